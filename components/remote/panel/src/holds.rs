//! Holds: reasons why a job, or the path of a machine without a task, does not go on.

use crate::status::Machine;
use hal_protocol::{Client, Kind as List, Link as _, Reply, Request, Value};
use serde::Serialize;
use serde_json::{Map, Value as Json};

/// Pins by which the machine itself holds all feeds.
const GATES: [&str; 2] = ["motion.feed-inhibit", "motion.feed-hold"];
/// State of the interpreter in the task's status that waits in a pause.
const RESTING: u64 = 2;
/// Kind of a rapid move in the status of motion.
const RAPID: u64 = 1;

/// A kind of hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct HoldKind {
    name: &'static str,
    /// Kinds of one group are one hold, told more or less exactly.
    group: &'static str,
    /// True if the command `resume` ends it.
    resumes: bool,
}

const fn kind(name: &'static str, group: &'static str, resumes: bool) -> HoldKind {
    HoldKind { name, group, resumes }
}

/// Kinds of the waits of the task and of motion, by the numbers in their status.
const WAITS: [Option<HoldKind>; 21] = [
    None,
    Some(kind("at-speed", "at-speed", false)),
    Some(kind("index", "index", false)),
    Some(kind("orient", "orient", false)),
    Some(kind("spindle-stopped", REST, true)),
    Some(PAUSED),
    Some(FEED_HOLD),
    Some(INHIBIT),
    Some(kind("override", SCALE, false)),
    Some(kind("spindle-speed", "spindle-speed", false)),
    Some(kind("stop", REST, true)),
    Some(kind("optional-stop", REST, true)),
    Some(kind("pallet", REST, true)),
    Some(STEP),
    Some(kind("tool", "tool", false)),
    Some(kind("input", "input", false)),
    Some(kind("user-program", "user-program", false)),
    Some(kind("function", "function", false)),
    Some(LEASE),
    Some(kind("dwell", "dwell", false)),
    Some(kind("io", "io", false)),
];
const REST: &str = "rest";
const SCALE: &str = "scale";
const LEASE: HoldKind = kind("lease", "lease", true);
const INHIBIT: HoldKind = kind("inhibit", "inhibit", false);
const FEED_HOLD: HoldKind = kind("feed-hold", "feed-hold", false);
const FEED_ZERO: HoldKind = kind("feed-zero", SCALE, false);
const RAPID_ZERO: HoldKind = kind("rapid-zero", SCALE, false);
const ADAPTIVE: HoldKind = kind("adaptive", SCALE, false);
const PAUSED: HoldKind = kind("paused", REST, true);
const STEP: HoldKind = kind("step", REST, true);
const PROGRAM: HoldKind = kind("program", REST, true);

/// A reason why nothing goes on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Hold {
    /// Name of its kind.
    pub(crate) kind: &'static str,
    #[serde(skip)]
    group: &'static str,
    /// Signal or pin that holds, where it is one.
    pub(crate) by: String,
    /// True if the command `resume` ends it.
    pub(crate) resumes: bool,
    /// True if it ends by itself.
    pub(crate) ends: bool,
    /// Spindle, tool, input or user code that is waited for; 0 for others.
    pub(crate) number: i64,
    /// Machine time of its begin in seconds, where the machine tells it.
    pub(crate) since: Option<f64>,
    /// Sentence of the machine: who is waited for, and how to go on.
    pub(crate) text: String,
}

impl Hold {
    fn new(kind: HoldKind, by: Option<&String>) -> Self {
        Self {
            kind: kind.name,
            group: kind.group,
            by: by.cloned().unwrap_or_default(),
            resumes: kind.resumes,
            ends: false,
            number: 0,
            since: None,
            text: String::new(),
        }
    }
}

/// Pins that hold feeds now, by the name of their signal where they have one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Gates([Option<String>; 2]);

impl Gates {
    /// Reads the pins, unless feeds are not held.
    pub(crate) fn read(client: &mut Client, motion: Option<&Map<String, Json>>) -> Self {
        if motion.and_then(|motion| number(motion, "feed_scale")) != Some(0.0) {
            return Self::default();
        }
        let patterns = GATES.map(str::to_owned).to_vec();
        let list = Request::List { kind: List::Pins, patterns, ty: None };
        let Ok(Reply::Items(pins)) = client.call(list) else { return Self::default() };
        Self(GATES.map(|name| {
            let pin = pins.iter().find(|pin| pin.name == name)?;
            let by = pin.signal.as_ref().unwrap_or(&pin.name);
            (pin.value == Value::Bit(true)).then(|| by.clone())
        }))
    }
}

