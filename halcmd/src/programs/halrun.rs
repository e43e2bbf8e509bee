//! The program halrun: it runs an engine in its process and executes the script of a machine.

mod begin;
pub(crate) mod compat;
pub(crate) mod data;
mod detach;
mod display;
mod environment;
pub(crate) mod folders;
mod job;
mod log;
pub(crate) mod machine;
pub(crate) mod plan;
mod realtime;
pub(crate) mod refused;
mod serve;
mod service;
mod settings;
mod stand_ins;
mod table;
mod waiting;

use crate::{
    Bytes, Error, Outcome, Session, Stdio, Terminal,
    ini::Ini,
    programs::options::Opt,
    session::prompt,
    session::remote::{is_gone, pause},
    terminal::print_error,
};
use hal_engine::{ClockKind, Ends, Engine, Options};
use hal_protocol::{Client, Link, NOT_RUNNING, Place, Request};
use plan::{Action, Detach, Plan, Script};
use serve::{Local, serve_until_end};
use service::Notifier;
use std::{
    path::Path,
    process::{Child, ExitCode},
};

/// Number of times, 10 ms apart, that `-U` checks whether the instance has ended.
const MAX_CHECKS: u32 = 1000;

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    let mut terminal = Stdio;
    let code = match plan::plan(words, &|name| std::env::var(name).ok()) {
        Ok(Action::Help) => shown(&plan::help(), &mut terminal),
        Ok(Action::Stop(place)) => stop(&place, &mut terminal),
        Ok(Action::Run(plan)) if plan.detach == Detach::Parent => {
            detach::parent(words, &mut terminal)
        }
        Ok(Action::Run(plan)) => run(&plan, &mut terminal),
        Err(error) => {
            terminal.err(&format!("{}\n\nFor usage try: halrun -h\n", error.whole()));
            1
        }
    };
    ExitCode::from(code)
}

/// Prints a text. Returns the exit status of the program.
fn shown(text: &str, terminal: &mut dyn Terminal) -> u8 {
    match terminal.out(text) {
        Ok(()) => 0,
        Err(unwritten) => {
            print_error(&format!("halrun: {unwritten}\n"));
            1
        }
    }
}

/// Returns the options for completion.
pub(crate) fn options() -> Vec<Opt<()>> {
    plan::table()
}

/// Executes `-U`: asks the instance to end, and waits until it has.
fn stop(place: &Place, terminal: &mut dyn Terminal) -> u8 {
    let mut client = match Client::connect(place, "") {
        Ok(client) => client,
        Err(failure) if failure.code == NOT_RUNNING => return 0,
        Err(failure) => {
            terminal.err(&format!("halrun: {failure}\n"));
            return 1;
        }
    };
    let wrong = serve::wrong(&mut client, place.name());
    // An instance that has ended meanwhile refuses the request.
    drop(client.call(Request::Shutdown));
    drop(client);
    let has_ended = (0..MAX_CHECKS).any(|_| {
        is_gone(place) || {
            pause(10);
            false
        }
    });
    let name = place.name();
    if !has_ended {
        terminal.err(&format!("halrun: instance '{name}' does not end\n"));
    }
    wrong.iter().filter(|_| has_ended).for_each(|text| terminal.err(&format!("halrun: {text}\n")));
    u8::from(!has_ended || !wrong.is_empty())
}

fn run(plan: &Plan, terminal: &mut dyn Terminal) -> u8 {
    if Client::connect(&plan.options.place, "").is_ok() {
        terminal.err(
            "halrun: Realtime already running.  Use 'halrun -U' to stop existing realtime \
             session.\n",
        );
        return 1;
    }
    match prepare(plan) {
        Ok(files) => make(plan, &files, terminal),
        Err(error @ (Error::NoCommandFile { .. } | Error::Ini(hal_ini::Error::File { .. }))) => {
            terminal.err(&format!("{}\n", error.whole()));
            255
        }
        Err(error) => {
            terminal.err(&format!("{}\n", error.whole()));
            1
        }
    }
}

/// Files that are read before the engine is created.
pub(crate) struct Files {
    pub(crate) ini: Option<Ini>,
    pub(crate) script: Vec<u8>,
}

/// Reads the files of a plan.
pub(crate) fn prepare(plan: &Plan) -> Result<Files, Error> {
    let mut script = Vec::new();
    let ini_path = match &plan.script {
        Script::Hal(path) => {
            script = hal_ini::file::whole(Path::new(path)).map_err(|e| Error::NoCommandFile {
                path: path.as_str().into(),
                why: crate::ini::plain(&e),
            })?;
            plan.ini.as_ref()
        }
        Script::Tcl(path) => {
            std::fs::metadata(path).map_err(|e| Error::NoCommandFile {
                path: path.as_str().into(),
                why: crate::ini::plain(&e),
            })?;
            plan.ini.as_ref()
        }
        Script::Ini(path) => Some(path),
        Script::Terminal | Script::Nothing => plan.ini.as_ref(),
    };
    // A machine needs all of its INI file; a script needs only the entries that it refers to.
    let read = if matches!(plan.script, Script::Ini(_)) { Ini::read } else { Ini::open };
    let ini = ini_path.map(|path| read(Path::new(path))).transpose()?;
    match (&plan.script, &ini) {
        (Script::Ini(_), Some(ini)) => refused::refuse(ini)?,
        (_, Some(ini)) => {
            realtime::of_ini(ini)?;
            compat::of_ini(ini)?;
        }
        (_, None) => {}
    }
    Ok(Files { ini, script })
}

