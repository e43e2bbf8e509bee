//! Specifications of devices, and refusals.

use super::fake::{FakeBus, known, try_load};
use crate::{
    bus::{FoundDevice, Identity},
    described::parse,
    hal_input::HalInput,
    spec::DeviceSpec,
};
use hal_bench::Bench;

fn devices() -> Vec<FoundDevice> {
    [
        (0, "AT Keyboard", "isa0060/serio0/input0", [0x11, 1, 1, 0xab41]),
        (1, "Logitech Gamepad F310", "usb-1/input0", [3, 0x46d, 0xc216, 0x110]),
        (2, "Logitech Mouse", "usb-2/input0", [3, 0x46d, 0xc077, 0x111]),
        (3, "Logitech Mouse", "usb-3/input1", [3, 0x46d, 0xc077, 0x111]),
        (10, "Big mouse", "usb-4/input1", [5, 0x46d, 0xc077, 0x111]),
    ]
    .into_iter()
    .map(|(number, name, phys, [bus, vendor, product, version])| {
        let (name, phys, uniq) = (name.to_owned(), phys.to_owned(), String::new());
        let identity = Identity { bus, vendor, product, version, name, phys, uniq };
        FoundDevice { number, identity }
    })
    .collect()
}

/// The rows above the empty one were measured on LinuxCNC's.
const CHOICES: &[(&str, Option<u32>)] = &[
    ("Mouse", Some(2)),
    ("mouse", Some(10)),
    ("Mouse:1", Some(3)),
    ("Mouse:0", Some(2)),
    ("Logitech*", Some(1)),
    ("*Gamepad*", Some(1)),
    ("Vendor=046d", Some(1)),
    ("Vendor=046d Product=c216", Some(1)),
    ("usb-3", Some(3)),
    ("nothing", None),
    ("Mouse:5", None),
    ("Vendor=46d", None),
    ("Version=ab41", Some(0)),
    ("AT*board", Some(0)),
    ("AT", Some(0)),
    ("Mouse:1:1", None),
    ("usb-3/input1:0", Some(3)),
    ("Vendor=046D", None),
    ("", None),
    // Its manual has these.
    ("serio*/input0", Some(0)),
    ("3", Some(3)),
    ("10", Some(10)),
    ("7", None),
    // A number that is no node is a part of a name, and of nothing else.
    ("310", Some(1)),
    ("31", Some(1)),
    ("0310", None),
    ("310:1", None),
    ("46", None),
    // A path is looked up by the bus.
    ("/dev/input/event3", None),
    ("+Mouse:1", Some(3)),
    ("-KRAL +Mouse", Some(2)),
    ("-L  AT Keyboard ", Some(0)),
    ("046d:c077", Some(2)),
    ("046d:c077:1", Some(3)),
    ("0005:046d:c077", Some(10)),
    ("0004:046d:c077", None),
    ("Bus=0005", Some(10)),
    ("?ouse", Some(2)),
    ("Log*F3?0", Some(1)),
    ("*:1", Some(1)),
    ("Mouse:99999999999999999999", None),
];

#[test]
fn specifications_choose_devices() {
    let devices = devices();
    for (text, want) in CHOICES.iter().filter(|row| !row.0.is_empty()) {
        let spec = DeviceSpec::parse(text).unwrap();
        let found = spec.find(&devices).map(|device| device.number);
        assert_eq!(found, *want, "{text}");
        assert_eq!(spec.is_exclusive, text.contains('+'), "{text}");
    }
}

#[test]
fn bad_arguments() {
    const NOTHING: &str =
        "no device: expected devices= with a part of its name, such as devices=Gamepad";
    const NO_DEVICE: &str = " without a device: expected a part of its name, such as -KRAL Gamepad";
    const LETTERS: &str = ": expected letters of K for keys and buttons, R and A for relative and absolute axes, and L \
                           for lights, such as -KRAL Gamepad";
    for (args, begin, end) in [
        (vec![], "", NOTHING),
        (vec!["devices=-KRAL"], "devices= has '-KRAL'", NO_DEVICE),
        (vec!["devices=X,-K +"], "devices= has '-K +'", NO_DEVICE),
        (vec!["devices=-X Gamepad"], "devices= has '-X Gamepad'", LETTERS),
        (vec!["devices=- Gamepad"], "devices= has '- Gamepad'", LETTERS),
        (vec!["devices=-kral Gamepad"], "devices= has '-kral Gamepad'", LETTERS),
    ] {
        let error = Bench::new().load::<HalInput>(&args).unwrap_err();
        assert_eq!(error, format!("{begin}{end}"), "{args:?}");
    }
}

#[test]
fn a_missing_device_is_named_with_those_that_are_there() {
    let bus = FakeBus::default();
    let said = try_load(&bus, &["Gamepad"]).err().unwrap();
    let want = "no input device matches 'Gamepad': /dev/input has no device; is it plugged in?; or run with --simulate";
    assert_eq!(said, want);
    bus.plug(0, known("keyboard"));
    bus.plug(3, known("Mouse"));
    let said = try_load(&bus, &["keyboard", "-KRAL Gamepad:1"]).err().unwrap();
    let want = "no input device matches '-KRAL Gamepad:1'; there are: 'AT Translated Set 2 keyboard' \
                (0001:0001, event0), 'Logitech USB Optical Mouse' (046d:c077, event3); or run with --simulate";
    assert_eq!(said, want);
    for at in 4..20 {
        bus.plug(at, known("Mouse"));
    }
    let said = try_load(&bus, &["Gamepad"]).err().unwrap();
    assert!(said.contains("event13), and 6 more; or run"), "{said}");
}

/// Each row: the specification, the error number of the opening, that of the accesses, and the text.
#[test]
fn a_device_that_cannot_be_used_is_named_with_the_reason() {
    const GROUP: &str = "the user may not open its node: run as a user in group input (usermod -aG input NAME, then \
                         log in again)";
    const KEPT: &str = "another program, or another word of devices=, keeps its events for itself: end that program, \
                        or leave out the +";
    for (spec, refuses, fails, want) in [
        ("Mouse", Some(13), None, GROUP),
        ("+Mouse", Some(1), None, GROUP),
        ("+Mouse", Some(16), None, KEPT),
        (
            "Mouse",
            Some(16),
            None,
            "its node cannot be read (Device or resource busy (os error 16))",
        ),
        ("+Mouse", Some(19), None, "its node cannot be read (No such device (os error 19))"),
        ("Mouse", None, Some(5), "its node cannot be read (Input/output error (os error 5))"),
    ] {
        let bus = FakeBus::default();
        bus.plug(0, known("keyboard"));
        bus.plug(1, known("Mouse"));
        bus.with(1, |mouse| (mouse.refuses, mouse.breaks) = (refuses, fails));
        let said = try_load(&bus, &["keyboard", spec]).err().unwrap();
        let want = format!(
            "/dev/input/event1 ('Logitech USB Optical Mouse') cannot be used: {want}; or run with --simulate"
        );
        assert_eq!(said, want, "{spec} {refuses:?}");
    }
}

#[test]
fn the_known_devices_can_be_read() {
    let text = include_str!("../devices.txt");
    let all = parse(text).unwrap();
    assert_eq!(all.len(), text.lines().filter(|line| line.starts_with("N:")).count());
    for device in &all {
        let has = &device.abilities;
        assert!(!has.keys.is_empty() && !device.identity.name.is_empty(), "{device:?}");
        assert!(has.abs.iter().all(|axis| axis.1.min < axis.1.max), "{device:?}");
    }
}
