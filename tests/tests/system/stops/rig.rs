//! A machine of `configs/` on a virtual clock that stands until it is run, and what every servo cycle shows of it.

use super::{clients::Clients, data::Machine};
use hal_protocol::{
    Client, Direction, Failure, Kind, Link as _, Place, Reply, Request, SampleSpec, Samples,
    TicketInfo, Value,
};
use hal_tests::{
    programs::root,
    scratch::{Running, Scratch, until},
};
use rustix::process::Signal;
use std::{collections::BTreeSet, fmt::Write as _};

/// Servo period of all machines, in nanoseconds.
pub(super) const PERIOD_NS: u32 = 1_000_000;
/// The same in seconds.
pub(super) const DT: f64 = 1e-3;
/// Cycles that the ring of samples holds.
const DEPTH: u32 = 8000;

/// Values after a cycle of the servo thread.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) ns: i64,
    /// Motion is enabled.
    pub(super) on: bool,
    /// An amplifier is enabled.
    pub(super) amplified: bool,
    /// Commands to the motors.
    pub(super) motors: Vec<f64>,
    /// Commanded places of the joints.
    pub(super) joints: Vec<f64>,
    /// Feedback of the motors.
    pub(super) feedback: Vec<f64>,
    /// Commanded places of the axes, of the machine's letters.
    pub(super) axes: Vec<f64>,
}

impl Frame {
    /// Returns the distance of the axes, in the space of all of them.
    pub(super) fn far(&self, other: &Self) -> f64 {
        let squares = self.axes.iter().zip(&other.axes).map(|(a, b)| (a - b) * (a - b));
        squares.sum::<f64>().sqrt()
    }
}

/// The machine.
pub(super) struct Rig {
    pub(super) machine: Machine,
    /// Programs beside it; they end before it.
    pub(super) clients: Clients,
    pub(super) client: Client,
    pub(super) scratch: Scratch,
    /// Names of all commands.
    pub(super) commands: BTreeSet<String>,
    samples: Samples,
    record: Vec<u64>,
    /// All cycles since the last `forget`.
    pub(super) seen: Vec<Frame>,
    /// Pins that have another value than their signals, with these.
    forced: Vec<(String, String, Option<String>)>,
    /// Reasons of refusals since the last `forget`.
    pub(super) refused: Vec<String>,
    /// True on the real clock.
    is_real: bool,
    pub(super) running: Running,
}

impl Rig {
    /// Starts a machine with its `halui` on a virtual clock that stands.
    pub(super) fn start(machine: &Machine) -> Self {
        Self::on(machine, &["--virtual", "--hold"])
    }

    /// Starts a machine with its `halui` on the real clock, with simulated hardware.
    pub(super) fn real(machine: &Machine) -> Self {
        Self::on(machine, &["--simulate"])
    }

