//! The table of rights: every subcommand by who has said hello or has control, while the machine takes commands and while it refuses all.

use super::{Noted, ROWS, Session, say};
use crate::rows::Stops;
use hal_golden::rights::RightsTable;
use std::path::Path;

/// Lines that bring a connection so far.
const WHO: [(&str, &str); 3] = [
    ("stranger", ""),
    ("greeted", "hello EMC me 1.0\nset echo off\nset verbose on"),
    ("control", "hello EMC me 1.0\nset echo off\nset verbose on\nset enable EMCTOO"),
];

/// Arguments of a subcommand of `set` that are right, unless it needs none.
fn arguments(name: &str) -> &'static str {
    match name {
        "COMM_MODE" => "ascii",
        "ENABLE" => "EMCTOO",
        "ECHO" | "VERBOSE" | "BRAKE" | "FLOOD" | "MIST" | "LUBE" | "OVERRIDE_LIMITS" => "on",
        "TELEOP_ENABLE" => "off",
        "ANGULAR_UNIT_CONVERSION" => "deg",
        "LINEAR_UNIT_CONVERSION" => "mm",
        "FEED_OVERRIDE" | "SPINDLE_OVERRIDE" => "50",
        "HOME" => "-1",
        "JOG" => "0 60",
        "JOG_INCR" => "0 60 1",
        "JOG_STOP" => "0",
        "LOAD_TOOL_TABLE" => "tool.tbl",
        "MDI" => "G0 X1",
        "MODE" => "manual",
        "OPEN" => "a.ngc",
        "OPTIONAL_STOP" => "1",
        "PROBE" => "1 2 3",
        "SPINDLE" => "forward",
        "SET_WAIT" | "WAIT" => "received",
        "SET_TIMEOUT" | "TIMEOUT" => "5",
        "UPDATE" => "none",
        _ => "",
    }
}

/// Returns all lines: each subcommand, once for each effect that it has.
fn lines() -> Vec<(String, String)> {
    let mut all = Vec::new();
    for row in ROWS {
        let name = row.name.to_lowercase();
        if row.get.is_some() {
            let arguments = if row.name == "INI" { " MACHINE EMC" } else { "" };
            all.push((format!("get {name}"), format!("get {name}{arguments}")));
        }
        if row.set.is_some() && matches!(row.stops, Stops::With(_)) {
            all.extend(
                ["on", "off"].map(|word| format!("set {name} {word}")).map(|l| (l.clone(), l)),
            );
        } else if row.set.is_some() {
            all.push((format!("set {name}"), format!("set {name} {}", arguments(row.name))));
        }
    }
    all
}

#[test]
fn every_subcommand_has_the_rights_of_its_rule() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/rights");
    let mut table = RightsTable::of(&folder.join("linuxcncrsh.rules"));
    for (who, before) in WHO {
        for (request, line) in lines() {
            for state in ["ready", "busy"] {
                let (mut session, mut machine) = (Session::default(), Noted::new());
                say(&mut session, &mut machine, before);
                machine.refuses = (state == "busy").then(|| "it refuses".to_owned());
                let reply = say(&mut session, &mut machine, &line);
                let end = if reply.contains("NAK") { "refused" } else { "ok" };
                // A refusal before the machine has been asked, and an effect, exclude each other.
                let is_stop = crate::is_stop(&line);
                assert!(
                    end == "ok" || state == "busy" || machine.said.is_empty(),
                    "{line}: {reply}"
                );
                assert!(!is_stop || who == "stranger" || !machine.said.is_empty(), "{line}");
                table.row(&request, &[who, state], end);
            }
        }
    }
    table.finish(&folder.join("linuxcncrsh.md"));
}
