//! Lines out of bytes, however the network has cut them.

use std::collections::VecDeque;

/// Longest line in bytes.
pub const MAX_LINE: usize = 1024;
/// Number of whole lines that wait; bytes beyond them are left to the network.
const MAX_WAITING: usize = 256;

/// Bytes that have arrived, as lines.
#[derive(Debug, Default)]
pub struct Lines {
    whole: VecDeque<String>,
    begun: Vec<u8>,
    /// True inside a line that is too long.
    skips: bool,
}

impl Lines {
    /// Adds bytes. Any number of CR and LF ends a line; a line that is too long is left out.
    pub fn push(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if matches!(byte, b'\r' | b'\n') {
                if !self.begun.is_empty() && !self.skips {
                    self.whole.push_back(String::from_utf8_lossy(&self.begun).into_owned());
                }
                self.begun.clear();
                self.skips = false;
            } else if self.begun.len() < MAX_LINE {
                self.begun.push(*byte);
            } else {
                self.skips = true;
            }
        }
    }

    /// Returns whether further bytes have room.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.whole.len() < MAX_WAITING
    }

    /// Returns the oldest line.
    pub fn next_line(&mut self) -> Option<String> {
        self.whole.pop_front()
    }

    /// Returns the lines that wait, the oldest first.
    pub fn waiting(&self) -> impl Iterator<Item = &str> {
        self.whole.iter().map(String::as_str)
    }
}
