//! Questions of workers for values of pins, parameters and signals, which the control side answers.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of questions that are kept. A worker that asks and does not look loses its oldest one.
const MAX_KEPT: usize = 256;

#[derive(Debug)]
struct Question {
    number: u64,
    name: Box<str>,
    /// `Some(None)` if nothing has the name.
    answer: Option<Option<f64>>,
}

/// Questions without an answer, and answers that nobody has taken, in order of their numbers.
#[derive(Debug, Default)]
pub(crate) struct Questions(Mutex<(u64, Vec<Question>)>);

impl Questions {
    fn lock(&self) -> MutexGuard<'_, (u64, Vec<Question>)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks for a value, and returns the number of the question.
    pub(crate) fn ask(&self, name: &str) -> u64 {
        let mut kept = self.lock();
        let (last, list) = &mut *kept;
        *last += 1;
        if list.len() >= MAX_KEPT {
            list.remove(0);
        }
        list.push(Question { number: *last, name: name.into(), answer: None });
        *last
    }

    /// Takes the answer to a question: `None` while there is none. A question that is not known has none.
    pub(crate) fn take(&self, number: u64) -> Option<Option<f64>> {
        let (_, list) = &mut *self.lock();
        let Some(at) = list.iter().position(|q| q.number == number) else { return Some(None) };
        let answer = list.get(at)?.answer?;
        list.remove(at);
        Some(answer)
    }

    /// Control side: answers every question.
    pub(crate) fn answer(&self, value: impl Fn(&str) -> Option<f64>) {
        let (_, list) = &mut *self.lock();
        for question in list.iter_mut().filter(|q| q.answer.is_none()) {
            question.answer = Some(value(&question.name));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_taken_once_and_is_of_its_own_time() {
        let questions = Questions::default();
        let (a, b) = (questions.ask("a"), questions.ask("b"));
        assert_eq!(questions.take(a), None, "nobody has answered");
        questions.answer(|name| (name == "a").then_some(1.5));
        questions.answer(|_| Some(7.0));
        assert_eq!((questions.take(b), questions.take(a)), (Some(None), Some(Some(1.5))));
        assert_eq!(questions.take(a), Some(None), "it is taken");
    }

    #[test]
    fn questions_that_nobody_follows_are_bounded() {
        let questions = Questions::default();
        let first = questions.ask("first");
        let last = (0..MAX_KEPT).map(|_| questions.ask("more")).last().unwrap_or(first);
        questions.answer(|_| Some(1.0));
        assert_eq!((questions.take(first), questions.take(last)), (Some(None), Some(Some(1.0))));
    }
}
