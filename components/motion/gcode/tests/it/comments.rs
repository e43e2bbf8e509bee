//! The table of active comments, each with all that may stand before and behind it on its line.

use std::{process::Command, sync::Arc};

use hal_gcode::{Call, Interpreter, Numbered, Settings};

use crate::support::{World, run_with, settings};

/// A comment, and the text of its call, or of its error where it begins with `!`.
const COMMENTS: [(&str, &str); 16] = [
    ("MSG, hello", "MESSAGE(\" hello\")"),
    ("MSG,", "MESSAGE(\"\")"),
    ("MSG, a ; b", "MESSAGE(\" a ; b\")"),
    ("DEBUG, v #1", "MESSAGE(\" v 5.000000\")"),
    ("DEBUG,%d#1 #<_none>", "MESSAGE(\"5 ######\")"),
    ("PRINT,v %.1f#1", "v 5.0"),
    ("LOG,v #5600", "LOG(\"v 0.000000\")"),
    ("LOGOPEN,a.txt", "LOGOPEN(\"a.txt\")"),
    ("LOGAPPEND,a.txt", "LOGAPPEND(\"a.txt\")"),
    ("LOGCLOSE", "LOGCLOSE()"),
    ("PROBEOPEN a.txt", "COMMENT(\"probeopen a.txt\")"),
    ("PROBECLOSE", "COMMENT(\"probeclose\")"),
    ("ABORT,v #1", "!v 5.000000"),
    ("PY,raise", "!Python in a comment is not run"),
    ("MSG hello", "COMMENT(\"MSG hello\")"),
    ("a remark", "COMMENT(\"a remark\")"),
];

/// Texts before a comment, and whether it moves.
const BEFORE: [(&str, bool); 11] = [
    ("", false),
    ("  \t", false),
    ("N10 ", false),
    ("/", false),
    ("/ n20.5 ", false),
    ("M5", false),
    ("#2=3 ", false),
    ("G0 X1", true),
    ("(MSG, first)", false),
    ("N1 (a remark) G0 Y1 ", true),
    ("\t(PRINT,first) #3=#1 ", false),
];

/// Texts behind a comment, whether it moves, and the call that replaces that of the comment.
const BEHIND: [(&str, bool, Option<&str>); 11] = [
    ("", false, None),
    (" \t ", false, None),
    (";", false, None),
    (" ; text", false, None),
    ("\t;(MSG, not this)", false, None),
    (";py,raise", false, None),
    (" #4=1;", false, None),
    (" A2", true, None),
    ("F100 Z2 ;text (", true, None),
    ("(last)", false, Some("COMMENT(\"last\")")),
    (" ( Msg, last) ; text", false, Some("MESSAGE(\" last\")")),
];

/// The spellings of a comment: the word that gives it its meaning in any case, and space before it.
fn spellings(comment: &str) -> [String; 4] {
    let end = comment.find([',', ' ']).unwrap_or(comment.len());
    let (word, text) = comment.split_at(end);
    let mixed: String = (0..).zip(word.chars()).map(|(k, c)| mix(k, c)).collect();
    // The case of a remark without a meaning is its text.
    let plain = text.starts_with(' ') && !comment.starts_with("PROBE");
    let lower = if plain { word.to_owned() } else { word.to_lowercase() };
    let mixed = if plain { word.to_owned() } else { mixed };
    [comment.to_owned(), format!("{lower}{text}"), format!(" \t{word}{text}"), mixed + text]
}

fn mix(k: usize, c: char) -> char {
    if k.is_multiple_of(2) { c.to_ascii_lowercase() } else { c }
}

/// A line of the table, and what it has to do.
struct Case {
    line: String,
    is_deletable: bool,
    call: &'static str,
    moves: bool,
}

fn cases() -> Vec<Case> {
    let mut out = Vec::new();
    for (comment, call) in COMMENTS {
        for spelling in spellings(comment) {
            for (before, moves_before) in BEFORE {
                for (behind, moves_behind, last) in BEHIND {
                    out.push(Case {
                        line: format!("{before}({spelling}){behind}"),
                        is_deletable: before.starts_with('/'),
                        call: last.unwrap_or(call),
                        moves: moves_before || moves_behind,
                    });
                }
            }
        }
    }
    out
}

/// Runs lines; returns the texts of the calls but those of the program's end, and the problem.
fn run(lines: &str, block_delete: bool, world: &World) -> (Vec<String>, Option<String>) {
    let settings = Settings { block_delete, ..settings() };
    let mut it = Interpreter::new(settings, Numbered::default());
    it.load("comment.ngc", Arc::new(format!("G0 X0\n#1=5\n{lines}\nM2\n").into_bytes()));
    let (calls, error) = run_with(&mut it, world, |_| {});
    let shown = calls.into_iter().skip(1).filter_map(|issued| match issued.call {
        Call::StraightTraverse(_) => Some("move".to_owned()),
        Call::Message(_)
        | Call::Print(_)
        | Call::Log(_)
        | Call::LogOpen { .. }
        | Call::LogClose
        | Call::ProbeOpen(_)
        | Call::ProbeClose
        | Call::Comment(_) => Some(issued.call.to_string()),
        _ => None,
    });
    (shown.collect(), error.map(|e| e.problem.to_string()))
}

