//! The program halteleop: what it prints, and its exit status.

use super::{PART, mill::Mill};
use hal_tests::scratch::{Output, Running, until};
use rustix::process::Signal;
use std::{fs, io::Write as _, os::unix::fs::PermissionsExt as _, process::Stdio};

/// Starts halteleop with these arguments.
fn start(mill: &Mill, args: &[&str]) -> Running {
    let mut command = mill.scratch.command(&[], "halteleop");
    command.env("USER", "ana").args(["--to", &format!("127.0.0.1:{}", mill.port)]);
    if !args.contains(&"--secret-file") {
        command.args(["--secret-file", "address"]);
    }
    mill.scratch.start(command.args(args))
}

/// Runs halteleop to its end, while machine time passes.
fn run(mill: &Mill, args: &[&str]) -> Output {
    let mut program = start(mill, args);
    until("halteleop ends", || {
        mill.run("50ms");
        !program.is_running()
    });
    program.wait()
}

/// Checks the status and the beginning of the message.
fn fails(mill: &Mill, args: &[&str], status: i32, message: &str) {
    let output = run(mill, args);
    let said = output.stderr.trim().trim_start_matches("halteleop: ");
    assert!(output.status == Some(status) && said.starts_with(message), "{args:?}: {output:?}");
}

#[test]
fn halteleop_runs_a_part_and_says_why_it_cannot() {
    let mill = Mill::start("ON_LOSS = hold\n", &[]);
    let scratch = &mill.scratch;
    for (name, text) in [
        ("part.ngc", b"G20 G1 X0.5 F600\nM2\n".to_vec()),
        ("slow.ngc", PART.into()),
        ("odd.ngc", b"G20 G1 X1 F6\nG1 X\nM2\n".to_vec()),
        ("far.ngc", b"G20 G0 X9\nM2\n".to_vec()),
        ("empty.ngc", Vec::new()),
        ("latin.ngc", b"G20\n(a\xf1il)\n".to_vec()),
        ("long.ngc", format!("G20\n({})\n", "x".repeat(1023)).into_bytes()),
        ("wrong", b"no token\n".to_vec()),
        ("nothing", b"\n".to_vec()),
    ] {
        scratch.write(name, text);
    }
    fails(&mill, &["run", "part.ngc"], 6, "refused: APAGADO the machine is in e-stop");
    mill.halcmd("task.estop-reset");
    mill.run("100ms");
    mill.halcmd("task.on");
    mill.run("100ms");
    fails(&mill, &["run", "part.ngc"], 6, "refused: SIN_AJUSTE joint 0 is not homed");
    mill.ready();

    let output = run(&mill, &["run", "part.ngc"]);
    assert_eq!((output.status, &*output.stderr), (Some(0), ""), "{output:?}");
    let begin = "logged in as ana\nthe program is there; it is checked, then it runs\n";
    assert!(output.stdout.starts_with(begin) && output.stdout.ends_with("100 %\n"), "{output:?}");
    assert_eq!(mill.number("stepgen.0.counts"), 2000.0);
    assert_eq!(run(&mill, &["progress", "-q"]).stdout, "100 %\n");

    for (args, status, message) in [
        (&["run", "odd.ngc"][..], 5, "refused: SINTAXIS 2 "),
        (&["run", "far.ngc"], 5, "refused: LIMITE 1 X9.0000 is 1.0000 inch beyond [JOINT_0]"),
        (&["run", "empty.ngc"], 5, "refused: VACIO send a program first"),
        (&["run", "gone.ngc"], 1, "gone.ngc: "),
        (&["run", "latin.ngc"], 1, "latin.ngc:2: the line is no UTF-8"),
        (&["run", "long.ngc"], 1, "long.ngc:2: the line has more than 1023 bytes"),
        (&["progress", "--secret-file", "wrong"], 4, "the login is refused: PERMISO the token"),
        (&["progress", "--secret-file", "gone"], 1, "gone: "),
        (&["progress", "--secret-file", "nothing"], 1, "nothing: its first line has no token"),
        (&["progress", "--user", "a b"], 4, "the login is refused: PERMISO INGRESAR USER:SECRET"),
        (&["progress", "--to", "127.0.0.1:1"], 3, "127.0.0.1:1: no connection"),
        (&["progress", "--to", "nowhere"], 3, "nowhere: "),
        (
            &["progress", "--to", "192.0.2.1:2000"],
            1,
            "192.0.2.1:2000: a network address needs --fingerprint",
        ),
        (&["progress", "--fingerprint", "12:34"], 1, "--fingerprint 12:34: must be the 64 digits"),
        (&["sing"], 2, "error: unrecognized subcommand 'sing'"),
    ] {
        fails(&mill, args, status, message);
    }
    // The panel is another program.
    let panel = mill.pair.panel.said().0;
    let at = panel.split("listening at 127.0.0.1:").nth(1).unwrap();
    let other = format!("127.0.0.1:{}", at.split(';').next().unwrap());
    fails(&mill, &["progress", "--to", &other], 3, "'HTTP/1.1 400 Bad Request' is no answer");

    // Ctrl-C cancels; the machine stands when the program ends.
    let mut program = start(&mill, &["run", "slow.ngc"]);
    mill.until("the job runs", || mill.halcmd("getp teleop.running").trim() == "TRUE");
    mill.run("1s");
    program.signal(Signal::INT);
    until("halteleop ends", || {
        mill.run("50ms");
        !program.is_running()
    });
    let output = program.wait();
    assert_eq!(output.status, Some(8), "{output:?}");
    assert_eq!(output.stderr, "halteleop: the job is cancelled\n");
    assert_eq!(mill.halcmd("getp motion.in-position").trim(), "TRUE");

    // An abort at the machine.
    let mut program = start(&mill, &["run", "slow.ngc"]);
    mill.until("the job runs", || mill.halcmd("getp teleop.running").trim() == "TRUE");
    mill.halcmd("task.abort");
    until("halteleop ends", || {
        mill.run("50ms");
        !program.is_running()
    });
    let output = program.wait();
    assert_eq!(output.status, Some(7), "{output:?}");
    assert_eq!(output.stderr, "halteleop: the job has ended: FALLA aborted\n");
}

