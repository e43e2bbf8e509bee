//! The other end of the terminal: a serial line, or a connection over TCP.

use rustix::{
    fs::{Mode, OFlags},
    io::Errno,
    termios::{ControlModes, OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr},
};
use std::{
    fs::File,
    io::{self, Read, Write},
    path::Path,
    time::Duration,
};

/// Longest time for a connection.
const CONNECT: Duration = Duration::from_secs(30);

/// A connection, once for each direction.
pub(crate) struct Device {
    pub(crate) from: Box<dyn Read + Send>,
    pub(crate) to: Box<dyn Write + Send>,
}

/// Connects to `HOST:PORT`.
pub(crate) fn connect(to: &str) -> Result<Device, String> {
    let stream = robot::connect(to, CONNECT)?;
    let far = stream.try_clone().map_err(|e| format!("{to}: {}", hal_output::reason(&e)))?;
    Ok(Device { from: Box::new(far), to: Box::new(stream) })
}

/// Opens a serial line: 8 data bits, no parity, 1 stop bit, no flow control.
pub(crate) fn open(path: &Path, baud: u32) -> Result<Device, String> {
    let name = path.display();
    let refused = |e: Errno| format!("{name}: {}", hal_output::reason(&io::Error::from(e)));
    // Without NONBLOCK, the open would wait for a carrier.
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let file = rustix::fs::open(path, flags, Mode::empty()).map_err(refused)?;
    let mut settings = tcgetattr(&file).map_err(|e| match e {
        Errno::NOTTY => format!("{name}: this is no serial line"),
        other => refused(other),
    })?;
    settings.make_raw();
    settings.control_modes -= ControlModes::CRTSCTS | ControlModes::CSTOPB | ControlModes::PARENB;
    settings.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
    settings.set_speed(baud).map_err(|_| format!("{name}: {baud} Bd is no speed of the line"))?;
    tcsetattr(&file, OptionalActions::Now, &settings).map_err(refused)?;
    tcflush(&file, QueueSelector::IFlush).map_err(refused)?;
    rustix::fs::fcntl_setfl(&file, OFlags::empty()).map_err(refused)?;
    let file = File::from(file);
    let far = file.try_clone().map_err(|e| format!("{name}: {}", hal_output::reason(&e)))?;
    Ok(Device { from: Box::new(far), to: Box::new(file) })
}
