//! The program halgcode: what its commands print, and what its texts mean.
#![expect(clippy::unwrap_used, reason = "tests")]
#![expect(clippy::print_stderr, reason = "the report of a comparison")]

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/gcode")
}

fn halgcode(at: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halgcode"));
    command.args(words).current_dir(at).stdin(Stdio::null()).output().unwrap()
}

fn scratch(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("halgcode-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&path).unwrap();
    path
}

#[test]
fn commands_print_what_they_should() {
    // The parameter file of the machine is written by `canon`: work on a copy.
    let at = scratch("commands");
    let copied = Command::new("cp").arg("-r").arg(folder().join(".")).arg(&at).status().unwrap();
    assert!(copied.success());
    let commands = std::fs::read_to_string(folder().join("commands")).unwrap();
    let mut text = String::new();
    for line in commands.lines() {
        let words: Vec<&str> = line.split_whitespace().skip(1).collect();
        let output = halgcode(&at, &words);
        writeln!(text, "$ {line}").unwrap();
        text.push_str(&String::from_utf8_lossy(&output.stdout));
        for error in String::from_utf8_lossy(&output.stderr).lines() {
            writeln!(text, "! {error}").unwrap();
        }
        writeln!(text, "= {}\n", output.status.code().unwrap()).unwrap();
    }
    std::fs::remove_dir_all(&at).unwrap();
    let path = folder().join("expected");
    hal_golden::check(&path, &text);
}

#[test]
fn an_error_takes_lines_of_mdi_and_asks() {
    use std::io::Write as _;
    let at = scratch("ask");
    std::fs::write(
        at.join("ask.ngc"),
        "g0 x1\ng1 x2\ng0 x3\no1 sub\ng1 x4\ng0 x5\no1 endsub\no1 call\nm2\n",
    )
    .unwrap();
    let run = |mdi: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halgcode"));
        command.args(["canon", "-g", "-n", "1", "ask.ngc"]).current_dir(&at);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(mdi.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let calls = text.lines().filter(|l| l.contains("STRAIGHT")).map(|l| l[13..].to_owned());
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        (calls.collect::<Vec<_>>(), errors, output.status.code())
    };
    // Without an answer the program ends, as it does in rs274.
    let (calls, errors, status) = run("g0 x9\nfoo\n");
    assert_eq!(calls.len(), 2, "{calls:?}");
    assert!(calls[1].starts_with("STRAIGHT_TRAVERSE(9.0000"), "{calls:?}");
    assert!(
        errors.starts_with("executing\nCannot do g1 with zero feed rate\ng1 x2\nstarting MDI\n")
    );
    assert!(errors.ends_with("\nfoo\ncontinue program? y/n =>"), "{errors}");
    assert_eq!(status, Some(1));
    std::fs::remove_dir_all(&at).unwrap();
}

/// In a terminal, lines of MDI end with Ctrl-D, and the answer `y` lets the program go on behind its error.
#[test]
fn the_answer_y_goes_on_behind_the_error() {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let at = scratch("yes");
    std::fs::write(at.join("ask.ngc"), "g0 x1\ng1 x2\ng0 x3\nm2\n").unwrap();
    let run = |typed: &[u8]| {
        let keys = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&keys).unwrap();
        unlockpt(&keys).unwrap();
        let name = ptsname(&keys, Vec::new()).unwrap().into_string().unwrap();
        let end = std::fs::File::options().read(true).write(true).open(name).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_halgcode"));
        command.args(["canon", "-g", "-n", "1", "ask.ngc"]).current_dir(&at);
        command.stdin(end).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        assert_eq!(rustix::io::write(&keys, typed).unwrap(), typed.len());
        let output = child.wait_with_output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let moves = text.lines().filter_map(|l| l.split_once("STRAIGHT_TRAVERSE("));
        let moves = moves.map(|(_, rest)| rest.split(',').next().unwrap().to_owned());
        (moves.collect::<Vec<_>>(), output.status.code())
    };
    assert_eq!(
        run(b"g0 x9\n\x04y\n"),
        (vec!["1.0000".into(), "9.0000".into(), "3.0000".into()], Some(0))
    );
    assert_eq!(run(b"g0 x9\n\x04n\n"), (vec!["1.0000".into(), "9.0000".into()], Some(1)));
    std::fs::remove_dir_all(&at).unwrap();
}

