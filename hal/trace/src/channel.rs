//! A channel: a name, a type, and the changes of its value.

use hal_protocol::{Type, Value};

/// New value of a channel, valid from a sample on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// Number of the sample.
    pub sample: usize,
    /// New value, or `None` if it is unknown.
    pub value: Option<Value>,
}

/// Recorded changes of one pin, signal or parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    names: Vec<String>,
    ty: Type,
    samples: Vec<u32>,
    bits: Vec<u64>,
    /// Indices of the changes to an unknown value.
    unknown: Vec<u32>,
}

/// Returns the canonical form of a cell's bits that a trace stores (all NaNs are the same).
pub(crate) fn plain(ty: Type, bits: u64) -> u64 {
    match Value::from_bits(ty, bits) {
        Value::Float(f) if f.is_nan() => f64::NAN.to_bits(),
        value => value.bits(),
    }
}

impl Channel {
    pub(crate) fn new(name: &str, ty: Type) -> Self {
        let names = vec![name.to_owned()];
        Self { names, ty, samples: Vec::new(), bits: Vec::new(), unknown: Vec::new() }
    }

    /// Returns the first name.
    #[must_use]
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// Returns all names of the channel, for example those of a signal and of its pins.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the type.
    #[must_use]
    pub const fn ty(&self) -> Type {
        self.ty
    }

    /// Returns the value at a sample.
    #[must_use]
    pub fn value(&self, sample: usize) -> Option<Value> {
        let after = self.samples.partition_point(|s| *s as usize <= sample);
        self.change(after.checked_sub(1)?)?.value
    }

    /// Returns the number of changes, including the initial value.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.samples.len()
    }

    /// Returns whether the channel has no changes, so that no value is known.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// Returns the change with this index.
    #[must_use]
    pub fn change(&self, number: usize) -> Option<Change> {
        let sample = *self.samples.get(number)? as usize;
        let bits = *self.bits.get(number)?;
        let known = u32::try_from(number).is_ok_and(|n| self.unknown.binary_search(&n).is_err());
        Some(Change { sample, value: known.then(|| Value::from_bits(self.ty, bits)) })
    }

    /// Returns all changes in order. The first one is the initial value.
    pub fn changes(&self) -> impl DoubleEndedIterator<Item = Change> + '_ {
        (0..self.len()).filter_map(|n| self.change(n))
    }

    /// Returns the number of changes at samples before this one.
    #[must_use]
    pub fn changes_before(&self, sample: usize) -> usize {
        self.samples.partition_point(|s| (*s as usize) < sample)
    }

    /// Adds another name.
    pub(crate) fn also(&mut self, name: &str) {
        self.names.push(name.to_owned());
    }

    /// Sets the value from this sample on. `sample` must not be before the last change.
    pub(crate) fn set(&mut self, sample: u32, bits: Option<u64>) {
        let plain = bits.map(|b| plain(self.ty, b));
        if self.samples.last() == Some(&sample) {
            self.samples.pop();
            self.bits.pop();
            if self.unknown.last().is_some_and(|n| *n as usize == self.samples.len()) {
                self.unknown.pop();
            }
        }
        if plain == self.last() {
            return;
        }
        if plain.is_none() {
            self.unknown.push(u32::try_from(self.samples.len()).unwrap_or(u32::MAX));
        }
        self.samples.push(sample);
        self.bits.push(plain.unwrap_or(0));
    }

    fn last(&self) -> Option<u64> {
        let number = self.len().checked_sub(1)?;
        let unknown = self.unknown.last().is_some_and(|n| *n as usize == number);
        if unknown { None } else { self.bits.last().copied() }
    }
}