    fn on(machine: &Machine, clock: &[&str]) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs").join(&machine.name));
        let script = &machine.script;
        let (file, text) = if machine.is_ini() {
            ("machine.ini", format!("#INCLUDE {script}\n[HAL]\nHALUI = halui\n"))
        } else {
            let letters = machine.letters.to_uppercase();
            ("machine.hal", format!("source {script}\nloadrt halui coordinates={letters}\n"))
        };
        scratch.write(file, text);
        let is_real = clock == ["--simulate"];
        if is_real && machine.is_ini() {
            scratch.write(script, without_following_error(&scratch.read(script)));
        }
        let (running, mut client) = start_on(&scratch, clock, file);
        let commands = commands(&mut client);
        let samples = client.sample(spec(machine)).unwrap();
        let mut rig = Self {
            machine: machine.clone(),
            clients: Clients::default(),
            client,
            scratch,
            commands,
            samples,
            record: Vec::new(),
            seen: Vec::new(),
            forced: Vec::new(),
            refused: Vec::new(),
            is_real,
            running,
        };
        rig.run(20);
        for line in machine.begin.clone() {
            let words: Vec<&str> = line.split(' ').collect();
            let ["setp", pin, value] = words[..] else { panic!("{line}") };
            rig.set(pin, value);
        }
        rig.run(20);
        rig
    }

    /// Returns whether the machine has a task.
    pub(super) fn has_task(&self) -> bool {
        self.commands.contains("task.run")
    }

    /// Lets so many servo cycles pass.
    pub(super) fn run(&mut self, cycles: usize) {
        if self.is_real {
            let end = self.seen.len() + cycles;
            until("cycles pass", || {
                self.look();
                end <= self.seen.len()
            });
            return;
        }
        self.client.call(Request::Run { ns: cycles as u64 * u64::from(PERIOD_NS) }).unwrap();
        self.look();
    }

    /// Forgets all cycles so far, also lost ones.
    pub(super) fn skip(&mut self) {
        while self.samples.take_bits(&mut self.record).is_some() {}
        self.run(1);
        self.forget();
    }

    fn look(&mut self) {
        let Machine { joints, letters, .. } = &self.machine;
        while let Some(stamp) = self.samples.take_bits(&mut self.record) {
            assert_eq!(stamp.lost, 0, "cycles were lost");
            let mut values = self.record.iter().copied();
            let on = values.next().unwrap() & 0xff != 0;
            let mut amplified = false;
            let (mut motors, mut places, mut feedback) = (Vec::new(), Vec::new(), Vec::new());
            for _ in 0..*joints {
                amplified |= values.next().unwrap() & 0xff != 0;
                motors.push(f64::from_bits(values.next().unwrap()));
                places.push(f64::from_bits(values.next().unwrap()));
                feedback.push(f64::from_bits(values.next().unwrap()));
            }
            let axes = values.map(f64::from_bits).collect::<Vec<_>>();
            assert_eq!(axes.len(), letters.len());
            let ns = stamp.time;
            self.seen.push(Frame { ns, on, amplified, motors, joints: places, feedback, axes });
        }
    }

    /// Returns the last cycle.
    pub(super) fn last(&self) -> &Frame {
        self.seen.last().unwrap()
    }

    /// Forgets all cycles but the last one.
    pub(super) fn forget(&mut self) {
        let keep = self.seen.len().saturating_sub(1);
        self.seen.drain(..keep);
        self.refused.clear();
    }

    /// Executes a line of a component's command; a refusal is kept.
    pub(super) fn give(&mut self, line: &str) -> bool {
        let mut words = words(line).into_iter();
        let name = words.next().unwrap();
        let answer = self.client.call(Request::Command { name, args: words.collect() });
        let refused = answer.err().map(|e| format!("{line}: {}", e.text));
        let is_ok = refused.is_none();
        self.refused.extend(refused);
        is_ok
    }

    /// Executes a line to its end, within so many cycles.
    pub(super) fn finish(&mut self, line: &str, cycles: usize) -> Result<(), String> {
        let mut words = words(line).into_iter();
        let name = words.next().unwrap();
        let answer = self.client.call(Request::Command { name, args: words.collect() });
        let id = match answer.map_err(|e| format!("{line}: {}", e.text))? {
            Reply::Answer(answer) => answer.ticket,
            other => panic!("{line}: {other:?}"),
        };
        let Some(id) = id else { return Ok(()) };
        for _ in 0..=cycles / 10 {
            match self.client.call(Request::Ticket { id, wait: false }) {
                Ok(Reply::Ticket(TicketInfo::Done)) => return Ok(()),
                Ok(Reply::Ticket(TicketInfo::Failed(why))) => return Err(format!("{line}: {why}")),
                Ok(Reply::Ticket(TicketInfo::Pending)) => self.run(10),
                Err(e) => return Err(format!("{line}: {}", e.text)),
                Ok(other) => panic!("{line}: {other:?}"),
            }
        }
        Err(format!("{line}: it has not ended after {cycles} cycles"))
    }

    /// Sets a pin or parameter.
    pub(super) fn set(&mut self, name: &str, value: &str) {
        let set = Request::Set { name: name.to_owned(), value: value.to_owned() };
        self.client.call(set).unwrap_or_else(|e| panic!("setp {name}: {e}"));
    }

    /// Returns whether a pin is TRUE.
    pub(super) fn is(&mut self, name: &str) -> bool {
        let get = self.client.call(Request::Get { name: name.to_owned() });
        matches!(get, Ok(Reply::Value(Value::Bit(true))))
    }

    /// Returns whether a signal changes within a second of looks.
    pub(super) fn changes(&mut self, signal: &str) -> bool {
        let get = |client: &mut Client| {
            client.call(Request::GetSignal { name: signal.to_owned() }).unwrap()
        };
        let first = get(&mut self.client);
        (0..1000).any(|_| {
            self.run(1);
            get(&mut self.client) != first
        })
    }

    /// Returns a number of the snapshot `motion.status`.
    pub(super) fn number(&mut self, field: &str) -> u64 {
        let reply = self.client.call(Request::Snapshot { name: "motion.status".to_owned() });
        let Ok(Reply::Snapshot(snapshot)) = reply else { panic!("{reply:?}") };
        let found = snapshot.info.fields.iter().position(|f| f.name == field);
        match found.map(|n| &snapshot.values[n][..]) {
            Some([Value::U64(n)]) => *n,
            other => panic!("motion.status has no number {field}: {other:?}"),
        }
    }

    /// Returns the names of the inputs that fit a pattern.
    pub(super) fn inputs(&mut self, pattern: &str) -> Vec<String> {
        let patterns = vec![pattern.to_owned()];
        let list = self.client.call(Request::List { kind: Kind::Pins, patterns, ty: None });
        let Ok(Reply::Items(items)) = list else { panic!("{list:?}") };
        let inputs = items.into_iter().filter(|i| i.direction != Direction::Out);
        inputs.map(|i| i.name).collect()
    }

    /// Sets the pins and parameters that fit a pattern, or the signals that they are linked to.
    pub(super) fn set_all(&mut self, pattern: &str, value: &str) {
        let mut list = |kind| {
            let patterns = vec![pattern.to_owned()];
            match self.client.call(Request::List { kind, patterns, ty: None }) {
                Ok(Reply::Items(items)) => items,
                other => panic!("{other:?}"),
            }
        };
        let items = [list(Kind::Pins), list(Kind::Params)];
        for item in items.into_iter().flatten() {
            let value = value.to_owned();
            let set = match item.signal {
                Some(name) => Request::SetSignal { name, value },
                None => Request::Set { name: item.name, value },
            };
            self.client.call(set).unwrap_or_else(|e| panic!("{pattern}: {e}"));
        }
    }

    /// Gives a pin another value, whatever it is linked to.
    pub(super) fn force(&mut self, pin: &str, value: Option<&str>) -> Result<(), String> {
        // A machine whose INI file is of the old style has the names of its joints from axes.
        let patterns = vec![pin.to_owned(), pin.replace("joint.", "axis.")];
        let list = self.client.call(Request::List { kind: Kind::Pins, patterns, ty: None });
        let Ok(Reply::Items(items)) = list else { panic!("{list:?}") };
        let found = items.into_iter().next().ok_or_else(|| format!("there is no pin {pin}"))?;
        if found.signal.is_some() {
            self.client.call(Request::Unlink { pin: pin.to_owned() }).unwrap();
        }
        if let Some(value) = value {
            self.set(pin, value);
        }
        self.forced.push((pin.to_owned(), found.value.to_string(), found.signal));
        Ok(())
    }

    /// Gives all pins that were forced their values again.
    pub(super) fn release(&mut self) {
        for (pin, value, signal) in std::mem::take(&mut self.forced) {
            // A signal without a writer takes the value of the pin.
            self.set(&pin, &value);
            if let Some(signal) = signal {
                self.client.call(Request::Link { pin, signal }).unwrap();
            }
        }
    }

    /// Returns the reports of the machine so far.
    pub(super) fn said(&self) -> String {
        self.running.said().1
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.clients = Clients::default();
        if self.running.is_running() {
            self.running.signal(Signal::TERM);
            self.running.ended();
        }
    }
}

