//! Requirements on the whole run or on a part of it.

use super::{
    condition::Condition,
    file::{self, Text},
    instant::Instant,
    outcome::{Complaint, Spot},
    source::Source,
    step::{is_value, no_value},
    test::Named,
};
use crate::nanoseconds;
use toml::{Spanned, Value};

/// The keys of which an expectation has exactly one.
const KEYS: &str = "value, always, never, happens, order, between, pulses, motor, message or \
                    no-message";

/// A requirement with its part of the run.
#[derive(Debug)]
pub(super) struct Expectation {
    pub(super) spot: Spot,
    pub(super) about: String,
    pub(super) from: Instant,
    pub(super) to: Instant,
    pub(super) what: Requirement,
}

/// Kind of a requirement.
#[derive(Debug)]
pub(super) enum Requirement {
    /// A value at one moment, or during the whole part of the run.
    Value { of: Named, at: Option<Instant>, bounds: Bounds },
    /// A condition that always holds, or always holds while another one does.
    Always { holds: Condition, when: Option<Condition> },
    /// A condition that never holds, or never holds while another one does.
    Never { holds: Condition, when: Option<Condition> },
    /// An event that happens between `least` and `most` times.
    Happens { event: Condition, least: u64, most: u64 },
    /// Events that happen one after the other.
    Order(Vec<Condition>),
    /// The time from one event to the next.
    Between { first: Condition, then: Condition, time: Times },
    /// The pulses of a bit.
    Pulses(Pulses),
    /// The position, in steps, of a stepper motor on these lines.
    Motor { step: Named, direction: Named, bounds: Bounds },
    /// A message that is logged.
    Message(Named),
    /// A message that is not logged.
    NoMessage(Named),
}

/// Permitted values of a number.
#[derive(Clone, Debug)]
pub(super) enum Bounds {
    /// A value, with a tolerance.
    Is(Value, f64),
    /// A range: minimum and maximum.
    Within(f64, f64),
}

/// Permitted durations in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    pub(super) least: u64,
    pub(super) most: u64,
}

/// Requirements on the pulses of a bit.
#[derive(Debug)]
pub(super) struct Pulses {
    pub(super) of: Named,
    pub(super) count: Option<u64>,
    /// Frequency and tolerance, in hertz.
    pub(super) frequency: Option<(f64, f64)>,
    pub(super) high: Option<(Spot, Times)>,
    pub(super) low: Option<(Spot, Times)>,
}

impl Expectation {
    /// Returns every condition of the expectation.
    pub(super) fn conditions(&self) -> impl Iterator<Item = &Condition> {
        let list: Vec<&Condition> = match &self.what {
            Requirement::Always { holds, when } | Requirement::Never { holds, when } => {
                [holds].into_iter().chain(when).collect()
            }
            Requirement::Happens { event, .. } => vec![event],
            Requirement::Order(events) => events.iter().collect(),
            Requirement::Between { first, then, .. } => vec![first, then],
            Requirement::Value { .. }
            | Requirement::Pulses(_)
            | Requirement::Motor { .. }
            | Requirement::Message(_)
            | Requirement::NoMessage(_) => Vec::new(),
        };
        list.into_iter()
    }

    /// Returns every channel that the expectation evaluates by name.
    pub(super) fn channels(&self) -> impl Iterator<Item = &Named> {
        let list = match &self.what {
            Requirement::Value { of, .. } => vec![of],
            Requirement::Pulses(pulses) => vec![&pulses.of],
            Requirement::Motor { step, direction, .. } => vec![step, direction],
            _ => Vec::new(),
        };
        list.into_iter()
    }

    /// Returns every moment of the expectation.
    pub(super) fn instants(&self) -> impl Iterator<Item = &Instant> {
        let at = match &self.what {
            Requirement::Value { at, .. } => at.as_ref(),
            _ => None,
        };
        [&self.from, &self.to].into_iter().chain(at)
    }
}

/// Checks the form of an expectation.
pub(super) fn checked(
    source: &Source<'_>,
    expect: Spanned<file::Expect>,
) -> Result<Expectation, Complaint> {
    let spot = source.spot(&expect.span());
    let mut expect = expect.into_inner();
    let from = source.instant(expect.from.as_ref(), Instant::start(&spot))?;
    let to = source.instant(expect.to.as_ref(), Instant::end(&spot))?;
    let about = core::mem::take(&mut expect.about).unwrap_or_default();
    let mut kinds = Kinds { source, spot: &spot, expect: &mut expect, found: Vec::new() };
    kinds.all()?;
    let mut found = kinds.found.into_iter();
    let (key, what) = match (found.next(), found.next()) {
        (Some(one), None) => one,
        (None, _) => {
            let text = "this expects nothing";
            return Err(Complaint::new(&spot, text).with(format!("it has one of {KEYS}")));
        }
        (Some((a, _)), Some((b, _))) => {
            let text = format!("this expects two things, '{a}' and '{b}': write two of them");
            return Err(Complaint::new(&spot, text));
        }
    };
    left_over(source, &expect, key)?;
    Ok(Expectation { spot, about, from, to, what })
}

