//! Waits of jobs: each is reported once, and a wait without an end of its own ends `--run` where no person is.

use hal_tests::scratch::{Output, Scratch};

/// Exit status of a wait that has lasted too long.
const WAITED: Option<i32> = Some(3);

const HAL: &str = "\
loadrt [KINS]KINEMATICS
loadrt motmod servo_period_nsec=1000000 num_joints=3
loadrt sim_spindle names=sp
loadrt limit2 names=ramp
addf motion-command-handler servo-thread
addf motion-controller servo-thread
addf ramp servo-thread
addf sp servo-thread
setp ramp.maxv 20
net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net x joint.0.motor-pos-cmd joint.0.motor-pos-fb
net y joint.1.motor-pos-cmd joint.1.motor-pos-fb
net z joint.2.motor-pos-cmd joint.2.motor-pos-fb
net a spindle.0.speed-out-rps => ramp.in
net b ramp.out => sp.velocity-cmd spindle.0.speed-in
net rev sp.position-fb => spindle.0.revs
";

/// Returns a machine of three axes with this program, and these lines behind its HAL file.
fn machine(program: &str, lines: &str) -> Scratch {
    let scratch = Scratch::new("waits");
    let mut ini = "[EMC]\nVERSION=1.1\n[TASK]\nTASK=milltask\nAT_SPEED_TIMEOUT=1000\n[RS274NGC]\nPARAMETER_FILE=v.var\n\
                   [HAL]\nHALFILE=m.hal\n[KINS]\nKINEMATICS=trivkins coordinates=xyz\nJOINTS=3\n\
                   [TRAJ]\nCOORDINATES=XYZ\nLINEAR_UNITS=mm\nMAX_LINEAR_VELOCITY=200\n[EMCIO]\nTOOL_TABLE=t.tbl\n"
        .to_owned();
    for joint in 0..3 {
        ini.push_str(&format!(
            "[JOINT_{joint}]\nMIN_LIMIT=-300\nMAX_LIMIT=300\nMAX_VELOCITY=100\nMAX_ACCELERATION=1000\n\
             HOME=0\nHOME_SEQUENCE=0\nFERROR=5\n"
        ));
    }
    scratch.write("m.ini", ini);
    scratch.write("m.hal", format!("{HAL}{lines}"));
    scratch.write("t.tbl", "T1 P1 Z0\nT2 P2 Z0\n");
    scratch.write("part.ngc", program);
    scratch
}

fn run(program: &str, lines: &str, words: &[&str]) -> Output {
    let all = [&["--virtual", "--headless", "--run", "part.ngc"], words, &["m.ini"]].concat();
    machine(program, lines).halrun(&all)
}

#[test]
fn a_wait_without_an_end_of_its_own_ends_a_run_that_nobody_sees() {
    for (program, lines, who) in [
        ("M0", "", "a person at M0: task.resume goes on, task.abort ends it"),
        ("M60", "", "a person who changes the pallet at M60"),
        ("M3 S100\nM19 R90\nG1 X1", "", "the angle of spindle 0"),
        ("M3 S100\nG33 Z-5 K1", "unlinkp spindle.0.revs\n", "the index of spindle 0"),
        ("T2 M6", "", "tool 2: it goes on when iocontrol.0.tool-changed says"),
        ("M3 S100\nG1 X1", "setp spindle.0.at-speed 0\n", "the speed of spindle 0"),
        ("G1 X1", "setp motion.feed-inhibit 1\n", "the end of a feed inhibit"),
        ("G1 X1", "setp motion.feed-hold 1\n", "the end of a feed hold"),
        (
            "M3 S100\nG95 G1 X1 F1",
            "unlinkp spindle.0.speed-in\n",
            "the turns of spindle 0, which the path follows",
        ),
    ] {
        let program = format!("G21 G90 F600\n{program}\nM2\n");
        let output = run(&program, lines, &[]);
        assert_eq!(output.status, WAITED, "{program}: {}", output.stderr);
        let told = format!("waits for {who}");
        assert_eq!(output.stderr.matches(&told).count(), 1, "{program}: {}", output.stderr);
        let ends = format!("gives up after 60 s of waiting for {who}");
        assert!(output.stderr.contains(&ends), "{program}: {}", output.stderr);
        let end = output.stderr.split("part.ngc: given up after ").nth(1).unwrap_or_default();
        let seconds: f64 = end.split(' ').next().unwrap_or_default().parse().unwrap_or(f64::NAN);
        assert!((59.9..70.0).contains(&seconds), "{program}: {}", output.stderr);
    }
}

