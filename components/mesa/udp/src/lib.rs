//! Packets over UDP with a deadline.
//!
//! A [`UdpLine`] is connected to one address, so that the system discards packets of others. After it is open, nothing
//! allocates, and each call makes only the system calls of this table:
//!
//! | call | system calls | longest wait |
//! |---|---|---|
//! | [`Exchange::send`] | one `sendto` that does not wait | none |
//! | [`Exchange::receive`] | one `recvfrom` that does not wait; if nothing is there, one `ppoll` and one more `recvfrom` | the stated time |
#![forbid(unsafe_code)]

use core::time::Duration;
use port::{Exchange, Lost};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::Errno,
    net::{RecvFlags, SendFlags, recv, send},
};
use std::{
    io,
    net::{Ipv4Addr, SocketAddrV4, UdpSocket},
};

/// Connection to one device.
#[derive(Debug)]
pub struct UdpLine {
    socket: UdpSocket,
}

impl UdpLine {
    /// Opens a connection to a device. Nothing is sent.
    ///
    /// # Errors
    /// The system has no way to the address.
    pub fn open(address: Ipv4Addr, port: u16) -> io::Result<Self> {
        let socket = UdpSocket::bind(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, 0))?;
        socket.connect(SocketAddrV4::new(address, port))?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket })
    }

    /// Returns the address of this end.
    ///
    /// # Errors
    /// The system does not say it.
    pub fn local(&self) -> io::Result<std::net::SocketAddr> {
        self.socket.local_addr()
    }

    /// Takes a packet that is there. Returns 0 for none.
    fn take(&self, into: &mut [u8]) -> Result<usize, Lost> {
        match recv(&self.socket, into, RecvFlags::DONTWAIT | RecvFlags::TRUNC) {
            Ok((_, length)) => Ok(length),
            Err(Errno::AGAIN | Errno::INTR) => Ok(0),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }
}

impl Exchange for UdpLine {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        match send(&self.socket, packet, SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
            Ok(_) => Ok(()),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }

    fn receive(&self, into: &mut [u8], within: Duration) -> Result<usize, Lost> {
        let length = self.take(into)?;
        if length != 0 || within.is_zero() {
            return Ok(length);
        }
        let within = Timespec {
            tv_sec: i64::try_from(within.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(within.subsec_nanos()),
        };
        match poll(&mut [PollFd::new(&self.socket, PollFlags::IN)], Some(&within)) {
            Ok(0) | Err(Errno::INTR) => Ok(0),
            Ok(_) => self.take(into),
            Err(error) => Err(Lost(error.raw_os_error())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_come_back_and_none_is_awaited_beyond_its_time() {
        let device = UdpSocket::bind("127.0.0.1:0").unwrap();
        let line = UdpLine::open(Ipv4Addr::LOCALHOST, device.local_addr().unwrap().port()).unwrap();
        let mut into = [0; 8];
        assert_eq!(line.receive(&mut into, Duration::from_millis(1)), Ok(0));
        line.send(b"abc").unwrap();
        let (length, from) = device.recv_from(&mut into).unwrap();
        assert_eq!((length, from.port()), (3, line.local().unwrap().port()));
        device.send_to(b"0123456789", from).unwrap();
        assert_eq!(line.receive(&mut into, Duration::from_secs(10)), Ok(10));
        assert_eq!(&into, b"01234567");
    }

    /// The port of a program that has ended answers with an error of ICMP.
    #[test]
    fn a_device_that_is_not_there_is_lost() {
        let device = UdpSocket::bind("127.0.0.1:0").unwrap();
        let line = UdpLine::open(Ipv4Addr::LOCALHOST, device.local_addr().unwrap().port()).unwrap();
        drop(device);
        line.send(b"abc").unwrap();
        let refused = Errno::CONNREFUSED.raw_os_error();
        assert_eq!(line.receive(&mut [0; 8], Duration::from_secs(10)), Err(Lost(refused)));
    }

    #[test]
    fn packets_of_other_senders_are_not_taken() {
        let device = UdpSocket::bind("127.0.0.1:0").unwrap();
        let line = UdpLine::open(Ipv4Addr::LOCALHOST, device.local_addr().unwrap().port()).unwrap();
        let stranger = UdpSocket::bind("127.0.0.1:0").unwrap();
        let to = SocketAddrV4::new(Ipv4Addr::LOCALHOST, line.local().unwrap().port());
        stranger.send_to(b"abc", to).unwrap();
        device.send_to(b"d", to).unwrap();
        let mut into = [0; 8];
        assert_eq!(line.receive(&mut into, Duration::from_secs(10)), Ok(1));
        assert_eq!(into[0], b'd');
    }
}
