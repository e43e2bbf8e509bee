//! Functions in Python: what programs do with them, and what the functions do wrong.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_gcode::{Call, Environment, Interpreter};
use hal_golden::tools::Tool;
use hal_job::{
    Files, Machine, World,
    run::{Answers, Stop, run},
};
use hal_remap::Progress;
use std::{
    collections::BTreeMap, fmt::Write, path::PathBuf, process::Command, sync::Arc, time::Duration,
};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/functions")
}

/// Returns the world of the machine with its functions; `None` without Python.
fn world() -> Option<World> {
    if !Tool::of("python3").is_installed() {
        return None;
    }
    let ini = folder().join("machine.ini");
    let machine = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
    let world = World::with_functions(machine, BTreeMap::new());
    assert_eq!(world.machine.remarks, Vec::<String>::new());
    Some(world)
}

/// Runs a program and returns its calls, and its error.
fn outcome(world: &World, text: &str) -> String {
    let machine = &world.machine;
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    it.load("p.ngc", Arc::new(format!("{text}M2\n").into_bytes()));
    let answers = Answers { probe_trips: true, functions: world.functions.as_ref() };
    let mut out = String::new();
    let mut ended = false;
    let result = run(&mut it, world, answers, |_, issued| {
        // The end of the program makes the same calls always.
        ended |= matches!(issued.call, Call::SetG5xOffset { .. });
        if !ended {
            writeln!(out, "{}: {}", issued.line, issued.call).unwrap();
        }
        Ok(())
    });
    match result {
        Ok(()) => {}
        Err(Stop::Program(error)) => writeln!(out, "error: {error}").unwrap(),
        Err(Stop::Output(why)) => writeln!(out, "output: {why}").unwrap(),
    }
    out
}

#[test]
fn programs_do_with_functions_what_is_expected_and_the_same_twice() {
    let Some(world) = world() else { return };
    let programs = std::fs::read_to_string(folder().join("programs.txt")).unwrap();
    let mut all = String::new();
    for part in programs.split("== ").skip(1) {
        let (name, text) = part.split_once('\n').unwrap();
        let first = outcome(&world, text);
        writeln!(all, "== {name}\n{first}").unwrap();
        if name != "state" {
            assert_eq!(outcome(&world, text), first, "{name}");
        }
    }
    hal_golden::check(&folder().join("expected.txt"), &all);
}

/// LinuxCNC starts, too, and keeps its own meaning of the code.
#[test]
fn a_remap_of_a_code_that_has_a_meaning_is_ignored_with_a_remark() {
    let ini = std::env::temp_dir().join(format!("hal-remap-{}.ini", std::process::id()));
    std::fs::write(&ini, "[RS274NGC]\nREMAP = G1 ngc=a\nREMAP = M400 ngc=b\n").unwrap();
    let machine = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
    std::fs::remove_file(&ini).unwrap();
    assert_eq!(machine.settings.remaps.len(), 1);
    let remark = machine.remarks.join("\n");
    assert!(remark.contains(".ini:2: REMAP G1: the code cannot be remapped"), "{remark}");
    assert!(remark.ends_with("this line is ignored"), "{remark}");
}

#[test]
fn modules_that_cannot_be_imported_are_a_remark_and_an_error_of_each_call() {
    let Some(world) = world() else { return };
    let name = format!("hal-functions-{}", std::process::id());
    let room = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&room).unwrap();
    std::fs::write(room.join("top.py"), "import math\nimport nothing_of_this_name\n").unwrap();
    let ini = room.join("m.ini");
    let write = |python: &str| {
        let text = format!("[PYTHON]\n{python}\n[RS274NGC]\nREMAP = M400 py=f\n");
        std::fs::write(&ini, text).unwrap();
        Machine::read(&Files { ini: Some(&ini), ..Files::default() })
    };
    let broken = World::with_functions(write("TOPLEVEL = top.py").unwrap(), BTreeMap::new());
    let remarks = broken.machine.remarks.join("\n");
    let why = "top.py:2: ModuleNotFoundError: No module named 'nothing_of_this_name'";
    assert!(remarks.contains(why), "{remarks}");
    let failed = outcome(&broken, "M400\n");
    assert!(failed.contains("p.ngc:1: f: ") && failed.contains(why), "{failed}");
    let refused = |python: &str| write(python).err().unwrap();
    let none = refused("TOPLEVEL = none.py");
    assert!(none.contains("m.ini:2: [PYTHON]TOPLEVEL: there is no file"), "{none}");
    let time = refused("TIMEOUT = soon");
    assert!(time.contains("m.ini:2: [PYTHON]TIMEOUT = soon: must be seconds above 0"), "{time}");
    std::fs::remove_dir_all(room).unwrap();
    assert!(world.function("twice") && !world.function("around"));
    assert!(world.open("twice").is_some());
}

#[test]
fn the_import_of_the_modules_is_no_part_of_a_step() {
    if world().is_none() {
        return;
    }
    let room = std::env::temp_dir().join(format!("hal-imports-{}", std::process::id()));
    std::fs::create_dir_all(&room).unwrap();
    // The second import waits until somebody opens the gate.
    let gate = "import os, remap\nif os.path.exists('gate'):\n    open('gate').read()\n";
    std::fs::write(room.join("top.py"), gate).unwrap();
    std::fs::write(room.join("remap.py"), "def f(self):\n    pass\n").unwrap();
    let ini = room.join("m.ini");
    let text = "[PYTHON]\nPATH_PREPEND = .\nTOPLEVEL = top.py\nTIMEOUT = 0.05\n\
                [RS274NGC]\nREMAP = M400 modalgroup=10 py=f\n";
    std::fs::write(&ini, text).unwrap();
    let machine = Machine::read(&Files { ini: Some(&ini), ..Files::default() }).unwrap();
    let world = World::with_functions(machine, BTreeMap::new());
    assert_eq!(world.machine.remarks, Vec::<String>::new());
    let settings = world.machine.settings.clone();
    let mut it = Interpreter::new(settings, world.machine.numbered.clone());
    it.load("p.ngc", Arc::new(b"M400\nM2\n".to_vec()));
    let mut out = Vec::new();
    while it.state.function().is_none_or(|_| it.state.pending.is_none()) {
        it.next(&world, &mut out).unwrap();
    }
    let mut functions = world.functions.as_ref().unwrap().borrow_mut();
    functions.end();
    let made = Command::new("mkfifo").arg(room.join("gate")).status().unwrap();
    assert!(made.success());
    functions.begin(&it.state, &world).unwrap();
    for _ in 0..20 {
        let progress = functions.progress(Duration::from_millis(10));
        assert_eq!(progress, Progress::Pending);
        assert!(!functions.is_ready());
    }
    std::fs::write(room.join("gate"), "").unwrap();
    while !functions.is_ready() {
        assert_eq!(functions.progress(Duration::from_millis(10)), Progress::Pending);
    }
    drop(functions);
    std::fs::remove_dir_all(room).unwrap();
}
