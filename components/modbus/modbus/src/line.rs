//! Lines: serial, over TCP, and simulated.

mod serial;
mod simulated;
mod tcp;

pub(crate) use serial::{NotOpened, Parity, RATES, SerialPlace};
pub(crate) use simulated::{SimulatedFaultPins, SimulatedLine};
pub(crate) use tcp::TcpPlace;

use core::{fmt, time::Duration};
use port::{Exchange, Lost};
use rustix::event::{Timespec, poll};

/// Line on which somebody other than its worker can have the last word.
pub(crate) trait Carrier: Exchange {
    /// Realtime. Sends a frame at this moment of machine time. Allocates nothing and takes no lock on a real line: one system call,
    /// which does not wait.
    fn send_now(&self, frame: &[u8], _now_ns: i64) -> Result<(), Lost> {
        self.send(frame)
    }

    /// Has the line send a frame so much later than `now_ns`, the machine's time. Returns whether the line can do that by itself.
    fn send_later(&self, _frame: &[u8], _wait: Duration, _now_ns: i64) -> bool {
        false
    }
}

/// Open line, whatever it is.
pub(crate) struct OpenLine(Box<dyn Carrier>);

impl fmt::Debug for OpenLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("OpenLine")
    }
}

impl OpenLine {
    pub(crate) fn new(line: impl Carrier + 'static) -> Self {
        Self(Box::new(line))
    }

    /// Realtime. Sends a frame at this moment of machine time.
    pub(crate) fn send_now(&self, frame: &[u8], now_ns: i64) -> Result<(), Lost> {
        self.0.send_now(frame, now_ns)
    }

    /// Has a simulated line send a frame so much later. Returns whether it is one.
    pub(crate) fn send_later(&self, frame: &[u8], wait: Duration, now_ns: i64) -> bool {
        self.0.send_later(frame, wait, now_ns)
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

/// Returns whether a text may be a part of the name of a pin.
pub(crate) fn is_name(text: &str) -> bool {
    let usual = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    !text.is_empty() && text.chars().all(usual)
}

/// Waits. Allocates nothing and takes no lock.
pub(crate) fn pause(time: Duration) {
    let _ = poll(&mut [], Some(&timespec(time)));
}

fn timespec(time: Duration) -> Timespec {
    Timespec {
        tv_sec: i64::try_from(time.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: i64::from(time.subsec_nanos()),
    }
}
