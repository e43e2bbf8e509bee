//! The table of commands.

use super::{Action, Args, Effect, Input, ROWS};
use crate::{
    engine::{
        Ending,
        tests::{ALL, orders},
    },
    session::Role,
};
use hal_protocol::Request;
use serde_json::{Value as Json, json};

/// The rows of the table of commands in the document.
fn documented() -> Vec<(String, String, bool)> {
    let text = include_str!("../../API.md");
    let table = text.split("| command | arguments |").nth(1).unwrap();
    let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
    rows.flat_map(|row| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let role = cells[3].split(',').next().unwrap().to_owned();
        let lease = cells[4] == "yes";
        let names = cells[1].split(", ").map(|name| name.trim_matches('`').to_owned());
        names.map(move |name| (name, role.clone(), lease)).collect::<Vec<_>>()
    })
    .collect()
}

#[test]
fn the_document_states_each_command_with_its_role_and_lease() {
    let mut documented = documented();
    let mut own: Vec<_> = ROWS
        .iter()
        .map(|row| {
            (row.name.to_owned(), format!("{:?}", row.role).to_lowercase(), row.needs_lease())
        })
        .collect();
    documented.sort();
    own.sort();
    assert_eq!(own, documented);
}

#[test]
fn only_what_ends_motion_needs_no_lease() {
    let free: Vec<&str> =
        ROWS.iter().filter(|row| !row.needs_lease()).map(|row| row.name).collect();
    assert_eq!(free, ["abort", "estop", "off", "pause", "jog-stop", "robot-stop", "robot-pause"]);
    let viewers: Vec<&str> =
        ROWS.iter().filter(|row| row.role == Role::Viewer).map(|row| row.name).collect();
    assert_eq!(viewers, ["abort", "estop", "robot-stop"]);
}

/// Commands of a machine without a task.
const WITHOUT: &[&str] = &[
    "motion.jog",
    "motion.disable",
    "motion.abort",
    "motion.pause",
    "motion.enable",
    "iocontrol.estop",
    "iocontrol.abort",
    "iocontrol.estop-reset",
];

/// Returns the engine's command for these arguments.
fn sent(name: &str, args: &Json, is_inch: bool) -> Result<String, String> {
    asked(name, args, is_inch, true)
}

fn asked(name: &str, args: &Json, is_inch: bool, has_task: bool) -> Result<String, String> {
    let args: Args = serde_json::from_value(args.clone()).unwrap();
    let orders = orders(if has_task { ALL } else { WITHOUT });
    let given = Input { args: &args, orders: &orders, is_inch };
    let requests = match super::find(name).map_err(|e| e.text)?.action {
        Action::Engine(requests) => requests(&given),
        Action::Jog => given.jog(7),
        Action::EndJogs => given.plain("motion.jog-stop"),
        Action::Stop(Ending::Machine(stop)) => {
            given.only(&[]).map(|()| orders.stops().requests(stop).collect())
        }
        Action::Stop(Ending::Robot(name)) => given.plain(name),
        Action::Open(name) => {
            orders.request(name, Vec::new()).map(Vec::from_iter).map_err(Into::into)
        }
        Action::ToolChanged => panic!("{name} is no request"),
    };
    let words = requests.map_err(|e| e.text)?.into_iter().map(|request| match request {
        Request::Command { name, args } => format!("{name} {}", args.join(" ")).trim().to_owned(),
        Request::Set { name, value } => format!("setp {name} {value}"),
        Request::Net { signal, pins } => format!("net {signal} {}", pins.join(" ")),
        other => format!("{other:?}"),
    });
    Ok(words.collect::<Vec<_>>().join("; "))
}

