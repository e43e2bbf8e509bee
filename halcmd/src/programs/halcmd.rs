//! The program halcmd: commands for a running instance.

use crate::{
    Bytes, Error, Outcome, Session, Stdio, Style, Terminal, check,
    ini::Ini,
    manual::complete,
    manual::explain,
    manual::help,
    manual::man,
    programs::common::{COMMON, Id, apply, short},
    programs::options::{Opt, from_environment, options, plain, program_usage},
    programs::profile::Profile,
    session::messages,
    session::prompt,
    session::remote::{Remote, instance_option},
    terminal::print_error,
    terminal::termination::leave_on_signals,
};
use hal_protocol::Place;
use std::{path::Path, process::ExitCode};

const OPTIONS: &[Opt<Id>] = &{
    let [a, b, c, d, e, f, g, h, i] = COMMON;
    [
        a,
        b,
        c,
        d,
        e,
        f,
        g,
        h,
        i,
        short(Id::File, 'f', "take commands from FILE, or from standard input"),
        Opt { long: Some("help"), ..short(Id::Help, 'h', "print this, or the help of a command") },
        short(Id::Complete, 'C', "complete the line in COMP_LINE, for shells"),
        long("json", Id::Json, "print replies as they came"),
        long("tcl", Id::Tcl, "answer the requests of a Tcl script; the package Hal starts it so"),
        long("wait", Id::Wait, "wait until the machine has carried out a component's command"),
        instance_option(Id::Instance),
    ]
};

const fn long(name: &'static str, id: Id, help: &'static str) -> Opt<Id> {
    Opt { id, short: None, long: Some(name), value: None, variable: None, help }
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    let mut terminal = Stdio;
    match run(words, &mut terminal) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            let json = words.iter().take_while(|w| w.starts_with('-')).any(|w| w == "--json");
            let text =
                if json { messages::lone_object(&error) } else { format!("{}\n", error.whole()) };
            print_error(&text);
            ExitCode::from(255)
        }
    }
}

fn run(words: &[String], terminal: &mut dyn Terminal) -> Result<u8, Error> {
    let (mut given, rest) = options("halcmd", OPTIONS, words)?;
    let profile = Profile::of_environment()?;
    from_environment(OPTIONS, &|name| profile.system(name), &mut given);
    let has = |wanted| given.iter().any(|(id, _)| *id == wanted);
    let value = |wanted| given.iter().rev().find(|(id, _)| *id == wanted)?.1.clone();
    if has(Id::Complete) {
        return complete_line(&rest, terminal);
    }
    let mut style = Style::default();
    given.iter().for_each(|(id, _)| apply(&mut style, *id));
    if has(Id::Help) {
        let about = rest.first().map(String::as_str);
        if style.json {
            terminal.out(&format!("{}\n", help::object(about)))?;
            return Ok(0);
        }
        let text = about.map_or_else(|| Ok(usage_text()), |name| help::help(Some(name)));
        terminal.out(&text.unwrap_or_else(|error| format!("{}\n", error.whole())))?;
        return Ok(0);
    }
    let file = has(Id::File);
    let tcl = has(Id::Tcl);
    if !file && !tcl && rest.is_empty() {
        if !has(Id::Release) {
            terminal.out(&usage_text())?;
        }
        return Ok(0);
    }
    if let Some((name, words)) = rest.split_first().filter(|_| !file) {
        match name.as_str() {
            "explain" => return explain::main(words, terminal),
            "man" if !words.is_empty() => return man::main(words, terminal),
            "check" => {
                let before = check::Before { ini: value(Id::Ini), json: style.json };
                let mut remote = Remote::new(place(value(Id::Instance))?, "");
                return check::main(words, before, &mut remote, terminal);
            }
            _ => {}
        }
    }
    if !file && !tcl && has(Id::Ini) {
        terminal.err("-i may only be used together with -f\n");
        return Ok(1);
    }
    let place = place(value(Id::Instance))?;
    let ini = value(Id::Ini).map(|path| Ini::open(Path::new(&path))).transpose()?;
    let text = match rest.first().filter(|_| file) {
        Some(path) => {
            let unreadable =
                |e| Error::NoCommandFile { path: path.as_str().into(), why: crate::ini::plain(&e) };
            Some((path.as_str(), hal_ini::file::whole(Path::new(path)).map_err(unreadable)?))
        }
        None => None,
    };
    leave_on_signals(1);
    let me = format!("halcmd{}", std::process::id());
    let instance = place.name().to_owned();
    let mut remote = Remote::new(place, &me);
    style.reads_input = tcl || file && text.is_none();
    let mut session = Session::new(&mut remote, terminal, style, &instance);
    if let Some(ini) = &ini {
        session.set_ini(ini);
        session.warn(ini.warnings());
    }
    let outcome = match text {
        Some((path, text)) => session.file(path, Bytes::new(text)),
        None if tcl => session.serve_tcl(),
        None if file => prompt::typed(&mut session, true),
        None => session.command(&rest),
    };
    Ok(u8::from(outcome != Outcome::Good))
}

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Executes `-C`. bash passes the program, the word being typed and the one before; the line and
/// the cursor position are in the environment. With `HAL_COMPLETE=about`, each word is followed by
/// its description.
fn complete_line(rest: &[String], terminal: &mut dyn Terminal) -> Result<u8, Error> {
    let line = std::env::var("COMP_LINE").unwrap_or_default();
    let point = std::env::var("COMP_POINT").ok().and_then(|p| p.parse::<usize>().ok());
    let line = point.and_then(|p| line.get(..p)).unwrap_or(&line);
    let about = std::env::var("HAL_COMPLETE").is_ok_and(|v| v == "about");
    let found = complete::for_shell(line, rest.get(1).map(String::as_str));
    for candidate in &found.candidates {
        let about = if about { format!("\t{}", candidate.about) } else { String::new() };
        terminal.out(&format!("{}{about}\n", candidate.word))?;
    }
    Ok(if found.files { complete::COMPLETE_FILES } else { 0 })
}

/// Returns the requested instance.
fn place(name: Option<String>) -> Result<Place, Error> {
    Place::find(name.as_deref()).map_err(|why| Error::OptionValue {
        program: "halcmd",
        option: "--instance".into(),
        value: name.unwrap_or_default().into(),
        why: why.into(),
    })
}

fn usage_text() -> String {
    format!(
        "\nUsage:   halcmd [options] [command [arguments]]\n         \
         halcmd [options] -f [FILE]\n         \
         halcmd check [FILE...]      what is wrong with a machine, before it moves\n         \
         halcmd explain [CODE]       what a finding of check means\n\noptions:\n{}\n\
         'halcmd help' lists the commands, 'halcmd help COMMAND' explains one.\n",
        program_usage(OPTIONS)
    )
}
