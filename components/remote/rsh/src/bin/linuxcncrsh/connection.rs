//! A connection: its lines, one after the other.

use crate::engine::{Engine, Served, lock};
use hal_lease::EpochPage;
use rsh::{Lines, Machine as _, Next, Session, is_stop};
use std::{
    collections::VecDeque,
    io::{ErrorKind, Read as _, Write as _},
    net::TcpStream,
    sync::Arc,
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
    /// Stop epochs in which the lines that wait have arrived; `None` is that of their execution.
    epochs: VecDeque<Option<u64>>,
    source: Arc<Served>,
    /// True after the last byte.
    ended: bool,
    /// True once a stop has ended a wait: what was sent before it is left out.
    stopped: bool,
}

impl Input {
    pub(crate) fn new(stream: TcpStream, source: Arc<Served>) -> Self {
        let (lines, epochs) = (Lines::default(), VecDeque::new());
        Self { stream, lines, epochs, source, ended: false, stopped: false }
    }

    /// Forgets when the lines that wait have arrived: a line before them is the stop that ended that epoch.
    pub(crate) fn forget_epochs(&mut self) {
        self.epochs.iter_mut().for_each(|epoch| *epoch = None);
    }

    /// Reads what has arrived, for at most this time.
    fn read(&mut self, most: Option<Duration>) -> std::io::Result<()> {
        self.stream.set_read_timeout(most)?;
        let mut bytes = [0; 4096];
        match self.stream.read(&mut bytes) {
            Ok(0) => self.ended = true,
            Ok(n) => {
                self.lines.push(bytes.get(..n).unwrap_or_default());
                let epoch = lock(&self.source.epochs).as_mut().and_then(EpochPage::read);
                let epoch = epoch.map(|(_, epoch)| epoch);
                self.epochs.resize(self.lines.waiting().count(), epoch);
            }
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

    /// Returns the next line, with whether a stop after it makes it void, and the stop epoch in which it has arrived; `None` at
    /// the end.
    fn next_line(&mut self) -> std::io::Result<Option<(String, bool, Option<u64>)>> {
        loop {
            if let Some(line) = self.lines.next_line() {
                if is_stop(&line) {
                    self.stopped = false;
                }
                let epoch = self.epochs.pop_front().flatten();
                return Ok(Some((line, self.stopped, epoch)));
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
pub(crate) fn run(stream: TcpStream, id: u64, source: &Arc<Served>) {
    let prepared = stream.set_write_timeout(Some(PATIENCE)).and_then(|()| stream.set_nodelay(true));
    let mut engine = Engine::new(source, id, stream);
    // A connection that is cut ends as one that is closed.
    drop(prepared.and_then(|()| lines(&mut engine, source)));
    engine.give();
}

fn lines(engine: &mut Engine, source: &Served) -> std::io::Result<()> {
    let mut session = Session::default();
    while let Some((line, void, epoch)) = engine.input.next_line()? {
        engine.given = epoch;
        if void && let Some(reply) = session.left_out(&line) {
            engine.input.reply(&reply)?;
            continue;
        }
        let (reply, next) = session.line(&line, &source.passwords, engine);
        if session.is_greeted() && engine.link().is_none() {
            // There is no machine for it: the hello was of no use.
            return engine.input.reply("HELLO NAK\r\n");
        }
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
