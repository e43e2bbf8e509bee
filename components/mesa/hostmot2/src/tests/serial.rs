//! Remotes of smart serial: their data, and what happens when one falls out.

use super::{PERIOD, Rig, card, last_card};
use crate::{
    Hm2Eth, ask,
    modules::sserial::{Addresses, Description, RemoteMemory, Talk},
    simulated::SimulatedLine,
};
use hal_bench::Bench;
use hal_firmware::Tag;

/// Returns a 7I76E whose remote runs in a mode.
fn running(config: &str) -> Rig {
    let rig = Rig::with("7i76e", config);
    rig.cycles(5);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
    rig
}

#[test]
fn inputs_and_outputs_are_those_of_the_remote() {
    let rig = running("sserial_port_0=2");
    let at = |pin: &str| format!("7i76.0.0.{pin}");
    let sim = |pin: &str| format!("sim.7i76.0.0.{pin}");
    for n in [0, 5, 31] {
        let (input, not) = (at(&format!("input-{n:02}")), at(&format!("input-{n:02}-not")));
        for level in [true, false] {
            rig.set(&sim(&format!("input-{n:02}")), level);
            rig.cycles(2);
            assert_eq!((rig.bit(&input), rig.bit(&not)), (level, !level), "{n}");
        }
    }
    for n in [0, 3, 15] {
        for (level, invert) in [(true, false), (true, true), (false, true), (false, false)] {
            rig.set(&at(&format!("output-{n:02}")), level);
            rig.set(&at(&format!("output-{n:02}-invert")), invert);
            rig.cycle();
            assert_eq!(rig.bit(&sim(&format!("output-{n:02}"))), level != invert, "{n}");
        }
    }
    rig.set(&at("spindir"), true);
    rig.set(&at("spinena-invert"), true);
    rig.cycle();
    assert_eq!((rig.word(&sim("spindir")), rig.word(&sim("spinena"))), (255, 255));
}

#[test]
fn numbers_have_their_units() {
    let rig = running("sserial_port_0=2");
    let at = |pin: &str| format!("7i76.0.0.{pin}");
    let sim = |pin: &str| format!("sim.7i76.0.0.{pin}");
    for (wish, got) in [(50.0, 50.0), (-3.0, 0.0), (170.0, 100.0), (f64::NAN, 0.0)] {
        rig.set(&at("spinout"), wish);
        rig.cycle();
        assert!((rig.float(&sim("spinout")) - got).abs() < 0.002, "{wish}");
    }
    rig.set(&at("spinout-maxlim"), 1500.0);
    rig.set(&at("spinout-scalemax"), 3000.0);
    rig.set(&at("spinout"), 2000.0);
    rig.cycle();
    assert!((rig.float(&sim("spinout")) - 50.0).abs() < 0.002);
    // Bounds that cross, and a scale of 0, send a number all the same.
    for (pin, value) in [("spinout-minlim", 9e9), ("spinout-scalemax", 0.0)] {
        rig.set(&at(pin), value);
        rig.cycle();
        assert!((0.0..=100.0).contains(&rig.float(&sim("spinout"))));
    }
    for volts in [0.0, 12.1, 36.3] {
        rig.set(&sim("analogin2"), volts);
        rig.set(&sim("fieldvoltage"), volts);
        rig.cycles(2);
        for pin in ["analogin2", "fieldvoltage"] {
            assert!((rig.float(&at(pin)) - volts).abs() < 0.08, "{pin}");
        }
    }
    rig.set(&at("analogin2-scalemax"), 100.0);
    rig.cycles(2);
    assert!((rig.float(&at("analogin2")) - 100.0).abs() < 1e-9);
}

#[test]
fn signed_numbers_and_streams_reach_their_remotes() {
    let rig = Rig::with("7i92 0.0=7i77-analog 0.1=7i73", "sserial_port_0=02");
    rig.cycles(5);
    for (volts, number) in [(5.0, 0x400), (-10.0, 0x800), (10.0, 0x7FF), (-99.0, 0x800_u32)] {
        rig.set("7i77.0.0.analogout0", volts);
        rig.set("7i77.0.0.analogout5", -volts);
        rig.cycle();
        assert_eq!(rig.word("sim.7i77.0.0.analogout0"), number, "{volts}");
    }
    assert_eq!(rig.word("sim.7i77.0.0.analogout5"), 0x7FF);
    rig.set("7i73.0.1.display32", 0x4142_4344_u32);
    rig.set("7i73.0.1.display", 0xFFF_u32);
    rig.cycle();
    assert_eq!(rig.word("sim.7i73.0.1.display32"), 0x4142_4344);
    assert_eq!(rig.word("sim.7i73.0.1.display"), 0xFF);
}

