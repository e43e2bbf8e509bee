//! The command `halscope capture`: captures samples of a machine around a trigger and writes them
//! to a file.

use super::{
    live::{End, Live},
    plan::{Asked, Plan},
    unwritten,
};
use crate::{Stdio, Terminal};
use hal_trace::{Trace, csv, save};
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Exit status when no trigger occurred.
const NOT_TRIGGERED: u8 = 2;
/// Exit status when a trigger occurred but the capture is incomplete.
const NOT_WHOLE: u8 = 3;

/// Runs the command with these arguments.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    run(words).map(ExitCode::from)
}

fn run(words: &[String]) -> Result<u8, String> {
    let plan = match Plan::parse(words)? {
        Asked::Plan(plan) => plan,
        Asked::Help(text) => {
            Stdio.out(&text)?;
            return Ok(0);
        }
    };
    // An incomplete capture is reported even if quiet.
    let say = |is_whole: bool, text: String| {
        if !plan.is_quiet || !is_whole {
            Stdio.err(&format!("halscope: {text}\n"));
        }
    };
    let mut live = Live::begin(&plan)?;
    for n in 1..=plan.count {
        let path = plan.output.as_deref().map(|p| numbered(p, n, plan.count));
        let keep = |trace: &Trace, is_whole| {
            write(path.as_deref(), trace)?;
            say(is_whole, told(path.as_deref(), trace));
            Ok::<(), String>(())
        };
        let end = live.next()?;
        match end {
            End::Whole(trace) => keep(&trace, true)?,
            End::Part(trace, why) => {
                keep(&trace, false)?;
                say(false, format!("{why}: the capture is not whole"));
                live.leave();
                return Ok(NOT_WHOLE);
            }
            End::Nothing(before, why) => {
                let more = if n > 1 { " any more" } else { "" };
                say(before.is_none(), format!("{why}: no trigger{more}"));
                if let Some(trace) = before {
                    keep(&trace, false)?;
                }
                live.leave();
                return Ok(NOT_TRIGGERED);
            }
        }
    }
    live.leave();
    Ok(0)
}

/// Returns the file name of capture `n`: `scope-2.vcd` for the second of several captures to
/// `scope.vcd`.
fn numbered(path: &Path, n: u64, of: u64) -> PathBuf {
    match (of, path.file_stem(), path.extension()) {
        (2.., Some(stem), Some(ending)) => {
            let name = format!("{}-{n}.{}", stem.to_string_lossy(), ending.to_string_lossy());
            path.with_file_name(name)
        }
        _ => path.to_owned(),
    }
}

fn write(path: Option<&Path>, trace: &Trace) -> Result<(), String> {
    let Some(path) = path else {
        let mut text = Vec::new();
        csv::write(&mut text, trace).map_err(|e| e.to_string())?;
        return Ok(Stdio.out(&String::from_utf8_lossy(&text))?);
    };
    save(path, trace).map_err(|e| format!("{}: the capture could not be written", unwritten(&e)))
}

fn told(path: Option<&Path>, trace: &Trace) -> String {
    let path = path.map(|p| format!("{}: ", p.display())).unwrap_or_default();
    let (samples, channels) = (trace.len(), trace.channels().len());
    let s = |n: usize| if n == 1 { "" } else { "s" };
    let mut text =
        format!("{path}{samples} sample{} of {channels} channel{}", s(samples), s(channels));
    for m in trace.markers() {
        text.push_str(&format!("; at {} s {}", trace.base().seconds(m.at), m.text));
    }
    let lost = trace.lost();
    if lost > 0 {
        let gaps = trace.gaps().len();
        text.push_str(&format!("; {lost} samples were lost in {gaps} place{}", s(gaps)));
    }
    text
}
