//! Sources of physical lines: a text or standard input.

use hal_output::Unwritten;
use hal_protocol::{Link, Request};
use rustix::{
    event::{PollFd, PollFlags, poll},
    io::Errno,
    time::Timespec,
};
use std::collections::VecDeque;

/// Maximum number of bytes of a line.
pub const MAX_PHYSICAL: usize = 1023;

/// A line, or a piece of a line that is longer than [`MAX_PHYSICAL`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Physical {
    /// Bytes without the end of line.
    pub bytes: Vec<u8>,
    /// True if it had an end of line; otherwise it was cut, or is the last of its file.
    pub ended: bool,
    /// True if the rest of the line follows.
    pub cut: bool,
}

/// A source of physical lines.
pub trait Lines {
    /// Returns the next line. `continuing` means that it continues the one before. While the user
    /// is not typing, the engine behind `link` serves its other clients.
    fn next(&mut self, continuing: bool, link: &mut dyn Link) -> Option<Physical>;
}

/// The lines of a text.
#[derive(Clone, Debug, Default)]
pub struct Bytes {
    text: Vec<u8>,
    at: usize,
}

impl Bytes {
    /// Makes a source from the content of a file.
    #[must_use]
    pub const fn new(text: Vec<u8>) -> Self {
        Self { text, at: 0 }
    }
}

impl Lines for Bytes {
    fn next(&mut self, _: bool, _: &mut dyn Link) -> Option<Physical> {
        let rest = self.text.get(self.at..).filter(|r| !r.is_empty())?;
        let (line, used) = first_line(rest);
        self.at += used;
        Some(line)
    }
}

/// The lines of standard input. While there is none, the engine serves its other clients.
#[derive(Debug)]
pub struct Stdin {
    prompt: Option<Prompt>,
    flow: bool,
    buffer: VecDeque<u8>,
    ended: bool,
}

#[derive(Clone, Copy, Debug)]
struct Prompt {
    first: &'static str,
    next: &'static str,
}

impl Stdin {
    /// Prompts if a person is at the terminal. `script` selects the prompt for programs. With
    /// `flow` the virtual clock moves while nothing is typed.
    #[must_use]
    pub fn new(script: bool, flow: bool) -> Self {
        let person = rustix::termios::isatty(std::io::stdin());
        let prompt = person.then_some(if script {
            Prompt { first: "%\n", next: "%\n" }
        } else {
            Prompt { first: "halcmd: ", next: "halcmd+: " }
        });
        Self { prompt, flow, buffer: VecDeque::new(), ended: false }
    }

    /// Waits for more input while the engine serves its clients. Returns false at the end.
    fn fill(&mut self, link: &mut dyn Link) -> bool {
        loop {
            let ready = {
                let stdin = std::io::stdin();
                let mut fds = [PollFd::new(&stdin, PollFlags::IN)];
                // An engine in this process has to serve its clients meanwhile.
                let wait = if link.is_local() { 0 } else { 3600 };
                let wait = Timespec { tv_sec: wait, tv_nsec: 0 };
                poll(&mut fds, Some(&wait))
            };
            match ready {
                Ok(0) if link.is_local() => {
                    // If the instance is ending, the next line notices it.
                    if link.call(Request::Idle { ms: 10, flow: self.flow }).is_err() {
                        return false;
                    }
                }
                Ok(0) | Err(Errno::INTR) => {}
                Ok(_) | Err(_) => break,
            }
        }
        let mut chunk = [0; 65536];
        match rustix::io::read(std::io::stdin(), &mut chunk) {
            Ok(n) if n > 0 => {
                self.buffer.extend(chunk.get(..n).unwrap_or_default());
                true
            }
            Err(Errno::INTR | Errno::AGAIN) => true,
            _ => false,
        }
    }
}

impl Lines for Stdin {
    fn next(&mut self, continuing: bool, link: &mut dyn Link) -> Option<Physical> {
        if let Some(prompt) = self.prompt {
            let text = if continuing { prompt.next } else { prompt.first };
            // Commands that print report when output cannot be written.
            if hal_output::print(text) == Err(Unwritten::ReaderGone) {
                return None;
            }
        }
        loop {
            let whole = self.buffer.len() > MAX_PHYSICAL || self.buffer.contains(&b'\n');
            if whole || self.ended {
                let rest = self.buffer.make_contiguous();
                if rest.is_empty() {
                    return None;
                }
                let (line, used) = first_line(rest);
                self.buffer.drain(..used);
                return Some(line);
            }
            self.ended = !self.fill(link);
        }
    }
}

/// Returns the first line of a non-empty text, and the number of bytes it takes.
fn first_line(text: &[u8]) -> (Physical, usize) {
    let end = text.iter().take(MAX_PHYSICAL + 1).position(|b| *b == b'\n');
    let length = end.unwrap_or_else(|| text.len().min(MAX_PHYSICAL));
    let bytes = text.get(..length).unwrap_or_default().to_vec();
    let cut = end.is_none() && text.len() > MAX_PHYSICAL;
    (Physical { bytes, ended: end.is_some(), cut }, length + usize::from(end.is_some()))
}
