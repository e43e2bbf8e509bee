//! The machine while it is commissioned: an instance of its own, which goes into e-stop when this program ends.

use super::{
    Stopped,
    entries::{JointEntries, Slow},
    fault,
    wires::Wires,
};
use crate::{
    beside,
    failure::Failure,
    options::Commission,
    start::{self, Running},
};
use hal_protocol::{Client, CommandLine, Link as _, Place, Reply, Request, TicketInfo};
use rustix::event::{Timespec, poll};
use std::{
    fs,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
};

/// Time between two looks at the machine.
const LOOK_NS: u32 = 5_000_000;
/// Looks of a second.
const LOOKS: f64 = 200.0;
/// Time in which a command that moves nothing is done, in seconds.
const SOON: f64 = 5.0;

/// Pin that says whether the e-stop chain is closed.
pub(crate) const CHAIN: &str = "iocontrol.0.emc-enable-in";

/// Reason for which the machine is off, with the joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    Estop,
    Following(usize),
    Low(usize),
    High(usize),
    Drive(usize),
    Unknown,
}

/// The running machine.
pub(crate) struct SlowMachine {
    running: Running,
    client: Client,
    /// True if the virtual clock stands until it is moved.
    is_held: bool,
    pub(crate) joints: Vec<JointEntries>,
    /// Speed of the spindle, in turns a minute.
    pub(crate) spindle: f64,
    file: PathBuf,
    ending: Arc<AtomicBool>,
}

impl SlowMachine {
    /// Starts the slow machine from a file beside its INI file, so that its other files are found.
    pub(crate) fn start(
        given: &Commission,
        slow: &Slow,
        ending: Arc<AtomicBool>,
    ) -> Result<Self, Failure> {
        let place =
            Place::find(given.instance.as_deref()).map_err(|why| Failure::Instance(why.into()))?;
        if Client::connect(&place, "").is_ok() {
            return Err(Failure::Runs { name: place.name().into() });
        }
        let stem = slow.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let file = slow.path.with_file_name(format!(".{stem}.commission.ini"));
        hal_output::write(&file, slow.text.as_bytes()).map_err(|e| Failure::file(&file, &e))?;
        let mut command = beside::command("halrun")?;
        command.arg("--headless");
        if given.is_virtual {
            command.args(["--virtual", "--hold"]);
        }
        if given.simulate {
            command.arg("--simulate");
        }
        if let Some(name) = &given.instance {
            command.arg("--instance").arg(name);
        }
        command.arg("--").arg(&file);
        let mut running = Running::begin("halrun", &mut command)?;
        let client = Self::connect(&place, &mut running, &ending);
        let client = match client {
            Ok(client) => client,
            Err(failure) => {
                drop(running.stop());
                drop(fs::remove_file(&file));
                return Err(failure);
            }
        };
        let joints = slow.joints.clone();
        let is_held = given.is_virtual;
        let spindle = slow.spindle;
        Ok(Self { running, client, is_held, joints, spindle, file, ending })
    }

    fn connect(
        place: &Place,
        running: &mut Running,
        ending: &AtomicBool,
    ) -> Result<Client, Failure> {
        if !start::come_up(place, running, ending)? {
            return Err(Failure::Lost("it has ended at its start".into()));
        }
        let mut client = Client::connect(place, "commission")
            .map_err(|f| Failure::Lost(f.to_string().into()))?;
        // However this program ends, the machine is in e-stop then.
        let line = |name: &str| CommandLine { name: name.to_owned(), args: Vec::new() };
        let commands = vec![line("iocontrol.estop")];
        client
            .call(Request::AtEnd { commands })
            .map_err(|f| Failure::Lost(f.to_string().into()))?;
        Ok(client)
    }

