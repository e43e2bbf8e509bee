//! Data of motion from an INI file: the arguments of `motion.configure`.

use crate::ini::{Entry, Ini};
use hal_protocol::CommandInfo;
use std::{collections::BTreeSet, path::Path};

/// INI entries of coordinated moves, and the corresponding arguments. The first entry that exists
/// counts.
const PATH: &[(&str, &str, &str)] = &[
    ("TRAJ", "MAX_LINEAR_VELOCITY", "max-velocity"),
    ("TRAJ", "MAX_VELOCITY", "max-velocity"),
    ("TRAJ", "MAX_LINEAR_ACCELERATION", "max-acceleration"),
    ("TRAJ", "MAX_ACCELERATION", "max-acceleration"),
    ("TRAJ", "MAX_LINEAR_JERK", "max-jerk"),
    ("TRAJ", "DEFAULT_LINEAR_VELOCITY", "default-velocity"),
    ("TRAJ", "DEFAULT_VELOCITY", "default-velocity"),
    ("TRAJ", "LINEAR_UNITS", "linear-units"),
    ("DISPLAY", "MAX_FEED_OVERRIDE", "max-feed-override"),
];

/// Returns the argument of `motion.configure` that an entry becomes.
pub(crate) fn argument(entry: &Entry) -> String {
    let row = PATH.iter().find(|row| row.0 == entry.section && row.1 == entry.name);
    row.map_or_else(|| entry.name.to_ascii_lowercase().replace('_', "-"), |row| row.2.to_owned())
}

/// Returns the arguments of each `motion.configure`, with the first INI entry of each: one call for
/// coordinated moves, one for each joint, and one for each axis and spindle that has limits of its
/// own. Arguments that the command does not have are left out. Names of files are relative to `here`.
pub(super) fn data<'a>(
    ini: &'a Ini,
    command: &CommandInfo,
    here: &Path,
) -> Vec<(&'a Entry, Vec<String>)> {
    let mut path = Args::new(command, None, here);
    for (section, name, arg) in PATH {
        if let Some(entry) = ini.all(section, name).next() {
            path.add(arg, entry);
        }
    }
    let of = |section: &str, first: String, only: &[&str]| {
        let mut args = Args::new(command, Some(first), here);
        for entry in ini.section(section) {
            let arg = entry.name.to_ascii_lowercase().replace('_', "-");
            // The section identifies the joint or axis. Of an axis, only its limits count.
            let is_object = ["joint", "axis", "spindle"].contains(&&*arg);
            if !is_object && (only.is_empty() || only.contains(&&*arg)) {
                args.add(&arg, entry);
            }
        }
        args.done()
    };
    let mut all = vec![path.done()];
    let joints = if ini.is_old() { "AXIS" } else { "JOINT" };
    for n in 0..joint_count(ini) {
        all.push(of(&format!("{joints}_{n}"), format!("joint={n}"), &[]));
    }
    for letter in "XYZABCUVW".chars() {
        let first = format!("axis={}", letter.to_ascii_lowercase());
        all.push(of(&format!("AXIS_{letter}"), first, AXIS));
    }
    for n in 0..number(ini, &[("TRAJ", "SPINDLES")]).unwrap_or(1).min(8) {
        all.push(of(&format!("SPINDLE_{n}"), format!("spindle={n}"), SPINDLE));
    }
    all.into_iter().flatten().collect()
}

/// Arguments that are read from a spindle's section.
const SPINDLE: &[&str] = &[
    "min-forward-velocity",
    "max-forward-velocity",
    "min-reverse-velocity",
    "max-reverse-velocity",
    "sync-error",
];

/// Arguments that are read from an axis's section.
const AXIS: &[&str] =
    &["min-limit", "max-limit", "max-velocity", "max-acceleration", "max-jerk", "offset-av-ratio"];

/// Returns the number of joint sections to read: the machine's number of joints, or 100 if it is
/// not given.
fn joint_count(ini: &Ini) -> u32 {
    let entries = [("KINS", "JOINTS"), ("TRAJ", "JOINTS"), ("TRAJ", "AXES")];
    number(ini, &entries).unwrap_or(100).min(100)
}

/// Returns the number in the first of these entries that has one.
fn number(ini: &Ini, entries: &[(&str, &str)]) -> Option<u32> {
    let mut given = entries.iter().filter_map(|(section, name)| ini.get(section, name));
    given.find_map(|value| value.split_whitespace().next()?.parse().ok())
}

/// Arguments of one command, collected from INI entries.
struct Args<'a, 'c> {
    command: &'c CommandInfo,
    /// Folder of the INI file.
    here: &'c Path,
    place: Option<&'a Entry>,
    words: Vec<String>,
}

impl<'a, 'c> Args<'a, 'c> {
    fn new(command: &'c CommandInfo, first: Option<String>, here: &'c Path) -> Self {
        Self { command, here, place: None, words: first.into_iter().collect() }
    }

