//! The four stops of a machine, and the commands that they are on each machine.
//!
//! Stop has one address: whatever a stop control is, and wherever it is, it sends what [`Stops`] says and nothing else. No
//! stop is a command of the task, so all of them work on machines without one.

use crate::{CommandInfo, Request};
use std::fmt;

/// A stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stop {
    /// E-stop: the machine is off, and stays off until the e-stop is reset.
    Estop,
    /// The machine is switched off.
    Off,
    /// All motion brakes and ends; the machine stays on.
    Abort,
    /// All motion brakes; the path of a program rests until it is resumed.
    Pause,
}

impl Stop {
    /// All stops.
    pub const ALL: [Self; 4] = [Self::Estop, Self::Off, Self::Abort, Self::Pause];

    /// Returns the name of the stop.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Estop => "estop",
            Self::Off => "off",
            Self::Abort => "abort",
            Self::Pause => "pause",
        }
    }

    /// Returns the stop of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|stop| stop.name() == name)
    }
}

/// Something that moves: the command whose presence says so, and the command of each stop.
struct Mover {
    /// Command that begins its motion.
    begins: &'static str,
    /// Commands that stop it, in the order of [`Stop::ALL`].
    stops: [&'static str; 4],
}

/// Everything that can move in a machine.
const MOVERS: &[Mover] = &[
    Mover {
        begins: "motion.jog",
        stops: ["motion.disable", "motion.disable", "motion.abort", "motion.pause"],
    },
    // A robot behind a controller of its own.
    Mover { begins: "robot.run", stops: ["robot.stop", "robot.stop", "robot.stop", "robot.pause"] },
];

/// E-stop of the machine: it goes before everything else.
const ESTOP: &str = "iocontrol.estop";
/// Coolant and tool changer end with an abort. A task that runs a job does that itself.
const IO_ABORT: (&str, &str) = ("iocontrol.abort", "task.run");

/// The stops of a machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stops {
    /// Commands of each stop, in the order of [`Stop::ALL`] and of their sending.
    commands: [Vec<&'static str>; 4],
}

/// Commands that a machine which moves lacks, so that it cannot be stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing {
    /// The command that moves the machine.
    pub begins: String,
    /// Commands that would stop it and do not exist.
    pub commands: Vec<String>,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let commands = self.commands.join(", ");
        write!(f, "{} moves this machine, and nothing stops it: no command {commands}", self.begins)
    }
}

impl Stops {
    /// Finds the stops of a machine that offers these commands. A machine in which nothing moves has none but its e-stop.
    ///
    /// # Errors
    /// Something moves that these commands cannot stop.
    pub fn of(commands: &[CommandInfo]) -> Result<Self, Missing> {
        Self::with(&|name| commands.iter().any(|command| command.name == name))
    }

    fn with(has: &dyn Fn(&str) -> bool) -> Result<Self, Missing> {
        let mut found = Self::default();
        let [estop, ..] = &mut found.commands;
        if has(ESTOP) {
            estop.push(ESTOP);
        }
        for mover in MOVERS.iter().filter(|mover| has(mover.begins)) {
            let mut missing: Vec<String> =
                mover.stops.iter().filter(|stop| !has(stop)).map(ToString::to_string).collect();
            missing.dedup();
            if !missing.is_empty() {
                return Err(Missing { begins: mover.begins.to_owned(), commands: missing });
            }
            for (all, stop) in found.commands.iter_mut().zip(mover.stops) {
                all.push(stop);
            }
        }
        let [_, _, abort, _] = &mut found.commands;
        if has(IO_ABORT.0) && !has(IO_ABORT.1) {
            abort.push(IO_ABORT.0);
        }
        Ok(found)
    }

    /// Returns whether nothing in this machine can be stopped.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.commands.iter().all(Vec::is_empty)
    }

    /// Returns the names of the commands that a stop is, in the order of their sending.
    #[must_use]
    pub fn commands(&self, stop: Stop) -> &[&'static str] {
        let [estop, off, abort, pause] = &self.commands;
        match stop {
            Stop::Estop => estop,
            Stop::Off => off,
            Stop::Abort => abort,
            Stop::Pause => pause,
        }
    }

    /// Returns the requests that a stop is. All of them are sent, in this order, also behind one that is refused.
    pub fn requests(&self, stop: Stop) -> impl Iterator<Item = Request> {
        let request = |name: &&str| Request::Command { name: (*name).to_owned(), args: Vec::new() };
        self.commands(stop).iter().map(request)
    }
}

#[cfg(test)]
mod tests {
    use super::{Stop, Stops};

    fn check(has: &[&str], expected: [&[&str]; 4]) {
        let stops = Stops::with(&|name| has.contains(&name)).unwrap();
        assert_eq!(
            Stop::ALL.map(|stop| stops.commands(stop).to_vec()),
            expected.map(<[_]>::to_vec)
        );
    }

    const MOTION: [&str; 4] = ["motion.jog", "motion.disable", "motion.abort", "motion.pause"];
    const ROBOT: [&str; 3] = ["robot.run", "robot.stop", "robot.pause"];

    #[test]
    fn every_machine_that_moves_has_its_stops() {
        let (off, abort, pause) = (&["motion.disable"], &["motion.abort"], &["motion.pause"]);
        check(&MOTION, [off, off, abort, pause]);
        let io = ["iocontrol.estop", "iocontrol.abort"];
        check(
            &[&MOTION[..], &io].concat(),
            [
                &["iocontrol.estop", "motion.disable"],
                off,
                &["motion.abort", "iocontrol.abort"],
                pause,
            ],
        );
        // The task switches coolant off.
        check(
            &[&MOTION[..], &io, &["task.run"]].concat(),
            [&["iocontrol.estop", "motion.disable"], off, abort, pause],
        );
        let stop: &[&str] = &["robot.stop"];
        check(&ROBOT, [stop, stop, stop, &["robot.pause"]]);
        check(&["iocontrol.estop"], [&["iocontrol.estop"], &[], &[], &[]]);
        check(&["siggen.run"], [&[], &[], &[], &[]]);
    }

    #[test]
    fn a_machine_that_cannot_be_stopped_is_refused_by_name() {
        let stops = Stops::with(&|name| name == "motion.jog" || name == "motion.abort");
        let text = stops.unwrap_err().to_string();
        let expected = "motion.jog moves this machine, and nothing stops it: no command \
                        motion.disable, motion.pause";
        assert_eq!(text, expected);
    }

    #[test]
    fn names_of_stops_are_read_back() {
        for stop in Stop::ALL {
            assert_eq!(Stop::named(stop.name()), Some(stop));
        }
        assert_eq!(Stop::named("stop"), None);
    }
}
