//! The steps of a test. Each has one action.

use super::{
    condition::Condition,
    file::{self, Text},
    instant::{END, START},
    outcome::{Complaint, Spot},
    source::Source,
    test::{Entry, Named},
};
use toml::{Spanned, Value};

/// Default time limit of a `wait`.
const TIMEOUT_NS: u64 = 10_000_000_000;

/// The keys of which a step has exactly one.
const KEYS: &str = "do, run, wait, set, ramp, force, stuck, unlink, drop, release or expect";

/// A step of a test.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) spot: Spot,
    /// Time after the start at which the step is due.
    pub(super) at: Option<u64>,
    /// Name of the moment at which the step executes.
    pub(super) mark: Option<String>,
    pub(super) action: Action,
}

/// Action of a step.
#[derive(Debug)]
pub(super) enum Action {
    /// None: the step only marks a moment.
    Mark,
    /// Executes lines of the HAL language.
    Do {
        lines: Named,
        fails: Option<String>,
        prints: Option<String>,
    },
    /// Lets time pass.
    Run(u64),
    /// Lets time pass until a condition holds.
    Wait {
        until: Condition,
        within: u64,
    },
    Set(Vec<Entry>),
    Ramp(Vec<Ramp>),
    Force(Vec<Entry>),
    Stuck(Vec<Named>),
    Unlink(Vec<Named>),
    Drop(Vec<(Named, u32)>),
    Release(Vec<Named>),
    Expect(Vec<Entry>, f64),
}

/// A value that changes linearly.
#[derive(Clone, Debug)]
pub(super) struct Ramp {
    pub(super) what: Named,
    pub(super) from: Option<f64>,
    pub(super) to: f64,
    pub(super) over: u64,
}

/// Checks the form of a step.
pub(super) fn checked(source: &Source<'_>, step: Spanned<file::Step>) -> Result<Step, Complaint> {
    let spot = source.spot(&step.span());
    let step = step.into_inner();
    companions(source, &step)?;
    let at = step.at.as_ref().map(|t| source.time(t)).transpose()?;
    let mark = step.mark.as_ref().map(|m| mark(source, m)).transpose()?;
    let mut actions = Vec::new();
    if let Some(text) = step.r#do {
        let plain = |t: Option<Text>| t.map(Spanned::into_inner);
        let (fails, prints) = (plain(step.fails), plain(step.prints));
        actions.push(Action::Do { lines: source.lines(&text), fails, prints });
    }
    if let Some(time) = &step.run {
        actions.push(Action::Run(source.time(time)?));
    }
    if let Some(text) = &step.wait {
        let within = step.within.as_ref().map(|t| source.time(t)).transpose()?;
        let until = Condition::parse(source.named(text))?;
        actions.push(Action::Wait { until, within: within.unwrap_or(TIMEOUT_NS) });
    }
    actions.extend(step.set.map(|v| Action::Set(source.entries(v))));
    if let Some(ramps) = step.ramp {
        let mut all: Vec<_> = ramps.into_iter().collect();
        all.sort_by_key(|(name, _)| name.span().start);
        let ramps = all.into_iter().map(|(name, ramp)| ramped(source, &name, ramp.into_inner()));
        actions.push(Action::Ramp(ramps.collect::<Result<_, _>>()?));
    }
    actions.extend(step.force.map(|v| Action::Force(source.entries(v))));
    actions.extend(step.stuck.map(|v| Action::Stuck(source.all_named(&v))));
    actions.extend(step.unlink.map(|v| Action::Unlink(source.all_named(&v))));
    if let Some(drops) = step.drop {
        let mut all: Vec<_> = drops.into_iter().collect();
        all.sort_by_key(|(name, _)| name.span().start);
        let drops = all.into_iter().map(|(name, n)| (source.named(&name), n.into_inner()));
        actions.push(Action::Drop(drops.collect()));
    }
    actions.extend(step.release.map(|v| Action::Release(source.all_named(&v))));
    if let Some(values) = step.expect {
        let entries = source.entries(values);
        if let Some(odd) = entries.iter().find(|e| !is_value(&e.value)) {
            return Err(no_value(&odd.spot, &odd.name));
        }
        let tolerance = step.tolerance.map_or(0.0, Spanned::into_inner);
        actions.push(Action::Expect(entries, tolerance));
    }
    let mut actions = actions.into_iter();
    let action = match (actions.next(), actions.next()) {
        (Some(action), None) => action,
        (None, _) if mark.is_some() || at.is_some() => Action::Mark,
        (None, _) => {
            let text = "this step does nothing";
            return Err(Complaint::new(&spot, text).with(format!("it has one of {KEYS}")));
        }
        (Some(_), Some(_)) => {
            let text = "this step does two things: write two steps";
            return Err(Complaint::new(&spot, text).with(format!("it has one of {KEYS}")));
        }
    };
    if let Action::Set(entries) | Action::Force(entries) = &action
        && let Some(odd) = entries.iter().find(|e| !is_value(&e.value))
    {
        return Err(no_value(&odd.spot, &odd.name));
    }
    Ok(Step { spot, at, mark, action })
}