fn number(status: &Map<String, Json>, name: &str) -> Option<f64> {
    status.get(name)?.as_f64()
}

/// Returns all reasons. `is_lost` says that a program is held since the control lease was lost.
pub(crate) fn holds(machine: &Machine, is_lost: bool) -> Vec<Hold> {
    let mut found = Vec::new();
    let mut add = |is: bool, kind, by: Option<&String>| {
        found.extend(is.then(|| Hold::new(kind, by)));
    };
    add(is_lost, LEASE, None);
    let empty = Map::new();
    let motion = machine.motion.as_ref().unwrap_or(&empty);
    let state = machine.task.as_ref().map(|task| count(task, "interpreter"));
    if count(motion, "queue") == 0 && state.unwrap_or(0) == 0 {
        return found;
    }
    let Gates([inhibit, hold]) = &machine.gates;
    // The hold of a lost lease is an inhibit too.
    add(inhibit.is_some() && !is_lost, INHIBIT, inhibit.as_ref());
    add(hold.is_some() && bit(motion, "feed_hold"), FEED_HOLD, hold.as_ref());
    let is_zero = |name| number(motion, name) == Some(0.0);
    let is_rapid = count(motion, "motion_type") == RAPID;
    add(is_zero("feed_override") && !is_rapid, FEED_ZERO, None);
    add(is_zero("rapid_override") && is_rapid, RAPID_ZERO, None);
    let is_open = inhibit.is_none() && hold.is_none() && !is_zero("feed_override");
    add(bit(motion, "adaptive_feed") && is_zero("feed_scale") && is_open, ADAPTIVE, None);
    let is_stepping = machine.task.as_ref().is_some_and(|task| bit(task, "stepping"));
    let rests = match state {
        Some(state) => state == RESTING,
        None => bit(motion, "paused"),
    };
    let kind = match (is_stepping, bit(motion, "paused")) {
        (true, _) => STEP,
        (false, true) => PAUSED,
        (false, false) => PROGRAM,
    };
    add(rests || is_stepping && state.is_some_and(|state| state != 0), kind, None);
    let (waits, since) = match &machine.task {
        Some(task) => (task, number(task, "wait_since")),
        None => (motion, number(motion, "wait_since_ns").map(|ns| ns * 1e-9)),
    };
    add_wait(&mut found, waits, since, is_lost);
    found
}

/// Adds what a status says of its wait to the hold that is known of it already, or as another one.
fn add_wait(found: &mut Vec<Hold>, status: &Map<String, Json>, since: Option<f64>, is_lost: bool) {
    let number = usize::try_from(count(status, "wait")).unwrap_or(0);
    let Some(kind) = WAITS.get(number).copied().flatten() else { return };
    // A lost lease inhibits the feed.
    let group = if is_lost && kind == INHIBIT { LEASE.group } else { kind.group };
    let at = found.iter().position(|hold| hold.group == group).unwrap_or_else(|| {
        found.push(Hold::new(kind, None));
        found.len() - 1
    });
    let Some(hold) = found.get_mut(at) else { return };
    if group == REST {
        hold.kind = kind.name;
    }
    hold.ends = bit(status, "wait_ends");
    hold.number = status.get("wait_number").and_then(Json::as_i64).unwrap_or(0);
    hold.since = since;
    hold.text = status.get("wait_text").and_then(Json::as_str).unwrap_or_default().to_owned();
}

fn count(of: &Map<String, Json>, name: &str) -> u64 {
    of.get(name).and_then(Json::as_u64).unwrap_or(0)
}

fn bit(of: &Map<String, Json>, name: &str) -> bool {
    of.get(name) == Some(&Json::Bool(true))
}

#[cfg(test)]
mod tests {
    //! Holds of machines with and without a task.

    use super::{Gates, holds};
    use crate::status::{Joined, Machine};
    use serde_json::{Value as Json, json};

