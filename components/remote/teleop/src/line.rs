//! Lines out of bytes, however the network has cut them.

/// Longest line in bytes, without its end.
pub const MAX_LINE: usize = 1024;

/// A line without its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Line {
    Text(String),
    /// More than [`MAX_LINE`] bytes, which were thrown away.
    Long,
    /// Bytes that are no UTF-8.
    NoText,
}

/// Bytes that have arrived, until each is part of a line.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    bytes: Vec<u8>,
    /// Number of bytes at the front that are part of lines already.
    used: usize,
    /// Number of bytes after them that are known to have no line end.
    seen: usize,
    /// True inside a line that is too long.
    skips: bool,
}

impl Lines {
    /// Adds bytes.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.used);
        self.used = 0;
        self.bytes.extend_from_slice(bytes);
    }

    /// Returns the number of bytes that wait.
    pub(crate) const fn waiting(&self) -> usize {
        self.bytes.len() - self.used
    }

    /// Returns the next whole line. It ends with LF, or CR LF.
    pub(crate) fn next(&mut self) -> Option<Line> {
        let rest = self.bytes.get(self.used..).unwrap_or_default();
        let found = rest.iter().skip(self.seen).position(|byte| *byte == b'\n');
        let Some(end) = found.map(|at| at + self.seen) else {
            self.seen = rest.len();
            // A CR may belong to the end of the line.
            if self.skips || rest.len() > MAX_LINE + 1 {
                self.skips = true;
                self.bytes.clear();
                (self.used, self.seen) = (0, 0);
            }
            return None;
        };
        let line = rest.get(..end).unwrap_or_default();
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let line = if core::mem::take(&mut self.skips) || line.len() > MAX_LINE {
            Line::Long
        } else {
            str::from_utf8(line).map_or(Line::NoText, |text| Line::Text(text.to_owned()))
        };
        self.used += end + 1;
        self.seen = 0;
        Some(line)
    }
}

#[cfg(test)]
mod tests {
    //! Line ends, cuts and limits.

    use super::{Line, Lines, MAX_LINE};

    fn lines(bytes: &[u8], size: usize) -> Vec<Line> {
        let (mut lines, mut out) = (Lines::default(), Vec::new());
        for piece in bytes.chunks(size) {
            lines.push(piece);
            while let Some(line) = lines.next() {
                out.push(line);
            }
            assert!(lines.waiting() <= MAX_LINE + 1 + size, "what has no end is not kept");
        }
        out
    }

    #[test]
    fn lines_are_the_same_however_they_are_cut() {
        let full = "x".repeat(MAX_LINE);
        let text = |text: &str| Line::Text(text.to_owned());
        for (bytes, expected) in [
            (&b"a\nb\r\n\r\n\nc"[..], vec![text("a"), text("b"), text(""), text("")]),
            (b"a\rb\r\r\n", vec![text("a\rb\r")]),
            (b"\xffa\nb\n", vec![Line::NoText, text("b")]),
            (format!("{full}\r\n{full}\n").as_bytes(), vec![text(&full), text(&full)]),
            (format!("{full}y\r\nb\n").as_bytes(), vec![Line::Long, text("b")]),
            (format!("{full}{full}{full}\nb\n").as_bytes(), vec![Line::Long, text("b")]),
        ] {
            for size in [1, 2, 3, 1000, 100_000] {
                assert_eq!(lines(bytes, size), expected, "in pieces of {size}");
            }
        }
    }
}
