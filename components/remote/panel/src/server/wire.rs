//! The connection under a request.

use rustix::net::sockopt;
use std::{
    io::{IoSlice, Result},
    pin::Pin,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    task::{Context, Poll},
};
use tokio::{
    io::{AsyncRead, AsyncWrite, ReadBuf},
    net::TcpStream,
};

/// Size of the send buffer of a `WebSocket`, small so that a slow client gets recent states.
const SEND_BUFFER: usize = 32 << 10;

/// A connection. It begins with the system's send buffer: with a small one, a long answer waits for the client after every
/// few packets, and the path of a long program takes 12 s instead of 0.1 s.
#[derive(Debug)]
pub(super) struct Wire {
    stream: TcpStream,
    send_buffer: SendBuffer,
}

/// The send buffer of a connection, for its requests.
#[derive(Clone, Debug, Default)]
pub(crate) struct SendBuffer {
    shrinks: Arc<AtomicBool>,
}

impl SendBuffer {
    /// Makes the buffer small before the next write, for a `WebSocket`: it then holds only what is recent.
    pub(crate) fn shrink(&self) {
        // The task that answers the request also writes.
        self.shrinks.store(true, Relaxed);
    }
}

impl Wire {
    /// Takes a connection, and returns it with its send buffer.
    pub(super) fn new(stream: TcpStream) -> (Self, SendBuffer) {
        let send_buffer = SendBuffer::default();
        (Self { stream, send_buffer: send_buffer.clone() }, send_buffer)
    }

    /// Returns the connection for a write.
    fn writer(&mut self) -> Pin<&mut TcpStream> {
        if self.send_buffer.shrinks.load(Relaxed) {
            self.send_buffer.shrinks.store(false, Relaxed);
            sockopt::set_socket_send_buffer_size(&self.stream, SEND_BUFFER).unwrap_or_default();
        }
        Pin::new(&mut self.stream)
    }
}

impl AsyncRead for Wire {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for Wire {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<Result<usize>> {
        self.writer().poll_write(context, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<Result<usize>> {
        self.writer().poll_write_vectored(context, slices)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::{SEND_BUFFER, Wire};
    use crate::lease::tests::run;
    use rustix::net::sockopt::socket_send_buffer_size;
    use tokio::{
        io::AsyncWriteExt,
        net::{TcpListener, TcpStream},
    };

    #[test]
    fn the_send_buffer_shrinks_before_the_next_write() {
        run(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let stream = TcpStream::connect(listener.local_addr().unwrap()).await.unwrap();
            let (mut wire, send_buffer) = Wire::new(stream);
            let size = |wire: &Wire| socket_send_buffer_size(&wire.stream).unwrap();
            let before = size(&wire);
            wire.write_all(b"answer").await.unwrap();
            assert_eq!(size(&wire), before);
            send_buffer.shrink();
            wire.write_all(b"upgrade").await.unwrap();
            // Linux doubles the size for its own records.
            assert!(size(&wire) <= 2 * SEND_BUFFER && size(&wire) < before, "{before}");
        });
    }
}
