//! Number and names of the channels of a component that is created once.

use crate::{Builder, Error};

/// Rules for the channels of a component, selected by `num_chan=`, `names=`, or neither.
#[derive(Clone, Copy, Debug)]
pub struct Channels {
    /// Name of numbered channels, without the number.
    pub prefix: &'static str,
    /// Number of channels if the arguments give none or 0.
    pub usual: usize,
    /// Maximum number of channels.
    pub most: usize,
    /// Text before the number in an error message.
    pub wrong: &'static str,
}

impl Channels {
    /// Returns the names of the channels that the arguments request. An empty name ends the list,
    /// as in LinuxCNC.
    ///
    /// # Errors
    /// There are too many channels, or both arguments are given.
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
