//! Serial lines: terminals of Linux, as bytes without interpretation.

use super::{Carrier, timespec};
use core::{fmt, time::Duration};
use hal_modbus::char_ns;
use port::{Exchange, Lost};
use rustix::{
    event::{PollFd, PollFlags, poll},
    fd::OwnedFd,
    fs::{Mode, OFlags, open},
    io::{Errno, read, write},
    termios::{
        ControlModes, OptionalActions, QueueSelector, SpecialCodeIndex, ioctl_tiocexcl, tcflush,
        tcgetattr, tcsetattr,
    },
};

/// Parity bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Parity {
    /// None.
    None,
    /// Even.
    Even,
    /// Odd.
    Odd,
}

impl Parity {
    /// Returns the parity with this name.
    pub(crate) fn of(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "none" => Some(Self::None),
            "even" => Some(Self::Even),
            "odd" => Some(Self::Odd),
            _ => None,
        }
    }
}

/// Rates that serial lines have, in bits per second.
pub(crate) const RATES: &[u32] = &[
    110, 300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115_200, 230_400, 460_800, 921_600,
];

/// A serial line and its settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SerialPlace {
    /// Device file.
    pub(crate) path: String,
    /// Bits per second.
    pub(crate) rate: u32,
    /// Data bits, 5 to 8.
    pub(crate) bits: u8,
    pub(crate) parity: Parity,
    /// Stop bits, 1 or 2.
    pub(crate) stops: u8,
}

/// Reason why a line cannot be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NotOpened {
    path: String,
    errno: Errno,
}

impl NotOpened {
    pub(crate) const fn new(path: String, errno: Errno) -> Self {
        Self { path, errno }
    }
}

impl fmt::Display for NotOpened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let remedy = match self.errno {
            Errno::NOENT | Errno::NODEV | Errno::NXIO => {
                ": is the adapter plugged in? ls /dev/serial/by-id shows those that are"
            }
            Errno::ACCESS | Errno::PERM => {
                ": add your user to the group of the device, usually dialout, and log in again"
            }
            Errno::BUSY => ": another program uses it",
            Errno::CONNREFUSED => ": nobody accepts there: is the port right?",
            Errno::HOSTUNREACH | Errno::NETUNREACH | Errno::TIMEDOUT => {
                ": check the address, and the cable"
            }
            Errno::NOTTY => ": it is no serial line",
            _ => "",
        };
        let reason = std::io::Error::from(self.errno);
        write!(f, "{}: {reason}{remedy}", self.path)
    }
}

impl SerialPlace {
    /// Returns the time of one character, in nanoseconds.
    pub(crate) const fn char_ns(&self) -> i64 {
        char_ns(self.rate, self.char_bits())
    }

    /// Returns the bits of one character: start, data, parity, stop.
    pub(crate) const fn char_bits(&self) -> u8 {
        let parity = if matches!(self.parity, Parity::None) { 0 } else { 1 };
        1 + self.bits + parity + self.stops
    }

    /// Opens the line for this program alone. What has come before is discarded.
    pub(crate) fn open(&self) -> Result<SerialLine, NotOpened> {
        self.open_with().map_err(|errno| NotOpened { path: self.path.clone(), errno })
    }

    fn open_with(&self) -> Result<SerialLine, Errno> {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let line = open(&self.path, flags, Mode::empty())?;
        let mut settings = tcgetattr(&line)?;
        ioctl_tiocexcl(&line)?;
        settings.make_raw();
        let modes = &mut settings.control_modes;
        modes.remove(
            ControlModes::CSIZE
                | ControlModes::PARENB
                | ControlModes::PARODD
                | ControlModes::CSTOPB
                | ControlModes::CRTSCTS,
        );
        modes.insert(ControlModes::CREAD | ControlModes::CLOCAL);
        modes.insert(match self.bits {
            5 => ControlModes::CS5,
            6 => ControlModes::CS6,
            7 => ControlModes::CS7,
            _ => ControlModes::CS8,
        });
        modes.insert(match self.parity {
            Parity::None => ControlModes::empty(),
            Parity::Even => ControlModes::PARENB,
            Parity::Odd => ControlModes::PARENB | ControlModes::PARODD,
        });
        if self.stops == 2 {
            modes.insert(ControlModes::CSTOPB);
        }
        // With one byte at least, 0 bytes say that the line is gone, and not that nothing has come.
        settings.special_codes[SpecialCodeIndex::VMIN] = 1;
        settings.special_codes[SpecialCodeIndex::VTIME] = 0;
        settings.set_speed(self.rate)?;
        tcsetattr(&line, OptionalActions::Now, &settings)?;
        tcflush(&line, QueueSelector::IOFlush)?;
        Ok(SerialLine { line })
    }
}

/// Open serial line. A call makes one system call that does not wait; a reception with time, at most three.
#[derive(Debug)]
pub(crate) struct SerialLine {
    line: OwnedFd,
}

impl SerialLine {
    fn take(&self, into: &mut [u8]) -> Result<usize, Lost> {
        match read(&self.line, into) {
            Ok(0) => Err(Lost::GONE),
            Ok(count) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }
}

impl Exchange for SerialLine {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        // A part of a frame is none: the device does not answer, and the frame is sent again.
        match write(&self.line, packet) {
            Ok(_) | Err(Errno::AGAIN | Errno::INTR) => Ok(()),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }

    fn receive(&self, into: &mut [u8], within: Duration) -> Result<usize, Lost> {
        let count = self.take(into)?;
        if count != 0 || within.is_zero() {
            return Ok(count);
        }
        match poll(&mut [PollFd::new(&self.line, PollFlags::IN)], Some(&timespec(within))) {
            Ok(0) | Err(Errno::INTR) => Ok(0),
            Ok(_) => self.take(into),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }
}

impl Carrier for SerialLine {}
