//! The questions in the terminal. Their answers become the TOML text that a file of answers has as well.

use std::fmt::Write as _;

/// The kind of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// A text.
    Text,
    /// A number.
    Number,
    /// A word of a list.
    OneOf(&'static [&'static str]),
    /// A line of the board, or nothing.
    Line,
}

/// A question: its key in the file, its text, what an empty answer means, and the form of its answer.
struct Question {
    key: &'static str,
    text: &'static str,
    default: &'static str,
    form: Form,
}

const fn ask(key: &'static str, text: &'static str, default: &'static str, form: Form) -> Question {
    Question { key, text, default, form }
}

const WHOLE: &[Question] = &[
    ask("name", "Name of the machine", "machine", Form::Text),
    ask("kind", "What moves it", "steppers", Form::OneOf(&["steppers", "servos", "arm"])),
    ask("driver", "Its inputs and outputs", "parport", Form::OneOf(&["parport", "viagpio"])),
    ask("units", "Unit of length", "mm", Form::OneOf(&["mm", "inch"])),
    ask("latency", "Largest jitter that a latency test showed, in ns", "50000", Form::Number),
];
const PINS: &[Question] = &[
    ask("estop", "Input of the e-stop chain, as 10; empty for none", "", Form::Line),
    ask("enable", "Output that switches the drives on; empty for none", "", Form::Line),
    ask("spindle", "Output that switches the spindle on; empty for none", "", Form::Line),
];
const PULSE: &[Question] = &[
    ask("length", "Length of a step, in ns", "5000", Form::Number),
    ask("space", "Space between two steps, in ns", "5000", Form::Number),
    ask("hold", "From a step to a change of the direction, in ns", "20000", Form::Number),
    ask("setup", "From a change of the direction to a step, in ns", "20000", Form::Number),
];
const AXIS: &[Question] = &[
    ask("min", "Lowest position", "-100", Form::Number),
    ask("max", "Highest position", "100", Form::Number),
    ask("velocity", "Largest velocity, in units a second", "50", Form::Number),
    ask("acceleration", "Largest acceleration, in units/s²", "500", Form::Number),
];
const JOINT: &[Question] = &[
    ask("turn", "Full steps of a turn of the motor, or edges of the encoder", "200", Form::Number),
    ask("microsteps", "Microsteps of a full step", "1", Form::Number),
    ask("gear", "Turns of the motor for a turn of the screw", "1", Form::Number),
    ask("pitch", "Way of a turn of the screw, in units", "5", Form::Number),
    ask("home", "Position after homing", "0", Form::Number),
    ask("step", "Output of the steps, or of a servo's power; empty for none", "", Form::Line),
    ask("direction", "Output of the direction; empty for none", "", Form::Line),
    ask("switch", "Input of its limit and home switch; empty for none", "", Form::Line),
];
const SEARCH: Question =
    ask("search", "Velocity at which homing looks for it, with its sign", "-5", Form::Number);
const SERVO: &[Question] = &[
    ask("a", "Input of the encoder's A", "", Form::Line),
    ask("b", "Input of the encoder's B", "", Form::Line),
    ask("full-speed", "Speed at full power, in units a second", "100", Form::Number),
];

/// Returns a wrong answer's message.
fn wrong(question: &Question, answer: &str) -> Option<String> {
    match question.form {
        Form::Text => None,
        // Numbers such as `.5` are none in TOML.
        Form::Number => (answer.parse::<f64>().is_err()
            || toml::from_str::<toml::Table>(&format!("x = {answer}")).is_err())
        .then(|| format!("'{answer}' is not a number, as {}", question.default)),
        Form::OneOf(words) => (!words.contains(&answer))
            .then(|| format!("'{answer}' is none of: {}", words.join(", "))),
        Form::Line => (!answer.is_empty() && super::lines::line(answer).is_none())
            .then(|| format!("'{answer}' is not a line, as 6, 1.11 or !6")),
    }
}

/// A conversation: prints a question and returns the line that answers it, or nothing at the end of the input.
pub(super) struct Dialog<'a> {
    pub(super) ask: &'a mut dyn FnMut(&str) -> Result<Option<String>, String>,
}

