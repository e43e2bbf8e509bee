//! Stops of a robot behind a controller of its own, which the virtual clock simulates.

use super::{
    clients::Panel,
    data::{Entry, RobotControl, entries, robot_controls},
    rig::start,
};
use hal_protocol::{Client, Kind, Link as _, Reply, Request, SampleSpec, Samples};
use hal_tests::{
    programs::root,
    scratch::{Running, Scratch},
};
use rustix::process::Signal;

/// Cycles of a second.
const SECOND: usize = 1000;
/// Cycles within which the robot begins a move that is long enough.
const BEGIN: usize = 60_000;
/// Cycles within which a move ends by itself.
const MOVE: usize = 20_000;
/// Values of a sample.
const NAMES: [&str; 4] = ["robot.sim.x", "robot.sim.y", "robot.sim.z", "robot.sim.moves"];

/// The robot and its controller.
struct Robot {
    client: Client,
    scratch: Scratch,
    samples: Samples,
    /// Place of the tool, and number of moves so far, of each cycle.
    seen: Vec<[f64; 4]>,
    forced: Vec<(String, String, Option<String>)>,
    running: Running,
}

impl Robot {
    fn start(name: &str, script: &str) -> Self {
        let scratch = Scratch::copy_of(&root().join("configs").join(name));
        let (running, mut client) = start(&scratch, script);
        let spec = SampleSpec {
            thread: Some("servo".to_owned()),
            depth: 30_000,
            names: NAMES.map(str::to_owned).to_vec(),
            ..SampleSpec::default()
        };
        let samples = client.sample(spec).unwrap();
        Self { client, scratch, samples, seen: Vec::new(), forced: Vec::new(), running }
    }

    fn run(&mut self, cycles: usize) {
        self.client.call(Request::Run { ns: cycles as u64 * 1_000_000 }).unwrap();
        let mut record = Vec::new();
        while self.samples.take_bits(&mut record).is_some() {
            let [x, y, z, moves] = record[..] else { panic!("{record:?}") };
            let [x, y, z] = [x, y, z].map(f64::from_bits);
            self.seen.push([x, y, z, f64::from((moves & 0xffff_ffff) as u32)]);
        }
    }

    fn give(&mut self, line: &str) -> Result<(), String> {
        let mut words = line.split(' ').map(str::to_owned);
        let name = words.next().unwrap();
        let answer = self.client.call(Request::Command { name, args: words.collect() });
        answer.map(drop).map_err(|e| format!("{line}: {}", e.text))
    }

    fn last(&self) -> [f64; 4] {
        *self.seen.last().unwrap()
    }

    /// Runs the program from its begin, into its second line in X and Y.
    fn begin(&mut self, program: &str) -> Result<(), String> {
        self.give("iocontrol.estop-reset")?;
        self.run(500);
        self.give("robot.connect")?;
        self.run(20 * SECOND);
        self.give(&format!("robot.load file={program}"))?;
        self.run(100);
        self.give("robot.run")?;
        self.seen.clear();
        self.run(10);
        for _ in 0..BEGIN / 10 {
            self.run(10);
            let [.., y, _, _] = self.last();
            // Its place does not change in each cycle.
            let before = self.seen.iter().rev().nth(10).copied();
            let moves = before.is_some_and(|before| before[..3] != self.last()[..3]);
            if 10.0 < y && moves {
                let keep = self.seen.len() - 1;
                self.seen.drain(..keep);
                return Ok(());
            }
        }
        Err("the robot does not begin".to_owned())
    }

    fn force(&mut self, pin: &str, value: &str) {
        let list = Request::List { kind: Kind::Pins, patterns: vec![pin.to_owned()], ty: None };
        let Ok(Reply::Items(items)) = self.client.call(list) else { panic!("{pin}") };
        let signal = items[0].signal.clone();
        if signal.is_some() {
            self.client.call(Request::Unlink { pin: pin.to_owned() }).unwrap();
        }
        let set = Request::Set { name: pin.to_owned(), value: value.to_owned() };
        self.client.call(set).unwrap();
        self.forced.push((pin.to_owned(), items[0].value.to_string(), signal));
    }

    fn release(&mut self) {
        for (pin, value, signal) in std::mem::take(&mut self.forced) {
            self.client.call(Request::Set { name: pin.clone(), value }).unwrap();
            if let Some(signal) = signal {
                self.client.call(Request::Link { pin, signal }).unwrap();
            }
        }
    }

    /// Judges a stop; the first cycle is the one before it.
    fn judge(&mut self, control: &RobotControl) -> Result<(usize, f64), String> {
        self.run(match control.cycles() {
            Some(_) => 5 * SECOND,
            None => MOVE,
        });
        let moves = |pair: &[[f64; 4]]| pair[0][..3] != pair[1][..3];
        let rest = self.seen.windows(2).rposition(moves).map_or(0, |n| n + 1);
        let way: f64 = self.seen.windows(2).map(|p| far(&p[0], &p[1])).sum();
        // The simulation counts moves that have ended.
        let ended = self.last()[3] - self.seen[0][3];
        let allowed = if control.cycles().is_none() { 1.0 } else { 0.0 };
        match control.cycles() {
            Some(most) if most < rest => {
                return Err(format!("it stands after {rest} cycles, at most {most}"));
            }
            None if rest + SECOND >= self.seen.len() => return Err("it does not stand".to_owned()),
            _ if allowed < ended => return Err(format!("{ended} moves end behind the stop")),
            _ => {}
        }
        // Nothing begins when the stop ends, and with a reset.
        self.release();
        drop(self.give("iocontrol.estop-reset"));
        let before = self.last();
        if control.cycles().is_some() {
            self.run(2 * SECOND);
            if self.last() != before {
                return Err("it moves after the end of the stop".to_owned());
            }
        }
        Ok((rest, way))
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.running.signal(Signal::TERM);
        self.running.ended();
    }
}

fn far(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (0..3).map(|n| (a[n] - b[n]).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn every_stop_stops_every_robot() {
    let mut bad = Vec::new();
    for (name, entry) in entries() {
        let Entry::Robot(script, program) = entry else { continue };
        for control in robot_controls() {
            let mut robot = Robot::start(&name, &script);
            let panel = control.panel.as_ref().map(|_| {
                let Robot { scratch, client, .. } = &mut robot;
                Panel::beside(scratch, false, &mut || {
                    client.call(Request::Run { ns: 10_000_000 }).unwrap();
                })
            });
            let judged = robot.begin(&program).and_then(|()| {
                if let Some(command) = &control.command {
                    robot.give(command)?;
                } else if let Some(force) = &control.force {
                    robot.force(&force.pin, &force.value);
                } else if let (Some(panel), Some(word)) = (&panel, &control.panel)
                    && let Some(why) = panel.give(word)
                {
                    return Err(why);
                }
                robot.judge(&control)
            });
            match judged {
                Ok((rest, way)) => println!("{name}, {}: {rest} cycles, {way:.3} mm", control.name),
                Err(why) => bad.push(format!("{name}, {}, program: {why}", control.name)),
            }
        }
    }
    assert!(bad.is_empty(), "{} cells are not as their rules say:\n{}", bad.len(), bad.join("\n"));
}
