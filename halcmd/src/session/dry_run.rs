//! A machine in a dry run. For `check`, `order` and `graph`, its scripts run to the last line on an
//! engine that affects nothing outside.

mod lines;
mod unknown;

use unknown::Maker;
pub use unknown::{MOTION, Unknown};

use crate::{
    Bytes, Captured, Error, Outcome, Session, Style,
    ini::{Doubt, Ini},
    programs::halrun::{compat, folders::plugin_path, machine, refused},
    programs::profile::Profile,
    standin::{Asked, Facts, StandIns, Wires},
};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{At, Code, Finding, ItemInfo, Kind, Link, Place, Reply, Request};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

/// A refused line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Place of the line.
    pub at: At,
    /// Error of the line.
    pub error: Error,
}

/// A warning about a line that was not refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Place of the line.
    pub at: At,
    /// Code under which `explain` describes the warning.
    pub code: Code,
    /// Text of the warning.
    pub text: String,
}

/// Result of lines that ran without affecting anything outside.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DryRunResult {
    /// The refused lines, in order.
    pub refusals: Vec<Refusal>,
    /// Warnings.
    pub notices: Vec<Notice>,
    /// Further findings.
    pub found: Vec<Finding>,
    /// INI entries that lines read: section and name.
    pub entries: BTreeSet<(String, String)>,
    /// The same for each line that reads any.
    pub uses: Vec<(At, Vec<(String, String)>)>,
    /// Words of each line, with variables replaced.
    pub statements: Vec<(At, Vec<String>)>,
    /// Names that missing components or programs that were not started may provide.
    pub unknown: Unknown,
    /// Modules and programs that lines load or start.
    pub loaded: BTreeSet<String>,
    /// Programs that belong to a screen: files of `POSTGUI_HALFILE` start them.
    pub of_screen: BTreeSet<String>,
    /// Programs with an argument that names a device.
    pub hardware: BTreeSet<String>,
    /// Loaded modules and programs that are not there.
    pub absent: BTreeSet<String>,
}

/// A machine in a dry run.
#[derive(Debug)]
pub struct DryRun {
    engine: Engine,
    result: DryRunResult,
    ini: Option<Ini>,
    starts_itself: bool,
    is_machine: bool,
}

impl DryRun {
    /// Runs `files`: scripts in order, with the values of an INI file if one is given, or one INI
    /// file as halrun would start it. Scripts given with the INI file of a machine (it has a
    /// section EMCIO) count as its HAL files. Plugins are looked for in halrun's folders.
    ///
    /// # Errors
    /// A file cannot be read, or an INI file or a profile has an error in it.
    pub fn of(files: &[String], ini: Option<&str>) -> Result<Self, Error> {
        let profile = Profile::of_environment()?;
        Self::with_plugins(files, ini, plugin_path(&|name| profile.system(name)))
    }

    /// Like [`Self::of`], with plugins from these folders.
    ///
    /// # Errors
    /// A file cannot be read, or an INI file has an error in it.
    pub fn with_plugins(
        files: &[String],
        ini: Option<&str>,
        path: Vec<PathBuf>,
    ) -> Result<Self, Error> {
        Self::replacing(files, ini, path, None)
    }

