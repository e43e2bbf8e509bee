//! The guarantee of the virtual clock: the same bytes on one processor or two, under load, in another environment, at
//! other addresses, with another arithmetic in the C library.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{
    case::{Around, cases, for_each},
    programs::root,
    scratch::{Running, Scratch},
    tools::Tool,
};
use std::{collections::BTreeMap, fmt::Write};

/// The printer's script: it moves, is sampled, saved and recorded.
const PRINTER: &str = "\
loadrt siggen
loadrt hypot
loadrt sampler depth=3000 cfg=ffffb
addf siggen.0.update servo-thread
addf hypot.0 servo-thread
addf sampler.0 servo-thread
net xpos-fb => sampler.0.pin.0
net ypos-fb => sampler.0.pin.1 hypot.0.in0
net wave siggen.0.sine => hypot.0.in1 sampler.0.pin.2
net far hypot.0.out => sampler.0.pin.3
net xdir => sampler.0.pin.4
iocontrol.estop-reset --wait
motion.enable --wait
motion.home joint=all --wait
motion.move x=13 y=7.7 z=-1.234 velocity=33.3
motion.move x=-1 y=2 velocity=90 --wait
motion.jog joint=0 velocity=50
loadusr -w halsampler -t -n 2500 samples
motion.jog-stop --wait
iocontrol.prepare tool=3 --wait
setp hal_manualtoolchange.change_button 1
iocontrol.change --wait
iocontrol.status
stop
save allu saved
save unconnectedinpins pins
show pin
show sig
show param
";

/// Returns the printer's output and every file that it wrote.
fn printer(around: &Around<'_>) -> BTreeMap<String, Vec<u8>> {
    let scratch = Scratch::copy_of(&root().join("tests/hal/printer"));
    scratch.write("custom_postgui.hal", PRINTER);
    let mut command = scratch.command(&around.before, "halrun");
    command.args(["--virtual", "--for", "20ms", "--record", "all.vcd", "impresora3D.ini"]);
    command.envs(around.environment.iter().copied());
    let output = scratch.run(&mut command);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let mut files = scratch.files();
    files.insert("stdout".to_owned(), output.stdout.into_bytes());
    files
}

/// Returns whether a program that runs others works here.
fn works(before: &[&str]) -> bool {
    let scratch = Scratch::new("works");
    let Some((first, rest)) = before.split_first() else { return true };
    let there = std::env::var("PATH").unwrap_or_default();
    let found = there.split(':').any(|folder| root().join(folder).join(first).is_file());
    found && scratch.run(scratch.command(&[], first).args(rest).arg("true")).status == Some(0)
}

/// Checks every case and the printer in these surroundings.
fn check(before: &[&str], environment: &[(&str, &str)]) {
    if !works(before) {
        Tool::of(before.first().unwrap()).skip();
        return;
    }
    let around = Around { before: before.to_vec(), environment: environment.to_vec() };
    let (plain, other) = (printer(&Around::default()), printer(&around));
    let mut differing = String::new();
    for (name, bytes) in &plain {
        let text = String::from_utf8_lossy(bytes);
        let text_other = String::from_utf8_lossy(other.get(name).map_or(&[], Vec::as_slice));
        let mut lines = text.lines().zip(text_other.lines()).enumerate();
        if let Some((n, (a, b))) = lines.find(|(_, (a, b))| a != b) {
            writeln!(differing, "{name}:{}:\n- {a}\n+ {b}", n + 1).unwrap();
        } else if text != text_other {
            writeln!(differing, "{name}: {} and {} bytes", text.len(), text_other.len()).unwrap();
        }
    }
    assert_eq!(differing, "");
    for name in ["stdout", "all.vcd", "samples", "saved", "pins"] {
        assert!(plain.get(name).is_some_and(|bytes| bytes.len() > 1000), "{name}");
    }
    for_each(&cases(), |case| case.check_in(&around));
}

#[test]
fn twice() {
    check(&[], &[]);
}

#[test]
fn on_one_processor() {
    check(&["taskset", "-c", "0"], &[]);
}

#[test]
fn under_load() {
    let scratch = Scratch::new("load");
    let _load: Vec<Running> = (0..3)
        .map(|_| scratch.start(scratch.command(&[], "sh").args(["-c", "while :; do :; done"])))
        .collect();
    check(&[], &[]);
}

#[test]
fn in_another_environment() {
    let padding = "x".repeat(100_000);
    check(
        &[],
        &[
            ("LC_ALL", "de_DE.UTF-8"),
            ("LANG", "tr_TR.UTF-8"),
            ("HOME", "/dev/null/none"),
            ("TZ", "Pacific/Chatham"),
            ("PADDING", &padding),
        ],
    );
}

#[test]
fn at_other_addresses() {
    check(&["setarch", "-R"], &[]);
}

#[test]
fn without_fused_arithmetic_in_the_c_library() {
    check(&[], &[("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4,-AVX512F")]);
}

/// Programs that nobody waits for in machine time: some end at once, some while the engine waits, one after more than the
/// second that other programs have to join.
#[test]
fn a_program_that_is_awaited_moves_no_machine_time() {
    let mut script = String::from(
        "loadrt threads name1=fast period1=1000000\nloadrt siggen\naddf siggen.0.update fast\nstart\nrun 5ms\n",
    );
    for seconds in ["0", "0.003", "0.011", "0.02", "0.033", "1.3"] {
        writeln!(script, "loadusr -w sh wait.sh {seconds}\ngetp siggen.0.sine").unwrap();
    }
    script.push_str("run 5ms\ngetp siggen.0.sine\n");
    let scratch = Scratch::new("awaited");
    // A sleep of the script itself would be machine time.
    scratch.write("wait.sh", "sleep $1\n");
    scratch.write("wait.hal", script);
    let output = scratch.halrun(&["--virtual", "-f", "wait.hal"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    let values: Vec<&str> = output.stdout.lines().collect();
    let [waits @ .., end] = values.as_slice() else { panic!("{values:?}") };
    assert!(waits.len() == 6 && waits.iter().all(|v| *v == waits[0]), "{values:?}");
    assert_ne!(waits[0], *end, "time goes on afterwards");
}