#[test]
fn a_hand_wheel_counts_over_its_end_and_is_reset() {
    let rig = Rig::new("7i96s 0.0=7i73");
    rig.set("sim.7i73.0.0.enc1", 250_u32);
    rig.cycles(6);
    assert_eq!(rig.int("7i73.0.0.enc1.count"), 0);
    rig.set("7i73.0.0.enc1.scale", 4.0);
    for raw in [254, 3, 10, 3, 251_u32] {
        rig.set("sim.7i73.0.0.enc1", raw);
        rig.cycles(2);
    }
    assert_eq!(rig.int("7i73.0.0.enc1.count"), 1);
    assert!((rig.float("7i73.0.0.enc1.position") - 0.25).abs() < 1e-12);
    rig.set("7i73.0.0.enc1.reset", true);
    rig.cycles(2);
    rig.set("7i73.0.0.enc1.reset", false);
    rig.set("sim.7i73.0.0.enc1", 249_u32);
    rig.cycles(2);
    assert_eq!((rig.int("7i73.0.0.enc1.count"), rig.int("7i73.0.0.enc1.rawcounts")), (-2, -1));
    // A remote that was started again may have another count.
    rig.set("sserial.port-0.run", false);
    rig.cycles(5);
    rig.set("sim.7i73.0.0.enc1", 77_u32);
    rig.set("sserial.port-0.run", true);
    rig.cycles(8);
    assert_eq!(rig.int("7i73.0.0.enc1.count"), -2);
}

#[test]
fn a_mode_that_a_remote_lacks_is_refused() {
    let names = card("7i76e", "sserial_port_0=1").names().join("\n");
    assert!(names.contains("analogin0") && !names.contains("fieldvoltage"));
    let off = card("7i76e", "sserial_port_0=x").names().join("\n");
    assert!(!off.contains("7i76.0.0") && off.contains("hm2_7i76e.0.gpio.010.out "));
    let mut bench = Bench::new();
    let refused = bench.load::<Hm2Eth>(&["card=7i76e", "config=sserial_port_0=7"]).unwrap_err();
    assert!(
        refused.contains("'sserial_port_0': the remote 7i76 at channel 0 has no mode 7"),
        "{refused}"
    );
    for bad in ["7i76e 0.9=7i76", "7i76e 0.0=7i99", "7i76e 0.0", "7i92 x.0=7i76"] {
        let refused = Bench::new().load::<Hm2Eth>(&[&format!("card={bad}")]).unwrap_err();
        assert!(refused.contains("PORT.CHANNEL=REMOTE"), "{bad}: {refused}");
    }
}

#[test]
fn a_remote_that_falls_out_stops_its_port_and_nothing_starts_by_itself() {
    let rig = running("sserial_port_0=00");
    rig.set("7i76.0.0.output-04", true);
    rig.set("sim.7i76.0.0.input-04", true);
    rig.cycles(3);
    assert!(rig.bit("sim.7i76.0.0.output-04") && rig.bit("7i76.0.0.input-04"));
    rig.set("sim.7i76.0.0.plugged", false);
    rig.cycles(2);
    assert!(rig.bit("sserial.port-0.channel-0.fault"));
    assert_eq!(rig.word("sserial.port-0.fault-count"), 9);
    assert_eq!(rig.word("sserial.port-0.port_state2"), 1);
    assert_eq!(rig.bench.failed_hardware(), 0);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
    let said = rig.bench.said().join("\n");
    assert!(said.contains("hm2_7i76e.0.7i76.0.0") && said.contains("does not answer"), "{said}");
    // Each fault adds 10, and each cycle takes 1: with the 23rd the limit of 200 is reached, and the hardware has failed.
    rig.cycles(21);
    assert_eq!((rig.word("sserial.port-0.fault-count"), rig.bench.failed_hardware()), (198, 0));
    rig.cycle();
    assert_eq!((rig.word("sserial.port-0.fault-count"), rig.bench.failed_hardware()), (207, 1));
    rig.cycles(100);
    assert_eq!(rig.word("sserial.port-0.port_state"), 4);
    assert!(rig.bit("7i76.0.0.input-04"), "inputs keep their values");
    assert!(!rig.bit("sim.7i76.0.0.output-04"), "its own watchdog has switched the outputs off");
    let said = rig.bench.said().join("\n");
    assert!(
        said.contains("hm2_7i76e.0.sserial.port-0 is stopped") && said.contains(".run to 0"),
        "{said}"
    );
    // The cable is back.
    rig.set("sim.7i76.0.0.plugged", true);
    rig.set("sim.7i76.0.0.input-04", false);
    rig.cycles(200);
    assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (4, 1));
    assert!(rig.bit("7i76.0.0.input-04"));
    rig.set("7i76.0.0.output-04", false);
    rig.set("sserial.port-0.run", false);
    rig.cycles(5);
    assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (0, 0));
    rig.set("sserial.port-0.run", true);
    rig.cycles(6);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
    assert!(!rig.bit("7i76.0.0.input-04") && !rig.bit("sim.7i76.0.0.output-04"));
    assert!(!rig.bit("sserial.port-0.channel-0.fault"));
}

