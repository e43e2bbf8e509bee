//! Absolute axes and wheels, by tables.

use super::fake::{FakeBus, known, load, step, try_load, with_axis};
use crate::bus::AxisRange;

/// Measurements of LinuxCNC's `hal_input`; see its first lines.
const MEASURED: &str = include_str!("axis.txt");

/// Ours is at the centre, exactly, wherever the value is within `flat` of it.
#[test]
fn axes_are_those_of_linuxcnc_and_at_rest_at_zero() {
    let (mut rows, mut at_rest) = (0, 0);
    for block in MEASURED.split("axis ").skip(2) {
        let mut lines = block.lines();
        let words: Vec<&str> = lines.next().unwrap().split(' ').collect();
        let numbers: Vec<i32> = words.iter().filter_map(|word| word.parse().ok()).collect();
        let [min, max, fuzz, flat] = numbers[..] else { panic!("{words:?}") };
        let bus = FakeBus::default();
        let value = min.midpoint(max);
        bus.plug(0, with_axis(AxisRange { min, max, fuzz, flat, value }));
        let bench = try_load(&bus, &["axis"]).unwrap();
        for (name, number) in words.iter().filter_map(|word| word.split_once('=')) {
            let pin = format!("input.0.abs-x-{name}");
            match name {
                "scale" | "offset" => bench.set::<f64>(&pin, number.parse().unwrap()),
                _ => bench.set::<i32>(&pin, number.parse().unwrap()),
            }
        }
        step(&bench);
        for line in lines {
            let row: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
            let [value, counts, position, is_pos, is_neg] = row[..] else { panic!("{line}") };
            bus.send(0, &format!("abs-x {value}"));
            step(&bench);
            let found = (
                f64::from(bench.get::<i32>("input.0.abs-x-counts")),
                bench.get::<f64>("input.0.abs-x-position"),
            );
            let centre = bench.get::<f64>("input.0.abs-x-offset").trunc();
            let flat = bench.get::<i32>("input.0.abs-x-flat").max(0);
            if (value - centre).abs() <= f64::from(flat) || counts == centre {
                assert_eq!(found, (centre, 0.0), "{words:?} {line}");
                at_rest += 1;
            } else {
                assert_eq!(found, (counts, position), "{words:?} {line}");
                let sides = [is_pos, is_neg].map(|side| side != 0.0);
                let is =
                    ["pos", "neg"].map(|s| bench.get::<bool>(&format!("input.0.abs-x-is-{s}")));
                assert_eq!(is, sides, "{words:?} {line}");
            }
            rows += 1;
        }
    }
    assert_eq!((rows, at_rest > 20), (93, true), "{at_rest}");
}

#[test]
fn settings_of_an_axis_have_no_edge() {
    let range = AxisRange { min: i32::MIN, max: i32::MAX, fuzz: -1, flat: -1, value: 0 };
    let bus = FakeBus::default();
    bus.plug(0, with_axis(range));
    let bench = try_load(&bus, &["axis"]).unwrap();
    for scale in [0.0, -0.0, f64::NAN, f64::INFINITY, 1e-300, 1e-20] {
        for offset in [0.0, f64::NAN, 1e300, -1e300, f64::INFINITY] {
            for value in [i32::MIN, -1, 0, 1, i32::MAX] {
                bench.set("input.0.abs-x-scale", scale);
                bench.set("input.0.abs-x-offset", offset);
                bench.set("input.0.abs-x-flat", value);
                bench.set("input.0.abs-x-fuzz", value.wrapping_neg());
                bus.send(0, &format!("abs-x {value}"));
                step(&bench);
                let position = bench.get::<f64>("input.0.abs-x-position");
                assert!(position.is_finite(), "{scale} {offset} {value}");
                assert!(!offset.is_nan() || position == 0.0, "{scale} {value}");
            }
        }
    }
    bench.set("input.0.abs-x-scale", 2.0);
    bench.set("input.0.abs-x-offset", 0.0);
    bench.set("input.0.abs-x-flat", 0);
    bench.set("input.0.abs-x-fuzz", 0);
    bus.send(0, "abs-x 8");
    step(&bench);
    assert_eq!(bench.get::<f64>("input.0.abs-x-position"), 4.0);
}

