//! Files, plugins and programs of earlier releases, as `tests/releases/VERSION` has kept them: the present release loads,
//! opens and answers them as that release did. `halcmd/package/VERSIONS.md` is the policy.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_component::abi::{ABI_MAJOR, ABI_MINOR};
use hal_protocol::LATEST;
use hal_tests::{
    golden,
    programs::root,
    scratch::{Scratch, until},
    tools,
};
use serde_json::Value;
use std::{
    fs,
    io::{BufRead, BufReader, Write},
    os::unix::net::UnixStream,
    path::{Path, PathBuf},
    process::Command,
};

/// Returns the folders of the releases.
fn releases() -> Vec<PathBuf> {
    let folders = fs::read_dir(root().join("tests/releases")).unwrap();
    let mut folders: Vec<PathBuf> = folders.map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    let own = env!("CARGO_PKG_VERSION");
    let minor = own.rsplit_once('.').unwrap().0;
    assert!(
        folders.iter().any(|folder| folder.ends_with(minor)),
        "tests/releases has no files of {minor}: the next release will be checked against them"
    );
    folders
}

/// Copies the files of a release, and of one of its folders.
fn copy_of(release: &Path, folder: &str) -> Scratch {
    let scratch = Scratch::copy_of(release);
    fs::create_dir(scratch.path().join(folder)).unwrap();
    for entry in fs::read_dir(release.join(folder)).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{folder}/{}", path.file_name().unwrap().to_str().unwrap());
        scratch.write(&name, fs::read(path).unwrap());
    }
    scratch
}

/// Runs a program in a copy of a release's folder, and returns its standard output. It must succeed and complain of nothing.
fn said(scratch: &Scratch, program: &str, words: &[&str]) -> String {
    let mut command = scratch.command(&[], program);
    let output = scratch.run(command.env("HAL_RTMOD_DIR", scratch.path()).args(words));
    assert_eq!(output.status, Some(0), "{program} {words:?}: {}{}", output.stdout, output.stderr);
    output.stdout
}

/// Compiles a library as a user of that release did.
fn cc(folder: &Path, source: &str, name: &str) {
    let mut cc = Command::new(tools::compiler().unwrap());
    cc.args([
        "-std=gnu11",
        "-Wall",
        "-Werror",
        "-O2",
        "-shared",
        "-fPIC",
        "-DRTAPI",
        "-I",
        "include",
    ]);
    let made = cc.args(["-o", name, source]).current_dir(folder).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
}

/// The numbers of the policy are those of the sources.
#[test]
fn the_policy_states_the_versions_of_the_sources() {
    let policy = fs::read_to_string(root().join("halcmd/package/VERSIONS.md")).unwrap();
    for row in [
        format!("| `ABI_MAJOR.ABI_MINOR`, {ABI_MAJOR}.{ABI_MINOR} |"),
        format!("| `hello.protocol`, {LATEST} |"),
    ] {
        assert!(policy.contains(&row), "halcmd/package/VERSIONS.md lacks: {row}");
    }
    let changes = fs::read_to_string(root().join("halcmd/package/CHANGELOG.md")).unwrap();
    let newest = changes.lines().find(|line| line.starts_with("## ")).unwrap();
    assert!(newest.starts_with(concat!("## ", env!("CARGO_PKG_VERSION"), " (")), "{newest}");
}

#[test]
fn plugins_of_earlier_releases_load_and_run() {
    if tools::compiler().is_none() {
        return;
    }
    for release in releases() {
        let scratch = copy_of(&release, "include");
        cc(scratch.path(), "plugin.c", "librelease0.so");
        cc(scratch.path(), "component.c", "component.so");
        scratch.write(
            "plugins.hal",
            "loadrt threads name1=t period1=1000000\nloadrt release0\nloadrt component text=three\n\
             addf release0 t\naddf component.count t\nsetp release0.in 21\nsetp component.0.enable 1\n\
             start\nrun 10ms\ngetp release0.out\ngetp component.0.count\n",
        );
        let out = said(&scratch, "halrun", &["--virtual", "--hold", "-f", "plugins.hal"]);
        assert_eq!(out, "42\n30\n", "{}", release.display());
    }
}

#[test]
fn recordings_of_earlier_releases_are_read() {
    for release in releases() {
        let scratch = Scratch::copy_of(&release.join("captures"));
        let samples = scratch.read("capture.csv");
        assert!(samples.lines().count() > 10, "{samples}");
        for kind in ["csv", "vcd", "fst", "json"] {
            said(&scratch, "halscope", &["convert", &format!("capture.{kind}"), "again.csv"]);
            assert_eq!(scratch.read("again.csv"), samples, "{}: {kind}", release.display());
        }
    }
}

