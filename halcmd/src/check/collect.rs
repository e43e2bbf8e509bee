//! Collected and sorted findings.

use super::{
    advice, allow::Allowed, arrows, converter, entries, joints, refused, texts::Texts, unused,
};
use crate::{Error, session::dry_run::DryRun};
use hal_protocol::{At, Code, Failure, Finding, Kind, Level, Link, Reply, Request};
use std::{collections::BTreeSet, path::PathBuf};

/// Result of a check.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// Findings in order of files and lines. Findings without a place are last.
    pub findings: Vec<Finding>,
    /// The lines of the files with findings.
    pub texts: Texts,
}

/// Checks scripts in order, with the values of an INI file if one is given, or checks a machine's
/// INI file.
#[must_use]
pub fn check(files: &[String], ini: Option<&str>, plugins: Vec<PathBuf>) -> Checked {
    let mut findings = Vec::new();
    match DryRun::with_plugins(files, ini, plugins) {
        Ok(mut dry_run) => collect(&mut dry_run, &mut findings),
        Err(error) => {
            let file = files.first().map_or("", String::as_str);
            let at = refused::place(&error).unwrap_or_else(|| At::new(file, 0));
            findings.push(refused::finding(at, &error));
        }
    }
    finished(findings, files)
}

/// Checks the running instance.
///
/// # Errors
/// No instance is running.
pub fn live(link: &mut dyn Link) -> Result<Checked, Error> {
    Ok(finished(asked(link)?, &[]))
}

/// Returns the findings of the engine.
fn asked(link: &mut dyn Link) -> Result<Vec<Finding>, Failure> {
    match link.call(Request::Check)? {
        Reply::Findings(list) => Ok(list),
        _ => Err(Failure::new(-5, Error::Unexpected.to_string())),
    }
}

fn collect(dry_run: &mut DryRun, findings: &mut Vec<Finding>) {
    let result = dry_run.result().clone();
    let refusals = result.refusals.iter().map(|r| refused::finding(r.at.clone(), &r.error));
    findings.extend(refusals.map(|f| match dry_run.ini() {
        Some(ini) if f.code == Code::MotionRefuses => refused::at_entry(f, ini),
        _ => f,
    }));
    findings.extend(result.notices.iter().map(refused::notice));
    findings.extend(result.found.iter().cloned());
    findings.extend(result.unknown.notes());
    let starts = dry_run.starts_itself();
    let wired_unknown = estop_is_unknown(dry_run.engine(), &result.unknown.signals);
    let unread = result.unknown.is_anything()
        || result.refusals.iter().any(|r| {
            matches!(
                r.error,
                Error::NotYet { .. } | Error::IniNotFound { .. } | Error::NoFile { .. }
            )
        });
    let outside = pins_of(dry_run, &result.unknown.signals);
    let engine = match asked(dry_run.engine()) {
        Ok(list) => list,
        Err(failure) => vec![refused::finding(At::new("", 0), &failure.into())],
    };
    let known = |f: &Finding| match f.code {
        // Files that could not be read may have the missing lines.
        Code::NeverEnabled
        | Code::EstopNotReturned
        | Code::EstopNotJoined
        | Code::HalfWired
        | Code::InputOpen
        | Code::ResultUnused
        | Code::OddChannel
        | Code::NeverAdded
        | Code::NothingHandedOver
        | Code::NeverStarted
        | Code::EmptyThread
        | Code::Unused
            if unread =>
        {
            false
        }
        Code::HalfWired => !outside.contains(&f.subject),
        Code::NoReader
        | Code::NoWriter
        | Code::SignalMisspelt
        | Code::NoPins
        | Code::SetThenWritten => !result.unknown.signals.contains(&f.subject),
        Code::EstopNotReturned | Code::EstopNotJoined => !wired_unknown,
        // The program that starts such a machine also starts its threads.
        Code::NeverStarted => !starts,
        _ => true,
    };
    findings.extend(engine.into_iter().filter(known));
    findings.extend(joints::findings(dry_run));
    findings.extend(entries::findings(dry_run, unread));
    findings.extend(arrows::findings(dry_run));
    findings.extend(unused::findings(dry_run));
    // An entry that is misspelt is not also one that nothing reads.
    let misplaced: BTreeSet<String> = findings
        .iter()
        .filter(|f| f.code == Code::EntryMisplaced)
        .map(|f| f.subject.clone())
        .collect();
    findings.retain(|f| f.code != Code::IniUnused || !misplaced.contains(&f.subject));
    converter::advise(findings, dry_run);
    advice::improve(findings, dry_run);
    for (at, module, lines) in result.unknown.missed() {
        let is_here = |f: &&mut Finding| f.level == Level::Error && f.at.as_ref() == Some(at);
        if let Some(refused) = findings.iter_mut().find(is_here) {
            let need = if lines == 1 { "line needs" } else { "lines need" };
            refused.text = format!("{}; {lines} more {need} {module}", refused.text);
        }
    }
}

/// Returns the pins that are linked to one of these signals.
fn pins_of(dry_run: &mut DryRun, signals: &BTreeSet<String>) -> BTreeSet<String> {
    let mut pins = dry_run.items(Kind::Pins);
    pins.retain(|p| p.signal.as_ref().is_some_and(|s| signals.contains(s)));
    pins.into_iter().map(|p| p.name).collect()
}

/// Returns whether the e-stop is wired to unknown pins, in which case its further path is unknown.
fn estop_is_unknown(link: &mut dyn Link, unknown: &BTreeSet<String>) -> bool {
    let ends = ["iocontrol.0.user-enable-out", "iocontrol.0.emc-enable-in", "motion.enable"];
    let patterns = ends.map(str::to_owned).to_vec();
    match link.call(Request::List { kind: Kind::Pins, patterns, ty: None }) {
        Ok(Reply::Items(pins)) => {
            pins.iter().filter_map(|pin| pin.signal.as_ref()).any(|name| unknown.contains(name))
        }
        _ => false,
    }
}

/// Sorts the findings and removes those that comments allow.
fn finished(mut findings: Vec<Finding>, files: &[String]) -> Checked {
    let mut texts = Texts::new();
    let named = findings.iter().flat_map(|f| f.at.iter().chain(f.related.iter().map(|r| &r.at)));
    for name in named.map(|at| &at.file).chain(files) {
        if !texts.contains_key(name)
            && let Ok(bytes) = hal_ini::file::whole(name.as_ref())
        {
            let text = String::from_utf8_lossy(&bytes);
            texts.insert(name.clone(), text.lines().map(str::to_owned).collect());
        }
    }
    let mut allowed = Allowed::of(&texts);
    findings.retain(|f| !allowed.takes(f));
    findings.extend(allowed.idle());
    findings.sort_by(|a, b| key(a).cmp(&key(b)));
    findings.dedup();
    Checked { findings, texts }
}

type Key<'f> = (bool, Option<&'f At>, Code, &'f str, &'f str);

fn key(f: &Finding) -> Key<'_> {
    (f.at.is_none(), f.at.as_ref(), f.code, &f.subject, &f.text)
}
