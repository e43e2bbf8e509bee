//! A connection: bytes from a client, and answers to it.

use rustix::net::sockopt;
use std::{sync::Arc, time::Duration};
use tokio::{
    io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _},
    net::TcpStream,
    sync::{Semaphore, mpsc},
    time::timeout,
};

/// Longest segment in bytes.
const SEGMENT: usize = 16 << 10;
/// Longest time that an answer may take.
const SEND_TIME: Duration = Duration::from_secs(10);
/// Longest time for which bytes of a client are read away after the last answer, so that it reads that answer.
const CLOSE_TIME: Duration = Duration::from_secs(1);

/// Silence of the other computer after which it is asked whether it is there, and the time between questions.
const QUIET: Duration = Duration::from_secs(5);
const ASK: Duration = Duration::from_secs(2);
/// Number of questions without an answer after which the connection ends.
const QUESTIONS: u32 = 3;

/// Lets a connection end whose other computer has vanished without a word.
pub(super) fn keep_alive(stream: &TcpStream) {
    let patience = QUIET + ASK * QUESTIONS;
    let patience = u32::try_from(patience.as_millis()).unwrap_or(u32::MAX);
    let set = sockopt::set_socket_keepalive(stream, true)
        .and_then(|()| sockopt::set_tcp_keepidle(stream, QUIET))
        .and_then(|()| sockopt::set_tcp_keepintvl(stream, ASK))
        .and_then(|()| sockopt::set_tcp_keepcnt(stream, QUESTIONS))
        .and_then(|()| sockopt::set_tcp_user_timeout(stream, patience));
    // Without it, the silence of the owner still ends a job.
    set.unwrap_or_default();
}

/// Passes bytes both ways until one side ends. Each segment is read under a permit and becomes an event by `event`;
/// `answers` ends with the connection.
pub(super) async fn serve<S, E>(
    stream: S,
    permits: Arc<Semaphore>,
    events: mpsc::Sender<E>,
    event: impl Fn(Vec<u8>) -> E,
    mut answers: mpsc::Receiver<Vec<u8>>,
) where
    S: AsyncRead + AsyncWrite,
{
    let (mut from, mut to) = tokio::io::split(stream);
    let reads = async {
        let mut buffer = vec![0; SEGMENT];
        while let Ok(permit) = permits.acquire().await {
            permit.forget();
            match from.read(&mut buffer).await {
                Ok(0) | Err(_) => return,
                Ok(count) => {
                    let segment = buffer.get(..count).unwrap_or_default().to_vec();
                    if events.send(event(segment)).await.is_err() {
                        return;
                    }
                }
            }
        }
    };
    let writes = async {
        while let Some(bytes) = answers.recv().await {
            if !matches!(timeout(SEND_TIME, to.write_all(&bytes)).await, Ok(Ok(()))) {
                return false;
            }
        }
        // A client that has gone needs no end.
        timeout(SEND_TIME, to.shutdown()).await.is_ok_and(|end| end.is_ok())
    };
    let closes = tokio::select! {
        () = reads => false,
        closes = writes => closes,
    };
    if closes {
        let mut rest = [0; 1024];
        let away = async { while from.read(&mut rest).await.is_ok_and(|count| count > 0) {} };
        drop(timeout(CLOSE_TIME, away).await);
    }
}
