//! Lines: serial, and simulated.

mod serial;
mod simulated;

pub(crate) use serial::{NotOpened, Parity, RATES, SerialPlace};
pub(crate) use simulated::{SimulatedFaultPins, SimulatedLine};

use core::{fmt, time::Duration};
use port::{Exchange, Lost};

/// Time in which the end of an answer passes, and the silence behind it.
pub(crate) const PAUSE: Duration = Duration::from_millis(40);

/// Line on which somebody other than its worker can have the last word.
pub(crate) trait Line: Exchange {
    /// Sends a frame after [`PAUSE`], so that the device hears it whatever was under way.
    fn send_last(&self, frame: &[u8]) -> Result<(), Lost>;
}

/// Open line, whatever it is.
pub(crate) struct Way(Box<dyn Line>);

impl fmt::Debug for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Way")
    }
}

impl Way {
    pub(crate) fn new(line: impl Line + 'static) -> Self {
        Self(Box::new(line))
    }

    /// Sends a frame after [`PAUSE`].
    pub(crate) fn send_last(&self, frame: &[u8]) -> Result<(), Lost> {
        self.0.send_last(frame)
    }
}

impl Exchange for Way {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        self.0.send(packet)
    }

    fn receive(&self, into: &mut [u8], within: Duration) -> Result<usize, Lost> {
        self.0.receive(into, within)
    }

    fn advance(&self, now_ns: i64) {
        self.0.advance(now_ns);
    }
}
