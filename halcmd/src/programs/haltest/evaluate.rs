//! Comparison of the expectations with the recording.

use super::{
    compare,
    condition::Condition,
    expectation::{Expectation, Requirement},
    instant::{Instant, START},
    outcome::{Complaint, Outcome, Picture, Spot},
    picture, pulses,
    run::{Run, counted},
    test::{Named, Test},
};
use crate::language::units::duration;
use hal_protocol::Value;
use hal_trace::{Channel, Trace, draw, vcd};
use std::path::Path;

/// Adds failed expectations and the waveforms to the outcome.
pub(super) fn evaluate(test: &Test, run: &Run, shown: &str, outcome: &mut Outcome) {
    let trace = match trace(run) {
        Ok(trace) => trace,
        Err(text) => {
            let spot = Spot { file: shown.to_owned(), line: 1 };
            return outcome.complaints.push(Complaint::new(&spot, text));
        }
    };
    let record = Record { trace: &trace, run };
    let (mut expectations, mut snapshots) = (0, 0);
    for e in &test.expectations {
        match record.so_far(e) {
            Some(Ok(())) => {}
            Some(Err(mut complaint)) => {
                if !e.about.is_empty() {
                    complaint.text = format!("{}: {}", e.about, complaint.text);
                }
                outcome.complaints.push(complaint);
            }
            None => expectations += 1,
        }
    }
    for s in &test.snapshots {
        if !record.is_over(&s.to) {
            snapshots += 1;
            continue;
        }
        let names: Vec<&str> = s.channels.iter().map(|c| c.name.as_str()).collect();
        let drawn = record.window(&s.from, &s.to, &s.spot).and_then(|(from, to)| {
            draw::edges(&trace, &names, from, to)
                .map_err(|none| Complaint::new(&s.spot, none.to_string()))
        });
        match drawn {
            Ok(drawing) => outcome.pictures.push(Picture {
                spot: s.spot.clone(),
                name: s.name.clone(),
                path: picture::path(Path::new(shown), &s.name),
                drawing,
                same: false,
            }),
            Err(complaint) => outcome.complaints.push(complaint),
        }
    }
    if let Some((_, step)) = &run.failed
        && let Some(left) = counted(&[(expectations, "expectation"), (snapshots, "snapshot")])
        && let Some(complaint) = outcome.complaints.iter_mut().find(|c| c.spot == *step)
    {
        complaint.details.push(format!("not judged, as the run ends here: {left}"));
    }
}

fn trace(run: &Run) -> Result<Trace, String> {
    let Some(path) = &run.recording else { return Ok(Trace::default()) };
    let bytes = std::fs::read(path).map_err(|e| crate::ini::plain(&e).to_string())?;
    let trace = vcd::read(&bytes).whole().map_err(|(_, flaw)| format!("the recording: {flaw}"))?;
    match trace.lost() {
        0 => Ok(trace),
        lost => Err(format!("the recording is not whole: {lost} changes were lost")),
    }
}

/// The recording, and the times of the instants.
pub(super) struct Record<'r> {
    pub(super) trace: &'r Trace,
    run: &'r Run,
}

