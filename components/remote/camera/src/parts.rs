//! Parts of a stream of pictures (`multipart/x-mixed-replace`).

use crate::{Refused, http::header};
use hal_marks::MAX_BYTES;
use std::io::{BufRead, BufReader, Read};

/// Longest boundary in bytes (RFC 2046 allows 70; some cameras add dashes).
const MAX_BOUNDARY: usize = 100;
/// Largest number of bytes between two parts.
const MAX_BETWEEN: usize = 4096;

/// Parts of a stream.
pub struct Parts<R> {
    reader: BufReader<R>,
    /// Boundary with its dashes.
    boundary: Vec<u8>,
    /// The reader stands behind a boundary.
    is_at_part: bool,
}

impl<R: Read> Parts<R> {
    /// Returns the parts of a body of this type.
    ///
    /// # Errors
    /// The type is another one, or names no boundary.
    pub fn new(content: &str, body: R) -> Result<Self, Refused> {
        let mut words = content.split(';').map(str::trim);
        let is_stream = words
            .next()
            .is_some_and(|w| w.get(..10).is_some_and(|w| w.eq_ignore_ascii_case("multipart/")));
        if !is_stream {
            return Err(Refused::NotStream);
        }
        let named = words.find_map(|w| {
            let (name, value) = w.split_once('=')?;
            name.trim().eq_ignore_ascii_case("boundary").then_some(value.trim().trim_matches('"'))
        });
        let name = named.filter(|n| !n.is_empty() && n.len() <= MAX_BOUNDARY);
        let name = name.ok_or(Refused::Boundary)?;
        // Some cameras state the boundary with the dashes that go before it.
        let dashes = if name.starts_with("--") { "" } else { "--" };
        let boundary = format!("{dashes}{name}").into_bytes();
        Ok(Self { reader: BufReader::new(body), boundary, is_at_part: false })
    }

    /// Returns the bytes of the next part.
    ///
    /// # Errors
    /// The stream ends, a boundary is missing, or the part is too large.
    pub fn part(&mut self) -> Result<Vec<u8>, Refused> {
        if !core::mem::replace(&mut self.is_at_part, false) {
            self.boundary()?;
        }
        let head = header(&mut self.reader)?;
        match length(&head) {
            Some(length) if length > MAX_BYTES => Err(Refused::Large),
            Some(length) => {
                let mut part = vec![0; length];
                self.reader.read_exact(&mut part)?;
                Ok(part)
            }
            None => self.up_to_boundary(),
        }
    }

    /// Finds the next boundary, which stands on a line.
    fn boundary(&mut self) -> Result<(), Refused> {
        let mut seen = 0;
        loop {
            let mut line = Vec::new();
            let most = u64::try_from(MAX_BETWEEN).unwrap_or(0);
            let n = self.reader.by_ref().take(most).read_until(b'\n', &mut line)?;
            if n == 0 {
                return Err(Refused::Ended);
            }
            let text = line.trim_ascii();
            if let Some(rest) = text.strip_prefix(self.boundary.as_slice()) {
                return match rest {
                    b"" => Ok(()),
                    b"--" => Err(Refused::Ended),
                    _ => Err(Refused::Boundary),
                };
            }
            seen += n;
            if seen > MAX_BETWEEN {
                return Err(Refused::Boundary);
            }
        }
    }

    /// Reads a part without a stated length, up to the boundary behind it.
    fn up_to_boundary(&mut self) -> Result<Vec<u8>, Refused> {
        let mut part = Vec::new();
        loop {
            let before = part.len();
            let room = u64::try_from((MAX_BYTES + MAX_BETWEEN).saturating_sub(before)).unwrap_or(0);
            if room == 0 {
                return Err(Refused::Large);
            }
            if self.reader.by_ref().take(room).read_until(b'\n', &mut part)? == 0 {
                return Err(Refused::Ended);
            }
            let line = part.get(before..).unwrap_or_default();
            if line.trim_ascii_end() == self.boundary {
                part.truncate(before);
                let end = part.strip_suffix(b"\n").unwrap_or(&part);
                let end = end.strip_suffix(b"\r").unwrap_or(end).len();
                part.truncate(end);
                self.is_at_part = true;
                return Ok(part);
            }
        }
    }
}

/// Returns the length that the header of a part states.
fn length(head: &[u8]) -> Option<usize> {
    let mut fields = [httparse::EMPTY_HEADER; 32];
    let parsed = httparse::parse_headers(head, &mut fields).ok()?;
    let (_, fields) = match parsed {
        httparse::Status::Complete(done) => done,
        httparse::Status::Partial => return None,
    };
    let field = fields.iter().find(|f| f.name.eq_ignore_ascii_case("content-length"))?;
    std::str::from_utf8(field.value).ok()?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(content: &str, body: &[u8]) -> Result<Vec<Vec<u8>>, Refused> {
        let mut parts = Parts::new(content, body)?;
        let mut out = Vec::new();
        loop {
            match parts.part() {
                Ok(part) => out.push(part),
                Err(Refused::Ended) if !out.is_empty() => return Ok(out),
                Err(refused) => return Err(refused),
            }
        }
    }

    const TYPE: &str = "multipart/x-mixed-replace; boundary=frame";

    #[test]
    fn parts_come_with_and_without_lengths() {
        let stated = b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 3\r\n\r\nabc\r\n--frame\r\nContent-Length: 2\r\n\r\nde\r\n--frame--\r\n";
        assert_eq!(parts(TYPE, stated).unwrap(), [b"abc".to_vec(), b"de".to_vec()]);
        let free = b"\r\n--frame\r\nContent-Type: image/jpeg\r\n\r\na\nb\r\n--frame\r\n\r\ncd\r\n--frame\r\n";
        assert_eq!(parts(TYPE, free).unwrap(), [b"a\nb".to_vec(), b"cd".to_vec()]);
        let dashes = "multipart/x-mixed-replace;boundary=\"--frame\"";
        assert_eq!(parts(dashes, stated).unwrap().len(), 2);
    }

    #[test]
    fn wrong_streams_are_refused_by_name() {
        assert_eq!(parts("image/jpeg", b""), Err(Refused::NotStream));
        assert_eq!(parts("multipart/x-mixed-replace", b""), Err(Refused::Boundary));
        let long = format!("multipart/mixed; boundary={}", "x".repeat(200));
        assert_eq!(parts(&long, b""), Err(Refused::Boundary));
        assert_eq!(parts(TYPE, b""), Err(Refused::Ended));
        assert_eq!(parts(TYPE, b"--other\r\n\r\nabc"), Err(Refused::Ended));
        assert_eq!(parts(TYPE, &b"junk\n".repeat(2000)), Err(Refused::Boundary));
        assert_eq!(parts(TYPE, b"--framed\r\n\r\n"), Err(Refused::Boundary));
        let large = format!("--frame\r\nContent-Length: {}\r\n\r\n", MAX_BYTES + 1);
        assert_eq!(parts(TYPE, large.as_bytes()), Err(Refused::Large));
        assert_eq!(parts(TYPE, b"--frame\r\nContent-Length: 9\r\n\r\nabc"), Err(Refused::Ended));
        let mut endless = b"--frame\r\n\r\n".to_vec();
        endless.resize(MAX_BYTES + 10_000, b'x');
        assert_eq!(parts(TYPE, &endless), Err(Refused::Large));
    }
}
