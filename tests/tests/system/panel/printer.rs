//! A simulated machine with its panel: the printer, unless a test asks for another.

use super::pair::{Pair, machine, panel, plain_panel};
use hal_tests::{
    programs::root,
    scratch::{Running, Scratch, until},
    web::{self, Answer, Socket},
};
use rustix::process::Signal;
use serde_json::json;
use std::{fs, path::Path};

/// INI file of the machine, with the entries of the test.
const INI: &str = "machine.ini";
/// Lines of the robot's machine for a lease that lasts where a computer that tests keep busy answers late.
pub(super) const LASTING: &str = "loadrt remote motion=0 lease_timeout=60\naddf remote servo 1\n";

/// The machine and the panel, with their folder.
#[derive(Debug)]
pub(super) struct Printer {
    pair: Pair,
    pub(super) scratch: Scratch,
    pub(super) port: u16,
}

/// A person who has signed in.
#[derive(Clone, Debug)]
pub(super) struct Session {
    port: u16,
    pub(super) cookie: String,
    pub(super) key: String,
}

impl Printer {
    /// Starts the printer, and a panel whose sessions have this role.
    pub(super) fn start(role: &str) -> Self {
        Self::of("printer", role)
    }

    /// Starts another machine of `configs` on the real clock, and a panel whose sessions have this role.
    pub(super) fn of(machine: &str, role: &str) -> Self {
        Self::begin(machine, role, &["--simulate"], "")
    }

    /// Starts the printer on a clock, with these entries of `[REMOTE]`, and a panel whose sessions have this role.
    pub(super) fn with(role: &str, clock: &[&str], entries: &str) -> Self {
        Self::begin("printer", role, clock, entries)
    }

    /// Starts the printer on a clock, whose lease lasts so many seconds without a beat, and a panel whose sessions have this role.
    pub(super) fn leased(role: &str, clock: &[&str], seconds: u32) -> Self {
        Self::with(role, clock, &format!("LEASE_TIMEOUT = {seconds}\n"))
    }

    /// Starts the machine of these files, of which one is `machine.ini`, on the real clock, and a panel of an integrator.
    pub(super) fn made(files: &[(&str, &str)]) -> Self {
        let scratch = Scratch::new("made");
        files.iter().for_each(|(name, text)| scratch.write(name, text));
        fs::create_dir(scratch.path().join("programs")).unwrap();
        let machine = of_ini(&scratch, &["--simulate"]);
        Self::listening(machine, panel_of(&scratch, "integrator", &[]), scratch)
    }