/// Looks for each kind of expectation. Each kind takes the keys that it uses; keys that remain
/// belong to none.
struct Kinds<'a> {
    source: &'a Source<'a>,
    spot: &'a Spot,
    expect: &'a mut file::Expect,
    found: Vec<(&'static str, Requirement)>,
}

impl Kinds<'_> {
    fn all(&mut self) -> Result<(), Complaint> {
        let source = self.source;
        if let Some(of) = self.expect.value.take() {
            let at = self.expect.at.take();
            let at = at.map(|t| source.instant(Some(&t), Instant::end(self.spot))).transpose()?;
            let what =
                Requirement::Value { bounds: self.bounds("value")?, of: source.named(&of), at };
            self.found.push(("value", what));
        }
        if let Some(text) = self.expect.always.take() {
            let what = Requirement::Always { holds: self.condition(&text)?, when: self.when()? };
            self.found.push(("always", what));
        }
        if let Some(text) = self.expect.never.take() {
            let what = Requirement::Never { holds: self.condition(&text)?, when: self.when()? };
            self.found.push(("never", what));
        }
        if let Some(text) = self.expect.happens.take() {
            let times = self.expect.times.take().map(Spanned::into_inner);
            let (least, most) = (self.number("least")?, self.number("most")?);
            let least = times.or(least).unwrap_or(u64::from(most.is_none()));
            let most = times.or(most).unwrap_or(u64::MAX);
            let what = Requirement::Happens { event: self.condition(&text)?, least, most };
            self.found.push(("happens", what));
        }
        if let Some(list) = self.expect.order.take() {
            let events = list.iter().map(|t| self.condition(t)).collect::<Result<Vec<_>, _>>()?;
            if events.len() < 2 {
                let text = "an order is of two events or more";
                return Err(Complaint::new(self.spot, text));
            }
            self.found.push(("order", Requirement::Order(events)));
        }
        if let Some(list) = self.expect.between.take() {
            let [first, then] = list.as_slice() else {
                let text = format!("'between' is of two events, not of {}", list.len());
                return Err(Complaint::new(self.spot, text));
            };
            let (first, then) = (self.condition(first)?, self.condition(then)?);
            let time = self.times()?;
            self.found.push(("between", Requirement::Between { first, then, time }));
        }
        if let Some(of) = self.expect.pulses.take() {
            let what = Requirement::Pulses(self.pulses(&of)?);
            self.found.push(("pulses", what));
        }
        if let Some(file::Motor { step, direction }) = self.expect.motor.take() {
            let (step, direction) = (source.named(&step), source.named(&direction));
            let what = Requirement::Motor { step, direction, bounds: self.bounds("motor")? };
            self.found.push(("motor", what));
        }
        if let Some(text) = self.expect.message.take() {
            self.found.push(("message", Requirement::Message(source.named(&text))));
        }
        if let Some(text) = self.expect.no_message.take() {
            self.found.push(("no-message", Requirement::NoMessage(source.named(&text))));
        }
        Ok(())
    }

    fn condition(&self, text: &Text) -> Result<Condition, Complaint> {
        Condition::parse(self.source.named(text))
    }

    fn when(&mut self) -> Result<Option<Condition>, Complaint> {
        let text = self.expect.r#while.take();
        text.map(|t| self.condition(&t)).transpose()
    }

    /// Takes `is` with a tolerance, or `least` and `most`.
    fn bounds(&mut self, key: &str) -> Result<Bounds, Complaint> {
        let tolerance = self.expect.tolerance.take().map(Spanned::into_inner);
        if let Some(is) = self.expect.is.take() {
            let spot = self.source.spot(&is.span());
            let is = is.into_inner();
            if !is_value(&is) {
                return Err(no_value(&spot, key));
            }
            return Ok(Bounds::Is(is, tolerance.unwrap_or(0.0)));
        }
        let (least, most) = (self.expect.least.take(), self.expect.most.take());
        if least.is_none() && most.is_none() {
            let text = format!("'{key}' without 'is', 'least' or 'most' expects nothing");
            return Err(Complaint::new(self.spot, text));
        }
        let number = |value: Option<Spanned<Value>>, or: f64| match value {
            None => Ok(or),
            Some(v) => match v.get_ref() {
                Value::Integer(i) => Ok(*i as f64),
                Value::Float(f) => Ok(*f),
                _ => Err(Complaint::new(&self.source.spot(&v.span()), "this is not a number")),
            },
        };
        Ok(Bounds::Within(number(least, f64::NEG_INFINITY)?, number(most, f64::INFINITY)?))
    }

    /// Takes `least` or `most` of a count.
    fn number(&mut self, key: &str) -> Result<Option<u64>, Complaint> {
        let expect = &mut *self.expect;
        let value = if key == "least" { expect.least.take() } else { expect.most.take() };
        let Some(value) = value else { return Ok(None) };
        let number = value.get_ref().as_integer().and_then(|i| u64::try_from(i).ok());
        number.map(Some).ok_or_else(|| {
            let text = format!("'{key}' is how often it happens: a whole number");
            Complaint::new(&self.source.spot(&value.span()), text)
        })
    }

    /// Takes `least` and `most` of a duration.
    fn times(&mut self) -> Result<Times, Complaint> {
        let (least, most) = (self.expect.least.take(), self.expect.most.take());
        if least.is_none() && most.is_none() {
            let text = "'between' without 'least' or 'most' expects nothing";
            return Err(Complaint::new(self.spot, text));
        }
        let time = |value: Option<Spanned<Value>>, or: u64| {
            let Some(value) = value else { return Ok(or) };
            let ns = value.get_ref().as_str().and_then(|t| nanoseconds(t).ok());
            ns.ok_or_else(|| {
                let text = format!("{} is not a time", value.get_ref());
                Complaint::new(&self.source.spot(&value.span()), text).with(super::source::TIMES)
            })
        };
        Ok(Times { least: time(least, 0)?, most: time(most, u64::MAX)? })
    }

    fn pulses(&mut self, of: &Text) -> Result<Pulses, Complaint> {
        let count = self.expect.count.take().map(Spanned::into_inner);
        let tolerance = self.expect.tolerance.take().map(Spanned::into_inner);
        let frequency = self.expect.frequency.take().map(Spanned::into_inner);
        let frequency = frequency.map(|f| (f, tolerance.unwrap_or(0.0)));
        let high = self.expect.high.take().map(|w| self.width(w)).transpose()?;
        let low = self.expect.low.take().map(|w| self.width(w)).transpose()?;
        if count.is_none() && frequency.is_none() && high.is_none() && low.is_none() {
            let text = "'pulses' without 'count', 'frequency', 'high' or 'low' expects nothing";
            return Err(Complaint::new(self.spot, text));
        }
        Ok(Pulses { of: self.source.named(of), count, frequency, high, low })
    }

    fn width(&self, width: Spanned<file::Width>) -> Result<(Spot, Times), Complaint> {
        let spot = self.source.spot(&width.span());
        let width = width.into_inner();
        let time = |t: Option<Text>, or| t.map_or(Ok(or), |t| self.source.time(&t));
        Ok((spot, Times { least: time(width.least, 0)?, most: time(width.most, u64::MAX)? }))
    }
}