/// A program of 24 MB takes less memory than its size, and is refused from the place on at which it was changed.
#[test]
fn a_program_is_read_in_parts_and_refused_once_it_has_changed() {
    use std::io::{BufRead as _, Write as _};
    let at = scratch("parts");
    let path = at.join("large.ngc");
    let lines = 6000;
    let mut text = String::new();
    for k in 0..lines {
        writeln!(text, "{:4000}g0 x{}", "", k % 7).unwrap();
    }
    text.push_str("m2\n");
    std::fs::write(&path, &text).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_halgcode"));
    command.args(["canon", "-g", "large.ngc"]).current_dir(&at).stdin(Stdio::null());
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The program waits once the pipe is full, with most of the file still to be read.
    let mut output = std::io::BufReader::new(child.stdout.take().unwrap()).lines();
    for _ in 0..lines / 2 {
        output.next().unwrap().unwrap();
    }
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
    let peak = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap();
    let peak: usize = peak.trim().trim_end_matches(" kB").parse().unwrap();
    assert!(peak * 1024 < text.len(), "{peak} kB");
    let mut file = std::fs::File::options().append(true).open(&path).unwrap();
    file.write_all(b"g0 x99\n").unwrap();
    let rest = output.map_while(Result::ok).count();
    assert!(rest < lines / 2, "the end of the file was read");
    let done = child.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&done.stderr);
    assert!(errors.contains("large.ngc>: it has changed since it was opened"), "{errors}");
    assert_eq!(done.status.code(), Some(1));
    std::fs::remove_dir_all(&at).unwrap();
}

/// 100 mm at 100 mm/s, a pause of 2 s and 100 mm at 200 mm/s, with 1000 mm/s²: 1.1, 2 and 0.7 s.
#[test]
fn check_tells_the_time_of_the_planner() {
    let at = scratch("time");
    let ini = |x: &str, joint: &str| {
        format!(
            "[TRAJ]\nCOORDINATES = XY\nLINEAR_UNITS = mm\nMAX_LINEAR_VELOCITY = 200\n\
             [KINS]\nKINEMATICS = trivkins\n\
             [AXIS_X]\n{x}\n[AXIS_Y]\nMAX_VELOCITY = 300\nMAX_ACCELERATION = 1000\n[JOINT_0]\n{joint}\n"
        )
    };
    std::fs::write(at.join("time.ngc"), "g21 g90 f6000\ng1 x100\ng4 p2\ng0 x0\nm2\n").unwrap();
    let time = |ini: String, file: &str| {
        std::fs::write(at.join("m.ini"), ini).unwrap();
        let text = halgcode(&at, &["check", "-i", "m.ini", file]).stdout;
        let text = String::from_utf8_lossy(&text).into_owned();
        text.lines().find_map(|l| l.strip_prefix("  time on the machine ")).map(str::to_owned)
    };
    let fast = "MAX_VELOCITY = 300\nMAX_ACCELERATION = 4000";
    let slow = "MAX_VELOCITY = 300\nMAX_ACCELERATION = 1000";
    let rest = "s, without tool changes and waits";
    assert_eq!(time(ini(fast, slow), "time.ngc"), Some(format!("3.8 {rest}")));
    // The joint is slower than its axis; without an acceleration there is no time.
    assert_eq!(time(ini(fast, fast), "time.ngc"), Some(format!("3.6 {rest}")));
    assert_eq!(time(ini("MAX_VELOCITY = 300", "MIN_LIMIT = 0"), "time.ngc"), None);
    // Two half circles of 157.08 mm in inches at 100 mm/s, one of them clockwise, each from rest to rest: 1.67 s, and a
    // little for the acceleration that the curvature needs; the second leaves the stop at once.
    let arcs = "g20 g90 f236.2204724\ng61.1\ng3 x3.937007874 i1.968503937\ng2 x7.874015748 i1.968503937\nm2\n";
    std::fs::write(at.join("arcs.ngc"), arcs).unwrap();
    assert_eq!(time(ini(slow, slow), "arcs.ngc"), Some(format!("3.3 {rest}")));
    std::fs::remove_dir_all(&at).unwrap();
}

/// Returns the programs of the interpreter's tests.
fn corpus() -> Vec<PathBuf> {
    let folder = folder().join("../../../components/motion/gcode/tests/programs");
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    assert!(paths.len() > 400);
    paths
}

