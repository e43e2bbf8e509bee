//! Names of pins, from masks of real devices.

use super::fake::{FakeBus, device, known, try_load};
use crate::{
    bus::{Abilities, AxisRange, Identity},
    codes,
    event::kind,
};
use std::collections::BTreeSet;

/// Pins of LinuxCNC's `hal_input`; see its first line.
const MEASURED: &str = include_str!("names.txt");

/// Pins that LinuxCNC's has not.
const OURS: [&str; 3] = ["connected", "fault", "required"];

#[test]
fn names_are_those_of_linuxcnc() {
    let mut seen = 0;
    for block in MEASURED.split("\n\n").skip(1) {
        let (name, pins) = block.split_once('\n').unwrap();
        let name = name.trim_start_matches("# ");
        let device = if name == "unnamed codes" {
            let abs = vec![(29, AxisRange::default())];
            let has = Abilities { keys: vec![703], abs, rel: vec![11], leds: vec![0, 11] };
            device(Identity { name: name.to_owned(), ..Identity::default() }, has)
        } else {
            let mut device = known(name);
            // Names of devices may be beginnings of others.
            device.identity.name = name.to_owned();
            if name.ends_with("PRO") {
                device.abilities.keys = (256..269).collect();
            }
            device
        };
        let bus = FakeBus::default();
        bus.plug(0, device);
        let bench = try_load(&bus, &[name]).unwrap();
        let made = bench.names();
        let made: BTreeSet<&str> = made
            .iter()
            .filter_map(|line| line.split(' ').next()?.strip_prefix("input.0."))
            .filter(|pin| !OURS.contains(pin))
            .collect();
        let want: BTreeSet<&str> = pins.lines().filter(|line| !line.is_empty()).collect();
        assert_eq!(made, want, "{name}");
        seen += want.len();
    }
    assert_eq!(seen, MEASURED.lines().filter(|l| !l.is_empty() && !l.starts_with('#')).count());
}

#[test]
fn features_choose_the_pins() {
    let bus = FakeBus::default();
    bus.plug(0, known("PRO v2"));
    bus.plug(1, known("keyboard"));
    bus.plug(2, known("Dual"));
    let bench = try_load(&bus, &["-R PRO", "-L keyboard", "-A Dual", "-KA Dual", "Dual"]).unwrap();
    let made = bench.names();
    let has = |pin: &str| made.iter().any(|line| line.split(' ').next() == Some(pin));
    for (pin, want) in [
        ("input.0.rel-dial-counts", true),
        ("input.0.btn-0", false),
        ("input.1.led-numl", true),
        ("input.1.key-a", false),
        ("input.2.abs-x-position", true),
        ("input.2.btn-trigger", false),
        ("input.3.btn-trigger", true),
        ("input.4.btn-trigger-not", true),
        ("input.0.connected", true),
        ("input.5.connected", false),
    ] {
        assert_eq!(has(pin), want, "{pin}");
    }
}

#[test]
fn each_name_means_one_code() {
    for kind in [kind::KEY, kind::REL, kind::ABS, kind::LED] {
        let all = codes::all(kind);
        assert!(all.len() > 9 && all.is_sorted());
        for code in all {
            assert_eq!(codes::code(kind, &codes::name(kind, code)), Some(code));
        }
    }
    assert_eq!(codes::name(kind::KEY, 288), "btn-trigger");
    for (kind, code, name) in [
        (kind::KEY, 703, "key-703"),
        (kind::REL, 11, "rel-11"),
        (kind::ABS, 29, "abs-29"),
        (kind::LED, 11, "led-11"),
    ] {
        assert_eq!(codes::name(kind, code), name);
    }
}
