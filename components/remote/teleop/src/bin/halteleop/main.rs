//! The program halteleop: sends a program to a machine, runs it there, and shows its progress.
#![forbid(unsafe_code)]

mod link;
mod options;

use clap::Parser as _;
use link::Link;
use options::{Options, Status, Work};
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};
use std::{
    io::Write as _,
    process::ExitCode,
    sync::{Arc, atomic::AtomicBool, atomic::Ordering::Relaxed},
    time::{Duration, Instant},
};
use teleop::{Client, Code, End, Event};

/// Longest silence of the server: it may check a program for a minute before the job starts.
const SILENCE: Duration = Duration::from_secs(90);
/// Longest time for the farewell.
const FAREWELL: Duration = Duration::from_secs(2);

fn main() -> ExitCode {
    hal_output::program(|_| {
        let (status, text) = match run(&Options::parse()) {
            Ok(()) => return ExitCode::SUCCESS,
            Err(why) => why,
        };
        // Without standard error there is nowhere else to say it.
        drop(writeln!(std::io::stderr(), "halteleop: {text}"));
        ExitCode::from(status as u8)
    })
}

/// Reason why the program fails, with its exit status.
type Failure = (Status, String);

#[expect(
    clippy::disallowed_methods,
    reason = "a program at the edge: the server lives in real time"
)]
fn run(options: &Options) -> Result<(), Failure> {
    let program = match &options.work {
        Work::Run { file } => Some(options::read(file)?),
        Work::Progress => None,
    };
    let runs = program.is_some();
    let secret = options.secret()?;
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        flag::register(signal, stop.clone())
            .map_err(|e| (Status::Local, hal_output::reason(&e)))?;
    }
    let mut link = Link::open(options)?;
    let begin = Instant::now();
    let now = || u64::try_from(begin.elapsed().as_millis()).unwrap_or(u64::MAX);
    let mut client = Client::new(&options.user, &secret, program);
    let (mut heard, mut ended) = (Instant::now(), None);
    loop {
        if !link.send(&client.output()) {
            client.closed();
        }
        match link.receive() {
            Some(bytes) if !bytes.is_empty() => {
                heard = Instant::now();
                client.receive(&bytes, now());
            }
            Some(_) if heard.elapsed() < SILENCE => {}
            Some(_) | None => client.closed(),
        }
        if stop.swap(false, Relaxed) {
            client.cancel();
        }
        client.poll(now());
        for event in client.events() {
            show(&event, options)?;
        }
        if let Some(end) = client.end().cloned() {
            let since = *ended.get_or_insert_with(Instant::now);
            // The farewell is sent, and the server closes.
            let is_over = link.is_closed() || since.elapsed() > FAREWELL;
            if is_over || !link.send(&client.output()) {
                return result(end, runs);
            }
        }
    }
}

/// Prints what has happened.
fn show(event: &Event, options: &Options) -> Result<(), Failure> {
    let text = match event {
        Event::Progress(percent) => format!("{percent} %\n"),
        _ if options.quiet => return Ok(()),
        Event::SignedIn => format!("logged in as {}\n", options.user),
        Event::Sent => "the program is there; it is checked, then it runs\n".to_owned(),
    };
    hal_output::print(&text).map_err(|e| (Status::Local, e.to_string()))
}

/// Returns the exit status of a result, with a text for people.
fn result(end: End, runs: bool) -> Result<(), Failure> {
    Err(match end {
        End::Done => return Ok(()),
        End::Cancelled => (Status::Cancelled, "the job is cancelled".to_owned()),
        End::Denied(why) => (Status::Denied, format!("the login is refused: {why}")),
        End::Refused(why) => {
            let status = match why.code {
                Some(Code::Falla) => Status::Failed,
                Some(Code::Detenido) => Status::Stopped,
                Some(
                    Code::Ocupado | Code::Apagado | Code::SinAjuste | Code::Permiso | Code::Orden,
                ) => Status::NotReady,
                Some(Code::Sintaxis | Code::Limite | Code::Vacio | Code::Largo)
                | Some(Code::Desconocido)
                | None => Status::Program,
            };
            let what = if status == Status::Failed { "the job has ended" } else { "refused" };
            (status, format!("{what}: {why}"))
        }
        End::Stopped => (Status::Stopped, "the server has stopped".to_owned()),
        End::Lost if runs => (
            Status::Lost,
            "the connection is lost: what the job does now, [REMOTE]ON_LOSS of the machine says"
                .to_owned(),
        ),
        End::Lost => (Status::Lost, "the connection is lost".to_owned()),
        End::Strange(line) => {
            (Status::Lost, format!("'{line}' is no answer: another program listens there"))
        }
    })
}