/// Starts a machine by its file on a clock that stands, and connects to it.
pub(super) fn start(scratch: &Scratch, file: &str) -> (Running, Client) {
    start_on(scratch, &["--virtual", "--hold"], file)
}

fn start_on(scratch: &Scratch, clock: &[&str], file: &str) -> (Running, Client) {
    let mut command = scratch.command(&[], "halrun");
    command.args(clock).args(["--headless", file]);
    // On the real clock, a task without a folder of its own keeps its files there.
    command.env("XDG_STATE_HOME", scratch.path().join("state"));
    let running = scratch.start(&mut command).lasting("the machine");
    let place = Place::at(scratch.path().join(".run/ferrule"), "default").unwrap();
    let mut client = None;
    until("the machine runs", || {
        client = Client::connect(&place, "").ok();
        client.as_mut().is_some_and(is_ready)
    });
    (running, client.unwrap())
}

/// Returns an INI file whose joints may be 1000 units late: on the real clock, a busy computer makes simulated motors late.
fn without_following_error(ini: &str) -> String {
    let line = |line: &str| match line.split_once('=') {
        Some((name, _)) if ["FERROR", "MIN_FERROR"].contains(&name.trim()) => {
            format!("{name}= 1000\n")
        }
        _ => format!("{line}\n"),
    };
    ini.lines().map(line).collect()
}

