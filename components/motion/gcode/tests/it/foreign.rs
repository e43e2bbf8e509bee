//! Programs of other controls: what is said of each, and that LinuxCNC's own are never taken for one.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

use hal_gcode::{
    Text,
    foreign::{self, Control, Findings, MAX_LINES, table::ROWS},
    tool::ToolTable,
};

use crate::support::{World, folder};

fn survey(bytes: Vec<u8>) -> Option<Findings> {
    let text: Text = Arc::new(bytes);
    let nothing = World { tools: ToolTable::default(), files: BTreeMap::new() };
    foreign::survey(&text, &[], &nothing).unwrap()
}

/// Each program of `tests/foreign`, and what is said of it.
#[test]
fn programs_of_other_controls_are_named() {
    let mut wrong = Vec::new();
    let mut controls = Vec::new();
    for path in files(&folder("foreign"), "nc") {
        let found = survey(std::fs::read(&path).unwrap());
        let mut text = String::new();
        if let Some(found) = found {
            text.push_str(&format!("{}\n", found.sentence()));
            for unread in &found.unread {
                text.push_str(&format!("  {unread}\n"));
            }
            controls.extend(found.controls);
        }
        let name = path.with_extension("expected");
        wrong.extend(hal_golden::compare(&name, &text).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for control in Control::ALL {
        assert!(controls.contains(&control), "no program for {}", control.name());
    }
}

/// Each error of these programs names its code, and what to write instead.
#[test]
fn errors_name_the_code_and_the_control() {
    let mut wrong = Vec::new();
    for path in files(&folder("foreign"), "nc") {
        let mut text = String::new();
        for error in errors(&path) {
            text.push_str(&format!("{error}\n"));
        }
        let name = path.with_extension("errors");
        wrong.extend(hal_golden::compare(&name, &text).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Returns the first errors of a program, which goes on behind each.
fn errors(path: &Path) -> Vec<String> {
    let mut it = crate::support::interpreter();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    it.load(&name, Arc::new(std::fs::read(path).unwrap()));
    let (world, mut out) = (World::new(), Vec::new());
    while out.len() < 30 {
        let (_, error) = crate::support::run_with(&mut it, &world, |_| {});
        let Some(error) = error else { break };
        out.push(error.to_string());
        if matches!(error.problem, hal_gcode::error::Problem::NoProgramEnd) {
            break;
        }
        (it.state.ended, it.state.pending) = (false, None);
    }
    out
}

/// Returns the files of a folder and its folders with this ending, in their order.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut out = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let entry = entry.unwrap();
        let path = entry.path();
        // A link may lead back to a folder above.
        if entry.file_type().unwrap().is_dir()
            && !path.ends_with("target")
            && !path.ends_with(".git")
        {
            out.extend(files(&path, ending));
        } else if path.extension().is_some_and(|e| e == ending) {
            out.push(path);
        }
    }
    out.sort();
    out
}

fn taken_for_another(files: &[PathBuf]) -> Vec<String> {
    let found = files.iter().filter_map(|path| {
        let found = survey(std::fs::read(path).ok()?)?;
        Some(format!("{}: {}", path.display(), found.summary(9)))
    });
    found.collect()
}

#[test]
fn programs_of_this_repository_are_linuxcncs() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let all = files(&root, "ngc");
    assert!(all.len() > 600, "only {} programs", all.len());
    let wrong = taken_for_another(&all);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn programs_of_the_package_linuxcnc_are_linuxcncs() {
    let folders = ["/usr/share/linuxcnc/ncfiles", "/usr/share/doc/linuxcnc/examples"];
    let all: Vec<PathBuf> = folders.iter().flat_map(|f| files(Path::new(f), "ngc")).collect();
    if all.is_empty() {
        eprintln!("skipped: the package linuxcnc-uspace is not installed");
        return;
    }
    let wrong = taken_for_another(&all);
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len(), wrong.join("\n"));
}

/// A sign alone, or signs that this language understands, say nothing.
#[test]
fn one_sign_is_not_enough() {
    for text in [
        "G187 P2\nM2\n",
        "(for Haas)\nG0 X1\nM2\n",
        "O1234\nT0101\nG4 P500\nM2\n",
        "G68 X0 Y0 R45\nM2\n",
        "O1234\nG187 P1\nG154 P1\no1 if [1]\no1 endif\nM2\n",
        "#<a>=1\nG187 P1\nG154 P1\nM2\n",
        "(debug, a)\nG187 P1\nG154 P1\nM2\n",
        "(made for LinuxCNC)\nG187 P1\nG154 P1\nM2\n",
    ] {
        assert_eq!(survey(text.into()), None, "{text}");
    }
    let two = survey("G187 P1\nG154 P1\nM2\n".into()).unwrap();
    assert_eq!(two.controls, [Control::Haas]);
    // What several controls have does not tell them apart.
    let shared = survey("G68 X0 Y0 R45\nG51 X0 Y0 P2\nM2\n".into()).unwrap();
    assert_eq!(shared.control(), "Fanuc, Haas or Mach3");
}

/// A remapped code is one of this machine's, and no sign.
#[test]
fn remapped_codes_are_no_signs() {
    let text: Text = Arc::new(b"M47\nG77 X1\nM10 P1\nM2\n".to_vec());
    let remaps = ["M47 modalgroup=10 ngc=a", "G77 modalgroup=1 ngc=a", "M10 modalgroup=10 ngc=a"];
    let remaps: Vec<_> =
        remaps.iter().map(|r| hal_gcode::remap::Remap::parse(r).unwrap()).collect();
    let world = World::new();
    assert!(foreign::survey(&text, &[], &world).unwrap().is_some());
    assert_eq!(foreign::survey(&text, &remaps, &world), Ok(None));
}

/// The survey of a long file ends at its bound, and keeps no more of it than of a short one.
#[test]
fn a_million_lines_are_bounded() {
    let count = usize::try_from(MAX_LINES).unwrap() + 10;
    let text = b"G1X1E2\n".repeat(count);
    let found = survey([b"M104 S1\n".to_vec(), text, b"M140 S1\n".to_vec()].concat()).unwrap();
    assert_eq!((found.lines, found.is_whole), (MAX_LINES, false));
    let filament = found.unread.iter().find(|u| u.code.to_string() == "G1 E").unwrap();
    assert_eq!(filament.seen.count, u64::from(MAX_LINES) - 1);
    assert_eq!(filament.seen.lines, [2, 3, 4, 5]);
    assert!(found.unread.iter().all(|u| u.code.to_string() != "M140"));
    // Different codes are counted up to a bound.
    let codes = (200..2000).map(|n| format!("M{n}\n")).collect::<String>();
    let found = survey(format!("M104 S1\nM140 S1\n{codes}M2\n").into()).unwrap();
    assert!(found.unread.len() <= 256 + ROWS.len());
}

/// Each row can be told: it has controls, a meaning and a remedy, and its code is written as this table writes them.
#[test]
fn the_rows_are_complete() {
    use foreign::row::{Sign, Weight};
    for row in ROWS {
        assert!(!row.of.is_empty(), "{row:?}");
        if row.weight != Weight::Name {
            assert!(!row.means.is_empty() && !row.instead.is_empty(), "{row:?}");
        }
        let text = match row.sign {
            Sign::Begins(text) | Sign::Is(text) | Sign::Has(text) | Sign::Remark(text) => text,
            Sign::Code(b'g' | b'm', _) | Sign::Codes(b'g' | b'm', ..) => "",
            Sign::Code(..) | Sign::Codes(..) => panic!("{row:?}: only G and M are codes"),
            _ => "",
        };
        assert_eq!(text, text.to_lowercase(), "{row:?}");
    }
}
