//! Every program through `rs274` of LinuxCNC and through this interpreter: the same calls, the same line of an error.

use std::{
    collections::BTreeMap,
    path::Path,
    process::{Command, Stdio},
};

use hal_gcode::{Answer, Call, Environment, Error, Issued, Request, Step, canon::Frame};

use crate::support::{World, answer, folder, interpreter_of, printed};

/// The output of `rs274`: its calls, its message and the line of its error.
struct Peer {
    calls: Vec<String>,
    message: Option<String>,
    line: String,
}

fn peer(room: &Path, name: &str) -> Peer {
    std::fs::write(room.join("v.var"), "5161 0.0\n").unwrap();
    let file = format!("{name}.ngc");
    let mut command = Command::new("timeout");
    command.args(["20", "runuser", "-u", "nobody", "--", "env"]);
    command.arg(format!("HOME={}", room.display())).args(["rs274", "-g", "-n", "2"]);
    command.args(["-t", "t.tbl", "-v", "v.var"]);
    if name.starts_with("remap-") {
        command.args(["-i", "remap.ini"]);
    }
    if name.starts_with("random-") {
        command.args(["-i", "random.ini"]);
    }
    if name.starts_with("offset-") {
        command.args(["-i", "offset.ini"]);
    }
    if name.starts_with("no-parts-") {
        command.args(["-i", "no-parts.ini"]);
    }
    if name.starts_with("nargs-") {
        command.args(["-i", "nargs.ini"]);
    }
    command.arg(&file);
    command.current_dir(room).stdin(Stdio::null());
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut calls = Vec::new();
    for line in text.lines() {
        let call = numbered(line);
        match call {
            Some((n, _)) if n <= 6 => {}
            Some((_, "ON_RESET()")) => {}
            // The reference repeats an entry for the spindle, as index 0.
            Some((_, call)) if call.starts_with("SET_TOOL_TABLE_ENTRY(0,") => {}
            Some((_, call)) => calls.push(call.to_owned()),
            None => calls.push(line.to_owned()),
        }
    }
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let mut lines = told.lines().filter(|l| *l != "executing");
    let message = lines.next().map(str::to_owned);
    let line = lines.next().unwrap_or_default().trim().to_owned();
    Peer { calls, message, line }
}

/// Splits a line of the form `  12 N..... CALL(…)`.
fn numbered(line: &str) -> Option<(u32, &str)> {
    let (n, rest) = line.trim_start().split_once(' ')?;
    let n = n.parse().ok()?;
    let rest = rest.strip_prefix('N')?;
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != ' ')?;
    Some((n, rest.get(end..)?))
}