    fn check(motion: Json, task: Json, gates: [Option<&str>; 2], is_lost: bool, expected: &str) {
        let machine = Machine {
            engine: Joined::Joined,
            motion: motion.as_object().cloned(),
            task: task.as_object().cloned(),
            gates: Gates(gates.map(|by| by.map(str::to_owned))),
        };
        let text = |hold: &super::Hold| {
            let by = if hold.by.is_empty() { String::new() } else { format!(" by {}", hold.by) };
            let text = if hold.text.is_empty() { "" } else { " told" };
            format!("{}{by}{}{text}", hold.kind, if hold.resumes { " resumes" } else { "" })
        };
        let said: Vec<_> = holds(&machine, is_lost).iter().map(text).collect();
        assert_eq!(said.join(", "), expected, "{motion} {task}");
    }

    #[test]
    fn each_hold_has_its_reason() {
        let none = [None, None];
        let moves = json!({ "queue": 3, "feed_override": 1, "rapid_override": 1, "feed_scale": 1 });
        let with = |more: Json| {
            let mut all = moves.as_object().cloned().unwrap();
            all.extend(more.as_object().cloned().unwrap());
            Json::Object(all)
        };
        let runs = json!({ "interpreter": 1 });
        check(moves.clone(), runs.clone(), none, false, "");
        check(moves.clone(), runs.clone(), none, true, "lease resumes");
        let shut = with(json!({ "feed_scale": 0, "feed_hold": true }));
        check(shut.clone(), runs.clone(), [Some("door"), None], false, "inhibit by door");
        // The hold of a lost lease is shown once.
        check(shut.clone(), runs.clone(), [Some("remote-hold"), None], true, "lease resumes");
        check(shut, runs.clone(), [None, Some("pedal")], false, "feed-hold by pedal");
        let zero = with(json!({ "feed_scale": 0, "feed_override": 0 }));
        check(zero.clone(), runs.clone(), none, false, "feed-zero");
        let rapid = with(json!({ "motion_type": 1, "rapid_override": 0 }));
        check(rapid, runs.clone(), none, false, "rapid-zero");
        let adaptive = with(json!({ "feed_scale": 0, "adaptive_feed": true }));
        check(adaptive, runs, none, false, "adaptive");
        let rests = json!({ "interpreter": 2 });
        check(with(json!({ "paused": true })), rests.clone(), none, false, "paused resumes");
        let still = json!({ "queue": 0 });
        check(still.clone(), rests, none, false, "program resumes");
        let steps = json!({ "interpreter": 2, "stepping": true });
        check(still.clone(), steps, none, false, "step resumes");
        // Without a job nothing is held by an override of 0.
        check(
            with(json!({ "queue": 0, "feed_override": 0 })),
            json!({ "interpreter": 0 }),
            none,
            false,
            "",
        );
        // A machine without a task.
        check(with(json!({ "paused": true })), Json::Null, none, false, "paused resumes");
        check(zero, Json::Null, none, false, "feed-zero");
        check(Json::Null, Json::Null, none, true, "lease resumes");
    }

    #[test]
    fn a_wait_of_the_machine_is_told_once() {
        let none = [None, None];
        let moves = json!({ "queue": 3, "feed_override": 1, "feed_scale": 1 });
        let waits = |wait: u32, interpreter: u32| json!({ "interpreter": interpreter, "wait": wait, "wait_text": "it waits", "wait_since": 1 });
        for (wait, interpreter, expected) in [
            (0, 1, ""),
            (2, 3, "index told"),
            (4, 2, "spindle-stopped resumes told"),
            (5, 2, "paused resumes told"),
            (10, 2, "stop resumes told"),
            (14, 3, "tool told"),
            (99, 1, ""),
        ] {
            check(moves.clone(), waits(wait, interpreter), none, false, expected);
        }
        let shut = json!({ "queue": 3, "feed_override": 1, "feed_scale": 0 });
        check(shut.clone(), waits(7, 1), [Some("door"), None], false, "inhibit by door told");
        for wait in [7, 18] {
            let by = [Some("remote-hold"), None];
            check(shut.clone(), waits(wait, 1), by, true, "lease resumes told");
        }
        let zero = json!({ "queue": 3, "feed_override": 0, "feed_scale": 0 });
        check(zero, waits(8, 1), none, false, "feed-zero told");
        // Motion alone.
        let turns = json!({ "queue": 1, "feed_override": 1, "feed_scale": 1, "wait": 1, "wait_since_ns": 5e9 });
        check(turns, Json::Null, none, false, "at-speed");
    }
}
