//! Moments of a test: `start`, `end` or a mark, with a time before or after it.

use super::{
    outcome::{Complaint, Spot},
    source::TIMES,
};
use crate::{language::hint::nearest, nanoseconds};
use std::collections::BTreeMap;

/// The moment at which the script is done and the steps begin.
pub(super) const START: &str = "start";
/// The moment at which the last step is done.
pub(super) const END: &str = "end";

/// A moment of the test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Instant {
    spot: Spot,
    base: String,
    offset: i64,
}

impl Instant {
    pub(super) fn start(spot: &Spot) -> Self {
        Self { spot: spot.clone(), base: START.to_owned(), offset: 0 }
    }

    pub(super) fn end(spot: &Spot) -> Self {
        Self { spot: spot.clone(), base: END.to_owned(), offset: 0 }
    }

    /// Parses `20ms`, `turn`, `turn + 20ms`, `end - 1s`.
    pub(super) fn parse(text: &str, spot: &Spot) -> Result<Self, Complaint> {
        let wrong = |what: &str| {
            Complaint::new(spot, format!("'{what}' is not a time"))
                .with(TIMES)
                .with("a moment is a time after the start, a mark, or a mark + or - a time")
        };
        let signed = |sign: &'static str| {
            text.split_once(sign).map(|(base, time)| (base.trim(), time.trim(), sign))
        };
        // The name of a mark may contain '-', so a sign has spaces around it.
        let (base, time, sign) = match signed(" + ").or_else(|| signed(" - ")) {
            Some(parts) => parts,
            None if text.trim().starts_with(|c: char| c.is_ascii_digit()) => {
                (START, text.trim(), " + ")
            }
            None => (text.trim(), "0ns", " + "),
        };
        let ns = nanoseconds(time).map_err(|_| wrong(time))?;
        let ns = i64::try_from(ns).map_err(|_| wrong(time))?;
        let offset = if sign == " - " { -ns } else { ns };
        Ok(Self { spot: spot.clone(), base: base.to_owned(), offset })
    }

    /// Returns an error if the test has no such mark.
    pub(super) fn unknown(&self, marks: &[&str]) -> Option<Complaint> {
        let known = [START, END];
        if known.contains(&&*self.base) || marks.contains(&&*self.base) {
            return None;
        }
        let near = nearest(&self.base, marks.iter().chain(&known).copied());
        let complaint = Complaint::new(&self.spot, format!("no step has the mark '{}'", self.base));
        Some(match near {
            Some(near) => complaint.near(Some(near)),
            None => complaint.with(format!("the marks are start, end{}", listed(marks))),
        })
    }

    /// Returns the machine time of the moment, if its mark was reached.
    pub(super) fn on(&self, reached: &BTreeMap<String, i64>) -> Option<i64> {
        reached.get(&self.base).map(|t| t.saturating_add(self.offset))
    }
}

fn listed(marks: &[&str]) -> String {
    marks.iter().fold(String::new(), |text, mark| text + ", " + mark)
}
