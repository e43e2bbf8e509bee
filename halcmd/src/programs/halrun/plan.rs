//! Command line, environment and profile of halrun.

use super::{
    begin::{Begin, Job, ProgramLine},
    compat,
    folders::{LINUXCNC_MODULES, plugin_path},
    log::Selection,
    realtime,
    table::{HIDDEN, Id, OPTIONS},
    waiting::MaxWait,
};
use crate::{
    Error, Style,
    language::flight,
    nanoseconds,
    programs::common::{COMMON, Id as Common, apply},
    programs::options::{Opt, from_environment, mixed, plain, program_usage, usage},
    programs::profile::Profile,
};
use core::ops::RangeInclusive;
use hal_engine::{ClockKind, Options};
use hal_protocol::{FlightSpec, Place};
use std::path::{Path, PathBuf};

/// Action that the user asks for.
#[derive(Clone, Debug)]
pub(crate) enum Action {
    /// Print the options.
    Help,
    /// End the running instance.
    Stop(Place),
    /// Start an instance.
    Run(Box<Plan>),
}

/// Source of the script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Script {
    /// A `.hal` file.
    Hal(String),
    /// A `.tcl` file.
    Tcl(String),
    /// A machine's INI file.
    Ini(String),
    /// Standard input.
    Terminal,
    /// No script; clients do everything.
    Nothing,
}

/// Role of the process with respect to `--detach`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Detach {
    /// An ordinary process in the foreground.
    No,
    /// The process that starts the background process.
    Parent,
    /// The background process.
    Child,
}

/// Parameters for creating and running an instance.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) options: Options,
    pub(crate) style: Style,
    pub(super) level: Option<u8>,
    /// Messages that are shown.
    pub(super) selection: Selection,
    pub(crate) script: Script,
    pub(super) ini: Option<String>,
    pub(super) batch: bool,
    pub(super) interactive: bool,
    /// Commands after the script are in Tcl.
    pub(super) tcl: bool,
    pub(super) for_ns: Option<u64>,
    pub(super) record: Option<PathBuf>,
    /// Settings of the flight recorder, if it is to be switched on.
    pub(super) flight: Option<FlightSpec>,
    pub(super) detach: Detach,
    /// The program to run on the machine; the instance ends with it.
    pub(super) job: Option<Job>,
    /// Nothing of a user interface is started.
    pub(super) headless: bool,
    /// Names of `--stub`.
    pub(super) stubs: Vec<String>,
    /// Inputs of simulated ports are those of a machine at rest.
    pub(super) healthy: bool,
}

/// Range of `--pace`.
const PACES: RangeInclusive<f64> = 0.001..=1000.0;

