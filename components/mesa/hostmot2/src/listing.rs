//! The command `hm2.card`: firmware, modules and I/O pins of each card.

use crate::{ask::Described, names};
use core::fmt::Write;
use hal_card::{Board, Terminal};
use hal_component::{Arg, Builder, Call, Error, abi::ArgSpec};
use hal_firmware::Tag;

const ARGS: &[&ArgSpec] =
    &[&Arg::text("name", "Only this card, such as hm2_7i96s.0; all without it")];

/// Text about one card.
#[derive(Clone, Debug)]
pub(crate) struct Listing {
    name: String,
    text: String,
}

/// Declares the command for the cards that were found.
pub(crate) fn command(b: &mut Builder<'_>, cards: Vec<Listing>) -> Result<(), Error> {
    let about = "Shows the firmware, the modules and the I/O pins of each card: what uses a pin, and \
                 the connector and pin where a document gives them";
    b.command("hm2.card", about, ARGS, move |call: &Call<'_>| {
        let asked = call.text("name");
        let is_asked = |card: &&Listing| asked.as_ref().is_none_or(|name| *name == card.name);
        let mut shown = cards.iter().filter(is_asked).peekable();
        if shown.peek().is_none() {
            let known: Vec<_> = cards.iter().map(|card| card.name.as_str()).collect();
            return Err(Error::new(format!(
                "no card '{}': {}",
                asked.unwrap_or_default().escape_debug(),
                known.join(", ")
            )));
        }
        for card in shown {
            card.text.lines().for_each(|line| call.reply(line));
        }
        Ok(())
    })
}

/// Writes about a card.
pub(crate) fn of(
    name: &str,
    address: &str,
    card: &Described,
    used: &[(Tag, u8)],
    taken: &[bool],
) -> Listing {
    let mut text = String::new();
    let it = &card.identification;
    let mhz = |hz: u32| f64::from(hz) / 1e6;
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{name}: {} at {address}", card.board);
    let _ = writeln!(
        text,
        "  firmware of {}, {} I/O pins in {} ports, clocks {} and {} MHz",
        it.board.escape_ascii(),
        it.width,
        it.ports,
        mhz(it.clock_low),
        mhz(it.clock_high)
    );
    for module in &card.modules {
        let count = |tag| used.iter().find(|row| row.0 == tag).map(|row| row.1);
        let kind = module.kind();
        let name =
            kind.map_or_else(|| format!("of tag {}", module.tag), |tag| tag.name().to_owned());
        let use_of = match kind.and_then(count) {
            Some(used) => format!(", {} used", used.min(module.instances)),
            None => ": not driven".to_owned(),
        };
        let _ = writeln!(
            text,
            "  module {name:<12} version {}, {} there{use_of}",
            module.version, module.instances
        );
    }
    let terminals = terminals(card);
    for (io, pin) in card.pins.iter().enumerate() {
        let terminal = match terminals.as_ref().and_then(|all| all.get(io)) {
            Some(Terminal::Named(name)) => name.escape_ascii().to_string(),
            Some(Terminal::Internal) => "internal".to_owned(),
            Some(Terminal::Unknown) | None => "unknown".to_owned(),
        };
        let user = match pin.kind() {
            Some(tag) if taken.get(io).copied().unwrap_or(false) => {
                let way = if pin.is_output { "output" } else { "input" };
                let number =
                    if pin.is_shared() { String::new() } else { format!(" {:02}", pin.instance) };
                match pin.name() {
                    Some(own) => format!("{}{number} {own}, {way}", tag.name()),
                    None => format!("{}{number}, pin {}, {way}", tag.name(), pin.number),
                }
            }
            _ => "free".to_owned(),
        };
        let _ = writeln!(text, "  io {io:03} {terminal:<12} {user}");
    }
    Listing { name: name.to_owned(), text }
}

/// Returns the terminals that a document gives for a card with just these pins; a wrong one could destroy a drive.
fn terminals(card: &Described) -> Option<Vec<Terminal>> {
    let boards = hal_card::boards().filter(|board| names::kind(board) == names::kind(&card.board));
    let boards = boards.filter_map(Board::named);
    let mut same = boards.filter(|board| board.pins == card.pins);
    same.next().map(|board| board.terminals)
}
