//! Values of HAL that a line of the program reads, asked for when motion has come to rest before it.

use crate::outside::Outside;
use hal_gcode::Answer;

/// A value that was asked for.
#[derive(Clone, Debug)]
pub(super) struct HalQuestion {
    number: u64,
    /// `Some(None)` if nothing has the name.
    answer: Option<Option<f64>>,
}

/// Asks for the values of these names, and returns the answer to the interpreter once all are known. NaN and infinity
/// are failures, so that no coordinate is one of them.
pub(super) fn answer(
    questions: &mut Vec<HalQuestion>,
    names: &[Box<str>],
    out: &mut impl Outside,
) -> Option<Answer> {
    if questions.is_empty() {
        let mut ask = |name: &str| HalQuestion { number: out.ask_value(name), answer: None };
        *questions = names.iter().map(|name| ask(name)).collect();
    }
    for question in questions.iter_mut().filter(|q| q.answer.is_none()) {
        question.answer = out.take_value(question.number);
    }
    if questions.iter().any(|q| q.answer.is_none()) {
        return None;
    }
    let answers = questions.drain(..).map(|q| q.answer.flatten());
    let values: Vec<_> = names.iter().cloned().zip(answers).collect();
    let wrong = values.iter().find(|(_, value)| value.is_some_and(|v| !v.is_finite()));
    if let Some((name, Some(value))) = wrong {
        return Some(Answer::Failed(
            format!("{name} is {value}, which is not a finite number").into(),
        ));
    }
    Some(Answer::Hal(values))
}
