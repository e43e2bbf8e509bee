//! Starts that are stopped while they are checked: nothing moves afterwards.

use super::mill::{Mill, People};
use std::fs;

/// A program whose check takes longer than this test, and then a move.
const SLOW: &str =
    "G20 F6\r\no1 repeat [100000000]\r\n#1=[#1+1]\r\no1 endrepeat\r\nG1 X1\r\nM2\r\n.";

/// Asks for the start, and waits until it is checked.
fn ask(mill: &Mill, people: &mut People) {
    if let Some(file) = mill.file() {
        fs::remove_file(file).unwrap();
    }
    people.say(mill, "A", "EJECUTAR");
    mill.until("the program is checked", || {
        assert_eq!(people.heard("A"), None, "it is not checked");
        mill.file().is_some()
    });
}

#[test]
fn what_is_stopped_while_a_start_is_checked_does_not_move_by_it() {
    // RS274-D has no loops.
    let edits = [("maxnc.ini", "DIALECT = rs274d\n", "")];
    let mill = Mill::with("ON_LOSS = hold\n", &[], &edits);
    mill.ready();
    // A program of the user with the name that the job's once had.
    mill.scratch.write("teleop.ngc", "mine");
    let mut people = People::default();
    assert_eq!(people.ask(&mill, "A", "INGRESAR ana:TOKEN"), "ACEPTADO");
    people.say(&mill, "A", "ENVIAR_NUEVO");
    assert_eq!(people.ask(&mill, "A", SLOW), "RECIBIDO");
    let off = "APAGADO remote.allow-motion is FALSE: the machine permits no remote motion";
    for (stop, why, again) in [
        ("task.estop", "APAGADO the machine is in e-stop", &["task.estop-reset", "task.on"][..]),
        ("setp remote.allow-motion FALSE", off, &["setp remote.allow-motion TRUE"]),
        ("task.off", "APAGADO the machine is off", &["task.on"]),
    ] {
        ask(&mill, &mut people);
        mill.halcmd(stop);
        assert_eq!(people.hear(&mill, "A"), format!("ERROR_EJECUTAR {why}"));
        for command in again {
            mill.halcmd(command);
            mill.run("200ms");
        }
    }
    ask(&mill, &mut people);
    people.say(&mill, "A", "AVANCE");
    people.say(&mill, "A", "CANCELAR");
    assert_eq!(people.hear(&mill, "A"), "AVANCE 0");
    assert_eq!(people.hear(&mill, "A"), "CANCELADO");
    ask(&mill, &mut people);
    mill.halcmd("setp teleop.serve FALSE");
    assert_eq!(people.hear(&mill, "A"), "ERROR_EJECUTAR DETENIDO the server stops");
    assert_eq!(people.hear(&mill, "A"), "DESCONEXION");
    mill.run("20s");
    assert_eq!(mill.number("stepgen.0.counts"), 0.0);
    assert_eq!(mill.halcmd("getp remote.lease").trim(), "0");
    let status = mill.halcmd("task.status");
    assert!(status.contains("state=on") && status.contains("jobs=0 failed=0"), "{status}");
    assert_eq!(mill.scratch.read("teleop.ngc"), "mine");
}
