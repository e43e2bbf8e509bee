//! Operation of the engine while a script runs and afterwards.

use super::{
    plan::{Plan, Script},
    service::Notifier,
};
use crate::{Stdio, Terminal, session::INTERRUPTED};
use hal_engine::{ClockKind, Ended, Engine};
use hal_protocol::{Failure, Kind, Link, Reply, Request};
use std::io::IsTerminal;

/// Link to an engine in this process. Once the engine is ending, it executes no more requests.
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
        // The messages were printed when they were logged.
        drop(self.engine.take_messages());
        reply
    }

    fn at(&mut self, file: &str, line: u32) {
        self.engine.at(file, line);
    }

    fn set_starting(&mut self, is_starting: bool) {
        self.engine.set_starting(is_starting);
    }

    fn is_local(&self) -> bool {
        true
    }

    fn is_ending(&self) -> bool {
        self.engine.is_ending()
    }
}

/// Returns whether a script ended because of a signal, and not because a line or a client asked for
/// it.
pub(super) fn was_broken_off(engine: &mut Engine) -> bool {
    engine.serve(Some(0)) == Ended::Signal
}

/// Returns messages about the failures of an instance: the function for which its threads have
/// stopped or that does not return, and the recording that could not be written or has gaps.
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
    let lost = status.recording.filter(|(_, lost)| *lost > 0).map(|(file, lost)| {
        format!("instance '{name}': {file}: {lost} changes were lost for want of room")
    });
    fault.into_iter().chain(stopped).chain(lost).collect()
}

/// Returns the message for a person at a terminal after the script, while the machine runs.
fn hint(plan: &Plan) -> String {
    let name = plan.options.place.name();
    let instance = if name == "default" { String::new() } else { format!(" --instance {name}") };
    let mut text = format!(
        "halrun: the machine runs; Ctrl-C ends it. From another terminal: 'halcmd{instance} status', \
         'halcmd{instance} show pin'\n"
    );
    if let Script::Ini(file) = &plan.script {
        text.push_str(&format!(
            "halrun: the panel in a browser: 'halpanel{instance} --ini-file {file}'; 'ferrule start' starts both\n"
        ));
    }
    let options = &plan.options;
    if options.clock == ClockKind::Virtual && options.hold {
        text.push_str(&format!(
            "halrun: the virtual clock stands still; 'halcmd{instance} run 1s' moves it by a second\n"
        ));
    }
    let is_free = options.clock == ClockKind::Virtual && !options.hold;
    if is_free && options.pace.is_none() && plan.for_ns.is_none() {
        text.push_str(
            "halrun: the virtual clock runs as fast as it can; with '--pace 1' it runs at the speed of \
             real time, with '--hold' it moves only in 'run TIME'\n",
        );
    }
    text
}

fn has_threads(engine: &mut Engine) -> bool {
    let all = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
    matches!(engine.call(all), Ok(Reply::Threads(threads)) if !threads.is_empty())
}

/// Serves clients until the instance ends, and tells the service manager, if there is one.
pub(super) fn serve_until_end(plan: &Plan, engine: &mut Engine, service: &mut Option<Notifier>) {
    let is_quiet = plan.batch || plan.style.background || plan.style.silent;
    if !is_quiet && std::io::stderr().is_terminal() && has_threads(engine) {
        Stdio.err(&hint(plan));
    }
    let mut pass = |engine: &mut Engine| {
        if let Some(service) = service {
            service.pass(engine);
        }
    };
    if plan.script == Script::Nothing && plan.for_ns.is_none() {
        // No thread need exist yet.
        let wait = Request::Idle { ms: 100, flow: !plan.options.hold };
        while !engine.is_ending() && engine.call(wait.clone()).is_ok() {
            pass(engine);
        }
    } else if !plan.batch || plan.for_ns.is_some() {
        engine.serve_with(plan.for_ns, &mut pass);
    }
}

#[cfg(test)]
mod tests {
    use super::hint;
    use crate::programs::halrun::plan::{Action, plan};

    fn shown(words: &str) -> String {
        let words: Vec<String> = words.split(' ').map(str::to_owned).collect();
        match plan(&words, &|_| None) {
            Ok(Action::Run(p)) => hint(&p),
            _ => panic!("{words:?}"),
        }
    }

    #[test]
    fn hints_name_the_instance_and_the_free_clock() {
        let runs = "halrun: the machine runs; Ctrl-C ends it. From another terminal: 'halcmd status', \
                    'halcmd show pin'\n";
        let free = "halrun: the virtual clock runs as fast as it can; with '--pace 1' it runs at the speed of \
                    real time, with '--hold' it moves only in 'run TIME'\n";
        for words in ["m.hal", "--virtual --pace 1 m.hal", "--virtual --for 2s m.hal"] {
            assert_eq!(shown(words), runs, "{words}");
        }
        assert_eq!(shown("--virtual m.hal"), format!("{runs}{free}"));
        let panel = "halrun: the panel in a browser: 'halpanel --ini-file m.ini'; 'ferrule start' starts both\n";
        assert_eq!(shown("m.ini"), format!("{runs}{panel}"));
        let held = "halrun: the virtual clock stands still; 'halcmd run 1s' moves it by a second\n";
        assert_eq!(shown("--virtual --hold m.hal"), format!("{runs}{held}"));
        let named = runs.replace("'halcmd ", "'halcmd --instance mill ");
        assert_eq!(shown("--instance mill m.hal"), named);
    }
}