/// Compares calls; numbers may differ in the last digit that is printed.
fn same(a: &str, b: &str) -> bool {
    let split = |t: &str| -> Vec<String> {
        let mut parts = vec![String::new()];
        let mut in_number = false;
        for c in t.chars() {
            let number = c.is_ascii_digit() || c == '.' || c == '-';
            if number != in_number {
                parts.push(String::new());
                in_number = number;
            }
            parts.last_mut().unwrap().push(c);
        }
        parts
    };
    let (a, b) = (split(a), split(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| {
            a == b
                || match (a.parse::<f64>(), b.parse::<f64>()) {
                    (Ok(x), Ok(y)) => (x - y).abs() < 1.5e-4,
                    _ => false,
                }
        })
}

/// Runs a program on a machine like the one that `rs274` stands in for. Tool 0 is selected from the begin; the tool of
/// M61 does not come into the spindle, and the old one stays there when tool 0 is changed to; after a change, the machine
/// tells its place without the rotation.
fn stand_in(name: &str, world: &World) -> (Vec<Issued>, Option<Error>) {
    let mut it = interpreter_of(name);
    it.state.selected = Some(0);
    it.load(&format!("{name}.ngc"), world.open(name).unwrap());
    let mut out = Vec::new();
    let mut asked = None;
    loop {
        let (known, held) = (out.len(), it.state.tool.clone());
        let step = match asked.take() {
            None => it.next(world, &mut out),
            Some(Request::ToolChange { .. }) => {
                let frame = Frame { rotation: 0.0, ..it.state.frame };
                let position = Some(frame.machine_mm(it.state.position));
                it.answer(&Answer::ToolChange { position }, world, &mut out)
            }
            Some(request) => {
                let reply = answer(&request, &it);
                it.answer(&reply, world, &mut out)
            }
        };
        let stays = |i: &Issued| matches!(i.call, Call::ChangeToolNumber(_) | Call::ChangeTool(0));
        if out.iter().skip(known).any(stays) {
            it.state.tool = held;
        }
        match step {
            Ok(Step::Line) => {}
            Ok(Step::Ask(request)) => asked = Some(request),
            Ok(Step::Ended) => return (out, None),
            Err(error) => return (out, Some(error)),
        }
    }
}

/// The programs that differ, with the reasons.
fn differences() -> BTreeMap<String, String> {
    let text = std::fs::read_to_string(folder("differences.txt")).unwrap();
    let lines = text.lines().filter(|l| !l.starts_with('#') && !l.trim().is_empty());
    lines.map(|l| l.split_once(": ").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap()).collect()
}

#[test]
#[ignore = "needs LinuxCNC's rs274 and root for runuser: cargo test -p hal-gcode --test programs -- --ignored --nocapture"]
fn programs_give_the_calls_of_the_reference() {
    let room = std::env::temp_dir().join("hal-gcode-oracle");
    std::fs::create_dir_all(&room).unwrap();
    let world = World::new();
    for (name, text) in &world.files {
        std::fs::write(room.join(format!("{name}.ngc")), text).unwrap();
    }
    std::fs::write(room.join("t.tbl"), crate::support::TABLE).unwrap();
    // The reference refuses an INI file whose subroutines are missing.
    let remaps = crate::support::REMAPS.lines().filter(|l| !l.contains("missing"));
    std::fs::write(room.join("remap.ini"), remaps.collect::<Vec<_>>().join("\n")).unwrap();
    std::fs::write(room.join("random.ini"), "[EMCIO]\nRANDOM_TOOLCHANGER=1\n").unwrap();
    let no_parts = "[RS274NGC]\nDISABLE_FANUC_STYLE_SUB=1\n";
    std::fs::write(room.join("no-parts.ini"), no_parts).unwrap();
    std::fs::write(room.join("nargs.ini"), "[RS274NGC]\nOWORD_NARGS=1\n").unwrap();
    std::fs::write(room.join("offset.ini"), "[RS274NGC]\nORIENT_OFFSET=42\n").unwrap();
    std::fs::write(room.join("v.var"), "").unwrap();
    // The reference links its parameter file to a second name, which only the owner of a file may do.
    let given = Command::new("chown").args(["-R", "nobody"]).arg(&room).status().unwrap();
    assert!(given.success());
    let only = std::env::var("ONLY").ok();
    let known = differences();
    let mut wrong = Vec::new();
    let (mut equal, mut messages, mut errors) = (0, 0, 0);
    for name in world.files.keys() {
        if only.as_ref().is_some_and(|o| !name.contains(o.as_str())) || name.starts_with("lib-") {
            continue;
        }
        let theirs = peer(&room, name);
        let (calls, error) = stand_in(name, &world);
        let ours = printed(&calls);
        let mut report = Vec::new();
        let at = ours.iter().zip(&theirs.calls).position(|(a, b)| !same(a, b));
        let at =
            at.or((ours.len() != theirs.calls.len()).then(|| ours.len().min(theirs.calls.len())));
        if let Some(at) = at {
            for i in at..(at + 4).min(ours.len().max(theirs.calls.len())) {
                let none = String::from("-");
                report.push(format!("  ours   {}", ours.get(i).unwrap_or(&none)));
                report.push(format!("  theirs {}", theirs.calls.get(i).unwrap_or(&none)));
            }
        }
        // A subroutine of another file has its name without ending.
        let file = error.as_ref().map_or(name.as_str(), |e| e.place.file.trim_end_matches(".ngc"));
        let source = String::from_utf8_lossy(&world.files[file]).into_owned();
        let line = error.as_ref().map_or("", |e| {
            let index = usize::try_from(e.place.line).unwrap().saturating_sub(1);
            source.lines().nth(index).unwrap_or_default()
        });
        if error.is_some() != theirs.message.is_some() || line.trim() != theirs.line {
            report.push(format!("  error  {:?}", error.as_ref().map(ToString::to_string)));
            report.push(format!("  theirs {:?} at {:?}", theirs.message, theirs.line));
        } else if let (Some(error), Some(message)) = (&error, &theirs.message) {
            errors += 1;
            let same = error.problem.to_string().to_lowercase() == message.to_lowercase();
            messages += u32::from(same);
            if !same && std::env::var("MESSAGES").is_ok() {
                eprintln!("{name}: {} | {message}", error.problem);
            }
        }
        match (report.is_empty(), known.get(name)) {
            (true, None) => equal += 1,
            (true, Some(_)) => wrong.push(format!("{name}: listed as different, but equal")),
            (false, Some(_)) => {}
            (false, None) => wrong.push(format!("{name}:\n{}", report.join("\n"))),
        }
    }
    eprintln!("{equal} equal, {} listed as different, {} not explained", known.len(), wrong.len());
    eprintln!("{messages} of {errors} error messages have the same text");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
