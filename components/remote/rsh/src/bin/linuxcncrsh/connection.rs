//! A connection: its lines, one after the other.

use crate::engine::{Engine, Served};
use rsh::{Lines, Machine as _, Next, Session, is_stop};
use std::{
    io::{ErrorKind, Read as _, Write as _},
    net::TcpStream,
    time::Duration,
};

/// Interval of the looks for a stop while a command is waited for.
const LOOK: Duration = Duration::from_millis(10);
/// Time after which a client that does not read its replies is left.
const PATIENCE: Duration = Duration::from_secs(5);

/// The lines that a client sends.
#[derive(Debug)]
pub(crate) struct Input {
    stream: TcpStream,
    lines: Lines,
    /// True after the last byte.
    ended: bool,
    /// True once a stop has ended a wait: what was sent before it is left out.
    stopped: bool,
}

impl Input {
    fn new(stream: TcpStream) -> Self {
        Self { stream, lines: Lines::default(), ended: false, stopped: false }
    }

    /// Reads what has arrived, for at most this time.
    fn read(&mut self, most: Option<Duration>) -> std::io::Result<()> {
        self.stream.set_read_timeout(most)?;
        let mut bytes = [0; 4096];
        match self.stream.read(&mut bytes) {
            Ok(0) => self.ended = true,
            Ok(n) => self.lines.push(bytes.get(..n).unwrap_or_default()),
            Err(e) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
        Ok(())
    }

    /// Looks whether a stop has arrived, or the connection is cut, while a command is waited for. What a script sends at once
    /// is executed in its order: a stop ends the wait only if it comes when `waits_long`.
    pub(crate) fn look(&mut self, waits_long: bool) -> Result<(), String> {
        let before = self.lines.waiting().count();
        if self.ended || !self.lines.has_room() {
            // Lines before the end are still executed.
            crate::pause(LOOK);
        } else {
            self.read(Some(LOOK)).map_err(|e| hal_output::reason(&e))?;
        }
        if waits_long && self.lines.waiting().skip(before).any(is_stop) {
            self.stopped = true;
            return Err("a stop has come meanwhile".to_owned());
        }
        Ok(())
    }

    /// Returns the next line, with whether a stop after it makes it void; `None` at the end.
    fn next_line(&mut self) -> std::io::Result<Option<(String, bool)>> {
        loop {
            if let Some(line) = self.lines.next_line() {
                if is_stop(&line) {
                    self.stopped = false;
                }
                return Ok(Some((line, self.stopped)));
            }
            if self.ended {
                return Ok(None);
            }
            self.read(None)?;
        }
    }

    fn reply(&mut self, text: &str) -> std::io::Result<()> {
        self.stream.write_all(text.as_bytes())
    }
}

/// Serves a connection until its end. Then the session has no control any more: its jogs stop.
pub(crate) fn run(stream: TcpStream, id: u64, source: &Served) {
    let prepared = stream.set_write_timeout(Some(PATIENCE)).and_then(|()| stream.set_nodelay(true));
    let Ok(mut engine) = Engine::new(source, id, Input::new(stream)) else { return };
    // A connection that is cut ends as one that is closed.
    drop(prepared.and_then(|()| lines(&mut engine, source)));
    engine.give();
}

fn lines(engine: &mut Engine, source: &Served) -> std::io::Result<()> {
    let mut session = Session::default();
    while let Some((line, void)) = engine.input.next_line()? {
        if void && let Some(reply) = session.left_out(&line) {
            engine.input.reply(&reply)?;
            continue;
        }
        let (reply, next) = session.line(&line, &source.passwords, engine);
        engine.input.reply(&reply)?;
        match next {
            Next::Line => {}
            Next::Close => break,
            Next::ShutDown => {
                // An engine that does not answer has ended.
                drop(engine.shut_down());
                break;
            }
        }
    }
    Ok(())
}
