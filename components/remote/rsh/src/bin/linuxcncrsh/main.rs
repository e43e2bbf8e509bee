//! The program linuxcncrsh: the running machine, commanded with lines of text over a connection of this computer.
#![forbid(unsafe_code)]

mod connection;
mod control;
mod engine;
mod options;
mod seats;

use control::Control;
use engine::{Records, Served};
use hal_ini::Ini;
use hal_lease::EpochPage;
use hal_protocol::{Client, Place};
use options::Options;
use rsh::{Facts, Passwords};
use seats::{MAX_SESSIONS, Seats, Who};
use std::{
    io::Write as _,
    net::{Ipv4Addr, TcpListener, TcpStream},
    process::ExitCode,
    sync::{Arc, Mutex},
    thread,
    time::Duration,
};

/// Interval between two looks whether the engine still runs.
const LOOK: Duration = Duration::from_millis(200);

fn main() -> ExitCode {
    hal_output::program(|_| match run(&Options::given()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            // Without standard error there is nowhere else to say it.
            drop(writeln!(std::io::stderr(), "linuxcncrsh: {text}"));
            ExitCode::FAILURE
        }
    })
}

fn run(options: &Options) -> Result<(), String> {
    let place = Place::find(options.instance.as_deref())?;
    let (path, ini) = match &options.ini_file {
        Some(path) => {
            let ini = Ini::read(path).map_err(|e| e.to_string())?;
            let path = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            (path.display().to_string(), ini)
        }
        None => (String::new(), Ini::parse("", b"").map_err(|e| e.to_string())?),
    };
    let mut watched = Client::connect(&place, "").map_err(|e| e.to_string())?;
    hal_lease::load(&place, Some(&ini), "linuxcncrsh").map_err(|why| why.to_string())?;
    let control = Control::start(&place)?;
    let passwords = Passwords {
        connect: options.connectpw.clone(),
        enable: options.enablepw.clone(),
        name: options.name.clone(),
    };
    let records = Records::open(&mut watched).map_err(|e| e.to_string())?;
    let epochs = Mutex::new(EpochPage::open(&mut watched));
    let most = usize::try_from(options.sessions).unwrap_or(MAX_SESSIONS);
    let source = Arc::new(Served {
        place,
        facts: Facts::new(path, ini),
        passwords,
        control,
        records: Mutex::new(records),
        epochs,
        seats: Seats::new(most),
    });
    let port = options.port;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
        .map_err(|e| format!("127.0.0.1:{port}: {}", hal_output::reason(&e)))?;
    let address = listener.local_addr().map_err(|e| hal_output::reason(&e))?;
    // Nobody has to read it.
    drop(hal_output::print(&format!("linuxcncrsh listens at {address}\n")));
    let only_own = options.has_known_passwords();
    let accept = move || serve(&listener, &source, only_own);
    thread::Builder::new().spawn(accept).map_err(|e| hal_output::reason(&e))?;
    while !watched.is_gone() {
        pause(LOOK);
    }
    Ok(())
}

/// Serves connections, each in a thread of its own.
fn serve(listener: &TcpListener, source: &Arc<Served>, only_own: bool) {
    for (id, stream) in (1..).zip(listener.incoming()) {
        let Ok(stream) = stream else {
            pause(LOOK);
            continue;
        };
        let who = who(&stream);
        if only_own && who != Who::Own {
            let text = "Only programs of the user of linuxcncrsh are served with its well-known passwords.\r\n";
            // Who is refused need not read it.
            drop((&stream).write_all(text.as_bytes()));
            continue;
        }
        let Some(seat) = source.seats.connect(who) else { continue };
        let source = source.clone();
        let work = move || {
            connection::run(stream, id, &source);
            drop(seat);
        };
        // A thread that cannot begin drops what it was given.
        drop(thread::Builder::new().name("session".to_owned()).spawn(work));
    }
}

/// Returns who is at the other end.
fn who(stream: &TcpStream) -> Who {
    if hal_lease::is_own(stream) {
        return Who::Own;
    }
    let ends = stream.peer_addr().and_then(|theirs| Ok((theirs, stream.local_addr()?)));
    Who::Other(ends.ok().and_then(|(theirs, ours)| hal_lease::user_at(theirs, ours)))
}

#[expect(
    clippy::disallowed_methods,
    reason = "programs elsewhere wait for replies whatever the engine's clock shows"
)]
pub(crate) fn pause(time: Duration) {
    thread::sleep(time);
}
