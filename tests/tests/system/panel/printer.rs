//! A simulated machine with its panel: the printer, unless a test asks for another.

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

/// The machine and the panel; both end with it.
#[derive(Debug)]
pub(super) struct Printer {
    panel: Running,
    machine: Running,
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

/// Prints what a program has said on standard error before a test failed.
pub(super) fn shown(name: &str, program: &Running) {
    report(&format!("{name} said: {}", program.said().1));
}

/// Prints a part of the report of a test that fails.
#[expect(clippy::print_stderr, reason = "the report of a test that fails")]
pub(super) fn report(text: &str) {
    eprintln!("{text}");
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

    /// Starts the machine of these files, of which one is `machine.ini`, on the real clock, and a panel of an integrator.
    pub(super) fn made(files: &[(&str, &str)]) -> Self {
        let scratch = Scratch::new("made");
        files.iter().for_each(|(name, text)| scratch.write(name, text));
        fs::create_dir(scratch.path().join("programs")).unwrap();
        let machine = machine(&scratch, &["--simulate"]);
        let panel = panel(&scratch, "integrator", &[]);
        Self::listening(scratch, machine, panel)
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
        let mut command = scratch.command(&[], "halrun");
        let machine = scratch.start(command.args(["--virtual", "--hold", &script]));
        until("the machine runs", || {
            scratch.halcmd(&["getp", "motion.motion-enabled"]).status == Some(0)
        });
        // Before its first cycle a machine has no state.
        scratch.told("run 10ms");
        let panel = panel(&scratch, "integrator", options);
        Self::listening(scratch, machine, panel)
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
        let machine = machine(&scratch, clock);
        let panel = panel(&scratch, role, &[]);
        Self::listening(scratch, machine, panel)
    }

    fn listening(scratch: Scratch, machine: Running, panel: Running) -> Self {
        let mut printer = Self { panel, machine, scratch, port: 0 };
        printer.port = printer.listens();
        printer
    }

    /// Starts the robot of `configs` behind its own controller, a machine without an INI file, on the real clock, and a panel
    /// whose sessions have this role; the programs are in the machine's folder. `lines` follow the machine's script.
    pub(super) fn robot(role: &str, lines: &str) -> Self {
        let name = "rs03n-controller";
        let scratch = Scratch::copy_of(&root().join("configs").join(name));
        scratch.write("machine.hal", format!("source {name}.hal\n{lines}"));
        let mut command = scratch.command(&[], "halrun");
        let machine = scratch.start(command.args(["--simulate", "machine.hal"]));
        let ready = if lines.is_empty() { "robot.status" } else { "remote.status" };
        until("the machine runs", || scratch.halcmd(&[ready]).status == Some(0));
        let mut command = scratch.command(&[], "halpanel");
        command.args(["--listen", "127.0.0.1:0", "--role", role, "--programs", "."]);
        command.args(["--address-file", "address", "--audit", "audit"]);
        let panel = scratch.start(&mut command);
        let mut printer = Self { panel, machine, scratch, port: 0 };
        printer.port = printer.listens();
        printer
    }

    /// Waits until the panel listens, and returns its port.
    fn listens(&mut self) -> u16 {
        until("the panel writes its address", || {
            let is_running = self.panel.is_running();
            assert!(is_running, "the panel has ended: {:?}", self.panel.said());
            is_address(&self.scratch.path().join("address"))
        });
        let address = self.address();
        let (_, rest) = address.split_once("127.0.0.1:").unwrap();
        rest.split_once('/').unwrap().0.parse().unwrap()
    }

    /// Ends the panel, and starts one whose sessions have another role, with further options.
    pub(super) fn restart(&mut self, role: &str, options: &[&str]) {
        self.panel.signal(Signal::TERM);
        assert!(self.panel.ended().is_some_and(|s| s.success()), "{:?}", self.panel.said());
        self.panel = panel(&self.scratch, role, options);
        self.port = self.listens();
    }

    /// Returns the process id of the panel.
    pub(super) fn panel_pid(&self) -> u32 {
        self.panel.pid()
    }

    /// Sends the panel a signal.
    pub(super) fn signal_panel(&self, signal: Signal) {
        self.panel.signal(signal);
    }

    /// Starts a panel after the one before was killed.
    pub(super) fn begin_again(&mut self, role: &str) {
        assert!(self.panel.ended().is_some(), "the panel still runs");
        // The one that was killed has left it.
        fs::remove_file(self.scratch.path().join("address")).unwrap();
        self.panel = panel(&self.scratch, role, &[]);
        self.port = self.listens();
    }

    /// Ends the machine, while the panel goes on.
    pub(super) fn end_machine(&mut self) {
        self.machine.signal(Signal::TERM);
        self.machine.ended().unwrap();
    }

    /// Starts the machine again after its end.
    pub(super) fn start_machine(&mut self) {
        self.machine = machine(&self.scratch, &["--simulate"]);
    }

    /// Returns what the panel has printed.
    pub(super) fn said(&self) -> String {
        self.panel.said().0
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

    /// Returns the port of the server.
    pub(super) const fn port(&self) -> u16 {
        self.port
    }

    /// Returns the headers of a request of this session.
    pub(super) fn headers(&self) -> String {
        let Self { port, cookie, key } = self;
        format!("Host: 127.0.0.1:{port}\r\nCookie: {cookie}\r\nX-Ferrule-Key: {key}\r\n")
    }

    /// Opens the socket and says hello.
    pub(super) fn socket(&self) -> Socket {
        let Self { port, cookie, key } = self;
        let headers = format!("Host: 127.0.0.1:{port}\r\nCookie: {cookie}\r\n");
        let mut socket = Socket::open(*port, "/api/v1/socket", &headers).unwrap();
        socket.send(&json!({ "type": "hello", "key": key }));
        let hello = socket.receive().unwrap();
        assert_eq!(hello["type"], "hello", "{hello}");
        // The panel knows of the permission after its first exchange with the engine.
        socket.wait(|m| m["panel"]["allow_motion"] == true).unwrap();
        socket
    }
}

impl Drop for Printer {
    fn drop(&mut self) {
        for program in [&mut self.panel, &mut self.machine] {
            if program.is_running() {
                program.signal(Signal::TERM);
            }
        }
        let (machine, panel) = (&mut self.machine, &mut self.panel);
        until("the programs end", || !machine.is_running() && !panel.is_running());
        if std::thread::panicking() {
            shown("the machine", machine);
            shown("the panel", panel);
        }
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

fn machine(scratch: &Scratch, clock: &[&str]) -> Running {
    let mut command = scratch.command(&[], "halrun");
    let machine = scratch.start(command.args(clock).args(["--headless", INI]));
    until("the machine runs", || scratch.halcmd(&["task.status"]).status == Some(0));
    machine
}

fn panel(scratch: &Scratch, role: &str, options: &[&str]) -> Running {
    let mut command = scratch.command(&[], "halpanel");
    command.args(["--listen", "127.0.0.1:0", "--role", role]);
    if scratch.path().join(INI).exists() {
        command.args(["--ini-file", INI]);
    }
    command.args(["--programs", "programs", "--address-file", "address", "--audit", "audit"]);
    command.args(options);
    scratch.start(&mut command)
}
