//! The program linuxcncrsh: the running machine, commanded with lines of text over a connection of this computer.
#![forbid(unsafe_code)]

mod connection;
mod control;
mod engine;
mod options;

use control::Control;
use engine::Served;
use hal_ini::Ini;
use hal_protocol::{Client, Place};
use options::Options;
use rsh::{Facts, Passwords};
use std::{
    io::Write as _,
    net::{Ipv4Addr, TcpListener},
    process::ExitCode,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
    thread,
    time::Duration,
};

/// Number of connections at once, whatever the options say.
const MAX_SESSIONS: usize = 256;
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
    let watched = Client::connect(&place, "").map_err(|e| e.to_string())?;
    hal_lease::load(&place, Some(&ini), "linuxcncrsh")?;
    let control = Control::start(&place)?;
    let passwords = Passwords {
        connect: options.connectpw.clone(),
        enable: options.enablepw.clone(),
        name: options.name.clone(),
    };
    let source = Arc::new(Served { place, facts: Facts::new(path, ini), passwords, control });
    let port = options.port;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
        .map_err(|e| format!("127.0.0.1:{port}: {}", hal_output::reason(&e)))?;
    let address = listener.local_addr().map_err(|e| hal_output::reason(&e))?;
    // Nobody has to read it.
    drop(hal_output::print(&format!("linuxcncrsh listens at {address}\n")));
    let most = usize::try_from(options.sessions).unwrap_or(MAX_SESSIONS).min(MAX_SESSIONS);
    let only_own = options.has_known_passwords();
    let accept = move || serve(&listener, &source, most, only_own);
    thread::Builder::new().spawn(accept).map_err(|e| hal_output::reason(&e))?;
    while !watched.is_gone() {
        pause(LOOK);
    }
    Ok(())
}

/// Serves connections, each in a thread of its own.
fn serve(listener: &TcpListener, source: &Arc<Served>, most: usize, only_own: bool) {
    let count = Arc::new(AtomicUsize::new(0));
    for (id, stream) in (1..).zip(listener.incoming()) {
        let Ok(stream) = stream else {
            pause(LOOK);
            continue;
        };
        if only_own && !hal_lease::is_own(&stream) {
            let text = "Only programs of the user of linuxcncrsh are served with its well-known passwords.\r\n";
            // Who is refused need not read it.
            drop((&stream).write_all(text.as_bytes()));
            continue;
        }
        if count.load(Relaxed) >= most {
            continue;
        }
        let (source, counted) = (source.clone(), Counted::begin(&count));
        let work = move || {
            connection::run(stream, id, &source);
            drop(counted);
        };
        // A thread that cannot begin drops what it was given.
        drop(thread::Builder::new().name("session".to_owned()).spawn(work));
    }
}

/// A connection that counts until it ends in any way.
struct Counted(Arc<AtomicUsize>);

impl Counted {
    fn begin(count: &Arc<AtomicUsize>) -> Self {
        count.fetch_add(1, Relaxed);
        Self(count.clone())
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Relaxed);
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "programs elsewhere wait for replies whatever the engine's clock shows"
)]
pub(crate) fn pause(time: Duration) {
    thread::sleep(time);
}
