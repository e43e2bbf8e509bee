//! The plugin in machines of all kinds, and wiring that the machine's files have made.

use super::{
    CONTROLLER, Edit, Ini, ItemInfo, JOB, Kind, Link, NoOrders, NoRemote, Reply, Request,
    ThreadInfo, arrange, join, orders, place_of, reaches, runs_before, wire,
};
use hal_protocol::{
    CommandInfo, ComponentInfo, ComponentState, Direction, Failure, Unlisted, Value,
};

fn pin(owner: u32, name: &str, direction: Direction, signal: &str) -> ItemInfo {
    ItemInfo {
        owner,
        owner_name: String::new(),
        direction,
        value: Value::Bit(false),
        name: name.to_owned(),
        original: None,
        signal: Some(signal.to_owned()),
        doc: String::new(),
    }
}

#[test]
fn a_stop_reaches_motion_through_parts_or_is_refused() {
    let (i, o) = (Direction::In, Direction::Out);
    let mut pins = vec![
        pin(1, "remote.jog-stop", o, "a"),
        pin(2, "or2.0.in0", i, "a"),
        pin(2, "or2.0.out", o, "b"),
        pin(2, "or2.1.out", o, "c"),
        pin(3, "motion.jog-stop", i, "b"),
        pin(3, "motion.other", i, "a"),
        pin(3, "motion.out", o, "d"),
    ];
    assert!(reaches(&pins, "a", "b", "motion.jog-stop"));
    assert!(!reaches(&pins, "a", "c", "motion.jog-stop"), "another part of the component");
    assert!(!reaches(&pins, "a", "d", "motion.jog-stop"), "motion joins nothing");
    let made = |pins: &[ItemInfo]| wire(pins, "remote.jog-stop", "s", "motion.jog-stop");
    assert_eq!(made(&pins), Ok(None));
    // Both are linked, and nothing joins them.
    pins[4].signal = Some("c".to_owned());
    made(&pins).unwrap_err();
}

#[test]
fn a_pin_is_read_beside_others() {
    let pins = [pin(1, "task.job", Direction::Out, "busy")];
    let link = Request::Net { signal: "busy".to_owned(), pins: vec!["remote.job".to_owned()] };
    assert_eq!(join(&pins, JOB), Ok(Some(link)));
    // Another signal at the pin shows something else.
    let pins = [pins[0].clone(), pin(2, "remote.job", Direction::In, "other")];
    join(&pins, JOB).unwrap_err();
}

#[test]
fn the_function_runs_before_the_controller() {
    for (functs, right) in [
        (&["remote", "motion-controller"][..], true),
        (&["motion-controller", "remote"], false),
        (&["remote"], false),
    ] {
        let functs: Vec<String> = functs.iter().map(|f| (*f).to_owned()).collect();
        assert_eq!(runs_before(&functs, CONTROLLER), right, "{functs:?}");
    }
}

/// A machine, as far as this crate asks for it, and what it was asked to do.
#[derive(Default)]
struct Fake {
    commands: &'static [&'static str],
    /// Functions of each thread.
    threads: &'static [&'static [&'static str]],
    /// Pins, each with its signal.
    pins: Vec<ItemInfo>,
    /// The plugin is loaded.
    is_loaded: bool,
    /// The engine refuses the changes.
    refuses: bool,
    /// Kind of list that the engine has not.
    lacks: Option<Kind>,
    applied: Vec<Edit>,
}

fn thread(functs: &[&str]) -> ThreadInfo {
    let name = if functs == ["fast"] { "base-thread" } else { "servo-thread" }.to_owned();
    let functs = functs.iter().map(|f| (*f).to_owned()).collect();
    ThreadInfo { name, functs, ..ThreadInfo::default() }
}