#[test]
fn the_pin_that_no_signal_drives_is_named() {
    let program = "G21 G90 F600\nM3 S100\nG33 Z-5 K1\nM2\n";
    let output = run(program, "unlinkp spindle.0.revs\n", &["--max-wait", "5s"]);
    assert_eq!(output.status, WAITED, "{}", output.stderr);
    assert!(output.stderr.contains("(spindle.0.index-enable is not linked)"), "{}", output.stderr);
    assert!(output.stderr.contains("part.ngc: line 3: gives up after 5 s"), "{}", output.stderr);
}

#[test]
fn a_wait_that_ends_by_itself_does_not_count() {
    let near = "loadrt near names=near\naddf near servo-thread\nsetp near.difference 0.1\nsetp ramp.maxv 0.1\n\
                net a near.in1\nnet b near.in2\nnet fast near.out spindle.0.at-speed\n";
    for (program, lines) in [
        ("G4 P100", ""),
        ("M66 P0 L3 Q100", ""),
        // A ramp of 83 s.
        ("M3 S500\nG1 X1", near),
    ] {
        let program = format!("G21 G90 F600\n{program}\nM2\n");
        let output = run(&program, lines, &[]);
        assert_eq!(output.status, Some(0), "{program}: {}", output.stderr);
    }
}

#[test]
fn the_longest_wait_is_an_option() {
    let output = run("M0\nM2\n", "", &["--max-wait", "2s"]);
    assert_eq!(output.status, WAITED, "{}", output.stderr);
    assert!(output.stderr.contains("gives up after 2 s of waiting"), "{}", output.stderr);
    let output = run("M0\nM2\n", "", &["--max-wait", "soon"]);
    assert_eq!(output.status, Some(1));
    assert!(output.stderr.contains("--max-wait 'soon': it is never, or a time such as 60s"));
}

/// Runs commands of a held machine, each on its line behind the start.
fn held(program: &str, commands: &str) -> Output {
    let scratch = machine(program, "");
    scratch.write(
        "held.hal",
        format!(
            "task.estop-reset --wait\ntask.on --wait\nmotion.home joint=all --wait\ntask.mode mode=auto --wait\n\
             task.open file=part.ngc --wait\n{commands}shutdown\n"
        ),
    );
    let ini = scratch.read("m.ini").replace("[KINS]", "POSTGUI_HALFILE=held.hal\n[KINS]");
    scratch.write("m.ini", ini);
    scratch.halrun(&["--virtual", "--hold", "-k", "m.ini"])
}

#[test]
fn a_late_refusal_of_a_held_script_names_its_line() {
    let output = held(
        "M2\n",
        "task.estop\nrun 100ms\ntask.on\nrun 100ms\ntask.estop-reset\ntask.on\nrun 300ms\ntask.status\n\
         motion.jog joint=0 velocity=1 distance=1000\nrun 10ms\ntask.resume\nrun 10ms\n",
    );
    let wanted = "held.hal:8: task.on: the machine is in e-stop: task.estop-reset comes first";
    assert_eq!(output.stderr.matches(wanted).count(), 1, "{}", output.stderr);
    assert!(
        output.stderr.contains("held.hal:16: task.resume: nothing is paused"),
        "{}",
        output.stderr
    );
    assert!(output.stdout.starts_with("task state=on "), "the reset, then on: {}", output.stdout);
}

