//! Realtime. A card that is simulated in the process, behind a line that may lose packets.

use crate::{
    config::{CardConfig, Limit},
    names,
};
use core::time::Duration;
use crossbeam::atomic::AtomicCell;
use hal_card::{Board, Card, Fate, FaultyLine, Rates};
use hal_firmware::{Module, Pin, Tag};
use hal_lbp16::MAX_PACKET;
use port::{Exchange, Lost};
use std::sync::Arc;

/// Simulated card, its line, and the packets on that.
pub(crate) struct Inside {
    pub(crate) card: Card,
    /// Moment up to which its time has gone on, in nanoseconds.
    now: Option<i64>,
    line: FaultyLine,
    rates: Rates,
    /// Number of times that the faults of the line were changed: the seed of its next ones.
    changes: u64,
    answers: [OnTheWay; ANSWERS],
    /// Number of answers that wait, the oldest first.
    waiting: usize,
    /// An answer that comes behind the next one.
    late: Option<OnTheWay>,
}

/// Most answers that wait: those to more questions are lost, as in a network.
const ANSWERS: usize = 4;

/// A packet on the line.
#[derive(Clone, Copy)]
struct OnTheWay {
    bytes: [u8; MAX_PACKET],
    len: usize,
}

impl OnTheWay {
    const NONE: Self = Self { bytes: [0; MAX_PACKET], len: 0 };
}

impl Inside {
    /// Sets the faults of the line.
    pub(crate) fn set_line(&mut self, rates: Rates, plugged: bool) {
        if rates != self.rates {
            self.changes += 1;
            self.rates = rates;
            self.line = FaultyLine::new(rates, self.changes);
        }
        self.line.break_cable(!plugged);
    }

    /// Carries a packet to the card, and its answer back.
    fn carry(&mut self, packet: &[u8]) {
        // Questions do not overtake each other.
        let fate = match self.line.carry(packet.len()) {
            Fate::Late => Fate::Delivered,
            fate => fate,
        };
        for len in fate.arrivals(packet.len()) {
            self.ask(packet.get(..len).unwrap_or_default());
        }
    }

    fn ask(&mut self, packet: &[u8]) {
        let mut answer = OnTheWay::NONE;
        let Some(len) = self.card.answer(packet, &mut answer.bytes) else { return };
        answer.len = len;
        let fate = self.line.carry(len);
        for len in fate.arrivals(len) {
            self.come(&OnTheWay { len, ..answer });
        }
        match fate {
            Fate::Late => self.late = Some(answer),
            Fate::Delivered => {
                if let Some(late) = self.late.take() {
                    self.come(&late);
                }
            }
            Fate::Lost | Fate::Doubled | Fate::Cut(_) => {}
        }
    }

    fn come(&mut self, answer: &OnTheWay) {
        if let Some(slot) = self.answers.get_mut(self.waiting) {
            *slot = *answer;
            self.waiting += 1;
        }
    }

    /// Puts a packet that the card has not sent before its next answer.
    #[cfg(test)]
    pub(crate) fn inject(&mut self, packet: &[u8]) {
        let mut strange = OnTheWay { len: packet.len(), ..OnTheWay::NONE };
        for (to, from) in strange.bytes.iter_mut().zip(packet) {
            *to = *from;
        }
        self.come(&strange);
    }

    /// Returns the answer that was taken last.
    #[cfg(test)]
    pub(crate) fn last_answer(&self) -> &[u8] {
        let [.., last] = &self.answers;
        last.bytes.get(..last.len).unwrap_or_default()
    }

    fn take(&mut self, into: &mut [u8]) -> usize {
        let [answer, ..] = &self.answers;
        if self.waiting == 0 {
            return 0;
        }
        let len = answer.len;
        for (to, from) in into.iter_mut().zip(answer.bytes.get(..len).unwrap_or_default()) {
            *to = *from;
        }
        self.answers.rotate_left(1);
        self.waiting -= 1;
        len
    }
}

/// Way to a simulated card. One thread at a time has the card; another one finds nobody there.
pub(crate) struct SimulatedCard(AtomicCell<Option<Box<Inside>>>);

impl SimulatedCard {
    pub(crate) fn new(board: &Board) -> Self {
        let inside = Inside {
            card: Card::new(board),
            now: None,
            line: FaultyLine::new(Rates::default(), 0),
            rates: Rates::default(),
            changes: 0,
            answers: [OnTheWay::NONE; ANSWERS],
            waiting: 0,
            late: None,
        };
        Self(AtomicCell::new(Some(Box::new(inside))))
    }

    /// Runs `f` with the card.
    pub(crate) fn with<T>(&self, f: impl FnOnce(&mut Inside) -> T) -> Result<T, Lost> {
        let mut inside = self.0.take().ok_or(BUSY)?;
        let done = f(&mut inside);
        self.0.store(Some(inside));
        Ok(done)
    }
}

