//! Programs beside a machine that stop it: the panel by its socket, linuxcncrsh by lines, Python by the module `linuxcnc`.

use super::rig::Rig;
use hal_protocol::{Link as _, Request};
use hal_tests::{
    programs::programs,
    scratch::{Running, Scratch, until},
    tools::Tool,
    web::{self, Socket},
};
use rustix::process::Signal;
use serde_json::json;
use std::{
    fs::{self, OpenOptions},
    io::{Read as _, Write as _},
    net::{Shutdown, TcpStream},
    process::{Command, Stdio},
};

/// Reply to the line that marks the end of the reply before it.
const MARK: &str = "PLAT Linux\r\n";
/// Cycles that pass between two looks at a program that starts.
const LOOK: usize = 10;
/// The program in Python: it reads stops, jogs and runs, and says each that was given.
const SCRIPT: &str = "\
import sys
import linuxcnc
command = linuxcnc.command()
stops = {
    'estop': lambda: command.state(linuxcnc.STATE_ESTOP),
    'off': lambda: command.state(linuxcnc.STATE_OFF),
    'abort': command.abort,
    'pause': lambda: command.auto(linuxcnc.AUTO_PAUSE),
}
print('ready', flush=True)
def jog(is_joint, index, speed):
    command.jog(linuxcnc.JOG_CONTINUOUS, bool(int(is_joint)), int(index), float(speed))
def run(part):
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete()
    command.program_open(part)
    command.wait_complete()
    command.auto(linuxcnc.AUTO_RUN, 0)
stops['jog'], stops['run'] = jog, run
for line in open('stop'):
    name, *words = line.split()
    try:
        stops[name](*words)
        print('gave', name, flush=True)
    except Exception as error:
        print('gave', name, 'and failed:', error, flush=True)
";

/// The programs that run beside a machine.
#[derive(Default)]
pub(super) struct Clients {
    panel: Option<Panel>,
    rsh: Option<Rsh>,
    python: Option<Python>,
}

/// A program that gives stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Client {
    Panel,
    Rsh,
    Python,
}

impl Client {
    /// Returns whether the program takes the control lease when it starts.
    pub(super) const fn needs_lease(self) -> bool {
        matches!(self, Self::Panel | Self::Rsh)
    }
}

/// Gives a stop by a program; returns its refusal, if any.
///
/// # Errors
/// The program is missing on this computer.
pub(super) fn give(rig: &mut Rig, client: Client, word: &str) -> Result<Option<String>, String> {
    ready(rig, client)?;
    let clients = &mut rig.clients;
    Ok(match client {
        Client::Panel => clients.panel.as_ref().and_then(|panel| panel.give(word)),
        Client::Rsh => clients.rsh.as_mut().and_then(|rsh| rsh.give(word)),
        Client::Python => clients.python.as_mut().and_then(|python| python.give(word)),
    })
}

/// Starts a program, if it does not run yet.
///
/// # Errors
/// The program is missing on this computer.
pub(super) fn ready(rig: &mut Rig, client: Client) -> Result<(), String> {
    match client {
        Client::Panel if rig.clients.panel.is_none() => {
            let panel = Panel::start(rig);
            rig.clients.panel = Some(panel);
        }
        Client::Rsh if rig.clients.rsh.is_none() => {
            let rsh = Rsh::start(rig);
            rig.clients.rsh = Some(rsh);
        }
        Client::Python if rig.clients.python.is_none() => {
            let python = Python::start(rig)?;
            rig.clients.python = Some(python);
        }
        _ => {}
    }
    Ok(())
}

/// Waits until something is so, while machine time passes.
fn passes(rig: &mut Rig, what: &str, mut look: impl FnMut(&Scratch) -> bool) {
    until(what, || {
        rig.run(LOOK);
        look(&rig.scratch)
    });
    rig.forget();
}

/// The panel, and a session that has signed in.
pub(super) struct Panel {
    pub(super) running: Running,
    port: u16,
    cookie: String,
    key: String,
}

