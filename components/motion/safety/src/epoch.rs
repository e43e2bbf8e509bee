//! The stop epoch, by which orders from before a stop are refused.

/// Numbers of stops and pauses so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Epoch {
    /// E-stops, switches to off, aborts and faults; never 0 in an epoch that is in force.
    pub stops: u32,
    /// Pauses.
    pub pauses: u32,
}

/// Stops after which an order that was given before them is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// No stop: the order is never too late.
    Never,
    /// E-stop, off, abort and faults.
    Stops,
    /// E-stop, off, abort, faults and a pause.
    Pauses,
}

impl Epoch {
    /// Returns whether an order that was given in this epoch comes too late in the epoch `now`.
    #[must_use]
    pub const fn is_too_old(self, ends: Ends, now: Self) -> bool {
        match ends {
            Ends::Never => false,
            Ends::Stops => self.stops != now.stops,
            Ends::Pauses => self.stops != now.stops || self.pauses != now.pauses,
        }
    }
}