#[test]
fn arguments_become_those_of_the_engine_or_are_refused() {
    let long = "x".repeat(5000);
    for (name, args, wanted) in [
        ("abort", json!({}), Ok("motion.abort")),
        ("estop", json!({}), Ok("iocontrol.estop; motion.disable")),
        ("off", json!({}), Ok("motion.disable")),
        ("pause", json!({}), Ok("motion.pause")),
        ("run", json!({"on_loss": "continue"}), Ok("task.run")),
        ("run", json!({"on_loss": "stop"}), Err("on_loss is stop, must be hold, continue, abort")),
        (
            "mdi",
            json!({"text": "G0", "on_loss": "hold"}),
            Err("the command has no argument 'on_loss'"),
        ),
        ("abort", json!({"now": true}), Err("the command has no argument 'now'")),
        ("mdi", json!({"text": "G0 X1"}), Ok("task.mdi text=G0 X1")),
        ("mdi", json!({}), Err("the command needs text")),
        ("mdi", json!({"text": "G0 X1\nM3"}), Err("text is one line")),
        ("mdi", json!({"text": ["G0"]}), Err("text is a number, a text, true or false")),
        ("mdi", json!({"text": long}), Err("text has 5000 bytes, at most 4096")),
        ("flood", json!({"on": true}), Ok("iocontrol.coolant flood=TRUE")),
        ("feed-override", json!({"scale": 0.5}), Ok("task.feed-override scale=0.5")),
        ("rapid-override", json!({"scale": 0.25}), Ok("task.rapid-override scale=0.25")),
        ("spindle", json!({"speed": -500}), Ok("motion.spindle speed=-500")),
        (
            "jog",
            json!({"axis": "x", "velocity": 10.0}),
            Ok("remote.jog axis=x velocity=10.0 lease=7"),
        ),
        ("jog", json!({"axis": "x"}), Err("the command needs velocity")),
        ("jog", json!({"velocity": 1, "lease": 3}), Err("the command has no argument 'lease'")),
        (
            "touch-off",
            json!({"axis": "z", "value": 1.5, "system": 2}),
            Ok("task.mdi text=G10 L20 P2 Z[1.5 * [#<_metric> + #<_imperial> / 25.4]]"),
        ),
        (
            "touch-off",
            json!({"axis": "z1", "value": 1}),
            Err("axis is Z1, must be one of XYZABCUVW"),
        ),
        ("touch-off", json!({"axis": "z", "value": "1 G0"}), Err("value '1 G0' is not a number")),
        ("touch-off", json!({"axis": "z", "value": "inf"}), Err("value 'inf' is not a number")),
        ("touch-off", json!({"axis": "a", "value": 90}), Ok("task.mdi text=G10 L20 P0 A90")),
        (
            "tool-offset",
            json!({"tool": 3, "z": 2, "diameter": 6}),
            Ok("task.mdi text=G10 L1 P3 Z[2 * [#<_metric> + #<_imperial> / 25.4]] \
                R[3 * [#<_metric> + #<_imperial> / 25.4]]"),
        ),
        (
            "align-go",
            json!({"x": 145.2, "y": -5}),
            Ok("task.mdi text=G53 G0 X[145.2 * [#<_metric> + #<_imperial> / 25.4]] \
                Y[-5 * [#<_metric> + #<_imperial> / 25.4]]"),
        ),
        ("align-go", json!({"x": 1}), Err("the command needs y")),
        ("align-look", json!({"mark": 2}), Ok("align.look mark=2")),
        ("align-look", json!({}), Err("the command needs mark")),
        ("align-calibrate", json!({"mark": 2}), Err("the command has no argument 'mark'")),
        ("robot-run", json!({}), Ok("robot.run")),
        ("robot-run", json!({"from": 12}), Ok("robot.run from=12")),
        ("robot-stop", json!({"now": true}), Err("the command has no argument 'now'")),
        (
            "tool-offset",
            json!({"tool": "3 M3", "z": 2}),
            Err("tool is the number of a tool, from 1"),
        ),
        ("run-from", json!({"line": 4}), Ok("task.run-from line=4")),
        ("confirm", json!({"token": 7}), Ok("task.confirm token=7")),
        (
            "touch-off",
            json!({"axis": "z", "value": 1, "system": 10}),
            Err("system is 10, must be 0 to 9"),
        ),
        ("setp", json!({"name": "a.b", "value": 1}), Ok("setp a.b 1")),
        ("net", json!({"signal": "s", "pins": "a b"}), Ok("net s a b")),
        ("setp", json!({"name": "a.b"}), Err("the command needs value")),
        ("unlink", json!({}), Err("the command needs pin")),
        ("linkp", json!({"pin": "a.b"}), Err("the command needs signal")),
        ("shutdown", json!({}), Err("there is no command 'shutdown'")),
    ] {
        let wanted = wanted.map(str::to_owned).map_err(str::to_owned);
        assert_eq!(sent(name, &args, false), wanted, "{name} {args}");
    }
}

