//! Driver of Mesa's cards with hostmot2 firmware, over Ethernet.
//!
//! A card tells its modules and pins (`ask`); `making` and `modules` create the HAL pins from that. In each cycle `read`
//! sends one packet and takes its answer, `write` sends one (`cycle`, `link`). The real way to a card is `hal_udp`; under
//! simulation a `hal_card` answers in the process (`simulated`). The driver's code is the same with both.
#![forbid(unsafe_code)]

mod ask;
mod config;
mod cycle;
mod follow;
mod link;
mod listing;
mod making;
mod module;
mod modules;
mod names;
mod numbers;
mod plan;
mod simulated;
#[cfg(test)]
mod tests;
mod world;

use crate::{
    ask::Described,
    config::CardConfig,
    cycle::{EarlyQuestion, Health, Read, ReadSays, ReadState, UNSENT, Write},
    link::{Link, Question, Renewals},
    listing::Listing,
    making::Making,
    simulated::{SimulatedCard, SimulatedLine},
};
use hal_card::Remote;
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use hal_firmware::{Tag, registers};
use hal_lbp16::{MAX_PACKET, Packet};
use port::Exchange;
use std::{net::Ipv4Addr, sync::Arc};

hal_component::export!(Hostmot2, Hm2Eth);

/// Component `hostmot2`.
pub(crate) enum Hostmot2 {}

