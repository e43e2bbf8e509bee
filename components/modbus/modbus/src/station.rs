//! The master's end of a line: a single request at a time.

use crate::line::OpenLine;
use core::time::Duration;
use hal_modbus::Miss;
use port::{Exchange as _, Lost};

/// Largest number of bytes that are kept for one answer, with the noise around it.
const MAX_CAME: usize = 2048;
/// Time that devices usually take before an answer, in nanoseconds.
const USUAL_NS: i64 = 20_000_000;

/// Question, with the form of its answer.
pub(crate) trait Question {
    type Answer;

    /// Returns the number of bytes of the longest answer.
    fn answer_len(&self) -> usize;

    /// Finds the answer in the bytes that have come.
    fn find(&self, bytes: &[u8]) -> Result<Option<Self::Answer>, Miss>;

    /// Returns what came instead of it.
    fn miss(&self, bytes: &[u8]) -> Miss;
}

/// Loss of the line, with the request that was under way.
#[derive(Debug)]
pub(crate) struct LineLoss<Q> {
    pub(crate) question: Option<Q>,
    pub(crate) lost: Lost,
}

/// A request and its end.
pub(crate) type Ended<Q> = (Q, Result<<Q as Question>::Answer, Miss>);

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

    /// Returns the time at which a request is heard by the device, if it answers the one under way as fast as usual.
    pub(crate) fn quiet_at(&self) -> i64 {
        let answer = match &self.pending {
            Some((question, _)) => self
                .silence_ns
                .saturating_add(USUAL_NS)
                .saturating_add(self.chars(question.answer_len())),
            None => 0,
        };
        self.quiet_since.saturating_add(answer).saturating_add(self.silence_ns)
    }

    fn chars(&self, count: usize) -> i64 {
        self.char_ns.saturating_mul(i64::try_from(count).unwrap_or(i64::MAX))
    }

    /// Sends a request. Its answer may begin so many nanoseconds later.
    pub(crate) fn ask(
        &mut self,
        line: &OpenLine,
        question: Q,
        frame: &[u8],
        within: i64,
        now: i64,
    ) -> Result<(), LineLoss<Q>> {
        self.came.clear();
        if let Err(lost) = line.send(frame) {
            return Err(LineLoss { question: Some(question), lost });
        }
        let sent = now.saturating_add(self.chars(frame.len()));
        self.quiet_since = sent;
        let answer = self.chars(question.answer_len());
        self.pending = Some((question, sent.saturating_add(within).saturating_add(answer)));
        Ok(())
    }

    /// Takes what has come. Returns the request that has ended, or the loss of the line, also while nothing is asked.
    pub(crate) fn poll(
        &mut self,
        line: &OpenLine,
        now: i64,
    ) -> Result<Option<Ended<Q>>, LineLoss<Q>> {
        let mut into = [0; 256];
        loop {
            match line.receive(&mut into, Duration::ZERO) {
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
                    let question = self.pending.take().map(|(question, _)| question);
                    return Err(LineLoss { question, lost });
                }
            }
        }
        let Some((question, deadline)) = self.pending.take() else {
            // Nobody has asked: the end of an answer that came too late.
            self.came.clear();
            return Ok(None);
        };
        let end = match question.find(&self.came) {
            Ok(None) if now < deadline => {
                self.pending = Some((question, deadline));
                return Ok(None);
            }
            Ok(None) => Err(question.miss(&self.came)),
            Ok(Some(answer)) => Ok(answer),
            Err(miss) => Err(miss),
        };
        self.came.clear();
        Ok(Some((question, end)))
    }
}
