//! Programs and lines of MDI.

use super::*;
use std::os::unix::fs::PermissionsExt as _;

#[test]
fn a_program_runs_and_its_second_run_is_the_same() {
    let mut rig = Rig::new("G21 G90 G0 X10 Y0\nG1 X20 Y5 F300\nG2 X30 Y5 I5 J0\nM2\n");
    let first = rig.run();
    assert_eq!(first[..3], ["1: line 10 0 0", "2: line 20 5 0", "3: arc 30 5 0"]);
    assert_eq!(first.last().unwrap(), "Spindle { spindle: 0, speed: 0.0 }");
    assert_eq!(rig.core.interpreting(), Interpreting::Idle);
    assert_eq!(rig.core.jobs, (1, 0));
    assert_eq!(rig.run(), first, "the second run");
    assert!(rig.fake.saves >= 2, "the parameters are written at each end");
}

#[test]
fn offsets_units_and_tools_make_machine_coordinates() {
    let mut rig = Rig::new(
        "G21 G10 L2 P1 X100 Y0 Z0\nG54 G92 X-1\nT1 M6\nG43 H1\nG20 G1 X1 Z0 F10\nG21 G92.1\nG49\n\
         G53 G0 X0 Z0\nM2\n",
    );
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    assert_eq!(rig.core.awaited_tool(), Some(1));
    assert_eq!(
        rig.sent(),
        ["Prepare { tool: 1, pocket: 1, index: 1 }", "Spindle { spindle: 0, speed: 0.0 }"],
        "the change waits for the tool"
    );
    rig.pass(1.0);
    rig.fake.answer_changer();
    rig.pass(0.1);
    assert_eq!(rig.sent(), ["Change"]);
    assert_eq!(rig.result(ticket), None, "it waits for the person");
    rig.fake.answer_changer();
    rig.pass(1.0);
    assert_eq!(rig.result(ticket), Some(Ok(())));
    let sent = rig.sent();
    assert_eq!(sent[0], "ToolOffset([0.0, 0.0, 10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])");
    // G92 calls the place of X0 X-1: 25.4 mm in the program is 26.4 mm from the machine's zero.
    let moved: Vec<&String> = sent.iter().filter(|s| s.contains("line")).collect();
    let words: Vec<&str> = moved[0].split(' ').collect();
    let near = |word: &str, value: f64| (word.parse::<f64>().unwrap() - value).abs() < 1e-9;
    assert!(near(words[2], 26.4) && near(words[4], 10.0), "{words:?}");
    assert_eq!(moved[1], "8: line 0 0 0");
}

#[test]
fn feeds_and_path_modes_reach_motion() {
    let mut rig = Rig::new("G21 G64 P0.1 G1 X1 F600\nG61 X2\nG61.1 X3\nG64 X4\nG0 X5\nM2\n");
    let mut moves = Vec::new();
    rig.send(Command::Run);
    rig.step();
    for (_, m, _) in &rig.fake.moves {
        moves.push((m.speed, m.end));
    }
    use crate::outside::{PathEnd, Speed};
    let feed = Speed::Feed(10.0);
    let free = PathEnd::Blend(f64::INFINITY);
    assert_eq!(
        moves,
        [
            (feed, PathEnd::Blend(0.1)),
            (feed, PathEnd::Exact),
            (feed, PathEnd::Stop),
            (feed, free),
            (Speed::Rapid, free)
        ]
    );
}

