//! Every C component of LinuxCNC's package: loaded, driven for 10,000 cycles, unloaded, and loaded again, each in a
//! process of its own.
//!
//! `cargo test -p hal-tests --test system peer::modules -- --ignored` runs all of them and compares with `tests/compat/modules.md`;
//! with `UPDATE_EXPECT=1` it writes that file. Without the package, the test is reported as skipped.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "tests")]

use hal_protocol::{Direction, Kind, Link, Request, Value};
use hal_tests::{
    foreign::{Bench, installed},
    golden,
    machine::script,
    programs::root,
    random::Random,
    tools,
};
use std::{collections::BTreeSet, fmt::Write, process::Command};

/// Requirements of a module's load: modules before it, its arguments.
const ARGUMENTS: &[(&str, &[&str], &str)] = &[
    ("bldc", &[], "cfg=qi6"),
    ("debounce", &[], "cfg=4"),
    ("gantry", &[], "personality=3"),
    ("hal_parport", &[], "cfg=0x378"),
    ("hm2_7i43", &["hostmot2"], ""),
    ("hm2_7i90", &["hostmot2"], ""),
    ("hm2_eth", &["hostmot2"], ""),
    ("hm2_pci", &["hostmot2"], ""),
    ("hm2_rpspi", &["hostmot2"], ""),
    ("hm2_spi", &["hostmot2"], ""),
    ("hm2_test", &["hostmot2"], "test_pattern=12"),
    ("lcd", &[], "fmt_strings=%4.4f"),
    ("mesa_7i65", &["hostmot2"], ""),
    ("mesa_pktgyro_test", &["hostmot2"], ""),
    ("mesa_uart", &["hostmot2"], ""),
    ("message", &[], "messages=one"),
    ("motmod", &["trivkins", "tpmod", "homemod"], "servo_period_nsec=1000000 num_joints=3"),
    ("mux_generic", &[], "config=bb4,fs2"),
    ("pwmgen", &[], "output_type=0,1"),
    ("sampler", &[], "depth=100 cfg=fbsu"),
    ("setsserial", &["hostmot2"], ""),
    // With fewer gears, the number of a missing gear ends the process, in LinuxCNC as well.
    ("spindle", &[], "numgears=16"),
    ("stepgen", &[], "step_type=0,2"),
    ("streamer", &[], "depth=100 cfg=fbsu"),
    ("threads", &[], "name1=fast period1=1000000"),
    ("watchdog", &[], "num_inputs=2"),
    ("weighted_sum", &[], "wsum_sizes=3"),
];

/// Reasons why a module does not run here.
const REASONS: &[(&str, &str)] = &[
    ("hal_bb_gpio", "a driver of a BeagleBone: it opens the board's memory, and there is none"),
    ("hal_gm", "a driver of a PCI card, and PCI is not offered"),
    ("hal_lib", "not a component: LinuxCNC's own library, whose place the engine takes"),
    ("hal_pi_gpio", "a driver of a Raspberry Pi: it looks for the board, and there is none"),
    ("hal_ppmc", "a driver of a board on the parallel port: it looks for it, and there is none"),
    ("hm2_7i43", "a driver of a Mesa card: it looks for one, and there is none"),
    ("hm2_7i90", "a driver of a Mesa card: it looks for one, and there is none"),
    ("hm2_pci", "a driver of a PCI card, and PCI is not offered"),
    ("hm2_rpspi", "a driver of a Raspberry Pi: it looks for the board, and there is none"),
    ("hm2_spi", "a driver of a Mesa card: it looks for one, and there is none"),
    ("mesa_pktgyro_test", "serves a Mesa card, and none is there"),
    ("mesa_uart", "serves a Mesa card, and none is there"),
    ("setsserial", "sets up a Mesa card and always ends with a refusal, its work done"),
    ("boss_plc", "crashes as it is loaded, in LinuxCNC as well"),
];

