//! Programs that command a machine and are lost: what becomes of the jog or the job that each has begun.

use super::{
    cell,
    clients::{Panel, Python, Rsh},
    data::{Effect, Machine, machines, read},
    judge,
    motion::{self, Moving, Target},
    rig::Rig,
};
use hal_protocol::{Link as _, Reply, Request};
use hal_tests::{
    scratch::{Running, until},
    web::Socket,
};
use rustix::process::Signal;
use serde::Deserialize;
use serde_json::{Value, json};
use std::{collections::BTreeSet, fs, thread};

/// Folder of programs of a machine whose INI file names none.
const PROGRAMS: &str = "nc_files";
/// Cycles for which the machine is watched behind the loss: longer than a lease lasts, and than a brake.
const WATCHED: usize = 2500;
/// Cycles for which nothing may move behind that.
const STAYS: usize = 300;
/// Cycles for which a job that goes on is watched: longer than a lease lasts without beats.
const BEHIND_LEASE: usize = 1200;
/// Machine time between two beats of a program that is well, in milliseconds.
const FRESH: u32 = 15;

/// Motion that the program has begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    /// A jog that lasts while a button is held.
    Jog,
    /// A job whose start said what becomes of it.
    Job(&'static str),
}

impl Work {
    const ALL: [Self; 4] =
        [Self::Jog, Self::Job("hold"), Self::Job("continue"), Self::Job("abort")];

    const fn name(self) -> &'static str {
        match self {
            Self::Jog => "jog",
            Self::Job(on_loss) => on_loss,
        }
    }
}

/// The program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Who {
    /// A page of the panel, and the panel behind it.
    Page,
    Rsh,
    Python,
}

/// Way in which it is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
enum Way {
    /// The connection ends.
    #[serde(rename = "closed")]
    Closed,
    /// The program says nothing more.
    #[serde(rename = "silent")]
    Silent,
    #[serde(rename = "SIGTERM")]
    Term,
    #[serde(rename = "SIGKILL")]
    Kill,
    #[serde(rename = "SIGSTOP")]
    Stop,
}

/// A row of the table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    name: String,
    program: Who,
    way: Way,
    jog: String,
    hold: String,
    r#continue: String,
    abort: String,
}

impl Row {
    fn effect(&self, work: Work) -> Effect {
        Effect::parse(match work {
            Work::Jog => &self.jog,
            Work::Job("hold") => &self.hold,
            Work::Job("continue") => &self.r#continue,
            Work::Job(_) => &self.abort,
        })
    }
}

fn rows() -> Vec<Row> {
    let list = read("rules.toml").remove("lost").unwrap();
    list.try_into().unwrap_or_else(|e| panic!("rules.toml: {e}"))
}

/// A program that commands the machine.
enum Commander {
    Page(Panel, Option<Socket>),
    Rsh(Rsh),
    Python(Python),
}

/// Lets machine time pass, as slowly as the computer's, until something is answered.
fn meanwhile<T: Send>(rig: &mut Rig, ask: impl FnOnce() -> T + Send) -> T {
    thread::scope(|scope| {
        let asked = scope.spawn(ask);
        until("it answers", || {
            rig.run(1);
            asked.is_finished()
        });
        asked.join().unwrap()
    })
}

/// Gives a command of the panel; returns its refusal, if any.
fn by_page(rig: &mut Rig, socket: &mut Socket, name: &str, args: &Value) -> Option<String> {
    let reply = meanwhile(rig, || {
        let reply = socket.ask(json!({ "type": "command", "name": name, "args": args }));
        // The last reply to a start comes when the job has ended.
        if reply["pending"] != true || name == "run" {
            return reply;
        }
        let is_end = |m: &Value| m["id"] == reply["id"] && m["pending"] != true;
        socket.wait(is_end).unwrap_or_default()
    });
    (!reply["error"].is_null()).then(|| format!("panel {name}: {}", reply["error"]))
}

/// Returns the value of a pin.
fn number(rig: &mut Rig, name: &str) -> u32 {
    let reply = rig.client.call(Request::Get { name: name.to_owned() });
    let Ok(Reply::Value(value)) = reply else { panic!("{name}: {reply:?}") };
    value.to_string().parse().unwrap()
}