#[test]
fn what_needs_rest_waits_for_the_moves_before_it() {
    let mut rig = Rig::new("G21 G0 X1\nM3 S1000\nG0 X2\nM8\nG4 P0.5\nG0 X3\nM62 P1\nM64 P2\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.05);
    assert_eq!(rig.sent(), ["1: line 1 0 0"]);
    rig.pass(0.07);
    let started = ["Spindle { spindle: 0, speed: 1000.0 }", "3: line 2 0 0"];
    assert_eq!(rig.sent(), started);
    rig.pass(0.13);
    assert_eq!(rig.sent(), ["Coolant { mist: None, flood: Some(true), lube: None }"]);
    rig.pass(0.4);
    assert_eq!(rig.sent().len(), 0, "the pause");
    rig.pass(0.1);
    assert_eq!(rig.sent(), ["6: line 3 0 0", "Digital { index: 1, on: true, with_motion: true }"]);
    rig.pass(0.1);
    assert_eq!(rig.sent()[0], "Digital { index: 2, on: true, with_motion: false }");
}

#[test]
fn a_probe_and_an_input_answer_the_interpreter() {
    let mut rig = Rig::new(
        "G21 G38.2 Z-10 F100\n#1=#5063\nM66 P3 L3 Q2\n#2=#5399\nM66 P4 L3 Q1\n#3=#5399\n\
         G0 X#1 Y#2 Z#3\nM2\n",
    );
    let ticket = rig.send(Command::Run);
    rig.step();
    assert_eq!(rig.sent(), ["1: probe 0 0 -10"]);
    rig.fake.motion.probe_found = true;
    rig.fake.motion.probe_measured = [0.0, 0.0, -4.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    rig.pass(1.0);
    assert_eq!(rig.core.interpreting(), Interpreting::Waiting);
    rig.fake.motion.digital_in = 1 << 3;
    rig.pass(2.5);
    let moved = rig.sent();
    assert_eq!(moved[0], "7: line -4.5 1 -1", "the second input timed out");
    assert!(rig.core.input_was_late);
    assert_eq!(rig.result(ticket), Some(Ok(())));
}

#[test]
fn pauses_stops_and_single_steps() {
    let mut rig = Rig::new("G21 G0 X1\nM0\nG0 X2\nM1\nG0 X3\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.5);
    assert_eq!(rig.sent(), ["1: line 1 0 0"]);
    assert_eq!(rig.core.interpreting(), Interpreting::Paused);
    rig.good(Command::OptionalStop(false));
    rig.good(Command::Resume);
    rig.pass(0.05);
    assert_eq!(rig.sent(), ["3: line 2 0 0"]);
    rig.good(Command::Pause);
    rig.pass(1.0);
    assert_eq!(rig.sent(), ["Pause"], "nothing goes on while it is paused");
    assert_eq!(rig.refused(Command::Run), "a program cannot begin while a program runs");
    rig.good(Command::Resume);
    rig.pass(1.0);
    assert_eq!(rig.sent()[..2], ["Resume", "5: line 3 0 0"]);
    assert_eq!(rig.core.interpreting(), Interpreting::Idle);

    let mut rig = Rig::new("G21 G0 X1\n#1=5\n(nothing)\nG0 X2\nG0 X3\nM2\n");
    rig.send(Command::Step);
    rig.pass(0.5);
    assert_eq!(rig.sent(), ["1: line 1 0 0"]);
    assert_eq!(rig.core.interpreting(), Interpreting::Paused);
    rig.good(Command::Step);
    rig.pass(0.5);
    assert_eq!(rig.sent(), ["4: line 2 0 0"]);
    rig.good(Command::Resume);
    rig.pass(0.5);
    assert_eq!(rig.sent()[0], "5: line 3 0 0");
    assert_eq!(rig.refused(Command::Resume), "nothing is paused");
}

#[test]
fn block_delete_leaves_lines_out() {
    let mut rig = Rig::new("G21 G0 X1\n/ G0 X2\nM2\n");
    assert_eq!(rig.run()[..1], ["1: line 1 0 0"]);
    assert!(!rig.run().contains(&"2: line 2 0 0".to_owned()));
    rig.good(Command::BlockDelete(false));
    assert!(rig.run().contains(&"2: line 2 0 0".to_owned()));
}

/// A button's line of MDI runs from any mode without a job, and the mode comes back after it.
#[test]
fn a_button_of_mdi_returns_to_the_mode_before_it() {
    let mut rig = Rig::new("G1 F60 X1\nM2\n");
    rig.good(Command::Mode(Mode::Auto));
    let first = rig.send(Command::BriefMdi("G0 X1".into()));
    let second = rig.send(Command::BriefMdi("G0 X2".into()));
    assert_eq!(rig.core.mode, Mode::Mdi);
    for _ in 0..10 {
        rig.pass(0.1);
    }
    assert_eq!((rig.result(first), rig.result(second)), (Some(Ok(())), Some(Ok(()))));
    assert_eq!(rig.core.mode, Mode::Auto);
    // While a program runs, and off, nothing changes.
    let program = rig.send(Command::Run);
    rig.pass(0.01);
    let why = rig.refused(Command::BriefMdi("G0 X1".into()));
    assert_eq!(why, "MDI is not possible while a program runs");
    rig.pass(1.0);
    assert_eq!(rig.result(program), Some(Ok(())));
    rig.good(Command::Mode(Mode::Manual));
    rig.fake.motion.enabled = false;
    rig.step();
    let why = rig.refused(Command::BriefMdi("G0 X1".into()));
    assert!(why.starts_with("MDI needs a machine that is on"), "{why}");
    assert_eq!(rig.core.mode, Mode::Manual);
}

#[test]
fn mdi_has_a_queue_of_ten() {
    let mut rig = Rig::new("M2\n");
    assert!(rig.refused(Command::Mdi("G0 X1".into())).starts_with("MDI needs mode mdi"));
    rig.good(Command::Mode(Mode::Mdi));
    let tickets: Vec<Ticket> =
        (1..=10).map(|n| rig.send(Command::Mdi(format!("G21 G0 X{n}").into()))).collect();
    assert_eq!(rig.refused(Command::Mdi("G0".into())), "10 lines of MDI wait already");
    rig.pass(0.15);
    assert_eq!(rig.result(tickets[0]), Some(Ok(())));
    assert_eq!(rig.result(tickets[1]), None);
    let mut gaps = 0;
    for _ in 0..1000 {
        rig.pass(0.01);
        let ends = tickets.iter().all(|t| rig.result(*t).is_some());
        if ends {
            break;
        }
        // Between two lines a job is still in progress.
        assert!(rig.core.has_work());
        gaps += u32::from(!rig.core.is_busy());
    }
    assert!(gaps > 0, "the queue has no gap without a line in execution");
    rig.pass(0.1);
    assert!(!rig.core.has_work());
    assert!(tickets.iter().all(|t| rig.result(*t) == Some(Ok(()))));
    let sent = rig.sent();
    assert_eq!((sent.len(), &*sent[9]), (10, "1: line 10 0 0"));
    // What MDI sets stays for the next line.
    rig.send(Command::Mdi("G91".into()));
    rig.send(Command::Mdi("G0 X1".into()));
    rig.pass(1.0);
    assert_eq!(rig.sent(), ["1: line 11 0 0"]);
}

#[test]
fn the_tool_table_is_written_when_its_line_is_executed() {
    let mut rig = Rig::new("G21 G0 X1\nG10 L1 P2 Z33\nG43 H2\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.05);
    assert!(rig.fake.tables.is_empty(), "the move before it has not ended");
    rig.pass(1.0);
    assert_eq!(rig.fake.tables.len(), 1);
    assert!(rig.fake.tables[0].contains("T2 P2 D+1.000000 X+0.000000 Y+0.000000 Z+33.000000"));
    assert!(rig.sent().iter().any(|s| s.starts_with("ToolOffset([0.0, 0.0, 33.0")));
}

#[test]
fn a_job_of_people_elsewhere_runs_user_codes_with_their_rights() {
    let rig = || {
        let rig = Rig::with("M101 P1\nM2\n", |rules| rules.needs_homing = false);
        let path = rig.folder.join("M101");
        std::fs::write(&path, "#!/bin/sh\n").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        rig
    };
    let began = |rig: &mut Rig, far: bool, command: Command| {
        rig.core.is_from_afar = far;
        rig.send(command);
        rig.core.is_from_afar = false;
        for _ in 0..50 {
            rig.step();
        }
        rig.sent().join(" ")
    };
    for (far, wanted) in [(false, "M101 1 -1"), (true, "M101 1 -1 from afar")] {
        for begin in [Command::Run, Command::Step] {
            let mut rig = rig();
            assert_eq!(began(&mut rig, far, begin.clone()), wanted, "{begin:?}");
        }
        let mut rig = rig();
        rig.good(Command::Mode(Mode::Mdi));
        assert_eq!(began(&mut rig, far, Command::Mdi("M101 P1".into())), wanted);
        // A line of somebody else that waits behind it has the rights of who gave it.
        let behind = if far { "M101 2 -1" } else { "M101 2 -1 from afar" };
        assert_eq!(began(&mut rig, !far, Command::Mdi("M101 P2".into())), "");
        rig.fake.program = Progress::Done;
        assert_eq!(began(&mut rig, false, Command::OptionalStop(true)), behind);
    }
}

#[test]
fn people_elsewhere_open_programs_of_the_folder_of_programs_alone() {
    let mut rig = Rig::new("M2\n");
    let (programs, other) = (rig.folder.join("nc_files"), rig.folder.join("job.ngc"));
    std::fs::create_dir_all(programs.join("uploads")).unwrap();
    for name in ["own.ngc", "uploads/sent.ngc"] {
        std::fs::write(programs.join(name), "M2\n").unwrap();
    }
    std::os::unix::fs::symlink(&other, programs.join("link.ngc")).unwrap();
    std::fs::write(rig.folder.join("m.ini"), "[EMC]\n").unwrap();
    let ini = hal_ini::Ini::read(&rig.folder.join("m.ini")).unwrap();
    let places = hal_job::places::Places::read(&ini, &rig.folder).unwrap();
    rig.core.world.machine.places = Some(places);
    let wanted = format!("opened from afar in {} alone", programs.display());
    rig.core.is_from_afar = true;
    rig.good(Command::Open(programs.join("own.ngc")));
    rig.good(Command::Open(programs.join("uploads/sent.ngc")));
    for (path, why) in [
        (other.clone(), &*wanted),
        ("/etc/passwd".into(), &*wanted),
        (programs.join("../job.ngc"), "the name has '..'"),
        (programs.join("link.ngc"), "a symbolic link is here or on the way"),
        (programs.clone(), "the name is empty"),
        (programs.join("none.ngc"), "No such file"),
    ] {
        let said = rig.refused(Command::Open(path.clone()));
        assert!(said.contains(why), "{}: {said}", path.display());
    }
    assert_eq!(rig.core.program, Some(programs.join("uploads/sent.ngc")));
    rig.core.is_from_afar = false;
    rig.good(Command::Open(other));
}

#[test]
fn a_user_code_is_awaited_and_its_failure_ends_the_job() {
    let mut rig = Rig::new("M101 P1 Q2.5\nG21 G0 X1\nM2\n");
    let path = rig.folder.join("M101");
    std::fs::write(&path, "#!/bin/sh\n").unwrap();
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    rig.send(Command::Run);
    rig.pass(1.0);
    assert_eq!(rig.sent(), ["M101 1 2.5"]);
    rig.fake.program = Progress::Done;
    rig.pass(1.0);
    assert_eq!(rig.sent()[0], "2: line 1 0 0");
    let ticket = rig.send(Command::Run);
    rig.pass(0.1);
    rig.fake.program = Progress::Failed("M101 ended with exit status: 1".to_owned());
    rig.pass(0.1);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.contains("job.ngc:1") && why.contains("exit status: 1"), "{why}");
}

#[test]
fn a_probe_move_pauses() {
    let mut rig = Rig::new("G21 G38.2 Z-5 F100\nM2\n");
    rig.send(Command::Run);
    rig.pass(0.05);
    rig.sent();
    rig.good(Command::Pause);
    assert_eq!(rig.sent(), ["Pause"]);
    rig.good(Command::Resume);
    assert_eq!(rig.sent(), ["Resume"]);
}

#[test]
fn a_value_of_hal_is_that_behind_the_motion_before_its_line() {
    let program =
        "G21 G90\nG0 X1\no1 if [#<_hal[a.b]> GT 2]\nG0 X5\no1 else\nG0 X6\no1 endif\nM2\n";
    for (value, wanted) in [(7.0, "4: line 5 0 0"), (1.0, "6: line 6 0 0")] {
        let mut rig = Rig::new(program);
        rig.fake.hal.insert("a.b".to_owned(), 9.0 - value);
        let ticket = rig.send(Command::Run);
        rig.pass(0.05);
        assert_eq!(rig.sent(), ["2: line 1 0 0"], "nothing is asked while it moves");
        // What changes during the move counts.
        rig.fake.hal.insert("a.b".to_owned(), value);
        let sent = rig.ended(ticket);
        assert_eq!(sent[..2], ["value of a.b", wanted], "{sent:?}");
    }
}

/// Values of `a.b`, and why the job then ends at its line.
#[test]
fn a_value_of_hal_that_is_none_ends_the_job_at_its_line() {
    for (value, wanted) in [
        (None, "job.ngc:3:5: Named parameter #<_hal[a.b]> not defined"),
        (Some(f64::NAN), "job.ngc:3: HAL: a.b is NaN, which is not a finite number"),
        (Some(f64::INFINITY), "job.ngc:3: HAL: a.b is inf, which is not a finite number"),
    ] {
        let mut rig = Rig::new("G21 G90\nG0 X1\nG0 X#<_hal[a.b]>\nG0 X9\nM2\n");
        rig.fake.hal.extend(value.map(|v| ("a.b".to_owned(), v)));
        let ticket = rig.send(Command::Run);
        rig.pass(1.0);
        let why = rig.result(ticket).unwrap().unwrap_err();
        assert!(why.contains(wanted), "{why}");
        assert!(rig.sent().iter().all(|order| !order.contains("line 9")));
    }
}

#[test]
fn a_value_that_was_asked_for_before_an_abort_is_not_that_of_the_next_run() {
    let mut rig = Rig::new("G21 G90\nG0 X#<_hal[a.b]>\nM2\n");
    rig.fake.hal.insert("a.b".to_owned(), 3.0);
    let ticket = rig.send(Command::Run);
    rig.step();
    rig.good(Command::Abort);
    rig.pass(0.1);
    assert!(rig.result(ticket).unwrap().is_err());
    rig.fake.hal.insert("a.b".to_owned(), 4.0);
    rig.sent();
    let sent = rig.run();
    assert!(sent.contains(&"2: line 4 0 0".to_owned()), "{sent:?}");
}

/// A tool table that is edited while a job runs is not overwritten, and is read again with G10 L0.
#[test]
fn a_tool_table_that_is_edited_meanwhile_is_not_overwritten() {
    let run = |edit: bool, program: &str| {
        let mut file = PathBuf::new();
        let mut rig = Rig::on_machine(program, |machine, _| {
            file = machine.folders[0].join("tool.tbl");
            std::fs::write(&file, TOOLS).unwrap();
            machine.table = Some(file.clone());
            machine.reload_tools().unwrap();
        });
        let ticket = rig.send(Command::Run);
        rig.pass(0.1);
        if edit {
            std::fs::write(&file, "T1 P1 Z99 D3\nT2 P2 Z20 D1\n").unwrap();
        }
        rig.pass(3.0);
        (rig.result(ticket).unwrap(), rig.fake.tables.clone())
    };
    let (result, tables) = run(false, "G21 G4 P1\nG10 L1 P1 Z5\nM2\n");
    assert_eq!((result, tables.len()), (Ok(()), 1));
    let (result, tables) = run(true, "G21 G4 P1\nG10 L1 P1 Z5\nM2\n");
    let why = result.unwrap_err();
    assert!(why.contains("tool.tbl: the tool table has changed since it was read"), "{why}");
    assert!(tables.is_empty(), "{tables:?}");
    let (result, tables) = run(true, "G21 G4 P1\nG10 L0\nG10 L1 P2 Z5\nM2\n");
    assert_eq!(result, Ok(()));
    assert!(tables[0].contains("99"), "{tables:?}");
}

#[test]
fn files_of_a_program_are_written_in_the_order_of_execution() {
    let mut rig = Rig::new(
        "(LOGOPEN,a.txt)\n(LOG,x is #5420)\nG21 G0 X1\n(LOG,x is #5420)\n(PROBEOPEN b.txt)\n\
         G38.3 Z-5 F100\nG38.3 Z-6\n(PROBECLOSE)\n(LOGCLOSE)\nM2\n",
    );
    rig.fake.motion.probe_found = true;
    rig.fake.motion.probe_measured = [1.0, 0.0, -4.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    rig.run();
    let open = |kind, name: &str| {
        format!("{:?}", FileAction::Open { kind, name: name.into(), append: false })
    };
    let line = |kind, text: &str| format!("{:?}", FileAction::Line(kind, text.into()));
    let close = |kind| format!("{:?}", FileAction::Close(kind));
    let probed = line(
        FileKind::Probe,
        "1.000000 0.000000 -4.500000 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000",
    );
    assert_eq!(
        rig.fake.lines,
        [
            open(FileKind::Log, "a.txt"),
            line(FileKind::Log, "x is 0.000000"),
            line(FileKind::Log, "x is 1.000000"),
            open(FileKind::Probe, "b.txt"),
            probed.clone(),
            probed,
            close(FileKind::Probe),
            close(FileKind::Log),
            close(FileKind::Log),
            close(FileKind::Probe),
        ]
    );
}

#[test]
fn a_file_that_cannot_be_written_ends_the_program_at_its_line() {
    let mut rig = Rig::new("G21 G0 X1\n(LOGOPEN,full)\nG0 X2\nM2\n");
    let ticket = rig.send(Command::Run);
    rig.pass(0.5);
    let why = rig.result(ticket).unwrap().unwrap_err();
    assert!(why.ends_with("job.ngc:2: full: No space left on device"), "{why}");
    assert!(!rig.sent().iter().any(|s| s.starts_with("3: ")));
}