fn commands(client: &mut Client) -> BTreeSet<String> {
    let list = client.call(Request::List { kind: Kind::Commands, patterns: vec![], ty: None });
    let Ok(Reply::Commands(list)) = list else { panic!("{list:?}") };
    list.into_iter().map(|c| c.name).collect()
}

/// Returns the commands of a folder of `configs`, from its script.
pub(super) fn commands_of(name: &str, script: &str) -> BTreeSet<String> {
    let scratch = Scratch::copy_of(&root().join("configs").join(name));
    let (running, mut client) = start(&scratch, script);
    let commands = commands(&mut client);
    running.signal(Signal::TERM);
    commands
}

/// Returns whether the machine's files have been executed.
fn is_ready(client: &mut Client) -> bool {
    let status: Result<Reply, Failure> = client.call(Request::Status);
    matches!(status, Ok(Reply::Status(status)) if status.running && !status.starting)
}

/// Returns the values that `Rig::look` reads.
fn spec(machine: &Machine) -> SampleSpec {
    let mut names = "motion.motion-enabled".to_owned();
    for n in 0..machine.joints {
        let joint = format!("joint.{n}");
        let ours = ["amp-enable-out", "motor-pos-cmd", "pos-cmd", "motor-pos-fb"];
        ours.iter().for_each(|pin| write!(names, " {joint}.{pin}").unwrap());
    }
    for letter in machine.letters.chars() {
        write!(names, " axis.{letter}.pos-cmd").unwrap();
    }
    SampleSpec {
        thread: Some("servo-thread".to_owned()),
        depth: DEPTH,
        names: names.split(' ').map(str::to_owned).collect(),
        ..SampleSpec::default()
    }
}

/// Returns the words of a line; a space within quotes ends none.
fn words(line: &str) -> Vec<String> {
    let mut is_quoted = false;
    let ends = |c: char| {
        is_quoted ^= c == '\'';
        c == ' ' && !is_quoted
    };
    line.split(ends).map(str::to_owned).collect()
}