#[test]
fn lengths_are_inches_except_places_of_the_part() {
    for (name, args, wanted) in [
        (
            "touch-off",
            json!({"axis": "z", "value": 1.5}),
            "task.mdi text=G10 L20 P0 Z[1.5 * [#<_imperial> + #<_metric> * 25.4]]",
        ),
        (
            "tool-offset",
            json!({"tool": 3, "diameter": 0.5}),
            "task.mdi text=G10 L1 P3 R[0.25 * [#<_imperial> + #<_metric> * 25.4]]",
        ),
        (
            "align-go",
            json!({"x": 145.2, "y": -5}),
            "task.mdi text=G53 G0 X[145.2 * [#<_metric> + #<_imperial> / 25.4]] \
             Y[-5 * [#<_metric> + #<_imperial> / 25.4]]",
        ),
    ] {
        assert_eq!(sent(name, &args, true).as_deref(), Ok(wanted), "{name} {args}");
    }
}

/// Arguments of each command that needs some.
pub(crate) fn example(name: &str) -> Json {
    match name {
        "mode" => json!({"mode": "manual"}),
        "home" | "unhome" => json!({"joint": "all"}),
        "jog" => json!({"joint": 0, "velocity": 1}),
        "run-from" => json!({"line": 1}),
        "confirm" => json!({"token": 1}),
        "mdi" => json!({"text": "G0 X1"}),
        "optional-stop" | "block-delete" | "mist" | "flood" => json!({"on": true}),
        "feed-override" | "rapid-override" | "spindle-override" => json!({"scale": 1}),
        "spindle" => json!({"speed": 100}),
        "touch-off" => json!({"axis": "x", "value": 0}),
        "tool-offset" => json!({"tool": 1, "z": 1}),
        "align-look" => json!({"mark": 1}),
        "align-go" => json!({"x": 1, "y": 1}),
        "setp" | "sets" => json!({"name": "a", "value": 1}),
        "net" => json!({"signal": "s", "pins": "a"}),
        "linkp" => json!({"pin": "a", "signal": "s"}),
        "unlink" => json!({"pin": "a"}),
        _ => json!({}),
    }
}

/// Commands of the engine that begin motion, those that give power to it, and those that end it.
const MOVING: &[&str] = &[
    "motion.home",
    "motion.resume",
    "motion.step",
    "task.home",
    "task.run",
    "task.confirm",
    "task.resume",
    "task.step",
    "task.mdi",
    "remote.jog",
    "robot.connect",
    "robot.run",
    "robot.resume",
];
const POWERING: &[&str] = &[
    "motion.enable",
    "motion.spindle",
    "motion.override-limits",
    "task.on",
    "task.estop-reset",
    "iocontrol.estop-reset",
];

const ENDING: &[&str] = &[
    "iocontrol.estop",
    "motion.disable",
    "motion.abort",
    "motion.pause",
    "motion.jog-stop",
    "robot.stop",
    "robot.pause",
];

#[test]
fn every_row_has_the_effect_of_what_it_sends_with_a_task_and_without() {
    let mut without = String::new();
    for row in ROWS {
        if matches!(row.action, Action::ToolChanged) {
            assert_eq!(row.effect, Effect::Powers);
            continue;
        }
        for has_task in [true, false] {
            let sent = match asked(row.name, &example(row.name), false, has_task) {
                Ok(sent) => sent,
                Err(why) if why.contains("need a task") && !has_task => {
                    without.push_str(row.name);
                    without.push(' ');
                    continue;
                }
                Err(why) => panic!("{}: {why}", row.name),
            };
            let is = |list: &[&str]| {
                sent.split("; ").any(|c| list.contains(&c.split(' ').next().unwrap_or_default()))
            };
            let effect = match (is(MOVING), is(POWERING), is(ENDING)) {
                (_, _, true) => Effect::Ends,
                (true, _, _) => Effect::Begins,
                // An override turns no spindle.
                (_, true, _) if row.name != "spindle-override" => Effect::Powers,
                _ => Effect::Changes,
            };
            assert_eq!(row.effect, effect, "{}: {sent}", row.name);
            assert!(!sent.contains("task.") || has_task, "{}: {sent}", row.name);
        }
        let is_free = row.effect == Effect::Ends;
        assert_eq!(row.needs_lease(), !is_free, "{}", row.name);
        assert!(row.role >= Role::Operator || is_free, "{}", row.name);
    }
    let needing = "open run run-from recover confirm mdi optional-stop block-delete touch-off \
                   tool-offset align-go ";
    assert_eq!(without, needing, "what needs a task");
}
