//! The line editor: keys, history and colours. It requests everything else from the session's
//! thread.

use super::{Event, Order, aside};
use crate::{language::table, manual::complete::Completion};
use rustyline::{
    Cmd, CompletionType, ConditionalEventHandler, Config, Context, Editor, EventContext,
    EventHandler, Helper, KeyEvent, RepeatCount,
    completion::{Completer, Pair},
    config::{BellStyle, ColorMode},
    error::ReadlineError,
    highlight::Highlighter,
    hint::Hinter,
    history::FileHistory,
    validate::Validator,
};
use std::{
    borrow::Cow,
    cell::Cell,
    path::Path,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, Sender},
    },
};

const FIRST: &str = "halcmd: ";
const NEXT: &str = "halcmd+: ";
/// Number of lines in the history.
const REMEMBERED: usize = 2000;

/// Reads lines as ordered until the channel closes. `local` means that the machine is in this
/// process.
pub(super) fn run(
    orders: &Receiver<Order>,
    say: &Sender<Event>,
    answers: Receiver<Completion>,
    local: bool,
) {
    let coloured = hal_output::is_coloured(std::io::stdout());
    let assistant = Assistant { say: say.clone(), answers, coloured, begun: Cell::new(true) };
    let Ok(mut editor) = editor(assistant, coloured) else {
        drop(say.send(Event::End));
        return;
    };
    let empty = Arc::new(AtomicBool::new(true));
    let noticed = Box::new(Interruption { empty: Arc::clone(&empty) });
    editor.bind_sequence(KeyEvent::ctrl('C'), EventHandler::Conditional(noticed));
    if local {
        // Stopping this process would stop the machine in the middle of a cycle.
        editor.bind_sequence(KeyEvent::ctrl('Z'), Cmd::Noop);
    }
    if let Ok(printer) = editor.create_external_printer() {
        aside::print_with(printer);
    }
    let history = hal_output::state_file("history");
    if let Some(file) = &history {
        // The first time, there is no file.
        drop(editor.load_history(file));
    }
    while let Ok(Order::Read { continuing }) = orders.recv() {
        // A signal from outside counts as Ctrl-C on an empty line.
        empty.store(true, Ordering::SeqCst);
        editor.helper().inspect(|assistant| assistant.begun.set(false));
        let event = match editor.readline(if continuing { NEXT } else { FIRST }) {
            Ok(line) => {
                let new = !line.trim().is_empty() && editor.add_history_entry(&line).is_ok();
                if let (true, Some(file)) = (new, &history) {
                    keep(&mut editor, file);
                }
                Event::Line(line)
            }
            // Pairs with the store in `Interruption`, which is on this thread.
            Err(ReadlineError::Interrupted) => {
                Event::Interrupted { empty: empty.load(Ordering::SeqCst) }
            }
            Err(_) => Event::End,
        };
        if say.send(event).is_err() {
            return;
        }
    }
}

/// Appends the last line, keeping lines that other prompts have appended. Errors are ignored,
/// because a missing history should not stop the prompt.
fn keep(editor: &mut Editor<Assistant, FileHistory>, file: &Path) {
    let kept = if file.exists() { editor.append_history(file) } else { editor.save_history(file) };
    drop(kept);
}

fn editor(
    assistant: Assistant,
    coloured: bool,
) -> Result<Editor<Assistant, FileHistory>, ReadlineError> {
    let config = Config::builder()
        .max_history_size(REMEMBERED)?
        .history_ignore_dups(true)?
        .history_ignore_space(true)
        .completion_type(CompletionType::List)
        .bell_style(BellStyle::None)
        .color_mode(if coloured { ColorMode::Enabled } else { ColorMode::Disabled })
        .build();
    let mut editor = Editor::with_config(config)?;
    editor.set_helper(Some(assistant));
    Ok(editor)
}

/// Records whether Ctrl-C was pressed on an empty line.
struct Interruption {
    empty: Arc<AtomicBool>,
}

impl ConditionalEventHandler for Interruption {
    fn handle(
        &self,
        _: &rustyline::Event,
        _: RepeatCount,
        _: bool,
        context: &EventContext<'_>,
    ) -> Option<Cmd> {
        // Pairs with the load after `readline`.
        self.empty.store(context.line().is_empty(), Ordering::SeqCst);
        Some(Cmd::Interrupt)
    }
}

/// The editor's access to completion and help while a line is typed.
struct Assistant {
    say: Sender<Event>,
    answers: Receiver<Completion>,
    coloured: bool,
    /// True once [`Event::Begun`] has been sent.
    begun: Cell<bool>,
}

impl Helper for Assistant {}
impl Validator for Assistant {}

impl Completer for Assistant {
    type Candidate = Pair;

    fn complete(
        &self,
        line: &str,
        at: usize,
        _: &Context<'_>,
    ) -> Result<(usize, Vec<Pair>), ReadlineError> {
        let line = line.get(..at).unwrap_or(line).to_owned();
        let asked = self.say.send(Event::Complete(line)).is_ok();
        let found = if asked { self.answers.recv().ok() } else { None };
        let found = found.ok_or(ReadlineError::Eof)?;
        let pair = |c: crate::manual::complete::Candidate| Pair {
            replacement: if c.is_open() { c.word.clone() } else { format!("{} ", c.word) },
            display: c.word,
        };
        Ok((found.at, found.candidates.into_iter().map(pair).collect()))
    }
}

impl Hinter for Assistant {
    type Hint = Usage;

    /// Returns the arguments of the command that was just typed.
    fn hint(&self, line: &str, at: usize, _: &Context<'_>) -> Option<Usage> {
        // The editor calls this whenever it draws the line, so also before the first key.
        if !self.begun.replace(true) {
            self.say.send(Event::Begun).ok()?;
        }
        let name = line.strip_suffix(' ').filter(|_| self.coloured && at == line.len())?;
        let row = table::find(name).filter(|row| !row.usage.is_empty())?;
        Some(Usage(table::line(row).split_off(name.len() + 1)))
    }
}

/// The arguments of a command, shown as a hint that cannot be accepted into the line.
struct Usage(String);

impl rustyline::hint::Hint for Usage {
    fn display(&self) -> &str {
        &self.0
    }

    fn completion(&self) -> Option<&str> {
        None
    }
}

impl Highlighter for Assistant {
    fn highlight_prompt<'b, 's: 'b, 'p: 'b>(&'s self, prompt: &'p str, _: bool) -> Cow<'b, str> {
        Cow::Owned(format!("\x1b[1m{prompt}\x1b[0m"))
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        Cow::Owned(format!("\x1b[2m{hint}\x1b[0m"))
    }
}
