//! Jobs: a program on a whole machine, from `--run` to the step pulses.
#![expect(clippy::indexing_slicing, clippy::panic, reason = "tests")]

use hal_tests::{programs::root, scratch::Scratch, vcd::Vcd};

/// Steps of a millimetre of X, Y and Z.
const SCALES: [f64; 3] = [4.0, 4.0, 285.714_285_714_285_7];
/// Distance from the path that the program allows: G61, exact path.
const TOLERANCE: f64 = 0.002;

/// Programmed corners and points of `configs/printer/pedal.ngc`, in their order.
fn programmed() -> Vec<[f64; 3]> {
    let mut path = vec![[0.0, 0.0, 0.0], [5.0, 5.0, 1.0]];
    for slice in [-3.0, -6.0] {
        path.push([5.0, 5.0, slice]);
        for (x, y) in [(35.0, 5.0), (35.0, 10.0), (5.0, 10.0), (5.0, 15.0)] {
            path.push([x, y, slice]);
        }
        for (x, y) in [(35.0, 15.0), (35.0, 20.0), (5.0, 20.0), (5.0, 25.0)] {
            path.push([x, y, slice]);
        }
        path.extend([[5.0, 25.0, 1.0], [5.0, 5.0, 1.0]]);
    }
    for row in 0..=16 {
        let side = if row % 2 == 0 { 1.0 } else { -1.0 };
        for n in 0..=15 {
            let x = side * (2.0 * f64::from(n) - 15.0);
            path.push([20.0 + x, 5.0 + 1.25 * f64::from(row), -6.5 - x * x / 225.0]);
        }
    }
    path.extend([[35.0, 25.0, 1.0], [0.0, 0.0, 0.0]]);
    path
}

/// Returns the places of the machine after each step, from the pulses alone.
fn stepped(vcd: &Vcd) -> Vec<[f64; 3]> {
    let mut pulses = Vec::new();
    for axis in 0..3 {
        let letter = ["x", "y", "z"][axis];
        let direction = format!("{letter}dir");
        for time in vcd.rises(&format!("{letter}step")) {
            let sign = if vcd.at(&direction, time) == 0.0 { 1.0 } else { -1.0 };
            pulses.push((time, axis, sign));
        }
    }
    pulses.sort_by_key(|(time, axis, _)| (*time, *axis));
    let mut at = [0.0; 3];
    let mut out = Vec::new();
    for (_, axis, sign) in pulses {
        at[axis] += sign / SCALES[axis];
        out.push(at);
    }
    out
}

/// Returns whether a place is within one step of each axis, and the tolerance, of a part of the path.
fn is_near(at: &[f64; 3], from: &[f64; 3], to: &[f64; 3], scales: &[f64; 3]) -> bool {
    // The shares of the part for which each axis is near.
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let most = 1.0 / scales[axis] + TOLERANCE;
        let (off, way) = (at[axis] - from[axis], to[axis] - from[axis]);
        if way == 0.0 {
            if off.abs() > most {
                return false;
            }
            continue;
        }
        let (a, b) = ((off - most) / way, (off + most) / way);
        low = low.max(a.min(b));
        high = high.min(a.max(b));
    }
    low <= high
}

/// Checks that places follow a path from its first point to its last, never back.
pub(super) fn follows(places: &[[f64; 3]], path: &[[f64; 3]], scales: &[f64; 3]) {
    let mut part = 0;
    for at in places {
        let rest = path.windows(2).enumerate().skip(part);
        let near = rest.take(4).find(|(_, w)| is_near(at, &w[0], &w[1], scales));
        let Some((n, _)) = near else {
            panic!("{at:?} is not near the path behind {:?}", path[part])
        };
        part = n;
    }
    assert!(part + 2 >= path.len(), "the path ends at part {part} of {}", path.len());
    let (last, goal) = (places[places.len() - 1], path[path.len() - 1]);
    let is_there = |axis: usize| (last[axis] - goal[axis]).abs() < 0.5 / scales[axis];
    assert!((0..3).all(is_there), "{last:?}, not {goal:?}");
}

fn printer(part: &str) -> Scratch {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    scratch.write("part.ngc", part);
    scratch
}

