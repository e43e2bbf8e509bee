//! Calls of functions in progress, and their steps.

use crate::{
    process::{Process, Sent},
    setup::Setup,
};
use hal_gcode::{
    Environment, State,
    function::{Next, Reply, Turn},
    view::View,
};
use serde::Deserialize;
use std::{collections::BTreeSet, time::Duration};

/// Longest wait for the begin of the process, in which the user's modules are imported.
const BEGIN: Duration = Duration::from_secs(30);
/// Time that a part of a line counts as, so that parts alone have an end.
const PART: Duration = Duration::from_millis(1);
/// Error of a call whose process has ended.
const NO_LONGER: &str = "the function is no longer in progress";

/// The first line of the process.
#[derive(Deserialize)]
struct Ready {
    words: BTreeSet<Box<str>>,
    error: Option<String>,
}

/// Progress of a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// The function is at work.
    Pending,
    /// The step is done.
    Step(Reply),
    /// The function has failed, or cannot run; the reason.
    Failed(String),
}

/// The functions of a machine.
#[derive(Debug)]
pub struct Functions {
    setup: Setup,
    process: Option<Process>,
    /// The process has said that it is ready.
    is_ready: bool,
    /// Numbers of the calls in progress, the outermost first.
    open: Vec<u64>,
    words: BTreeSet<Box<str>>,
    /// Time in which the process said nothing.
    silent: Duration,
    /// Reason why the user's modules cannot be used.
    broken: Option<String>,
}

impl Functions {
    /// Starts the process and imports the user's modules. Their errors are reported here, and again at each call.
    pub fn start(setup: Setup) -> (Self, Result<(), String>) {
        let mut out = Self {
            setup,
            process: None,
            is_ready: false,
            open: Vec::new(),
            words: BTreeSet::new(),
            silent: Duration::ZERO,
            broken: None,
        };
        let result = out.wait_until_ready();
        if let Err(why) = &result {
            out.broken = Some(why.clone());
            out.end();
        }
        (out, result)
    }

    fn wait_until_ready(&mut self) -> Result<(), String> {
        self.process = Some(Process::start(&self.setup)?);
        loop {
            let Some(process) = &mut self.process else { return Ok(()) };
            match process.line(BEGIN - self.silent)? {
                Sent::Line(line) => return self.ready(&line),
                Sent::Part => self.silent += PART,
                Sent::Nothing => self.silent = BEGIN,
            }
            if self.silent >= BEGIN {
                return Err(self.late());
            }
        }
    }

    fn ready(&mut self, line: &[u8]) -> Result<(), String> {
        let ready: Ready = serde_json::from_slice(line).map_err(|e| format!("answer: {e}"))?;
        if let Some(error) = ready.error {
            let toplevel = self.setup.toplevel.as_ref().map(|path| path.display());
            return Err(toplevel.map_or(error.clone(), |path| format!("{path}: {error}")));
        }
        self.words = ready.words;
        self.is_ready = true;
        self.silent = Duration::ZERO;
        Ok(())
    }

    /// Returns the names of the functions that O-words call.
    pub fn words(&self) -> &BTreeSet<Box<str>> {
        &self.words
    }

    /// Returns whether the process has imported the user's modules.
    pub fn is_ready(&self) -> bool {
        self.is_ready
    }

    /// Returns the longest time for what the process does now: a step, or the import of the user's modules.
    pub fn timeout(&self) -> Duration {
        if self.is_ready { self.setup.timeout } else { BEGIN }
    }

    /// Begins the next step of the function that is the innermost level of a state.
    ///
    /// # Errors
    /// There is no such function, or no process for it.
    pub fn begin(&mut self, state: &State, env: &dyn Environment) -> Result<(), String> {
        if let Some(why) = &self.broken {
            return Err(why.clone());
        }
        let Some(function) = state.function() else { return Err("no function is called".into()) };
        let around = state.levels.iter().filter(|l| l.function().is_some()).count();
        if function.turn == Turn::Begin {
            // Calls that a program has left behind ended with it.
            if self.open.len() + 1 != around {
                self.end();
            }
            if around > 1 && self.open.is_empty() {
                return Err("the function around it is no longer in progress".to_owned());
            }
            self.open.push(function.serial);
        } else if let Some(at) = self.open.iter().position(|n| *n == function.serial) {
            // A call inside of this one has failed: the process leaves it when it gets a turn of this one.
            self.open.truncate(at + 1);
        } else {
            return Err(match &function.turn {
                Turn::Executed(Some(failure)) => format!("{NO_LONGER}: {}", failure.message),
                _ => NO_LONGER.to_owned(),
            });
        }
        let view = View::of(state, env).ok_or("no function is called")?;
        let line = serde_json::to_string(&view).map_err(|e| e.to_string())?;
        if self.process.is_none() {
            self.process = Some(Process::start(&self.setup)?);
            self.is_ready = false;
        }
        self.silent = Duration::ZERO;
        let sent = self.process.as_mut().map_or(Ok(()), |process| process.send(&line));
        sent.inspect_err(|_| self.end())
    }

    /// Waits this long for the end of the step.
    pub fn progress(&mut self, wait: Duration) -> Progress {
        let Some(process) = &mut self.process else {
            return Progress::Failed(NO_LONGER.to_owned());
        };
        let result = match process.line(wait) {
            Ok(sent @ (Sent::Nothing | Sent::Part)) => {
                self.silent += if matches!(sent, Sent::Nothing) { wait } else { PART };
                if self.silent < self.timeout() {
                    return Progress::Pending;
                }
                Err(self.late())
            }
            Ok(Sent::Line(line)) if !self.is_ready => match self.ready(&line) {
                Ok(()) => return Progress::Pending,
                Err(why) => Err(why),
            },
            Ok(Sent::Line(line)) => {
                serde_json::from_slice::<Reply>(&line).map_err(|e| format!("answer: {e}"))
            }
            Err(why) => Err(why),
        };
        match result {
            Ok(reply) => {
                if matches!(reply.next, Next::Done(_) | Next::Fail(_)) {
                    self.open.pop();
                }
                Progress::Step(reply)
            }
            Err(why) => {
                self.end();
                Progress::Failed(why)
            }
        }
    }

    /// Ends a function that takes too long, and returns the reason.
    pub fn give_up(&mut self) -> String {
        let why = self.late();
        self.end();
        why
    }

    fn late(&self) -> String {
        if !self.is_ready {
            return format!("the modules were not imported within {} s", BEGIN.as_secs());
        }
        let seconds = self.setup.timeout.as_secs_f64();
        format!("it made no step within {seconds} s ([PYTHON]TIMEOUT) and was ended")
    }

    /// Makes the next step, and waits for its end.
    pub fn step(&mut self, state: &State, env: &dyn Environment) -> Result<Reply, String> {
        self.begin(state, env)?;
        loop {
            match self.progress(Duration::from_millis(100)) {
                Progress::Pending => {}
                Progress::Step(reply) => return Ok(reply),
                Progress::Failed(why) => return Err(why),
            }
        }
    }

    /// Returns whether a call is in progress.
    pub fn is_busy(&self) -> bool {
        !self.open.is_empty()
    }

    /// Ends the process with all calls in progress. The next call begins another one.
    pub fn end(&mut self) {
        self.open.clear();
        if let Some(mut process) = self.process.take() {
            process.end();
        }
    }
}