/// Error of a card that another thread has (EBUSY).
const BUSY: Lost = Lost(16);

/// Returns the card of a kind, or of a family by the name that its cards share, with a firmware that has what is asked of it:
/// one of the usual firmwares if one has, else the first of them with further modules, whose I/O pins nobody sees.
///
/// A kind of module must have as many instances as its limit in `config`, or without a limit as many as `wanted` says.
pub(crate) fn board(kind: &str, config: &CardConfig, wanted: &[(Tag, u8)]) -> Option<Board> {
    let asked_of = |entry: &Limit| {
        let of = wanted.iter().filter(|row| entry.tags.contains(&row.0)).map(|row| row.1);
        config.limit(entry.name).or(of.max()).filter(|asked| *asked > 0)
    };
    let is_kind =
        |name: &&str| *name == kind || names::kind(name.split('-').next().unwrap_or(name)) == kind;
    let exact = hal_card::boards().filter(|name| *name == kind);
    let of_kind = || exact.chain(hal_card::boards().filter(is_kind)).filter_map(Board::named);
    let boards: Vec<Board> = of_kind().collect();
    let has_all = |board: &&Board| {
        CardConfig::entries().all(|entry| {
            let asked = asked_of(entry).unwrap_or(0);
            entry.tags.is_empty()
                || entry.tags.contains(&Tag::Led)
                || entry.tags.iter().any(|tag| instances(board, *tag) >= asked)
                || asked == 0
        })
    };
    let mut board = boards.iter().find(has_all).or(boards.first())?.clone();
    for entry in CardConfig::entries() {
        let (Some(asked), [tag, ..]) = (asked_of(entry), entry.tags) else { continue };
        let has = entry.tags.iter().any(|tag| instances(&board, *tag) >= asked);
        if has || *tag == Tag::Led {
            continue;
        }
        let there = board
            .modules
            .iter()
            .position(|module| module.kind().is_some_and(|kind| entry.tags.contains(&kind)));
        match there.and_then(|at| board.modules.get_mut(at)) {
            Some(module) => module.instances = asked,
            None => {
                let any =
                    hal_card::boards().filter_map(Board::named).flat_map(|board| board.modules);
                let module = any.into_iter().find(|module| module.kind() == Some(*tag));
                board.modules.extend(module.map(|module| Module { instances: asked, ..module }));
            }
        }
    }
    Some(board)
}

/// Gives a board a smart-serial channel, if it has none there and two of its I/O pins are free: the last ones are taken.
pub(crate) fn add_channel(board: &mut Board, (port, channel): (u8, u8)) {
    let is_channel = |pin: &Pin| {
        pin.kind() == Some(Tag::SmartSerial) && pin.instance == port && pin.number == channel + 1
    };
    let free = board.pins.iter().filter(|pin| **pin == Pin::plain()).count();
    if board.pins.iter().any(is_channel) || free < 2 {
        return;
    }
    let module = board.modules.iter_mut().find(|module| module.kind() == Some(Tag::SmartSerial));
    match module {
        Some(module) => module.instances = module.instances.max(port + 1),
        None => {
            let any = hal_card::boards().filter_map(Board::named).flat_map(|board| board.modules);
            let module = any.into_iter().find(|module| module.kind() == Some(Tag::SmartSerial));
            board.modules.extend(module.map(|module| Module { instances: port + 1, ..module }));
        }
    }
    let last = board.pins.iter_mut().rev().filter(|pin| **pin == Pin::plain());
    for (pin, is_output) in last.zip([true, false]) {
        let (number, tag) = (channel + 1, Tag::SmartSerial as u8);
        *pin = Pin { number, is_output, tag, instance: port, ..Pin::plain() };
    }
}

/// Reads a number of modules that files use: `pwmgen=2`.
pub(crate) fn wanted_module(word: &str) -> Option<(Tag, u8)> {
    let (name, count) = word.split_once('=')?;
    let tag = Tag::all().find(|tag| tag.name() == name)?;
    Some((tag, count.parse().ok()?))
}

fn instances(board: &Board, tag: Tag) -> u8 {
    let of = board.modules.iter().filter(|module| module.kind() == Some(tag));
    of.map(|module| module.instances).max().unwrap_or(0)
}

/// Way to a simulated card that the world around it shares.
pub(crate) struct SimulatedLine(pub(crate) Arc<SimulatedCard>);

impl Exchange for SimulatedLine {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        self.0.with(|inside| inside.carry(packet))
    }

    fn receive(&self, into: &mut [u8], _: Duration) -> Result<usize, Lost> {
        self.0.with(|inside| inside.take(into))
    }

    fn advance(&self, now_ns: i64) {
        // A card that another thread has goes on at the next call.
        let _ = self.0.with(|inside| {
            let passed = now_ns.saturating_sub(inside.now.unwrap_or(now_ns));
            inside.now = Some(now_ns);
            inside.card.advance(u64::try_from(passed).unwrap_or(0));
        });
    }
}