const CYCLES: u64 = 10_000;
const PERIOD: u64 = 1_000_000;

fn wanted(module: &str) -> (&'static [&'static str], &'static str) {
    let found = ARGUMENTS.iter().find(|(name, ..)| *name == module);
    found.map_or((&[], ""), |(_, before, args)| (*before, *args))
}

/// Returns a value for an input: mostly small, and true for enables.
fn chosen(name: &str, now: Value, r: &mut Random) -> Option<Value> {
    let enables = ["enable", "power", "machine-on", "is-on"].iter().any(|w| name.contains(w));
    Some(match now {
        Value::Bit(_) => Value::Bit(if enables { r.below(10) > 0 } else { r.below(2) == 0 }),
        Value::Float(_) => Value::Float((r.unit() * 4000.0).round() / 1000.0),
        Value::S32(_) => Value::S32(i32::try_from(r.below(12)).unwrap() - 2),
        Value::U32(_) => Value::U32(u32::try_from(r.below(12)).unwrap()),
        Value::S64(_) => Value::S64(i64::try_from(r.below(12)).unwrap() - 2),
        Value::U64(_) => Value::U64(r.below(12)),
        Value::Port(_) => return None,
    })
}

/// Drives one module; returns the row of the table.
fn drive(module: &str) -> String {
    let folder = installed().unwrap();
    let mut b = Bench::new(&[&folder]);
    let (before, args) = wanted(module);
    let mut thread = "t";
    if module == "threads" {
        thread = "fast";
    } else if module == "motmod" {
        thread = "servo-thread";
    } else {
        script(&mut b, "loadrt threads name1=t period1=1000000");
    }
    let clean: BTreeSet<String> = b.items(Kind::Pins, "").into_iter().map(|i| i.name).collect();
    for name in before {
        if let Err(e) = b.load_c("", name) {
            return format!("no | | | | | {e}");
        }
    }
    if let Err(e) = b.load_c("", &format!("{module} {args}")) {
        return format!("no | | | | | {e}");
    }
    let mut owners: Vec<&str> = before.to_vec();
    owners.push(module);
    let functs: Vec<String> = owners.iter().flat_map(|o| b.functs(o)).map(|f| f.name).collect();
    let mine = |b: &mut Bench, kind| -> Vec<_> {
        let all = b.items(kind, "").into_iter();
        all.filter(|i| owners.contains(&&*i.owner_name) && !clean.contains(&i.name)).collect()
    };
    let (pins, params) = (mine(&mut b, Kind::Pins), mine(&mut b, Kind::Params));
    for f in &functs {
        script(&mut b, &format!("addf {f} {thread}"));
    }
    script(&mut b, "start");
    let outputs: Vec<_> = pins
        .iter()
        .chain(&params)
        .filter(|i| matches!(i.direction, Direction::Out | Direction::Io | Direction::Ro))
        .map(|i| (i.name.clone(), i.value))
        .collect();
    let inputs: Vec<_> = pins
        .iter()
        .filter(|i| matches!(i.direction, Direction::In | Direction::Io))
        .map(|i| (i.name.clone(), i.value))
        .collect();
    let mut r = Random::new(module.bytes().map(u64::from).sum());
    let mut changed = BTreeSet::new();
    for _ in 0..CYCLES / 20 {
        for (name, now) in &inputs {
            if r.below(3) == 0
                && let Some(value) = chosen(name, *now, &mut r)
            {
                b.set(name, value);
            }
        }
        b.call(Request::Run { ns: 20 * PERIOD }).unwrap();
        if changed.len() < outputs.len() {
            for (name, first) in &outputs {
                if !changed.contains(name) && hal_tests::machine::get(&mut b, name) != *first {
                    changed.insert(name.clone());
                }
            }
        }
    }
    let cycles = hal_tests::machine::thread(&mut b, thread).cycles;
    for name in owners.iter().rev() {
        script(&mut b, &format!("unloadrt {name}"));
    }
    let left: Vec<_> = b.items(Kind::Pins, "").into_iter().map(|i| i.name).collect();
    let left = left.iter().filter(|n| !clean.contains(*n)).count();
    let again = before
        .iter()
        .map(|n| (*n).to_owned())
        .chain([format!("{module} {args}")])
        .try_for_each(|words| b.load_c("", &words));
    let again = match again {
        Ok(()) if left == 0 => "yes".to_owned(),
        Ok(()) => format!("{left} pins left"),
        Err(e) => e,
    };
    format!(
        "{} | {} | {} | {cycles} | {} of {} | {again}",
        pins.len(),
        params.len(),
        functs.len(),
        changed.len(),
        outputs.len()
    )
}

