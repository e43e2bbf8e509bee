//! Lines over TCP.

use super::{Carrier, NotOpened, timespec};
use core::time::Duration;
use port::{Exchange, Lost};
use rustix::{
    event::{PollFd, PollFlags, poll},
    io::Errno,
    net::{RecvFlags, SendFlags, recv, send},
};
use std::net::{TcpStream, ToSocketAddrs as _};

/// Longest time for a connection.
const CONNECT: Duration = Duration::from_millis(500);

/// A device, or a gateway to several, in the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TcpPlace {
    /// Address or name.
    pub(crate) host: String,
    pub(crate) port: u16,
}

impl TcpPlace {
    /// Connects.
    pub(crate) fn open(&self) -> Result<TcpLine, NotOpened> {
        let name = || format!("{}:{}", self.host, self.port);
        let refused = |error: &std::io::Error| {
            NotOpened::new(name(), Errno::from_io_error(error).unwrap_or(Errno::HOSTUNREACH))
        };
        let mut all = (self.host.as_str(), self.port).to_socket_addrs().map_err(|e| refused(&e))?;
        let address = all.next().ok_or_else(|| NotOpened::new(name(), Errno::HOSTUNREACH))?;
        let stream = TcpStream::connect_timeout(&address, CONNECT).map_err(|e| refused(&e))?;
        stream.set_nodelay(true).map_err(|e| refused(&e))?;
        stream.set_nonblocking(true).map_err(|e| refused(&e))?;
        Ok(TcpLine { stream })
    }
}

/// Connection over TCP.
#[derive(Debug)]
pub(crate) struct TcpLine {
    stream: TcpStream,
}

impl TcpLine {
    fn take(&self, into: &mut [u8]) -> Result<usize, Lost> {
        match recv(&self.stream, into, RecvFlags::DONTWAIT) {
            Ok((_, 0)) => Err(Lost(Errno::CONNRESET.raw_os_error())),
            Ok((_, count)) => Ok(count),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }
}

impl Exchange for TcpLine {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        match send(&self.stream, packet, SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
            Ok(count) if count == packet.len() => Ok(()),
            // A part of a frame would join the next one.
            Ok(_) | Err(Errno::AGAIN) => Err(Lost(Errno::NOBUFS.raw_os_error())),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }

    fn receive(&self, into: &mut [u8], within: Duration) -> Result<usize, Lost> {
        let count = self.take(into)?;
        if count != 0 || within.is_zero() {
            return Ok(count);
        }
        match poll(&mut [PollFd::new(&self.stream, PollFlags::IN)], Some(&timespec(within))) {
            Ok(0) | Err(Errno::INTR) => Ok(0),
            Ok(_) => self.take(into),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }
}

impl Carrier for TcpLine {}
