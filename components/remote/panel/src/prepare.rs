//! The plugin `remote` in the machine: loaded and wired where the machine's files have not.

use hal_ini::Ini;
use hal_protocol::{
    Client, Edit, ItemInfo, Kind, Link as _, Place, Reply, Request, SignalInfo, ThreadInfo,
};

/// Pins of the plugin that stop motion, with the signal and the pin of motion that each must reach.
const STOPS: &[(&str, &str, &str)] = &[
    ("remote.jog-stop", "remote-jog-stop", "motion.jog-stop"),
    ("remote.hold", "remote-hold", "motion.feed-inhibit"),
];
/// Function before which the plugin's runs.
const CONTROLLER: &str = "motion-controller";

/// Loads and wires the plugin as a whole, or leaves the machine as it is.
pub(crate) fn load(place: &Place, ini: Option<&Ini>) -> Result<(), String> {
    let mut client = Client::connect(place, "").map_err(|e| e.to_string())?;
    let mut requests = Vec::new();
    let component = Request::Component { name: "remote".to_owned() };
    let there = client.call(component).map_err(|e| e.to_string())?;
    if there == Reply::Components(Vec::new()) {
        let get = |name: &str| ini.and_then(|ini| ini.get("REMOTE", name));
        let entries = [
            ("JOG_TIMEOUT", "jog_timeout"),
            ("LEASE_TIMEOUT", "lease_timeout"),
            ("ON_LOSS", "on_loss"),
        ];
        let args = entries.iter().filter_map(|(entry, arg)| Some(format!("{arg}={}", get(entry)?)));
        let args = args.map(|arg| arg.to_lowercase()).collect();
        requests.push(Request::Load { module: "remote".to_owned(), args });
    }
    let threads = list(&mut client, Kind::Threads)?;
    let Reply::Threads(threads) = threads else {
        return Err("the engine lists no threads".to_owned());
    };
    if !threads.iter().any(|t| t.functs.iter().any(|f| f == "remote")) {
        let (thread, position) = place_of(&threads).ok_or_else(|| {
            format!("no thread runs {CONTROLLER}: this machine has no motion that could be stopped")
        })?;
        let funct = "remote".to_owned();
        requests.push(Request::AddFunct { funct, thread, position, init: false });
    }
    let Reply::Items(pins) = list(&mut client, Kind::Pins)? else {
        return Err("the engine lists no pins".to_owned());
    };
    let Reply::Signals(signals) = list(&mut client, Kind::Signals)? else {
        return Err("the engine lists no signals".to_owned());
    };
    for (from, signal, to) in STOPS {
        requests.extend(wire(&pins, &signals, from, signal, to)?);
    }
    if requests.is_empty() {
        return Ok(());
    }
    // An error names the line, which is the number of the request.
    let edits = (1..).zip(requests).map(|(line, request)| Edit { file: 0, line, request });
    let files = vec!["halpanel".to_owned()];
    let apply = Request::Apply { files, edits: edits.collect(), dry: false };
    match client.call(apply).map_err(|e| e.to_string())? {
        Reply::Refused { failure, .. } => {
            Err(format!("the plugin remote cannot be used: {failure}"))
        }
        _ => Ok(()),
    }
}

fn list(client: &mut Client, kind: Kind) -> Result<Reply, String> {
    let list = Request::List { kind, patterns: Vec::new(), ty: None };
    client.call(list).map_err(|e| e.to_string())
}

/// Returns the thread of the motion controller, and the position before it.
fn place_of(threads: &[ThreadInfo]) -> Option<(String, i64)> {
    threads.iter().find_map(|thread| {
        let at = thread.functs.iter().position(|f| f == CONTROLLER)?;
        Some((thread.name.clone(), i64::try_from(at).ok()? + 1))
    })
}

/// Returns the link of two pins, unless the machine's files have made it.
fn wire(
    pins: &[ItemInfo],
    signals: &[SignalInfo],
    from: &str,
    signal: &str,
    to: &str,
) -> Result<Option<Request>, String> {
    let signal_of =
        |name: &str| pins.iter().find(|p| p.name == name).and_then(|p| p.signal.clone());
    match (signal_of(from), signal_of(to)) {
        (Some(a), Some(b)) if a == b => Ok(None),
        (None, None) => {
            let pins = vec![from.to_owned(), to.to_owned()];
            Ok(Some(Request::Net { signal: signal.to_owned(), pins }))
        }
        // The machine's own logic stands between the two.
        (Some(a), Some(_)) if feeds(signals, &a) => Ok(None),
        _ => Err(format!(
            "{to} is linked, and {from} does not reach it: join both in the machine's HAL file, as \
             with loadrt or2, before halpanel is started"
        )),
    }
}

/// Returns whether a signal leads anywhere.
fn feeds(signals: &[SignalInfo], name: &str) -> bool {
    signals.iter().any(|s| s.name == name && s.pins.len() > 1)
}
