//! Simulated devices: pins to pins.

use super::{
    events::is_down,
    fake::{MS, step},
};
use crate::hal_input::HalInput;
use hal_bench::Bench;

fn load(args: &[&str]) -> Bench {
    let mut bench = Bench::new();
    bench.load::<HalInput>(args).unwrap();
    step(&bench);
    bench
}

#[test]
fn buttons_axes_wheels_and_lights_are_pins() {
    let bench = load(&["devices=-KRAL X-Box 360,PRO v2,AT*keyboard,Mouse"]);
    for (pin, value) in [("0.sim.abs-x", 16_384), ("0.sim.abs-hat0x", -1), ("1.sim.rel-wheel", -3)]
    {
        bench.set(&format!("input.{pin}"), value);
    }
    bench.set("input.0.sim.btn-start", true);
    bench.set("input.2.sim.key-esc", true);
    bench.set("input.2.led-numl", true);
    bench.set("input.3.sim.rel-wheel", 7);
    step(&bench);
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-start") && is_down(&bench, "input.2.key-esc"));
    assert_eq!(bench.get::<i32>("input.0.abs-x-counts"), 16_384);
    assert_eq!(bench.get::<f64>("input.0.abs-hat0x-position"), -1.0);
    assert_eq!(bench.get::<f64>("input.0.abs-z-position"), -1.0, "a trigger at rest");
    assert_eq!(bench.get::<i32>("input.1.rel-wheel-counts"), -3);
    assert_eq!(bench.get::<i32>("input.3.rel-wheel-counts"), 7);
    assert!(bench.get::<bool>("input.2.sim.led-numl"));
    // The first report of the wheel says where it is; each further one moves.
    for (place, want) in [(1, 0), (2, 1), (300, 44), (299, 43)] {
        bench.set("input.1.sim.rel-dial", place);
        step(&bench);
        assert_eq!(bench.get::<i32>("input.1.rel-dial-counts"), want, "{place}");
    }
    bench.set("input.1.sim.rel-wheel", 0);
    bench.set("input.0.sim.btn-start", false);
    step(&bench);
    assert_eq!(bench.get::<i32>("input.1.rel-wheel-counts"), 0);
    assert!(!is_down(&bench, "input.0.btn-start"));
}

#[test]
fn a_simulated_device_is_unplugged() {
    let bench = load(&["devices=X-Box,Mouse"]);
    bench.set("input.0.sim.btn-a", true);
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-a"));
    bench.set("input.0.sim.unplugged", true);
    step(&bench);
    assert!(!is_down(&bench, "input.0.btn-a") && bench.get::<bool>("input.0.fault"));
    assert!(bench.get::<bool>("input.1.connected"));
    bench.set("input.0.sim.unplugged", false);
    bench.pass(500 * MS);
    step(&bench);
    assert!(!is_down(&bench, "input.0.btn-a") && bench.get::<bool>("input.0.connected"));
    bench.set("input.0.sim.btn-a", false);
    step(&bench);
    bench.set("input.0.sim.btn-a", true);
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-a"));
}

/// Each row: a specification, a pin of the device that is simulated for it, and whether the driver says that it knows none.
#[test]
fn a_device_for_each_specification() {
    for (spec, pin, is_unknown) in [
        ("Dual Action", "btn-trigger", false),
        ("Dual:3", "btn-base6", false),
        ("+F310", "btn-mode", false),
        ("-K 0b33:0020", "btn-8", false),
        ("0003:077d:0410", "rel-dial-counts", false),
        ("Vendor=045e", "abs-rx-flat", false),
        ("3", "key-a", true),
        ("Joystick", "key-300-not", true),
        ("360", "btn-mode", false),
        ("/dev/input/by-id/usb-Pad-event-joystick", "abs-rx-position", true),
        ("SpaceBall", "abs-ry-position", true),
    ] {
        let bench = load(&[&format!("devices={spec}")]);
        let name = format!("input.0.{pin} ");
        assert!(bench.names().iter().any(|line| line.starts_with(&name)), "{spec}");
        let said = bench.said();
        assert_eq!(!said.is_empty(), is_unknown, "{spec}: {said:?}");
        let text = format!(
            "nothing describes the input device '{spec}': it is simulated with all keys, axes and lights; \
             describe= names a file that describes it"
        );
        assert!(said.iter().all(|line| line.contains(&text)), "{spec}: {said:?}");
    }
}

#[test]
fn the_background_task_sets_the_pins() {
    let mut bench = Bench::new();
    bench.load::<HalInput>(&["devices=X-Box", "task=1"]).unwrap();
    assert!(bench.functs().is_empty());
    // What is pressed after the load counts, also before the first run.
    bench.set("input.0.sim.btn-a", true);
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-a"));
}

