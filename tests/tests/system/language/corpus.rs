//! Every input that the fuzzers kept, run again: none of them breaks anything.
#![expect(clippy::unwrap_used, reason = "tests")]

use flate2::read::GzDecoder;
use hal_tests::{fuzz, programs::root};
use std::{fs::File, io::Read};
use tar::Archive;

/// Runs each input of a target's archive.
fn replay(target: &str, run: impl Fn(&[u8])) {
    let path = root().join("tests/fuzz/corpus").join(format!("{target}.tar.gz"));
    let mut archive = Archive::new(GzDecoder::new(File::open(path).unwrap()));
    let mut count = 0;
    for entry in archive.entries().unwrap() {
        let mut entry = entry.unwrap();
        if !entry.header().entry_type().is_file() {
            continue;
        }
        count += 1;
        let name = entry.path().unwrap().display().to_string();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run(&bytes)));
        assert!(done.is_ok(), "{name} breaks it");
    }
    assert!(count > 20, "only {count} inputs of {target}");
}

#[test]
fn scripts() {
    replay("script", fuzz::script);
}

#[test]
fn ini_files() {
    replay("ini", fuzz::ini);
}

#[test]
fn what_clients_write() {
    replay("protocol", fuzz::protocol);
}

#[test]
fn recordings() {
    replay("trace", fuzz::trace);
}

#[test]
fn lines_of_g_code() {
    replay("gcode-line", fuzz::gcode::lines);
}

#[test]
fn g_code_programs() {
    replay("gcode-program", fuzz::gcode::program);
}
