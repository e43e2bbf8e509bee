//! Serial lines and other character devices: a worker passes their bytes to a function, and the function's bytes to them.

use hal_component::{Builder, Error, Messages, Plain, Port, RingReader, RingWriter, Touch, Work};
use rustix::{
    fs::{Mode, OFlags},
    termios::{OptionalActions, tcgetattr, tcsetattr},
};
use std::{
    fs::File,
    io::{ErrorKind, Read as _, Write as _},
    sync::{Arc, Mutex, PoisonError},
};

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 2_000_000;
/// Number of bytes that wait in each direction.
const ROOM: usize = 4096;
/// Number of bytes that are read at once.
const CHUNK: usize = 1024;

/// Byte on its way.
#[derive(Clone, Copy, Plain)]
pub(crate) struct OneByte {
    /// The byte.
    value: u32,
}

/// The function's end of a device.
#[derive(Touch)]
pub(crate) struct DeviceLine {
    from: RingReader<OneByte>,
    to: RingWriter<OneByte>,
}

impl DeviceLine {
    /// Realtime. Takes bytes that have arrived; returns their number.
    pub(crate) fn read(&mut self, into: &mut [u8]) -> usize {
        let mut count = 0;
        for free in into {
            let Some(byte) = self.from.take() else { break };
            *free = u8::try_from(byte.value).unwrap_or(0);
            count += 1;
        }
        count
    }

    /// Realtime. Sends bytes; those for which there is no room are lost.
    pub(crate) fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if self.to.put(OneByte { value: u32::from(*byte) }).is_err() {
                break;
            }
        }
    }
}

/// Realtime. Takes bytes that wait in a port; returns their number.
pub(crate) fn read_port(port: Port, into: &mut [u8]) -> usize {
    let waiting = usize::try_from(port.readable()).unwrap_or(0).min(into.len());
    let free = into.get_mut(..waiting).unwrap_or_default();
    if waiting > 0 && port.read(free) { waiting } else { 0 }
}

/// Opens a device that is not waited for. A serial line passes bytes as they are, at `baud`.
///
/// # Errors
/// The device cannot be opened, or the line has no such speed.
pub(crate) fn open(path: &str, baud: u32) -> Result<File, Error> {
    let fail =
        |e: rustix::io::Errno| Error::new(format!("device {path}: {}", std::io::Error::from(e)));
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let opened = rustix::fs::open(path, flags, Mode::empty());
    // A device may permit reading alone.
    let opened = opened.or_else(|e| match e {
        rustix::io::Errno::ACCESS | rustix::io::Errno::PERM => {
            let flags = OFlags::RDONLY | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
            rustix::fs::open(path, flags, Mode::empty())
        }
        other => Err(other),
    });
    let file = File::from(opened.map_err(fail)?);
    match tcgetattr(&file) {
        Ok(mut settings) => {
            settings.make_raw();
            settings.set_speed(baud).map_err(fail)?;
            tcsetattr(&file, OptionalActions::Now, &settings).map_err(fail)?;
        }
        // No terminal: a pipe, or a driver's own device.
        Err(rustix::io::Errno::NOTTY) => {}
        Err(e) => return Err(fail(e)),
    }
    Ok(file)
}

/// Declares the worker `NAME` of a device; the function gets the other end. The device is opened with the machine, never in a
/// dry run and never while hardware is simulated.
///
/// # Errors
/// The name is taken.
pub(crate) fn declare(
    b: &mut Builder<'_>,
    name: &str,
    path: String,
    baud: u32,
) -> Result<Option<DeviceLine>, Error> {
    if path.is_empty() || b.is_simulated() {
        return Ok(None);
    }
    let opened = Arc::new(Mutex::new(None));
    let slot = opened.clone();
    b.on_open(move |_| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(open(&path, baud)?);
        Ok(())
    })?;
    let (in_writer, in_reader) = b.ring(ROOM);
    let (out_writer, out_reader) = b.ring(ROOM);
    let pump = Pump {
        opened,
        device: None,
        to: in_writer,
        from: out_reader,
        unsent: Vec::new(),
        messages: b.messages(),
    };
    b.worker(name, "Passes bytes from and to the device.", PERIOD_NS, 64, pump)?;
    Ok(Some(DeviceLine { from: in_reader, to: out_writer }))
}

/// Worker of a device.
#[derive(Touch)]
struct Pump {
    #[state]
    opened: Arc<Mutex<Option<File>>>,
    #[state]
    device: Option<File>,
    to: RingWriter<OneByte>,
    from: RingReader<OneByte>,
    #[state]
    unsent: Vec<u8>,
    messages: Messages,
}

impl Work for Pump {
    fn work(&mut self, items: u32) -> u32 {
        if let Some(file) = self.opened.lock().unwrap_or_else(PoisonError::into_inner).take() {
            self.device = Some(file);
        }
        let Some(mut device) = self.device.take() else { return 0 };
        let mut done = 0;
        while done < items {
            match self.exchange(&mut device) {
                Ok(0) => break,
                Ok(_) => done += 1,
                Err(_) => {
                    self.messages
                        .error("a device has failed: no byte passes from or to it any more", &[]);
                    return 0;
                }
            }
        }
        self.device = Some(device);
        done
    }
}

impl Pump {
    /// Passes what there is in both directions; returns the number of bytes.
    fn exchange(&mut self, device: &mut File) -> std::io::Result<usize> {
        let mut buffer = [0; CHUNK];
        let room = ROOM.saturating_sub(usize::try_from(self.to.waiting()).unwrap_or(ROOM));
        let most = room.min(CHUNK);
        // Bytes for which there is no room stay in the device.
        let read = match device.read(buffer.get_mut(..most).unwrap_or_default()) {
            Ok(read) => read,
            // A terminal whose other end is closed.
            Err(e) if e.kind() == ErrorKind::WouldBlock || e.raw_os_error() == Some(5) => 0,
            Err(e) => return Err(e),
        };
        for byte in buffer.iter().take(read) {
            if self.to.put(OneByte { value: u32::from(*byte) }).is_err() {
                break;
            }
        }
        while self.unsent.len() < CHUNK
            && let Some(byte) = self.from.take()
        {
            self.unsent.push(u8::try_from(byte.value).unwrap_or(0));
        }
        if self.unsent.is_empty() {
            return Ok(read);
        }
        match device.write(&self.unsent) {
            Ok(sent) => {
                self.unsent.drain(..sent);
                Ok(read + sent)
            }
            Err(e) if e.kind() == ErrorKind::WouldBlock || e.raw_os_error() == Some(5) => Ok(read),
            Err(e) => Err(e),
        }
    }
}
