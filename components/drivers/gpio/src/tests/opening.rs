//! Opening: a row for each reason why lines are refused, and what is requested.

use super::{
    MS,
    fake::{FakeChip, FakeChips, load, named},
};
use crate::{
    chips::Chips,
    config::{NamedLine, Place, Setting},
    device::Device,
    kernel::Kernel,
    label::Label,
    pi::HEADER,
    refused::Refused,
};
use hal_bench::Bench;
use port::Lost;

/// Loads the driver on these chips. Returns the reason why it was refused.
fn refused(chips: &FakeChips, args: &str) -> String {
    let args: Vec<&str> = args.split_whitespace().collect();
    load(&mut Bench::new().with_hardware(), chips, &args).unwrap_err()
}

const EPERM: Lost = Lost(1);
const ENOENT: Lost = Lost(2);
const EACCES: Lost = Lost(13);
const EBUSY: Lost = Lost(16);
const ENODEV: Lost = Lost(19);
const EINVAL: Lost = Lost(22);
const ENOTTY: Lost = Lost(25);
const EOPNOTSUPP: Lost = Lost(95);

/// Changes the first chip.
fn with(change: impl FnOnce(&mut FakeChip)) -> FakeChips {
    let mut chips = named(&["GPIO5", "GPIO17", ""]);
    change(&mut chips.chips[0].1);
    chips
}

#[test]
fn each_error_of_the_kernel_names_what_would_be_right() {
    let forbidden = "/dev/gpiochip0 may not be opened: run as a user in group gpio";
    let rule = "SUBSYSTEM==\"gpio\", GROUP=\"gpio\", MODE=\"0660\"";
    let missing = "/dev/gpiochip0 is missing: gpiodetect lists the chips that are there";
    let old = "/dev/gpiochip0 does not know version 2 of the GPIO interface: it needs Linux 5.10";
    let held = "line 'GPIO17' (gpiochip0.1) is held by 'pwm-fan': end that program or unload that \
                driver, or take another line";
    let opening = |lost| with(|chip| chip.open = Some(lost));
    let asking = |lost| with(|chip| chip.facts = Some(lost));
    let requesting = |lost| with(|chip| chip.request = Some(lost));
    let by = |holder| with(|chip| chip.lines[1].1 = Some(holder));
    let table: &[(&str, FakeChips, &str, &[&str])] = &[
        (
            "no /dev",
            FakeChips { numbers: Some(ENOENT), ..named(&[]) },
            "inputs=GPIO17",
            &["this computer has no GPIO chip"],
        ),
        (
            "no chip",
            FakeChips::default(),
            "inputs=GPIO17",
            &["this computer has no GPIO chip: /dev has no gpiochip0"],
        ),
        ("ENOENT open", opening(ENOENT), "inputs=GPIO17", &[missing]),
        ("EACCES open", opening(EACCES), "inputs=GPIO17", &[forbidden, rule]),
        ("EPERM open", opening(EPERM), "inputs=GPIO17", &[forbidden, rule]),
        ("EACCES, by number", opening(EACCES), "inputs=gpiochip0.2", &[forbidden]),
        (
            "ENODEV facts",
            asking(ENODEV),
            "inputs=GPIO17",
            &["/dev/gpiochip0 cannot be used: No such device"],
        ),
        ("ENOTTY facts", asking(ENOTTY), "inputs=GPIO17", &[old]),
        ("no such chip", named(&["A"]), "inputs=gpiochip3.0", &["/dev/gpiochip3 is missing"]),
        (
            "no such number",
            named(&["A", "B"]),
            "inputs=gpiochip0.2",
            &["gpiochip0 has no line 2: it has 2 lines, from 0"],
        ),
        (
            "unknown",
            with(|_| ()),
            "inputs=GPOI17",
            &[
                "no GPIO chip has a line 'GPOI17' (did you mean 'GPIO17'?)",
                "gpioinfo lists all names",
            ],
        ),
        (
            "unknown, nothing near",
            with(|_| ()),
            "inputs=PIN11",
            &["no GPIO chip has a line 'PIN11': gpioinfo lists all names"],
        ),
        (
            "twice on a chip",
            named(&["NC", "NC"]),
            "inputs=NC",
            &["two lines are named 'NC': name it by its chip, as gpiochip0.0 or gpiochip0.1"],
        ),
        (
            "the same line",
            with(|_| ()),
            "inputs=GPIO17,gpiochip0.1",
            &["'GPIO17' and 'gpiochip0.1' are the same line, gpiochip0.1"],
        ),
        ("held", by("pwm-fan"), "inputs=GPIO5 outputs=GPIO17", &[held]),
        (
            "held by the kernel",
            by(""),
            "outputs=GPIO17",
            &["line 'GPIO17' (gpiochip0.1) is held by 'the kernel'"],
        ),
        (
            "EBUSY request",
            with(|chip| (chip.request, chip.faster) = (Some(EBUSY), Some("pwm-fan"))),
            "outputs=GPIO17",
            &[held],
        ),
        (
            "EBUSY, nobody",
            requesting(EBUSY),
            "outputs=GPIO17",
            &["/dev/gpiochip0 cannot be used: Device or resource busy"],
        ),
        ("EPERM request", requesting(EPERM), "outputs=GPIO17", &[forbidden]),
        (
            "ENODEV request",
            requesting(ENODEV),
            "outputs=GPIO17",
            &["/dev/gpiochip0 cannot be used: No such device"],
        ),
        ("ENOTTY request", requesting(ENOTTY), "outputs=GPIO17", &[old]),
        (
            "EINVAL request",
            requesting(EINVAL),
            "outputs=GPIO17",
            &["gpiochip0 refuses its lines: Invalid argument"],
        ),
        (
            "no bias",
            requesting(EOPNOTSUPP),
            "inputs=GPIO17 pullup=GPIO17",
            &[
                "gpiochip0 refuses its lines: Operation not supported",
                "it may lack pullup=, pulldown= and biasdisable=",
            ],
        ),
        (
            "no drive",
            requesting(EOPNOTSUPP),
            "outputs=GPIO17 opendrain=GPIO17",
            &["it may lack opendrain= and opensource="],
        ),
    ];
    for (row, chips, args, says) in table {
        let why = refused(chips, args);
        for text in *says {
            assert!(why.contains(text), "{row}: {why}");
        }
        assert!(why.ends_with("; or run with --simulate"), "{row}: {why}");
        assert!(chips.requested.lock().unwrap().is_empty(), "{row}: something was requested");
    }
}