#[test]
fn a_port_whose_processor_hangs_is_stopped_and_says_the_command() {
    // While data are exchanged, and in a start.
    for (begins, command) in [(false, 4097.0), (true, 2048.0)] {
        let rig = running("sserial_port_0=0");
        let hang = |hangs| last_card().with(|inside| inside.card.hang_serial(0, hangs)).unwrap();
        if begins {
            rig.set("sserial.port-0.run", false);
            rig.cycles(5);
            hang(true);
            rig.set("sserial.port-0.run", true);
        } else {
            hang(true);
        }
        rig.cycles(5000);
        assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (4, 1));
        let said = rig.bench.said().join("\n");
        let text = format!("hm2_7i76e.0.sserial.port-0: command {command} is not finished");
        assert_eq!(said.matches(&text).count(), 1, "{said}");
        // The processor works again: a person begins.
        hang(false);
        rig.cycles(100);
        assert_eq!(rig.bench.failed_hardware(), 1);
        rig.set("sserial.port-0.run", false);
        rig.cycles(5);
        rig.set("sserial.port-0.run", true);
        rig.cycles(10);
        assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (3, 0));
    }
}

#[test]
fn a_short_fault_is_counted_and_forgotten() {
    let rig = running("");
    rig.set("sim.7i76.0.0.plugged", false);
    rig.cycles(4);
    rig.set("sim.7i76.0.0.plugged", true);
    rig.cycles(3);
    let level = rig.word("sserial.port-0.fault-count");
    assert!((25..=40).contains(&level), "{level}");
    assert!(!rig.bit("sserial.port-0.channel-0.fault"));
    rig.cycles(40);
    assert_eq!(rig.word("sserial.port-0.fault-count"), 0);
    assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (3, 0));
    // With a limit of 1, one fault is too many; with an increment of 0, none is.
    rig.set("sserial.port-0.fault-inc", 0_u32);
    rig.set("sim.7i76.0.0.plugged", false);
    rig.cycles(30);
    assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (3, 0));
    rig.set("sserial.port-0.fault-inc", 1_u32);
    rig.set("sserial.port-0.fault-lim", 1_u32);
    rig.cycle();
    assert_eq!(rig.bench.failed_hardware(), 1);
}

#[test]
fn a_remote_that_is_absent_at_the_start_is_named() {
    let rig = Rig::new("7i92 0.2=7i84 0.3=7i71");
    rig.set("sim.7i71.0.3.plugged", false);
    rig.cycles(10);
    assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (4, 1));
    assert!(
        rig.bit("sserial.port-0.channel-3.fault") && !rig.bit("sserial.port-0.channel-2.fault")
    );
    let said = rig.bench.said();
    let said: Vec<_> = said.into_iter().filter(|line| !line.contains("has answered")).collect();
    let said = said.join("\n");
    assert!(said.contains("hm2_7i92.0.7i71.0.3 (unit") && !said.contains("7i84"), "{said}");
}

#[test]
fn a_pause_of_the_thread_switches_the_remotes_outputs_off() {
    let rig = running("");
    rig.set("watchdog.timeout_ns", 2_000_000_000_u32);
    rig.set("7i76.0.0.output-00", true);
    rig.cycles(2);
    rig.bench.pass(200 * PERIOD);
    rig.cycles(60);
    assert_eq!((rig.word("sserial.port-0.port_state"), rig.bench.failed_hardware()), (4, 1));
    assert!(!rig.bit("sim.7i76.0.0.output-00"));
    let said = rig.bench.said().join("\n");
    assert!(said.contains("watchdog has bitten, and its outputs are off"), "{said}");
}

#[test]
fn lost_packets_are_no_faults_of_remotes() {
    let rig = running("");
    rig.set("packet-error-limit", 1_000_000);
    rig.set("sim.line.lost", 100_000_u32);
    let mut right = 0;
    for n in 0..20_000_u32 {
        let level = n / 50 % 2 == 1;
        rig.set("sim.7i76.0.0.input-07", level);
        rig.set("7i76.0.0.output-07", level);
        rig.cycle();
        if n % 50 == 40 {
            assert_eq!(rig.bit("7i76.0.0.input-07"), level, "{n}");
            assert_eq!(rig.bit("sim.7i76.0.0.output-07"), level, "{n}");
            right += 1;
        }
        assert_eq!(rig.word("sserial.port-0.fault-count"), 0, "{n}");
    }
    assert_eq!(right, 400);
    assert!(rig.word("packet-error-total") > 1000);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
}