impl Commander {
    /// Starts a program that takes control.
    fn start(rig: &mut Rig, who: Who) -> Result<Self, String> {
        let mut commander = match who {
            Who::Page => {
                let panel = Panel::start(rig);
                let mut socket = panel.socket();
                let take = json!({ "type": "lease", "do": "take" });
                let taken = meanwhile(rig, || socket.ask(take));
                if !taken["error"].is_null() {
                    return Err(format!("the page takes control: {}", taken["error"]));
                }
                Self::Page(panel, Some(socket))
            }
            Who::Rsh => {
                let mut rsh = Rsh::start(rig);
                if let Some(why) = meanwhile(rig, || rsh.give("enable EMCTOO")) {
                    return Err(why);
                }
                Self::Rsh(rsh)
            }
            Who::Python => Self::Python(Python::start(rig)?),
        };
        commander.keep(rig);
        Ok(commander)
    }

    /// Lets the program say that it is well.
    fn keep(&mut self, rig: &mut Rig) {
        match self {
            Self::Page(_, Some(socket)) => until("the page answers pulses", || {
                // The page of its pins is read in each cycle; a refusal is an answer too.
                rig.run(1);
                socket.command("optional-stop", &json!({ "on": true }));
                let is_fresh = number(rig, "remote.pulse") <= number(rig, "remote.beat") + FRESH;
                is_fresh && rig.is("remote.permit")
            }),
            // It beats by itself.
            Self::Rsh(_) => {
                let lease = number(rig, "remote.lease");
                until("linuxcncrsh answers pulses", || {
                    rig.run(1);
                    let beat = Request::Command {
                        name: "remote.beat".to_owned(),
                        args: vec![format!("lease={lease}")],
                    };
                    let Ok(Reply::Answer(answer)) = rig.client.call(beat) else { return true };
                    let words = answer.lines.join(" ");
                    let word = |name: &str| -> u32 {
                        let found = words.split(' ').find_map(|w| w.strip_prefix(name));
                        found.unwrap_or_else(|| panic!("{words}")).parse().unwrap()
                    };
                    word("pulse=") <= word("beat=") + FRESH
                });
            }
            Self::Page(_, None) | Self::Python(_) => {}
        }
    }

    fn jog(&mut self, rig: &mut Rig, target: Target, velocity: f64) -> Option<String> {
        match self {
            Self::Page(_, socket) => {
                let args = match target {
                    Target::Joint(n) => json!({ "joint": n, "velocity": velocity }),
                    Target::Axis(letter) => json!({ "axis": letter, "velocity": velocity }),
                };
                by_page(rig, socket.as_mut()?, "jog", &args)
            }
            Self::Rsh(rsh) => {
                let (target, teleop) = match target {
                    Target::Joint(n) => (n.to_string(), "off"),
                    Target::Axis(letter) => (letter.to_ascii_uppercase().to_string(), "on"),
                };
                [format!("teleop_enable {teleop}"), format!("jog {target} {}", velocity * 60.0)]
                    .iter()
                    .find_map(|line| meanwhile(rig, || rsh.give(line)))
            }
            Self::Python(python) => {
                let words = match target {
                    Target::Joint(n) => format!("1 {n}"),
                    Target::Axis(letter) => format!("0 {}", "xyzabcuvw".find(letter)?),
                };
                python.order(&format!("jog {words} {velocity}"), &mut || rig.run(1))
            }
        }
    }

    fn run(&mut self, rig: &mut Rig, part: &str, on_loss: &str) -> Option<String> {
        match self {
            Self::Page(_, socket) => {
                let socket = socket.as_mut()?;
                [
                    ("mode", json!({ "mode": "auto" })),
                    ("open", json!({ "program": part })),
                    ("run", json!({ "on_loss": on_loss })),
                ]
                .iter()
                .find_map(|(name, args)| by_page(rig, socket, name, args))
            }
            Self::Rsh(rsh) => {
                // Who speaks lines opens programs of the machine's folder of programs.
                let text = rig.scratch.read(part);
                fs::create_dir_all(rig.scratch.path().join(PROGRAMS)).unwrap();
                rig.scratch.write(&format!("{PROGRAMS}/{part}"), &text);
                let open = format!("open {PROGRAMS}/{part}");
                ["mode auto".to_owned(), open, "run".to_owned()]
                    .iter()
                    .find_map(|line| meanwhile(rig, || rsh.give(line)))
            }
            Self::Python(python) => python.order(&format!("run {part}"), &mut || rig.run(1)),
        }
    }

