//! A machine on trial: its scripts are carried out to the last line on an engine that touches
//! nothing, for `check`, `order` and `graph`.

mod attempt;
mod unknown;

pub use unknown::Unknown;

use crate::{
    Bytes, Captured, Error, Outcome, Session, Style,
    halrun::{machine, plan::plugin_path},
    ini::Ini,
};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{At, Place};
use std::path::{Path, PathBuf};

/// A line that was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Where it stands.
    pub at: At,
    /// Why.
    pub error: Error,
}

/// Something odd that a line did without being refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// Where it stands.
    pub at: At,
    /// What is odd.
    pub text: String,
}

/// What came of lines that were carried out without touching anything outside.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Attempt {
    /// The lines that were refused, in order.
    pub refusals: Vec<Refusal>,
    /// What was odd.
    pub remarks: Vec<Remark>,
    /// What is not known of programs and of components that are missing.
    pub unknown: Unknown,
}

/// A machine on trial.
#[derive(Debug)]
pub struct Trial {
    engine: Engine,
    attempt: Attempt,
    ini: Option<Ini>,
}

impl Trial {
    /// Carries out `files`: scripts in order, with the values of an INI file if one is given, or
    /// one INI file as halrun would start it. Plugins are looked for where halrun looks.
    ///
    /// # Errors
    /// A file cannot be read, or an INI file has an error in it.
    pub fn of(files: &[String], ini: Option<&str>) -> Result<Self, Error> {
        Self::with_plugins(files, ini, plugin_path(&|name| std::env::var(name).ok()))
    }

    /// The same, with plugins from these folders.
    ///
    /// # Errors
    /// A file cannot be read, or an INI file has an error in it.
    pub fn with_plugins(
        files: &[String],
        ini: Option<&str>,
        path: Vec<PathBuf>,
    ) -> Result<Self, Error> {
        let is_ini = |f: &String| Path::new(f).extension().is_some_and(|e| e == "ini");
        let machine = files.iter().find(|f| is_ini(f)).map(String::as_str);
        if let (Some(_), [_, other, ..]) = (machine, files) {
            return Err(Error::TooManyFiles { files: other.as_str().into() });
        }
        let ini = machine.or(ini).map(|path| Ini::read(Path::new(path))).transpose()?;
        let mut scripts = Vec::new();
        for file in files.iter().filter(|f| !is_ini(f)) {
            let text = std::fs::read(file).map_err(|e| Error::NoCommandFile {
                path: file.as_str().into(),
                why: crate::ini::plain(&e),
            })?;
            scripts.push((file, text));
        }
        let mut engine = Engine::trial(Options {
            place: Place::at(std::env::temp_dir(), "trial").map_err(|why| Error::OptionValue {
                program: "halcmd",
                option: "--instance".into(),
                value: "trial".into(),
                why: why.into(),
            })?,
            clock: ClockKind::Virtual,
            hold: true,
            simulate: true,
            old_names: ini.as_ref().is_some_and(Ini::is_old),
            path,
        })?;
        let mut terminal = Captured::default();
        let style = Style { keep_going: true, ..Style::default() };
        let mut session = Session::new(&mut engine, &mut terminal, style, "trial");
        session.begin_trial();
        if let Some(ini) = &ini {
            session.set_ini(ini);
        }
        match (machine, &ini) {
            (Some(path), Some(ini)) => {
                if let Err(error) = machine::refuse(ini) {
                    session.stand_at(path, 0);
                    session.report(&error);
                }
                let _: Outcome = machine::start(&mut session, ini, Path::new(path));
            }
            _ => {
                for (file, text) in scripts {
                    let _: Outcome = session.file(file, Bytes::new(text));
                }
            }
        }
        let attempt = session.end_trial();
        Ok(Self { engine, attempt, ini })
    }

    /// The engine, with everything made that could be made.
    pub const fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    /// What came of the lines.
    #[must_use]
    pub const fn attempt(&self) -> &Attempt {
        &self.attempt
    }

    /// The INI file, if there is one.
    #[must_use]
    pub const fn ini(&self) -> Option<&Ini> {
        self.ini.as_ref()
    }
}
