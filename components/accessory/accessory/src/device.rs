//! Serial lines and other character devices: a worker passes their bytes to a function, and the function's bytes to them.

use crate::packed;
use hal_component::{
    Builder, Clock, Error, Messages, Plain, Port, RingReader, RingWriter, SeqReader, SeqWriter,
    Touch, Work,
};
use hal_handheld::frame::MOST_BYTES;
use rustix::{
    fs::{Mode, OFlags},
    io::Errno,
    termios::{
        ControlModes, OptionalActions, QueueSelector, isatty, tcflush, tcgetattr, tcsetattr,
    },
};
use std::{
    fs::File,
    io::{ErrorKind, Read as _, Write as _},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicI64, Ordering},
    },
};

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 2_000_000;
/// Number of bytes that wait for the function.
const ROOM: usize = 4096;
/// Number of bytes that are read at once.
const CHUNK: usize = 1024;

/// Time after which a failure of a device is reported, and between two attempts to open it again, in nanoseconds.
const FAILED_NS: i64 = 1_000_000_000;

/// Byte on its way to the function.
#[derive(Clone, Copy, Plain)]
pub(crate) struct ByteAt {
    /// The byte.
    value: u32,
    /// Machine time at which it was read, in nanoseconds.
    at: i64,
}

/// Latest frame for the device.
#[derive(Clone, Copy, Default, Plain)]
struct LatestFrame {
    /// Number of the frame, from 1.
    number: u64,
    /// Number of its bytes.
    len: u64,
    /// The bytes, the first one in the lowest byte.
    bytes: [u64; MOST_BYTES / 8],
}

/// The function's end of a device.
#[derive(Touch)]
pub(crate) struct DeviceLine {
    from: RingReader<ByteAt>,
    to: SeqWriter<LatestFrame>,
    #[state]
    number: u64,
    /// Machine time of the last look at which no byte was left, in nanoseconds.
    #[state]
    empty: Arc<AtomicI64>,
}

impl DeviceLine {
    /// Realtime. Takes bytes that were read at this time or later, and throws older ones away; returns their number.
    pub(crate) fn read_since(&mut self, oldest: i64, into: &mut [u8]) -> usize {
        let mut count = 0;
        for _ in 0..ROOM {
            let Some(free) = into.get_mut(count) else { break };
            let Some(byte) = self.from.take() else { break };
            if byte.at >= oldest {
                *free = u8::try_from(byte.value).unwrap_or(0);
                count += 1;
            }
        }
        count
    }

    /// Realtime. Takes a byte, with the machine time at which it was read.
    pub(crate) fn take(&mut self) -> Option<(u8, i64)> {
        self.from.take().map(|byte| (u8::try_from(byte.value).unwrap_or(0), byte.at))
    }

    /// Realtime. Returns the machine time of the last look at which no byte was left in the device. The bytes that were read
    /// before it can be taken.
    pub(crate) fn empty_at(&self) -> i64 {
        self.empty.load(Ordering::Acquire) // Pairs with the store in `Pump::work`.
    }

    /// Realtime. Sends a frame of at most 16 bytes, instead of those before that have not left yet.
    pub(crate) fn write(&mut self, frame: &[u8]) {
        self.number = self.number.wrapping_add(1);
        let len = frame.len().min(MOST_BYTES) as u64;
        self.to.set(&LatestFrame { number: self.number, len, bytes: packed::words(frame) });
    }
}

/// Realtime. Takes bytes that wait in a port; returns their number.
pub(crate) fn read_port(port: Port, into: &mut [u8]) -> usize {
    let waiting = usize::try_from(port.readable()).unwrap_or(0).min(into.len());
    let free = into.get_mut(..waiting).unwrap_or_default();
    if waiting > 0 && port.read(free) { waiting } else { 0 }
}

/// Opens a device that is not waited for. A serial line passes bytes as they are, at `baud`, whatever its other wires say;
/// what has arrived before is thrown away.
///
/// # Errors
/// The device cannot be opened, or the line has no such speed.
pub(crate) fn open(path: &str, baud: u32) -> Result<File, Error> {
    let fail = |e: Errno| Error::new(format!("device {path}: {}", std::io::Error::from(e)));
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let opened = rustix::fs::open(path, flags, Mode::empty());
    // A device may permit reading alone.
    let opened = opened.or_else(|e| match e {
        Errno::ACCESS | Errno::PERM => {
            let flags = OFlags::RDONLY | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
            rustix::fs::open(path, flags, Mode::empty())
        }
        other => Err(other),
    });
    let file = File::from(opened.map_err(fail)?);
    match tcgetattr(&file) {
        Ok(mut settings) => {
            settings.make_raw();
            settings.control_modes -= ControlModes::CRTSCTS | ControlModes::CSTOPB;
            settings.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
            settings.set_speed(baud).map_err(fail)?;
            tcsetattr(&file, OptionalActions::Now, &settings).map_err(fail)?;
            tcflush(&file, QueueSelector::IOFlush).map_err(fail)?;
        }
        // No terminal: a pipe, or a driver's own device.
        Err(Errno::NOTTY) => {}
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
    let again = path.clone();
    b.on_open(move |_| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(open(&path, baud)?);
        Ok(())
    })?;
    let (in_writer, in_reader) = b.ring(ROOM);
    let (out_writer, out_reader) = b.seqlock(LatestFrame::default());
    let empty = Arc::new(AtomicI64::new(0));
    let pump = Pump {
        opened,
        device: None,
        path: again,
        baud,
        to: in_writer,
        from: out_reader,
        number: 0,
        unsent: Vec::new(),
        tried: None,
        is_reported: false,
        empty: empty.clone(),
        clock: b.clock(),
        messages: b.messages(),
    };
    b.worker(name, "Passes bytes from and to the device.", PERIOD_NS, 64, pump)?;
    Ok(Some(DeviceLine { from: in_reader, to: out_writer, number: 0, empty }))
}

