//! The person at the terminal: questions and answers.

use super::Stopped;
use crate::{failure::Failure, start};
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::read,
    stdio::stdin,
};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering::Relaxed},
};

/// Longest answer, in bytes.
const LONGEST: usize = 1024;
/// Time after which a signal is seen at the latest while a question is open.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };

/// The person, and the signals that end the program.
pub(crate) struct Person {
    ending: Arc<AtomicBool>,
    /// Bytes that were typed and not read yet.
    typed: Vec<u8>,
}

impl Person {
    pub(crate) fn new() -> Result<Self, Failure> {
        Ok(Self { ending: start::ending()?, typed: Vec::new() })
    }

    /// Returns the flag that a signal sets.
    pub(crate) fn ending(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.ending)
    }

    /// Asks a question; returns the line without blanks around it, or nothing if the person wants no more.
    fn line(&mut self, question: &str) -> Result<Option<String>, Failure> {
        hal_output::print(question)?;
        Ok(self.typed_line().map(|line| line.trim().to_lowercase()).filter(|line| line != "stop"))
    }

    /// Waits for a line, a signal, or the end of the input.
    fn typed_line(&mut self) -> Option<String> {
        loop {
            if self.ending.load(Relaxed) {
                return None;
            }
            if let Some(end) = self.typed.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.typed.drain(..=end).collect();
                return Some(String::from_utf8_lossy(&line).into_owned());
            }
            if self.typed.len() >= LONGEST {
                return None;
            }
            let from = stdin();
            match poll(&mut [PollFd::new(&from, PollFlags::IN)], Some(&LOOK)) {
                Ok(0) | Err(rustix::io::Errno::INTR) => continue,
                Ok(_) => {}
                Err(_) => return None,
            }
            let mut bytes = [0; LONGEST];
            match read(from, &mut bytes) {
                Ok(n @ 1..) => self.typed.extend_from_slice(bytes.get(..n)?),
                Err(rustix::io::Errno::INTR | rustix::io::Errno::AGAIN) => {}
                Ok(0) | Err(_) => return None,
            }
        }
    }

    /// Asks until the answer is one of the words.
    pub(crate) fn word(&mut self, question: &str, words: &[&str]) -> Result<String, Stopped> {
        loop {
            let answer = self.line(question)?.ok_or(Stopped::Ended)?;
            if words.contains(&answer.as_str()) {
                return Ok(answer);
            }
            hal_output::print(&format!("'{answer}': one of {}\n", words.join(", ")))
                .map_err(Failure::from)?;
        }
    }

    /// Waits for Enter.
    pub(crate) fn enter(&mut self, question: &str) -> Result<(), Stopped> {
        self.line(&format!("{question}, then Enter "))?.map(drop).ok_or(Stopped::Ended)
    }

    /// Asks until the answer is a number.
    pub(crate) fn number(&mut self, question: &str) -> Result<f64, Stopped> {
        loop {
            let answer = self.line(question)?.ok_or(Stopped::Ended)?;
            let number = answer.parse().ok().filter(|x: &f64| x.is_finite());
            match number {
                Some(number) => return Ok(number),
                None => hal_output::print(&format!("'{answer}': a number, as 4.95\n"))
                    .map_err(Failure::from)?,
            }
        }
    }

    /// Asks whether something is so. Without an answer it is not.
    pub(crate) fn yes(&mut self, question: &str) -> Result<bool, Failure> {
        match self.word(question, &["y", "n", ""]) {
            Ok(word) => Ok(word == "y"),
            Err(Stopped::Failed(failure)) => Err(failure),
            Err(_) => Ok(false),
        }
    }
}
