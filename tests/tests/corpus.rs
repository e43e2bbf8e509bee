//! What the fuzzers have found, once more: nothing of it breaks anything.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_tests::{fuzz, programs::root};

fn replay(target: &str, run: impl Fn(&[u8])) {
    let folder = root().join("tests/fuzz/corpus").join(target);
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > 20, "only {} inputs of {target}", files.len());
    for file in files {
        let bytes = std::fs::read(&file).unwrap();
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| run(&bytes)));
        assert!(done.is_ok(), "{} breaks it", file.display());
    }
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
