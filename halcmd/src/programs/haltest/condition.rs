//! Conditions, in the language of the scope's triggers.

use super::{outcome::Complaint, test::Named};
use hal_protocol::{Type, Value};
use hal_trace::trigger::{self, ConditionError, When};

/// A condition with its location in the test's file.
#[derive(Clone, Debug)]
pub(super) struct Condition {
    pub(super) named: Named,
    read: trigger::Condition,
}

impl Condition {
    /// Parses a condition.
    pub(super) fn parse(named: Named) -> Result<Self, Complaint> {
        match trigger::Condition::parse(&named.name) {
            Ok(read) => Ok(Self { named, read }),
            Err(error) => Err(wrong(&named, &error)),
        }
    }

    /// Returns the names that the condition uses.
    pub(super) fn names(&self) -> Vec<Named> {
        let named = |name: &&str| Named { spot: self.named.spot.clone(), name: (*name).to_owned() };
        self.read.names().iter().map(named).collect()
    }

    /// Starts evaluating the condition. `types` are the types of its names, in order.
    pub(super) fn begin(&self, types: &[Type]) -> Result<Looking, Complaint> {
        let names = self.read.names().into_iter().map(str::to_owned);
        let channels: Vec<_> = names.zip(types.iter().copied()).collect();
        let when = self.read.bind(&channels).map_err(|error| wrong(&self.named, &error))?;
        Ok(Looking { when, before: None })
    }
}

/// A condition that is evaluated sample by sample.
#[derive(Debug)]
pub(super) struct Looking {
    when: When,
    before: Option<Vec<u64>>,
}

impl Looking {
    /// Returns whether the condition holds at this sample. `values` are the values of its names, in
    /// order.
    pub(super) fn look(&mut self, values: &[Option<Value>]) -> bool {
        let now: Option<Vec<u64>> = values.iter().map(|v| v.map(|v| v.bits())).collect();
        let holds = now.as_ref().is_some_and(|now| self.when.holds(self.before.as_deref(), now));
        self.before = now;
        holds
    }
}

/// Returns the error with a mark under the wrong word.
fn wrong(named: &Named, error: &ConditionError) -> Complaint {
    let (at, length) = error.place();
    let letters = |bytes: usize| named.name.get(..bytes).map_or(0, |t| t.chars().count());
    let (from, to) = (letters(at), letters(at + length));
    let marks = "^".repeat(to.saturating_sub(from).max(1));
    Complaint::new(&named.spot, error.why())
        .with(named.name.replace(char::is_control, " "))
        .with(format!("{}{marks}", " ".repeat(from)))
}
