//! Machines in which something moves that nothing stops: programs that would command them do not start.

use hal_tests::{plugins::plugins, scratch::Scratch, scratch::until};

/// The command that begins a motion, and what is missing to end it.
const MOVERS: [(&str, &str); 2] = [
    ("motion.jog", "motion.disable, motion.abort, motion.pause"),
    ("robot.run", "robot.stop, robot.pause"),
];
/// Programs that command machines elsewhere than here.
const PROGRAMS: [(&str, &[&str]); 2] =
    [("halpanel", &["--listen", "127.0.0.1:0"]), ("linuxcncrsh", &["--port", "0"])];

#[test]
fn no_program_commands_a_machine_that_nothing_stops() {
    for (begins, missing) in MOVERS {
        let scratch = Scratch::new("unstoppable");
        let lines = "loadrt threads name1=t period1=1000000\nloadrt mover begins=";
        scratch.write("m.hal", format!("{lines}{begins}\nstart\nprint ready\n"));
        let mut halrun = scratch.command(&[], "halrun");
        halrun.env("HAL_RTMOD_DIR", plugins());
        let running = scratch.start(halrun.args(["--simulate", "m.hal"]));
        until("it runs", || running.said().1.contains("ready"));
        for (program, args) in PROGRAMS {
            let output = scratch.run(scratch.command(&[], program).args(args));
            let why =
                format!("{begins} moves this machine, and nothing stops it: no command {missing}");
            assert!(output.stderr.contains(&why), "{program}: {output:?}");
            assert_eq!(output.status, Some(1), "{program}: {output:?}");
        }
        assert_eq!(scratch.halrun(&["-U"]).status, Some(0));
        assert_eq!(running.wait().status, Some(0));
    }
}
