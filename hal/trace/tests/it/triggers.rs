//! Triggers on known signals, checked to the exact sample.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::{Type, Value};
use hal_trace::{
    Trace,
    trigger::{Capture, Cause, Condition, HoldOff, Mode, Setup, Trigger, When},
};

fn channels() -> Vec<(String, Type)> {
    let all = [
        ("b", Type::Bit),
        ("c", Type::Bit),
        ("f", Type::Float),
        ("i", Type::S32),
        ("u", Type::U32),
        ("l", Type::S64),
        ("m", Type::U64),
        ("a name", Type::Bit),
    ];
    all.iter().map(|(n, t)| ((*n).to_owned(), *t)).collect()
}

fn when(text: &str) -> When {
    Condition::parse(text).unwrap().bind(&channels()).unwrap()
}

/// Returns sample n of the known signals, at n times 25 µs.
fn record(n: u64) -> [u64; 8] {
    let wave = n % 1000;
    let triangle = if wave < 500 { wave } else { 1000 - wave } as f64 - 250.0;
    let signed = i64::try_from(n % 7).unwrap() - 3;
    [
        u64::from(n % 10 >= 5),
        u64::from(n % 7 == 3),
        if n % 1000 == 999 { f64::NAN } else { triangle }.to_bits(),
        Value::S32(i32::try_from(signed).unwrap()).bits(),
        u64::from(u32::MAX) - n % 5,
        Value::S64(i64::MIN + signed.abs()).bits(),
        u64::MAX - n % 3,
        u64::from(n == 777_777),
    ]
}

/// Expected result of a condition at a sample, computed in Rust from the sample's number.
type Truth = fn(u64) -> bool;

fn f(n: u64) -> f64 {
    f64::from_bits(record(n)[2])
}

const TRUTHS: &[(&str, Truth)] = &[
    ("b rises", |n| n > 0 && n % 10 == 5),
    ("b falls", |n| n > 0 && n % 10 == 0),
    ("b toggles", |n| n > 0 && n % 5 == 0),
    ("b changes", |n| n > 0 && n % 5 == 0),
    ("b", |n| n % 10 >= 5),
    ("not b", |n| n % 10 < 5),
    ("b = TRUE", |n| n % 10 >= 5),
    ("b != 1", |n| n % 10 < 5),
    ("'a name' rises", |n| n == 777_777),
    ("\"b rises and c\"", |n| n > 0 && n % 10 == 5 && n % 7 == 3),
    ("'a name'&&!c", |n| n == 777_777 && n % 7 != 3),
    ("i changes", |n| n > 0),
    ("f > 249", |n| f(n) > 249.0),
    ("f >= 249", |n| f(n) >= 249.0),
    ("f < -249.5", |n| f(n) < -249.5),
    ("f <= -1e99", |_| false),
    ("f == 100", |n| f(n) == 100.0),
    ("f != 100", |n| f(n) != 100.0),
    ("f rises through 0.5", |n| n % 1000 == 251),
    ("f falls through 0.5", |n| n % 1000 == 750),
    ("f rises through 0", |n| n % 1000 == 250),
    ("f crosses 0", |n| n % 1000 == 250 || n % 1000 == 750),
    ("f in -1..1", |n| f(n).abs() <= 1.0),
    ("f outside -249..249", |n| f(n).abs() > 249.0),
    ("i = -3", |n| n % 7 == 0),
    ("i < -2", |n| n % 7 == 0),
    ("i in -3..-2", |n| n % 7 <= 1),
    ("u = 4294967295", |n| n % 5 == 0),
    ("u > 4294967293", |n| n % 5 <= 1),
    ("l = -9223372036854775808", |n| n % 7 == 3),
    ("l > -9223372036854775807", |n| (n % 7).abs_diff(3) > 1),
    ("m = 18446744073709551615", |n| n.is_multiple_of(3)),
    ("m falls through 18446744073709551613", |n| n > 0 && n % 3 == 2),
    ("b rises and c", |n| n > 0 && n % 10 == 5 && n % 7 == 3),
    ("b rises or c rises", |n| n > 0 && (n % 10 == 5 || n % 7 == 3)),
    ("b and not c and f > 0", |n| n % 10 >= 5 && n % 7 != 3 && f(n) > 0.0),
    ("not (b or c)", |n| n % 10 < 5 && n % 7 != 3),
    ("c || b && f>0", |n| n % 7 == 3 || n % 10 >= 5 && f(n) > 0.0),
    ("! b && (c rises or f = 0)", |n| n % 10 < 5 && (n > 0 && n % 7 == 3 || f(n) == 0.0)),
];

#[test]
fn none_is_missed_in_a_million_cycles_and_none_is_made_up() {
    let conditions: Vec<(When, Truth, &str)> =
        TRUTHS.iter().map(|(text, truth)| (when(text), *truth, *text)).collect();
    let mut before = None;
    let mut fired = vec![0_u64; conditions.len()];
    for n in 0..1_000_000 {
        let now = record(n);
        for ((when, truth, text), fired) in conditions.iter().zip(&mut fired) {
            let holds = when.holds(before.as_ref().map(<[u64; 8]>::as_slice), &now);
            assert_eq!(holds, truth(n), "{text} at {n}");
            *fired += u64::from(holds);
        }
        before = Some(now);
    }
    assert!(fired.iter().zip(TRUTHS).all(|(n, t)| *n > 0 || t.0.contains("1e99")), "{fired:?}");
}

