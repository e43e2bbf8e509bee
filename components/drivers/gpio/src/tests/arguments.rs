//! Arguments: what each kind of mistake says, and what right ones mean.

use crate::{
    config::{BadLines, Bias, Drive, GpioConfig, MARKS, Place, Setting, parse},
    gpio::HalGpio,
    pi::PiGpio,
};
use hal_bench::Bench;

/// Returns what the arguments mean.
fn read(args: &str) -> Result<GpioConfig, BadLines> {
    let list = |arg: &str| {
        let words = args.split_whitespace().filter_map(|word| word.split_once('='));
        let found = words.filter(|(name, _)| *name == arg).flat_map(|(_, list)| list.split(','));
        found.map(str::to_owned).collect()
    };
    parse(list)
}

const BAD: &[(&str, &str)] = &[
    ("", "no lines: give inputs=, outputs= or encoders=, such as inputs=GPIO17"),
    ("invert=A", "no lines: give inputs=, outputs= or encoders=, such as inputs=GPIO17"),
    (
        "inputs=A,,B",
        "inputs= has an empty name: expected names of lines without blanks, such as GPIO5,GPIO6",
    ),
    (
        "outputs=A,",
        "outputs= has an empty name: expected names of lines without blanks, such as GPIO5,GPIO6",
    ),
    (
        "outputs=A pullup=",
        "pullup= has an empty name: expected names of lines without blanks, such as GPIO5,GPIO6",
    ),
    (
        "inputs=A23456789012345678901234567890123",
        "inputs= has the name 'A234567890123456789012345678901…': expected names of at most \
         31 bytes, as the kernel's",
    ),
    (
        "inputs=A,A",
        "line 'A' is named twice in inputs=, outputs= and encoders=: a line is one of these, once",
    ),
    (
        "inputs=A outputs=A",
        "line 'A' is named twice in inputs=, outputs= and encoders=: a line is one of these, once",
    ),
    (
        "encoders=A:A",
        "line 'A' is named twice in inputs=, outputs= and encoders=: a line is one of these, once",
    ),
    (
        "outputs=GPIO17 invert=GPOI17",
        "invert= names 'GPOI17', which is in none of inputs=, outputs=, encoders=; did you mean \
         'GPIO17'?",
    ),
    (
        "inputs=GPIO17 reset=PIN3",
        "reset= names 'PIN3', which is in none of inputs=, outputs=, encoders=",
    ),
    ("inputs=A opendrain=A", "opendrain= names 'A', which is an input: it is for outputs="),
    ("encoders=A opensource=A", "opensource= names 'A', which is an input: it is for outputs="),
    (
        "outputs=A debounce=A:100",
        "debounce= names 'A', which is an output: it is for inputs= and encoders=",
    ),
    (
        "outputs=A opendrain=A opensource=A",
        "line 'A' is in opendrain= and in opensource=: it can be one of these",
    ),
    (
        "inputs=A pulldown=A pullup=A",
        "line 'A' is in pulldown= and in pullup=: it can be one of these",
    ),
    (
        "inputs=A biasdisable=A pullup=A",
        "line 'A' is in biasdisable= and in pullup=: it can be one of these",
    ),
    (
        "inputs=A debounce=A",
        "debounce= has 'A': expected NAME:MICROSECONDS, such as GPIO17:2000, from 1 to 1000000",
    ),
    (
        "inputs=A debounce=A:0",
        "debounce= has 'A:0': expected NAME:MICROSECONDS, such as GPIO17:2000, from 1 to 1000000",
    ),
    (
        "inputs=A debounce=A:1000001",
        "debounce= has 'A:1000001': expected NAME:MICROSECONDS, such as GPIO17:2000, from 1 to \
         1000000",
    ),
    (
        "inputs=A debounce=A:5ms",
        "debounce= has 'A:5ms': expected NAME:MICROSECONDS, such as GPIO17:2000, from 1 to 1000000",
    ),
    (
        "encoders=A:B:C:D",
        "encoders= has 'A:B:C:D': expected A:B, A:B:INDEX, or the one line of a pulse counter",
    ),
    (
        "encoders=A:",
        "encoders= has an empty name: expected names of lines without blanks, such as GPIO5,GPIO6",
    ),
];