    /// Adds the entry's value, if the command has this argument and it is not yet set.
    fn add(&mut self, arg: &str, entry: &'a Entry) {
        let given = self.words.iter().any(|w| w.split('=').next() == Some(arg));
        let known = self.command.args.iter().any(|a| a.name == arg);
        let value = entry.value.split_whitespace().next();
        if let Some(value) = value.filter(|_| known && !given) {
            let file = (arg == "comp-file").then(|| hal_ini::beside(self.here, value));
            self.words.push(match file {
                Some(file) => format!("{arg}={}", file.display()),
                None => format!("{arg}={value}"),
            });
        }
        self.place.get_or_insert(entry);
    }

    /// Returns the arguments, or `None` without any entry.
    fn done(self) -> Option<(&'a Entry, Vec<String>)> {
        let place = self.place?;
        (!self.words.is_empty()).then_some((place, self.words))
    }
}

/// Lets a joint that no switch homes be homed where it stands. Returns the joint if its arguments ask for a search.
pub(super) fn without_search(args: &mut [String], homed: &BTreeSet<u32>) -> Option<u32> {
    let joint = args.first()?.strip_prefix("joint=")?.parse().ok()?;
    let is_zero = |text: &str| text.parse::<f64>().is_ok_and(|value| value == 0.0);
    let searches = args.iter().any(|arg| match arg.split_once('=') {
        Some(("home-search-vel" | "home-latch-vel", value)) => !is_zero(value),
        _ => false,
    });
    if !searches || !homed.contains(&joint) {
        return None;
    }
    for arg in args.iter_mut() {
        let name = arg.split('=').next().unwrap_or_default();
        match name {
            "home-search-vel" | "home-latch-vel" => *arg = format!("{name}=0"),
            "home-use-index" => *arg = format!("{name}=NO"),
            _ => {}
        }
    }
    Some(joint)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_protocol::ArgInfo;

    fn command() -> CommandInfo {
        let arg = |name: &str| ArgInfo {
            name: name.to_owned(),
            ty: "float".to_owned(),
            doc: String::new(),
            required: false,
            default: None,
            bounds: hal_protocol::Bounds::default(),
            unit: String::new(),
        };
        let names = "joint axis min-limit max-limit max-velocity ferror home-offset \
                     default-velocity linear-units comp-file spindle max-forward-velocity \
                     min-reverse-velocity fault-stop";
        let (name, doc) = ("motion.configure".to_owned(), String::new());
        CommandInfo { name, doc, args: names.split_whitespace().map(arg).collect() }
    }

    fn check(text: &str, want: &[&str]) {
        let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
        let got: Vec<String> = data(&ini, &command(), Path::new("/m"))
            .iter()
            .map(|(entry, args)| format!("{} {}", entry.line, args.join(" ")))
            .collect();
        assert_eq!(got, want, "{text}");
    }

    #[test]
    fn data_of_both_kinds_of_ini_files() {
        check(
            "[TRAJ]\nLINEAR_UNITS = mm\nDEFAULT_VELOCITY = 9.00\nMAX_LINEAR_VELOCITY = 90.00\n\
             [AXIS_0]\nTYPE = LINEAR\nMIN_LIMIT = -50.0\nMAX_LIMIT = 200.0 # mm\nSCALE = 4\n\
             [AXIS_1]\nHOME_OFFSET = 0.0\n",
            &[
                "4 max-velocity=90.00 default-velocity=9.00 linear-units=mm",
                "6 joint=0 min-limit=-50.0 max-limit=200.0",
                "11 joint=1 home-offset=0.0",
            ],
        );
        check(
            "[AXIS_X]\nMAX_VELOCITY = 5\nMAX_LIMIT=7\n[JOINT_0]\nFERROR = 1\nFERROR = 2\nFAULT_STOP = ramp\n",
            &["5 joint=0 ferror=1 fault-stop=ramp", "2 axis=x max-velocity=5 max-limit=7"],
        );
        check(
            "[SPINDLE_0]\nMAX_FORWARD_VELOCITY = 2400\nINCREMENT = 50\n[SPINDLE_1]\n\
             MIN_REVERSE_VELOCITY = 10\n[JOINT_0]\nCOMP_FILE = x.comp\n[JOINT_1]\nCOMP_FILE = /y\n[TRAJ]\nSPINDLES = 2\n\
             [SPINDLE_2]\nMAX_FORWARD_VELOCITY = 7\n",
            &[
                "7 joint=0 comp-file=/m/x.comp",
                "9 joint=1 comp-file=/y",
                "2 spindle=0 max-forward-velocity=2400",
                "5 spindle=1 min-reverse-velocity=10",
            ],
        );
        check("[TRAJ]\nMAX_LINEAR_VELOCITY=1\nMAX_VELOCITY=2\n", &["2 max-velocity=1"]);
        check("", &[]);
    }
}