/// Feeds samples. Returns the number and cause of each trigger, and the number of each capture's
/// last sample.
fn run(trigger: &mut Trigger, samples: std::ops::Range<u64>) -> Vec<(u64, Cause, u64)> {
    let mut out: Vec<(u64, Cause, u64)> = Vec::new();
    for n in samples {
        let step = trigger.feed(i64::try_from(n).unwrap() * 25_000, &record(n));
        out.extend(step.fired.map(|cause| (n, cause, u64::MAX)));
        if step.complete {
            out.last_mut().unwrap().2 = n;
        }
    }
    out
}

#[test]
fn every_trigger_of_a_million_cycles_makes_a_capture_when_there_is_room() {
    // b rises every 10 cycles; 4 samples before the trigger, 10 in all: each capture ends before
    // the next trigger.
    let setup = Setup { length: 10, before: 4, mode: Mode::Normal, ..Setup::default() };
    let mut trigger = Trigger::new(Some(when("b rises")), setup, 8);
    let got = run(&mut trigger, 0..1_000_001);
    assert_eq!(got.len(), 100_000);
    for ((n, cause, end), wanted) in got.into_iter().zip((5..).step_by(10)) {
        assert_eq!((n, cause, end), (wanted, Cause::Condition, wanted + 5));
    }
}

#[test]
fn the_share_before_the_trigger_is_exact_and_waited_for() {
    for share in [0.0, 0.1, 0.25, 0.5, 0.999, 1.0, f64::NAN, -1.0] {
        for length in [1, 2, 10, 64, 1000] {
            let setup = Setup { length, ..Setup::default() }.with_share(share);
            let mut capture = Capture::new(&channels(), Some(when("b rises")), setup);
            let mut got = Vec::new();
            for n in 0..3000 {
                let time = i64::try_from(n).unwrap() * 25_000;
                got.extend(capture.feed(time, &record(n), 0).map(|t| (n, t)));
            }
            let [(end, trace)] = &got[..] else { panic!("{share} {length}: {}", got.len()) };
            // The first rising edge with enough samples before it.
            let fired = (0..).find(|n| n % 10 == 5 && *n >= setup.before).unwrap();
            assert_eq!(*end, fired + length - setup.before - 1, "{share} {length}");
            assert_eq!(trace.len() as u64, length);
            let at = trace.markers()[0].at;
            assert_eq!(at, i64::try_from(fired).unwrap() * 25_000);
            assert_eq!(trace.times().until(at).map(|s| s as u64), Some(setup.before));
            for sample in 0..trace.len() {
                let number = fired - setup.before + sample as u64;
                let time = i64::try_from(number).unwrap() * 25_000;
                assert_eq!(trace.times().get(sample), Some(time));
                for (c, bits) in record(number).into_iter().enumerate() {
                    assert_eq!(
                        trace.value(c, sample).unwrap(),
                        Value::from_bits(channels()[c].1, bits)
                    );
                }
            }
            assert!(capture.trigger().is_idle() && capture.rest().is_none());
        }
    }
}

#[test]
fn hold_off_counts_from_the_trigger() {
    let setup = Setup { length: 2, mode: Mode::Normal, ..Setup::default() };
    let held = |hold_off| {
        let setup = Setup { hold_off, ..setup };
        let mut trigger = Trigger::new(Some(when("b rises")), setup, 8);
        run(&mut trigger, 0..100).into_iter().map(|t| t.0).collect::<Vec<_>>()
    };
    assert_eq!(held(HoldOff::Samples(10)), [5, 15, 25, 35, 45, 55, 65, 75, 85, 95]);
    assert_eq!(held(HoldOff::Samples(11)), [5, 25, 45, 65, 85]);
    assert_eq!(held(HoldOff::Time(750_000)), [5, 35, 65, 95]);
    assert_eq!(held(HoldOff::Time(750_001)), [5, 45, 85]);
    assert_eq!(held(HoldOff::Time(i64::MAX)), [5]);
}

#[test]
fn auto_fires_when_nothing_does_and_not_when_something_does() {
    let setup = |ns| Setup { length: 3, mode: Mode::Auto(ns), ..Setup::default() };
    let mut never = Trigger::new(Some(when("f > 1e9")), setup(1_000_000), 8);
    let got = run(&mut never, 0..120);
    // 40 cycles after arming. The trigger is armed at the first sample and at the end of each
    // capture.
    assert_eq!(got, [(40, Cause::Auto, 42), (82, Cause::Auto, 84)]);
    let mut often = Trigger::new(Some(when("b rises")), setup(1_000_000), 8);
    assert!(run(&mut often, 0..1000).iter().all(|t| t.1 == Cause::Condition));
}

