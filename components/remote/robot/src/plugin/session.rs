//! A connection, the program that is loaded, and its run.

use super::{cause::Cause, pins::SimInputs, shown::SessionState};
use crate::{
    Command, Driver, Event, Faults, Program, SimulatedLink, State, TcpLink, TcpOpening, Volume,
    Zero,
};
use hal_arm::Joints;
use std::{
    path::Path,
    sync::{Arc, Mutex, Weak},
    time::Duration,
};

/// Distance up to which a part zero is that of the load, where a run goes on in the middle, in mm: a person has taught it again.
const SAME: f64 = 0.5;
/// Longest wait for bytes in one step of the worker.
const TICK: Duration = Duration::from_millis(2);
/// Seed of the simulated faults.
const SEED: u64 = 1;

/// Connection.
enum Link {
    /// There is none.
    None,
    /// A thread connects.
    Opening(TcpOpening),
    Tcp(TcpLink),
    Simulated,
}

/// Connection, program and run.
pub(crate) struct Session {
    pub(crate) driver: Driver,
    link: Link,
    /// Thread that has begun to connect last; its flag is gone once it has ended.
    thread: Weak<Mutex<bool>>,
    /// Controller of the instance; `None` where it is a real one.
    pub(super) simulated: Option<SimulatedLink>,
    pub(super) program: Option<Arc<Program>>,
    volume: Volume,
    /// Reason of an end, where it is not the driver's.
    pub(super) cause: Option<Cause>,
    /// Text of the last problem.
    pub(super) problem: String,
    /// A command has paused the run.
    is_paused: bool,
    /// Number of the first line that is not known to be executed.
    pub(super) line: usize,
    pub(super) point: [f64; 3],
    pub(super) speed: f64,
    pub(super) joints: Joints,
    pub(super) zero: Option<Zero>,
}

impl Session {
    /// Returns a session without a connection. `timeout` is the time for the answer to a line, in seconds.
    pub(crate) fn new(volume: &Volume, timeout: f64, simulated: Option<Zero>) -> Self {
        Self {
            driver: Driver::new(timeout),
            link: Link::None,
            thread: Weak::new(),
            simulated: simulated.map(|zero| SimulatedLink::new(*volume, zero, SEED)),
            program: None,
            volume: *volume,
            cause: None,
            problem: String::new(),
            is_paused: false,
            line: 0,
            point: [0.0; 3],
            speed: 0.0,
            joints: [0.0; 6],
            zero: None,
        }
    }

    /// Returns the flag that gives up a connection that a thread makes.
    pub(crate) const fn opening(&self) -> Option<&Arc<Mutex<bool>>> {
        match &self.link {
            Link::Opening(opening) => Some(opening.flag()),
            _ => None,
        }
    }

    /// Returns the socket.
    pub(crate) const fn socket(&self) -> Option<&Arc<std::net::TcpStream>> {
        match &self.link {
            Link::Tcp(link) => Some(link.stream()),
            _ => None,
        }
    }

    /// Begins to connect.
    pub(crate) fn connect(
        &mut self,
        to: &str,
        longest: f64,
        sim: &SimInputs,
        now: f64,
    ) -> Result<(), String> {
        if self.state().is_connected() {
            return Err("the controller is connected already".to_owned());
        }
        if self.thread.strong_count() > 0 {
            return Err(
                "the connection before is being given up: wait until it has ended".to_owned()
            );
        }
        (self.cause, self.is_paused) = (None, false);
        self.problem.clear();
        self.driver.closed();
        let Some(link) = &mut self.simulated else {
            let opening = TcpOpening::begin(to, Duration::from_secs_f64(longest), TICK)?;
            self.thread = Arc::downgrade(opening.flag());
            self.link = Link::Opening(opening);
            return Ok(());
        };
        if sim.cut {
            return self.unreachable("the simulated link is down".to_owned());
        }
        if sim.zero.iter().all(|at| at.abs() < 1e6) {
            link.controller_mut().teach(sim.zero);
        }
        link.connect(&mut self.driver, now);
        self.link = Link::Simulated;
        Ok(())
    }

