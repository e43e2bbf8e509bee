//! Number and names of the channels of a component that is created once.

use crate::{Builder, Error};

/// Rules for the channels of a component, selected by `num_chan=`, `names=`, or neither.
#[derive(Clone, Copy, Debug)]
pub struct Channels {
    /// Name of numbered channels, without the number.
    pub prefix: &'static str,
    /// Number of channels if the arguments give none or 0.
    pub usual: usize,
}

impl Channels {
    /// Returns the names of the channels that the arguments request. An empty name ends the list,
    /// as in LinuxCNC.
    ///
    /// # Errors
    /// Both arguments are given.
    pub fn names(&self, b: &Builder<'_>) -> Result<Vec<String>, Error> {
        let count = b.arg_int("num_chan").unwrap_or(0);
        let named: Vec<String> =
            b.arg_texts("names").into_iter().take_while(|n| !n.is_empty()).collect();
        let numbered = |n: usize| (0..n).map(|i| format!("{}.{i}", self.prefix)).collect();
        // The declarations of the arguments limit both numbers.
        match (named.is_empty(), usize::try_from(count).unwrap_or(0)) {
            (true, 0) => Ok(numbered(self.usual)),
            (true, n) => Ok(numbered(n)),
            (false, 0) => Ok(named),
            (false, _) => Err(Error::new("num_chan= and names= are mutually exclusive")),
        }
    }
}
