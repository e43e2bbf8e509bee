//! Packets that are lost, late, doubled or cut; a card that is gone, and one that comes back.

use super::{PERIOD, Rig, last_card};

#[test]
fn one_lost_packet_in_a_hundred_moves_nothing_else() {
    let rig = Rig::new("7i92");
    rig.stepgen(1000.0, 500.0);
    rig.set("sim.line.lost", 10_000_u32);
    let mut lost = 0;
    for n in 0..20_000_i32 {
        // A ramp of 5 units a second up and down, with soft ends.
        let phase = f64::from(n) * 0.001;
        let goal = 2.0 * (1.0 - libm::cos(phase));
        rig.set("stepgen.00.position-cmd", goal);
        rig.cycle();
        lost += u32::from(rig.bit("packet-error"));
        let off = (rig.float("sim.stepgen.00.steps") / 1000.0 - goal).abs();
        assert!(off < 0.02, "{n}: {off}");
        assert!(!rig.bit("io_error"), "{n}: level {}", rig.int("packet-error-level"));
    }
    assert!((100..1000).contains(&lost), "{lost}");
    let total: u32 = rig.bench.get(&rig.at("packet-error-total"));
    assert_eq!(total, lost);
}

#[test]
fn what_is_late_doubled_or_cut_changes_no_pin_wrongly() {
    for fault in ["late", "doubled", "cut"] {
        let rig = Rig::new("7i92");
        rig.set(&format!("sim.line.{fault}"), 300_000_u32);
        rig.set("packet-error-limit", 1_000_000);
        let mut counts = 0;
        for n in 0..5000 {
            counts += 5;
            rig.set("sim.encoder.00.counts", counts);
            rig.cycle();
            let seen = rig.int("encoder.00.count");
            assert!((0..=counts).contains(&seen) && counts - seen < 100, "{fault} {n}: {seen}");
        }
        let errors: u32 = rig.bench.get(&rig.at("packet-error-total"));
        assert_eq!(errors > 0, fault != "doubled", "{fault}: {errors}");
    }
}

/// An order to latch that is lost must not look like an index that has come.
#[test]
fn an_index_counts_only_where_it_is_however_many_packets_are_lost() {
    let rig = Rig::new("7i92");
    rig.set("sim.encoder.00.counts-per-index", 4000_u32);
    rig.set("packet-error-limit", 1_000_000);
    rig.cycles(2);
    rig.set("sim.line.lost", 200_000_u32);
    let (mut counts, mut found) = (0_i32, 0);
    let mut before = 0;
    for n in 0..200_000 {
        counts += 3;
        rig.set("sim.encoder.00.counts", counts);
        let armed = rig.bit("encoder.00.index-enable");
        rig.cycle();
        if armed && !rig.bit("encoder.00.index-enable") {
            found += 1;
            let zero = rig.int("encoder.00.rawcounts") - rig.int("encoder.00.count");
            assert_eq!(zero.rem_euclid(4000), before, "{n}: zero at {zero}");
        }
        if n % 3000 == 0 {
            if found == 0 && n > 0 {
                panic!("no index in {n} cycles");
            }
            if n == 0 {
                // The first one without losses tells where the index is.
                rig.set("sim.line.lost", 0_u32);
                rig.set("encoder.00.index-enable", true);
                while rig.bit("encoder.00.index-enable") {
                    counts += 3;
                    rig.set("sim.encoder.00.counts", counts);
                    rig.cycle();
                }
                let zero = rig.int("encoder.00.rawcounts") - rig.int("encoder.00.count");
                before = zero.rem_euclid(4000);
                found = 1;
                rig.set("sim.line.lost", 200_000_u32);
            }
            rig.set("encoder.00.index-enable", true);
        }
    }
    assert!(found > 40, "{found}");
}

#[test]
fn a_card_without_an_answer_is_abandoned_and_nothing_starts_by_itself() {
    let rig = Rig::new("7i92");
    rig.stepgen(1000.0, 0.0);
    rig.set("stepgen.00.control-type", true);
    rig.set("stepgen.00.velocity-cmd", 5.0);
    rig.cycles(100);
    assert_eq!(rig.bench.failed_hardware(), 0);
    rig.set("sim.line.plugged", false);
    // The limit of 10 with 2 for each error: five cycles.
    rig.cycles(4);
    assert_eq!((rig.bit("io_error"), rig.bench.failed_hardware()), (false, 0));
    rig.cycle();
    assert!(rig.bit("io_error") && rig.bit("packet-error-exceeded"));
    assert_eq!(rig.bench.failed_hardware(), 1, "the motion controller must be off in this cycle");
    rig.cycles(10);
    assert!(rig.bit("sim.watchdog-bitten"), "5 ms without a packet");
    let said = rig.bench.said();
    assert!(said.iter().any(|text| text.contains("is abandoned")), "{said:?}");
    // The cable comes back: still nothing moves.
    let steps = rig.float("sim.stepgen.00.steps");
    rig.set("sim.line.plugged", true);
    rig.cycles(100);
    assert!(rig.bit("io_error"));
    // A person begins again, and is informed that the watchdog has bitten.
    rig.set("io_error", false);
    rig.cycles(3);
    assert!(rig.bit("watchdog.has_bit") && rig.bit("sim.watchdog-bitten"));
    assert_eq!(rig.bench.failed_hardware(), 1);
    rig.set("watchdog.has_bit", false);
    rig.cycles(3);
    assert!(!rig.bit("sim.watchdog-bitten") && !rig.bit("watchdog.has_bit"));
    assert_eq!(rig.bench.failed_hardware(), 0);
    rig.cycles(1000);
    assert!((rig.float("sim.stepgen.00.steps") - steps).abs() > 4000.0);
}