/// Worker of a device.
#[derive(Touch)]
struct Pump {
    #[state]
    opened: Arc<Mutex<Option<File>>>,
    #[state]
    device: Option<File>,
    #[state]
    path: String,
    #[state]
    baud: u32,
    to: RingWriter<ByteAt>,
    from: SeqReader<LatestFrame>,
    /// Number of the last frame that was begun.
    #[state]
    number: u64,
    /// Rest of that frame.
    #[state]
    unsent: Vec<u8>,
    /// Machine time at which the device began to fail, and then of the last attempt to open it again; `None` while it works.
    #[state]
    tried: Option<i64>,
    /// The failure was reported.
    #[state]
    is_reported: bool,
    #[state]
    empty: Arc<AtomicI64>,
    clock: Clock,
    messages: Messages,
}

/// Result of a look at a device.
enum Exchange {
    /// Bytes have passed.
    Passed,
    /// No byte is in the device, and none waits for it.
    Nothing,
    /// Bytes wait in the device for room.
    Full,
}

impl Work for Pump {
    fn work(&mut self, items: u32) -> u32 {
        if let Some(file) = self.opened.lock().unwrap_or_else(PoisonError::into_inner).take() {
            self.device = Some(file);
        }
        let Some(mut device) = self.device.take() else { return 0 };
        let mut done = 0;
        while done < items {
            let now = self.clock.now_ns();
            match self.exchange(&mut device, now) {
                Ok(Exchange::Passed) => {
                    self.works();
                    done += 1;
                }
                Ok(Exchange::Nothing) => {
                    self.works();
                    // Pairs with the load in `empty_at`: what was read before can be taken.
                    self.empty.store(now, Ordering::Release);
                    break;
                }
                Ok(Exchange::Full) => break,
                Err(_) => {
                    if let Some(file) = self.try_again(now) {
                        device = file;
                    }
                    break;
                }
            }
        }
        self.device = Some(device);
        done
    }
}

impl Pump {
    /// Notes that the device works.
    fn works(&mut self) {
        self.tried = None;
        if std::mem::take(&mut self.is_reported) {
            self.messages.warn("a device that had failed passes bytes again", &[]);
        }
    }

    /// Opens a device that fails again, if it can be, a while after the failure or the last attempt. The first attempt reports
    /// the failure.
    fn try_again(&mut self, now: i64) -> Option<File> {
        let since = *self.tried.get_or_insert(now);
        if now.saturating_sub(since) < FAILED_NS {
            return None;
        }
        if !self.is_reported {
            self.is_reported = true;
            self.messages.error(
                "a device has failed, and no byte passes from or to it: it is opened again as soon as it is there",
                &[],
            );
        }
        self.tried = Some(now);
        let file = open(&self.path, self.baud).ok()?;
        self.unsent.clear();
        Some(file)
    }

    /// Passes what there is in both directions.
    fn exchange(&mut self, device: &mut File, now: i64) -> std::io::Result<Exchange> {
        let mut buffer = [0; CHUNK];
        let room = ROOM.saturating_sub(usize::try_from(self.to.waiting()).unwrap_or(ROOM));
        let most = room.min(CHUNK);
        // Bytes for which there is no room stay in the device.
        let read = match device.read(buffer.get_mut(..most).unwrap_or_default()) {
            // A terminal whose hardware or other end has gone.
            Ok(0) if most > 0 && isatty(&*device) => return Err(Errno::IO.into()),
            Ok(read) => read,
            Err(e) if e.kind() == ErrorKind::WouldBlock => 0,
            Err(e) => return Err(e),
        };
        for byte in buffer.iter().take(read) {
            if self.to.put(ByteAt { value: u32::from(*byte), at: now }).is_err() {
                break;
            }
        }
        let sent = self.send(device)?;
        Ok(match (read, sent) {
            (0, 0) if most > 0 => Exchange::Nothing,
            (0, 0) => Exchange::Full,
            _ => Exchange::Passed,
        })
    }

    /// Sends the rest of a frame, or else the latest frame; returns the number of bytes.
    fn send(&mut self, device: &mut File) -> std::io::Result<usize> {
        let latest = self.from.get();
        if self.unsent.is_empty() && latest.number != self.number {
            self.number = latest.number;
            let bytes = packed::bytes(&latest.bytes);
            self.unsent.extend(bytes.take(usize::try_from(latest.len).unwrap_or(0)));
        }
        if self.unsent.is_empty() {
            return Ok(0);
        }
        match device.write(&self.unsent) {
            Ok(sent) => {
                self.unsent.drain(..sent);
                Ok(sent)
            }
            Err(e) if e.kind() == ErrorKind::WouldBlock => {
                // The line does not move: what waits in it is old by the time it does.
                let _: Result<(), Errno> = tcflush(&*device, QueueSelector::OFlush);
                self.unsent.clear();
                Ok(0)
            }
            Err(e) => Err(e),
        }
    }
}