/// Prints the row of the module that the environment names. Runs in a process of its own.
#[test]
fn one_module() {
    if let Ok(module) = std::env::var("HAL_TEST_MODULE") {
        println!("\nROW {}", drive(&module));
    }
}

fn row(module: &str) -> (bool, String) {
    let mut me = Command::new(std::env::current_exe().unwrap());
    me.args([
        "--exact",
        &hal_tests::programs::own_test(module_path!(), "one_module"),
        "--nocapture",
    ])
    .env("HAL_TEST_MODULE", module);
    let out = me.output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let found = text.lines().find_map(|l| l.strip_prefix("ROW "));
    let reason = REASONS.iter().find(|(name, _)| *name == module).map(|(_, why)| *why);
    let why = |said: &str| match reason {
        Some(why) => why.to_owned(),
        None => format!("unexplained: {said}"),
    };
    match found {
        Some(row) if row.starts_with("no |") => {
            (false, format!("| `{module}` | | | | | | no: {} |", why(row)))
        }
        Some(row) => (row.ends_with("| yes"), format!("| `{module}` | {row} |")),
        None => {
            let said = String::from_utf8_lossy(&out.stderr).into_owned();
            (false, format!("| `{module}` | | | | | | no: {} |", why(said.trim())))
        }
    }
}

fn modules() -> Vec<String> {
    let files = std::fs::read_dir(installed().unwrap()).unwrap();
    let names = files.map(|f| f.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> =
        names.filter_map(|n| n.strip_suffix(".so").map(str::to_owned)).collect();
    names.sort();
    names
}

/// Motion with its kinematics, planner and homing, and some modules of each kind.
#[test]
fn some_modules_run() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let table = std::fs::read_to_string(root().join("tests/compat/modules.md")).unwrap();
    for module in ["and2", "pid", "motmod"] {
        let (runs, row) = row(module);
        assert!(runs, "{row}");
        assert!(table.contains(&row), "{row}");
    }
}

#[test]
#[ignore = "takes a minute, needs LinuxCNC's package: cargo test -p hal-tests --test system peer::modules -- --ignored"]
fn all_modules() {
    if tools::linuxcnc().is_none() {
        return;
    }
    let rows: Vec<(bool, String)> = modules().iter().map(|m| row(m)).collect();
    let running = rows.iter().filter(|(runs, _)| *runs).count();
    let mut text = format!(
        "# LinuxCNC's components in C, as they are in its package\n\n\
         Each is loaded, put into a thread of 1 ms, started with its inputs driven by chance, run\n\
         for {CYCLES} cycles, unloaded and loaded again, in a process of its own.\n\
         `UPDATE_EXPECT=1 cargo test -p hal-tests --test system peer::modules -- --ignored` writes this file.\n\n\
         {running} of {} run.\n\n\
         | component | pins | parameters | functions | cycles | outputs that changed | again |\n\
         |---|---|---|---|---|---|---|\n",
        rows.len()
    );
    for (_, row) in &rows {
        writeln!(text, "{row}").unwrap();
    }
    let file = root().join("tests/compat/modules.md");
    golden::check(&file, &text);
    assert!(running >= 150, "only {running} run");
    assert!(!text.contains("unexplained"), "{text}");
}
