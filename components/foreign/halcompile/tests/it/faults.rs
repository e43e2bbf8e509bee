//! Tests of the faults reported for wrong files: message, line, column, mark. `UPDATE_EXPECT=1` rewrites `faults.txt`.

use std::{fs, path::Path};

/// Returns the report for this text, read as `x.comp`.
fn said(text: &str) -> String {
    match halcompile::read("x.comp", text.as_bytes()) {
        Ok((_, doubts)) => format!("accepted\n{doubts}"),
        Err(report) => report.to_string(),
    }
}

#[test]
fn every_fault_is_named_with_its_place() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults.txt");
    let whole = fs::read_to_string(&path).unwrap();
    let mut new = String::new();
    let mut cases = 0;
    for case in whole.split("=== ").skip(1) {
        let (title, rest) = case.split_once('\n').unwrap();
        let (text, _) = rest.split_once("--->\n").unwrap();
        let said = said(&text.replace('␍', "\r"));
        new.push_str(&format!("=== {title}\n{text}--->\n{said}<---\n"));
        cases += 1;
    }
    assert!(cases >= 40, "{cases}");
    hal_golden::check(&path, &new);
}

#[test]
fn a_byte_that_is_no_text_is_named() {
    let report = halcompile::read("x.comp", b"component x;\npin in bit \xff;\n").unwrap_err();
    assert!(
        report.to_string().starts_with("x.comp:2:12: this byte is no UTF-8 text\n"),
        "{report}"
    );
}

/// Truncates every good file, and changes, removes and inserts bytes: nothing panics, and every accepted file yields C
/// text, a page and Rust.
#[test]
fn damaged_files_never_panic() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/comp");
    let mut state = 0x9e37_79b9_u64;
    let mut random = move |below: usize| {
        // A Lehmer generator: any spread is sufficient.
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).unwrap() % below.max(1)
    };
    let pieces: [&[u8]; 16] = [
        b"\"",
        b"\"\"\"",
        b";",
        b"[",
        b"(",
        b":",
        b"/*",
        b"//",
        b"\n;;\n",
        b"#",
        b"\\",
        b"if ",
        b"=",
        b"\xc3",
        b"personality",
        b"99999999999999999999",
    ];
    let mut accepted = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "comp") {
            continue;
        }
        let good = fs::read(&path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let mut read = |bytes: &[u8]| match halcompile::read(&name, bytes) {
            Ok((component, _)) => {
                let wanted = halcompile::c::Wanted { source: &name, out: "x.c", personalities: 64 };
                assert!(!halcompile::c::text(&component, &wanted).is_empty());
                assert!(!halcompile::document::roff(&component).is_empty());
                assert!(!halcompile::document::adoc(&component).is_empty());
                assert!(!halcompile::rust::text(&component).is_empty());
                accepted += 1;
            }
            Err(report) => assert!(!report.to_string().is_empty()),
        };
        read(&good);
        for cut in 0..good.len() {
            read(good.get(..cut).unwrap());
        }
        for _ in 0..200 {
            let mut bytes = good.clone();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                match random(3) {
                    0 => bytes[at] = u8::try_from(random(256)).unwrap(),
                    1 => drop(bytes.drain(at..(at + random(8)).min(bytes.len()))),
                    _ => drop(bytes.splice(at..at, pieces[random(pieces.len())].iter().copied())),
                }
            }
            read(&bytes);
        }
    }
    assert!(accepted > 1_000, "{accepted} of the damaged files are good: is anything read at all?");
}
