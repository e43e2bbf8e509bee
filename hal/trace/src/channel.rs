//! One channel: a name, a type, and how its value changed.

use hal_protocol::{Type, Value};

/// A value from a sample on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The number of the sample.
    pub sample: usize,
    /// What it became; nothing where it is not known.
    pub value: Option<Value>,
}

/// What was seen of one pin, signal or parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    names: Vec<String>,
    ty: Type,
    samples: Vec<u32>,
    bits: Vec<u64>,
    /// Which of the changes are to a value that is not known.
    unknown: Vec<u32>,
}

/// What a cell holds, in the one form in which a trace keeps it.
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

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// Its name, and other names of the same: a signal and the pins that it joins.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Its type.
    #[must_use]
    pub const fn ty(&self) -> Type {
        self.ty
    }

    /// Its value at a sample.
    #[must_use]
    pub fn value(&self, sample: usize) -> Option<Value> {
        let after = self.samples.partition_point(|s| *s as usize <= sample);
        self.change(after.checked_sub(1)?)?.value
    }

    /// How often it changed, what it was at first included.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether nothing is known of it.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// One of its changes.
    #[must_use]
    pub fn change(&self, number: usize) -> Option<Change> {
        let sample = *self.samples.get(number)? as usize;
        let bits = *self.bits.get(number)?;
        let known = u32::try_from(number).is_ok_and(|n| self.unknown.binary_search(&n).is_err());
        Some(Change { sample, value: known.then(|| Value::from_bits(self.ty, bits)) })
    }

    /// All changes in order; the first is what it was.
    pub fn changes(&self) -> impl DoubleEndedIterator<Item = Change> + '_ {
        (0..self.len()).filter_map(|n| self.change(n))
    }

    /// How many changes were at samples before this one.
    #[must_use]
    pub fn changes_before(&self, sample: usize) -> usize {
        self.samples.partition_point(|s| (*s as usize) < sample)
    }

    /// Another name for it.
    pub(crate) fn also(&mut self, name: &str) {
        self.names.push(name.to_owned());
    }

    /// What it is from this sample on, which is none before its last change.
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