    /// Like [`Self::with_plugins`], with stand-ins: those asked for, or else those that the INI file names.
    ///
    /// # Errors
    /// A file cannot be read, or an INI file has an error in it.
    pub(crate) fn replacing(
        files: &[String],
        ini: Option<&str>,
        path: Vec<PathBuf>,
        asked: Option<&Asked>,
    ) -> Result<Self, Error> {
        let is_ini = |f: &String| Path::new(f).extension().is_some_and(|e| e == "ini");
        let machine = files.iter().find(|f| is_ini(f)).map(String::as_str);
        if let (Some(_), [_, other, ..]) = (machine, files) {
            return Err(Error::TooManyFiles { files: other.as_str().into() });
        }
        let given = ini;
        let ini = machine.or(ini).map(|path| Ini::read(Path::new(path))).transpose()?;
        let mut scripts = Vec::new();
        for file in files.iter().filter(|f| !is_ini(f)) {
            let text = hal_ini::file::whole(Path::new(file)).map_err(|e| Error::NoCommandFile {
                path: file.as_str().into(),
                why: crate::ini::plain(&e),
            })?;
            scripts.push((file, text));
        }
        // Scripts that load `iocontrol` themselves are not HAL files of a machine.
        let loads = scripts.iter().any(|(_, text)| loads_iocontrol(text));
        let whole = match (given, &ini) {
            (Some(path), Some(ini)) if machine.is_none() && ini.has_section("EMCIO") && !loads => {
                Some((ini, Path::new(path)))
            }
            _ => None,
        };
        let place = Place::at(std::env::temp_dir(), "trial");
        let place = place.map_err(|why| Error::OptionValue {
            program: "halcmd",
            option: "--instance".into(),
            value: "trial".into(),
            why: why.into(),
        })?;
        let mut engine = Engine::dry_run(Options {
            old_names: ini.as_ref().is_some_and(Ini::is_old),
            interlock: machine.is_some() || whole.is_some(),
            earlier_values: std::env::var("HAL_COMPAT").is_ok_and(|v| v == "2.9")
                || ini.as_ref().is_some_and(|ini| compat::of_ini(ini) == Ok(true)),
            path,
            ..Options::simulated(place, ClockKind::Virtual)
        })?;
        let mut terminal = Captured::default();
        let style = Style { keep_going: true, ..Style::default() };
        let mut session = Session::new(&mut engine, &mut terminal, style, "trial");
        session.begin_dry_run();
        session.is_first_look = asked.is_some();
        session.asked = match (asked, &ini) {
            (Some(asked), _) => asked.clone(),
            (None, Some(ini)) => Asked::of_ini(ini, true, false),
            (None, None) => Asked::default(),
        };
        if let Some(ini) = &ini {
            session.set_ini(ini);
        }
        if let Some(ini) = &ini {
            session.expect_interface(ini);
        }
        match (machine, &ini) {
            (Some(path), Some(ini)) => {
                for warning in ini.warnings() {
                    session.stand_at(&warning.file, warning.line);
                    let code = match warning.doubt {
                        Doubt::Ignored => Code::IniIgnored,
                        Doubt::Repeated => Code::SectionRepeated,
                    };
                    session.warn_as(code, &warning.text);
                }
                if let Err(error) = refused::refuse(ini) {
                    session.stand_at(path, 0);
                    session.report(&error);
                }
                let _: Outcome = machine::start(&mut session, ini, Path::new(path), true);
            }
            _ => {
                if let Some((ini, path)) = whole {
                    machine::before_files(&mut session, ini, path);
                }
                for (file, text) in scripts {
                    let _: Outcome = match file.ends_with(".tcl") {
                        true => machine::tcl_script(&mut session, Path::new(file)),
                        false => session.file(file, Bytes::new(text)),
                    };
                }
                if let Some((ini, path)) = whole {
                    machine::after_files(&mut session, ini, path);
                }
            }
        }
        let result = session.end_dry_run();
        let is_machine = machine.is_some() || whole.is_some();
        let starts_itself = ini.as_ref().is_some_and(|ini| ini.has_section("EMCIO"));
        Ok(Self { engine, result, ini, starts_itself, is_machine })
    }

    /// Returns the engine with everything that the lines could make.
    pub const fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// Returns all items of a kind, such as pins.
    pub(crate) fn items(&mut self, kind: Kind) -> Vec<ItemInfo> {
        match self.engine.call(Request::List { kind, patterns: Vec::new(), ty: None }) {
            Ok(Reply::Items(items)) => items,
            _ => Vec::new(),
        }
    }

    /// Returns the stand-ins for what is missing and asked for.
    pub(crate) fn stand_ins(&mut self, asked: &Asked) -> StandIns {
        let wires = Wires::of(&mut self.engine);
        let DryRunResult { unknown, of_screen, hardware, loaded, absent, statements, .. } =
            &self.result;
        let makers = unknown.makers().map(|maker| {
            let name = maker.name();
            let is_screen = matches!(maker, Maker::Screen(_)) || of_screen.contains(name);
            (name, is_screen, hardware.contains(name))
        });
        let facts = Facts {
            makers: makers.collect(),
            used: unknown.users().collect(),
            loaded,
            absent,
            statements,
            maker: &|name| unknown.maker(name).map(Maker::name),
        };
        StandIns::of(&facts, &wires, asked)
    }

    /// Returns the result of the lines.
    #[must_use]
    pub const fn result(&self) -> &DryRunResult {
        &self.result
    }

    /// Returns whether the program that starts the machine also starts its threads, so that no line
    /// has to.
    #[must_use]
    pub const fn starts_itself(&self) -> bool {
        self.starts_itself
    }

    /// Returns whether the INI file is that of a machine, not only a source of values.
    #[must_use]
    pub const fn is_machine(&self) -> bool {
        self.is_machine
    }

    /// Returns the INI file, if there is one.
    #[must_use]
    pub const fn ini(&self) -> Option<&Ini> {
        self.ini.as_ref()
    }
}

/// Returns whether a script loads `iocontrol`, which a start from an INI file has always loaded.
fn loads_iocontrol(text: &[u8]) -> bool {
    String::from_utf8_lossy(text).lines().any(|line| {
        let mut words = line.split_whitespace();
        words.next() == Some("loadrt") && matches!(words.next(), Some("iocontrol" | "io" | "iov2"))
    })
}
