//! `ferrule doctor`: what a machine needs of the computer, what of it is missing, and the line that mends it.

mod computer;
mod findings;

use crate::{failure::Failure, options::Doctor};
use computer::Computer;
use findings::{Finding, Grade};
use std::{
    io::Write as _,
    process::{Command, ExitCode},
};

/// Looks at the computer and prints what it has found. The status is 1 if something is missing.
pub(crate) fn doctor(given: &Doctor) -> Result<ExitCode, Failure> {
    let findings = findings::all(&Computer::read(&given.root));
    hal_output::print(&text(&findings))?;
    if given.fix {
        mend(&findings)?;
    }
    let is_ill = findings.iter().any(|f| f.grade == Grade::Missing);
    Ok(if is_ill { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Returns what `ferrule doctor` prints, without questions.
pub(crate) fn examined(root: &std::path::Path) -> String {
    text(&findings::all(&Computer::read(root)))
}

fn text(findings: &[Finding]) -> String {
    let mut text = String::new();
    for finding in findings {
        text.push_str(&format!(
            "{:<8} {:<14} {}\n",
            finding.grade.word(),
            finding.subject,
            finding.says
        ));
        for line in &finding.lines {
            text.push_str(&format!("{:>8} {line}\n", "do:"));
        }
        if let Some(then) = finding.then {
            text.push_str(&format!("{:>8} {then}\n", "then:"));
        }
    }
    let count = |grade| findings.iter().filter(|f| f.grade == grade).count();
    let (missing, better) = (count(Grade::Missing), count(Grade::Better));
    text.push_str(&format!("{missing} missing, {better} could be better\n"));
    text
}

/// Asks about each line that mends something, and runs it.
fn mend(findings: &[Finding]) -> Result<(), Failure> {
    let lines: Vec<&String> = findings.iter().flat_map(|f| &f.lines).collect();
    if lines.is_empty() {
        return Ok(());
    }
    if !hal_output::is_person() {
        return Err(Failure::NoTerminal { what: "--fix", instead: "type the lines yourself" });
    }
    for line in lines {
        hal_output::print(&format!("\n{line}\nrun this? [y/N] "))?;
        let mut answer = String::new();
        // Without an answer nothing runs.
        drop(std::io::stdin().read_line(&mut answer));
        if answer.trim().eq_ignore_ascii_case("y") {
            let status = Command::new("sh").arg("-c").arg(line).status();
            let said = match status {
                Ok(status) if status.success() => "done".to_owned(),
                Ok(status) => status.to_string(),
                Err(error) => hal_output::reason(&error),
            };
            // Standard error has nowhere else to go.
            drop(writeln!(std::io::stderr(), "{said}"));
        }
    }
    Ok(())
}