/// Returns the options of the instance: those of the plan, and those that follow from the INI file.
pub(crate) fn instance_options(plan: &Plan, files: &Files) -> Options {
    let mut options = plan.options.clone();
    options.old_names = files.ini.as_ref().is_some_and(Ini::is_old);
    options.interlock = matches!(plan.script, Script::Ini(_));
    let asked = files.ini.as_ref().is_some_and(|ini| compat::of_ini(ini) == Ok(true));
    options.earlier_values |= asked;
    let times = files.ini.as_ref().and_then(|ini| realtime::of_ini(ini).ok()).unwrap_or_default();
    options.realtime.stuck_ns = options.realtime.stuck_ns.or(times.stuck_ns);
    options.realtime.max_gap_ns = options.realtime.max_gap_ns.or(times.max_gap_ns);
    options
}

fn make(plan: &Plan, files: &Files, terminal: &mut dyn Terminal) -> u8 {
    log::listen(plan.selection.clone());
    if plan.detach == Detach::Child {
        detach::leave_terminal();
    }
    let ends = Ends::begin("halrun");
    let mut engine = match Engine::new(instance_options(plan, files)) {
        Ok(engine) => engine,
        Err(failure) => {
            terminal.err(&format!("halrun: {failure}\n"));
            return 1;
        }
    };
    let (outcome, status, programs) = script(plan, files, &mut engine, terminal);
    let mut code = match outcome {
        Outcome::Good => 0,
        Outcome::Failed => 1,
        // A script that ends on request has not failed; a script that a signal has interrupted has.
        Outcome::Ended => u8::from(serve::was_broken_off(&mut engine)),
    };
    if plan.detach == Detach::Child && outcome == Outcome::Good {
        // The log must be known before the waiting process returns.
        let log = detach::leave_stderr(&plan.options.place);
        ends.be_quiet(log.as_deref());
        detach::tell();
    }
    let goes_on = outcome == Outcome::Good
        && plan.job.is_none()
        && !plan.interactive
        && plan.script != Script::Terminal;
    let mut service = Notifier::of_environment();
    if goes_on {
        if let Some(service) = &mut service {
            service.ready(&mut engine, plan.options.place.name());
        }
        serve_until_end(plan, &mut engine, &mut service);
    }
    if let Some(service) = &service {
        service.stopping();
    }
    if let Some(said) = ends.said() {
        terminal.err(&format!("halrun: {said}\n"));
    }
    // A typed command may fail without a failure of the session.
    if plan.script == Script::Terminal && outcome == Outcome::Failed {
        code = 0;
    }
    code = status.unwrap_or(code);
    if !engine.close_checked() {
        code = 1;
    }
    // The engine has ended the programs; this collects their statuses.
    for mut program in programs {
        drop(program.wait());
    }
    if plan.detach == Detach::Child {
        detach::forget(&plan.options.place);
    }
    ends.finish(code)
}

fn script(
    plan: &Plan,
    files: &Files,
    engine: &mut Engine,
    terminal: &mut dyn Terminal,
) -> (Outcome, Option<u8>, Vec<Child>) {
    let mut link = Local::new(engine);
    // What a person types has no end that programs could wait for.
    link.set_starting(plan.script != Script::Terminal);
    if let Some(level) = plan.level {
        // The level is within range.
        drop(link.call(Request::MessageLevel { level }));
    }
    let instance = plan.options.place.name();
    let mut session = Session::new(&mut link, terminal, plan.style, instance);
    if let Some(ini) = &files.ini {
        session.set_ini(ini);
        session.warn(ini.warnings());
    }
    session.sleeps_on_the_clock = plan.options.clock == ClockKind::Virtual && !plan.options.hold;
    if let Some(path) = &plan.record {
        let path = path.display().to_string();
        session.before_start(Request::Record { path, patterns: Vec::new() });
    }
    if let Some(spec) = &plan.flight {
        session.before_start(Request::Flight(spec.clone()));
    }
    let typed = |session: &mut Session<'_>| {
        session.style_mut().keep_going = true;
        if plan.tcl { session.tcl_prompt() } else { prompt::typed(session, plan.interactive) }
    };
    let prepared = stand_ins::prepare(&mut session, plan, files);
    let outcome = match (&plan.script, &files.ini) {
        _ if prepared != Outcome::Good => prepared,
        (Script::Hal(path), _) => session.file(path, Bytes::new(files.script.clone())),
        (Script::Tcl(path), _) => machine::tcl_script(&mut session, Path::new(path)),
        (Script::Ini(path), Some(ini)) => {
            let is_shown = display::is_shown(plan, ini);
            let reads = is_shown && display::reads_postgui(ini);
            if !is_shown {
                machine::warn_of_shutdown(&mut session, ini);
            }
            machine::start(&mut session, ini, Path::new(path), !reads)
        }
        (Script::Terminal, _) => typed(&mut session),
        (Script::Nothing | Script::Ini(_), _) => Outcome::Good,
    };
    let outcome = session.settle(outcome);
    if outcome == Outcome::Failed {
        stand_ins::propose(&mut session, plan, files);
    }
    let (outcome, status) = match &plan.job {
        Some(job) if outcome == Outcome::Good => job::run(&mut session, job),
        _ => (outcome, None),
    };
    let outcome = match (&plan.script, &files.ini) {
        (Script::Ini(path), Some(ini))
            if outcome == Outcome::Good && display::is_shown(plan, ini) =>
        {
            display::run(&mut session, ini, Path::new(path))
        }
        _ => outcome,
    };
    if plan.interactive && outcome != Outcome::Ended && plan.script != Script::Terminal {
        typed(&mut session);
    }
    (outcome, status, session.into_programs())
}