#[test]
fn each_mistake_is_named_with_its_remedy() {
    for (args, says) in BAD {
        assert_eq!(read(args).unwrap_err().to_string(), *says, "{args}");
    }
    let many: Vec<String> = (0..129).map(|n| format!("L{n}")).collect();
    let refused = read(&format!("inputs={}", many.join(","))).unwrap_err();
    assert_eq!(refused.to_string(), "more than 128 lines");
    assert_eq!(read(&format!("inputs={}", many[1..].join(","))).unwrap().lines.len(), 128);
}

/// The row of a mistake is refused by the component itself, with the same words.
#[test]
fn the_component_refuses_what_its_arguments_refuse() {
    for (args, says) in BAD {
        let args: Vec<&str> = args.split_whitespace().collect();
        assert_eq!(Bench::new().load::<HalGpio>(&args).unwrap_err(), *says, "{args:?}");
    }
}

#[test]
fn each_argument_sets_what_it_says() {
    let plain = Setting::default();
    let out = Setting { is_output: true, ..plain };
    for (args, setting, is_reset) in [
        ("inputs=A", plain, false),
        ("outputs=A", out, false),
        ("outputs=A invert=A", Setting { is_active_low: true, ..out }, false),
        ("outputs=A invert=A,A", Setting { is_active_low: true, ..out }, false),
        ("inputs=A activelow=A", Setting { is_active_low: true, ..plain }, false),
        ("outputs=A reset=A", out, true),
        ("outputs=A opendrain=A", Setting { drive: Drive::OpenDrain, ..out }, false),
        ("outputs=A opensource=A", Setting { drive: Drive::OpenSource, ..out }, false),
        ("inputs=A biasdisable=A", Setting { bias: Bias::Disabled, ..plain }, false),
        ("inputs=A pulldown=A", Setting { bias: Bias::PullDown, ..plain }, false),
        ("inputs=A pullup=A", Setting { bias: Bias::PullUp, ..plain }, false),
        ("inputs=A debounce=A:250", Setting { debounce_us: 250, ..plain }, false),
        ("encoders=A", Setting { has_edges: true, ..plain }, false),
    ] {
        let config = read(args).unwrap();
        assert_eq!(
            (config.lines[0].setting, config.lines[0].is_reset),
            (setting, is_reset),
            "{args}"
        );
        assert!(!config.is_without_effect, "{args}");
        let marks = MARKS.iter().filter(|mark| args.contains(&format!("{mark}="))).count();
        assert!(marks <= 1, "{args}");
    }
    let tested = |mark: &&str| BAD.iter().any(|(args, _)| args.contains(&format!("{mark}=")));
    assert_eq!(
        MARKS.iter().find(|mark| !tested(mark)),
        Some(&"activelow"),
        "it has no mistake of its own"
    );
}

#[test]
fn names_of_lines_without_a_name() {
    for (word, place) in [
        ("GPIO17", Place::Named),
        ("gpiochip0.17", Place::At { chip: 0, offset: 17 }),
        ("gpiochip12.300", Place::At { chip: 12, offset: 300 }),
        ("gpiochip0", Place::Named),
        ("gpiochip.1", Place::Named),
        ("gpiochip0.-1", Place::Named),
        ("gpiochip99999999999.1", Place::Named),
    ] {
        assert_eq!(read(&format!("inputs={word}")).unwrap().lines[0].place, place, "{word}");
    }
}

/// LinuxCNC takes these arguments for inputs and does nothing.
#[test]
fn an_output_argument_for_an_input_is_a_warning() {
    for args in [["inputs=A", "invert=A"], ["inputs=A", "reset=A"]] {
        let mut bench = Bench::new();
        bench.load::<HalGpio>(&args).unwrap();
        let said = bench.said();
        assert!(
            said.len() == 1 && said[0].contains("names an input, where it has no effect"),
            "{said:?}"
        );
        assert!(!bench.functs().contains(&"hal_gpio.reset".to_owned()));
    }
}

#[test]
fn masks_of_the_header() {
    for (args, says) in [
        (
            &["exclude=-1"][..],
            "exclude= leaves no line of the header: of its bits 0 to 25 at least one must be 0",
        ),
        (
            &["exclude=0x3FFFFFF"],
            "exclude= leaves no line of the header: of its bits 0 to 25 at least one must be 0",
        ),
    ] {
        assert_eq!(Bench::new().load::<PiGpio>(args).unwrap_err(), says, "{args:?}");
    }
}
