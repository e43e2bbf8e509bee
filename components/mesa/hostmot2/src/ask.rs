//! Questions to a card before anything runs: each is one packet and its answer.

use crate::link::MAX_STRANGE;
use core::time::Duration;
use hal_firmware::{
    BadIdentification, COOKIE, COOKIE_AT, IDENTIFICATION_AT, Identification, MAX_MODULES, Module,
    NAME, Pin,
};
use hal_lbp16::{MAX_PACKET, Packet, Size, Space};
use port::{Exchange, Lost};

/// Number of times that a question is put before the card counts as absent.
const ATTEMPTS: u32 = 5;

/// Longest wait for one answer.
const WITHIN: Duration = Duration::from_millis(200);

/// Silence after which no further answer to a repeated question is expected.
const QUIET: Duration = Duration::from_millis(10);

/// The account that a card gives of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Described {
    /// Name of the board, such as `7I92`.
    pub(crate) board: String,
    pub(crate) identification: Identification,
    pub(crate) modules: Vec<Module>,
    pub(crate) pins: Vec<Pin>,
}

/// Reason why a card cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unusable {
    /// No answer came.
    Silent,
    /// The way to the card failed.
    Lost(Lost),
    /// Another answer than a card's.
    NotOurs(u32),
    /// The firmware has another name than `HOSTMOT2`.
    Firmware([u8; 8]),
    /// The identification makes no sense.
    Identification(BadIdentification),
    /// The table of modules has no end.
    Modules,
}

impl core::fmt::Display for Unusable {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Silent => f.write_str(
                "no card answers: check the cable, the card's power, its address (jumpers select \
                 192.168.1.121 or 10.10.10.10), and that this computer has an address in the same \
                 network",
            ),
            Self::Lost(lost) => write!(f, "no way to the card: {lost}"),
            Self::NotOurs(cookie) => write!(
                f,
                "the device answers {cookie:#010x} where a card with hostmot2 firmware has {COOKIE:#010x}"
            ),
            Self::Firmware(name) => write!(
                f,
                "the card's firmware is '{}', not HOSTMOT2: load one with mesaflash",
                name.escape_ascii()
            ),
            Self::Identification(bad) => write!(f, "the card's firmware cannot be used: {bad}"),
            Self::Modules => write!(
                f,
                "the card's firmware cannot be used: its table of modules has no end within {MAX_MODULES}"
            ),
        }
    }
}

impl core::error::Error for Unusable {}

/// Asks a card for its description.
pub(crate) fn describe(card: &dyn Exchange) -> Result<Described, Unusable> {
    let [cookie, low, high, at] = registers(card, COOKIE_AT)?;
    if cookie != COOKIE {
        return Err(Unusable::NotOurs(cookie));
    }
    let ([a, b, c, d], [e, g, h, i]) = (low.to_le_bytes(), high.to_le_bytes());
    let name = [a, b, c, d, e, g, h, i];
    if name != NAME {
        return Err(Unusable::Firmware(name));
    }
    debug_assert_eq!(IDENTIFICATION_AT, COOKIE_AT + 12);
    let bad = |at| Unusable::Identification(BadIdentification::Offset(at));
    let base = u16::try_from(at).ok().filter(|at| *at < 0x8000).ok_or(bad(at))?;
    let identification =
        Identification::parse(&registers(card, base)?).map_err(Unusable::Identification)?;
    let place = |offset: u32, row: usize, words: usize| {
        let bytes = u32::try_from(row * words * 4).unwrap_or(u32::MAX);
        let at = u32::from(base).saturating_add(offset).saturating_add(bytes);
        u16::try_from(at).map_err(|_| bad(at))
    };
    let mut modules = Vec::new();
    loop {
        let at = place(identification.modules, modules.len(), Module::REGISTERS)?;
        let module = Module::parse(registers(card, at)?);
        if module.tag == 0 {
            break;
        }
        if modules.len() == MAX_MODULES {
            return Err(Unusable::Modules);
        }
        modules.push(module);
    }
    let mut pins = Vec::new();
    while pins.len() < identification.width as usize {
        let [word] = registers(card, place(identification.pins, pins.len(), 1)?)?;
        pins.push(Pin::parse(word));
    }
    Ok(Described { board: board(card)?, identification, modules, pins })
}

/// Returns the name of the board.
fn board(card: &dyn Exchange) -> Result<String, Unusable> {
    let mut packet = Packet::new();
    // An empty packet has room for one command.
    let _ = packet.read(Space::Board, Size::Word, 0, 8);
    let mut answer = [0; MAX_PACKET];
    let bytes = ask(card, &packet, &mut answer)?;
    let text = bytes.iter().take_while(|byte| byte.is_ascii_graphic());
    Ok(text.map(|byte| char::from(*byte)).collect())
}

/// Reads registers from an address on.
pub(crate) fn registers<const N: usize>(
    card: &dyn Exchange,
    at: u16,
) -> Result<[u32; N], Unusable> {
    let mut packet = Packet::new();
    // An empty packet has room for one command.
    let _ = packet.read_registers(at, u8::try_from(N).unwrap_or(u8::MAX));
    let mut answer = [0; MAX_PACKET];
    let bytes = ask(card, &packet, &mut answer)?;
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
        *word = u32::from_le_bytes(*bytes);
    }
    Ok(words)
}

/// Discards packets that have come, and those that come within a time after the last; a flood of them has an end.
fn discard(card: &dyn Exchange, within: Duration) {
    let mut packet = [0; MAX_PACKET];
    for _ in 0..MAX_STRANGE {
        if !matches!(card.receive(&mut packet, within), Ok(n) if n > 0) {
            break;
        }
    }
}

/// Sends a packet until its answer comes, and returns that.
pub(crate) fn ask<'a>(
    card: &dyn Exchange,
    packet: &Packet,
    answer: &'a mut [u8],
) -> Result<&'a [u8], Unusable> {
    let expected = packet.answer_bytes();
    let mut lost = None;
    for attempt in 0..ATTEMPTS {
        // Answers to earlier questions came too late.
        discard(card, Duration::ZERO);
        let come = card.send(packet.bytes()).and_then(|()| card.receive(answer, WITHIN));
        match come {
            Ok(n) if n == expected => {
                // Each repetition of the question may be answered as well.
                if attempt > 0 {
                    discard(card, QUIET);
                }
                return Ok(answer.get(..n).unwrap_or_default());
            }
            Ok(_) => {}
            Err(error) => lost = Some(error),
        }
    }
    Err(lost.map_or(Unusable::Silent, Unusable::Lost))
}
