//! Accesses to lines as text: recorded from one back end, replayed as another. For tests; both lock and allocate.
//!
//! A line of the text is one call, with what it answered: `read MASK = LEVELS`, `write LEVELS MASK`, or `edges` and
//! `TIME:BIT:RISING:NUMBER` for each edge. Masks and levels are hexadecimal. `! ERRNO` at the end of a line stands for an error.

use crate::{LineEdge, Lines, Lost};
use core::fmt;
use std::{
    collections::VecDeque,
    sync::{Mutex, PoisonError},
};

/// Error number of a call that the recording does not have next (EBADMSG).
const OTHER: i32 = 74;

/// Access to lines, with the answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LineCall {
    /// Levels of the lines of a mask.
    Read(u64, Result<u64, Lost>),
    /// Levels, and the mask of the lines that take them.
    Write(u64, u64, Result<(), Lost>),
    /// Edges that waited.
    Edges(Result<Vec<LineEdge>, Lost>),
}

/// Lines whose accesses are recorded.
#[derive(Debug)]
pub struct RecordedLines<L> {
    lines: L,
    calls: Mutex<Vec<LineCall>>,
}

impl<L: Lines> RecordedLines<L> {
    /// Returns `lines` with an empty recording.
    #[must_use]
    pub const fn new(lines: L) -> Self {
        Self { lines, calls: Mutex::new(Vec::new()) }
    }

    /// Returns the lines that are accessed.
    #[must_use]
    pub const fn inner(&self) -> &L {
        &self.lines
    }

    /// Returns the accesses so far, one to a line.
    #[must_use]
    pub fn text(&self) -> String {
        let calls = self.calls.lock().unwrap_or_else(PoisonError::into_inner);
        calls.iter().map(|call| format!("{call}\n")).collect()
    }

    fn keep(&self, call: LineCall) {
        self.calls.lock().unwrap_or_else(PoisonError::into_inner).push(call);
    }
}

impl<L: Lines> Lines for RecordedLines<L> {
    fn read(&self, mask: u64) -> Result<u64, Lost> {
        let answer = self.lines.read(mask);
        self.keep(LineCall::Read(mask, answer));
        answer
    }

    fn write(&self, levels: u64, mask: u64) -> Result<(), Lost> {
        let answer = self.lines.write(levels, mask);
        self.keep(LineCall::Write(levels, mask, answer));
        answer
    }

    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost> {
        let answer = self.lines.edges(room);
        let edges = answer.map(|count| room.get(..count).unwrap_or_default().to_vec());
        self.keep(LineCall::Edges(edges));
        answer
    }
}

/// Lines that answer as a recording says. An access that the recording does not have next fails with EBADMSG.
#[derive(Debug)]
pub struct ReplayedLines(Mutex<VecDeque<LineCall>>);

impl ReplayedLines {
    /// Reads a recording. Empty lines and lines that begin with `#` are skipped.
    ///
    /// # Errors
    /// A line is no access.
    pub fn new(text: &str) -> Result<Self, BadTape> {
        let mut calls = VecDeque::new();
        for (at, line) in (1..).zip(text.lines()) {
            let line = line.trim();
            if !line.is_empty() && !line.starts_with('#') {
                calls.push_back(parse(line).ok_or(BadTape(at))?);
            }
        }
        Ok(Self(Mutex::new(calls)))
    }

    /// Returns the number of recorded accesses that have not been made yet.
    #[must_use]
    pub fn left(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    fn next(&self) -> Option<LineCall> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}

impl Lines for ReplayedLines {
    fn read(&self, mask: u64) -> Result<u64, Lost> {
        match self.next() {
            Some(LineCall::Read(recorded, answer)) if recorded == mask => answer,
            _ => Err(Lost(OTHER)),
        }
    }

    fn write(&self, levels: u64, mask: u64) -> Result<(), Lost> {
        match self.next() {
            Some(LineCall::Write(l, m, answer)) if (l, m) == (levels, mask) => answer,
            _ => Err(Lost(OTHER)),
        }
    }

    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost> {
        let Some(LineCall::Edges(answer)) = self.next() else { return Err(Lost(OTHER)) };
        let edges = answer?;
        let to = room.get_mut(..edges.len()).ok_or(Lost(OTHER))?;
        to.copy_from_slice(&edges);
        Ok(edges.len())
    }
}

/// Number of the first line of a recording that is no access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadTape(pub usize);

impl fmt::Display for BadTape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "line {} is no access to lines: expected read MASK = LEVELS, write LEVELS MASK or edges \
             TIME:BIT:RISING:NUMBER …, with ! ERRNO for an error",
            self.0
        )
    }
}

impl core::error::Error for BadTape {}