/// A chip that this user may not open does not matter if the lines are on others.
#[test]
fn a_closed_chip_does_not_matter_if_the_lines_are_elsewhere() {
    let mut chips = named(&["GPIO5"]);
    chips.chips.push((1, FakeChip { open: Some(EACCES), ..FakeChip::default() }));
    load(&mut Bench::new().with_hardware(), &chips, &["inputs=GPIO5"]).unwrap();
    assert!(refused(&chips, "inputs=GPIO6").contains("/dev/gpiochip1 may not be opened"));
}

#[test]
fn lines_of_an_encoder_are_of_one_chip() {
    let mut chips = named(&["A"]);
    chips.chips.push((1, FakeChip { lines: vec![("B", None)], ..FakeChip::default() }));
    let why = refused(&chips, "encoders=A:B");
    assert!(why.contains("'A' and 'B' are on different chips"), "{why}");
}

/// A single request for a chip, one call for a function, and outputs at rest before the lines are released.
#[test]
fn a_chip_is_one_request_and_a_function_is_one_call() {
    let chips = named(&["A", "B", "C", "D"]);
    let mut bench = Bench::new().with_hardware();
    load(&mut bench, &chips, &["inputs=A,C", "outputs=B,D", "reset=D"]).unwrap();
    let (request, lines) = chips.requested.lock().unwrap()[0].clone();
    assert_eq!(chips.requested.lock().unwrap().len(), 1);
    assert_eq!(request.offsets, [0, 2, 1, 3]);
    // Opening reads levels of encoders alone.
    assert_eq!(lines.text(), "");
    bench.set("hal_gpio.B-out", true);
    bench.set("hal_gpio.D-out", true);
    for function in ["read", "write", "reset", "reset"] {
        bench.run(&format!("hal_gpio.{function}"), MS);
    }
    bench.stop();
    assert_eq!(lines.text(), "read 3 = 0\nwrite c c\nwrite 4 c\nwrite 0 c\n");
    drop(bench);
    let text = lines.text();
    assert!(text.ends_with("write 0 c\nwrite 0 c\n"), "the lines are released at rest: {text}");
}

