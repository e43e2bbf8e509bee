//! Answers of HTTP/1.1, within limits of bytes and time.

use crate::{Address, Refused};
use std::{
    io::{self, BufRead, BufReader, Read, Write},
    net::{TcpStream, ToSocketAddrs},
    time::Duration,
};

/// Longest header in bytes.
const MAX_HEADER: usize = 16 << 10;
/// Longest line that states the size of a chunk.
const MAX_LINE: u64 = 1000;

/// Answer to a request: its type, and its body.
pub struct Answer {
    /// Type of the content.
    pub content: String,
    body: Body<BufReader<TcpStream>>,
}

impl Read for Answer {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        self.body.read(to)
    }
}

/// Sends a request, and returns the answer. No wait for bytes lasts longer than the time-out.
///
/// # Errors
/// There is no connection or no answer, or it is not 200.
pub fn get(address: &Address, timeout: Duration) -> Result<Answer, Refused> {
    let places = (address.name.as_str(), address.port).to_socket_addrs()?;
    let mut last = Refused::Connection(io::ErrorKind::NotFound);
    for place in places {
        match TcpStream::connect_timeout(&place, timeout) {
            Ok(stream) => return ask(stream, address, timeout),
            Err(error) => last = error.into(),
        }
    }
    Err(last)
}

fn ask(mut stream: TcpStream, address: &Address, timeout: Duration) -> Result<Answer, Refused> {
    stream.set_read_timeout(Some(timeout))?;
    stream.set_write_timeout(Some(timeout))?;
    let Address { host, path, .. } = address;
    let request = format!(
        "GET {path} HTTP/1.1\r\nHost: {host}\r\nUser-Agent: halcamera\r\nConnection: close\r\n\r\n"
    );
    stream.write_all(request.as_bytes())?;
    let mut reader = BufReader::new(stream);
    let head = header(&mut reader)?;
    let mut fields = [httparse::EMPTY_HEADER; 64];
    let mut answer = httparse::Response::new(&mut fields);
    let parsed = answer.parse(&head).map_err(|_| Refused::Header)?;
    if parsed.is_partial() {
        return Err(Refused::Header);
    }
    match answer.code {
        Some(200) => {}
        Some(code) => return Err(Refused::Status(code)),
        None => return Err(Refused::Header),
    }
    let field = |name: &str| {
        let found = answer.headers.iter().find(|h| h.name.eq_ignore_ascii_case(name));
        found.and_then(|h| std::str::from_utf8(h.value).ok()).map(str::trim)
    };
    let is_chunked = field("transfer-encoding").is_some_and(|v| v.eq_ignore_ascii_case("chunked"));
    let length = field("content-length").map(|v| v.parse::<u64>().map_err(|_| Refused::Header));
    let kind = match (is_chunked, length.transpose()?) {
        (true, _) => Framing::Chunks { left: 0, first: true },
        (false, Some(left)) => Framing::Length(left),
        (false, None) => Framing::ToEnd,
    };
    let content = field("content-type").unwrap_or_default().to_owned();
    Ok(Answer { content, body: Body { reader, kind } })
}

/// Reads bytes up to an empty line.
pub(crate) fn header(reader: &mut impl BufRead) -> Result<Vec<u8>, Refused> {
    let mut head = Vec::new();
    loop {
        let before = head.len();
        let room = u64::try_from(MAX_HEADER.saturating_sub(before)).unwrap_or(0);
        let n = reader.by_ref().take(room).read_until(b'\n', &mut head)?;
        if n == 0 {
            return Err(if room == 0 { Refused::Header } else { Refused::Ended });
        }
        if matches!(head.get(before..), Some(b"\r\n" | b"\n")) {
            return Ok(head);
        }
    }
}

/// Framing of a body.
enum Framing {
    Length(u64),
    ToEnd,
    Chunks { left: u64, first: bool },
}

/// Body of an answer without its framing.
struct Body<R> {
    reader: R,
    kind: Framing,
}

impl<R: BufRead> Body<R> {
    /// Reads the line that states the size of the next chunk.
    fn chunk(&mut self, first: bool) -> io::Result<u64> {
        let bad = || io::Error::from(io::ErrorKind::InvalidData);
        let mut line = Vec::new();
        for _ in 0..if first { 1 } else { 2 } {
            // The line before the second one is the end of the last chunk.
            line.clear();
            self.reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line)?;
        }
        let text = std::str::from_utf8(&line).map_err(|_| bad())?;
        let size = text.split(';').next().unwrap_or_default().trim();
        u64::from_str_radix(size, 16).map_err(|_| bad())
    }
}

impl<R: BufRead> Read for Body<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let mut part = |reader: &mut R, left: &mut u64| {
            let most = usize::try_from(*left).unwrap_or(usize::MAX).min(to.len());
            let n = reader.read(to.get_mut(..most).unwrap_or_default())?;
            *left -= u64::try_from(n).unwrap_or(0);
            Ok(n)
        };
        match &mut self.kind {
            Framing::ToEnd => self.reader.read(to),
            Framing::Length(left) => part(&mut self.reader, left),
            Framing::Chunks { left, first } => {
                if *left == 0 {
                    let is_first = core::mem::replace(first, false);
                    let size = self.chunk(is_first)?;
                    if size == 0 {
                        self.kind = Framing::Length(0);
                        return Ok(0);
                    }
                    self.kind = Framing::Chunks { left: size, first: false };
                    return self.read(to);
                }
                part(&mut self.reader, left)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(kind: Framing, bytes: &[u8]) -> io::Result<Vec<u8>> {
        let mut out = Vec::new();
        Body { reader: bytes, kind }.read_to_end(&mut out).map(|_| out)
    }

    #[test]
    fn bodies_come_without_their_framing() {
        assert_eq!(body(Framing::ToEnd, b"abc").unwrap(), b"abc");
        assert_eq!(body(Framing::Length(2), b"abc").unwrap(), b"ab");
        let chunks = || Framing::Chunks { left: 0, first: true };
        assert_eq!(
            body(chunks(), b"3;x=1\r\nabc\r\nA\r\n0123456789\r\n0\r\n\r\n").unwrap(),
            b"abc0123456789"
        );
        assert!(body(chunks(), b"zz\r\nabc").is_err());
        assert!(body(chunks(), b"ffffffffffffffffff\r\nabc").is_err());
    }

    #[test]
    fn headers_end() {
        let read = |text: &[u8]| header(&mut BufReader::new(text));
        assert_eq!(read(b"a\r\nb\r\n\r\nrest").unwrap(), b"a\r\nb\r\n\r\n");
        assert_eq!(read(b"a\r\n"), Err(Refused::Ended));
        assert_eq!(read(&vec![b'a'; MAX_HEADER + 1]), Err(Refused::Header));
        let lines = b"a: b\r\n".repeat(MAX_HEADER);
        assert_eq!(read(&lines), Err(Refused::Header));
    }
}