#[test]
fn a_stop_by_a_person_is_told_as_one() {
    let scratch = machine("G21 G90 F60\nG1 X50\nM2\n", "");
    // A timer that presses the e-stop after two seconds of the job.
    scratch.write(
        "m.hal",
        scratch.read("m.hal")
            + "loadrt timedelay names=press\naddf press servo-thread\nsetp press.on-delay 3\nnet on motion.motion-enabled press.in\n\
               net abort press.out task.abort\n",
    );
    let ini =
        scratch.read("m.ini").replace("HALFILE=m.hal", "HALFILE=m.hal\nPOSTGUI_HALFILE=late.hal");
    let hal = scratch.read("m.hal");
    let (early, late) = hal.split_once("net abort").unwrap();
    scratch.write("m.hal", early);
    scratch.write("late.hal", format!("net abort{late}"));
    scratch.write("m.ini", ini);
    let output = scratch.halrun(&["--virtual", "--run", "part.ngc", "m.ini"]);
    assert_eq!(output.status, Some(1), "{}", output.stderr);
    let lines: Vec<&str> = output.stderr.lines().collect();
    assert!(
        lines[lines.len() - 1].starts_with("part.ngc: stopped by an abort at line 2 after "),
        "{lines:?}"
    );
    assert!(!output.stderr.contains("task.run:"), "{lines:?}");
}

#[test]
fn an_error_is_shown_once_with_its_line() {
    for (program, lines, text) in [
        ("G38.2 Z-5 F600", "", "part.ngc:2: the probe move ended without a change of the probe"),
        ("G0 X500", "", "part.ngc:2: task.run: X500.0000 is 200.0000 mm beyond"),
    ] {
        let output = run(&format!("G21 G90\n{program}\nM2\n"), lines, &[]);
        assert_eq!(output.status, Some(1), "{}", output.stderr);
        let words = text.rsplit(": ").next().unwrap_or_default();
        assert_eq!(output.stderr.matches(words).count(), 1, "{program}: {}", output.stderr);
        assert!(output.stderr.contains(text), "{program}: {}", output.stderr);
    }
}

#[test]
fn parameters_on_a_full_disk_fail_the_run() {
    let scratch = machine("G10 L2 P1 X5\nM2\n", "");
    let ini = scratch.read("m.ini").replace("PARAMETER_FILE=v.var", "PARAMETER_FILE=none/v.var");
    scratch.write("m.ini", ini);
    let output = scratch.halrun(&["--virtual", "--run", "part.ngc", "m.ini"]);
    assert_eq!(output.status, Some(1), "{}", output.stderr);
    let is_told = |line: &&str| line.contains("part.ngc:2: ") && line.contains("none/v.var: ");
    assert_eq!(output.stderr.lines().filter(is_told).count(), 1, "{}", output.stderr);
}

#[test]
fn a_resume_turns_a_stopped_spindle_again() {
    let output = held(
        "G21 G90\nM3 S500\nG4 P.3\nG1 X50 F1000\nM5\nM2\n",
        "task.run\nrun 1s\ntask.pause\nrun 500ms\nmotion.spindle speed=0\nrun 500ms\nstatus instance\ntask.resume\nrun 900ms\n\
         getp spindle.0.on\nrun 3s\ngetp joint.0.motor-pos-cmd\n",
    );
    let lines: Vec<&str> = output.stdout.lines().collect();
    let wait = lines.iter().find(|line| line.contains("wait:")).copied().unwrap_or_default();
    assert!(
        wait.contains("spindle 0 was stopped after it was turned"),
        "{lines:?} {}",
        output.stderr
    );
    assert_eq!(lines[lines.len() - 2..], ["TRUE", "50"], "{}", output.stderr);
}