impl Panel {
    pub(super) fn start(rig: &mut Rig) -> Self {
        let Rig { scratch, client, machine, .. } = rig;
        let mut passes = || {
            client.call(Request::Run { ns: LOOK as u64 * 1_000_000 }).unwrap();
        };
        let panel = Self::beside(scratch, machine.is_ini(), &mut passes);
        rig.skip();
        panel
    }

    /// Starts a panel of a machine, whose time `passes` lets pass; returns it with the address for a page.
    pub(super) fn serve(
        scratch: &Scratch,
        is_ini: bool,
        passes: &mut dyn FnMut(),
    ) -> (Running, String) {
        fs::create_dir_all(scratch.path().join("programs")).unwrap();
        // A panel before this one has left its address.
        drop(fs::remove_file(scratch.path().join("address")));
        let mut command = scratch.command(&[], "halpanel");
        command.args(["--listen", "127.0.0.1:0", "--role", "operator", "--programs", "programs"]);
        command.args(["--address-file", "address", "--audit", &scratch.private("audit")]);
        if is_ini {
            command.args(["--ini-file", "machine.ini"]);
        }
        let running = scratch.start(&mut command).lasting("the panel");
        let mut address = String::new();
        until("the panel listens", || {
            passes();
            address = fs::read_to_string(scratch.path().join("address")).unwrap_or_default();
            address.contains("#token=") && address.ends_with('\n')
        });
        (running, address.trim_end().to_owned())
    }

    /// Starts a panel of a machine, whose time `passes` lets pass, and signs in.
    pub(super) fn beside(scratch: &Scratch, is_ini: bool, passes: &mut dyn FnMut()) -> Self {
        let (running, address) = Self::serve(scratch, is_ini, passes);
        let (_, rest) = address.split_once("127.0.0.1:").unwrap();
        let (port, rest) = rest.split_once('/').unwrap();
        let (port, token) = (port.parse().unwrap(), rest.split_once("#token=").unwrap().1);
        let (body, host) =
            (json!({ "token": token }).to_string(), format!("Host: 127.0.0.1:{port}\r\n"));
        let answer = web::request(port, "POST", "/api/v1/session", &host, body.as_bytes());
        assert_eq!(answer.status, 200, "{answer:?}");
        let cookie = answer.header("set-cookie").unwrap().split_once(';').unwrap().0.to_owned();
        let key = answer.json()["key"].as_str().unwrap().to_owned();
        // The panel exchanges its pins.
        (0..100).for_each(|_| passes());
        Self { running, port, cookie, key }
    }

    pub(super) fn pid(&self) -> u32 {
        self.running.pid()
    }

    /// Opens the socket of a page.
    pub(super) fn socket(&self) -> Socket {
        let Self { port, cookie, key, .. } = self;
        let headers = format!("Host: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n");
        let mut socket = Socket::open(*port, "/api/v1/socket", &headers).unwrap();
        socket.send(&json!({ "type": "hello", "key": key }));
        let hello = socket.receive().unwrap();
        assert_eq!(hello["type"], "hello", "{hello}");
        socket
    }

    /// Gives a command; returns its refusal, if any.
    pub(super) fn give(&self, name: &str) -> Option<String> {
        // A page that has just been opened, without a lease.
        let mut socket = self.socket();
        let reply = socket.ask(json!({ "type": "command", "name": name, "args": {} }));
        let error = &reply["error"];
        (!error.is_null()).then(|| format!("panel {name}: {error}"))
    }
}

/// The server of lines, and a connection that has said hello and has no control.
pub(super) struct Rsh {
    pub(super) running: Running,
    stream: TcpStream,
}