/// Returns the calls of a program without the line numbers of its text.
fn calls(at: &Path, file: &Path) -> (Vec<String>, String) {
    let output = halgcode(at, &["canon", "-g", file.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let error = String::from_utf8_lossy(&output.stderr).lines().nth(1).unwrap_or_default().into();
    (text.lines().map(str::to_owned).collect(), error)
}

#[test]
fn a_formatted_program_makes_the_same_calls() {
    let at = scratch("format");
    let programs = corpus();
    for path in &programs {
        std::fs::copy(path, at.join(path.file_name().unwrap())).unwrap();
    }
    let mut compared = 0;
    for path in programs.iter().step_by(2) {
        let (before, error) = calls(&at, path);
        let output = at.join("formatted.ngc");
        let formatted =
            halgcode(&at, &["format", "-o", output.to_str().unwrap(), path.to_str().unwrap()]);
        assert!(matches!(formatted.status.code(), Some(0 | 1)), "{}", path.display());
        let (after, error_after) = calls(&at, &output);
        // Names of files are in messages about files only.
        assert_eq!((after, error_after), (before, error), "{}", path.display());
        compared += 1;
    }
    std::fs::remove_dir_all(&at).unwrap();
    assert!(compared > 200);
}

#[test]
fn an_endless_program_is_refused() {
    let at = scratch("endless");
    let refused = halgcode(&at, &["format", "/dev/zero"]);
    let error = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!((refused.status.code(), refused.stdout.len()), (Some(2), 0), "{error}");
    assert!(error.contains("/dev/zero: it is a device, not a file"), "{error}");
    std::fs::remove_dir_all(&at).unwrap();
}

#[test]
fn a_program_in_millimetres_moves_to_the_same_places() {
    let at = scratch("metric");
    let machine = |file: &str| {
        let output = halgcode(&at, &["check", file]);
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let mut compared = 0;
    for path in corpus() {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        // Tool tables and parameters of the machine keep their unit; this machine has none. Radii that differ by the very
        // tolerance of inches differ by more than that of millimetres.
        let skipped =
            ["lib-", "remap-", "lang-", "m70", "m72", "m73", "mixed3", "mixed6-p", "arc-radii-"];
        let begins = text.lines().next().unwrap_or_default().to_lowercase().contains("g20");
        if !begins || skipped.iter().any(|s| name.starts_with(s)) {
            continue;
        }
        let metric = at.join("metric.ngc");
        let done = halgcode(
            &at,
            &["format", "--mm", "-o", metric.to_str().unwrap(), path.to_str().unwrap()],
        );
        if done.status.code() != Some(0) {
            continue;
        }
        let (before, after) = (machine(path.to_str().unwrap()), machine("metric.ngc"));
        let lines = |text: &str| -> Vec<String> {
            let wanted = |l: &&str| l.starts_with("  moves") || l.starts_with("  cuts");
            text.lines().filter(wanted).map(str::to_owned).collect()
        };
        assert_eq!(lines(&after), lines(&before), "{name}");
        compared += 1;
    }
    std::fs::remove_dir_all(&at).unwrap();
    eprintln!("{compared} programs");
    assert!(compared >= 5, "only {compared} programs");
}

/// The pictures of a simulation are what they were; `UPDATE_EXPECT=1` draws them again.
#[test]
fn simulations_are_drawn_as_before() {
    let configs = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../configs/maxnc");
    let pictures = folder().join("pictures");
    let at = scratch("simulation");
    let coarse = |view: &'static str| vec!["-r", "20", "-w", view];
    let mut cases: Vec<(PathBuf, Vec<&str>, &str)> = ["perspective", "front", "side", "top"]
        .map(|view| (pictures.join(format!("ticks-{view}.svg")), coarse(view), "scissors-b"))
        .to_vec();
    cases.push((pictures.join("ticks-turned.svg"), vec!["-r", "20", "-a", "-60,10"], "scissors-b"));
    cases.push((configs.join("scissors-a.svg"), vec!["-r", "100"], "scissors-a"));
    cases.push((
        configs.join("scissors-b.svg"),
        vec!["-r", "100", "-w", "top"],
        "scissors-b-plunged",
    ));
    for (path, mut words, part) in cases {
        let program = configs.join(format!("{part}.nc"));
        let ini = configs.join("maxnc.ini");
        let size = if path.starts_with(&configs) { "1000x520" } else { "720x400" };
        words.extend(["-S", size, "-o", "new.svg", "-i", ini.to_str().unwrap()]);
        words.push(program.to_str().unwrap());
        words.insert(0, "ticks");
        let output = halgcode(&at, &words);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let new = std::fs::read_to_string(at.join("new.svg")).unwrap();
        hal_golden::check(&path, &new);
        // A line for each of the axes that are seen, and for each command that moves.
        assert!(new.matches("<polyline").count() > 20, "{part}");
    }
    std::fs::remove_dir_all(&at).unwrap();
}

#[test]
fn pictures_are_drawn() {
    let at = scratch("plot");
    let pictures = folder().join("pictures");
    let ini = pictures.join("mill.ini");
    let ini = ini.to_str().unwrap();
    for name in ["pocket", "engraving", "spiral", "lathe", "five", "pedal"] {
        let program = pictures.join(format!("{name}.ngc"));
        let program = program.to_str().unwrap();
        let checked = halgcode(&at, &["check", "-i", ini, program]);
        assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
        for ending in ["svg", "png"] {
            let picture = format!("{name}.{ending}");
            let output = halgcode(&at, &["plot", "-i", ini, "-o", &picture, program]);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let bytes = std::fs::read(at.join(&picture)).unwrap();
            assert!(bytes.len() > 10_000, "{picture}");
        }
        // Feed, rapid moves and limits are there.
        let svg = std::fs::read_to_string(at.join(format!("{name}.svg"))).unwrap();
        for colour in ["#0072B2", "#D55E00", "#A01E3C"] {
            let lines = svg.lines().filter(|l| l.contains("polyline") && l.contains(colour));
            assert!(lines.count() > 4, "{name}: {colour}");
        }
    }
    std::fs::remove_dir_all(&at).unwrap();
}