    fn running(&mut self) -> &mut Running {
        match self {
            Self::Page(panel, _) => &mut panel.running,
            Self::Rsh(rsh) => &mut rsh.running,
            Self::Python(python) => &mut python.running,
        }
    }

    /// Loses the program.
    fn lose(&mut self, way: Way) {
        let signal = match (way, &mut *self) {
            (Way::Closed, Self::Page(_, socket)) => {
                *socket = None;
                return;
            }
            (Way::Closed, Self::Rsh(rsh)) => return rsh.hang_up(),
            (Way::Closed, Self::Python(_)) => panic!("rules.toml: it has no connection to close"),
            (Way::Silent, _) => return,
            (Way::Term, _) => Signal::TERM,
            (Way::Kill, _) => Signal::KILL,
            (Way::Stop, _) => Signal::STOP,
        };
        self.running().signal(signal);
        if way != Way::Stop {
            self.running().ended().unwrap();
        }
    }

    /// Ends the program; one that stands goes on first, for nothing may move by that.
    fn end(mut self, rig: &mut Rig, way: Way) {
        if way == Way::Stop {
            self.running().signal(Signal::CONT);
            rig.run(STAYS);
        }
        if self.running().is_running() {
            self.running().signal(Signal::KILL);
            self.running().ended();
        }
    }
}

/// Begins what the program will be lost in.
fn begin(rig: &mut Rig, by: &mut Commander, work: Work) -> Result<Moving, String> {
    rig.forget();
    let (refused, moving, circle) = match work {
        Work::Jog => {
            let (target, velocity, moving) = motion::jog_of(rig);
            (by.jog(rig, target, velocity), moving, None)
        }
        Work::Job(on_loss) => {
            let (part, moving, circle) = motion::part(rig);
            (by.run(rig, part, on_loss), moving, Some(circle))
        }
    };
    match refused {
        Some(why) => Err(why),
        None => motion::reach(rig, moving, circle.as_ref(), |rig| by.keep(rig)),
    }
}

/// Returns what can be begun on a machine by the program of a row.
fn works(machine: &Machine, row: &Row) -> Vec<Work> {
    let can = |work: &Work| {
        // A machine that is started from a script has no task, and no jobs.
        let has_job = *work == Work::Jog || machine.is_ini();
        let has_lease = row.program == Who::Python || machine.no_lease.is_none();
        has_job && has_lease && !matches!(row.effect(*work), Effect::Cannot(_))
    };
    Work::ALL.into_iter().filter(can).collect()
}

/// A machine, and where its axes were when it was homed.
struct Stage {
    rig: Rig,
    start: Vec<f64>,
}

impl Stage {
    fn set(machine: &Machine) -> Result<Self, String> {
        let mut rig = Rig::start(machine);
        cell::ready(&mut rig)?;
        let start = rig.last().axes.clone();
        Ok(Self { rig, start })
    }

    /// Moves back to the start: jobs that are cut at any place would lead out of the limits in the end.
    fn ready(&mut self) -> Result<(), String> {
        let Self { rig, start } = self;
        cell::ready(rig)?;
        if rig.last().axes != *start {
            let Machine { letters, path, .. } = &rig.machine;
            let place = letters.chars().zip(start).map(|(l, at)| format!(" {l}={at}"));
            let there =
                format!("motion.move{} velocity={}", place.collect::<String>(), path.velocity);
            rig.finish("motion.mode mode=coord", 100)?;
            rig.finish(&there, 60_000)?;
        }
        Ok(())
    }
}