#[test]
fn the_watchdog_bites_when_nothing_is_written() {
    let rig = Rig::new("7i92");
    rig.set("gpio.010.is_output", true);
    rig.set("gpio.010.out", true);
    rig.set("sim.in-010", false);
    rig.cycles(10);
    assert!(rig.bit("sim.out-010"));
    for n in 0..10 {
        rig.bench.pass(PERIOD);
        rig.bench.run(&rig.at("read"), PERIOD);
        // After 5,000,000 ns.
        assert_eq!(rig.bit("sim.watchdog-bitten"), n >= 4, "{n}");
    }
    assert!(rig.bit("watchdog.has_bit") && !rig.bit("sim.out-010"));
    assert_eq!(rig.bench.failed_hardware(), 1);
    // Writing alone changes nothing: a person must look.
    rig.cycles(100);
    assert!(rig.bit("watchdog.has_bit") && !rig.bit("sim.out-010"));
    rig.set("watchdog.has_bit", false);
    rig.cycles(2);
    assert!(rig.bit("sim.out-010") && !rig.bit("watchdog.has_bit"));
    let said = rig.bench.said();
    assert_eq!(said.len(), 1, "{said:?}");
}

/// A watchdog with less time than a period bites in each cycle, and each time it is said.
#[test]
fn a_watchdog_that_bites_again_is_seen_again() {
    let rig = Rig::new("7i92");
    rig.set("watchdog.timeout_ns", 800_000_u32);
    rig.cycles(3);
    for n in 0..5 {
        assert!(rig.bit("watchdog.has_bit"), "{n}");
        rig.set("watchdog.has_bit", false);
        rig.cycle();
        assert_eq!(rig.bench.failed_hardware(), 1, "{n}");
        rig.cycle();
    }
    assert!(rig.bench.said().len() >= 5);
}

#[test]
fn a_stop_makes_all_outputs_inputs_at_once() {
    let rig = Rig::new("7i92");
    rig.set("gpio.010.is_output", true);
    rig.set("gpio.010.out", true);
    rig.set("sim.in-010", false);
    rig.cycles(10);
    rig.bench.stop();
    rig.bench.pass(1000);
    rig.bench.run(&rig.at("read"), PERIOD);
    assert!(rig.bit("sim.watchdog-bitten") && !rig.bit("sim.out-010"));
}

/// The generator counts on where nothing asks, but the watchdog holds its pulses back.
#[test]
fn an_abandoned_card_goes_on_without_pulses() {
    let rig = Rig::new("7i92");
    rig.stepgen(1000.0, 500.0);
    rig.set("stepgen.00.control-type", true);
    rig.set("stepgen.00.velocity-cmd", 5.0);
    rig.cycles(500);
    let [steps, emitted] = ["steps", "emitted"].map(|pin| format!("sim.stepgen.00.{pin}"));
    assert!((rig.float(&steps) - rig.float(&emitted)).abs() <= 1.0);
    rig.set("sim.line.plugged", false);
    rig.cycles(20);
    assert!(rig.bit("io_error") && rig.bit("sim.watchdog-bitten"));
    let before = [&steps, &emitted].map(|pin| rig.float(pin));
    rig.cycles(1000);
    assert!((rig.float(&steps) - before[0] - 5000.0).abs() < 1.0, "it counts");
    assert_eq!(rig.float(&emitted).to_bits(), before[1].to_bits(), "nothing moves");
}

/// A card whose outputs are off comes back only after a person has seen it.
#[test]
fn a_bite_never_ends_unseen_however_many_packets_are_lost() {
    let rig = Rig::new("7i92");
    rig.set("packet-error-limit", 1_000_000);
    rig.cycles(2);
    rig.set("sim.line.lost", 500_000_u32);
    let (mut bites, mut was_seen, mut before) = (0, false, false);
    for n in 0..50_000 {
        rig.cycle();
        let bitten = rig.bit("sim.watchdog-bitten");
        was_seen |= rig.bit("watchdog.has_bit");
        if bitten && !before {
            bites += 1;
        }
        if before && !bitten {
            assert!(was_seen, "{n}: outputs are on again, and nobody was told");
            was_seen = false;
        }
        before = bitten;
        if n % 50 == 0 {
            rig.set("watchdog.has_bit", false);
        }
    }
    assert!(bites > 100, "{bites}");
}