/// Lines of a chip that is gone are named, each function's once until it answers again.
#[test]
fn a_chip_that_vanishes_is_reported_with_its_lines() {
    let again = "; load the machine again when it is back";
    let (inputs, outputs, edges) = (
        format!("gpiochip0 is gone: its inputs A keep their values{again}"),
        format!("gpiochip0 is gone: nothing drives its outputs B, C{again}"),
        format!("gpiochip0 is gone: nothing counts the edges of D, E{again}"),
    );
    let chips = named(&["A", "B", "C", "D", "E"]);
    let mut bench = Bench::new().with_hardware();
    load(&mut bench, &chips, &["inputs=A", "outputs=B,C", "encoders=D:E"]).unwrap();
    let all: Vec<_> = chips.requested.lock().unwrap().iter().map(|(_, l)| l.clone()).collect();
    let change = |level, lost| {
        for lines in &all {
            *lines.inner().levels.lock().unwrap() = level;
            *lines.inner().lost.lock().unwrap() = lost;
        }
    };
    let functions = ["capture-position", "read", "write"];
    let run = || functions.map(|f| bench.run(&format!("hal_gpio.{f}"), MS));
    let pins = || ["A-in", "fault"].map(|pin| bench.get::<bool>(&format!("hal_gpio.{pin}")));
    change(1, None);
    run();
    assert_eq!(pins(), [true, false]);
    change(0, Some(ENODEV));
    run();
    run();
    assert_eq!(bench.said(), [edges, inputs, outputs]);
    assert_eq!(pins(), [true, true]);
    assert_eq!(bench.failed_hardware(), 3);
    change(0, None);
    run();
    assert_eq!((pins(), bench.said().len()), ([false, false], 0));
    assert_eq!(bench.failed_hardware(), 0);
}

#[test]
fn other_errors_are_reported_with_their_number() {
    let chips = named(&["A", "B", "C"]);
    let mut bench = Bench::new().with_hardware();
    load(&mut bench, &chips, &["inputs=A", "outputs=B", "encoders=C"]).unwrap();
    for (_, lines) in chips.requested.lock().unwrap().iter() {
        *lines.inner().lost.lock().unwrap() = Some(Lost(5));
    }
    for function in ["read", "write", "capture-position"] {
        bench.run(&format!("hal_gpio.{function}"), MS);
    }
    assert_eq!(
        bench.said(),
        [
            "gpiochip0: error 5 when reading its inputs A: they keep their values",
            "gpiochip0: error 5 when writing its outputs B: it is tried again",
            "gpiochip0: error 5 when reading the edges of C: counts keep their values",
        ]
    );
}

/// A reset that failed is done with when nothing is left to reset.
#[test]
fn a_failed_reset_keeps_motion_off_until_nothing_is_left_to_reset() {
    let chips = named(&["A"]);
    let mut bench = Bench::new().with_hardware();
    load(&mut bench, &chips, &["outputs=A", "reset=A"]).unwrap();
    let lines = chips.requested.lock().unwrap()[0].1.clone();
    bench.set("hal_gpio.A-out", true);
    bench.run("hal_gpio.write", MS);
    *lines.inner().lost.lock().unwrap() = Some(Lost(5));
    bench.run("hal_gpio.reset", MS);
    assert_eq!(bench.failed_hardware(), 1);
    *lines.inner().lost.lock().unwrap() = None;
    bench.set("hal_gpio.A-out", false);
    bench.run("hal_gpio.write", MS);
    bench.run("hal_gpio.reset", MS);
    assert_eq!((bench.failed_hardware(), bench.get::<bool>("hal_gpio.fault")), (0, false));
}

/// A message has room for the names of a few outputs.
#[test]
fn many_outputs_are_counted() {
    let names: Vec<&'static str> = (0..40).map(|n| &*format!("LINE{n:02}").leak()).collect();
    let chips = named(&names);
    let mut bench = Bench::new().with_hardware();
    load(&mut bench, &chips, &[&format!("outputs={}", names.join(","))]).unwrap();
    *chips.requested.lock().unwrap()[0].1.inner().lost.lock().unwrap() = Some(ENODEV);
    bench.run("hal_gpio.write", MS);
    let said = bench.said();
    assert!(said[0].contains("LINE14, LINE15 and 24 more; load"), "{said:?}");
}

