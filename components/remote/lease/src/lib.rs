//! The plugin `remote` in the machine: loaded and wired where the machine's files have not.
#![forbid(unsafe_code)]

mod epoch;
mod error;
#[cfg(test)]
mod tests;
mod user;

use hal_ini::Ini;
use hal_protocol::{
    Client, Direction, Edit, ItemInfo, Kind, Link, Orders, Place, Reply, Request, ThreadInfo,
};
use std::collections::BTreeSet;

pub use epoch::EpochPage;
pub use error::{NoOrders, NoRemote};
pub use user::{is_guest, is_own, user_at};

/// Pins of the plugin that stop motion, with the signal and the pin of motion that each must reach.
const STOPS: &[(&str, &str, &str)] = &[
    ("remote.jog-stop", "remote-jog-stop", "motion.jog-stop"),
    ("remote.hold", "remote-hold", "motion.feed-inhibit"),
];
/// Pin of the task that ends a job, and the pin that shows one.
const ABORT: (&str, &str, &str) = ("remote.abort", "remote-abort", "task.abort");
const JOB: (&str, &str, &str) = ("task.job", "remote-job", "remote.job");
/// Function before which the plugin's runs.
const CONTROLLER: &str = "motion-controller";
/// Function of a robot behind its own controller, in a machine without motion; pins of the plugin that act on it, and
/// the pin that shows its job.
const ROBOT: &str = "robot";
const ROBOT_STOPS: &[(&str, &str, &str)] =
    &[("remote.hold", "remote-hold", "robot.hold"), ("remote.abort", "remote-abort", "robot.stop")];
const ROBOT_JOB: (&str, &str, &str) = ("robot.busy", "remote-job", "remote.job");

/// Finds the orders of a machine.
///
/// # Errors
/// The engine does not answer, or something moves that nothing stops.
pub fn orders(client: &mut dyn Link) -> Result<Orders, NoOrders> {
    let answer = client.call(Orders::list()).map_err(NoOrders::Engine)?;
    Orders::listed(&answer).map_err(NoOrders::Unlisted)
}

/// Loads and wires the plugin as a whole, or leaves the machine as it is. Messages name the program that asks.
///
/// # Errors
/// There is no engine, or no motion; something moves that nothing stops; or the machine's files have wired these pins otherwise.
pub fn load(place: &Place, ini: Option<&Ini>, program: &str) -> Result<(), NoRemote> {
    let mut client = Client::connect(place, "").map_err(NoRemote::Engine)?;
    arrange(&mut client, ini, program)
}

/// Does what [`load`] does, at the end of this link.
fn arrange(client: &mut dyn Link, ini: Option<&Ini>, program: &str) -> Result<(), NoRemote> {
    // A machine that cannot be stopped is not commanded.
    orders(client).map_err(NoRemote::Orders)?;
    let mut requests = Vec::new();
    let Reply::Threads(threads) = list(client, Kind::Threads)? else {
        return Err(NoRemote::Unlisted("threads"));
    };
    let has = |name: &str| threads.iter().any(|t| t.functs.iter().any(|f| f == name));
    let controller = if !has(CONTROLLER) && has(ROBOT) { ROBOT } else { CONTROLLER };
    let component = Request::Component { name: "remote".to_owned() };
    let there = client.call(component).map_err(NoRemote::Engine)?;
    if there == Reply::Components(Vec::new()) {
        let get = |name: &str| ini.and_then(|ini| ini.get("REMOTE", name));
        let entries = [
            ("JOG_TIMEOUT", "jog_timeout"),
            ("LEASE_TIMEOUT", "lease_timeout"),
            ("ON_LOSS", "on_loss"),
        ];
        let args = entries.iter().filter_map(|(entry, arg)| Some(format!("{arg}={}", get(entry)?)));
        let motion = (controller == ROBOT).then(|| "motion=0".to_owned());
        let args = args.map(|arg| arg.to_lowercase()).chain(motion).collect();
        requests.push(Request::Load { module: "remote".to_owned(), args });
    }
    if !has("remote") {
        let (thread, position) = place_of(&threads, controller)
            .ok_or(NoRemote::NoMotion { functs: [CONTROLLER, ROBOT] })?;
        let funct = "remote".to_owned();
        requests.push(Request::AddFunct { funct, thread, position, init: false });
    } else if !threads.iter().any(|thread| runs_before(&thread.functs, controller)) {
        return Err(NoRemote::Late { controller, program: program.to_owned() });
    }
    let Reply::Items(pins) = list(client, Kind::Pins)? else {
        return Err(NoRemote::Unlisted("pins"));
    };
    let has_task = pins.iter().any(|pin| pin.name == JOB.0);
    let (stops, job) = match controller {
        ROBOT => (ROBOT_STOPS.to_vec(), Some(ROBOT_JOB)),
        _ if has_task => ([STOPS, &[ABORT]].concat(), Some(JOB)),
        _ => (STOPS.to_vec(), None),
    };
    for (from, signal, to) in stops {
        requests.extend(wire(&pins, from, signal, to)?);
    }
    if let Some(job) = job {
        requests.extend(join(&pins, job)?);
    }
    if requests.is_empty() {
        return Ok(());
    }
    // An error names the line, which is the number of the request.
    let edits = (1..).zip(requests).map(|(line, request)| Edit { file: 0, line, request });
    let files = vec![program.to_owned()];
    let apply = Request::Apply { files, edits: edits.collect(), dry: false };
    match client.call(apply).map_err(NoRemote::Engine)? {
        Reply::Refused { failure, .. } => Err(NoRemote::Refused(failure)),
        _ => Ok(()),
    }
}

