//! Messages of a session on standard error: text for people, objects for programs (`--json`).

use crate::{
    Captured, Error, Fault, Session, Terminal,
    ini::IniWarning,
    language::lex::Line,
    language::syntax::excerpt,
    session::dry_run::{Notice, Refusal},
    terminal::colour,
};
use hal_output::Unwritten;
use hal_protocol::{At, Code, Link};
use serde_json::{Value, json};

impl Session<'_> {
    /// Reports an error outside a script.
    pub fn report(&mut self, error: &Error) {
        self.error(&error.clone().into(), None);
    }

    /// Prints the warnings about a file. Each has its place already.
    pub fn warn(&mut self, warnings: &[IniWarning]) {
        for warning in warnings {
            self.info(&warning.to_string());
        }
    }

    /// Reports an error: preceding messages, error, following messages, remedy. A person also sees
    /// the line with a mark under the wrong part.
    pub(crate) fn error(&mut self, fault: &Fault, line: Option<&Line>) {
        let error = &fault.error;
        if **error == Error::AlreadyReported {
            return;
        }
        let (file, number) = self.place();
        let at = At::new(file, number);
        if let Some(dry_run) = &mut self.dry_run {
            dry_run.refusals.push(Refusal { at, error: Error::clone(error) });
        } else if self.style.json {
            self.object(&json!({ "error": object(fault, &at, line) }));
        } else {
            self.print_error(fault, line);
        }
    }

    fn print_error(&mut self, fault: &Fault, line: Option<&Line>) {
        let error = &fault.error;
        let coloured = self.terminal.is_coloured();
        if !self.style.silent {
            for line in error.before() {
                self.warn_at(&line);
            }
        }
        if !self.style.silent || !fault.quiet {
            let (file, line) = self.place();
            let text = colour::error(&format!("{file}:{line}: {error}"), coloured);
            self.terminal.err(&format!("{text}\n"));
        }
        for text in &fault.after {
            self.warn_at(text);
        }
        let hint = error.hint();
        if self.terminal.is_person() {
            if let (Some(line), Some(at)) = (line, &fault.at)
                && let Some(excerpt) = excerpt(line, at)
            {
                self.terminal.err(&colour::mark(&excerpt, coloured));
            }
            if let Some(hint) = hint {
                self.terminal.err(&format!("{hint}\n"));
            }
        } else if let Some(hint) = hint.filter(|_| !self.style.silent) {
            self.warn_at(&hint);
        }
    }

    /// Reports a refused line of another file.
    pub(crate) fn refuse(&mut self, at: &At, error: &Error) {
        if self.style.json {
            let fault = error.clone().into();
            self.object(&json!({ "error": object(&fault, at, None) }));
        } else {
            let text = colour::error(&format!("{at}: {error}"), self.terminal.is_coloured());
            self.terminal.err(&format!("{text}\n"));
        }
    }

    /// Prints a message with the place of the line that is being executed.
    pub(crate) fn warn_at(&mut self, text: &str) {
        self.place_message(Code::Refused, text);
    }

    /// Prints a warning with the place of the line that is being executed; `check` reports it under this code.
    pub(crate) fn warn_as(&mut self, code: Code, text: &str) {
        self.place_message(code, &format!("Warning: {text}"));
    }

    fn place_message(&mut self, code: Code, text: &str) {
        let (file, line) = self.place();
        let at = At::new(file, line);
        if let Some(dry_run) = &mut self.dry_run {
            dry_run.notices.push(Notice { at, code, text: text.to_owned() });
        } else if self.style.json {
            let place = json!({ "file": at.file, "line": at.line, "text": text });
            self.object(&json!({ "message": place }));
        } else {
            self.terminal.err(&format!("{}:{}: {text}\n", at.file, at.line));
        }
    }

    /// Writes to standard output, or to the result of a Tcl script's command.
    pub(crate) fn out(&mut self, text: &str) -> Result<(), Unwritten> {
        match &mut self.returned {
            Some(returned) => {
                returned.push_str(text);
                Ok(())
            }
            None => self.terminal.out(text),
        }
    }

    /// Runs a command that prints by itself.
    pub(crate) fn printed_by(
        &mut self,
        print: impl FnOnce(&mut dyn Link, &mut dyn Terminal) -> Result<u8, Error>,
    ) -> Result<u8, Error> {
        if self.returned.is_none() {
            return print(self.link, self.terminal);
        }
        let mut kept = Captured::default();
        let status = print(self.link, &mut kept)?;
        self.terminal.err(&kept.err);
        self.out(&kept.out)?;
        Ok(status)
    }

    /// Prints a message if `-v` was given. A Tcl script gets it as a part of the result.
    pub(crate) fn note(&mut self, text: &str) {
        if let Some(returned) = &mut self.returned {
            returned.push_str(text);
            returned.push('\n');
        } else if self.style.verbose {
            self.warn_at(text);
        }
    }

    /// Prints a message without a place, or with its own.
    pub(crate) fn info(&mut self, text: &str) {
        if self.style.json {
            self.object(&json!({ "message": { "text": text } }));
        } else {
            self.terminal.err(&format!("{text}\n"));
        }
    }

    /// Prints a line for `echo`.
    pub(crate) fn echo_line(&mut self, line: u32, text: &str) {
        if self.style.json {
            self.object(&json!({ "echo": { "line": line, "text": text } }));
        } else {
            self.terminal.err(&format!("({line})<echo>: {text}\n"));
        }
    }

    fn object(&mut self, object: &Value) {
        self.terminal.err(&format!("{object}\n"));
    }
}

/// Returns an error as an object, for programs without a session.
pub(crate) fn lone_object(error: &Error) -> String {
    let text = json!({ "error": object(&error.clone().into(), &At::new("", 0), None) });
    format!("{text}\n")
}

/// Returns an error as an object: place, text, remedy, preceding and following messages.
fn object(fault: &Fault, at: &At, line: Option<&Line>) -> Value {
    let error = &fault.error;
    let source = line.and_then(|line| line.text.as_ref().ok());
    let span = fault.at.as_ref().filter(|_| source.is_some());
    let mut object = json!({
        "file": at.file,
        "line": at.line,
        "text": error.to_string(),
        "hint": error.hint(),
        "before": error.before(),
        "after": fault.after,
        "source": source,
        "span": span.map(|span| [span.start, span.end]),
    });
    if let (Error::Engine(failure), Some(fields)) = (&**error, object.as_object_mut()) {
        fields.insert("code".to_owned(), failure.code.into());
    }
    object
}