    /// Starts a machine of `configs` that has no INI file, by its script, on a virtual clock that stands until it is run, and a
    /// panel of an integrator with these programs and options.
    pub(super) fn of_script(name: &str, programs: &[&str], options: &[&str]) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs").join(name));
        fs::create_dir(scratch.path().join("programs")).unwrap();
        for program in programs {
            scratch.write(&format!("programs/{program}"), scratch.read(program));
        }
        let script = format!("{name}.hal");
        let words = ["--virtual", "--hold", &script];
        let machine = machine(&scratch, &words, "getp motion.motion-enabled");
        // Before its first cycle a machine has no state.
        scratch.told("run 10ms");
        Self::listening(machine, panel_of(&scratch, "integrator", options), scratch)
    }

    /// Starts a machine of `configs` that has no INI file and no task, by its script, on the real clock, and a panel of an
    /// integrator.
    pub(super) fn without_task(name: &str) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs").join(name));
        fs::create_dir(scratch.path().join("programs")).unwrap();
        let words = ["--simulate", &format!("{name}.hal")];
        let machine = machine(&scratch, &words, "getp motion.motion-enabled");
        Self::listening(machine, panel_of(&scratch, "integrator", &[]), scratch)
    }

    fn begin(name: &str, role: &str, clock: &[&str], entries: &str) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs").join(name));
        let mut ini = scratch.read(&format!("{name}.ini"));
        if clock.contains(&"--simulate") {
            ini = without_following_error(&ini);
        }
        // A computer that tests keep busy answers late: the lease then lasts, while a jog still ends at once.
        let lasts = if entries.contains("LEASE_TIMEOUT") { "" } else { "LEASE_TIMEOUT = 60\n" };
        scratch.write(INI, format!("{ini}\n[REMOTE]\n{lasts}{entries}"));
        fs::create_dir(scratch.path().join("programs")).unwrap();
        let machine = of_ini(&scratch, clock);
        Self::listening(machine, panel_of(&scratch, role, &[]), scratch)
    }

    /// Starts the printer with another INI file and further files on a clock, and a panel whose sessions have this role.
    pub(super) fn edited(
        role: &str,
        clock: &[&str],
        edit: impl Fn(&str) -> String,
        prepare: impl Fn(&Scratch),
    ) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs/printer"));
        let ini = edit(&scratch.read("printer.ini"));
        scratch.write(INI, format!("{ini}\n[REMOTE]\nLEASE_TIMEOUT = 60\n"));
        prepare(&scratch);
        let machine = of_ini(&scratch, clock);
        Self::listening(machine, panel_of(&scratch, role, &[]), scratch)
    }

    fn listening(machine: Running, panel: Running, scratch: Scratch) -> Self {
        let mut printer = Self { pair: Pair { machine, panel }, scratch, port: 0 };
        printer.port = printer.listens();
        printer
    }

    /// Starts the robot of `configs` behind its own controller, a machine without an INI file, on the real clock, and a panel
    /// whose sessions have this role; the programs are in the machine's folder. `lines` follow the machine's script.
    pub(super) fn robot(role: &str, lines: &str) -> Self {
        let name = "rs03n-controller";
        let scratch = Scratch::copy_of(&root().join("configs").join(name));
        scratch.write("machine.hal", format!("source {name}.hal\n{lines}"));
        let ready = if lines.is_empty() { "robot.status" } else { "remote.status" };
        let machine = machine(&scratch, &["--simulate", "machine.hal"], ready);
        Self::listening(machine, panel(&scratch, role, &["--programs", "."]), scratch)
    }

    /// Waits until the panel listens, and returns its port.
    fn listens(&self) -> u16 {
        let file = self.scratch.path().join("address");
        until("the panel writes its address", || is_address(&file));
        let address = self.address();
        let (_, rest) = address.split_once("127.0.0.1:").unwrap();
        rest.split_once('/').unwrap().0.parse().unwrap()
    }

    /// Ends the panel, and starts one whose sessions have another role, with further options.
    pub(super) fn restart(&mut self, role: &str, options: &[&str]) {
        let before = &mut self.pair.panel;
        before.signal(Signal::TERM);
        assert!(before.ended().is_some_and(|s| s.success()), "{:?}", before.said());
        *before = panel_of(&self.scratch, role, options);
        self.port = self.listens();
    }

    /// Ends the panel, and starts one as a person does who names no role.
    pub(super) fn begin_plain(&mut self) {
        let before = &mut self.pair.panel;
        before.signal(Signal::TERM);
        assert!(before.ended().is_some_and(|s| s.success()), "{:?}", before.said());
        *before = plain_panel(&self.scratch, &["--programs", "programs", "--ini-file", INI]);
        self.port = self.listens();
    }

    /// Returns the process id of the panel.
    pub(super) fn panel_pid(&self) -> u32 {
        self.pair.panel.pid()
    }

    /// Sends the panel a signal.
    pub(super) fn signal_panel(&self, signal: Signal) {
        self.pair.panel.signal(signal);
    }

    /// Starts a panel after the one before was killed.
    pub(super) fn begin_again(&mut self, role: &str) {
        assert!(self.pair.panel.ended().is_some(), "the panel still runs");
        // The one that was killed has left it.
        fs::remove_file(self.scratch.path().join("address")).unwrap();
        self.pair.panel = panel_of(&self.scratch, role, &[]);
        self.port = self.listens();
    }

    /// Ends the machine, while the panel goes on.
    pub(super) fn end_machine(&mut self) {
        self.pair.end_machine();
    }

    /// Starts the machine again after its end.
    pub(super) fn start_machine(&mut self) {
        self.pair.machine = of_ini(&self.scratch, &["--simulate"]);
    }

    /// Waits until the first job ends.
    ///
    /// # Panics
    /// The job fails.
    pub(super) fn job_ends(&self) {
        let mut status = String::new();
        until("the job ends", || {
            status = self.halcmd("task.status");
            !status.contains("jobs=0")
        });
        assert!(status.contains("jobs=1 failed=0"), "{status}");
    }

    /// Returns what the panel has printed.
    pub(super) fn said(&self) -> String {
        self.pair.panel.said().0
    }

    /// Returns the address with the one-time token.
    pub(super) fn address(&self) -> String {
        self.scratch.read("address").trim().to_owned()
    }

    /// Returns the one-time token.
    pub(super) fn token(&self) -> String {
        self.address().split_once("#token=").unwrap().1.to_owned()
    }

    /// Signs in.
    pub(super) fn sign_in(&self) -> Session {
        Session::begin(self.port, &self.token())
    }

    /// Returns the header that names this server.
    pub(super) fn host(&self) -> String {
        format!("Host: 127.0.0.1:{}\r\n", self.port)
    }

    /// Sends a request with these lines as headers.
    pub(super) fn request(&self, method: &str, path: &str, headers: &str, body: &[u8]) -> Answer {
        web::request(self.port, method, path, headers, body)
    }

    /// Runs a command of halcmd.
    pub(super) fn halcmd(&self, line: &str) -> String {
        self.scratch.told(line)
    }

    /// Returns a number that halcmd prints of a pin or signal.
    pub(super) fn number(&self, command: &str) -> f64 {
        self.halcmd(command).trim().parse().unwrap()
    }
}