#[test]
fn force_fires_at_once_and_only_once() {
    let setup =
        Setup { length: 4, before: 2, mode: Mode::Normal, hold_off: HoldOff::Samples(1000) };
    let mut trigger = Trigger::new(Some(when("'a name' = 1")), setup, 8);
    trigger.force();
    assert_eq!(run(&mut trigger, 0..20), [(2, Cause::Force, 3)]);
    trigger.force();
    assert_eq!(run(&mut trigger, 20..40), [(20, Cause::Force, 21)]);
}

#[test]
fn it_is_armed_again_while_samples_run() {
    let setup = Setup { length: 10, before: 3, mode: Mode::Single, ..Setup::default() };
    let mut trigger = Trigger::new(Some(when("b rises")), setup, 8);
    assert_eq!(run(&mut trigger, 0..100), [(5, Cause::Condition, 11)]);
    assert!(trigger.is_idle());
    trigger.arm();
    assert_eq!(run(&mut trigger, 100..108), [(105, Cause::Condition, u64::MAX)]);
    // Arming in the middle of a capture aborts it. The next trigger counts, with all samples before
    // it.
    trigger.arm();
    assert_eq!(run(&mut trigger, 108..130), [(115, Cause::Condition, 121)]);
    trigger.arm_for(Some(when("c rises")));
    assert_eq!(run(&mut trigger, 130..150), [(136, Cause::Condition, 142)]);
    trigger.arm();
    trigger.disarm();
    assert_eq!(run(&mut trigger, 150..170), []);
    trigger.arm_for(None);
    assert_eq!(run(&mut trigger, 170..200), [(170, Cause::Condition, 176)]);

    // An edge at the first sample after arming counts.
    assert_eq!(run(&mut trigger, 200..205), []);
    trigger.arm_for(Some(when("b rises")));
    assert_eq!(run(&mut trigger, 205..206), [(205, Cause::Condition, u64::MAX)]);
}

#[test]
fn lost_samples_are_gaps_in_the_capture() {
    let setup = Setup { length: 6, before: 3, ..Setup::default() };
    let mut capture = Capture::new(&channels(), Some(when("b rises")), setup);
    let mut trace = Trace::default();
    for n in (0..40).filter(|n| !(8..11).contains(n) && *n != 16) {
        let lost = match n {
            11 => 3,
            17 => 1,
            _ => 0,
        };
        let mut got = capture.feed(n * 25_000, &record(n.unsigned_abs()), lost);
        if n == 6 {
            capture.arm();
        }
        if let Some(got) = got.take() {
            trace = got;
        }
    }
    let times: Vec<i64> = trace.times().iter().map(|t| t / 25_000).collect();
    assert_eq!(times, [12, 13, 14, 15, 17, 18]);
    let gaps: Vec<_> = trace.gaps().iter().map(|g| (g.sample, g.lost)).collect();
    assert_eq!(gaps, [(4, 1)]);
}

#[test]
fn a_condition_is_found_in_a_trace() {
    let mut trace = Trace::default();
    for (name, ty) in channels() {
        trace.add(&name, ty);
    }
    for n in 0..2000 {
        trace.push(i64::try_from(n).unwrap(), &record(n)).unwrap();
    }
    let found = when("f rises through 0 and b rises");
    assert_eq!(found.first(&trace, 0), None);
    let found = when("f rises through 0");
    assert_eq!(found.first(&trace, 0), Some(250));
    assert_eq!(found.first(&trace, 250), Some(250));
    assert_eq!(found.first(&trace, 251), Some(1250));
}

#[test]
fn what_is_wrong_is_said_with_a_mark() {
    let mut all = String::new();
    for text in [
        "",
        "b and",
        "and b",
        "b rises falls",
        "b rose",
        "(b or c",
        "b)",
        "f >",
        "f > and",
        "f in 5",
        "f in 3..1",
        "f in nan..1",
        "nope rises",
        "f rises",
        "f falls",
        "f",
        "not i",
        "i toggles",
        "b > 0",
        "b in 0..1",
        "b rises through 1",
        "i > 2.5",
        "u = -1",
        "u = 4294967296",
        "b = 2",
        "f > fast",
        "'b rises",
        "b & c",
        "ü = 1 and f ~ 2",
        "port",
    ] {
        let mut channels = channels();
        channels.push(("port".to_owned(), Type::Port));
        let said = match Condition::parse(text).and_then(|c| c.bind(&channels)) {
            Ok(_) => format!("{text}: nothing is wrong"),
            Err(e) => e.to_string(),
        };
        all.push_str(&said);
        all.push('\n');
    }
    let deep = format!("{}b{}", "(".repeat(60), ")".repeat(60));
    assert_eq!(Condition::parse(&deep).unwrap_err().why(), "this is nested too deeply");
    let long = "b or ".repeat(10_000) + "b";
    assert!(Condition::parse(&long).unwrap().bind(&channels()).is_ok());
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/trigger-errors.expected");
    hal_golden::check(path.as_ref(), &all);
}