/// Judges a cell; returns the cycles to the begin of braking.
fn judged(stage: &mut Stage, row: &Row, work: Work) -> Result<usize, String> {
    let effect = row.effect(work);
    stage.ready()?;
    let rig = &mut stage.rig;
    let mut by = Commander::start(rig, row.program)?;
    let begun = begin(rig, &mut by, work);
    rig.forget();
    let result = begun.and_then(|moving| {
        by.lose(row.way);
        let result = watch(rig, &effect, &moving);
        rig.forget();
        result
    });
    let rests = !matches!(effect, Effect::On);
    by.end(rig, row.way);
    let stays = if rests { judge::stays(&rig.seen, "behind the loss") } else { Ok(()) };
    cell::clear_all(rig)?;
    let cycles = result?;
    stays?;
    Ok(cycles)
}

/// Watches what follows a loss; returns the cycles to the begin of braking.
fn watch(rig: &mut Rig, effect: &Effect, moving: &Moving) -> Result<usize, String> {
    let limit = match effect {
        Effect::On => {
            rig.run(if moving.by_task { BEHIND_LEASE } else { STAYS });
            return judge::on(moving, &rig.seen).map(|_| 0);
        }
        // Only the computer's time says how soon the end of a program is known: machine time passes slowly.
        Effect::Ends => {
            until("the machine knows that the program has ended", || {
                rig.run(1);
                let speeds = moving.speeds(&rig.seen);
                speeds.last().is_some_and(|speed| *speed < moving.speed * 0.99)
            });
            rig.seen.drain(..rig.seen.len().saturating_sub(3));
            3
        }
        Effect::Brake(n) | Effect::Rest(n) => *n,
        other => panic!("rules.toml: {other:?}"),
    };
    rig.run(WATCHED);
    judge::brake(moving, &rig.seen, limit, false).map(|m| m.effect)
}

/// Walks the machines; without `whole`, each row once on each machine, with another kind of work on the next one.
fn walk(whole: bool) {
    let wanted = |name| std::env::var(name).unwrap_or_default();
    let (case, only) = (wanted("CASE"), wanted("CONTROL"));
    let (mut bad, mut good, mut slowest) = (Vec::new(), 0, 0);
    let rows = rows();
    for (m, machine) in machines().iter().enumerate().filter(|(_, m)| m.name.starts_with(&case)) {
        let mut stage: Option<Stage> = None;
        for (n, row) in rows.iter().enumerate().filter(|(_, r)| r.name.contains(&only)) {
            let works = works(machine, row);
            for (k, work) in works.iter().enumerate() {
                if !whole && !(m + n + k).is_multiple_of(works.len()) {
                    continue;
                }
                let there = stage.get_or_insert_with(|| Stage::set(machine).unwrap());
                let judged = judged(there, row, *work);
                if machine.needs_fresh || judged.is_err() {
                    stage = None;
                }
                match judged {
                    Ok(cycles) => (good, slowest) = (good + 1, slowest.max(cycles)),
                    Err(why) => {
                        bad.push(format!("{}, {}, {}: {why}", machine.name, row.name, work.name()));
                    }
                }
            }
        }
    }
    println!(
        "programs that are lost: {good} cells, {} bad; the slowest begins to brake after {slowest} cycles",
        bad.len()
    );
    assert!(bad.is_empty(), "{} cells are not as their rules say:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn every_program_that_is_lost_leaves_nothing_moving_that_should_stand() {
    walk(false);
}

#[test]
#[ignore = "takes minutes: cargo test -p hal-tests --test system stops::lost -- --ignored --nocapture"]
fn the_whole_table_of_lost_programs() {
    walk(true);
}

#[test]
fn every_program_and_way_has_a_row() {
    let rows = rows();
    let there: BTreeSet<_> = rows.iter().map(|r| format!("{:?} {:?}", r.program, r.way)).collect();
    for program in [Who::Page, Who::Rsh, Who::Python] {
        for way in [Way::Closed, Way::Silent, Way::Term, Way::Kill, Way::Stop] {
            // A program in Python has no connection of its own to close, and linuxcncrsh and Python say nothing by themselves.
            let is_none = matches!(
                (program, way),
                (Who::Python, Way::Closed | Way::Silent) | (Who::Rsh, Way::Silent)
            );
            let name = format!("{program:?} {way:?}");
            assert_eq!(there.contains(&name), !is_none, "{name}");
        }
    }
    for row in &rows {
        for work in Work::ALL {
            row.effect(work);
        }
    }
}