/// The numbers of the header's lines do not depend on their names, which boards give to functions.
#[test]
fn the_header_is_found_by_the_label_of_its_chip() {
    let line = |offset| NamedLine {
        name: Label::cut("pin-03"),
        place: Place::Header(offset),
        setting: Setting::default(),
        is_reset: false,
    };
    let open = |chips: &FakeChips, offset| {
        crate::chips::open(chips, &[line(offset)], &[])
            .map(|found| (found[0].request.chip, found[0].request.offsets.clone()))
    };
    for label in ["pinctrl-bcm2835", "pinctrl-bcm2711", "pinctrl-rp1"] {
        let mut chips = named(&["GPIO2"]);
        let lines = vec![("SDA1", None); 28];
        chips.chips.push((4, FakeChip { label, lines, ..FakeChip::default() }));
        assert_eq!(open(&chips, 2), Ok((4, vec![2])), "{label}");
        assert_eq!(open(&chips, 28), Err(Refused::Beyond { chip: 4, offset: 28, lines: 28 }));
    }
    assert_eq!(open(&named(&["GPIO2"]), 2), Err(Refused::NoHeader));
    assert!(Refused::NoHeader.to_string().contains("use hal_gpio on other boards"));
}

#[test]
fn the_header_has_each_line_at_a_pin_that_is_no_supply() {
    let (mut lines, mut pins): (Vec<u32>, Vec<u8>) = HEADER.into_iter().unzip();
    lines.sort_unstable();
    pins.sort_unstable();
    assert_eq!(lines, (2..28).collect::<Vec<_>>());
    // Supplies, grounds, and the two lines of the memory of an extension board.
    let others = [1, 2, 4, 6, 9, 14, 17, 20, 25, 27, 28, 30, 34, 39];
    assert_eq!(pins, (1..=40).filter(|pin| !others.contains(pin)).collect::<Vec<_>>());
}

/// Links to chips and files of other names are no chips; a file is no chip either.
#[test]
fn nodes_of_chips() {
    let folder = std::env::temp_dir().join(format!("gpio-nodes-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for name in ["gpiochip10", "gpiochip2", "gpiochipx", "gpiomem", "tty"] {
        std::fs::write(folder.join(name), "").unwrap();
    }
    std::os::unix::fs::symlink("gpiochip2", folder.join("gpiochip4")).unwrap();
    let kernel = Kernel { nodes: folder.clone() };
    assert_eq!(kernel.numbers(), Ok(vec![2, 10]));
    assert_eq!(kernel.open(3).err(), Some(ENOENT));
    assert_eq!(kernel.open(2).unwrap().facts().err(), Some(ENOTTY));
    let device = Device::new(
        crate::config::parse(|arg| if arg == "inputs" { vec!["A".to_owned()] } else { Vec::new() })
            .unwrap(),
    );
    assert_eq!(device.open(&kernel).err(), Some(Refused::Old(2)));
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(kernel.numbers(), Err(ENOENT));
}

/// A fault of one function stays while another one succeeds on another chip.
#[test]
fn a_fault_lasts_until_its_own_function_succeeds() {
    let mut chips = named(&["A"]);
    chips.chips.push((1, FakeChip { lines: vec![("B", None)], ..FakeChip::default() }));
    for lost in [0, 1] {
        let mut bench = Bench::new().with_hardware();
        chips.requested.lock().unwrap().clear();
        load(&mut bench, &chips, &["inputs=A", "outputs=B"]).unwrap();
        let lines = chips.requested.lock().unwrap()[lost].1.clone();
        for (error, fault) in [(Some(ENODEV), true), (None, false)] {
            *lines.inner().lost.lock().unwrap() = error;
            for function in ["read", "write", "read", "write"] {
                bench.run(&format!("hal_gpio.{function}"), MS);
            }
            bench.run("hal_gpio.read", MS);
            assert_eq!(bench.get::<bool>("hal_gpio.fault"), fault, "{lost}");
            bench.run("hal_gpio.write", MS);
            assert_eq!(bench.get::<bool>("hal_gpio.fault"), fault, "{lost}");
        }
    }
}
