//! Conditions: texts in the language of the scope's triggers.

use super::{outcome::Complaint, test::Named};
use hal_protocol::{Type, Value};
use hal_trace::trigger::{self, ConditionError, When};

/// A condition, and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Condition {
    pub(super) named: Named,
    read: trigger::Condition,
}

impl Condition {
    /// Reads it.
    pub(super) fn parse(named: Named) -> Result<Self, Complaint> {
        match trigger::Condition::parse(&named.name) {
            Ok(read) => Ok(Self { named, read }),
            Err(error) => Err(wrong(&named, &error)),
        }
    }

    /// The names in it.
    pub(super) fn names(&self) -> Vec<Named> {
        let named = |name: &&str| Named { spot: self.named.spot.clone(), name: (*name).to_owned() };
        self.read.names().iter().map(named).collect()
    }

    /// Looks from here on; the types are those of its names.
    pub(super) fn begin(&self, types: &[Type]) -> Result<Looking, Complaint> {
        let names = self.read.names().into_iter().map(str::to_owned);
        let channels: Vec<_> = names.zip(types.iter().copied()).collect();
        let when = self.read.bind(&channels).map_err(|error| wrong(&self.named, &error))?;
        Ok(Looking { when, before: None })
    }
}

/// A condition that is looked at, sample by sample.
#[derive(Debug)]
pub(super) struct Looking {
    when: When,
    before: Option<Vec<u64>>,
}

impl Looking {
    /// Whether it holds at this sample; the values are those of its names.
    pub(super) fn look(&mut self, values: &[Option<Value>]) -> bool {
        let now: Option<Vec<u64>> = values.iter().map(|v| v.map(|v| v.bits())).collect();
        let holds = now.as_ref().is_some_and(|now| self.when.holds(self.before.as_deref(), now));
        self.before = now;
        holds
    }
}

/// What is wrong, with a mark under the word.
fn wrong(named: &Named, error: &ConditionError) -> Complaint {
    let (at, length) = error.place();
    let letters = |bytes: usize| named.name.get(..bytes).map_or(0, |t| t.chars().count());
    let (from, to) = (letters(at), letters(at + length));
    let marks = "^".repeat(to.saturating_sub(from).max(1));
    Complaint::new(&named.spot, error.why())
        .with(named.name.replace(char::is_control, " "))
        .with(format!("{}{marks}", " ".repeat(from)))
}