/// Each row: events, `rel-dial-counts` and `rel-wheel-counts` after them.
#[test]
fn wheels_count_and_rings_have_a_place() {
    let rows = [
        // A mouse's wheel moves.
        ("Mouse", "rel-wheel 1", "rel-wheel", 1),
        ("Mouse", "rel-wheel 5 | rel-wheel -2", "rel-wheel", 3),
        ("Mouse", "rel-x 7, rel-wheel 255", "rel-wheel", 255),
        ("PowerMate", "rel-dial -1 | rel-dial -1 | rel-dial 3", "rel-dial", 1),
        // A shuttle's wheel says where it is, and leaves out 0.
        ("PRO v2", "rel-dial 10", "rel-dial", 0),
        ("PRO v2", "rel-dial 10 | rel-dial 11 | rel-dial 13", "rel-dial", 3),
        ("PRO v2", "rel-dial 254 | rel-dial 255 | rel-dial 1 | rel-dial 2", "rel-dial", 3),
        ("PRO v2", "rel-dial 2 | rel-dial 1 | rel-dial 255 | rel-dial 254", "rel-dial", -3),
        ("PRO v2", "rel-dial 7 | rel-dial 7 | btn-0 1, rel-dial 7", "rel-dial", 0),
        // Its ring is at rest in a report without it.
        ("PRO v2", "rel-dial 7, rel-wheel 3", "rel-wheel", 3),
        ("Xpress", "rel-dial 7, rel-wheel 3 | rel-dial 7, rel-wheel -7", "rel-wheel", -7),
        ("PRO v2", "rel-dial 7, rel-wheel 1 | rel-dial 7", "rel-wheel", 0),
        ("PRO v2", "rel-dial 7, rel-wheel 2 | btn-3 1, rel-dial 7, rel-wheel 2", "rel-wheel", 2),
    ];
    for (name, events, pin, want) in rows {
        let (bus, bench) = load(&[name]);
        bus.send(0, events);
        step(&bench);
        let counts = bench.get::<i32>(&format!("input.0.{pin}-counts"));
        assert_eq!(counts, want, "{name}: {events}");
    }
}

/// The name of a device may be another one, if it has numbers.
#[test]
fn wheels_are_known_by_the_numbers_of_a_device() {
    for (name, numbers, want) in [
        ("Contour Design ShuttlePRO v2", (0x0b33, 0x30), 3),
        ("Contour Design ShuttlePRO", (0x0b33, 0x30), 3),
        ("Another name", (0x0b33, 0x20), 3),
        ("Another name", (0x0b33, 0x99), 41),
        ("Another name", (0, 0), 41),
        ("Contour Design ShuttlePRO v2", (0, 0), 41),
    ] {
        let bus = FakeBus::default();
        let mut device = known("PRO v2");
        name.clone_into(&mut device.identity.name);
        (device.identity.vendor, device.identity.product) = numbers;
        bus.plug(0, device);
        let bench = try_load(&bus, &["0"]).unwrap();
        step(&bench);
        bus.send(0, "rel-dial 12 | rel-dial 14");
        bus.send(0, "rel-dial 15");
        step(&bench);
        let counts = bench.get::<i32>("input.0.rel-dial-counts");
        assert_eq!(counts, want, "{name} {numbers:?}");
    }
}

#[test]
fn a_wheel_is_scaled_and_reset() {
    let (bus, bench) = load(&["PowerMate"]);
    let dial = |what: &str| bench.get::<i32>("input.0.rel-dial-counts").to_string() + what;
    bench.set("input.0.rel-dial-scale", 4.0);
    for (events, reset, scale, want) in [
        ("rel-dial 6", false, 4.0, ("6", 1.5)),
        ("rel-dial 1", true, 4.0, ("0", 0.0)),
        ("rel-dial 3", true, 4.0, ("0", 0.0)),
        ("rel-dial 2", false, 4.0, ("2", 0.5)),
        ("rel-dial 2", false, 0.0, ("4", 4.0)),
        ("rel-dial 0", false, -1e-21, ("4", 4.0)),
        ("rel-dial 2147483647", false, 1.0, ("-2147483645", -2_147_483_645.0)),
    ] {
        bench.set("input.0.rel-dial-reset", reset);
        bench.set("input.0.rel-dial-scale", scale);
        bus.send(0, events);
        step(&bench);
        let position = bench.get::<f64>("input.0.rel-dial-position");
        assert_eq!((dial("").as_str(), position), want, "{events}");
    }
}
