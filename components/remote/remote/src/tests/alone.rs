//! A machine without motion, whose robot moves by its own controller.

use crate::{Remote, numbers};
use hal_bench::Bench;

const PERIOD: i64 = 1_000_000;

fn pass(bench: &Bench, ms: u32) {
    for n in 0..ms {
        bench.pass(PERIOD);
        bench.run("remote", PERIOD);
        if n % 10 == 0 {
            bench.run("remote-keeper", 10 * PERIOD);
        }
    }
}

/// Loses the lease while the robot runs; returns the bench.
fn lost(on_loss: &str) -> Bench {
    numbers::begin_anew();
    let mut bench = Bench::new();
    bench.load::<Remote>(&["motion=0", on_loss]).unwrap();
    pass(&bench, 20);
    bench.command("remote.take", &["holder=ana"]).unwrap();
    bench.command("remote.start", &["lease=1"]).unwrap();
    bench.set("remote.job", true);
    pass(&bench, 500);
    assert!(!bench.get::<bool>("remote.hold") && !bench.get::<bool>("remote.abort"));
    // No beat keeps the lease.
    pass(&bench, 1000);
    assert!(!bench.get::<bool>("remote.present"));
    bench
}

#[test]
fn a_lost_lease_holds_the_robot_until_a_person_releases_it() {
    let bench = lost("on_loss=hold");
    assert!(bench.get::<bool>("remote.hold"));
    pass(&bench, 60_000);
    assert!(bench.get::<bool>("remote.hold"), "time releases nothing");
    bench.command("remote.release", &[]).unwrap();
    pass(&bench, 20);
    assert!(!bench.get::<bool>("remote.hold"));
    let bench = lost("on_loss=hold");
    bench.set("remote.job", false);
    pass(&bench, 20);
    assert!(!bench.get::<bool>("remote.hold"), "an end of the run leaves nothing to hold");
}

#[test]
fn a_lost_lease_ends_the_robots_run_or_leaves_it() {
    let bench = lost("on_loss=abort");
    let mut edges = 0;
    for _ in 0..100 {
        let was = bench.get::<bool>("remote.abort");
        pass(&bench, 10);
        edges += u32::from(!was && bench.get::<bool>("remote.abort"));
    }
    assert!(edges >= 3, "a stop that is missed comes again: {edges}");
    bench.set("remote.job", false);
    pass(&bench, 20);
    assert!(!bench.get::<bool>("remote.abort"));
    let bench = lost("on_loss=continue");
    assert!(!bench.get::<bool>("remote.hold") && !bench.get::<bool>("remote.abort"));
}

#[test]
fn a_machine_without_motion_says_so_and_jogs_nothing() {
    let why = Bench::new().load::<Remote>(&[]).unwrap_err();
    assert!(why.contains("loadrt motmod first, or motion=0"), "{why}");
    numbers::begin_anew();
    let mut bench = Bench::new();
    bench.load::<Remote>(&["motion=0"]).unwrap();
    pass(&bench, 20);
    bench.command("remote.take", &["holder=ana"]).unwrap();
    let jog = ["lease=1", "joint=0", "velocity=1", "distance=1"];
    let why = bench.command("remote.jog", &jog).unwrap_err();
    assert_eq!(why, "this machine has no motion that could jog");
}

#[test]
fn the_number_of_a_lease_counts_no_more_after_the_plugin_was_loaded_again() {
    numbers::begin_anew();
    let load = || {
        let mut bench = Bench::new();
        bench.load::<Remote>(&["motion=0"]).unwrap();
        bench
    };
    let before = load();
    assert_eq!(before.command("remote.take", &["holder=ana"]).unwrap(), ["lease=1"]);
    drop(before);
    let bench = load();
    assert_eq!(bench.command("remote.take", &["holder=eva"]).unwrap(), ["lease=2"]);
    for name in ["remote.start", "remote.give", "remote.beat", "remote.tool-changed"] {
        let pulse: &[&str] =
            if name == "remote.beat" { &["lease=1", "pulse=1"] } else { &["lease=1"] };
        let why = bench.command(name, pulse).unwrap_err();
        assert!(why.starts_with("this is not the number of the control lease"), "{name}: {why}");
    }
    // An engine whose clock is behind is one of its own: the same script gives the same numbers.
    (0..60).for_each(|_| bench.pass(PERIOD));
    bench.command("remote.give", &["lease=2"]).unwrap();
    assert_eq!(bench.command("remote.take", &["holder=eva"]).unwrap(), ["lease=3"]);
    drop(bench);
    let bench = load();
    assert_eq!(bench.command("remote.take", &["holder=ana"]).unwrap(), ["lease=1"]);
    // A process that is started later goes on behind the clock.
    numbers::begin_anew();
    let mut bench = Bench::new();
    (0..3000).for_each(|_| bench.pass(PERIOD));
    bench.load::<Remote>(&["motion=0"]).unwrap();
    assert_eq!(bench.command("remote.take", &["holder=eva"]).unwrap(), ["lease=193"]);
}