#[test]
fn a_part_with_two_tools_goes_from_its_program_to_the_pulses() {
    let run = || {
        let scratch = printer("");
        let output = scratch.halrun(&["--virtual", "--run", "pedal.ngc", "pedal.ini"]);
        assert_eq!(output.status, Some(0), "{}", output.stderr);
        (output.stderr, scratch.read("pedal.vcd"), scratch.read("linuxcnc.var"))
    };
    let (said, recorded, parameters) = run();
    for part in [
        "pedal.ngc: line 4: waits for tool 1: ",
        "Insert tool 1 and set hal_manualtoolchange.change_button.\n",
        "pedal.ngc: line 25: waits for tool 2: ",
        "pedal.ngc: ended after ",
    ] {
        assert!(said.contains(part), "no {part:?} in\n{said}");
    }
    let vcd = Vcd::parse(&recorded);
    // It stood still while the person changed a tool.
    for change in vcd.rises("tool-change") {
        let during = |t: &i64| (change..change + 2_000_000_000).contains(t);
        let steps = vcd.rises("xstep").iter().filter(|t| during(t)).count();
        assert_eq!(steps, 0, "X moves while the tool is changed");
    }
    assert_eq!(vcd.rises("tool-change").len(), 2);
    follows(&stepped(&vcd), &programmed(), &SCALES);
    assert_eq!(parameters.lines().next(), Some("5161\t0.000000"));
    assert_eq!(run(), (said, recorded, parameters), "the second run");
}

#[test]
fn a_program_beyond_a_limit_is_refused_with_its_line_before_it_begins() {
    let scratch = printer("G21 G90\nG0 X10\nG0 X999\nM2\n");
    let output = scratch.halrun(&["--virtual", "--run", "part.ngc", "printer.ini"]);
    assert_eq!(output.status, Some(1));
    let refused =
        "/part.ngc:3: task.run: X999.0000 is 799.0000 mm beyond [AXIS_0]MAX_LIMIT = 200 (";
    assert!(output.stderr.contains(refused), "{}", output.stderr);
    assert!(output.stderr.contains("/printer.ini:60)"), "{}", output.stderr);
    assert!(output.stderr.contains("part.ngc: failed after 0.000 s"), "{}", output.stderr);
}

#[test]
fn a_run_from_a_line_shows_its_entry_and_goes_on_from_there() {
    let program =
        "G21 G90 G61\nG0 X5 Y5\no1 repeat [3]\nG91 G1 X10 F600\nG90\no1 endrepeat\nG0 X0 Y0\nM2\n";
    let scratch = printer(program);
    let words = ["--virtual", "--run", "part.ngc", "--from", "4/3"];
    let asked = scratch.halrun(&[&words[..], &["printer.ini"]].concat());
    assert_eq!(asked.status, Some(1));
    assert!(
        asked.stderr.contains(
            "standard input is no terminal, so nobody can agree: --yes begins without a question"
        ),
        "{}",
        asked.stderr
    );
    assert!(!asked.stderr.contains("position X25"), "nothing is switched on: {}", asked.stderr);
    let run =
        scratch.halrun(&[&words[..], &["--yes", "--record", "out.vcd", "printer.ini"]].concat());
    assert_eq!(run.status, Some(0), "{}", run.stderr);
    for part in [" line=4 pass=3 of=3\n", "position X25.0000 Y5.0000", "over: over the place"] {
        assert!(run.stderr.contains(part), "no {part:?} in\n{}", run.stderr);
    }
    assert!(run.stderr.contains("part.ngc: ended after "), "{}", run.stderr);
    let vcd = Vcd::parse(&scratch.read("out.vcd"));
    let rises = |pin: &str| vcd.rises(pin).len();
    // X goes to 25, to 35 and back to 0; from the first line it would go there by 5 and 15, too.
    assert_eq!(rises("stepgen.0.step"), 2 * 35 * 4);
    assert_eq!(rises("stepgen.1.step"), 2 * 5 * 4);
    let refused = scratch.halrun(&[
        "--virtual",
        "--run",
        "part.ngc",
        "--from",
        "4/4",
        "--yes",
        "printer.ini",
    ]);
    assert_eq!(refused.status, Some(1));
    assert!(refused.stderr.contains("reaches this line 3 times only"), "{}", refused.stderr);
}

