//! Lists by number that have an answer for every number: graph algorithms without a panic.

/// A value for each number.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Row<T>(Vec<T>);

impl<T: Copy + Default> Row<T> {
    /// `n` times the same.
    pub(crate) fn of(n: usize, value: T) -> Self {
        Self(vec![value; n])
    }

    /// The value of a number; of one that is not here, the default.
    pub(crate) fn at(&self, i: usize) -> T {
        self.0.get(i).copied().unwrap_or_default()
    }

    /// Sets the value of a number.
    pub(crate) fn set(&mut self, i: usize, value: T) {
        if let Some(place) = self.0.get_mut(i) {
            *place = value;
        }
    }
}

impl Row<usize> {
    /// Where each number of a list stands in it; numbers go up to `n`.
    pub(crate) fn places(order: &[usize], n: usize) -> Self {
        let mut row = Self::of(n, 0);
        order.iter().enumerate().for_each(|(place, i)| row.set(*i, place));
        row
    }
}

/// A list for each number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists(Vec<Vec<usize>>);

impl Lists {
    /// Sorts `items` into the list of the number that each belongs to.
    pub(crate) fn sort(n: usize, items: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut lists = vec![Vec::new(); n];
        for (of, item) in items {
            if let Some(list) = lists.get_mut(of) {
                list.push(item);
            }
        }
        Self(lists)
    }

    /// The list of a number.
    pub(crate) fn at(&self, i: usize) -> &[usize] {
        self.0.get(i).map_or(&[], Vec::as_slice)
    }

    /// Changes every list.
    pub(crate) fn each(&mut self, mut change: impl FnMut(&mut Vec<usize>)) {
        self.0.iter_mut().for_each(&mut change);
    }
}
