//! Clients that vanish while their job runs: by a cut, by silence, and with the panel itself.

use super::{
    PART,
    mill::{Mill, People},
};
use hal_tests::scratch::until;
use rustix::process::Signal;
use serde_json::json;

/// Steps of X at the end of the part.
const END: f64 = 8000.0;

/// Starts the part and lets it move.
fn begin(mill: &Mill) -> People {
    mill.ready();
    let mut people = People::default();
    assert_eq!(people.ask(mill, "A", "INGRESAR ana:TOKEN"), "ACEPTADO");
    people.say(mill, "A", "ENVIAR_NUEVO");
    assert_eq!(people.ask(mill, "A", &format!("{}\r\n.", PART.replace('\n', "\r\n"))), "RECIBIDO");
    people.say(mill, "A", "EJECUTAR");
    mill.until("the job runs", || mill.halcmd("getp teleop.running").trim() == "TRUE");
    mill.run("2s");
    assert_eq!(mill.halcmd("getp teleop.link-ok").trim(), "TRUE");
    let x = mill.number("stepgen.0.counts");
    assert!(0.0 < x && x < END / 2.0, "the job moves: {x}");
    people
}

/// Waits until the client is known to have vanished, and lets the machine brake.
fn vanished(mill: &Mill) {
    mill.until("the loss is known", || mill.halcmd("getp teleop.link-ok").trim() == "FALSE");
    mill.until("the lease has ended", || mill.halcmd("getp remote.lease").trim() == "0");
    mill.run("1s");
}

/// The job is held where it is, until a person at the machine lets it go on to its end.
fn is_held(mill: &Mill) {
    let x = mill.number("stepgen.0.counts");
    assert!(0.0 < x && x < END, "{x}");
    mill.run("20s");
    assert_eq!(mill.number("stepgen.0.counts"), x);
    assert_eq!(mill.halcmd("getp motion.current-vel").trim(), "0");
    assert_eq!(mill.halcmd("getp motion.feed-inhibit").trim(), "TRUE");
    // A new session of the same person changes nothing.
    let mut people = People::default();
    assert_eq!(people.ask(mill, "A", "INGRESAR ana:TOKEN"), "ACEPTADO");
    let refused = people.ask(mill, "A", "CANCELAR");
    assert!(refused == "ERROR PERMISO the job is another session's", "{refused}");
    people.say(mill, "A", "ENVIAR_NUEVO G20 G0 X0 M2");
    assert_eq!(people.hear(mill, "A"), "RECIBIDO");
    let refused = people.ask(mill, "A", "EJECUTAR");
    assert!(refused == "ERROR_EJECUTAR OCUPADO another job runs", "{refused}");
    mill.run("5s");
    assert_eq!(mill.number("stepgen.0.counts"), x);
    mill.halcmd("remote.release");
    ends(mill);
}

/// The job goes on to its end.
fn ends(mill: &Mill) {
    mill.until_no_job_runs();
    mill.run("1s");
    assert_eq!(mill.number("stepgen.0.counts"), END);
    assert!(mill.halcmd("task.status").contains("jobs=1 failed=0"));
}

#[test]
fn a_job_of_a_client_that_is_cut_holds() {
    let mill = Mill::start("ON_LOSS = hold\n", &[]);
    let mut people = begin(&mill);
    people.cut("A");
    vanished(&mill);
    is_held(&mill);
}

#[test]
fn a_job_of_a_client_that_is_silent_for_ten_seconds_holds() {
    let mill = Mill::start("ON_LOSS = hold\n", &[]);
    let mut people = begin(&mill);
    // 2 s have passed.
    mill.run("7s");
    // The panel looks at the machine on its own clock: it answers with the last progress that it has seen.
    let share = || 100.0 * mill.number("stepgen.0.counts") / END;
    let from = share().floor();
    until("the panel has seen where the job is", || {
        let progress = people.ask(&mill, "A", "AVANCE");
        let percent: f64 = progress.strip_prefix("AVANCE ").unwrap().parse().unwrap();
        assert!(percent <= share(), "{progress}");
        from <= percent
    });
    mill.run("9s");
    assert_eq!(mill.halcmd("getp remote.hold").trim(), "FALSE");
    mill.run("2500ms");
    assert_eq!(mill.halcmd("getp remote.hold").trim(), "TRUE");
    let x = mill.number("stepgen.0.counts");
    mill.run("5s");
    assert_eq!(mill.number("stepgen.0.counts"), x);
    // Its owner is still there, and may cancel it; nothing that it says lets it go on.
    assert!(people.ask(&mill, "A", "AVANCE").starts_with("AVANCE 9"));
    mill.run("5s");
    assert_eq!(mill.number("stepgen.0.counts"), x);
    assert_eq!(people.ask(&mill, "A", "CANCELAR"), "CANCELADO");
    assert_eq!(people.ask(&mill, "A", "SALIR"), "ADIOS");
}