fn list(client: &mut dyn Link, kind: Kind) -> Result<Reply, NoRemote> {
    let list = Request::List { kind, patterns: Vec::new(), ty: None };
    client.call(list).map_err(NoRemote::Engine)
}

/// Returns the thread of the controller, and the position before it.
fn place_of(threads: &[ThreadInfo], controller: &str) -> Option<(String, i64)> {
    threads.iter().find_map(|thread| {
        let at = thread.functs.iter().position(|f| f == controller)?;
        Some((thread.name.clone(), i64::try_from(at).ok()? + 1))
    })
}

/// Returns the link of two pins, unless the machine's files have made it.
fn wire(
    pins: &[ItemInfo],
    from: &str,
    signal: &str,
    to: &str,
) -> Result<Option<Request>, NoRemote> {
    let signal_of =
        |name: &str| pins.iter().find(|p| p.name == name).and_then(|p| p.signal.clone());
    match (signal_of(from), signal_of(to)) {
        (Some(a), Some(b)) if a == b => Ok(None),
        (None, None) => {
            let pins = vec![from.to_owned(), to.to_owned()];
            Ok(Some(Request::Net { signal: signal.to_owned(), pins }))
        }
        // The machine's own logic stands between the two.
        (Some(a), Some(b)) if reaches(pins, &a, &b, to) => Ok(None),
        _ => Err(NoRemote::Unreached { from: from.to_owned(), to: to.to_owned() }),
    }
}

/// Returns the link of a pin with one that reads it, unless there is one. The first may have a signal already.
///
/// # Errors
/// Both are linked, and not with each other.
pub fn join(
    pins: &[ItemInfo],
    (from, signal, to): (&str, &str, &str),
) -> Result<Option<Request>, NoRemote> {
    let signal_of =
        |name: &str| pins.iter().find(|p| p.name == name).and_then(|p| p.signal.clone());
    match (signal_of(from), signal_of(to)) {
        (Some(from), None) => Ok(Some(Request::Net { signal: from, pins: vec![to.to_owned()] })),
        _ => wire(pins, from, signal, to),
    }
}

/// Returns whether the plugin's function runs before the controller's, in its thread.
fn runs_before(functs: &[String], controller: &str) -> bool {
    let at = |name: &str| functs.iter().position(|f| f == name);
    at("remote").zip(at(controller)).is_some_and(|(own, controller)| own < controller)
}

/// Returns whether a signal reaches another through components: from a pin that reads it to one that the same part
/// writes. Motion itself, whose pin `to` is, joins nothing.
fn reaches(pins: &[ItemInfo], from: &str, goal: &str, to: &str) -> bool {
    let part = |pin: &ItemInfo| {
        let own = pin.original.as_ref().unwrap_or(&pin.name);
        (pin.owner, own.rsplit_once('.').map_or("", |(part, _)| part).to_owned())
    };
    let motion = pins.iter().find(|pin| pin.name == to).map(|pin| pin.owner);
    let mut seen = BTreeSet::from([from.to_owned()]);
    let mut next = vec![from.to_owned()];
    while let Some(signal) = next.pop() {
        let readers = pins.iter().filter(|pin| {
            pin.signal.as_ref() == Some(&signal)
                && pin.direction != Direction::Out
                && Some(pin.owner) != motion
        });
        let parts: BTreeSet<_> = readers.map(part).collect();
        for pin in pins.iter().filter(|pin| pin.direction != Direction::In) {
            if let Some(signal) = &pin.signal
                && parts.contains(&part(pin))
                && seen.insert(signal.clone())
            {
                next.push(signal.clone());
            }
        }
    }
    seen.contains(goal)
}