impl fmt::Display for LineCall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(mask, Ok(levels)) => write!(f, "read {mask:x} = {levels:x}"),
            Self::Read(mask, Err(lost)) => write!(f, "read {mask:x} ! {}", lost.0),
            Self::Write(levels, mask, Ok(())) => write!(f, "write {levels:x} {mask:x}"),
            Self::Write(levels, mask, Err(lost)) => {
                write!(f, "write {levels:x} {mask:x} ! {}", lost.0)
            }
            Self::Edges(Ok(edges)) => {
                write!(f, "edges")?;
                edges.iter().try_for_each(|e| {
                    write!(f, " {}:{}:{}:{}", e.at_ns, e.bit, u8::from(e.is_rising), e.number)
                })
            }
            Self::Edges(Err(lost)) => write!(f, "edges ! {}", lost.0),
        }
    }
}

fn parse(line: &str) -> Option<LineCall> {
    let (line, lost) = match line.split_once('!') {
        Some((line, errno)) => (line, Some(Lost(errno.trim().parse().ok()?))),
        None => (line, None),
    };
    let words: Vec<&str> = line.split_whitespace().collect();
    let hex = |word: &str| u64::from_str_radix(word, 16).ok();
    Some(match (words.as_slice(), lost) {
        (["read", mask, "=", levels], None) => LineCall::Read(hex(mask)?, Ok(hex(levels)?)),
        (["read", mask], Some(lost)) => LineCall::Read(hex(mask)?, Err(lost)),
        (["write", levels, mask], lost) => {
            LineCall::Write(hex(levels)?, hex(mask)?, lost.map_or(Ok(()), Err))
        }
        (["edges"], Some(lost)) => LineCall::Edges(Err(lost)),
        (["edges", edges @ ..], None) => {
            LineCall::Edges(Ok(edges.iter().map(|word| edge(word)).collect::<Option<_>>()?))
        }
        _ => return None,
    })
}

fn edge(word: &str) -> Option<LineEdge> {
    let parts: Vec<&str> = word.split(':').collect();
    let [at, bit, rising, number] = parts.as_slice() else { return None };
    let is_rising = match *rising {
        "0" => false,
        "1" => true,
        _ => return None,
    };
    Some(LineEdge {
        at_ns: at.parse().ok()?,
        bit: bit.parse().ok().filter(|bit| *bit < 64)?,
        number: number.parse().ok()?,
        is_rising,
    })
}

#[cfg(test)]
mod tests {
    use super::{BadTape, RecordedLines, ReplayedLines};
    use crate::{LineEdge, Lines, Lost};

    const TAPE: &str = "read ff = 5\nwrite 1 3\nedges 100:0:1:1 250:1:0:2\nedges\nread 1 ! 19\n\
                        write 0 ffffffffffffffff ! 19\nedges ! 19\n";

    /// A recording of a replay is the text that was replayed.
    #[test]
    fn a_recording_is_replayed_call_by_call() {
        let lines = RecordedLines::new(ReplayedLines::new(TAPE).unwrap());
        let mut room = [LineEdge::default(); 4];
        assert_eq!(lines.read(0xFF), Ok(5));
        assert_eq!(lines.write(1, 3), Ok(()));
        assert_eq!(lines.edges(&mut room), Ok(2));
        assert_eq!(room[1], LineEdge { at_ns: 250, number: 2, bit: 1, is_rising: false });
        assert_eq!(lines.edges(&mut room), Ok(0));
        assert_eq!(lines.read(1), Err(Lost(19)));
        assert_eq!(lines.write(0, u64::MAX), Err(Lost(19)));
        assert_eq!(lines.edges(&mut room), Err(Lost(19)));
        assert_eq!((lines.text().as_str(), lines.lines.left()), (TAPE, 0));
    }

    #[test]
    fn another_call_than_the_recorded_one_fails() {
        let calls: [fn(&ReplayedLines) -> Option<Lost>; 5] = [
            |l| l.read(1).err(),
            |l| l.write(1, 1).err(),
            |l| l.write(0, 3).err(),
            |l| l.edges(&mut []).err(),
            |l| l.edges(&mut [LineEdge::default(); 1]).err(),
        ];
        for (text, call) in
            ["write 1 3", "read 1 = 1", "write 1 3", "read 1 = 1", TWO].into_iter().zip(calls)
        {
            assert_eq!(call(&ReplayedLines::new(text).unwrap()), Some(Lost(74)), "{text}");
        }
        assert_eq!(ReplayedLines::new("").unwrap().read(1), Err(Lost(74)));
    }

    const TWO: &str = "edges 1:0:1:1 2:0:0:2";

    #[test]
    fn a_line_that_is_no_access_is_named() {
        for text in [
            "read",
            "read ff",
            "read = 5",
            "read g = 5",
            "write 1",
            "edges 1:2:3",
            "edges 1:64:1:1",
            "edges 1:1:2:1",
            "edges -1:1:1:1",
            "read 1 = 1 ! 19",
            "edges 1:1:1:1 ! 19",
            "look",
            "read 1 ! x",
        ] {
            let found = ReplayedLines::new(&format!("# comment\n\n{text}\n"));
            assert_eq!(found.err(), Some(BadTape(3)), "{text}");
        }
        assert!(BadTape(3).to_string().starts_with("line 3 is no access"));
    }
}
