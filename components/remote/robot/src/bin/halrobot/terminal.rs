//! The terminal: a person, or lines of standard input, and a controller.

use crate::{
    device::{self, Device},
    print,
};
use robot::{Console, ConsoleOptions, ConsoleRequest, LogEntry, LogKind};
use rustyline::{
    Editor, ExternalPrinter, config::BellStyle, error::ReadlineError, history::FileHistory,
};
use std::{
    fs,
    io::{BufRead, ErrorKind, Read, Write as _},
    path::{Path, PathBuf},
    sync::mpsc::{RecvTimeoutError, SyncSender, channel, sync_channel},
    thread,
    time::{Duration, Instant},
};

/// Largest number of lines and segments that wait for their turn.
const MAX_WAITING: usize = 64;
/// Longest line of standard input, in bytes: more than a controller is sent.
const MAX_INPUT: usize = 8192;
/// Number of lines in the history.
const REMEMBERED: usize = 2000;
const PROMPT: &str = "robot: ";

/// Options of the terminal.
#[derive(clap::Args)]
#[group(skip)]
pub(crate) struct TerminalOptions {
    /// Address and port of the controller.
    #[arg(long, required_unless_present = "serial", conflicts_with = "serial")]
    to: Option<String>,
    /// Serial line of the controller, as /dev/ttyUSB0; 8 data bits, no parity, 1 stop bit.
    #[arg(long)]
    serial: Option<PathBuf>,
    /// Speed of the serial line, in Bd.
    #[arg(long, default_value_t = 9600)]
    baud: u32,
    /// End of a line that is sent: cr, lf or crlf.
    #[arg(long, default_value = "crlf", value_parser = ["cr", "lf", "crlf"])]
    eol: String,
    /// Begin of a line or a prompt that is an answer; may be repeated. Without it, every line and every prompt is one.
    #[arg(long)]
    answer: Vec<String>,
    /// Text that the controller sends before anything is sent to it.
    #[arg(long)]
    begin: Option<String>,
    /// Time for an answer, in seconds, while a file is sent or standard input is no terminal.
    #[arg(long, default_value_t = 60.0)]
    timeout: f64,
    /// File of the history of typed lines; without it, one in the user's state folder.
    #[arg(long)]
    history: Option<PathBuf>,
}

/// Something that happens.
enum Happening {
    Typed(String),
    TypedEnd,
    /// Standard input is no text from here on, with the reason.
    Unusable(String),
    Received(Vec<u8>),
    /// The controller has gone, with the reason.
    Gone(String),
}

/// Log, on the screen or on standard output.
struct Log {
    printer: Option<Box<dyn ExternalPrinter + Send>>,
    is_coloured: bool,
}

