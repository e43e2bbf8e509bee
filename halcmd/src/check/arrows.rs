//! Arrows of `net` lines that point at an output, or away from an input.

use crate::session::dry_run::DryRun;
use hal_protocol::{Code, Direction, Finding, Kind};
use std::collections::BTreeMap;

pub(super) fn findings(dry_run: &mut DryRun) -> Vec<Finding> {
    let mut directions: BTreeMap<String, Direction> = BTreeMap::new();
    for pin in dry_run.items(Kind::Pins) {
        directions.extend(pin.original.map(|name| (name, pin.direction)));
        directions.insert(pin.name, pin.direction);
    }
    let mut found = Vec::new();
    for (at, words) in &dry_run.result().statements {
        if words.first().is_none_or(|w| w != "net") {
            continue;
        }
        // Arrows only tell readers, and many scripts are careless with them: both ends must be wrong.
        let [_, _, from, arrow, to @ ..] = words.as_slice() else { continue };
        let all = |wanted| to.iter().all(|pin| directions.get(pin) == Some(&wanted));
        let right = match (directions.get(from), arrow.as_str()) {
            _ if to.is_empty() => continue,
            (Some(Direction::Out), "<=") if all(Direction::In) => "=>",
            (Some(Direction::In), "=>") if all(Direction::Out) => "<=",
            _ => continue,
        };
        let to = to.join(" ");
        let text = format!("'{from} {arrow} {to}': the arrow points at the output");
        found.push(
            Finding::new(Code::ArrowTurned, from, text)
                .at(Some(at.clone()))
                .remedy(format!("write '{from} {right} {to}', or correct the pins")),
        );
    }
    found
}