/// The thread is late by more than the watchdog waits, right after a release that the card has received.
#[test]
fn a_bite_behind_a_release_that_nobody_has_confirmed_is_seen() {
    for timeout_ns in [5_000_000_u32, 800_000] {
        let rig = Rig::new("7i92");
        rig.set("watchdog.timeout_ns", timeout_ns);
        rig.cycles(3);
        rig.bench.pass(20 * PERIOD);
        rig.bench.run(&rig.at("read"), PERIOD);
        assert!(rig.bit("watchdog.has_bit") && rig.bit("sim.watchdog-bitten"));
        rig.set("watchdog.has_bit", false);
        rig.bench.run(&rig.at("write"), PERIOD);
        rig.bench.pass(20 * PERIOD);
        rig.bench.run(&rig.at("write"), PERIOD);
        rig.bench.run(&rig.at("read"), PERIOD);
        assert!(rig.bit("sim.watchdog-bitten"), "{timeout_ns}: the outputs stay off");
        assert!(rig.bit("watchdog.has_bit"), "{timeout_ns}: a person is told again");
    }
}

/// An index that was armed before the card was lost has not come because the card has forgotten it.
#[test]
fn an_index_that_was_armed_before_the_card_was_abandoned_does_not_count() {
    for before_the_loss in [true, false] {
        let rig = Rig::new("7i92");
        rig.set("packet-error-limit", 6);
        rig.cycles(2);
        rig.set("encoder.00.index-enable", before_the_loss);
        rig.cycles(2);
        rig.set("sim.line.lost", 1_000_000_u32);
        rig.cycles(10);
        assert!(rig.bit("io_error"));
        rig.set("encoder.00.index-enable", true);
        rig.set("sim.line.lost", 0_u32);
        rig.set("io_error", false);
        rig.set("watchdog.has_bit", false);
        rig.cycles(10);
        assert!(rig.bit("encoder.00.index-enable"), "no index has come");
    }
}

/// An answer to a question from before the loss is none to one behind it.
#[test]
fn a_question_of_before_the_loss_is_forgotten() {
    let rig = Rig::new("7i92");
    rig.cycles(2);
    rig.set("sim.encoder.00.counts", 100);
    rig.cycles(2);
    rig.bench.run(&rig.at("read-request"), PERIOD);
    rig.set("io_error", true);
    rig.cycle();
    rig.set("sim.encoder.00.counts", 200);
    rig.cycles(5);
    rig.set("io_error", false);
    rig.cycle();
    assert_eq!(rig.int("encoder.00.rawcounts"), 200);
}

/// Each message of a card that runs begins with the card's name.
#[test]
fn each_loss_is_said_with_the_name_of_the_card() {
    let lost = |rig: &Rig, n: u32| rig.set("sim.line.lost", n);
    // (cause, expected beginning)
    type Cause = fn(&Rig, &dyn Fn(&Rig, u32));
    let causes: [(Cause, &str); 7] = [
        (
            |rig, lost| {
                lost(rig, 1_000_000);
                rig.cycle();
            },
            "no answer in packet-read-timeout (receiving): its inputs keep their values",
        ),
        (
            |rig, lost| {
                rig.set("packet-error-limit", 1_000_000);
                lost(rig, 300_000);
                rig.cycles(200);
            },
            "the card had missed the last packet of writes (sending): all is written again",
        ),
        (
            |rig, lost| {
                lost(rig, 1_000_000);
                rig.cycles(10);
            },
            "packet-error-level has reached packet-error-limit: the card is abandoned (io_error)",
        ),
        (
            |rig, _| {
                for _ in 0..10 {
                    rig.bench.pass(PERIOD);
                    rig.bench.run(&rig.at("read"), PERIOD);
                }
            },
            "the card's watchdog has bitten, because no packet of the write function came",
        ),
        (
            // While somebody else has the device, it fails with EBUSY.
            |rig, _| last_card().with(|_| rig.cycle()).unwrap(),
            "the network reports error 16 in place of an answer: its inputs keep their values",
        ),
        (
            |rig, _| last_card().with(|_| rig.cycle()).unwrap(),
            "the network does not take the packet of writes (error 16); it is tried again",
        ),
        (
            |rig, _| {
                rig.set("encoder.00.quad-error-enable", true);
                rig.cycles(3);
                rig.set("sim.encoder.00.counts", 1_000_002);
                rig.cycles(3);
                assert!(rig.bit("encoder.00.quad-error"));
            },
            "encoder.00: A and B changed together: counts are lost",
        ),
    ];
    for (cause, expected) in causes {
        let rig = Rig::new("7i92");
        rig.cycles(3);
        cause(&rig, &lost);
        let said = rig.bench.said();
        let named = |line: &String| line.contains("hm2_7i92.0") && line.contains(expected);
        assert!(said.iter().any(named), "{expected}: {said:?}");
        assert!(said.iter().all(|line| !line.contains("{}")), "{said:?}");
    }
}
