//! First steps of a newcomer: versions, options after files, unknown names and formats, help of a component's command.

use hal_tests::{
    programs::root,
    scratch::{Scratch, until},
};
use std::time::{Duration, Instant};

const MACHINE: &str = "loadrt threads name1=t period1=1000000\nloadrt and2\nnewsig a bit\nnet b and2.0.out\n\
                       addf and2.0 t\nstart\n";

const PROGRAMS: [&str; 15] = [
    "halrun",
    "halcmd",
    "halscope",
    "haltest",
    "halsetup",
    "halgcode",
    "halsampler",
    "halstreamer",
    "hal_manualtoolchange",
    "haltcl",
    "halshow",
    "linuxcnc",
    "halcompile",
    "latency-test",
    "ferrule",
];

fn machine() -> Scratch {
    let scratch = Scratch::new("first-use");
    scratch.write("m.hal", MACHINE);
    scratch
}

/// Runs a program; returns its output, its errors and its status.
fn run(scratch: &Scratch, words: &[&str]) -> (String, String, Option<i32>) {
    let [program, words @ ..] = words else { return (String::new(), String::new(), None) };
    let output = scratch.run(scratch.command(&[], program).args(words));
    (output.stdout, output.stderr, output.status)
}

#[test]
fn every_program_prints_its_version() {
    let scratch = machine();
    for program in PROGRAMS {
        let want = format!("{program} {}\n", env!("CARGO_PKG_VERSION"));
        assert_eq!(run(&scratch, &[program, "--version"]), (want, String::new(), Some(0)));
    }
}

#[test]
fn every_program_prints_its_help_without_a_screen() {
    let scratch = machine();
    for program in PROGRAMS {
        let mut command = scratch.command(&[], program);
        let output = scratch.run(command.arg("--help").env_remove("DISPLAY"));
        assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)), "{program}");
        let words = output.stdout.to_ascii_lowercase();
        assert!(words.contains("usage:") && words.contains(program), "{program}:\n{words}");
    }
    let output = scratch.run(scratch.command(&[], "halshow").env_remove("DISPLAY"));
    let want = "halshow: DISPLAY is not set: it needs a screen; in a terminal, 'halcmd show' and 'halcmd watch' show the same\n";
    assert_eq!((output.stderr.as_str(), output.status), (want, Some(1)));
}

#[test]
fn a_picture_has_a_known_format_and_something_in_it() {
    let scratch = machine();
    scratch.write("x.csv", "time,b\n0,0\n0.001,1\n");
    for (words, error) in [
        (&["halscope", "plot", "x.csv", "-o", "x.svg"][..], ""),
        (&["halscope", "plot", "x.csv", "b", "--size", "400x300", "-o", "y.svg"], ""),
        (
            &["halscope", "plot", "x.csv", "-o", "x.pdf"],
            "halscope: x.pdf: a picture ends in .svg or .png\n",
        ),
        (&["halcmd", "graph", "m.hal", "-o", "m.svg"], ""),
        (
            &["halcmd", "graph", "m.hal", "-o", "m.pdf"],
            "<commandline>:0: graph: -o 'm.pdf': a picture ends in .svg, .dot, .gv, .mmd or .mermaid\n",
        ),
        (
            &["halcmd", "graph", "m.hal", "-o", "n.svg", "xyz*"],
            "<commandline>:0: graph: the pattern 'xyz*': no pin, signal or component has such a name\n",
        ),
        (
            &["halcmd", "graph", "m.hal", "-o", "n.svg", "and2.0.in0"],
            "<commandline>:0: graph: the pattern 'and2.0.in0': its pins have no signals; --all draws them\n",
        ),
        (&["halcmd", "graph", "m.hal", "-o", "i.svg", "--all", "and2.0.in0"], ""),
    ] {
        let (_, stderr, status) = run(&scratch, words);
        assert_eq!(
            (stderr.as_str(), status),
            (error, Some(i32::from(!error.is_empty()))),
            "{words:?}"
        );
    }
    let pictures: Vec<String> = scratch.files().into_keys().filter(|f| f.ends_with("g")).collect();
    assert_eq!(pictures, ["i.svg", "m.svg", "x.svg", "y.svg"]);
}

#[test]
fn verbose_says_which_value_was_set() {
    let scratch = machine();
    let lines = "setp and2.0.in0 1\nsets a 1\nand2.0.in1 = TRUE\nhelp and2.nothing\n";
    scratch.write("v.hal", format!("{MACHINE}{lines}"));
    let (stdout, stderr, status) = run(&scratch, &["halrun", "--virtual", "-v", "-f", "v.hal"]);
    let said: Vec<&str> = stderr.lines().filter(|l| l.contains("set to")).collect();
    let want = [
        "v.hal:7: Pin 'and2.0.in0' set to 1",
        "v.hal:8: Signal 'a' set to 1",
        "v.hal:9: Pin 'and2.0.in1' set to TRUE",
    ];
    assert_eq!((said.as_slice(), status), (&want[..], Some(0)), "{stderr}");
    assert!(stdout.contains("No help for unknown command 'and2.nothing'"), "{stdout}");
}