impl Record<'_> {
    /// Writes a time relative to the start.
    pub(super) fn told(&self, time: i64) -> String {
        let start = self.run.reached.get(START).copied().unwrap_or(0);
        let text = duration(time.saturating_sub(start).unsigned_abs());
        if time < start { format!("{text} before the start") } else { text }
    }

    fn instant(&self, moment: &Instant, spot: &Spot) -> Result<i64, Complaint> {
        let time = moment.on(&self.run.reached);
        time.ok_or_else(|| Complaint::new(spot, "its moment was not reached"))
    }

    fn window(&self, from: &Instant, to: &Instant, spot: &Spot) -> Result<(i64, i64), Complaint> {
        let (from, to) = (self.instant(from, spot)?, self.instant(to, spot)?);
        if from < to {
            return Ok((from, to));
        }
        let text = "its part of the run is empty";
        let times = format!("from {} to {}", self.told(from), self.told(to));
        Err(Complaint::new(spot, text).with(times))
    }

    pub(super) fn channel(&self, named: &Named) -> Result<usize, Complaint> {
        self.trace.find(&named.name).ok_or_else(|| {
            let text = format!("'{}' was not recorded", named.name);
            let why = "it was not there when the clock first moved";
            Complaint::new(&named.spot, text).with(why)
        })
    }

    /// Returns whether the run has reached an instant.
    fn is_over(&self, instant: &Instant) -> bool {
        let Some((failed, _)) = self.run.failed else { return true };
        instant.on(&self.run.reached).is_some_and(|time| time <= failed)
    }

    /// Evaluates an expectation as far as the run came; returns `None` if the run ended before that can be said.
    fn so_far(&self, e: &Expectation) -> Option<Result<(), Complaint>> {
        let result = match &e.what {
            Requirement::Message(_) | Requirement::NoMessage(_) => self.evaluate(e),
            Requirement::Value { at: Some(at), .. } => {
                return self.is_over(at).then(|| self.evaluate(e));
            }
            _ if self.is_over(&e.to) => return Some(self.evaluate(e)),
            Requirement::Always { .. } | Requirement::Never { .. } | Requirement::Value { .. } => {
                let (failed, _) = self.run.failed.as_ref()?;
                let from = e.from.on(&self.run.reached).filter(|from| from < failed)?;
                self.evaluate_in(e, from, *failed)
            }
            _ => return None,
        };
        // Until its end, only one of both answers is final.
        let is_final = self.run.failed.is_none()
            || result.is_err() != matches!(e.what, Requirement::Message(_));
        is_final.then_some(result)
    }

    fn evaluate(&self, e: &Expectation) -> Result<(), Complaint> {
        let spot = &e.spot;
        match &e.what {
            Requirement::Message(text) => return self.message(text, true),
            Requirement::NoMessage(text) => return self.message(text, false),
            Requirement::Value { of, at: Some(at), bounds } => {
                let time = self.instant(at, spot)?;
                let found = self.trace.at(self.channel(of)?, time);
                return self.value(spot, &of.name, bounds, time, found);
            }
            _ => {}
        }
        let (from, to) = self.window(&e.from, &e.to, spot)?;
        self.evaluate_in(e, from, to)
    }

    /// Evaluates an expectation about a part of the run.
    fn evaluate_in(&self, e: &Expectation, from: i64, to: i64) -> Result<(), Complaint> {
        let spot = &e.spot;
        match &e.what {
            Requirement::Value { of, bounds, .. } => {
                let channel = self.channel(of)?;
                let times = self.times(from, to);
                times.into_iter().try_for_each(|t| {
                    self.value(spot, &of.name, bounds, t, self.trace.at(channel, t))
                })
            }
            Requirement::Always { holds, when } => {
                self.holds(spot, holds, when.as_ref(), (from, to), true)
            }
            Requirement::Never { holds, when } => {
                self.holds(spot, holds, when.as_ref(), (from, to), false)
            }
            Requirement::Happens { event, least, most } => {
                let times = self.events(event, from, to)?;
                let n = times.len() as u64;
                if *least <= n && n <= *most {
                    return Ok(());
                }
                let wanted = match (least, most) {
                    (a, b) if a == b => often(*a),
                    (a, &u64::MAX) => format!("{} or more", often(*a)),
                    (0, b) => format!("{} at most", often(*b)),
                    (a, b) => format!("{a} to {b} times"),
                };
                let name = &event.named.name;
                let text = match n {
                    0 => format!("'{name}' never happens"),
                    n => format!("'{name}' happens {}", often(n)),
                };
                let complaint = Complaint::new(spot, text).with(format!("expected: {wanted}"));
                Err(match self.list(&times) {
                    list if list.is_empty() => complaint,
                    list => complaint.with(format!("found:    at {list}")),
                })
            }
            Requirement::Order(events) => self.order(spot, events, from, to),
            Requirement::Between { first, then, time } => {
                let (firsts, thens) = (self.events(first, from, to)?, self.events(then, from, to)?);
                pulses::between(self, spot, (first, &firsts), (then, &thens), *time)
            }
            Requirement::Pulses(wanted) => pulses::evaluate(self, spot, wanted, from, to),
            Requirement::Motor { step, direction, bounds } => {
                let found = pulses::steps(self, step, direction, from, to)?;
                let found = Value::S64(found);
                if compare::within(spot, "motor", bounds, found)? {
                    return Ok(());
                }
                let text = format!("the motor comes {} steps far", compare::shown(found));
                Err(Complaint::new(spot, text)
                    .with(format!("expected: {}", compare::bounds(bounds, found)))
                    .with(format!("found:    {}", compare::shown(found))))
            }
            Requirement::Message(_) | Requirement::NoMessage(_) => Ok(()),
        }
    }

    fn message(&self, text: &Named, wanted: bool) -> Result<(), Complaint> {
        let said = &self.run.said;
        let found: Vec<_> = said.iter().filter(|(_, s)| s.contains(&text.name)).collect();
        if wanted != found.is_empty() {
            return Ok(());
        }
        if let Some((time, said)) = found.first() {
            let complaint = Complaint::new(&text.spot, "this is said, and should not be");
            return Err(complaint.with(format!("at {}: {said}", self.told(*time))));
        }
        let complaint = Complaint::new(&text.spot, "this is never said");
        let complaint = complaint.with(format!("expected: {}", text.name));
        Err(said.iter().fold(complaint, |complaint, (time, said)| {
            complaint.with(format!("said at {}: {said}", self.told(*time)))
        }))
    }

    fn value(
        &self,
        spot: &Spot,
        name: &str,
        bounds: &super::expectation::Bounds,
        time: i64,
        found: Option<Value>,
    ) -> Result<(), Complaint> {
        let Some(found) = found else {
            let text = format!("'{name}' is not known at {}", self.told(time));
            return Err(Complaint::new(spot, text));
        };
        if compare::within(spot, name, bounds, found)? {
            return Ok(());
        }
        let text = format!("'{name}' is {} at {}", compare::shown(found), self.told(time));
        Err(Complaint::new(spot, text)
            .with(format!("expected: {}", compare::bounds(bounds, found)))
            .with(format!("found:    {}", compare::shown(found))))
    }

    /// Returns the beginning of a part of the run and the times of the samples in it.
    pub(super) fn times(&self, from: i64, to: i64) -> Vec<i64> {
        let times = self.trace.times();
        let inside = times.from(from.saturating_add(1))..times.from(to);
        [from].into_iter().chain(inside.filter_map(|n| times.get(n))).collect()
    }

    /// Evaluates a condition sample by sample. The sample before `from` is evaluated too, so that
    /// edges at `from` are found.
    fn truths(
        &self,
        condition: &Condition,
        from: i64,
        to: i64,
    ) -> Result<Vec<(i64, bool)>, Complaint> {
        let names = condition.names();
        let channels = names.iter().map(|n| self.channel(n)).collect::<Result<Vec<_>, _>>()?;
        let all = self.trace.channels();
        let types: Vec<_> = channels.iter().filter_map(|c| all.get(*c)).map(Channel::ty).collect();
        let mut looking = condition.begin(&types)?;
        let mut look = |time: i64| {
            let values: Vec<_> = channels.iter().map(|c| self.trace.at(*c, time)).collect();
            (time, looking.look(&values))
        };
        look(from.saturating_sub(1));
        Ok(self.times(from, to).into_iter().map(look).collect())
    }

    /// Returns the times at which a condition becomes true.
    pub(super) fn events(
        &self,
        event: &Condition,
        from: i64,
        to: i64,
    ) -> Result<Vec<i64>, Complaint> {
        let mut held = false;
        let truths = self.truths(event, from, to)?.into_iter();
        Ok(truths
            .filter(|(_, now)| !core::mem::replace(&mut held, *now) && *now)
            .map(|(time, _)| time)
            .collect())
    }

    fn holds(
        &self,
        spot: &Spot,
        holds: &Condition,
        when: Option<&Condition>,
        (from, to): (i64, i64),
        wanted: bool,
    ) -> Result<(), Complaint> {
        let truths = self.truths(holds, from, to)?;
        let whens = when.map(|w| self.truths(w, from, to)).transpose()?;
        let counts = |n: usize| whens.as_ref().is_none_or(|w| w.get(n).is_some_and(|(_, t)| *t));
        let is_cut = self.run.failed.as_ref().is_some_and(|(failed, _)| to == *failed);
        if whens.is_some() && !is_cut && !(0..truths.len()).any(counts) {
            let name = when.map_or("", |w| w.named.name.as_str());
            let text = format!("'{name}' is never true: nothing was checked");
            return Err(Complaint::new(spot, text));
        }
        let bad = truths.iter().enumerate().find(|(n, (_, is))| *is != wanted && counts(*n));
        let Some((_, (time, _))) = bad else { return Ok(()) };
        let not = if wanted { "not so" } else { "so" };
        let text = format!("'{}' is {not} at {}", holds.named.name, self.told(*time));
        let rule = if wanted { "always" } else { "never" };
        let part = when.map_or_else(String::new, |w| format!(" while {}", w.named.name));
        let complaint =
            Complaint::new(spot, text).with(format!("expected: {rule} {}{part}", holds.named.name));
        Err(holds.names().iter().fold(complaint, |complaint, name| {
            let name = &name.name;
            let value = self.trace.find(name).and_then(|c| self.trace.at(c, *time));
            let value = value.map_or_else(|| "not known".to_owned(), compare::shown);
            complaint.with(format!("found:    {name} is {value}"))
        }))
    }

    fn order(
        &self,
        spot: &Spot,
        events: &[Condition],
        from: i64,
        to: i64,
    ) -> Result<(), Complaint> {
        let mut after = from.saturating_sub(1);
        let mut before: Option<&Condition> = None;
        for event in events {
            let times = self.events(event, from, to)?;
            let Some(time) = times.iter().find(|t| **t > after) else {
                let name = &event.named.name;
                let complaint = match before {
                    None => Complaint::new(spot, format!("'{name}' never happens")),
                    Some(b) => {
                        let (b, at) = (&b.named.name, self.told(after));
                        let text =
                            format!("'{name}' does not happen after '{b}', which is at {at}");
                        Complaint::new(spot, text)
                    }
                };
                let order: Vec<&str> = events.iter().map(|e| e.named.name.as_str()).collect();
                let complaint = complaint.with(format!("expected: {}", order.join(", then ")));
                return Err(match self.list(&times) {
                    list if list.is_empty() => complaint,
                    list => complaint.with(format!("found:    '{name}' at {list}")),
                });
            };
            (after, before) = (*time, Some(event));
        }
        Ok(())
    }

    /// Writes the first eight times.
    fn list(&self, times: &[i64]) -> String {
        let told: Vec<String> = times.iter().take(8).map(|t| self.told(*t)).collect();
        let more = if times.len() > 8 { ", …" } else { "" };
        told.join(", ") + more
    }
}

/// Writes a number of times in words.
fn often(n: u64) -> String {
    match n {
        0 => "never".to_owned(),
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{n} times"),
    }
}