impl Session {
    /// Signs in at the panel of this port.
    pub(super) fn begin(port: u16, token: &str) -> Self {
        let (body, host) =
            (json!({ "token": token }).to_string(), format!("Host: 127.0.0.1:{port}\r\n"));
        let answer = web::request(port, "POST", "/api/v1/session", &host, body.as_bytes());
        assert_eq!(answer.status, 200, "{answer:?}");
        let cookie = answer.header("set-cookie").unwrap().split_once(';').unwrap().0.to_owned();
        let key = answer.json()["key"].as_str().unwrap().to_owned();
        Self { port, cookie, key }
    }

    /// Returns a session by its cookie, with name and value, and its key.
    pub(super) const fn of(port: u16, cookie: String, key: String) -> Self {
        Self { port, cookie, key }
    }

    /// Returns the port of the server.
    pub(super) const fn port(&self) -> u16 {
        self.port
    }

    /// Returns the headers of a request of this session.
    pub(super) fn headers(&self) -> String {
        let Self { port, cookie, key } = self;
        format!("Host: 127.0.0.1:{port}\r\nCookie: {cookie}\r\nX-Ferrule-Key: {key}\r\n")
    }

    /// Opens the socket and sends the hello.
    pub(super) fn open(&self) -> Socket {
        let Self { port, cookie, key } = self;
        let headers = format!("Host: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n");
        let mut socket = Socket::open(*port, "/api/v1/socket", &headers).unwrap();
        socket.send(&json!({ "type": "hello", "key": key }));
        socket
    }

    /// Opens the socket, and waits until the panel knows of the permission.
    pub(super) fn socket(&self) -> Socket {
        let mut socket = self.open();
        let hello = socket.receive().unwrap();
        assert_eq!(hello["type"], "hello", "{hello}");
        // The panel knows of the permission after its first exchange with the engine.
        socket.wait(|m| m["panel"]["allow_motion"] == true).unwrap();
        socket
    }
}

fn is_address(file: &Path) -> bool {
    fs::read_to_string(file).is_ok_and(|text| text.contains("#token=") && text.ends_with('\n'))
}

/// Returns an INI file whose joints may be 1000 units late. On the real clock, a computer that runs the base thread late makes
/// the simulated motors late too, and the machine would switch off.
fn without_following_error(ini: &str) -> String {
    let line = |line: &str| match line.split_once('=') {
        Some((name, _)) if ["FERROR", "MIN_FERROR"].contains(&name.trim()) => {
            format!("{name}= 1000\n")
        }
        _ => format!("{line}\n"),
    };
    ini.lines().map(line).collect()
}

fn of_ini(scratch: &Scratch, clock: &[&str]) -> Running {
    machine(scratch, &[clock, &["--headless", INI]].concat(), "task.status")
}

fn panel_of(scratch: &Scratch, role: &str, options: &[&str]) -> Running {
    let is_there = scratch.path().join(INI).exists();
    let ini: &[&str] = if is_there { &["--ini-file", INI] } else { &[] };
    panel(scratch, role, &[&["--programs", "programs"], ini, options].concat())
}
