//! An engine of a program's own, which no client reaches: for tests of a computer or of a single axis.

use super::{halrun::folders::plugin_path, profile::Profile};
use crate::{Captured, Outcome, Session, Style};
use hal_engine::{ClockKind, Ended, Engine, Options, RealtimeOptions};
use hal_protocol::{Link as _, Place, Reply, Request, StatusInfo};

/// The engine.
pub(super) struct Alone {
    engine: Engine,
    clock: ClockKind,
}

impl Alone {
    /// Makes an engine. Hardware is simulated on the virtual clock alone.
    pub(super) fn new(clock: ClockKind, cpu: Option<usize>) -> Result<Self, String> {
        let profile = Profile::of_environment().map_err(|e| e.to_string())?;
        // No files are made in its folder.
        let place = Place::at("/nonexistent", "alone")?;
        let realtime = RealtimeOptions { cpu, ..RealtimeOptions::default() };
        let options = Options {
            path: plugin_path(&|name| profile.system(name)),
            realtime,
            simulate: clock == ClockKind::Virtual,
            ..Options::simulated(place, clock)
        };
        let engine = Engine::without_socket(options).map_err(|f| f.to_string())?;
        Ok(Self { engine, clock })
    }

    /// Executes the lines of a script.
    pub(super) fn script(&mut self, name: &str, text: &str) -> Result<(), String> {
        let mut terminal = Captured::default();
        let mut session = Session::new(&mut self.engine, &mut terminal, Style::default(), "alone");
        for (number, line) in (1..).zip(text.lines()) {
            if session.line_at(name, number, line) != Outcome::Good {
                return Err(terminal.err.trim_end().to_owned());
            }
        }
        Ok(())
    }

    /// Lets machine time pass. On the real clock this waits.
    pub(super) fn pass(&mut self, ns: u64) -> Result<(), String> {
        if self.clock == ClockKind::Virtual {
            return self.engine.call(Request::Run { ns }).map(drop).map_err(|f| f.to_string());
        }
        match self.engine.serve(Some(ns)) {
            // Who has asked for the end looks at signals too.
            Ended::Time | Ended::Signal => Ok(()),
            Ended::NoThreads | Ended::Shutdown => Err("the threads have ended".to_owned()),
        }
    }

    /// Returns the value of a pin or parameter as a number.
    pub(super) fn number(&mut self, name: &str) -> Result<f64, String> {
        match self.engine.call(Request::Get { name: name.to_owned() }) {
            Ok(Reply::Value(value)) => Ok(value.number()),
            Ok(_) => Err(format!("{name} has no value")),
            Err(failure) => Err(failure.to_string()),
        }
    }

    /// Sets a pin or parameter.
    pub(super) fn set(&mut self, name: &str, value: &str) -> Result<(), String> {
        let request = Request::Set { name: name.to_owned(), value: value.to_owned() };
        self.engine.call(request).map(drop).map_err(|f| f.to_string())
    }

    /// Returns the state of the instance.
    pub(super) fn status(&mut self) -> Result<StatusInfo, String> {
        match self.engine.call(Request::Status) {
            Ok(Reply::Status(status)) => Ok(*status),
            Ok(_) => Err("the engine tells no status".to_owned()),
            Err(failure) => Err(failure.to_string()),
        }
    }
}
