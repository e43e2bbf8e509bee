//! The engine while a script runs, and afterwards.

use super::plan::{Plan, Script};
use crate::{session::INTERRUPTED, session::prompt::Aside};
use hal_engine::{Ended, Engine};
use hal_protocol::{Failure, Link, Reply, Request};
use tracing::level_filters::LevelFilter;

/// Shows on standard error what components and the engine have to say, as they say it. Which
/// messages of components those are is the engine's matter (`debug LEVEL`).
pub(super) fn listen() {
    let plain = tracing_subscriber::fmt()
        .with_writer(Aside::default)
        .with_max_level(LevelFilter::DEBUG)
        .with_ansi(false)
        .with_level(false)
        .with_target(false)
        .without_time()
        // Standard error that cannot be written to would be told there, and end the machine.
        .log_internal_errors(false);
    // Another one may have been installed by whoever uses this as a library.
    drop(plain.try_init());
}

/// An engine in this process: once it is ending it carries out nothing more.
pub(super) struct Local<'a> {
    engine: &'a mut Engine,
}

impl<'a> Local<'a> {
    pub(super) const fn new(engine: &'a mut Engine) -> Self {
        Self { engine }
    }
}

impl Link for Local<'_> {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        if self.engine.is_ending() {
            return Err(Failure::new(INTERRUPTED, "the instance is ending"));
        }
        let reply = self.engine.call(request);
        // They were shown when they were logged.
        drop(self.engine.take_messages());
        reply
    }

    fn at(&mut self, file: &str, line: u32) {
        self.engine.at(file, line);
    }

    fn is_local(&self) -> bool {
        true
    }

    fn is_ending(&self) -> bool {
        self.engine.is_ending()
    }
}

/// Whether a script ended because of a signal, not because a line or a client asked for it.
pub(super) fn was_broken_off(engine: &mut Engine) -> bool {
    engine.serve(Some(0)) == Ended::Signal
}

/// What went wrong in an instance: the function for which its threads have stopped, or that does not
/// come back, and the recording that could not be written.
pub(super) fn wrong(link: &mut impl Link, name: &str) -> Vec<String> {
    let Ok(Reply::Status(status)) = link.call(Request::Status) else { return Vec::new() };
    let fault = status.fault.or(status.stuck).map(|f| {
        let (component, funct, thread, cause) = (f.component, f.funct, f.thread, f.cause);
        format!(
            "instance '{name}' had a fault: function '{funct}' of component '{component}' in thread \
             '{thread}': {cause}"
        )
    });
    let stopped = status.recording_stopped.map(|s| format!("instance '{name}': {s}"));
    fault.into_iter().chain(stopped).collect()
}

/// Serves clients until the instance's time is over.
pub(super) fn stay(plan: &Plan, engine: &mut Engine) {
    if plan.script == Script::Nothing && plan.for_ns.is_none() {
        // There need not be a thread yet.
        let wait = Request::Idle { ms: 100, flow: !plan.options.hold };
        while !engine.is_ending() && engine.call(wait.clone()).is_ok() {}
    } else if !plan.batch || plan.for_ns.is_some() {
        engine.serve(plan.for_ns);
    }
}