    fn unreachable(&mut self, why: String) -> Result<(), String> {
        self.cause = Some(Cause::Unreachable);
        self.problem.clone_from(&why);
        Err(why)
    }

    /// Gives up a connection that a thread makes: the robot would move.
    pub(crate) fn give_up_opening(&mut self, why: &str) {
        if self.opening().is_some() {
            self.link = Link::None;
            drop(self.unreachable(why.to_owned()));
        }
    }

    /// Advances the connection to a time. Returns whether bytes came, so that more may follow at once.
    pub(crate) fn exchange(&mut self, hold: bool, now: impl Fn() -> f64, sim: &SimInputs) -> bool {
        if self.is_paused || hold {
            // Before an answer comes, which sends the next line.
            self.driver.pause();
        }
        let mut came = false;
        match (&mut self.link, &mut self.simulated) {
            (Link::Opening(opening), _) => match opening.poll() {
                Some(Ok(link)) => {
                    self.driver.connected(now());
                    self.link = Link::Tcp(link);
                    came = true;
                }
                Some(Err(why)) => {
                    self.link = Link::None;
                    drop(self.unreachable(why));
                }
                None => {}
            },
            (Link::Tcp(link), _) => came = link.exchange(&mut self.driver, now),
            (_, Some(link)) => {
                let share = |x: f64| if x > 0.0 { f64::min(x, 1.0) } else { 0.0 };
                let delay = if sim.delay > 0.0 { f64::min(sim.delay, 3600.0) } else { 0.0 };
                let (lost, doubled) = (share(sim.lost), share(sim.doubled));
                link.controller_mut().set_faults(Faults { seed: 0, delay, lost, doubled });
                link.exchange(&mut self.driver, now());
                if sim.cut {
                    link.cut(&mut self.driver, now());
                }
            }
            (Link::None | Link::Simulated, None) => {}
        }
        self.events();
        came
    }

    /// Sends what a command has made, and ends a connection that is over.
    pub(crate) fn flush(&mut self, hold: bool, now: f64) {
        if self.is_paused || hold {
            self.driver.pause();
        } else {
            self.driver.resume(now);
        }
        match (&mut self.link, &mut self.simulated) {
            (Link::Tcp(link), _) => link.send(&mut self.driver),
            (_, Some(link)) => link.exchange(&mut self.driver, now),
            (Link::None | Link::Opening(_) | Link::Simulated, None) => {}
        }
        self.events();
        if !self.state().is_connected() {
            let is_lost = self.driver.state() == State::Closed && !matches!(self.link, Link::None);
            self.cause = self.cause.or_else(|| is_lost.then_some(Cause::Lost));
            self.link = Link::None;
        }
    }

    /// Takes the driver's news.
    fn events(&mut self) {
        for event in self.driver.events() {
            match event {
                Event::Zero(zero) => {
                    (self.zero, self.point, self.speed) = (Some(zero), [0.0; 3], 0.0);
                    self.follow();
                }
                Event::Executed(n, _) => self.executed(n),
                Event::Noise => {
                    "the controller has sent text that is no answer".clone_into(&mut self.problem);
                }
                Event::Sent(_) => {}
            }
        }
    }

    fn executed(&mut self, n: usize) {
        self.line = n + 1;
        let record = self.program.as_ref().and_then(|program| program.records.get(n));
        match record.map(|record| record.command) {
            Some(Command::Rapid(to) | Command::Cut(to)) => {
                self.point = to;
                self.follow();
            }
            Some(Command::Speed(speed)) => self.speed = speed,
            Some(Command::Start | Command::Exit) | None => {}
        }
    }

    /// Computes the joints for the point.
    fn follow(&mut self) {
        let Some(zero) = &self.zero else { return };
        let point = Volume::robot(zero, self.point);
        if let Some(joints) = self.volume.joints(point, &self.joints) {
            self.joints = joints;
        }
    }

