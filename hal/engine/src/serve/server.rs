//! The socket and its connections.

use crate::{
    Error, ends, os,
    serve::client::{Client, Rights, WaitState},
};
use hal_protocol::{Folder, FolderError, Place, peer};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::{
    fs::File,
    os::unix::net::{UnixListener, UnixStream},
};

/// Largest number of clients at once.
const MAX_CLIENTS: usize = 256;

/// The socket and its clients.
#[derive(Debug)]
pub(crate) struct Server {
    listener: UnixListener,
    place: Place,
    folder: Folder,
    #[expect(dead_code, reason = "locked as long as the instance lives")]
    lock: File,
    pub(super) clients: Vec<Client>,
    next: u64,
}

impl Server {
    /// Takes the socket of an instance, even if a former owner has died and left it behind.
    pub(crate) fn open(place: &Place) -> Result<Self, FolderError> {
        let folder = Folder::make(place)?;
        let lock = folder.lock(place)?;
        let listener = folder.listen(place)?;
        Ok(Self { listener, place: place.clone(), folder, lock, clients: Vec::new(), next: 1 })
    }

    /// Ends every connection: programs notice it and exit.
    pub(crate) fn drop_clients(&mut self) {
        self.clients.clear();
    }

    /// Returns for how many of these milliseconds to wait for input: until a client's wait is over,
    /// and not at all if a request is already there.
    pub(super) fn wait_ms(&mut self, ms: i32) -> i32 {
        let (now, mut ms) = (os::monotonic_ns(), ms);
        for c in &mut self.clients {
            if c.is_served() && c.has_line() {
                ms = 0;
            }
            if let WaitState::Wall(t) = c.waits {
                let left = i32::try_from((t - now) / 1_000_000 + 1).unwrap_or(i32::MAX);
                ms = ms.min(left.max(0));
            }
        }
        ms
    }

    /// Waits at most `ms` milliseconds for input or space for output, then reads, writes and
    /// accepts connections.
    pub(super) fn transfer(&mut self, ms: i32) {
        let mut fds = vec![PollFd::new(&self.listener, PollFlags::IN)];
        for c in &self.clients {
            let mut flags = PollFlags::empty();
            flags.set(PollFlags::IN, c.listens());
            flags.set(PollFlags::OUT, c.has_output());
            fds.push(PollFd::new(&c.socket, flags));
        }
        let wake = ends::wake();
        fds.extend(wake.iter().map(|wake| PollFd::new(wake, PollFlags::IN)));
        let ready = wait(&mut fds, ms).unwrap_or(false);
        let events: Vec<PollFlags> = fds.iter().map(PollFd::revents).collect();
        drop(fds);
        if !ready {
            return;
        }
        for (c, e) in self.clients.iter_mut().zip(events.iter().skip(1)) {
            c.hung |= e.intersects(PollFlags::HUP | PollFlags::ERR);
            if c.has_output() && (c.hung || e.contains(PollFlags::OUT)) {
                c.write();
            } else if c.hung || e.contains(PollFlags::IN) {
                c.read();
            }
        }
        self.accept();
    }

    fn accept(&mut self) {
        while let Ok((socket, _)) = self.listener.accept() {
            if self.clients.len() >= MAX_CLIENTS || socket.set_nonblocking(true).is_err() {
                continue;
            }
            let mut client = Client::new(self.next, socket);
            match admitted(&client.socket, &self.folder) {
                Ok(rights) => client.rights = rights,
                Err(refusal) => {
                    client.closing = true;
                    client.answer(Err(refusal.into()));
                    continue;
                }
            }
            self.clients.push(client);
            self.next += 1;
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.folder.remove(&self.place);
    }
}

/// Checks that the user at the other end may use this instance: its own user, or root; as a guest everybody else whom
/// the kernel lets through to the socket of a system service.
fn admitted(socket: &UnixStream, folder: &Folder) -> Result<Rights, Error> {
    let me = rustix::process::geteuid().as_raw();
    let peer = peer(socket).map_err(|e| Error::System {
        what: "the user of this program cannot be found out",
        why: os::said(&e),
    })?;
    if peer == me || peer == 0 {
        return Ok(Rights::Own);
    }
    if folder.lets_in_a_group() {
        return Ok(Rights::Guest);
    }
    let why = format!(
        "this instance belongs to user {me}, and is used by that user and root; this program runs \
         as user {peer}"
    );
    Err(Error::Protocol { why: why.into() })
}

/// Waits at most `ms` milliseconds.
pub(super) fn wait_only(ms: i32) {
    if ms > 0 {
        drop(wait(&mut [], ms));
    }
}

fn wait(fds: &mut [PollFd<'_>], ms: i32) -> std::io::Result<bool> {
    let ms = i64::from(ms);
    let limit = Timespec { tv_sec: ms / 1000, tv_nsec: ms % 1000 * 1_000_000 };
    Ok(poll(fds, Some(&limit))? > 0)
}
