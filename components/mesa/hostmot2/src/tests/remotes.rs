//! A machine with remotes, beside what LinuxCNC's driver did with it.
//!
//! `tests/mesa/remotes.*` are the machine, its commands and what happens at its terminals; `values` and `writes` what LinuxCNC's
//! driver sampled and wrote.

use super::{Rig, last_card};
use std::{collections::BTreeMap, fs, path::Path};

fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/mesa");
    fs::read_to_string(folder.join(name)).unwrap()
}

/// Returns the numbers of each line.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let text = text(name);
    text.lines()
        .map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect())
        .collect()
}

/// Returns the process data that LinuxCNC's driver wrote, by cycle: registers of the two channels.
fn written() -> BTreeMap<usize, [u32; 3]> {
    let names = ["SERIAL_USER_0[0].0", "SERIAL_USER_1[0].0", "SERIAL_USER_0[0].1"];
    let (mut all, mut now, mut cycle) = (BTreeMap::new(), [0; 3], 0);
    for line in text("writes/remotes.txt").lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        match words[..] {
            ["cycle", number] => cycle = number.parse().unwrap(),
            [name, "=", value] => {
                if let Some(place) = names.iter().position(|n| *n == name) {
                    now[place] = u32::from_str_radix(value, 16).unwrap();
                }
            }
            _ => {}
        }
        all.insert(cycle, now);
    }
    all
}

/// Rows after which a remote that is not asked releases its outputs: 50 ms.
const REMOTE_WATCHDOG: usize = 50;

/// Row in which the cable of the second remote is cut.
const CUT: usize = 89;

/// Row in which the faults of a cut remote reach the limit.
const STOPPED: usize = 95;

/// Puts what the play of the world has for a cycle onto the terminals.
fn play(cycle: usize, scenes: &[Vec<String>], rig: &Rig) {
    for scene in scenes.iter().filter(|scene| scene[0].parse() == Ok(cycle)) {
        let [_, what, place, rest @ ..] = &scene[..] else { panic!("{scene:?}") };
        let remote = if place == "0.0" { "sim.7i76.0.0" } else { "sim.7i84.0.1" };
        let number = || rest.last().unwrap().parse::<u32>().unwrap();
        let analog = |name: &str| {
            rig.set(&format!("{remote}.{name}"), f64::from(number()) / 255.0 * f64::from(36.3_f32));
        };
        match (what.as_str(), rest[0].as_str()) {
            ("remote", "Input") => {
                for n in 0..32 {
                    rig.set(&format!("{remote}.input-{n:02}"), number() >> n & 1 == 1);
                }
            }
            ("remote", "AnalogIn2") => analog("analogin2"),
            ("remote", "FieldVoltage") => analog("fieldvoltage"),
            ("remote", "Enc0") => rig.set(&format!("{remote}.enc0"), number()),
            ("cut", level) => rig.set(&format!("{remote}.plugged"), level == "0"),
            _ => panic!("{scene:?}"),
        }
    }
}

#[test]
fn remotes_get_and_give_what_they_do_with_linuxcnc() {
    let rig = Rig::with("7i76e 0.0=7i76 0.1=7i84", "sserial_port_0=20xxxx num_stepgens=1");
    for (pin, value) in [("maxlim", 1500.0), ("minlim", 10.0), ("scalemax", 2000.0)] {
        rig.set(&format!("7i76.0.0.spinout-{pin}"), value);
    }
    rig.set("7i76.0.0.output-03-invert", true);
    rig.set("7i76.0.0.spindir-invert", true);
    rig.set("sserial.port-0.fault-lim", 50_u32);
    let scenes: Vec<Vec<String>> = text("remotes.world")
        .lines()
        .map(|line| line.split('#').next().unwrap())
        .map(|line| line.split_whitespace().map(str::to_owned).collect())
        .filter(|words: &Vec<String>| !words.is_empty())
        .collect();
    assert!(scenes.len() > 5);
    let (stream, values, written) = (rows("remotes.stream"), rows("values/remotes.txt"), written());
    // LinuxCNC's driver waits some cycles before it starts its ports.
    let starts = 21;
    let mut compared = 0;
    let mut last = [0; 3];
    for (row, values) in values.iter().enumerate().map(|(n, values)| (n + 1, values)) {
        play(row + 1, &scenes, &rig);
        let stream = &stream[row - 1];
        rig.set("7i76.0.0.spinout", stream[0]);
        let bit = |n: usize| stream[n] != 0.0;
        rig.set("7i76.0.0.spinena", bit(1));
        rig.set("7i76.0.0.spindir", bit(2));
        for pin in ["7i76.0.0.output-00", "7i76.0.0.output-03", "7i84.0.1.output-15"] {
            rig.set(pin, bit(3));
        }
        rig.set("7i84.0.1.output-01", bit(4));
        rig.cycle();
        // The last row has no cycle behind it.
        if row < starts || row == 160 {
            continue;
        }
        let ours = [
            f64::from(u8::from(rig.bit("7i76.0.0.input-00"))),
            f64::from(u8::from(rig.bit("7i76.0.0.input-31"))),
            f64::from(u8::from(rig.bit("7i76.0.0.input-31-not"))),
            rig.float("7i76.0.0.analogin2"),
            rig.float("7i76.0.0.fieldvoltage"),
            f64::from(rig.int("7i76.0.0.enc0.count")),
            f64::from(u8::from(rig.bit("7i84.0.1.input-07"))),
            f64::from(rig.word("sserial.port-0.port_state")),
            f64::from(rig.word("sserial.port-0.fault-count")),
        ];
        let stopped = row >= STOPPED;
        for (n, (ours, theirs)) in ours.iter().zip(values).enumerate() {
            // Ours stops in the cycle of the last fault, theirs in the next one, and both show other numbers then.
            if stopped && n == 7 {
                continue;
            }
            assert!((ours - theirs).abs() < 1e-6, "row {row}, sample {n}: {ours} {theirs}");
        }
        if stopped {
            // Nothing goes to the remotes any more, whose own watchdogs release their outputs.
            continue;
        }
        let card = last_card();
        let got = card.with(|inside| {
            let value = |channel, name: &str| {
                let remote = inside.card.remote(0, channel).unwrap();
                u32::try_from(remote.value(name).unwrap()).unwrap()
            };
            [
                value(0, "Output") | value(0, "SpinOut") << 16,
                value(0, "SpinEna") | value(0, "SpinDir") << 8,
                value(1, "Output"),
            ]
        });
        let got = got.unwrap();
        let mut wish = written[&(row + 1)];
        if CUT + REMOTE_WATCHDOG <= row {
            wish[2] = 0;
        }
        // A port that stops asks nobody.
        if STOPPED + REMOTE_WATCHDOG <= row {
            wish = [0; 3];
        }
        assert_eq!(got, wish, "row {row}");
        compared += usize::from(got != last);
        last = got;
    }
    // Until the cable is cut, the data change in nearly each row.
    assert!(compared >= 60, "{compared} different data");
}
