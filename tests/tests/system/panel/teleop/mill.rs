//! The mill on the virtual clock, its panel with teleoperation, and people who speak the protocol.

use super::super::{
    pair::{Pair, machine, panel, report},
    printer::Session,
};
use hal_tests::{
    programs::root,
    scratch::{Running, Scratch, until},
    web::Socket,
};
use rustix::process::Signal;
use std::{
    collections::BTreeMap,
    fs,
    io::{ErrorKind, Read as _, Write as _},
    net::TcpStream,
    path::PathBuf,
    time::Duration,
};

/// INI file of the mill with teleoperation.
const INI: &str = "teleop.ini";
/// Longest time for which a read waits before machine time passes.
const PATIENCE: Duration = Duration::from_millis(20);

/// The machine and its panel, with their folder.
#[derive(Debug)]
pub(super) struct Mill {
    pub(super) pair: Pair,
    pub(super) scratch: Scratch,
    pub(super) port: u16,
}

/// A connection.
#[derive(Debug)]
struct Person {
    stream: TcpStream,
    /// Bytes that have arrived and are no whole line yet.
    bytes: Vec<u8>,
}

impl Mill {
    /// Starts the mill, whose clock stands still, with these further entries of its INI file and options of the panel.
    pub(super) fn start(entries: &str, options: &[&str]) -> Self {
        Self::with(entries, options, &[])
    }

    /// Does the same, with the first occurrence of a text in a file replaced by another.
    pub(super) fn with(entries: &str, options: &[&str], edits: &[(&str, &str, &str)]) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs/maxnc"));
        for (file, from, to) in edits {
            let text = scratch.read(file);
            assert!(text.contains(from), "{file} has no {from}");
            scratch.write(file, text.replacen(from, to, 1));
        }
        let ini = scratch.read(INI).replace("ON_LOSS = hold\n", entries);
        assert!(ini.contains(entries), "{ini}");
        // Several tests run at the same time: each has a port of its own.
        scratch.write(INI, ini.replace(":2000", ":0"));
        scratch.write("local.ngc", "G20 G1 X2 F6\nM2\n");
        let words = ["--virtual", "--hold", "--headless", INI];
        let machine = machine(&scratch, &words, "task.status");
        let panel = panel_of(&scratch, options);
        let mut mill = Self { pair: Pair { machine, panel }, scratch, port: 0 };
        mill.listens();
        mill
    }

    /// Waits until the server of teleoperation listens.
    pub(super) fn listens(&mut self) {
        until("teleoperation listens", || {
            self.run("10ms");
            let output = self.scratch.halcmd(&["getp", "teleop.listening"]);
            self.port = output.stdout.trim().parse().unwrap_or(0);
            self.port != 0
        });
        // The panel learns by its pins that the machine permits remote motion.
        self.run("100ms");
    }

    /// Ends the panel by a signal and starts another.
    pub(super) fn restart(&mut self, signal: Signal, options: &[&str]) {
        self.pair.panel.signal(signal);
        self.pair.panel.ended().unwrap();
        self.pair.panel = panel_of(&self.scratch, options);
        self.listens();
    }

    /// Ends the machine, while the panel goes on.
    pub(super) fn end_machine(&mut self) {
        self.pair.end_machine();
    }

    /// Lets machine time pass.
    pub(super) fn run(&self, time: &str) {
        self.scratch.halcmd(&["run", time]);
    }

    /// Runs a command of halcmd.
    pub(super) fn halcmd(&self, line: &str) -> String {
        self.scratch.told(line)
    }

    /// Returns a number that halcmd prints of a pin.
    pub(super) fn number(&self, pin: &str) -> f64 {
        self.halcmd(&format!("getp {pin}")).trim().parse().unwrap()
    }

    /// Switches the machine on and homes it.
    pub(super) fn ready(&self) {
        for command in ["task.estop-reset", "task.on", "task.home joint=all"] {
            self.halcmd(command);
            self.run("200ms");
        }
        assert_eq!(self.halcmd("getp motion.is-all-homed").trim(), "TRUE");
    }

    /// Returns the token of the next login.
    pub(super) fn token(&self) -> String {
        let address = self.scratch.read("address");
        address.trim().split_once("#token=").unwrap().1.to_owned()
    }

    /// Opens a page of the panel.
    pub(super) fn page(&self) -> Socket {
        let address = self.scratch.read("address");
        let port = address.split_once("127.0.0.1:").unwrap().1.split_once('/').unwrap().0;
        Session::begin(port.parse().unwrap(), &self.token()).socket()
    }

    /// Returns the file of a program that is checked or runs.
    pub(super) fn file(&self) -> Option<PathBuf> {
        let files = fs::read_dir(self.scratch.path().join(".run/ferrule")).unwrap();
        let mut files = files.map(|entry| entry.unwrap().path());
        files.find(|path| path.file_name().unwrap().to_string_lossy().starts_with(".teleop-"))
    }

    /// Lets machine time pass in small steps until something is so.
    pub(super) fn until(&self, what: &str, is_so: impl FnMut() -> bool) {
        self.in_steps("10ms", what, is_so);
    }

    /// Lets machine time pass until no job runs, in steps that are long, because each starts programs.
    pub(super) fn until_no_job_runs(&self) {
        self.in_steps("500ms", "the job ends", || self.halcmd("getp task.job").trim() == "FALSE");
    }

    fn in_steps(&self, step: &str, what: &str, mut is_so: impl FnMut() -> bool) {
        until(what, || {
            self.run(step);
            is_so()
        });
    }
}

