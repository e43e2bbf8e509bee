//! Teleoperation of the mill: every use case as a transcript, and clients that vanish.

mod begin;
mod client;
mod loss;
mod mill;

use hal_tests::{programs::root, scratch::until};
use mill::{Mill, People};
use std::fs;

/// A program that takes 20 s.
const PART: &str = "G20 G90\nG1 X1 F6\nG1 X2\nM2";

/// Plays a transcript: `A> ` and `A< ` are lines of person A (with `…` at its end, the begin of one), `$ ` is a command of halcmd, `= ` its output.
///
/// `~ PIN = VALUE` lets time pass until a pin has this value, `A? AVANCE N` asks until that percentage is reached; `A starts` lets time pass until the job runs.
fn play(mill: &mut Mill, text: &str) {
    let (mut people, mut output) = (People::default(), String::new());
    for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        let (who, rest) = line.split_once(' ').unwrap();
        if let Some(name) = who.strip_suffix('>') {
            people.say(mill, name, rest);
        } else if let Some(name) = who.strip_suffix('<') {
            let said = people.hear(mill, name);
            match rest.strip_suffix('…') {
                Some(begin) => assert!(said.starts_with(begin), "{line}: {said}"),
                None => assert_eq!(said, rest, "{line}"),
            }
        } else if let Some(name) = who.strip_suffix('?') {
            let (word, least) = rest.split_once(' ').unwrap();
            until(line, || {
                let answer = people.ask(mill, name, word);
                let percent: u32 = answer.split(' ').nth(1).unwrap().parse().unwrap();
                mill.run("100ms");
                least.parse::<u32>().unwrap() <= percent
            });
        } else {
            match (who, rest) {
                ("$", _) => output = mill.halcmd(rest),
                ("=", _) => assert_eq!(output.trim(), rest, "{line}"),
                ("~", _) => {
                    let (pin, value) = rest.split_once(" = ").unwrap();
                    let pin = format!("getp {pin}");
                    mill.until(line, || mill.halcmd(&pin).trim() == value);
                }
                (_, "starts") => {
                    mill.until(line, || mill.halcmd("getp teleop.running").trim() == "TRUE");
                }
                (_, "gone") => people.cut(who),
                (_, "closed") => {
                    assert_eq!(people.hear(mill, who), "(closed)", "{line}");
                    people.cut(who);
                }
                ("*", "listens") => mill.listens(),
                _ => panic!("{line}: this is no line of a transcript"),
            }
        }
    }
}

/// Plays the transcript of a use case on a mill of its own.
fn use_case(name: &str) {
    let text = fs::read_to_string(root().join(format!("tests/teleop/{name}.txt"))).unwrap();
    play(&mut Mill::start("ON_LOSS = hold\n", &[]), &text);
}

#[test]
fn a_user_logs_in_sends_runs_and_leaves() {
    use_case("run");
}

#[test]
fn a_user_cancels() {
    use_case("cancel");
}

/// With `TELEOP_CANCEL = block` the line in progress is executed to its end, also where that takes longer than a client may be
/// silent: it waits for the answer. Motion brakes at the begin of the next line.
#[test]
fn a_cancelled_job_ends_at_the_end_of_its_command() {
    let mut mill = Mill::start("ON_LOSS = hold\nTELEOP_CANCEL = block\n", &[]);
    mill.ready();
    play(
        &mut mill,
        "A> INGRESAR ana:TOKEN\nA< ACEPTADO\nA> ENVIAR_NUEVO G20 G1 X0.5 F1\nA< RECIBIDO\n\
         A> ENVIAR_AGREGAR G1 Y2 F6\nA< RECIBIDO\nA> EJECUTAR\nA starts\nA? AVANCE 5\n\
         A> CANCELAR\nA< CANCELADO\nA> AVANCE\nA< AVANCE 100\nA> SALIR\nA< ADIOS\nA closed\n",
    );
    assert_eq!(mill.number("joint.0.pos-cmd"), 0.5);
    assert!(mill.number("joint.1.pos-cmd") < 0.01);
    assert_eq!(mill.halcmd("getp motion.in-position").trim(), "TRUE");
}

#[test]
fn a_client_whose_address_is_not_listed_is_refused() {
    let mill = Mill::start("ON_LOSS = hold\nTELEOP_ALLOW = 192.0.2.0/24\n", &[]);
    let mut people = People::default();
    let answer = people.ask(&mill, "A", "AVANCE");
    assert!(answer.starts_with("DENEGADO PERMISO "), "{answer}");
    assert_eq!(people.hear(&mill, "A"), "(closed)");
    let mill = Mill::start("ON_LOSS = hold\nTELEOP_ALLOW = 192.0.2.0/24 127.0.0.0/8\n", &[]);
    assert_eq!(people.ask(&mill, "B", "INGRESAR ana:TOKEN"), "ACEPTADO");
}

#[test]
fn an_operator_adjusts() {
    use_case("adjust");
}

#[test]
fn an_operator_starts_and_stops_the_server() {
    use_case("server");
}

#[test]
fn local_and_remote_jobs_exclude_each_other() {
    use_case("local");
}

#[test]
fn a_machine_that_is_not_ready_and_a_program_that_is_wrong_are_refused() {
    use_case("refused");
}

#[test]
fn an_operator_configures_and_starts_again() {
    let mut mill = Mill::start("ON_LOSS = hold\n", &[]);
    let mut people = People::default();
    assert_eq!(people.ask(&mill, "A", "INGRESAR ana:TOKEN"), "ACEPTADO");
    // The engine ends with the machine; every client is informed.
    mill.end_machine();
    assert_eq!(people.hear(&mill, "A"), "DESCONEXION");
    assert_eq!(people.hear(&mill, "A"), "(closed)");
    // Half as many steps to the inch, and another port.
    drop(mill);
    let half = ("maxnc.ini", "SCALE = 4000", "SCALE = 2000");
    let mill = Mill::with("ON_LOSS = hold\n", &["--teleop", "127.0.0.1:0"], &[half]);
    mill.ready();
    let mut people = People::default();
    assert_eq!(people.ask(&mill, "A", "INGRESAR ana:TOKEN"), "ACEPTADO");
    assert_eq!(people.ask(&mill, "A", "ENVIAR_NUEVO G20 G0 X0.5 M2"), "RECIBIDO");
    assert_eq!(people.ask(&mill, "A", "EJECUTAR"), "TERMINADO");
    assert_eq!(mill.number("stepgen.0.counts"), 1000.0);
}