/// Rejects keys that belong to another action than the step's own.
fn companions(source: &Source<'_>, step: &file::Step) -> Result<(), Complaint> {
    let alone = [
        (step.fails.as_ref().map(Spanned::span), step.r#do.is_some(), "fails", "do"),
        (step.prints.as_ref().map(Spanned::span), step.r#do.is_some(), "prints", "do"),
        (step.within.as_ref().map(Spanned::span), step.wait.is_some(), "within", "wait"),
        (step.tolerance.as_ref().map(Spanned::span), step.expect.is_some(), "tolerance", "expect"),
    ];
    for (span, has, key, with) in alone {
        if let Some(span) = span.filter(|_| !has) {
            let text = format!("'{key}' belongs to '{with}', which this step does not have");
            return Err(Complaint::new(&source.spot(&span), text));
        }
    }
    Ok(())
}

fn ramped(source: &Source<'_>, name: &Text, ramp: file::Ramp) -> Result<Ramp, Complaint> {
    let over = source.time(&ramp.over)?;
    if over == 0 {
        let text = "a ramp over no time: use 'set'";
        return Err(Complaint::new(&source.spot(&ramp.over.span()), text));
    }
    let (from, to) = (ramp.from.map(Spanned::into_inner), ramp.to.into_inner());
    Ok(Ramp { what: source.named(name), from, to, over })
}

fn mark(source: &Source<'_>, text: &Text) -> Result<String, Complaint> {
    let name = text.get_ref();
    let spot = source.spot(&text.span());
    if name == START || name == END {
        let text = format!("'{name}' is a moment that every test has: use another name");
        return Err(Complaint::new(&spot, text));
    }
    let good = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_');
    if good {
        return Ok(name.clone());
    }
    let rule = "a mark has letters, digits, '-' and '_', and begins with a letter";
    Err(Complaint::new(&spot, format!("'{name}' cannot be a mark")).with(rule))
}

/// Returns whether a pin can have this value.
pub(super) const fn is_value(value: &Value) -> bool {
    matches!(value, Value::Boolean(_) | Value::Integer(_) | Value::Float(_) | Value::String(_))
}

/// Writes a value for a script.
pub(super) fn text_of(value: &Value) -> String {
    match value {
        Value::Boolean(b) => u8::from(*b).to_string(),
        Value::Integer(i) => i.to_string(),
        Value::Float(f) => format!("{f:e}"),
        Value::String(text) => text.clone(),
        _ => String::new(),
    }
}

/// Returns the error for something that is not a value of a pin.
pub(super) fn no_value(spot: &Spot, name: &str) -> Complaint {
    Complaint::new(spot, format!("this is not a value for '{name}'"))
        .with("a value is true, false or a number")
}