/// Returns what a line of the table has to do.
fn expected(case: &Case) -> (Vec<String>, Option<String>) {
    if let Some(problem) = case.call.strip_prefix('!') {
        return (Vec::new(), Some(problem.to_owned()));
    }
    let mut calls = vec![case.call.to_owned()];
    calls.extend(case.moves.then(|| "move".to_owned()));
    (calls, None)
}

#[test]
fn each_comment_acts_whatever_stands_beside_it() {
    let world = World::new();
    let (cases, mut wrong) = (cases(), Vec::new());
    for case in &cases {
        for block_delete in [false, true] {
            let left_out = block_delete && case.is_deletable;
            let wanted = if left_out { (Vec::new(), None) } else { expected(case) };
            let given = run(&case.line, block_delete, &world);
            if given != wanted {
                wrong.push(format!("{:?}: {given:?}, not {wanted:?}", case.line));
            }
        }
    }
    assert_eq!(cases.len(), 7744);
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// Comments on lines of O-words are remarks, as in the reference; those in a branch that is left out do nothing.
#[test]
fn a_comment_on_the_line_of_an_o_word_is_a_remark() {
    let world = World::new();
    for (comment, call) in COMMENTS {
        let run = |lines: &str| run(&lines.replace('@', &format!("({comment})")), false, &world);
        let none = (Vec::new(), None);
        for lines in [
            "o1 if [1] @;\no1 endif @",
            "o1 if [0] @\n@\no1 elseif [0] @ ; text\n@\no1 endif",
            "o1 repeat [2] @\no1 endrepeat @",
            "o1 while [#7 lt 2] @\n#7=[#7+1]\no1 endwhile @;",
            "o1 do @\no1 while [0] @",
            "o1 sub @\no1 endsub @;\no1 call [1] @ [2] @",
            "o1 sub\n@\no1 endsub",
            "o1 @;",
        ] {
            assert_eq!(run(lines), none, "{lines} {comment}");
        }
        let one = expected(&Case { line: String::new(), is_deletable: false, call, moves: false });
        assert_eq!(run("o1 if [1]\n@;\no1 endif"), one, "{comment}");
        assert_eq!(run("o1 sub\n@ ; text\no1 endsub\no1 call"), one_level(one, comment));
    }
}

/// Within a call, parameter 1 is the call's own.
fn one_level(
    (mut calls, problem): (Vec<String>, Option<String>),
    comment: &str,
) -> (Vec<String>, Option<String>) {
    let own = |text: &String| {
        if comment.contains("#1") { text.replace('5', "0") } else { text.clone() }
    };
    calls = calls.iter().map(own).collect();
    (calls, problem.as_ref().map(own))
}

/// `rs274` does the same with every line of the table but those that run Python.
#[test]
#[ignore = "needs LinuxCNC's rs274 and root for runuser: cargo test -p hal-gcode --test programs -- --ignored --nocapture"]
fn the_reference_does_the_same_with_each_comment() {
    let room = std::env::temp_dir().join("hal-gcode-comments");
    std::fs::create_dir_all(&room).unwrap();
    let is_python = |case: &Case| case.call.contains("Python") || case.line.contains("PY,");
    let cases: Vec<Case> = cases().into_iter().filter(|c| !is_python(c)).collect();
    let lines: Vec<&str> = cases.iter().map(|c| c.line.as_str()).collect();
    let text = format!("G0 X0\n#1=5\n{}\nM2\n", lines.join("\n"));
    std::fs::write(room.join("c.ngc"), text).unwrap();
    std::fs::write(room.join("v.var"), "5161 0.0\n").unwrap();
    std::fs::write(room.join("t.tbl"), crate::support::TABLE).unwrap();
    let given = Command::new("chown").args(["-R", "nobody"]).arg(&room).status().unwrap();
    assert!(given.success());
    let mut command = Command::new("runuser");
    command.args(["-u", "nobody", "--", "env", &format!("HOME={}", room.display())]);
    command.args(["rs274", "-g", "-n", "0", "-t", "t.tbl", "-v", "v.var", "c.ngc"]);
    let output = command.current_dir(&room).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let named = ["MESSAGE", "LOG", "COMMENT", "STRAIGHT"];
    let mut theirs = text.lines().filter_map(|line| {
        let call = line.find(|c: char| c.is_ascii_alphabetic() && c != 'N').map(|at| &line[at..]);
        let call = call.filter(|c| named.iter().any(|n| c.starts_with(n)));
        let is_printed = line.starts_with("v 5.0") || line == "first";
        let shown = call.or(is_printed.then_some(line))?;
        Some(if shown.starts_with("STRAIGHT") { "move".into() } else { shown.to_lowercase() })
    });
    // The first is the move of the begin.
    assert_eq!(theirs.next().as_deref(), Some("move"));
    for case in &cases {
        for call in expected(case).0 {
            let spaceless = |t: &str| t.to_lowercase().replace(['\t', ' '], "");
            let given = theirs.next().unwrap_or_default();
            assert_eq!(spaceless(&given), spaceless(&call), "{:?}", case.line);
        }
    }
    assert_eq!(theirs.next(), None);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let aborts = cases.iter().filter(|c| c.call.starts_with('!')).count();
    assert_eq!(told.lines().filter(|l| *l == "v 5.000000").count(), aborts);
}