#[test]
fn a_users_file_describes_a_device() {
    let path = std::env::temp_dir().join(format!("ferrule-input-{}.txt", std::process::id()));
    let text = "I: Bus=0003 Vendor=1234 Product=5678 Version=0100\nN: Name=\"My Pendant\"\n\
                H: Handlers=kbd event7\nB: PROP=0\nB: EV=17\nB: KEY=3 0 0 0 0\nB: REL=80\nB: ABS=1\n\
                A: abs-x 0 1023 2 10\nD: rel-dial counter 4\n";
    std::fs::write(&path, text).unwrap();
    let bench = load(&["devices=My Pendant", &format!("describe={}", path.display())]);
    assert_eq!(bench.get::<f64>("input.0.abs-x-scale"), 511.5);
    bench.set("input.0.sim.btn-1", true);
    bench.set("input.0.sim.rel-dial", 20);
    step(&bench);
    bench.set("input.0.sim.rel-dial", 22);
    step(&bench);
    assert!(is_down(&bench, "input.0.btn-1"));
    assert_eq!(bench.get::<i32>("input.0.rel-dial-counts"), 2);
    // A name may have bytes that are no text.
    std::fs::write(&path, b"N: Name=\"My Pendant \xff\"\nB: KEY=2").unwrap();
    let bench = load(&["devices=My Pendant", &format!("describe={}", path.display())]);
    assert!(!is_down(&bench, "input.0.key-esc"));
    std::fs::remove_file(&path).unwrap();
}

/// Each row: a file, the number of the line that is wrong, and what was expected there.
#[test]
fn a_wrong_line_of_a_users_file_is_named() {
    const NUMBERS: &str = "Bus=0003 Vendor=046d Product=c216 Version=0110, with numbers of 16 bits";
    const MASK: &str =
        "a mask of codes, such as KEY=fff00000000 0 0 0 0: words of 64 bits, at most 12";
    const CODES: &str = "a mask of codes that the kernel has";
    const AXIS: &str =
        "an axis of the line ABS with its range: abs-x MIN MAX FUZZ FLAT, and its value at rest";
    const WHEEL: &str = "rel-wheel ring, or rel-dial counter 8, with 2 to 31 bits";
    const LINE: &str = "a line of /proc/bus/input/devices, such as N: Name=\"Gamepad\", or one that begins with A: or D:";
    let path = std::env::temp_dir().join(format!("ferrule-lines-{}.txt", std::process::id()));
    for (text, line, expected) in [
        ("N: My Pendant", 1, "Name=\"…\""),
        ("P: usb-1", 1, "Phys=…"),
        ("U: 1", 1, "Uniq=…"),
        ("I: Bus=3 Vendor=99999", 1, NUMBERS),
        ("I: Bus", 1, NUMBERS),
        ("I: Colour=3", 1, NUMBERS),
        ("\n# x\nB: KEY=xyz", 3, MASK),
        ("B: KEY=", 1, MASK),
        ("B: KEY", 1, MASK),
        ("B: KEY=0 0 0 0 0 0 0 0 0 0 0 0 0", 1, MASK),
        ("B: REL=10000", 1, CODES),
        ("B: LED=10000", 1, CODES),
        ("B: ABS=1 0", 1, CODES),
        ("B: ABS=1\nA: abs-y 0 1 0 0", 2, AXIS),
        ("B: ABS=1\nA: abs-x 0 1 0", 2, AXIS),
        ("B: ABS=1\nA: abs-x 0 a 0 0", 2, AXIS),
        ("D: rel-dial counter 1", 1, WHEEL),
        ("D: abs-x ring", 1, WHEEL),
        ("D: rel-dial", 1, WHEEL),
        ("gamepad", 1, LINE),
        ("Z: 1", 1, LINE),
    ] {
        std::fs::write(&path, text).unwrap();
        let args = ["devices=X", &format!("describe={}", path.display())];
        let said = Bench::new().load::<HalInput>(&args).unwrap_err();
        let want = format!("{}: line {line}: expected {expected}", path.display());
        assert_eq!(said, want, "{text}");
    }
    std::fs::remove_file(&path).unwrap();
}

/// A file is read within a bound of its size, and a device or a folder is none.
#[test]
fn a_users_file_that_cannot_be_read_is_named_with_the_reason() {
    let path = std::env::temp_dir().join(format!("ferrule-large-{}.txt", std::process::id()));
    std::fs::write(&path, " ".repeat(1 << 20) + "\n").unwrap();
    let large = path.display().to_string();
    for (path, why) in [
        (large.as_str(), "it is larger than 1 MiB"),
        ("/dev/zero", "it is a device, not a file"),
        ("/", "Is a directory (os error 21)"),
        ("/nothing", "No such file or directory (os error 2)"),
    ] {
        let args = ["devices=X", &format!("describe={path}")];
        let said = Bench::new().load::<HalInput>(&args).unwrap_err();
        let want = format!(
            "describe= has '{path}', which cannot be read ({why}): expected a file with lines of \
             /proc/bus/input/devices"
        );
        assert_eq!(said, want);
    }
    std::fs::remove_file(&path).unwrap();
}
