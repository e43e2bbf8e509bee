//! The master's end of a line: a single request at a time.

use crate::line::OpenLine;
use core::time::Duration;
use hal_modbus::Miss;
use port::{Exchange as _, Lost};

/// Largest number of bytes that are kept for one answer, with the noise around it.
const MAX_CAME: usize = 2048;

/// Question, with the form of its answer.
pub(crate) trait Question {
    type Answer;

    /// Finds the answer in the bytes that have come.
    fn find(&self, bytes: &[u8]) -> Result<Option<Self::Answer>, Miss>;

    /// Returns what came instead of it.
    fn miss(&self, bytes: &[u8]) -> Miss;
}

/// Reason why a request has no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Failure {
    /// No answer came.
    Missed(Miss),
    /// The line is lost.
    Lost(Lost),
}

/// A request and its end.
pub(crate) type Ended<Q> = (Q, Result<<Q as Question>::Answer, Failure>);

/// The master's end of a line.
#[derive(Debug)]
pub(crate) struct Station<Q> {
    /// The request under way, with the time at which it ends without an answer.
    pending: Option<(Q, i64)>,
    came: Vec<u8>,
    /// Time of the last byte on the line, either way.
    quiet_since: i64,
    silence_ns: i64,
    char_ns: i64,
}

impl<Q: Question> Station<Q> {
    /// Returns the end of a line on which requests need this silence before them.
    pub(crate) const fn new(silence_ns: i64, char_ns: i64) -> Self {
        Self { pending: None, came: Vec::new(), quiet_since: i64::MIN / 2, silence_ns, char_ns }
    }

    /// Returns whether a request can be sent.
    pub(crate) const fn is_free(&self, now: i64) -> bool {
        self.pending.is_none() && self.silence_ns <= now.saturating_sub(self.quiet_since)
    }

    /// Sends a request, whose answer may take this long. Returns a request whose line is lost.
    pub(crate) fn ask(
        &mut self,
        way: &OpenLine,
        question: Q,
        frame: &[u8],
        within: i64,
        now: i64,
    ) -> Result<(), (Q, Lost)> {
        self.came.clear();
        if let Err(lost) = way.send(frame) {
            return Err((question, lost));
        }
        let count = i64::try_from(frame.len()).unwrap_or(i64::MAX);
        let sent = now.saturating_add(self.char_ns.saturating_mul(count));
        self.quiet_since = sent;
        self.pending = Some((question, sent.saturating_add(within)));
        Ok(())
    }

    /// Takes what has come. Returns the request that has ended.
    pub(crate) fn poll(&mut self, way: &OpenLine, now: i64) -> Option<Ended<Q>> {
        let mut into = [0; 256];
        loop {
            match way.receive(&mut into, Duration::ZERO) {
                Ok(0) => break,
                Ok(count) => {
                    self.quiet_since = self.quiet_since.max(now);
                    self.came.extend(into.get(..count).unwrap_or(&into));
                    // An endless stream of noise must neither fill the memory nor hold the worker.
                    if MAX_CAME < self.came.len() {
                        self.came.drain(..MAX_CAME / 2);
                        break;
                    }
                }
                Err(lost) => {
                    self.came.clear();
                    let (question, _) = self.pending.take()?;
                    return Some((question, Err(Failure::Lost(lost))));
                }
            }
        }
        let Some((question, deadline)) = self.pending.take() else {
            // Nobody has asked: the end of an answer that came too late.
            self.came.clear();
            return None;
        };
        match question.find(&self.came) {
            Ok(Some(answer)) => {
                self.came.clear();
                Some((question, Ok(answer)))
            }
            Ok(None) if now < deadline => {
                self.pending = Some((question, deadline));
                None
            }
            Ok(None) => {
                let miss = question.miss(&self.came);
                self.came.clear();
                Some((question, Err(Failure::Missed(miss))))
            }
            Err(miss) => {
                self.came.clear();
                Some((question, Err(Failure::Missed(miss))))
            }
        }
    }

    /// Forgets a request under way, because its line is lost.
    pub(crate) fn forget(&mut self) {
        self.pending = None;
        self.came.clear();
    }
}
