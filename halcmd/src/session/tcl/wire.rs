//! Requests of Tcl scripts, and answers to them: lists of texts. A list is a line with its number of texts, and each text
//! behind a line with its length in bytes.

/// Largest number of texts in a request.
const MAX_TEXTS: usize = 10_000;
/// Largest length of a text in bytes.
const MAX_LENGTH: usize = 1 << 20;

/// Bytes that are no request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Garbled;

/// The bytes of requests as they arrive.
#[derive(Debug, Default)]
pub(crate) struct Incoming {
    bytes: Vec<u8>,
}

impl Incoming {
    pub(crate) fn add(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Takes the first request, if all of it has arrived.
    pub(crate) fn next(&mut self) -> Result<Option<Vec<String>>, Garbled> {
        let mut rest = self.bytes.as_slice();
        let Some(count) = number(&mut rest, MAX_TEXTS)? else { return Ok(None) };
        let mut texts = Vec::new();
        for _ in 0..count {
            let Some(length) = number(&mut rest, MAX_LENGTH)? else { return Ok(None) };
            let Some((text, after)) = rest.split_at_checked(length) else { return Ok(None) };
            texts.push(String::from_utf8_lossy(text).into_owned());
            rest = after;
        }
        let used = self.bytes.len() - rest.len();
        self.bytes.drain(..used);
        Ok(Some(texts))
    }
}

/// Takes a line with a number off the front. Returns `None` if the line has not arrived as a whole.
fn number(rest: &mut &[u8], most: usize) -> Result<Option<usize>, Garbled> {
    let Some(end) = rest.iter().take(16).position(|b| *b == b'\n') else {
        return if rest.len() < 16 { Ok(None) } else { Err(Garbled) };
    };
    let line = rest.get(..end).and_then(|line| std::str::from_utf8(line).ok()).ok_or(Garbled)?;
    let number: usize = line.parse().map_err(|_| Garbled)?;
    *rest = rest.get(end + 1..).unwrap_or_default();
    if number <= most { Ok(Some(number)) } else { Err(Garbled) }
}

/// Returns an answer as it is sent.
pub(crate) fn sent(texts: &[String]) -> String {
    let mut all = format!("{}\n", texts.len());
    for text in texts {
        all.push_str(&format!("{}\n{text}", text.len()));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_arrive_in_pieces() {
        let texts = ["do".to_owned(), String::new(), "grün\n2".to_owned()];
        let whole = sent(&texts) + &sent(&[]);
        let mut incoming = Incoming::default();
        let mut found = Vec::new();
        for byte in whole.into_bytes() {
            incoming.add(&[byte]);
            while let Some(request) = incoming.next().unwrap() {
                found.push(request);
            }
        }
        assert_eq!(found, [texts.to_vec(), Vec::new()]);
    }

    #[test]
    fn other_bytes_are_refused() {
        for wrong in ["x\n", "-1\n", "1\n1048577\n", "10001\n", "1\n\n", "0000000000000000", "\n"] {
            let mut incoming = Incoming::default();
            incoming.add(wrong.as_bytes());
            assert_eq!(incoming.next(), Err(Garbled), "{wrong:?}");
        }
        let mut incoming = Incoming::default();
        incoming.add(b"1\n5\nabc");
        assert_eq!(incoming.next(), Ok(None));
    }
}
