//! Lists in which every index has a value.

/// A value for each index.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ByIndex<T>(Vec<T>);

impl<T: Copy + Default> ByIndex<T> {
    /// Makes a list of `n` equal values.
    pub(super) fn of(n: usize, value: T) -> Self {
        Self(vec![value; n])
    }

    /// Returns the value at an index, or the default outside the list.
    pub(super) fn at(&self, i: usize) -> T {
        self.0.get(i).copied().unwrap_or_default()
    }

    /// Sets the value at an index. Does nothing outside the list.
    pub(super) fn set(&mut self, i: usize, value: T) {
        if let Some(place) = self.0.get_mut(i) {
            *place = value;
        }
    }
}

impl<T> FromIterator<T> for ByIndex<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}
