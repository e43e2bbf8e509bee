//! The socket for readers of the screen.

use crate::lcd_reader::ScreenRecord;
use hal_component::{Builder, Error, Messages, SnapshotReader, Touch, Work};
use hal_handheld::ScreenReader;
use std::{
    io::{ErrorKind, Write as _},
    os::unix::{
        fs::FileTypeExt as _,
        net::{UnixListener, UnixStream},
    },
    path::Path,
    sync::{Arc, Mutex, PoisonError},
};

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 5_000_000;
/// Largest number of readers of the socket, and of the command `lcd.read`.
pub(crate) const READERS: usize = 16;

/// Opens the socket. One that a process has left behind is replaced.
///
/// # Errors
/// The path is something else, another process serves it, or it cannot be made.
pub(crate) fn open(path: &str) -> Result<UnixListener, Error> {
    let fail = |e: std::io::Error| Error::new(format!("socket {path}: {e}"));
    if let Ok(found) = std::fs::symlink_metadata(path) {
        if !found.file_type().is_socket() {
            return Err(Error::new(format!("socket {path}: there is something else of this name")));
        }
        if UnixStream::connect(path).is_ok() {
            return Err(Error::new(format!("socket {path}: another process serves it")));
        }
        std::fs::remove_file(path).map_err(fail)?;
    }
    let listener = UnixListener::bind(path).map_err(fail)?;
    listener.set_nonblocking(true).map_err(fail)?;
    Ok(listener)
}

/// Declares the worker of the socket. It is opened with the machine, never while hardware is simulated.
///
/// # Errors
/// The name is taken.
pub(crate) fn declare(
    b: &mut Builder<'_>,
    path: String,
    latest: SnapshotReader<ScreenRecord>,
) -> Result<(), Error> {
    if path.is_empty() || b.is_simulated() {
        return Ok(());
    }
    let opened = Arc::new(Mutex::new(None));
    let slot = opened.clone();
    let socket = path.clone();
    b.on_open(move |_| {
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(open(&socket)?);
        Ok(())
    })?;
    let server = Server {
        opened,
        listener: None,
        path,
        readers: Vec::new(),
        latest,
        messages: b.messages(),
    };
    b.worker("lcd.readers", "Serves readers at the socket.", PERIOD_NS, 32, server)
}

/// Connection of a reader.
struct Connection {
    stream: UnixStream,
    reader: ScreenReader,
}

/// Worker of the socket.
#[derive(Touch)]
struct Server {
    #[state]
    opened: Arc<Mutex<Option<UnixListener>>>,
    #[state]
    listener: Option<UnixListener>,
    #[state]
    path: String,
    #[state]
    readers: Vec<Connection>,
    latest: SnapshotReader<ScreenRecord>,
    messages: Messages,
}

impl Work for Server {
    fn work(&mut self, _: u32) -> u32 {
        if let Some(listener) = self.opened.lock().unwrap_or_else(PoisonError::into_inner).take() {
            self.listener = Some(listener);
        }
        self.accept();
        let Some(record) = self.latest.get().filter(|record| record.number() > 0) else { return 0 };
        let text = record.text();
        self.readers.retain_mut(|Connection { stream, reader }| {
            let bytes = reader.next(&text, record.number());
            if bytes.is_empty() {
                return true;
            }
            match stream.write(bytes) {
                Ok(sent) => {
                    reader.took(sent);
                    true
                }
                Err(e) => e.kind() == ErrorKind::WouldBlock,
            }
        });
        0
    }
}

impl Server {
    fn accept(&mut self) {
        while let Some(Ok((stream, _))) = self.listener.as_ref().map(UnixListener::accept) {
            if self.readers.len() >= READERS {
                // Those that have gone are noticed when a screen is sent to them.
                self.messages.warn(
                    "{} readers are connected already: another is refused",
                    &[READERS as f64],
                );
            } else if stream.set_nonblocking(true).is_ok() {
                self.readers.push(Connection { stream, reader: ScreenReader::default() });
            }
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        if self.listener.is_some() {
            // The next one replaces it where this fails.
            drop(std::fs::remove_file(Path::new(&self.path)));
        }
    }
}