impl Dialog<'_> {
    /// Asks until the answer has the right form.
    fn answer(&mut self, question: &Question, of: &str) -> Result<String, String> {
        let hint = match question.form {
            Form::OneOf(words) => format!(" ({})", words.join(", ")),
            _ => String::new(),
        };
        let default = if question.default.is_empty() {
            String::new()
        } else {
            format!(" [{}]", question.default)
        };
        let mut before = String::new();
        loop {
            let prompt = format!("{before}{of}{}{hint}{default}: ", question.text);
            let Some(line) = (self.ask)(&prompt)? else {
                return Err(
                    "the questions were not answered to the end; nothing was written".to_owned()
                );
            };
            let line = line.trim();
            let answer = if line.is_empty() { question.default } else { line };
            match wrong(question, answer) {
                Some(text) => before = format!("{text}\n"),
                None => return Ok(answer.to_owned()),
            }
        }
    }

    /// Asks these questions and appends their answers.
    fn table(&mut self, questions: &[Question], of: &str, to: &mut String) -> Result<(), String> {
        for question in questions {
            let answer = self.answer(question, of)?;
            keep(question, &answer, to);
        }
        Ok(())
    }
}

fn keep(question: &Question, answer: &str, to: &mut String) {
    let value = match question.form {
        Form::Number => answer.to_owned(),
        _ if answer.is_empty() => return,
        _ => toml::Value::String(answer.to_owned()).to_string(),
    };
    let _: std::fmt::Result = writeln!(to, "{} = {value}", question.key);
}

/// Asks everything and returns the TOML text.
pub(super) fn questions(dialog: &mut Dialog<'_>) -> Result<String, String> {
    let mut to = String::from("# Answers for halsetup.\n");
    let mut kind = String::new();
    for question in WHOLE {
        let answer = dialog.answer(question, "")?;
        keep(question, &answer, &mut to);
        if question.key == "kind" {
            kind = answer;
        } else if question.key == "driver" && answer == "parport" {
            let ports = ask(
                "ports",
                "Addresses and directions of the ports, with commas",
                "378 out",
                Form::Text,
            );
            let answer = dialog.answer(&ports, "")?;
            let ports: Vec<toml::Value> = answer.split(',').map(|p| p.trim().into()).collect();
            let _: std::fmt::Result = writeln!(to, "ports = {}", toml::Value::Array(ports));
        }
    }
    let is_arm = kind == "arm";
    if is_arm {
        let model = ask("model", "Model of the arm", "rs03n", Form::OneOf(&["rs03n", "rx90"]));
        dialog.table(&[model], "", &mut to)?;
    }
    to.push_str("\n[pins]\n");
    dialog.table(PINS, "", &mut to)?;
    if kind != "servos" {
        to.push_str("\n[pulse]\n");
        dialog.table(PULSE, "", &mut to)?;
    }
    let letters = ask("", "Axes, a letter each", if is_arm { "XYZABC" } else { "XYZ" }, Form::Text);
    let letters = dialog.answer(&letters, "")?;
    if is_arm {
        for letter in letters.chars().filter(|c| !c.is_whitespace()) {
            let _: std::fmt::Result = write!(to, "\n[[axis]]\nletter = \"{letter}\"\n");
            dialog.table(AXIS, &format!("{letter}: "), &mut to)?;
        }
    }
    let joints: Vec<String> = if is_arm {
        (0..6).map(|n| format!("joint {n}")).collect()
    } else {
        letters.chars().filter(|c| !c.is_whitespace()).map(String::from).collect()
    };
    for joint in joints {
        to.push_str("\n[[joint]]\n");
        if !is_arm {
            let _: std::fmt::Result = writeln!(to, "axis = \"{joint}\"");
        }
        let of = format!("{joint}: ");
        dialog.table(AXIS, &of, &mut to)?;
        let from = to.len();
        dialog.table(JOINT, &of, &mut to)?;
        if to.get(from..).is_some_and(|t| t.contains("switch = ")) {
            dialog.table(&[SEARCH], &of, &mut to)?;
        }
        if kind == "servos" {
            dialog.table(SERVO, &of, &mut to)?;
        }
    }
    Ok(to)
}
