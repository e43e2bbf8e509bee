//! How many channels a component has that is created once, and what they are called.

use crate::{Builder, Error};

/// What a component says of the number of its channels: `num_chan=`, or `names=`, or neither.
#[derive(Clone, Copy, Debug)]
pub struct Channels {
    /// What numbered channels are called.
    pub prefix: &'static str,
    /// How many there are if nobody says, or says 0.
    pub usual: usize,
    /// The most.
    pub most: usize,
    /// What comes before the number in a refusal.
    pub wrong: &'static str,
}

impl Channels {
    /// The names of the channels that the arguments ask for; an empty one ends the list, as in
    /// LinuxCNC.
    ///
    /// # Errors
    /// There are too many, or both arguments are given.
    pub fn names(&self, b: &Builder<'_>) -> Result<Vec<String>, Error> {
        let count = b.arg_int("num_chan").unwrap_or(0);
        let named: Vec<String> =
            b.arg_texts("names").into_iter().take_while(|n| !n.is_empty()).collect();
        let numbered = |n: usize| (0..n).map(|i| format!("{}.{i}", self.prefix)).collect();
        let fits = |n: usize| (1..=self.most).contains(&n);
        match (named.len(), usize::try_from(count)) {
            (0, Ok(0)) => Ok(numbered(self.usual)),
            (0, Ok(n)) if fits(n) => Ok(numbered(n)),
            (n, Ok(0)) if fits(n) => Ok(named),
            (1.., Ok(1..) | Err(_)) => {
                Err(Error::new("num_chan= and names= are mutually exclusive"))
            }
            (0, _) => Err(Error::new(format!("{} {count}", self.wrong))),
            (n, _) => Err(Error::new(format!("{} {n}", self.wrong))),
        }
    }
}
