//! `halscope capture`: samples a machine at a trigger, into a file.

use super::{
    live::{End, Live},
    plan::{Asked, Plan},
};
use crate::{Stdio, Terminal};
use hal_trace::{Trace, csv, save};
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// The status when no trigger came.
const NOT_TRIGGERED: u8 = 2;
/// The status when a trigger came and the capture did not become whole.
const NOT_WHOLE: u8 = 3;

/// Runs the command with these words.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    run(words).map(ExitCode::from)
}

fn run(words: &[String]) -> Result<u8, String> {
    let plan = match Plan::parse(words)? {
        Asked::Plan(plan) => plan,
        Asked::Help(text) => {
            Stdio.out(&text);
            return Ok(0);
        }
    };
    let say = |text: String| {
        if !plan.is_quiet {
            Stdio.err(&format!("halscope: {text}\n"));
        }
    };
    let mut live = Live::begin(&plan)?;
    let mut done = 0;
    while done < plan.count {
        let end = live.next()?;
        let (trace, why) = match end {
            End::Whole(trace) => (trace, None),
            End::Part(trace, why) => (trace, Some(why)),
            End::Nothing(why) => {
                say(format!("{why}: no trigger{}", if done > 0 { " any more" } else { "" }));
                live.leave();
                return Ok(NOT_TRIGGERED);
            }
        };
        done += 1;
        let path = plan.output.as_deref().map(|p| numbered(p, done, plan.count));
        write(path.as_deref(), &trace)?;
        say(told(path.as_deref(), &trace));
        if let Some(why) = why {
            say(format!("{why}: the capture is not whole"));
            live.leave();
            return Ok(NOT_WHOLE);
        }
    }
    live.leave();
    Ok(0)
}

/// `scope.vcd` is `scope-2.vcd` for the second of several.
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
        let written = csv::write(&mut text, trace);
        written.map_err(|e| e.to_string())?;
        Stdio.out(&String::from_utf8_lossy(&text));
        return Ok(());
    };
    save(path, trace).map_err(|e| {
        let kept = std::fs::metadata(path).map_or(0, |m| m.len());
        let kept = match kept {
            0 => "nothing of the capture could be written".to_owned(),
            n => format!(
                "the first {n} bytes of the capture are there; halscope convert --keep reads them"
            ),
        };
        format!("{e}\n{kept}")
    })
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