#[test]
fn files_of_earlier_releases_are_opened() {
    for release in releases() {
        let scratch = copy_of(&release, "tests");
        // A saved state makes the same state, and a test of a machine with its waveform passes.
        fs::create_dir(scratch.path().join("plain")).unwrap();
        let script = format!("{}save all again.hal\n", scratch.read("saved.hal"));
        scratch.write("twice.hal", script);
        said(&scratch, "halrun", &["--virtual", "-f", "twice.hal"]);
        assert_eq!(scratch.read("again.hal"), scratch.read("saved.hal"));
        let passed = said(&scratch, "haltest", &["tests"]);
        assert!(passed.contains("1 test, all passed"), "{passed}");
        // A profile with each key of that release.
        scratch.write("profile.hal", "loadrt threads name1=t period1=1000000\nstart\n");
        said(&scratch, "halrun", &["--profile", "profile.toml", "profile.hal"]);
        assert!(scratch.path().join("profile.vcd").is_file());
        // Answers of a machine give a machine without a finding.
        let setup = fs::read_dir(scratch.path()).unwrap().map(|e| e.unwrap().path());
        let setup =
            setup.into_iter().find(|p| p.extension().is_some_and(|e| e == "setup")).unwrap();
        let setup = setup.file_name().unwrap().to_str().unwrap().to_owned();
        said(&scratch, "halsetup", &["-o", "plain", &setup]);
        let made = fs::read_dir(scratch.path().join("plain")).unwrap().next().unwrap().unwrap();
        let name = made.file_name().into_string().unwrap();
        let ini = format!("plain/{name}/{name}.ini");
        said(&scratch, "halcmd", &["check", "--level", "warning", &ini]);
    }
}

/// A machine with tool table, tool in the spindle, parameters, and the journal of a job that broke off. The journal names its
/// program by the path at which it ran.
#[test]
fn a_job_of_an_earlier_release_resumes_where_it_broke_off() {
    for release in releases() {
        let name = release.file_name().unwrap().to_str().unwrap();
        let folder = PathBuf::from(format!("/tmp/ferrule-release-{name}"));
        drop(fs::remove_dir_all(&folder));
        fs::create_dir(&folder).unwrap();
        for entry in fs::read_dir(release.join("machine")).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
        }
        let scratch = Scratch::new("release");
        let mut command = scratch.command(&[], "halrun");
        command.args(["--virtual", "--resume", "--yes", "machine.ini"]).current_dir(&folder);
        let output = scratch.run(&mut command);
        let table = fs::read_to_string(folder.join("machine.var")).unwrap();
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(output.status, Some(0), "{}", output.stderr);
        golden::check(&release.join("resume.out"), &(output.stdout + &output.stderr));
        let origin = table.lines().find(|line| line.starts_with("5221")).unwrap();
        assert_eq!(origin.split_whitespace().nth(1), Some("5.000000"), "{table}");
    }
}

/// Returns whether `new` has everything that `old` has: objects may have gained fields, nothing else has changed.
fn has(new: &Value, old: &Value) -> bool {
    match (new, old) {
        (Value::Object(new), Value::Object(old)) => {
            old.iter().all(|(key, value)| new.get(key).is_some_and(|new| has(new, value)))
        }
        (Value::Array(new), Value::Array(old)) => {
            new.len() >= old.len() && new.iter().zip(old).all(|(new, old)| has(new, old))
        }
        (new, old) => new == old,
    }
}

#[test]
fn programs_of_earlier_releases_are_answered() {
    let json = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    assert!(has(&json(r#"{"a":[{"b":1,"c":2}],"d":null}"#), &json(r#"{"a":[{"b":1}]}"#)));
    for (new, old) in [(r#"{"a":1}"#, r#"{"a":2}"#), (r#"{"a":1}"#, r#"{"b":1}"#), ("[1]", "[1,2]")]
    {
        assert!(!has(&json(new), &json(old)), "{new} {old}");
    }
    for release in releases() {
        let scratch = Scratch::copy_of(&release);
        let mut command = scratch.command(&[], "halrun");
        let engine = scratch.start(command.args(["--virtual", "--hold", "protocol.hal"]));
        let place = scratch.place("default");
        let mut connection = None;
        until("it listens", || {
            connection = UnixStream::connect(place.socket()).ok();
            connection.is_some()
        });
        let mut socket = connection.unwrap();
        let mut answers = BufReader::new(socket.try_clone().unwrap()).lines();
        let mut last = String::new();
        for line in scratch.read("protocol.txt").lines() {
            if let Some(request) = line.strip_prefix("> ") {
                writeln!(socket, "{{\"request\":{request}}}").unwrap();
                last = answers.next().unwrap().unwrap();
            } else if let Some(reply) = line.strip_prefix("< ") {
                assert!(
                    has(&json(&last), &json(reply)),
                    "{}:\nwas {reply}\nis  {last}",
                    release.display()
                );
            }
        }
        assert_eq!(engine.wait().status, Some(0));
    }
}