#[test]
fn a_network_address_needs_tls_accounts_and_the_right_fingerprint() {
    let mut mill = Mill::start("ON_LOSS = hold\n", &[]);
    mill.ready();
    mill.scratch.write("part.ngc", "G20 G0 X1\nM2\n");
    for (account, password) in [("ana=operator", "correct horse"), ("mia=viewer", "only looks on")]
    {
        let mut command = mill.scratch.command(&[], "halpanel");
        let people = mill.scratch.private("people");
        command.args(["--accounts", &people, "--add-account", account]).stdin(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(password.as_bytes()).unwrap();
        assert!(child.wait().unwrap().success());
        let (name, _) = account.split_once('=').unwrap();
        mill.scratch.write(name, password);
    }
    // Without accounts or without a certificate it does not start.
    let mut command = mill.scratch.command(&[], "halpanel");
    command.args(["--ini-file", "teleop.ini", "--listen", "127.0.0.1:0"]);
    let output =
        mill.scratch.run(command.args(["--teleop", "0.0.0.0:0", "--accounts", ".private/people"]));
    let why = "halpanel: 0.0.0.0:0 is a network address: it needs --accounts and --certificate\n";
    assert_eq!((output.status, &*output.stderr), (Some(1), why));

    let (people, pem) = (".private/people", ".private/mill.pem");
    let options = ["--teleop", "0.0.0.0:0", "--accounts", people, "--certificate", pem];
    mill.restart(Signal::TERM, &options);
    let mode = fs::metadata(mill.scratch.path().join(pem)).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);
    let said = mill.pair.panel.said().0;
    let fingerprint = said.split("SHA-256 fingerprint ").nth(1).unwrap().trim();
    let fingerprint = fingerprint.split_whitespace().next().unwrap();
    let other = fingerprint.replace('A', "B").replace("00", "11").replace('1', "2");
    let ana = ["--secret-file", "ana", "--fingerprint", fingerprint, "run", "part.ngc"];
    let output = run(&mill, &ana);
    assert_eq!((output.status, &*output.stderr), (Some(0), ""), "{output:?}");
    assert_eq!(mill.number("stepgen.0.counts"), 4000.0);
    for (args, status, message) in [
        // Plain text, in which a password would be readable.
        (&["--secret-file", "ana", "progress"][..], 3, "the connection is lost"),
        (
            &["--secret-file", "mia", "--fingerprint", fingerprint, "progress"],
            4,
            "the login is refused: PERMISO the user or the password is wrong",
        ),
        (
            &[
                "--user",
                "mia",
                "--secret-file",
                "mia",
                "--fingerprint",
                fingerprint,
                "run",
                "part.ngc",
            ],
            6,
            "refused: PERMISO this needs the role operator",
        ),
        (&["--secret-file", "ana", "--fingerprint", &other, "progress"], 3, ""),
    ] {
        fails(&mill, args, status, message);
    }
    let output = run(&mill, &["--secret-file", "ana", "--fingerprint", &other, "progress"]);
    assert!(output.stderr.contains(&format!("another fingerprint, {fingerprint}")), "{output:?}");
    let audit = mill.scratch.read(&mill.scratch.private("audit"));
    assert!(audit.contains("\"teleop sign-in\"") && audit.contains("\"user\":\"ana\""), "{audit}");
    assert!(!audit.contains("correct horse"), "{audit}");
}