/// Parses the command line, the environment and the profile.
pub(crate) fn plan(
    words: &[String],
    environment: &dyn Fn(&str) -> Option<String>,
) -> Result<Action, Error> {
    let mut table: Vec<Opt<Id>> = [OPTIONS, HIDDEN].concat();
    table.extend(COMMON.iter().map(common));
    let (mut given, files) = mixed("halrun", &table, words)?;
    from_environment(&table, environment, &mut given);
    let profile = given.iter().rev().find(|(id, _)| *id == Id::Profile);
    let profile = match profile.and_then(|(_, file)| file.as_deref()) {
        Some(file) => Profile::read(Path::new(file))?,
        None => Profile::default(),
    };
    let environment = |name: &str| profile.value(environment, name);
    from_environment(&table, &environment, &mut given);
    let has = |wanted| given.iter().any(|(id, _)| *id == wanted);
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    if has(Id::Help) {
        return Ok(Action::Help);
    }
    let bad = |option: &str, value: &str, why: &str| Error::OptionValue {
        program: "halrun",
        option: option.into(),
        value: value.into(),
        why: why.into(),
    };
    let name = value(Id::Instance);
    let place = Place::find(name.as_deref())
        .map_err(|why| bad("--instance", &name.clone().unwrap_or_default(), &why))?;
    if has(Id::Stop) {
        return Ok(Action::Stop(place));
    }
    let clock = match value(Id::Clock).as_deref() {
        _ if has(Id::Virtual) => ClockKind::Virtual,
        Some("virtual") => ClockKind::Virtual,
        None | Some("real") => ClockKind::Real,
        Some(other) => return Err(bad("--clock", other, "it is real or virtual")),
    };
    let for_ns =
        match value(Id::For) {
            Some(text) => Some(nanoseconds(&text).map_err(|_| {
                bad("--for", &text, "it is a number and ns, us, ms or s, such as 2s")
            })?),
            None => None,
        };
    let pace = value(Id::Pace)
        .map(|text| match text.parse().ok().filter(|n| PACES.contains(n)) {
            _ if clock == ClockKind::Real => Err(bad("--pace", &text, "it is for --virtual")),
            _ if has(Id::Hold) => {
                Err(bad("--pace", &text, "with --hold the clock moves only in 'run TIME'"))
            }
            Some(n) => Ok(n),
            None => Err(bad("--pace", &text, "it is a number from 0.001 to 1000, such as 1")),
        })
        .transpose()?;
    let mut style = Style::default();
    for (id, _) in &given {
        if let Id::Common(id) = id {
            apply(&mut style, *id);
        }
    }
    let level = if has(Id::Common(Common::VeryVerbose)) {
        Some(5)
    } else {
        has(Id::Common(Common::Silent)).then_some(0)
    };
    let detach = match (has(Id::Detached), has(Id::Detach)) {
        (true, _) => Detach::Child,
        (false, true) => Detach::Parent,
        (false, false) => Detach::No,
    };
    let script = script(&files, detach)?;
    let whole = |path: String| std::path::absolute(&path).unwrap_or_else(|_| path.into());
    let from = value(Id::From);
    let begin = match (value(Id::Job), from, has(Id::Resume)) {
        (None, None, false) => None,
        (None, None, true) => Some(Begin::Resume),
        (Some(file), _, true) => {
            return Err(bad("--run", &file, "--resume runs the program of the last job"));
        }
        (None, Some(text), _) => return Err(bad("--from", &text, "it belongs to --run FILE")),
        // The start of a machine changes the folder.
        (Some(file), None, false) => Some(Begin::First(whole(file).display().to_string())),
        (Some(file), Some(text), false) => {
            let why = "it is [FILE:]LINE[/PASS], such as 120 or 120/2";
            let place = ProgramLine::parse(&text).ok_or_else(|| bad("--from", &text, why))?;
            Some(Begin::From(whole(file).display().to_string(), place))
        }
    };
    if let Some(begin) = &begin {
        let (option, file) = match begin {
            Begin::First(file) | Begin::From(file, _) => ("--run", file.as_str()),
            Begin::Resume => ("--resume", ""),
        };
        if !matches!(script, Script::Ini(_)) {
            return Err(bad(option, file, "it needs a machine from an INI file"));
        }
        if detach != Detach::No || has(Id::Hold) {
            return Err(bad(option, file, "it excludes --detach and --hold"));
        }
    }
    let max_wait = match value(Id::MaxWait) {
        Some(text) => MaxWait::parse(&text)
            .ok_or_else(|| bad("--max-wait", &text, "it is never, or a time such as 60s"))?,
        None => MaxWait::default(),
    };
    let is_job = begin.is_some();
    let job = begin.map(|begin| Job { begin, yes: has(Id::Yes), max_wait });
    let times = (value(Id::StuckTime), value(Id::MaxGap));
    let realtime = realtime::options(value(Id::Cpu), value(Id::DmaLatency), times)?;
    let tcl = has(Id::Tcl);
    let interactive = tcl || has(Id::Interactive);
    if interactive && detach != Detach::No {
        return Err(bad(
            if tcl { "-T" } else { "-I" },
            "",
            "it excludes --detach: a process in the background has no prompt",
        ));
    }
    style.background = detach == Detach::Child;
    style.reads_input = interactive || script == Script::Terminal || detach == Detach::Child;
    Ok(Action::Run(Box::new(Plan {
        options: Options {
            place,
            clock,
            hold: has(Id::Hold),
            pace,
            simulate: has(Id::Simulate) || clock == ClockKind::Virtual,
            old_names: false,
            interlock: false,
            earlier_values: compat::option(value(Id::Compat))?,
            path: plugin_path(&|name| match name {
                LINUXCNC_MODULES if has(Id::Linuxcnc) => Some("1".to_owned()),
                "HAL_RTMOD_DIR" => value(Id::Modules),
                _ => environment(name),
            }),
            realtime,
        },
        style,
        level,
        selection: Selection::parse(&value(Id::Log).unwrap_or_default())?,
        script,
        ini: value(Id::Common(Common::Ini)),
        batch: has(Id::Common(Common::File)),
        interactive,
        tcl,
        for_ns,
        record: value(Id::Record).map(whole),
        flight: value(Id::Flight)
            .map(|words| {
                let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
                flight::spec(&words)
            })
            .transpose()?,
        detach,
        job,
        headless: has(Id::Headless),
        stubs: given
            .iter()
            .filter(|(id, _)| *id == Id::Stub)
            .filter_map(|(_, v)| v.clone())
            .collect(),
        healthy: has(Id::Healthy) || is_job,
    })))
}

