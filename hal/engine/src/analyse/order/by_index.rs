//! Lists that return a value for every index, for graph algorithms that never panic.

/// A value for each index.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ByIndex<T>(Vec<T>);

impl<T: Copy + Default> ByIndex<T> {
    /// Returns a row of `n` equal values.
    pub(crate) fn of(n: usize, value: T) -> Self {
        Self(vec![value; n])
    }

    /// Returns the value at an index, or the default if the index is out of range.
    pub(crate) fn at(&self, i: usize) -> T {
        self.0.get(i).copied().unwrap_or_default()
    }

    /// Sets the value at an index. Ignores an index out of range.
    pub(crate) fn set(&mut self, i: usize, value: T) {
        if let Some(place) = self.0.get_mut(i) {
            *place = value;
        }
    }
}

impl ByIndex<usize> {
    /// Returns the position of each number in `order`. Numbers are below `n`.
    pub(crate) fn places(order: &[usize], n: usize) -> Self {
        let mut row = Self::of(n, 0);
        order.iter().enumerate().for_each(|(place, i)| row.set(*i, place));
        row
    }
}

/// A list for each index.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists(Vec<Vec<usize>>);

impl Lists {
    /// Sorts `items` into lists by the index of each.
    pub(crate) fn sort(n: usize, items: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut lists = vec![Vec::new(); n];
        for (of, item) in items {
            if let Some(list) = lists.get_mut(of) {
                list.push(item);
            }
        }
        Self(lists)
    }

    /// Returns the list at an index.
    pub(crate) fn at(&self, i: usize) -> &[usize] {
        self.0.get(i).map_or(&[], Vec::as_slice)
    }

    /// Applies `change` to every list.
    pub(crate) fn each(&mut self, mut change: impl FnMut(&mut Vec<usize>)) {
        self.0.iter_mut().for_each(&mut change);
    }
}
