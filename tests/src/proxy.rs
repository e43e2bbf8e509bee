//! A TCP proxy that delays what it passes on.

use rustix::{
    thread::nanosleep,
    time::{ClockId, Timespec, clock_gettime},
};
use std::{
    io::{Read as _, Write as _},
    net::{IpAddr, Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream},
    sync::{
        Arc,
        atomic::{AtomicU64, Ordering::Relaxed},
        mpsc::channel,
    },
    thread,
};

/// A proxy for one server of this computer. Its threads end with their connections.
#[derive(Debug)]
pub struct Proxy {
    address: SocketAddr,
    delay_ms: Arc<AtomicU64>,
}

impl Proxy {
    /// Listens at an address of this computer, and passes connections on to a port of loopback.
    pub fn start(at: IpAddr, to: u16) -> Self {
        let listener = TcpListener::bind((at, 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let delay_ms = Arc::new(AtomicU64::new(0));
        let delay = delay_ms.clone();
        thread::spawn(move || {
            for client in listener.incoming() {
                let Ok(client) = client else { return };
                let Ok(server) = TcpStream::connect((Ipv4Addr::LOCALHOST, to)) else { continue };
                for stream in [&client, &server] {
                    drop(stream.set_nodelay(true));
                }
                pass(client.try_clone().unwrap(), server.try_clone().unwrap(), delay.clone());
                pass(server, client, delay.clone());
            }
        });
        Self { address, delay_ms }
    }

    /// Returns the address of the proxy.
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Delays all that arrives from now on, in milliseconds. What follows arrives no earlier than what precedes it.
    pub fn delay(&self, milliseconds: u64) {
        self.delay_ms.store(milliseconds, Relaxed);
    }
}

/// Returns the time of the system's clock in milliseconds.
fn now() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.unsigned_abs() * 1000 + now.tv_nsec.unsigned_abs() / 1_000_000
}

/// Passes one direction of a connection on.
fn pass(mut from: TcpStream, mut to: TcpStream, delay: Arc<AtomicU64>) {
    let (send, waiting) = channel::<(u64, Vec<u8>)>();
    thread::spawn(move || {
        for (at, bytes) in waiting {
            let wait = at.saturating_sub(now());
            let wait = Timespec {
                tv_sec: (wait / 1000).cast_signed(),
                tv_nsec: (wait % 1000 * 1_000_000).cast_signed(),
            };
            drop(nanosleep(&wait));
            if to.write_all(&bytes).is_err() {
                break;
            }
        }
        drop(to.shutdown(Shutdown::Write));
    });
    thread::spawn(move || {
        let mut bytes = vec![0; 64 << 10];
        while let Ok(n @ 1..) = from.read(&mut bytes) {
            if send.send((now() + delay.load(Relaxed), bytes[..n].to_vec())).is_err() {
                break;
            }
        }
    });
}