/// Rejects keys that belong to another kind of expectation.
fn left_over(source: &Source<'_>, expect: &file::Expect, key: &str) -> Result<(), Complaint> {
    let span = |s: &Option<Text>| s.as_ref().map(Spanned::span);
    let value = |s: &Option<Spanned<Value>>| s.as_ref().map(Spanned::span);
    let left = [
        ("at", span(&expect.at), "value"),
        ("is", value(&expect.is), "value and motor"),
        ("least", value(&expect.least), "value, motor, happens and between"),
        ("most", value(&expect.most), "value, motor, happens and between"),
        ("tolerance", expect.tolerance.as_ref().map(Spanned::span), "value, motor and pulses"),
        ("while", span(&expect.r#while), "always and never"),
        ("times", expect.times.as_ref().map(Spanned::span), "happens"),
        ("count", expect.count.as_ref().map(Spanned::span), "pulses"),
        ("frequency", expect.frequency.as_ref().map(Spanned::span), "pulses"),
        ("high", expect.high.as_ref().map(Spanned::span), "pulses"),
        ("low", expect.low.as_ref().map(Spanned::span), "pulses"),
    ];
    for (name, span, owners) in left {
        if let Some(span) = span {
            let text = format!("'{name}' has no meaning with '{key}'");
            return Err(
                Complaint::new(&source.spot(&span), text).with(format!("it belongs to {owners}"))
            );
        }
    }
    Ok(())
}