impl Component for Hostmot2 {
    const NAME: &'static str = "hostmot2";
    const DOC: &'static str = "\
The common part of Mesa's cards. Loading it makes nothing: `hm2_eth` makes the pins of each card.

Scripts load it before the driver of their card, and it is kept for them. Its arguments are accepted
without effect: `hm2_eth` logs what it finds in a card.

# Example

```hal
loadrt hostmot2
loadrt hm2_eth
getp hm2_7i92.0.watchdog.timeout_ns # -> 5000000
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::int("debug_idrom", "Without effect").within(0.0, 1.0),
        &Arg::int("debug_module_descriptors", "Without effect").within(0.0, 1.0),
        &Arg::int("debug_pin_descriptors", "Without effect").within(0.0, 1.0),
        &Arg::int("debug_modules", "Without effect").within(0.0, 1.0),
        &Arg::int("use_serial_numbers", "0: names with the serial numbers of remotes are not made")
            .within(0.0, 0.0),
    ];

    fn create(_: &mut Builder<'_>) -> Result<(), Error> {
        Ok(())
    }
}

/// Component `hm2_eth`.
pub(crate) enum Hm2Eth {}

impl Component for Hm2Eth {
    const NAME: &'static str = "hm2_eth";
    const DOC: &'static str = include_str!("hm2_eth.md");
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::texts("board_ip", "Addresses of the cards, separated by commas").or("192.168.1.121"),
        &Arg::texts(
            "config",
            "For each card, what is used of it: `num_encoders=N num_stepgens=N …`, in the order of \
             `board_ip`",
        ),
        &Arg::texts(
            "card",
            "For each card, its kind, such as 7i96s, and its remotes, such as 0.0=7i84: used where no \
             card can be asked, which is in simulation and in `check`; a card without one is like the last \
             that has one",
        )
        .or("7i92"),
        &Arg::int("debug", "Without effect").within(0.0, 1.0),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let mut names = names::Names::default();
        let mut cards = Vec::new();
        for (index, address) in b.arg_texts("board_ip").into_iter().enumerate() {
            let address = address.trim_matches('"').trim();
            let address: Ipv4Addr = address.parse().map_err(|_| {
                Error::new(format!(
                    "board_ip: '{}' is no address: four numbers from 0 to 255 with dots, such as \
                     192.168.1.121",
                    address.escape_debug()
                ))
            })?;
            cards.push(create_card(b, index, address, &mut names)?);
        }
        listing::command(b, cards)
    }
}

/// Finds one card, and creates its pins and functions.
fn create_card(
    b: &mut Builder<'_>,
    index: usize,
    address: Ipv4Addr,
    names: &mut names::Names,
) -> Result<Listing, Error> {
    let text = b.arg_text_at("config", index).unwrap_or_default();
    let config = CardConfig::parse(&text).map_err(|why| Error::new(format!("{address}: {why}")))?;
    let (device, simulated) = device(b, index, address, &config)?;
    let card = ask::describe(&*device).map_err(|why| Error::new(format!("{address}: {why}")))?;
    let name = names.next(&card.board);
    let failed = |why: &dyn core::fmt::Display| Error::new(format!("{name}: {why}"));
    let renewals = Renewals::new();
    let used = used(&card, &config, &name)?;
    let health = Health::make(b, &name)?;
    let mut making = Making {
        b,
        name: &name,
        renewals: renewals.clone(),
        raw_address: Arc::default(),
        device: &*device,
        card: &card,
        config: &config,
        plan: plan::ReadPlan::default(),
        reads: Vec::new(),
        writes: Vec::new(),
        encoder_scales: Vec::new(),
        taken: Vec::new(),
        channels: Vec::new(),
        remotes: Vec::new(),
        used,
    };
    modules::make(&mut making)?;
    let world = simulated.as_ref().map(|card| world::make(&mut making, card)).transpose()?;
    let ports = making.channels.iter().filter(|channels| **channels != 0).count();
    making.used.push((Tag::SmartSerial, u8::try_from(ports).unwrap_or(u8::MAX)));
    let listing = listing::of(&name, &address.to_string(), &card, &making.used, &making.taken);
    let stop = stop(&making)?;
    let (says, unsent) = (ReadSays::of(&making), making.says(UNSENT));
    let (plan, raw, mut reads, writes) =
        (making.plan, making.raw_address, making.reads, making.writes);
    let question = plan.packet()?;
    let mut answer = [0; MAX_PACKET];
    let first = ask::ask(&*device, &question, &mut answer);
    let first = first.map_err(|why| failed(&why))?;
    for part in &mut reads {
        part.read(plan::ReadAnswer(first), module::Cycle { period: 0.001 }, false);
    }
    let link = Arc::new(Link::new(
        device,
        b.clock(),
        Question { packet: question, raw: plan.variable_at(&question), address: raw },
        renewals.clone(),
    ));
    let messages = b.messages();
    let request = EarlyQuestion { link: Arc::clone(&link), io_error: health.io_error };
    b.function(&format!("{name}.read-request"), "Sends the packet of reads early", request)?;
    let write = Write {
        link: Arc::clone(&link),
        io_error: health.io_error,
        parts: writes,
        world: world.clone(),
        messages,
        unsent,
        reported: false,
    };
    let read = Read {
        link: Arc::clone(&link),
        health,
        parts: reads,
        world,
        renewals: renewals.clone(),
        messages: b.messages(),
        hardware: b.hardware(),
        says,
        state: ReadState::default(),
    };
    b.function(&format!("{name}.read"), "Asks the card, and takes its answer", read)?;
    b.function(&format!("{name}.write"), "Sends what is new to the card", write)?;
    b.on_stop(move || {
        // A card that cannot be reached is stopped by its watchdog.
        let _ = link.stop(&stop);
        renewals.renew();
    })?;
    Ok(listing)
}

/// Way to a card; the card itself if it is simulated.
type Device = (Box<dyn Exchange>, Option<Arc<SimulatedCard>>);

/// Returns the way to a card.
fn device(
    b: &Builder<'_>,
    index: usize,
    address: Ipv4Addr,
    config: &CardConfig,
) -> Result<Device, Error> {
    if !b.is_simulated() && !b.is_trial() {
        let line = hal_udp::UdpLine::open(address, hal_lbp16::PORT);
        let line = line.map_err(|why| Error::new(format!("{address}: no way to a card: {why}")))?;
        return Ok((Box::new(line), None));
    }
    let kinds = || hal_card::boards().collect::<Vec<_>>().join(", ");
    let named = b.arg_texts("card");
    let text = named.get(index).or(named.last()).cloned().unwrap_or_default();
    let mut words = text.trim_matches('"').split_whitespace();
    let kind = words.next().unwrap_or_default();
    let (modules, words): (Vec<_>, Vec<_>) =
        words.partition(|word| simulated::wanted_module(word).is_some());
    let wanted = modules.into_iter().filter_map(simulated::wanted_module).collect::<Vec<_>>();
    let mut board = simulated::board(kind, config, &wanted).ok_or_else(|| {
        Error::new(format!("card: '{}' is none of {}", kind.escape_debug(), kinds()))
    })?;
    words
        .iter()
        .filter_map(|word| place(word))
        .for_each(|at| simulated::add_channel(&mut board, at));
    let card = Arc::new(SimulatedCard::new(&board));
    #[cfg(test)]
    tests::keep_card(&card);
    plug(&card, kind, &words)?;
    Ok((Box::new(SimulatedLine(Arc::clone(&card))), Some(card)))
}

/// Remotes that are parts of a board: its kind, the smart-serial channel, and the remote.
const OWN_REMOTES: &[(&str, &str)] =
    &[("7i76e", "0.0=7i76"), ("7i76eu", "0.0=7i76"), ("7i76", "0.0=7i76")];

/// Reads the port and the channel of a remote: `0.1=7i77`.
fn place(word: &str) -> Option<(u8, u8)> {
    let (port, channel) = word.split_once('=')?.0.split_once('.')?;
    let (port, channel) = (port.parse().ok()?, channel.parse().ok()?);
    (port < 8 && channel < 8).then_some((port, channel))
}

/// Plugs remotes into a simulated card: those of its board, unless others are named.
fn plug(card: &SimulatedCard, kind: &str, named: &[&str]) -> Result<(), Error> {
    let own = OWN_REMOTES.iter().filter(|row| row.0 == kind).map(|row| row.1);
    let all: Vec<&str> = match named {
        ["alone"] => Vec::new(),
        [] => own.collect(),
        named => named.to_vec(),
    };
    for word in all {
        let plugged = || {
            let (port, channel) = place(word)?;
            let remote = Remote::named(word.split_once('=')?.1)?;
            let plug = |inside: &mut simulated::Inside| {
                inside.card.plug(port.into(), channel.into(), remote)
            };
            card.with(plug).ok()?.then_some(())
        };
        plugged().ok_or_else(|| {
            Error::new(format!(
                "card: '{}': PORT.CHANNEL=REMOTE is needed behind the kind of the card, with a channel \
                 that the card has and a remote, one of {}; or 'alone' for a card without remotes",
                word.escape_debug(),
                hal_card::remotes().collect::<Vec<_>>().join(", ")
            ))
        })?;
    }
    Ok(())
}

/// Returns how many instances of each kind of module are used.
fn used(card: &Described, config: &CardConfig, name: &str) -> Result<Vec<(Tag, u8)>, Error> {
    let mut used: Vec<_> = card.modules.iter().filter_map(modules::instances).collect();
    let there =
        |used: &[(Tag, u8)], tag| used.iter().find(|row| row.0 == tag).map_or(0, |row| row.1);
    // A limit is for all kinds that an entry names, of which a firmware has one.
    for entry in CardConfig::entries() {
        let most = entry.tags.iter().map(|tag| there(&used, *tag)).max().unwrap_or(0);
        let Some(asked) = config.limit(entry.name) else { continue };
        if asked > most && !entry.tags.is_empty() {
            return Err(Error::new(format!(
                "{name}: config: '{}={asked}': the card's firmware has {most} of them",
                entry.name
            )));
        }
        for row in used.iter_mut().filter(|row| entry.tags.contains(&row.0)) {
            row.1 = row.1.min(asked);
        }
    }
    Ok(used)
}

/// Returns the packet that stops a card: its watchdog bites in the next moment, and all I/O pins become inputs.
fn stop(m: &Making<'_, '_>) -> Result<Packet, Error> {
    let mut packet = Packet::new();
    if let Some((module, _)) = m.module(Tag::Watchdog) {
        for (register, value) in
            [(registers::WATCHDOG_TIMEOUT, 1), (registers::WATCHDOG_RESET, modules::RESET)]
        {
            let address = m.address(&module, register, 0)?;
            // An empty packet has room for two registers.
            let _ = packet.write_registers(address, &[value]);
        }
    }
    Ok(packet)
}