#[test]
fn a_job_that_broke_off_is_resumed_when_a_person_agrees() {
    let program = "G21 G90 G61\nG0 X5 Y5\nG1 X15 F600\nM3 S100\nG1 Y15\nG1 X5\nG0 X0 Y0\nM2\n";
    // The spindle never reaches its speed, so that the job breaks off.
    let scratch = printer(program);
    scratch.write("custom.hal", "setp spindle.0.at-speed FALSE\n");
    let cut = scratch.halrun(&["--virtual", "--run", "part.ngc", "printer.ini"]);
    assert!(cut.stderr.contains("part.ngc: failed after "), "{}", cut.stderr);
    scratch.write("custom.hal", "");
    let asked = scratch.halrun(&["--virtual", "--resume", "--record", "out.vcd", "printer.ini"]);
    assert_eq!(asked.status, Some(1));
    for part in ["note the job broke off at line ", "not-ready ", "nobody can agree: --yes"] {
        assert!(asked.stderr.contains(part), "no {part:?} in\n{}", asked.stderr);
    }
    let still = Vcd::parse(&scratch.read("out.vcd"));
    assert!(still.rises("stepgen.0.step").is_empty(), "it moved without an agreement");
    let resumed = scratch.halrun(&["--virtual", "--resume", "--yes", "printer.ini"]);
    assert_eq!(resumed.status, Some(0), "{}", resumed.stderr);
    assert!(resumed.stderr.contains("part.ngc: ended after "), "{}", resumed.stderr);
    let again = scratch.halrun(&["--virtual", "--resume", "--yes", "printer.ini"]);
    assert_eq!(again.status, Some(1));
    assert!(again.stderr.contains("there is nothing to resume"), "{}", again.stderr);
}

#[test]
fn what_run_needs_is_said() {
    let scratch = printer("M2\n");
    for (words, wanted) in [
        (&["--virtual", "--run", "none.ngc", "printer.ini"][..], "<commandline>:0: task.open: "),
        (&["--run", "part.ngc", "custom.hal"], "it needs a machine from an INI file"),
        (&["--virtual", "--from", "3", "printer.ini"], "it belongs to --run FILE"),
        (&["--run", "part.ngc", "--from", "x", "printer.ini"], "such as 120 or 120/2"),
        (&["--run", "part.ngc", "--detach", "printer.ini"], "it excludes --detach and --hold"),
    ] {
        let output = scratch.halrun(words);
        assert_eq!(output.status, Some(1), "{words:?}");
        assert!(output.stderr.contains(wanted), "{words:?}: {}", output.stderr);
    }
}

#[test]
fn the_task_switches_the_machine_on_and_runs_lines() {
    let scratch = printer("M2\n");
    scratch.write(
        "custom_postgui.hal",
        "task.mdi text='G0 X1' --wait\ntask.estop-reset --wait\ntask.on --wait\ntask.run --wait\n\
         task.home joint=all --wait\ntask.mode mode=mdi --wait\ntask.mdi text='G21 G0 X1 Y2' --wait\n\
         task.mdi text='G10 L20 P1 X0' --wait\ntask.mdi text='G0 X3' --wait\n\
         getp joint.0.motor-pos-cmd\ntask.mdi text='G0 Y' --wait\ntask.status\n\
         task.estop --wait\ngetp motion.motion-enabled\nshutdown\n",
    );
    let output = scratch.halrun(&["-k", "--virtual", "printer.ini"]);
    for wanted in [
        "MDI is not possible in e-stop",
        "a program needs mode auto, the mode is manual: task.mode mode=auto; a program needs homed joints",
    ] {
        assert!(output.stderr.contains(wanted), "no {wanted:?} in\n{}", output.stderr);
    }
    let lines: Vec<&str> = output.stdout.lines().collect();
    assert_eq!(lines[0], "4", "X3 in a system whose zero is at 1\n{}", output.stderr);
    assert!(lines[1].starts_with("task state=on mode=mdi interpreter="), "{lines:?}");
    assert_eq!(lines.last(), Some(&"FALSE"), "off in e-stop");
    assert!(scratch.read("linuxcnc.var").contains("5221\t1.000000"), "the offset is on disk");
}
