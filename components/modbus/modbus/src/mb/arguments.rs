//! Arguments of `modbus`.

use super::{
    config::{KINDS, LinkConfig, MbConfig, TransactionConfig},
    refused::BadArgument,
};
use crate::line::{LinePlace, Parity, RATES, SerialPlace, TcpPlace, is_name, is_path};
use hal_component::{Arg, Builder, abi::ArgSpec};
use hal_modbus::nanoseconds;
use std::path::Path;

const MS: i64 = 1_000_000;

pub(crate) const ARGS: &[&ArgSpec] = &[
    &Arg::text("ini", "File of LinuxCNC's mb2hal."),
    &Arg::text("device", "Without a file: serial line, or HOST:PORT.").or("/dev/ttyUSB0"),
    &Arg::int("rate", "Without a file: bits per second.").or("9600"),
    &Arg::text("parity", "Without a file: none, even or odd.").or("none"),
    &Arg::int("stopbits", "Without a file: stop bits.").within(1.0, 2.0).or("1"),
    &Arg::int("unit", "Without a file: number of the device.").within(1.0, 247.0).or("1"),
    &Arg::float("update_rate", "Without a file: requests per second of each transaction.")
        .within(0.0, 1000.0)
        .unit("Hz")
        .or("20"),
    &Arg::texts("transactions", "Without a file: requests as NAME:FUNCTION:FIRST:COUNT.")
        .at_most(100),
    &Arg::bit("critical", "TRUE: motion is off while a device does not answer.").or("FALSE"),
];

/// Reads the arguments.
pub(crate) fn read(b: &Builder<'_>) -> Result<MbConfig, BadArgument> {
    let transactions = b.arg_texts("transactions");
    let ini = b.arg_text("ini");
    match (ini, transactions.is_empty()) {
        (Some(path), true) => MbConfig::read(Path::new(&path)).map_err(BadArgument::Ini),
        (Some(_), false) => Err(BadArgument::Both),
        (None, _) => inline(b, &transactions),
    }
}

/// Makes transactions of the list.
fn inline(b: &Builder<'_>, list: &[String]) -> Result<MbConfig, BadArgument> {
    let device = b.arg_text("device").unwrap_or_default();
    let is_host = |host: &str| {
        let usual = |c: char| c.is_ascii_alphanumeric() || ".-_:[]".contains(c);
        (1..=253).contains(&host.len()) && host.chars().all(usual)
    };
    let address = device.rsplit_once(':').filter(|(host, _)| is_host(host));
    let place = match address.and_then(|(host, port)| Some((host, port.parse().ok()?))) {
        Some((host, port)) => LinePlace::Tcp(TcpPlace { host: host.to_owned(), port }),
        None if is_path(&device) => LinePlace::Serial(serial(b, device)?),
        None => return Err(BadArgument::Device(device)),
    };
    let rate = b.arg_float("update_rate").unwrap_or(20.0);
    let mut transactions: Vec<TransactionConfig> = Vec::new();
    for text in list {
        let bad = || BadArgument::Transaction(text.clone());
        let mut one = transaction(text).ok_or_else(bad)?;
        if transactions.iter().any(|other| other.name == one.name) {
            return Err(bad());
        }
        one.unit = b.arg_int("unit").and_then(|n| u8::try_from(n).ok()).unwrap_or(1);
        one.period_ns = if rate == 0.0 { 0 } else { nanoseconds(1.0 / rate) };
        transactions.push(one);
    }
    Ok(MbConfig {
        prefix: "mb2hal".to_owned(),
        has_new_names: true,
        links: vec![LinkConfig { place, pause_ns: 0 }],
        transactions,
    })
}

fn serial(b: &Builder<'_>, path: String) -> Result<SerialPlace, BadArgument> {
    let rate = b.arg_int("rate").unwrap_or(9600);
    let parity = b.arg_text("parity").unwrap_or_default();
    Ok(SerialPlace {
        path,
        rate: u32::try_from(rate)
            .ok()
            .filter(|rate| RATES.contains(rate))
            .ok_or(BadArgument::Rate(rate))?,
        bits: 8,
        parity: Parity::of(&parity).ok_or(BadArgument::Parity(parity))?,
        stops: b.arg_int("stopbits").and_then(|n| u8::try_from(n).ok()).unwrap_or(1),
    })
}

/// Reads a transaction such as `inputs:02:0:8`.
fn transaction(text: &str) -> Option<TransactionConfig> {
    let mut parts = text.split(':');
    let (name, function) = (parts.next()?, parts.next()?);
    let (first, count): (u16, u16) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
    let function = format!("fnct_{:02}_", function.parse::<u8>().ok()?);
    let (_, kind) = KINDS.iter().find(|(name, _)| name.starts_with(&function))?;
    let is_whole = parts.next().is_none() && is_name(name);
    let is_within = (1..=kind.most()).contains(&i64::from(count))
        && u32::from(first) + u32::from(count) <= 65536;
    (is_whole && is_within).then(|| TransactionConfig {
        name: name.to_owned(),
        link: 0,
        unit: 1,
        kind: *kind,
        first,
        pins: (0..count).map(|n| format!("{n:02}")).collect(),
        period_ns: 0,
        timeout_ns: 500 * MS,
    })
}