impl Link for Fake {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        Ok(match request {
            Request::List { kind, .. } if self.lacks == Some(kind) => Reply::Done,
            Request::List { kind: Kind::Commands, .. } => {
                let info = |name: &&str| CommandInfo {
                    name: (*name).to_owned(),
                    doc: String::new(),
                    args: Vec::new(),
                };
                Reply::Commands(self.commands.iter().map(info).collect())
            }
            Request::List { kind: Kind::Threads, .. } => {
                Reply::Threads(self.threads.iter().map(|functs| thread(functs)).collect())
            }
            Request::List { kind: Kind::Pins, .. } => Reply::Items(self.pins.clone()),
            Request::Component { name } if name == "remote" => {
                let info = ComponentInfo {
                    id: 1,
                    name,
                    realtime: true,
                    pid: None,
                    state: ComponentState::Ready,
                    args: None,
                    foreign: None,
                };
                Reply::Components(if self.is_loaded { vec![info] } else { Vec::new() })
            }
            Request::Apply { files, edits, dry: false } => {
                assert_eq!(files, ["program"]);
                self.applied = edits;
                match self.refuses {
                    true => Reply::Refused { edit: 0, failure: Failure::new(-22, "it is full") },
                    false => Reply::Done,
                }
            }
            other => return Err(Failure::new(-38, format!("not known here: {other:?}"))),
        })
    }
}

const MOTION: &[&str] = &["motion.estop", "motion.off", "motion.abort", "motion.pause"];

/// Returns what the machine was asked to do, in the words of a script.
fn asked(machine: &mut Fake, ini: &str) -> Result<String, NoRemote> {
    let ini = Ini::parse("a.ini", ini.as_bytes()).unwrap();
    arrange(machine, Some(&ini), "program")?;
    let word = |edit: &Edit| match &edit.request {
        Request::Load { module, args } => {
            [&["loadrt", module], args.iter().map(String::as_str).collect::<Vec<_>>().as_slice()]
                .concat()
                .join(" ")
        }
        Request::AddFunct { funct, thread, position, init: false } => {
            format!("addf {funct} {thread} {position}")
        }
        Request::Net { signal, pins } => format!("net {signal} {}", pins.join(" ")),
        other => format!("{other:?}"),
    };
    let lines = machine.applied.iter().map(|edit| format!("{}: {}", edit.line, word(edit)));
    Ok(lines.collect::<Vec<_>>().join("\n"))
}

fn bits(rows: &[(&str, Option<&str>)]) -> Vec<ItemInfo> {
    let one = |(name, signal): &(&str, Option<&str>)| ItemInfo {
        signal: signal.map(str::to_owned),
        ..pin(7, name, Direction::Out, "")
    };
    rows.iter().map(one).collect()
}

#[test]
fn the_plugin_is_loaded_and_wired_as_the_machine_needs_it() {
    let motion = Fake { threads: &[&["fast"], &["a", CONTROLLER]], ..Fake::default() };
    let rows: Vec<(Fake, &str, &str)> = vec![
        (
            motion,
            "[REMOTE]\nON_LOSS = HOLD\nJOG_TIMEOUT = 0.2\n",
            "1: loadrt remote jog_timeout=0.2 on_loss=hold\n\
             2: addf remote servo-thread 2\n\
             3: net remote-jog-stop remote.jog-stop motion.jog-stop\n\
             4: net remote-hold remote.hold motion.feed-inhibit",
        ),
        (
            Fake {
                threads: &[&[CONTROLLER]],
                pins: bits(&[("task.job", None)]),
                ..Fake::default()
            },
            "[REMOTE]\nLEASE_TIMEOUT = 2\n",
            "1: loadrt remote lease_timeout=2\n\
             2: addf remote servo-thread 1\n\
             3: net remote-jog-stop remote.jog-stop motion.jog-stop\n\
             4: net remote-hold remote.hold motion.feed-inhibit\n\
             5: net remote-abort remote.abort task.abort\n\
             6: net remote-job task.job remote.job",
        ),
        (
            // A robot behind its own controller, with another's job.
            Fake {
                threads: &[&["robot"]],
                pins: bits(&[("robot.busy", Some("works"))]),
                ..Fake::default()
            },
            "",
            "1: loadrt remote motion=0\n\
             2: addf remote servo-thread 1\n\
             3: net remote-hold remote.hold robot.hold\n\
             4: net remote-abort remote.abort robot.stop\n\
             5: net works remote.job",
        ),
        (
            // Motion comes before a robot.
            Fake { threads: &[&["robot", CONTROLLER]], ..Fake::default() },
            "",
            "1: loadrt remote\n\
             2: addf remote servo-thread 2\n\
             3: net remote-jog-stop remote.jog-stop motion.jog-stop\n\
             4: net remote-hold remote.hold motion.feed-inhibit",
        ),
        (
            // The files have loaded it and wired one pin.
            Fake {
                threads: &[&["remote", CONTROLLER]],
                pins: bits(&[("remote.hold", Some("h")), ("motion.feed-inhibit", Some("h"))]),
                is_loaded: true,
                ..Fake::default()
            },
            "",
            "1: net remote-jog-stop remote.jog-stop motion.jog-stop",
        ),
        (
            // They have done everything: nothing is asked for.
            Fake {
                threads: &[&["remote", "x", CONTROLLER]],
                pins: bits(&[
                    ("remote.jog-stop", Some("j")),
                    ("motion.jog-stop", Some("j")),
                    ("remote.hold", Some("h")),
                    ("motion.feed-inhibit", Some("h")),
                ]),
                is_loaded: true,
                refuses: true,
                ..Fake::default()
            },
            "",
            "",
        ),
    ];
    for (mut machine, ini, expected) in rows {
        assert_eq!(asked(&mut machine, ini), Ok(expected.to_owned()));
    }
}

