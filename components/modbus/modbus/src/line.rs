//! Lines: serial, over TCP, and simulated.

mod serial;
mod simulated;
mod tcp;

pub(crate) use serial::{NotOpened, Parity, RATES, SerialPlace};
pub(crate) use simulated::{SimulatedFaultPins, SimulatedLine};
pub(crate) use tcp::TcpPlace;

use core::{fmt, time::Duration};
use port::{Exchange, Lost};

/// Time in which the end of an answer passes, and the silence behind it.
pub(crate) const PAUSE: Duration = Duration::from_millis(40);

/// Line on which somebody other than its worker can have the last word.
pub(crate) trait Carrier: Exchange {
    /// Sends a frame after [`PAUSE`], so that the device hears it whatever was under way.
    fn send_last(&self, frame: &[u8]) -> Result<(), Lost>;
}

/// Open line, whatever it is.
pub(crate) struct OpenLine(Box<dyn Carrier>);

impl fmt::Debug for OpenLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Way")
    }
}

impl OpenLine {
    pub(crate) fn new(line: impl Carrier + 'static) -> Self {
        Self(Box::new(line))
    }

    /// Sends a frame after [`PAUSE`].
    pub(crate) fn send_last(&self, frame: &[u8]) -> Result<(), Lost> {
        self.0.send_last(frame)
    }
}

impl Exchange for OpenLine {
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

/// Place of a line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LinePlace {
    Serial(SerialPlace),
    Tcp(TcpPlace),
}

impl LinePlace {
    /// Returns whether both mean the same line, with whatever settings.
    pub(crate) fn is_same_line(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Serial(a), Self::Serial(b)) => a.path == b.path,
            (a, b) => a == b,
        }
    }

    /// Opens the line.
    pub(crate) fn open(&self) -> Result<OpenLine, NotOpened> {
        match self {
            Self::Serial(place) => place.open().map(OpenLine::new),
            Self::Tcp(place) => place.open().map(OpenLine::new),
        }
    }
}

impl fmt::Display for LinePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(place) => f.write_str(&place.path),
            Self::Tcp(place) => write!(f, "{}:{}", place.host, place.port),
        }
    }
}

/// Returns whether a text may be the path of a device.
pub(crate) fn is_path(text: &str) -> bool {
    text.starts_with('/') && text.len() <= 255 && !text.chars().any(char::is_control)
}
