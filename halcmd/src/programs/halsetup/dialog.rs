//! The conversation in the terminal.

use super::{
    questions::{Asked, sequence},
    rules::told,
    sheet::Sheet,
};

/// Words that are no answers.
const WORDS: &str = "Enter takes what stands in brackets; none for nothing; back to the question before; save to go on later; ? for help";

/// Function that prints a question and returns the line that answers it, or nothing at the end of the input.
pub(super) type Ask<'a> = dyn FnMut(&str) -> Result<Option<String>, String> + 'a;

/// A conversation.
pub(super) struct Dialog<'a> {
    pub(super) ask: &'a mut Ask<'a>,
    /// Keeps the answers so far.
    pub(super) keep: &'a mut dyn FnMut(&Sheet) -> Result<(), String>,
    /// Returns why a machine cannot have this name.
    pub(super) taken: &'a mut dyn FnMut(&str) -> Option<String>,
}

/// End of a conversation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    /// Each question is answered.
    Answered,
    /// The person goes on later.
    Saved,
    /// The input has ended.
    Ended,
}

impl Dialog<'_> {
    /// Asks what the sheet does not answer yet.
    pub(super) fn questions(&mut self, sheet: &mut Sheet) -> Result<Ending, String> {
        let mut before = format!("{WORDS}.\n");
        // Answer that a person has gone back over, as the default of its question.
        let mut former: Option<(String, String)> = None;
        loop {
            let questions = sequence(sheet);
            let open = questions.iter().position(|asked| sheet.get(&asked.key).is_none());
            let Some(n) = open else { return Ok(Ending::Answered) };
            let Some(asked) = questions.get(n) else { return Ok(Ending::Answered) };
            let mut asked = asked.clone();
            if let Some((_, text)) = former.as_ref().filter(|(key, _)| *key == asked.key) {
                asked.default.clone_from(text);
            }
            let prompt = format!("{before}{}", asked.prompt(sheet));
            before.clear();
            let Some(line) = (self.ask)(&prompt)? else { return Ok(Ending::Ended) };
            match line.trim() {
                "?" => before = help(&asked, sheet),
                "save" => return Ok(Ending::Saved),
                "back" => match n.checked_sub(1).and_then(|n| questions.get(n)) {
                    Some(last) => {
                        former = sheet.remove(&last.key).map(|text| (last.key.clone(), text));
                        (self.keep)(sheet)?;
                    }
                    None => "this is the first question\n".clone_into(&mut before),
                },
                line => {
                    let answer = match line {
                        "" => asked.default.as_str(),
                        "none" => "",
                        line => line,
                    };
                    let is_name = asked.key == "name";
                    let why = told(sheet, &asked, answer)
                        .or_else(|| is_name.then(|| (self.taken)(answer)).flatten());
                    if let Some(text) = why {
                        before = format!("{text}\n");
                    } else {
                        sheet.put(&asked.key, answer);
                        (self.keep)(sheet)?;
                    }
                }
            }
        }
    }
}

/// Returns the help of a question.
fn help(asked: &Asked, sheet: &Sheet) -> String {
    let mut text = format!("{} Accepted: {}.\n", asked.question.help, asked.accepts(sheet));
    if asked.question.key == "board" {
        for board in super::boards::BOARDS {
            text.push_str(&format!("  {:<11} {}\n", board.name, board.about));
        }
    }
    text.push_str(&format!("{WORDS}.\n"));
    text
}