/// Talks until the person or the controller ends it.
#[expect(
    clippy::disallowed_methods,
    reason = "a program at the edge: the controller lives in real time"
)]
pub(crate) fn talk(options: &TerminalOptions) -> Result<(), String> {
    // NaN is refused too.
    if !(0.0 < options.timeout && options.timeout < 1e6) {
        return Err(format!("--timeout {}: must be a number above 0", options.timeout));
    }
    let Device { from, mut to } = match (&options.to, &options.serial) {
        (_, Some(path)) => device::open(path, options.baud)?,
        (Some(to), None) => device::connect(to)?,
        (None, None) => return Err("--to or --serial is needed".to_owned()),
    };
    let is_person = is_terminal(std::io::stdin()) && is_terminal(std::io::stdout());
    let line_end = match options.eol.as_str() {
        "cr" => "\r",
        "lf" => "\n",
        _ => "\r\n",
    };
    let dialogue = ConsoleOptions {
        line_end,
        answers: options.answer.clone(),
        begin: options.begin.clone(),
        timeout: options.timeout,
        is_queued: !is_person,
    };
    let begin = Instant::now();
    let now = || begin.elapsed().as_secs_f64();
    let mut console = Console::new(dialogue, now());
    // A controller or a file that sends faster than the log is printed has to wait.
    let (send, receive) = sync_channel(MAX_WAITING);
    let mut log = Log { printer: None, is_coloured: hal_output::is_coloured(std::io::stdout()) };
    receive_from(from, send.clone());
    if is_person {
        log.printer = Some(type_lines(
            send,
            options.history.clone().or_else(|| hal_output::state_file("robot-history")),
        )?);
    } else {
        read_lines(send);
    }
    let mut has_ended = false;
    loop {
        let wait = console.next().map(|at| Duration::from_secs_f64(f64::max(0.0, at - now())));
        let happening = match wait {
            None => receive.recv().map_err(|_| RecvTimeoutError::Disconnected),
            Some(wait) => receive.recv_timeout(wait),
        };
        let mut is_gone = false;
        let mut request = None;
        match happening {
            Ok(Happening::Typed(line)) => request = console.enter(&line, now()),
            Ok(Happening::TypedEnd) => has_ended = true,
            Ok(Happening::Unusable(why)) => {
                console.fail(&why);
                has_ended = true;
            }
            Ok(Happening::Received(bytes)) => console.receive(&bytes, now()),
            Ok(Happening::Gone(why)) => {
                console.closed(&why);
                is_gone = true;
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => is_gone = true,
        }
        console.poll(now());
        while let Some(wanted) = request.take().or_else(|| console.turn(now())) {
            match wanted {
                ConsoleRequest::Quit => return finish(&mut console, &mut log),
                ConsoleRequest::Read(name) => match fs::read_to_string(&name) {
                    Ok(text) => console.send_file(&name, &text, now()),
                    Err(e) => console.fail(&format!("{name}: {}", hal_output::reason(&e))),
                },
            }
        }
        let bytes = console.output();
        if let Err(e) = to.write_all(&bytes).and_then(|()| to.flush()) {
            console.fail("the last line was not sent");
            console.closed(&hal_output::reason(&e));
            is_gone = true;
        }
        log.show(&mut console)?;
        let is_useless = console.is_mute() && !is_person;
        if is_gone || is_useless || has_ended && (is_person || console.is_idle()) {
            return finish(&mut console, &mut log);
        }
    }
}

/// Prints what is left of the log. A failure of lines that nobody watched is one of the program.
fn finish(console: &mut Console, log: &mut Log) -> Result<(), String> {
    log.show(console)?;
    let is_person = log.printer.is_some();
    if console.has_failed() && !is_person {
        return Err("not everything was sent and answered".to_owned());
    }
    Ok(())
}

impl Log {
    fn show(&mut self, console: &mut Console) -> Result<(), String> {
        for entry in console.log() {
            let text = self.line(&entry);
            match &mut self.printer {
                Some(printer) => printer.print(text).map_err(|e| e.to_string())?,
                None => print(&text)?,
            }
        }
        Ok(())
    }

    /// Returns an entry as a line: what is sent as the terminal writes, what is received in red, errors in bold magenta.
    fn line(&self, entry: &LogEntry) -> String {
        let (mark, colour) = match entry.kind {
            LogKind::Sent => ('>', ""),
            LogKind::Received => ('<', "\x1b[31m"),
            LogKind::Error => ('!', "\x1b[1;35m"),
            LogKind::Note => ('#', "\x1b[2m"),
        };
        let text = &entry.text;
        if self.is_coloured && !colour.is_empty() {
            format!("{colour}{mark} {text}\x1b[0m\n")
        } else {
            format!("{mark} {text}\n")
        }
    }
}

fn is_terminal(file: impl std::os::fd::AsFd) -> bool {
    rustix::termios::isatty(file)
}

/// Receives in a thread of its own.
fn receive_from(mut from: Box<dyn Read + Send>, send: SyncSender<Happening>) {
    thread::spawn(move || {
        let mut buffer = [0; 4096];
        loop {
            let happening = match from.read(&mut buffer) {
                Ok(0) => Happening::Gone("the controller has closed the connection".to_owned()),
                Ok(count) => Happening::Received(buffer.get(..count).unwrap_or_default().to_vec()),
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                Err(e) => Happening::Gone(hal_output::reason(&e)),
            };
            let is_last = matches!(happening, Happening::Gone(_));
            if send.send(happening).is_err() || is_last {
                return;
            }
        }
    });
}

/// Reads lines of standard input in a thread of its own.
fn read_lines(send: SyncSender<Happening>) {
    thread::spawn(move || {
        let mut input = std::io::stdin().lock();
        let mut number = 0_u64;
        loop {
            number += 1;
            let happening = match line(&mut input) {
                Ok(None) => Happening::TypedEnd,
                Ok(Some(text)) => Happening::Typed(text),
                Err(why) => Happening::Unusable(format!("standard input, line {number}: {why}")),
            };
            let is_last = !matches!(happening, Happening::Typed(_));
            if send.send(happening).is_err() || is_last {
                return;
            }
        }
    });
}

/// Reads a line without its end; `None` at the end of the input.
fn line(input: &mut impl BufRead) -> Result<Option<String>, String> {
    let mut bytes = Vec::new();
    let most = u64::try_from(MAX_INPUT).unwrap_or(u64::MAX);
    let read = input.take(most).read_until(b'\n', &mut bytes);
    read.map_err(|e| hal_output::reason(&e))?;
    if bytes.is_empty() {
        return Ok(None);
    }
    if bytes.len() >= MAX_INPUT && !bytes.ends_with(b"\n") {
        return Err(format!("the line has more than {MAX_INPUT} bytes"));
    }
    let text = String::from_utf8(bytes).map_err(|_| "the line is not UTF-8".to_owned())?;
    Ok(Some(text.trim_end_matches(['\n', '\r']).to_owned()))
}

/// Lets a person type lines in a thread of its own, with a history; returns the way to print beside the line.
fn type_lines(
    send: SyncSender<Happening>,
    history: Option<PathBuf>,
) -> Result<Box<dyn ExternalPrinter + Send>, String> {
    let failed = |e: ReadlineError| e.to_string();
    let config = rustyline::Config::builder()
        .max_history_size(REMEMBERED)
        .map_err(failed)?
        .history_ignore_dups(true)
        .map_err(failed)?
        .bell_style(BellStyle::None)
        .build();
    let mut editor = Editor::<(), FileHistory>::with_config(config).map_err(failed)?;
    let printer = editor.create_external_printer().map_err(failed)?;
    if let Some(file) = &history {
        // The first time, there is no file.
        drop(editor.load_history(file));
    }
    // The editor never waits for room in the queue: the queue's reader may wait for the editor, which prints for it.
    let (typed, lines) = channel();
    thread::spawn(move || drop(lines.into_iter().try_for_each(|happening| send.send(happening))));
    thread::spawn(move || {
        loop {
            let happening = match editor.readline(PROMPT) {
                Ok(line) => {
                    let is_new = !line.trim().is_empty() && editor.add_history_entry(&line).is_ok();
                    if let (true, Some(file)) = (is_new, &history) {
                        keep(&mut editor, file);
                    }
                    Happening::Typed(line)
                }
                Err(ReadlineError::Interrupted) => Happening::Typed(":stop".to_owned()),
                Err(_) => Happening::TypedEnd,
            };
            let is_last = matches!(happening, Happening::TypedEnd);
            if typed.send(happening).is_err() || is_last {
                return;
            }
        }
    });
    Ok(Box::new(printer))
}

/// Appends the last line, and keeps lines that other terminals have appended. A history that cannot be written stops nobody.
fn keep(editor: &mut Editor<(), FileHistory>, file: &Path) {
    let kept = if file.exists() { editor.append_history(file) } else { editor.save_history(file) };
    drop(kept);
}
