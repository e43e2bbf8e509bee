//! Parts of a machine: the modules and programs that its files load, and whether each is there.

use crate::{
    Command, Error, io::built_in, language::syntax::Statement, session::dry_run::DryRun, standin,
};
use hal_protocol::{At, Kind, Link, Reply, Request};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

/// Origin of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Origin {
    /// A plugin of Ferrule.
    Native,
    /// A component in C.
    InC,
    /// A program.
    Program,
    /// A screen, or a program that belongs to it.
    Screen,
    /// A module or program that drives hardware.
    Hardware,
    /// A module or program that is not there.
    Missing,
}

impl Origin {
    const fn name(self) -> &'static str {
        match self {
            Self::Native => "native",
            Self::InC => "in C",
            Self::Program => "program",
            Self::Screen => "screen",
            Self::Hardware => "hardware",
            Self::Missing => "missing",
        }
    }
}

/// Returns the parts of a machine as lines: origin, name, place, and what to know of it.
///
/// # Errors
/// A file cannot be read.
pub(super) fn text(
    files: &[String],
    ini: Option<&str>,
    plugins: Vec<PathBuf>,
) -> Result<String, Error> {
    let mut dry_run = DryRun::with_plugins(files, ini, plugins)?;
    let foreign = foreign(dry_run.engine());
    let result = dry_run.result();
    let mut parts: BTreeMap<(Origin, String), At> = BTreeMap::new();
    for (at, words) in &result.statements {
        let Some((name, is_module)) = loaded(words) else { continue };
        let name = name.as_str();
        let is_absent = result.absent.contains(name);
        let of_screen = result.of_screen.contains(name) || standin::is_screen(name);
        let origin = match (is_module, is_absent) {
            _ if of_screen => Origin::Screen,
            (false, _) | (true, true)
                if standin::drives_hardware(name) || result.hardware.contains(name) =>
            {
                Origin::Hardware
            }
            (_, true) => Origin::Missing,
            (true, false) if foreign.contains_key(name) => Origin::InC,
            (true, false) => Origin::Native,
            (false, false) => Origin::Program,
        };
        parts.entry((origin, name.to_owned())).or_insert_with(|| at.clone());
    }
    let screens = dry_run.ini().into_iter().flat_map(|ini| ini.all("DISPLAY", "DISPLAY"));
    for entry in screens {
        let name = entry.value.split_whitespace().next().unwrap_or_default();
        let at = At::new(&entry.file, entry.line);
        parts.entry((Origin::Screen, name.to_owned())).or_insert(at);
    }
    let wide = parts.keys().map(|(_, name)| name.len()).max().unwrap_or_default();
    let place = |at: &At| format!("{}:{}", at.file, at.line);
    let far = parts.values().map(|at| place(at).len()).max().unwrap_or_default();
    let mut out = String::new();
    for ((origin, name), at) in &parts {
        let about = match origin {
            Origin::InC => foreign.get(name).cloned().unwrap_or_default(),
            Origin::Hardware => format!("pins in its place: --stub {name}"),
            Origin::Missing => format!("install it, or pins in its place: --stub {name}"),
            Origin::Native | Origin::Program | Origin::Screen => String::new(),
        };
        let line = format!("{:8}  {name:wide$}  {:far$}  {about}", origin.name(), place(at));
        out.push_str(line.trim_end());
        out.push('\n');
    }
    Ok(out)
}

/// Returns the name of the module or program that a line loads or starts, and whether it is a module.
fn loaded(words: &[String]) -> Option<(String, bool)> {
    match Statement::of_words(words).0.command().ok()? {
        Command::Launch(launch) => Some(match built_in(&launch) {
            Some(name) => (name.to_owned(), true),
            None => (launch.name().to_owned(), false),
        }),
        Command::Send(Request::Load { module, .. } | Request::LoadForeign { module, .. }, _) => {
            Some((module, true))
        }
        _ => None,
    }
}

/// Returns the components in C with their files.
fn foreign(link: &mut dyn Link) -> BTreeMap<String, String> {
    let all = Request::List { kind: Kind::Components, patterns: Vec::new(), ty: None };
    let Ok(Reply::Components(list)) = link.call(all) else { return BTreeMap::new() };
    let mut seen = BTreeSet::new();
    let foreign = list.into_iter().filter_map(|c| c.foreign);
    foreign.filter(|f| seen.insert(f.module.clone())).map(|f| (f.module, f.file)).collect()
}

#[cfg(test)]
mod tests {
    use super::loaded;

    #[test]
    fn options_are_no_names() {
        for (line, want) in [
            ("loadrt and2 count=2", Some(("and2", true))),
            ("loadrt --c --prefix p mine", Some(("mine", true))),
            ("loadusr -W hy_vfd -n vfd", Some(("hy_vfd", true))),
            ("loadusr -W mb2hal config=x", Some(("modbus", true))),
            ("loadusr -Wn vfd /usr/bin/gs2_vfd", Some(("gs2_vfd", false))),
            ("loadusr -Wn mpg python -u /x/mpg.py --port=/dev/ttyUSB0", Some(("mpg.py", false))),
            ("loadusr -W hal_input -KRAL Gamepad", Some(("hal_input", true))),
            ("loadusr -W /usr/bin/io", Some(("iocontrol", true))),
            ("loadusr -W iov2 -ini x", Some(("iocontrol", true))),
            ("loadusr -W halui", Some(("halui", true))),
            ("loadusr milltask", Some(("milltask", true))),
            ("loadusr sudo linuxcncsvr", Some(("linuxcncsvr", true))),
            ("loadusr", None),
            ("net a b", None),
        ] {
            let words: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
            let found = loaded(&words);
            let found = found.as_ref().map(|(name, is_module)| (name.as_str(), *is_module));
            assert_eq!(found, want, "{line}");
        }
    }
}