    /// Loads a program for the part zero of this connection.
    pub(crate) fn load(&mut self, path: &Path, speed: f64, tool: f64) -> Result<&[String], String> {
        if self.state().runs() {
            return Err("a run is in progress".to_owned());
        }
        let zero = self.driver.zero().filter(|_| self.state() == SessionState::Ready);
        let zero = zero.ok_or("the part zero is not known: robot.connect first")?;
        self.program = None;
        self.line = 0;
        // A length that is refused must not reach the joints.
        let volume = Volume { tool, ..self.volume };
        match Program::read(path, &volume, &zero, speed) {
            Ok(program) => {
                self.volume = volume;
                self.problem.clear();
                Ok(&self.program.insert(Arc::new(program)).warnings)
            }
            Err(why) => {
                self.problem.clone_from(&why);
                Err(why)
            }
        }
    }

    /// Runs the program from a line.
    pub(crate) fn run(
        &mut self,
        from: usize,
        speed: f64,
        tool: f64,
        now: f64,
    ) -> Result<(), String> {
        if self.state().runs() {
            return Err("a run is in progress".to_owned());
        }
        let program = self.program.as_ref().ok_or("there is no program: robot.load first")?;
        if self.state() != SessionState::Ready {
            return Err("the controller does not wait for a run: robot.connect first".to_owned());
        }
        program.check_zero(
            &self.driver.zero().unwrap_or_default(),
            if from > 0 { SAME } else { 0.0 },
        )?;
        let changed = [
            (tool.to_bits() != program.tool.to_bits(), "robot.tool-length"),
            (speed.to_bits() != program.speed.to_bits(), "robot.cutting-speed"),
        ];
        if let Some((_, what)) = changed.iter().find(|(is, _)| *is) {
            return Err(format!(
                "{what} has changed since the program was loaded: robot.load again"
            ));
        }
        let lines = program.records.len();
        if from >= lines {
            return Err(format!("from={from}: the program has {lines} lines, from 0"));
        }
        program.check_approach(&self.volume, from)?;
        let before = program.records.iter().take(from).rev();
        let speed = before.map(|record| record.command).find_map(|command| match command {
            Command::Speed(speed) => Some(speed),
            _ => None,
        });
        self.speed = speed.unwrap_or(self.speed);
        (self.is_paused, self.line) = (false, from);
        self.driver.run(program.commands(), from, now);
        Ok(())
    }

    /// Pauses the run, or ends a pause.
    pub(crate) fn pause(&mut self, is_paused: bool) -> Result<(), String> {
        if !self.state().runs() {
            return Err("no run is in progress".to_owned());
        }
        self.is_paused = is_paused;
        Ok(())
    }

    /// Ends a connection while nothing runs.
    pub(crate) fn disconnect(&mut self, now: f64) -> Result<(), String> {
        if self.state().runs() {
            return Err("a run is in progress: robot.stop ends it".to_owned());
        }
        self.give_up(None, now);
        Ok(())
    }

    /// Stops the robot at once, and ends the connection.
    pub(crate) fn stop(&mut self, cause: Cause, now: f64) {
        self.give_up(Some(cause), now);
    }

    /// Notes that the instance has ended the connection, which is then not lost.
    pub(crate) fn end_with_instance(&mut self, now: f64) {
        self.stop(Cause::Instance, now);
        if self.cause() == Some(Cause::Lost) || !matches!(self.link, Link::None) {
            self.cause = Some(Cause::Instance);
        }
    }

    fn give_up(&mut self, cause: Option<Cause>, now: f64) {
        if !self.state().is_connected() {
            return;
        }
        self.cause = cause;
        self.driver.stop();
        // EXIT leaves before a new connection makes the driver forget it.
        match (&mut self.link, &mut self.simulated) {
            (Link::Tcp(link), _) => link.send(&mut self.driver),
            (Link::Simulated, Some(link)) => link.end(&mut self.driver, now),
            // A connection that a thread makes ends with EXIT where it is let go.
            (Link::None | Link::Opening(_) | Link::Simulated, _) => {}
        }
        self.link = Link::None;
        if cause.is_none() {
            self.driver.closed();
        }
    }
}