#[test]
fn a_lease_that_a_page_has_taken_is_kept_by_that_page_alone() {
    let mill = Mill::start("ON_LOSS = hold\n", &["--role", "integrator"]);
    let mut people = begin(&mill);
    mill.halcmd("task.pause");
    let mut page = mill.page();
    let take = page.ask(json!({ "type": "lease", "do": "take", "force": true }));
    assert_eq!(take["ok"], json!({}), "{take}");
    until("the page's beats count", || {
        mill.run("10ms");
        mill.halcmd("getp remote.permit").trim() == "TRUE" || {
            assert_eq!(page.command("optional-stop", &json!({ "on": true })), "");
            false
        }
    });
    // The page says nothing more, while the client of the job does.
    assert!(people.ask(&mill, "A", "AVANCE").starts_with("AVANCE "));
    mill.run("100ms");
    assert_eq!(mill.halcmd("getp remote.permit").trim(), "FALSE");
    mill.run("1s");
    assert_eq!(mill.halcmd("getp remote.lease").trim(), "0");
}

#[test]
fn a_job_whose_panel_is_killed_holds() {
    let mut mill = Mill::start("ON_LOSS = hold\n", &[]);
    drop(begin(&mill));
    // The cut may come first; the job holds in either case.
    mill.pair.panel.signal(Signal::KILL);
    mill.pair.panel.ended().unwrap();
    mill.until("the lease has ended", || mill.halcmd("getp remote.lease").trim() == "0");
    mill.run("1s");
    let x = mill.number("stepgen.0.counts");
    mill.run("20s");
    assert_eq!(mill.number("stepgen.0.counts"), x);
    assert_eq!(mill.halcmd("getp motion.feed-inhibit").trim(), "TRUE");
    mill.halcmd("remote.release");
    ends(&mill);
}

#[test]
fn a_job_of_a_vanished_client_goes_on_or_is_aborted_as_the_machine_says() {
    let mill = Mill::start("ON_LOSS = continue\n", &[]);
    let mut people = begin(&mill);
    people.cut("A");
    vanished(&mill);
    assert_eq!(mill.halcmd("getp motion.feed-inhibit").trim(), "FALSE");
    ends(&mill);
    drop(mill);

    let mill = Mill::start("ON_LOSS = abort\n", &[]);
    let mut people = begin(&mill);
    people.cut("A");
    mill.until("the job ends", || mill.halcmd("getp task.job").trim() == "FALSE");
    mill.run("1s");
    let x = mill.number("stepgen.0.counts");
    assert!(0.0 < x && x < END, "{x}");
    assert!(mill.halcmd("task.status").contains("jobs=1 failed=1"));
    mill.run("5s");
    assert_eq!(mill.number("stepgen.0.counts"), x);
    // The machine is free for the next one.
    assert_eq!(people.ask(&mill, "B", "INGRESAR eva:TOKEN"), "ACEPTADO");
    assert_eq!(people.ask(&mill, "B", "ENVIAR_NUEVO G20 G0 X0 M2"), "RECIBIDO");
    assert_eq!(people.ask(&mill, "B", "EJECUTAR"), "TERMINADO");
    assert_eq!(mill.number("stepgen.0.counts"), 0.0);
}

#[test]
fn the_end_of_the_panel_cancels_a_job_and_tells_everybody() {
    let mut mill = Mill::start("ON_LOSS = hold\n", &[]);
    let mut people = begin(&mill);
    mill.pair.panel.signal(Signal::TERM);
    assert_eq!(people.hear(&mill, "A"), "ERROR_EJECUTAR DETENIDO the server stops");
    assert_eq!(people.hear(&mill, "A"), "DESCONEXION");
    assert_eq!(people.hear(&mill, "A"), "(closed)");
    mill.until("the panel ends", || mill.halcmd("getp task.job").trim() == "FALSE");
    assert!(mill.pair.panel.ended().is_some_and(|status| status.success()));
}
