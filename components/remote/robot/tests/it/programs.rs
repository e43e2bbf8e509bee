//! The programs over a socket of this machine.
#![expect(clippy::unwrap_used, reason = "tests")]

use crate::sim;

use sim::Sim;
use std::{
    io::{Read as _, Write as _},
    net::TcpStream,
    process::{Command, Output, Stdio},
};

/// 20 simulated seconds in a second.
const FAST: &[&str] = &["--fast", "20"];

fn halrobot(words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_halrobot"));
    command.args(words).stdin(Stdio::null()).output().unwrap()
}

fn scratch(name: &str, text: &str) -> String {
    let path = std::env::temp_dir().join(format!("halrobot-{name}-{}.nc", std::process::id()));
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn each_program_states_its_version() {
    for program in [env!("CARGO_BIN_EXE_halrobot"), env!("CARGO_BIN_EXE_halrobotsim")] {
        let output = Command::new(program).arg("--version").output().unwrap();
        let name = std::path::Path::new(program).file_name().unwrap().to_string_lossy();
        let want = format!("{name} {}\n", env!("CARGO_PKG_VERSION"));
        assert_eq!(String::from_utf8_lossy(&output.stdout), want);
    }
}

#[test]
fn a_program_runs_with_faults() {
    let mut sim = Sim::new(&[FAST, &["--lost", "0.02", "--doubled", "0.1"]].concat());
    let file = scratch("run", "G0 Z10\nX5 Y5\nG1 Z0 F300\nG2 X15 Y5 R5\nG0 Z10\n");
    let output = halrobot(&[&file, "--to", &sim.address, "--timeout", "0.3"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        text.starts_with("part zero -400.000 0.000 -30.000\n0\tX5 Y5\tJMOVE,5.000,5.000,10.000\n"),
        "{text}"
    );
    assert!(text.ends_with("184 lines executed\n"), "{text}");
    assert!(sim.line().ends_with(": ended, 183 moves"), "182 moves in two axes and one in Z");
    std::fs::remove_file(file).unwrap();
}

#[test]
fn what_leaves_the_volume_is_refused_and_nothing_moves() {
    let mut sim = Sim::new(FAST);
    let file = scratch("far", "G0 X1\nG0 X400\n");
    let output = halrobot(&[&file, "--to", &sim.address]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success());
    assert!(
        text.contains(
            "line 2: X400.000 Y0.000 Z10.000 is outside the work volume: robot Y 400.000 > 250"
        ),
        "{text}"
    );
    assert!(sim.line().ends_with(": ended, 0 moves"));
    std::fs::remove_file(file).unwrap();
    let output = halrobot(&["nowhere.nc", "--to", "127.0.0.1:1"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("127.0.0.1:1: Connection refused"));
}

#[test]
fn a_second_client_is_told_that_the_robot_is_busy() {
    let sim = Sim::new(FAST);
    let mut first = TcpStream::connect(&sim.address).unwrap();
    let mut greeting = [0; 10];
    first.read_exact(&mut greeting).unwrap();
    let mut second = TcpStream::connect(&sim.address).unwrap();
    let mut text = String::new();
    second.read_to_string(&mut text).unwrap();
    assert_eq!(text, "error busy\r\n");
    first.write_all(b"EXIT\r\n").unwrap();
}
