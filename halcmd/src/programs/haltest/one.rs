//! A single test, in its own process.

use super::{
    evaluate,
    failure::Failure,
    outcome::{Complaint, Outcome, Spot},
    process::{OUTCOME, RECORDING},
    run::{self, Run},
    stage,
    test::Test,
};
use rustix::process::{Signal, set_parent_process_death_signal};
use std::path::Path;

/// Runs the test in a file and leaves the outcome in a folder.
///
/// # Errors
/// The outcome cannot be written.
pub(super) fn main(shown: &str, folder: &Path) -> Result<(), Failure> {
    // If the parent process ends, nobody needs the outcome, so the kernel kills this process.
    let _ = set_parent_process_death_signal(Some(Signal::KILL));
    let outcome = outcome(shown, folder);
    let text = serde_json::to_vec(&outcome).map_err(|e| Failure::Unwritten(e.to_string()))?;
    let path = folder.join(OUTCOME);
    std::fs::write(&path, text).map_err(|e| Failure::file(&path, &e))
}

fn outcome(shown: &str, folder: &Path) -> Outcome {
    let mut outcome = Outcome::default();
    let path = std::path::absolute(shown).unwrap_or_else(|_| shown.into());
    let test = match Test::read(&path, shown) {
        Ok(test) => test,
        Err(complaints) => {
            outcome.complaints = complaints;
            return outcome;
        }
    };
    outcome.about.clone_from(&test.about);
    let (copy, script) = match stage::set(&test, folder) {
        Ok(found) => found,
        Err(complaint) => {
            outcome.complaints.push(complaint);
            return outcome;
        }
    };
    if let Err(error) = std::env::set_current_dir(&copy) {
        let spot = Spot { file: shown.to_owned(), line: 1 };
        outcome.complaints.push(Complaint::new(&spot, crate::ini::plain(&error)));
        return outcome;
    }
    let run = run::run(&test, &script);
    outcome.machine_ns = run.end.unsigned_abs();
    outcome.said = run.said.iter().map(|(_, text)| text.clone()).collect();
    evaluate(&test, &run, shown, folder, &mut outcome);
    outcome
}

fn evaluate(test: &Test, run: &Run, shown: &str, folder: &Path, outcome: &mut Outcome) {
    outcome.complaints.extend(run.complaints.iter().cloned());
    if let Some(recording) = &run.recording
        && let Err(error) = std::fs::copy(recording, folder.join(RECORDING))
    {
        let spot = Spot { file: shown.to_owned(), line: 1 };
        let text = format!("the recording cannot be kept: {}", crate::ini::plain(&error));
        outcome.complaints.push(Complaint::new(&spot, text));
    }
    if !run.aborted {
        evaluate::evaluate(test, run, shown, outcome);
    }
}