/// A packet that starts a port may be lost as well.
#[test]
fn a_port_starts_however_many_packets_are_lost() {
    let rig = Rig::new("7i76e");
    rig.set("packet-error-limit", 1_000_000);
    rig.set("watchdog.timeout_ns", 2_000_000_000_u32);
    rig.set("sim.line.lost", 400_000_u32);
    for round in 0..200 {
        rig.set("sserial.port-0.run", true);
        rig.cycles(500);
        assert_eq!(rig.word("sserial.port-0.port_state"), 3, "{round}");
        // A card that has not received the start would have remotes that are not ready.
        rig.cycles(200);
        assert_eq!(rig.word("sserial.port-0.port_state"), 3, "{round}");
        assert_eq!(rig.word("sserial.port-0.fault-count"), 0, "{round}");
        rig.set("sserial.port-0.run", false);
        rig.cycles(500);
        assert_eq!(rig.word("sserial.port-0.port_state"), 0, "{round}");
    }
    assert_eq!(rig.bench.failed_hardware(), 0);
}

/// Returns the value of a parameter that the remote at channel 0 of port 0 has, while the port is off.
fn parameter(name: &str) -> Option<u32> {
    let line = SimulatedLine(last_card());
    let card = ask::describe(&line).unwrap();
    let module = card.modules.iter().find(|m| m.kind() == Some(Tag::SmartSerial)).unwrap();
    let at = Addresses::new(module, &card.identification, 0).unwrap();
    let talk = Talk { device: &line, at };
    talk.stop().unwrap();
    let answered = talk.start(0, 0).unwrap()?;
    let mut memory = RemoteMemory { talk: &talk, channel: 0, fault: None };
    let description = Description::read(&mut memory, answered.data, answered.parameters).unwrap();
    let setting = description.settings.iter().find(|setting| setting.name == name)?;
    let value = talk.value(0, setting.at, 4, setting.lasts).unwrap();
    talk.stop().unwrap();
    value
}

#[test]
fn a_parameter_reaches_its_remote_while_the_port_does_not_run() {
    let rig = running("");
    assert_eq!(rig.word("7i76.0.0.nvwatchdogtimeout"), 50);
    rig.set("7i76.0.0.nvwatchdogtimeout", 1234_u32);
    rig.cycles(20);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
    rig.set("sserial.port-0.run", false);
    let mut states = Vec::new();
    for _ in 0..20 {
        rig.cycle();
        states.push(rig.word("sserial.port-0.port_state"));
    }
    assert!(states.contains(&7) && states.last() == Some(&0), "{states:?}");
    assert_eq!(parameter("nvwatchdogtimeout"), Some(1234));
    // What is not new is not sent again.
    rig.set("sserial.port-0.run", true);
    rig.cycles(10);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
    // A value that was set before the thread ran is sent before the port starts.
    let rig = Rig::new("7i76e");
    rig.set("7i76.0.0.nvwatchdogtimeout", 4321_u32);
    rig.cycles(20);
    assert_eq!(rig.word("sserial.port-0.port_state"), 3);
    rig.set("sserial.port-0.run", false);
    rig.cycles(5);
    assert_eq!(parameter("nvwatchdogtimeout"), Some(4321));
}

#[test]
fn a_remote_that_cannot_be_had_is_told_when_the_card_is_found() {
    let rows = [
        ("7i76e alone", "sserial_port_0=2", "port 0: no remote answers"),
        ("7i76e", "sserial_port_3=0", "'sserial_port_3': the card's firmware has 1 of them"),
        ("7i96s alone", "sserial_port_0=x", ""),
        ("7i76e", "sserial_port_0=2xxx", ""),
        ("7i92 alone", "", ""),
    ];
    for (kind, config, says) in rows {
        let said = card(kind, config).said();
        let warned: Vec<_> = said.iter().filter(|line| !line.contains("has answered")).collect();
        assert_eq!(warned.len(), usize::from(!says.is_empty()), "{kind}: {said:?}");
        assert!(warned.iter().all(|line| line.contains(says)), "{kind}: {said:?}");
    }
    let said = card("7i92 0.1=7i84", "sserial_port_0=01").said().join("\n");
    assert!(
        said.contains("channel 1: the remote 7i84 has answered (unit 10008401, mode 1)"),
        "{said}"
    );
}