/// Returns the options for completion.
pub(crate) fn table() -> Vec<Opt<()>> {
    [plain(OPTIONS), plain(&COMMON)].concat()
}

/// Returns the usage text.
pub(crate) fn help() -> String {
    format!(
        "\nUsage:   halrun [options] [FILE.hal|FILE.tcl|FILE.ini]\n         halrun [options] -f FILE\n         \
         halrun -U\n\n\
         Makes an instance, carries out the file, and stays up while a thread exists. Without a\n\
         file, commands are taken from standard input.\n\noptions:\n{}{}",
        usage(OPTIONS),
        program_usage(&COMMON)
    )
}

const fn common(option: &Opt<Common>) -> Opt<Id> {
    Opt {
        id: Id::Common(option.id),
        short: option.short,
        long: option.long,
        value: option.value,
        variable: option.variable,
        help: option.help,
    }
}

fn script(files: &[String], detach: Detach) -> Result<Script, Error> {
    let file = match files {
        [] if detach == Detach::No => return Ok(Script::Terminal),
        [] => return Ok(Script::Nothing),
        [file] => file,
        _ => return Err(Error::TooManyFiles { files: files.join(" ").into() }),
    };
    match Path::new(file).extension().and_then(|e| e.to_str()) {
        Some("hal") => Ok(Script::Hal(file.clone())),
        Some("ini") => Ok(Script::Ini(file.clone())),
        Some("tcl") => Ok(Script::Tcl(file.clone())),
        _ => Err(Error::Extension { file: file.as_str().into() }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(words: &str, variables: &[(&str, &str)]) -> String {
        let words: Vec<String> = words.split_whitespace().map(str::to_owned).collect();
        let environment = |name: &str| {
            variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned())
        };
        match plan(&words, &environment) {
            Err(error) => format!("! {}", error.whole()),
            Ok(Action::Help) => "help".to_owned(),
            Ok(Action::Stop(place)) => format!("stop {}", place.name()),
            Ok(Action::Run(p)) => {
                let o = &p.options;
                let mut text = format!("{:?} {} {:?}", p.script, o.place.name(), o.clock);
                for (on, word) in [
                    (p.batch, " batch"),
                    (p.interactive, " interactive"),
                    (p.tcl, " tcl"),
                    (o.hold, " hold"),
                    (o.simulate, " simulate"),
                    (p.style.keep_going, " keep"),
                    (p.detach == Detach::Parent, " detach"),
                ] {
                    text.push_str(if on { word } else { "" });
                }
                if let Some(ns) = p.for_ns {
                    text.push_str(&format!(" for {ns}"));
                }
                if let Some(ini) = &p.ini {
                    text.push_str(&format!(" ini {ini}"));
                }
                if let Some(file) = p.record.as_ref().and_then(|f| f.file_name()) {
                    text.push_str(&format!(" record {}", file.to_string_lossy()));
                }
                text
            }
        }
    }

    #[test]
    fn options_come_before_the_environment_and_that_before_the_profile() {
        let file = std::env::temp_dir().join(format!("hal-plan-{}.toml", std::process::id()));
        let text = "clock = \"virtual\"\nfor = \"2s\"\ninstance = \"a\"\nsimulate = true\n";
        std::fs::write(&file, text).unwrap();
        let file = file.display().to_string();
        let (hal, variable) = ("Hal(\"m.hal\")", ("HAL_PROFILE", file.as_str()));
        for (words, variables, want) in [
            (format!("--profile {file} m.hal"), vec![], "a Virtual simulate for 2000000000"),
            ("m.hal".into(), vec![variable], "a Virtual simulate for 2000000000"),
            (
                "m.hal".into(),
                vec![variable, ("HAL_FOR", "3s")],
                "a Virtual simulate for 3000000000",
            ),
            (
                "m.hal --for 4s --clock real --instance b".into(),
                vec![variable, ("HAL_FOR", "3s"), ("HAL_SIMULATE", "0")],
                "b Real for 4000000000",
            ),
        ] {
            assert_eq!(shown(&words, &variables), format!("{hal} {want}"), "{words}");
        }
        let refused = shown("--profile /none.toml m.hal", &[]);
        assert_eq!(refused, "! /none.toml: No such file or directory");
    }

    #[test]
    fn the_command_line() {
        for (words, want) in [
            ("m.hal", "Hal(\"m.hal\") default Real"),
            ("-f m.hal", "Hal(\"m.hal\") default Real batch"),
            ("-f m.hal -i m.ini", "Hal(\"m.hal\") default Real batch ini m.ini"),
            ("-ki m.ini m.hal", "Hal(\"m.hal\") default Real keep ini m.ini"),
            ("m.ini", "Ini(\"m.ini\") default Real"),
            ("", "Terminal default Real"),
            ("-I m.hal", "Hal(\"m.hal\") default Real interactive"),
            ("-T m.hal", "Hal(\"m.hal\") default Real interactive tcl"),
            ("-T", "Terminal default Real interactive tcl"),
            ("-U", "stop default"),
            ("-U --instance a", "stop a"),
            ("-h", "help"),
            (
                "--virtual --for 2s --record out.vcd m.hal",
                "Hal(\"m.hal\") default Virtual simulate for 2000000000 record out.vcd",
            ),
            ("--virtual --hold m.hal", "Hal(\"m.hal\") default Virtual hold simulate"),
            ("--simulate m.ini", "Ini(\"m.ini\") default Real simulate"),
            ("--detach", "Nothing default Real detach"),
            ("--instance b m.hal", "Hal(\"m.hal\") b Real"),
            ("foo.txt", "! halrun: Unknown file extension for filename=<foo.txt>"),
            ("a.hal b.hal", "! halrun: too many arguments <a.hal b.hal>"),
            ("-f a.tcl -i m.ini", "Tcl(\"a.tcl\") default Real batch ini m.ini"),
            (
                "--detach -I m.hal",
                "! halrun: -I '': it excludes --detach: a process in the background has no prompt",
            ),
            ("-z", "! halrun: invalid option -- 'z'"),
            (
                "--for 2 a.hal",
                "! halrun: --for '2': it is a number and ns, us, ms or s, such as 2s",
            ),
            (
                "--instance a/b a.hal",
                "! halrun: --instance 'a/b': instance name 'a/b' is not usable: letters, digits, \
                 '-' and '_', at most 32",
            ),
        ] {
            assert_eq!(shown(words, &[]), want, "{words}");
        }
    }

    #[test]
    fn the_environment() {
        let variables = [
            ("HAL_CLOCK", "virtual"),
            ("HAL_FOR", "5ms"),
            ("HAL_HOLD", "1"),
            ("HAL_INSTANCE", "z"),
            ("HAL_RECORD", "r.vcd"),
        ];
        let want = "Hal(\"m.hal\") z Virtual hold simulate for 5000000 record r.vcd";
        assert_eq!(shown("m.hal", &variables), want);
        let want = "Hal(\"m.hal\") y Virtual simulate for 1000000";
        assert_eq!(shown("--for 1ms --instance y m.hal", &[variables[0], variables[3]]), want);
        let want = "! halrun: --clock 'sun': it is real or virtual";
        assert_eq!(shown("m.hal", &[("HAL_CLOCK", "sun")]), want);
        assert_eq!(shown("m.hal", &[("HAL_SIMULATE", "0")]), "Hal(\"m.hal\") default Real");
    }
}
