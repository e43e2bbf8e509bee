//! How many channels there are, and what they are called.

use hal_component::Error;

/// The most channels.
const MOST: usize = 8;

/// What a component says of a number of channels that it does not have.
pub(crate) struct Words {
    /// What numbered channels are called.
    pub(crate) prefix: &'static str,
    /// Before the number in an error.
    pub(crate) wrong: &'static str,
    /// How many there are if nobody says.
    pub(crate) usual: usize,
}

impl Words {
    /// The names of the channels that `num_chan=` or `names=` asks for.
    pub(crate) fn names(
        &self,
        count: Option<i64>,
        given: Vec<String>,
    ) -> Result<Vec<String>, Error> {
        let count = count.unwrap_or(0);
        let named: Vec<String> = given.into_iter().take_while(|n| !n.is_empty()).collect();
        let numbered = |n: usize| (0..n).map(|i| format!("{}.{i}", self.prefix)).collect();
        match (named.len(), usize::try_from(count)) {
            (0, Ok(0)) => Ok(numbered(self.usual)),
            (0, Ok(n @ 1..=MOST)) => Ok(numbered(n)),
            (1..=MOST, Ok(0)) => Ok(named),
            (1.., Ok(1..) | Err(_)) => {
                Err(Error::new("num_chan= and names= are mutually exclusive"))
            }
            (0, _) => Err(Error::new(format!("{} {count}", self.wrong))),
            (n, _) => Err(Error::new(format!("{} {n}", self.wrong))),
        }
    }
}