impl Drop for Mill {
    fn drop(&mut self) {
        if std::thread::panicking() {
            report(&self.scratch.read(&self.scratch.private("audit")));
        }
    }
}

fn panel_of(scratch: &Scratch, options: &[&str]) -> Running {
    let (role, options) = match options {
        ["--role", role, rest @ ..] => (*role, rest),
        _ => ("operator", options),
    };
    panel(scratch, role, &[&["--ini-file", INI], options].concat())
}

/// People with their connections, by name.
#[derive(Debug, Default)]
pub(super) struct People(BTreeMap<String, Person>);

impl People {
    /// Sends a line; `TOKEN` in it is the token of the moment.
    pub(super) fn say(&mut self, mill: &Mill, name: &str, line: &str) {
        let person = self.0.entry(name.to_owned()).or_insert_with(|| {
            let stream = TcpStream::connect(("127.0.0.1", mill.port)).unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            Person { stream, bytes: Vec::new() }
        });
        let line = line.replace("TOKEN", &mill.token());
        // A server that has closed the connection reads nothing.
        drop(person.stream.write_all(format!("{line}\r\n").as_bytes()));
    }

    /// Returns the next line, while machine time passes; `(closed)` at the end of the connection.
    pub(super) fn hear(&mut self, mill: &Mill, name: &str) -> String {
        let mut line = None;
        until("an answer comes", || {
            line = self.heard(name);
            if line.is_none() {
                mill.run("100ms");
            }
            line.is_some()
        });
        line.unwrap()
    }

    /// Returns the next line, if there is one.
    pub(super) fn heard(&mut self, name: &str) -> Option<String> {
        let person = self.0.get_mut(name).unwrap();
        let mut buffer = [0; 4096];
        loop {
            if let Some(end) = person.bytes.windows(2).position(|two| two == b"\r\n") {
                let bytes: Vec<u8> = person.bytes.drain(..end + 2).take(end).collect();
                return Some(String::from_utf8(bytes).unwrap());
            }
            match person.stream.read(&mut buffer) {
                Ok(0) => return Some("(closed)".to_owned()),
                Ok(count) => person.bytes.extend(&buffer[..count]),
                Err(e) if e.kind() == ErrorKind::ConnectionReset => {
                    return Some("(closed)".to_owned());
                }
                Err(_) => return None,
            }
        }
    }

    /// Cuts a connection.
    pub(super) fn cut(&mut self, name: &str) {
        self.0.remove(name).unwrap();
    }

    /// Sends a line and returns its answer.
    pub(super) fn ask(&mut self, mill: &Mill, name: &str, line: &str) -> String {
        self.say(mill, name, line);
        self.hear(mill, name)
    }
}