/// Scripts of users of LinuxCNC search the output of `status` for `lock`.
#[test]
fn status_says_lock_only_in_the_lines_of_locks() {
    let scratch = machine();
    scratch.write("s.hal", format!("{MACHINE}status\n"));
    for clock in ["--virtual", "--simulate"] {
        let (stdout, stderr, _) = run(&scratch, &["halrun", clock, "-f", "s.hal"]);
        let found: Vec<&str> =
            stdout.lines().filter(|l| l.to_lowercase().contains("lock")).collect();
        let want = [
            "HAL locking status:",
            "  current lock value 0 (00)",
            "  HAL_LOCK_NONE - nothing is locked",
        ];
        assert_eq!(found, want, "{clock}: {stderr}");
        assert!(stdout.contains("HAL instance status"), "{clock}: {stdout}");
    }
}

#[test]
fn help_explains_a_command_of_a_component() {
    let scratch = Scratch::new("first-help");
    scratch.write("m.hal", "loadrt iocontrol\nhelp iocontrol.estop\n");
    let (stdout, stderr, status) = run(&scratch, &["halrun", "--virtual", "-f", "m.hal"]);
    assert_eq!((stderr.as_str(), status), ("", Some(0)));
    assert!(stdout.starts_with("Commands:\niocontrol.estop"), "{stdout}");
    let output = scratch.halcmd(&["help", "iocontrol.estop"]);
    let want = "No help for unknown command 'iocontrol.estop'; commands of a component are known while it is loaded";
    assert!((output.stdout.clone() + &output.stderr).contains(want), "{output:?}");
    let output = scratch.halcmd(&["help", "nonsense"]);
    assert!(!(output.stdout.clone() + &output.stderr).contains("component"), "{output:?}");
}

#[test]
fn a_paced_clock_is_no_faster_than_it_should_be() {
    let scratch = machine();
    for (words, error) in [
        (&["--pace", "1", "m.hal"][..], "it is for --virtual"),
        (&["--virtual", "--pace", "0", "m.hal"], "it is a number from 0.001 to 1000, such as 1"),
        (&["--virtual", "m.hal", "--pace", "x"], "it is a number from 0.001 to 1000, such as 1"),
        (&["--virtual", "--hold", "--pace", "1"], "with --hold the clock moves only in 'run TIME'"),
    ] {
        let output = scratch.halrun(words);
        assert!(output.stderr.contains(error) && output.status == Some(1), "{}", output.stderr);
    }
    #[expect(clippy::disallowed_methods, reason = "a paced clock follows the wall's")]
    let began = Instant::now();
    let words = ["--virtual", "--pace", "10", "--for", "1s", "--record", "out.vcd", "m.hal"];
    let output = scratch.halrun(&words);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    assert!(began.elapsed() >= Duration::from_millis(100));
    // The pace changes nothing else.
    let paced = scratch.read("out.vcd");
    let output = scratch.halrun(&["--virtual", "--for", "1s", "--record", "out.vcd", "m.hal"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    assert_eq!(scratch.read("out.vcd"), paced);
}

#[test]
fn a_command_that_the_machine_refuses_at_once_fails() {
    let scratch = Scratch::new("first-refusal");
    let machine = "loadrt trivkins coordinates=X\nloadrt motmod num_joints=1\naddf motion-command-handler servo-thread\n\
                   addf motion-controller servo-thread\nstart\n";
    scratch.write("m.hal", machine);
    let mut command = scratch.command(&[], "halrun");
    let running = scratch.start(command.args(["--virtual", "m.hal"]));
    until("the machine runs", || {
        scratch.halcmd(&["getp", "motion.motion-enabled"]).status == Some(0)
    });
    let output = scratch.halcmd(&["motion.jog", "joint=0", "velocity=5"]);
    let refusal = "<commandline>:0: motion.jog: cannot jog: the machine is not enabled";
    assert!(output.stderr.lines().any(|l| l == refusal), "{}", output.stderr);
    assert_eq!(output.status, Some(1));
    // What takes time is not waited for.
    let output = scratch.halcmd(&["motion.configure", "joint=0", "max-velocity=5"]);
    assert_eq!((output.stderr.as_str(), output.status), ("", Some(0)));
    assert_eq!(scratch.halrun(&["-U"]).status, Some(0));
    drop(running.wait());
}

/// Lines in the second terminal of "Coming from LinuxCNC", from e-stop to a jog.
#[test]
fn the_first_minute_of_a_user_of_linuxcnc() {
    let page = std::fs::read_to_string(root().join("halcmd/LINUXCNC.md")).unwrap();
    let (_, typed) = page.split_once("```sh\n").unwrap();
    let (typed, _) = typed.split_once("```").unwrap();
    let lines: Vec<&str> = typed.lines().map(|l| l.strip_prefix("halcmd ").unwrap()).collect();
    assert!(lines.len() >= 6, "{lines:?}");
    let scratch = Scratch::copy_of(&root().join("configs/laser"));
    scratch.write("demo.hal", lines.join("\n") + "\nshutdown\n");
    let (out, err, status) = run(&scratch, &["halrun", "--virtual", "demo.ini"]);
    let at: f64 = out.trim().parse().unwrap_or_else(|_| panic!("{out}{err}"));
    assert!((at - 5.0).abs() < 0.001 && status == Some(0), "{at}: {err}");
}
