//! Lists by number that have an answer for every number.

/// A value for each number.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Row<T>(Vec<T>);

impl<T: Copy + Default> Row<T> {
    /// `n` times the same.
    pub(super) fn of(n: usize, value: T) -> Self {
        Self(vec![value; n])
    }

    /// The value of a number; of one that is not here, the default.
    pub(super) fn at(&self, i: usize) -> T {
        self.0.get(i).copied().unwrap_or_default()
    }

    /// Sets the value of a number.
    pub(super) fn set(&mut self, i: usize, value: T) {
        if let Some(place) = self.0.get_mut(i) {
            *place = value;
        }
    }
}

impl<T> FromIterator<T> for Row<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}