    /// Ends the machine.
    pub(crate) fn stop(mut self) -> Result<(), Failure> {
        drop(self.begin("iocontrol.estop", &[]));
        drop(self.pass(0.1));
        drop(self.client);
        let ended = self.running.stop();
        drop(fs::remove_file(&self.file));
        ended.map(drop)
    }

    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        self.client.call(request).map_err(|f| Failure::Lost(f.to_string().into()))
    }

    /// Lets machine time pass, in seconds. Without movement nothing is watched but the person's wish to end.
    pub(crate) fn pass(&mut self, seconds: f64) -> Result<(), Stopped> {
        let mut left = (seconds * LOOKS).ceil();
        while left > 0.0 {
            self.look()?;
            left -= 1.0;
        }
        Ok(())
    }

    /// Lets the time of a look pass.
    fn look(&mut self) -> Result<(), Stopped> {
        if self.is_held {
            self.call(Request::Run { ns: u64::from(LOOK_NS) })?;
        } else {
            let time = Timespec { tv_sec: 0, tv_nsec: i64::from(LOOK_NS) };
            poll(&mut [], Some(&time)).unwrap_or_default();
        }
        if self.ending.load(Relaxed) { Err(Stopped::Ended) } else { Ok(()) }
    }

    /// Returns the value of a pin as a number.
    pub(crate) fn value(&mut self, name: &str) -> Result<f64, Failure> {
        match self.call(Request::Get { name: name.to_owned() })? {
            Reply::Value(value) => Ok(value.number()),
            _ => Err(Failure::Lost(format!("{name} has no value").into())),
        }
    }

    /// Returns whether a pin is TRUE.
    pub(crate) fn is(&mut self, name: &str) -> Result<bool, Failure> {
        Ok(self.value(name)? != 0.0)
    }

    /// Returns the pins with their signals.
    pub(crate) fn wires(&mut self) -> Result<Wires, Failure> {
        let request =
            Request::List { kind: hal_protocol::Kind::Pins, patterns: Vec::new(), ty: None };
        match self.call(request)? {
            Reply::Items(items) => Ok(Wires::new(items)),
            _ => Err(Failure::Lost("it lists no pins".into())),
        }
    }

    /// Gives a command; returns its ticket, if it takes time.
    fn begin(&mut self, name: &str, args: &[String]) -> Result<Option<u64>, Stopped> {
        let request = Request::Command { name: name.to_owned(), args: args.to_vec() };
        match self.client.call(request) {
            Ok(Reply::Answer(answer)) => Ok(answer.ticket),
            Ok(_) => Ok(None),
            Err(failure) => Err(Stopped::Aborted(format!("{name}: {failure}"))),
        }
    }

    /// Gives a command that moves nothing, and waits for its end.
    pub(crate) fn order(&mut self, name: &str, args: &[String]) -> Result<(), Stopped> {
        let ticket = self.begin(name, args)?;
        self.until_done(name, ticket, SOON, &mut |_| Ok(()))
    }

    /// Gives a command that moves, and watches until it is done: the e-stop, a machine that goes off, and the time end it.
    pub(crate) fn moving(
        &mut self,
        name: &str,
        args: &[String],
        seconds: f64,
        each: &mut dyn FnMut(&mut Self) -> Result<(), Stopped>,
    ) -> Result<(), Stopped> {
        let ticket = self.begin(name, args)?;
        self.until_done(name, ticket, seconds, &mut |machine| {
            machine.watched()?;
            each(machine)
        })
    }

    fn until_done(
        &mut self,
        name: &str,
        ticket: Option<u64>,
        seconds: f64,
        each: &mut dyn FnMut(&mut Self) -> Result<(), Stopped>,
    ) -> Result<(), Stopped> {
        let Some(id) = ticket else { return self.look() };
        let mut left = (seconds * LOOKS).ceil();
        while left > 0.0 {
            let state = self.call(Request::Ticket { id, wait: false })?;
            each(self)?;
            match state {
                Reply::Ticket(TicketInfo::Pending) => {}
                Reply::Ticket(TicketInfo::Failed(why)) => {
                    return Err(Stopped::Aborted(format!("{name}: {why}")));
                }
                _ => return Ok(()),
            }
            self.look()?;
            left -= 1.0;
        }
        self.rest();
        Err(Stopped::Aborted(format!("{name} was not done within {seconds:.0} s")))
    }

    /// Watches until something is so: the e-stop, a machine that goes off, and the time end it.
    pub(crate) fn until(
        &mut self,
        what: &str,
        seconds: f64,
        is_so: &mut dyn FnMut(&mut Self) -> Result<bool, Stopped>,
    ) -> Result<(), Stopped> {
        let mut left = (seconds * LOOKS).ceil();
        while left > 0.0 {
            self.look()?;
            self.watched()?;
            if is_so(self)? {
                return Ok(());
            }
            left -= 1.0;
        }
        self.rest();
        Err(Stopped::Aborted(format!("{what}: not within {seconds:.0} s")))
    }

    /// Lets time pass while something turns: the e-stop and a machine that goes off end it.
    pub(crate) fn pass_watched(&mut self, seconds: f64) -> Result<(), Stopped> {
        let mut left = (seconds * LOOKS).ceil();
        while left > 0.0 {
            self.look()?;
            self.watched()?;
            left -= 1.0;
        }
        Ok(())
    }

    /// Returns an error if the e-stop has come or the machine has gone off.
    fn watched(&mut self) -> Result<(), Stopped> {
        if self.is(CHAIN)? && self.is("motion.motion-enabled")? {
            return Ok(());
        }
        Err(Stopped::Off(self.cause()?))
    }

    /// Returns why the machine is off.
    pub(crate) fn cause(&mut self) -> Result<Cause, Failure> {
        if !self.is(CHAIN)? {
            return Ok(Cause::Estop);
        }
        // The joint that switched the machine off, then any with a switch or a fault.
        for is_own in [true, false] {
            for n in 0..self.joints.len() {
                if is_own && !self.is(&format!("joint.{n}.error"))? {
                    continue;
                }
                for (pin, cause) in [
                    ("amp-fault-in", Cause::Drive(n)),
                    ("neg-hard-limit", Cause::Low(n)),
                    ("pos-hard-limit", Cause::High(n)),
                ] {
                    if self.is(&format!("joint.{n}.{pin}"))? {
                        return Ok(cause);
                    }
                }
                if is_own {
                    return Ok(Cause::Following(n));
                }
            }
        }
        Ok(Cause::Unknown)
    }

    /// Returns the end of a step in which the machine went off as a fault with the wires to look at.
    pub(crate) fn explained(&mut self, stopped: Stopped) -> Stopped {
        let Stopped::Off(cause) = stopped else { return stopped };
        let wires = match self.wires() {
            Ok(wires) => wires,
            Err(failure) => return failure.into(),
        };
        let name = |n: usize| self.joints.get(n).map_or("", |joint| joint.name.as_str());
        let pin = |n: usize, end: &str| wires.of(&format!("joint.{n}.{end}"));
        match cause {
            Cause::Estop => Stopped::Aborted("the e-stop was pressed".to_owned()),
            Cause::Unknown => fault(
                "the machine went off, and no joint says why",
                format!("look at what switches it off: {}", wires.of("motion.enable")),
            ),
            Cause::Following(n) => fault(
                format!(
                    "{}: it does not follow its command (following error, [JOINT_{n}]FERROR)",
                    name(n)
                ),
                format!(
                    "exchange A and B of its encoder, or mend the wire of the encoder or the power of the motor: {}; {}",
                    pin(n, "motor-pos-fb"),
                    wires.outputs(n)
                ),
            ),
            Cause::Low(n) => fault(
                format!("{}: limit switch at its low end", name(n)),
                format!(
                    "free the joint by hand; if it was not there, look at {}",
                    pin(n, "neg-lim-sw-in")
                ),
            ),
            Cause::High(n) => fault(
                format!("{}: limit switch at its high end", name(n)),
                format!(
                    "free the joint by hand; if it was not there, look at {}",
                    pin(n, "pos-lim-sw-in")
                ),
            ),
            Cause::Drive(n) => fault(
                format!("{}: fault of the drive", name(n)),
                format!(
                    "look at the drive; a line of the wrong sense is read as the other of pin-NN-in and pin-NN-in-not: {}",
                    pin(n, "amp-fault-in")
                ),
            ),
        }
    }

    /// Brings everything to rest and switches the machine off.
    pub(crate) fn rest(&mut self) {
        for name in ["motion.abort", "motion.disable"] {
            // A machine that does not answer is in e-stop: the engine gives that command when this client is gone.
            drop(self.begin(name, &[]));
        }
        for _ in 0..40 {
            drop(self.look());
        }
    }
}