#[test]
fn a_machine_that_cannot_be_stopped_or_wired_is_refused_by_name() {
    let controller: &[&[&str]] = &[&[CONTROLLER]];
    let rows = [
        (
            Fake { commands: &["motion.jog"], threads: controller, ..Fake::default() },
            "motion.jog moves this machine, and nothing stops it: no command ",
        ),
        (Fake { lacks: Some(Kind::Commands), ..Fake::default() }, "the engine lists no commands"),
        (Fake { lacks: Some(Kind::Threads), ..Fake::default() }, "the engine lists no threads"),
        (
            Fake { lacks: Some(Kind::Pins), threads: controller, ..Fake::default() },
            "the engine lists no pins",
        ),
        (
            Fake { threads: &[&["other"]], ..Fake::default() },
            "no thread runs motion-controller or robot: this machine has no motion that could be stopped",
        ),
        (
            Fake { threads: &[&[CONTROLLER, "remote"]], is_loaded: true, ..Fake::default() },
            "function remote is not in the thread of motion-controller before it: motion would see a stop a cycle \
             late, or never; addf it there, before program is started",
        ),
        (
            Fake { threads: &[&["remote"], &[CONTROLLER]], is_loaded: true, ..Fake::default() },
            "function remote is not in the thread of motion-controller before it",
        ),
        (
            Fake {
                threads: controller,
                pins: bits(&[("motion.jog-stop", Some("mine"))]),
                ..Fake::default()
            },
            "motion.jog-stop is linked, and remote.jog-stop does not reach it: join both in the machine's HAL file, as \
             with loadrt or2",
        ),
        (
            Fake { threads: controller, refuses: true, ..Fake::default() },
            "the plugin remote cannot be used: it is full",
        ),
    ];
    for (mut machine, expected) in rows {
        let error = asked(&mut machine, "").unwrap_err().to_string();
        assert!(error.starts_with(expected), "{error}");
        let done: Vec<_> = machine.applied.iter().filter(|_| !machine.refuses).collect();
        assert!(done.is_empty(), "{expected}: {done:?}");
    }
}

#[test]
fn the_orders_are_those_of_the_machine() {
    let mut machine = Fake { commands: MOTION, ..Fake::default() };
    assert!(orders(&mut machine).unwrap().has("motion.abort"));
    machine.lacks = Some(Kind::Commands);
    let why = orders(&mut machine).unwrap_err();
    assert!(matches!(&why, NoOrders::Unlisted(Unlisted::NoList)), "{why:?}");
    assert_eq!(why.to_string(), "the engine lists no commands");
    let engine = NoOrders::Engine(Failure::new(-2, "there is no engine"));
    assert_eq!(engine.to_string(), "there is no engine");
}

#[test]
fn the_controller_has_a_place_in_its_thread() {
    let threads = [thread(&["fast"]), thread(&["a", "b", CONTROLLER])];
    assert_eq!(place_of(&threads, CONTROLLER), Some(("servo-thread".to_owned(), 3)));
    assert_eq!(place_of(&threads, "fast"), Some(("base-thread".to_owned(), 1)));
    assert_eq!(place_of(&threads, "robot"), None);
}