impl Rsh {
    pub(super) fn start(rig: &mut Rig) -> Self {
        let mut command = rig.scratch.command(&[], "linuxcncrsh");
        command.args(["-p", "0"]);
        if rig.machine.is_ini() {
            command.args(["-ini", "machine.ini"]);
        }
        let running = rig.scratch.start(&mut command).lasting("linuxcncrsh");
        let mut port = None;
        passes(rig, "linuxcncrsh listens", |_| {
            let said = |l: &str| l.strip_prefix("linuxcncrsh listens at 127.0.0.1:")?.parse().ok();
            port = running.said().0.lines().find_map(said);
            port.is_some()
        });
        let stream = TcpStream::connect(("127.0.0.1", port.unwrap_or(0_u16))).unwrap();
        let mut rsh = Self { running, stream };
        for line in ["hello EMC me 1.0", "set echo off", "set verbose on"] {
            rsh.ask(line);
        }
        rsh
    }

    /// Sends a line and returns its reply.
    fn ask(&mut self, line: &str) -> String {
        self.stream.write_all(format!("{line}\r\nget plat\r\n").as_bytes()).unwrap();
        let (mut seen, mut byte) = (Vec::new(), [0]);
        while !seen.ends_with(MARK.as_bytes()) {
            self.stream.read_exact(&mut byte).unwrap();
            seen.push(byte[0]);
        }
        let text = String::from_utf8(seen).unwrap();
        text.strip_suffix(MARK).unwrap().to_owned()
    }

    /// Ends the connection.
    pub(super) fn hang_up(&mut self) {
        self.stream.shutdown(Shutdown::Both).unwrap();
    }

    pub(super) fn give(&mut self, words: &str) -> Option<String> {
        let reply = self.ask(&format!("set {words}"));
        let is_taken = reply.trim_end().ends_with("ACK");
        (!is_taken).then(|| format!("rsh {words}: {reply:?} {}", self.ask("get error")))
    }
}

/// The program in Python, which reads stops from a pipe.
pub(super) struct Python {
    pub(super) running: Running,
    /// Number of stops that it has said.
    gave: usize,
    /// The pipe stays open: a line in one that is opened again can be lost.
    pipe: fs::File,
}

impl Python {
    pub(super) fn start(rig: &mut Rig) -> Result<Self, String> {
        let runs = |name: &&str| {
            Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success())
        };
        let found = ["/usr/bin/python3", "python3"].into_iter().find(runs);
        let python = Tool::of("python3").or_skip(found).ok_or("there is no python3")?;
        let scratch = &rig.scratch;
        scratch.write("stops.py", SCRIPT);
        drop(fs::remove_file(scratch.path().join("stop")));
        let made = Command::new("mkfifo").arg(scratch.path().join("stop")).status().unwrap();
        assert!(made.success(), "a pipe is made");
        let mut command = scratch.command(&[], python);
        let modules = programs().join("python");
        command.arg("stops.py").env("PYTHONPATH", modules).env("PYTHONDONTWRITEBYTECODE", "1");
        let running = scratch.start(command.stdin(Stdio::null())).lasting("the program in Python");
        passes(rig, "the program in Python is ready", |_| running.said().0.contains("ready"));
        let pipe = OpenOptions::new().write(true).open(rig.scratch.path().join("stop")).unwrap();
        Ok(Self { running, gave: 0, pipe })
    }

    fn give(&mut self, name: &str) -> Option<String> {
        self.order(name, &mut || {})
    }

    /// Sends a line, and waits until it was given; meanwhile time passes.
    pub(super) fn order(&mut self, line: &str, passes: &mut dyn FnMut()) -> Option<String> {
        self.pipe.write_all(format!("{line}\n").as_bytes()).unwrap();
        let mut said = String::new();
        until("the program in Python has given it", || {
            passes();
            said = self.running.said().0;
            said.lines().filter(|l| l.starts_with("gave")).count() > self.gave
        });
        self.gave += 1;
        let last = said.lines().last().unwrap_or_default();
        last.contains("failed").then(|| last.to_owned())
    }
}

impl Drop for Clients {
    fn drop(&mut self) {
        let panel = self.panel.as_mut().map(|p| &mut p.running);
        let rsh = self.rsh.as_mut().map(|r| &mut r.running);
        let python = self.python.as_mut().map(|p| &mut p.running);
        for running in [panel, rsh, python].into_iter().flatten() {
            if running.is_running() {
                running.signal(Signal::TERM);
                running.ended();
            }
        }
    }
}
