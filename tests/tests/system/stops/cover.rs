//! The table has a cell for everything: a new machine, control, command or pin that nobody has judged fails by its name.

use super::{
    data::{Control, Entry, Motion, controls, entries, known, machines},
    rig::{Rig, commands_of},
};
use hal_protocol::Stop;
use hal_tests::programs::root;
use serde_json::Value;
use std::{collections::BTreeSet, fs};

/// Beginnings of commands that move a machine.
const BEGINS: [&str; 3] = ["motion.jog", "motion.move", "robot.run"];

fn controls_with(pick: impl Fn(&Control) -> Option<String>) -> BTreeSet<String> {
    controls().iter().filter_map(pick).collect()
}

/// Checks that each name is a control or is said to be none, and that nothing is said of names that are not there.
fn judged(
    what: &str,
    names: &BTreeSet<String>,
    controls: &BTreeSet<String>,
    others: &BTreeSet<String>,
) {
    let unknown: Vec<_> =
        names.iter().filter(|n| !controls.contains(*n) && !others.contains(*n)).collect();
    assert!(unknown.is_empty(), "{what} without a rule in tests/stops/rules.toml: {unknown:?}");
    let both: Vec<_> = others.iter().filter(|n| controls.contains(*n)).collect();
    assert!(both.is_empty(), "{what} that are controls, and said to be none: {both:?}");
    let gone: Vec<_> = others.iter().filter(|n| !names.contains(*n)).collect();
    assert!(gone.is_empty(), "{what} of tests/stops/rules.toml that are not there: {gone:?}");
}

#[test]
fn every_folder_of_configs_is_in_the_table() {
    let folders = fs::read_dir(root().join("configs")).unwrap().map(|e| e.unwrap());
    let folders = folders.filter(|e| e.path().is_dir());
    let folders: BTreeSet<_> = folders.map(|e| e.file_name().into_string().unwrap()).collect();
    let named: BTreeSet<_> = entries().into_keys().collect();
    assert_eq!(folders, named, "tests/stops/machines.toml names the folders of configs/");
}

#[test]
fn what_is_said_not_to_move_does_not() {
    for (name, entry) in entries() {
        if let Entry::Still(why) = entry {
            let commands = commands_of(&name, &format!("{name}.hal"));
            let moves = BEGINS.iter().find(|c| commands.contains(**c));
            assert_eq!(moves, None, "{name} moves by this command, and the table says: {why}");
        }
    }
}

#[test]
fn every_control_has_a_rule_for_every_motion() {
    let mut names = BTreeSet::new();
    for control in controls() {
        for motion in Motion::ALL {
            control.effect(motion);
        }
        assert!(names.insert(control.name.clone()), "{} is there twice", control.name);
    }
}

#[test]
fn every_command_and_pin_is_a_control_or_said_to_be_none() {
    let (mut commands, mut buttons, mut inputs) =
        (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for machine in machines() {
        let mut rig = Rig::start(&machine);
        let ours = ["motion.", "task.", "iocontrol.", "remote.", "robot.", "halui."];
        let is_ours = |c: &&String| ours.iter().any(|o| c.starts_with(o));
        commands.extend(rig.commands.iter().filter(is_ours).cloned());
        buttons.extend(rig.inputs("halui.*"));
        inputs.extend(rig.inputs("motion.*"));
    }
    commands.extend(
        commands_of("rs03n-controller", "rs03n-controller.hal")
            .into_iter()
            .filter(|c| c.starts_with("robot.")),
    );
    judged("commands", &commands, &controls_with(|c| c.command.clone()), &known("commands"));
    judged(
        "pins of halui",
        &plain(&buttons),
        &plain(&controls_with(|c| c.button.clone())),
        &known("buttons"),
    );
    let forced = controls_with(|c| c.force.as_ref().map(|f| f.pin.clone()));
    judged("inputs of motion", &plain(&inputs), &plain(&forced), &known("inputs"));
}

/// Returns names with N for each number of a joint, spindle or output, and L for each letter of an axis.
fn plain(names: &BTreeSet<String>) -> BTreeSet<String> {
    let part = |part: &str| {
        let digits = part.trim_start_matches(|c: char| !c.is_ascii_digit());
        if !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()) {
            format!("{}N", &part[..part.len() - digits.len()])
        } else if part.len() == 1 {
            "L".to_owned()
        } else {
            part.to_owned()
        }
    };
    names.iter().map(|name| name.split('.').map(part).collect::<Vec<_>>().join(".")).collect()
}

#[test]
fn every_command_of_the_panel_is_a_control_or_said_to_be_none() {
    let path = root().join("components/remote/panel/openapi.json");
    let document: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let names = &document["components"]["schemas"]["Command"]["properties"]["name"]["enum"];
    let names: BTreeSet<_> =
        names.as_array().unwrap().iter().map(|n| n.as_str().unwrap().to_owned()).collect();
    let panel = controls_with(|c| c.panel.clone());
    judged("commands of the panel", &names, &panel, &known("panel"));
}

#[test]
fn every_client_has_every_stop() {
    let names = controls_with(|c| Some(c.name.clone()));
    let mut missing = Vec::new();
    // Teleoperation has one stop, CANCELAR, which ends a job of its own: `tests/teleop/cancel.txt`.
    for client in ["panel", "rsh", "python"] {
        for stop in Stop::ALL {
            let name = format!("{client} {}", stop.name());
            if !names.contains(&name) {
                missing.push(name);
            }
        }
    }
    assert!(missing.is_empty(), "controls without rules: {missing:?}");
}
