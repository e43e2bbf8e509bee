//! The INI file of LinuxCNC's `mb2hal`, understood: lines, devices, elements.

use super::refused::{BadEntry, BadIni};
use crate::line::{LinePlace, Parity, RATES, SerialPlace, TcpPlace, is_name};
use hal_ini::{Entry, Ini};
use hal_modbus::{Call, ModbusRequest, ModbusTable, nanoseconds};
use std::{collections::BTreeMap, path::Path};

/// Largest number of transactions.
pub(crate) const MAX_TRANSACTIONS: i64 = 500;
/// Section of the settings for all transactions.
const INIT: &str = "MB2HAL_INIT";
const MS: i64 = 1_000_000;

/// Function of a transaction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Read(ModbusTable),
    WriteCoil,
    WriteRegister,
    WriteCoils,
    WriteRegisters,
}

/// Functions by their names in the file.
pub(crate) const KINDS: &[(&str, Function)] = &[
    ("fnct_01_read_coils", Function::Read(ModbusTable::Coils)),
    ("fnct_02_read_discrete_inputs", Function::Read(ModbusTable::Discretes)),
    ("fnct_03_read_holding_registers", Function::Read(ModbusTable::Holding)),
    ("fnct_04_read_input_registers", Function::Read(ModbusTable::Inputs)),
    ("fnct_05_write_single_coil", Function::WriteCoil),
    ("fnct_06_write_single_register", Function::WriteRegister),
    ("fnct_15_write_multiple_coils", Function::WriteCoils),
    ("fnct_16_write_multiple_registers", Function::WriteRegisters),
];

impl Function {
    /// Returns the largest number of elements.
    pub(crate) fn most(self) -> i64 {
        let call = match self {
            Self::Read(table) => Call::Read { table, first: 0, count: 0 },
            Self::WriteCoil | Self::WriteRegister => return 1,
            Self::WriteCoils => Call::WriteCoils { first: 0, on: Vec::new() },
            Self::WriteRegisters => Call::WriteRegisters { first: 0, values: Vec::new() },
        };
        let most = ModbusRequest { unit: 1, call }.check().map_or_else(|bad| bad.most, |()| 1);
        i64::try_from(most).unwrap_or(i64::MAX)
    }
}

/// Line with its settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LinkConfig {
    pub(crate) place: LinePlace,
    /// Pause between requests beyond the silence that the line needs, in nanoseconds.
    pub(crate) pause_ns: i64,
}

/// Request that is repeated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TransactionConfig {
    pub(crate) name: String,
    /// Place of its line in the list.
    pub(crate) link: usize,
    pub(crate) unit: u8,
    pub(crate) kind: Function,
    pub(crate) first: u16,
    /// Names of the elements.
    pub(crate) pins: Vec<String>,
    /// Time from one request to the next, in nanoseconds; 0 for as often as possible.
    pub(crate) period_ns: i64,
    pub(crate) timeout_ns: i64,
}

/// All lines and transactions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MbConfig {
    /// Name before all pins.
    pub(crate) prefix: String,
    /// The pins have the names of version 1.1.
    pub(crate) has_new_names: bool,
    pub(crate) links: Vec<LinkConfig>,
    pub(crate) transactions: Vec<TransactionConfig>,
}

impl MbConfig {
    /// Reads a file of `mb2hal`.
    pub(crate) fn read(path: &Path) -> Result<Self, BadIni> {
        let ini = Ini::read(path).map_err(BadIni::Unreadable)?;
        FileReader::new(&ini, path).read()
    }
}

/// Entries by their names, the last of each name.
type Entries<'i> = BTreeMap<&'i str, &'i Entry>;

/// A section, with those before it from which it takes what it does not state.
struct Section<'r> {
    reader: &'r FileReader<'r>,
    number: i64,
    /// Entries of this section, and of the nearest before it that has one.
    all: &'r Entries<'r>,
}

struct FileReader<'i> {
    ini: &'i Ini,
    file: String,
    sections: BTreeMap<&'i str, Entries<'i>>,
}

impl<'i> FileReader<'i> {
    fn new(ini: &'i Ini, path: &Path) -> Self {
        let mut sections: BTreeMap<&str, Entries<'_>> = BTreeMap::new();
        for entry in ini.entries() {
            sections.entry(&entry.section).or_default().insert(&entry.name, entry);
        }
        Self { ini, file: path.display().to_string(), sections }
    }

    fn read(&self) -> Result<MbConfig, BadIni> {
        let total = match self.entry(INIT, "TOTAL_TRANSACTIONS") {
            Some(entry) => number(entry, 1, MAX_TRANSACTIONS)?,
            None => {
                return Err(self.missing(
                    INIT,
                    "TOTAL_TRANSACTIONS",
                    "the number of sections [TRANSACTION_00], [TRANSACTION_01] …",
                ));
            }
        };
        let version = match self.entry(INIT, "VERSION") {
            Some(entry) => decimal(entry, 1.0, 99.0)?,
            None => 1.0,
        };
        let slowdown = match self.entry(INIT, "SLOWDOWN") {
            Some(entry) => decimal(entry, 0.0, 60.0)?,
            None => 0.0,
        };
        let prefix =
            self.entry(INIT, "HAL_MODULE_NAME").map_or("mb2hal", |entry| entry.value.as_str());
        let mut config = MbConfig {
            prefix: prefix.to_owned(),
            has_new_names: 1.1 <= version,
            links: Vec::new(),
            transactions: Vec::new(),
        };
        let mut all = Entries::new();
        for number in 0..total {
            let own = self.sections.get(section_name(number).as_str());
            all.extend(own.into_iter().flatten());
            let section = Section { reader: self, number, all: &all };
            let link = section.link(nanoseconds(slowdown))?;
            let known = config.links.iter().position(|known| known.place.is_same_line(&link.place));
            let at = known.unwrap_or(config.links.len());
            match config.links.get(at) {
                None => config.links.push(link),
                Some(known) if known.place == link.place => {}
                Some(_) => return Err(section.contradiction()),
            }
            let transaction = section.transaction(at, config.has_new_names)?;
            if let Some(same) = config.transactions.iter().find(|t| t.name == transaction.name) {
                return Err(section.bad_or_missing("HAL_TX_NAME", &same.name, BadEntry::SameName));
            }
            config.transactions.push(transaction);
        }
        Ok(config)
    }

    fn entry(&self, section: &str, key: &str) -> Option<&'i Entry> {
        self.sections.get(section)?.get(key).copied()
    }

    fn missing(&self, section: &str, key: &'static str, what: &'static str) -> BadIni {
        let section = section.to_owned();
        let near =
            self.ini.nearest(&section, key).filter(|(_, is_meant)| *is_meant).map(|(name, _)| name);
        BadIni::Missing { file: self.file.clone(), section, key, what, near }
    }
}

impl<'r> Section<'r> {
    fn name(&self) -> String {
        section_name(self.number)
    }

    /// Returns an entry of this section alone.
    fn own(&self, key: &str) -> Option<&'r Entry> {
        self.reader.entry(&self.name(), key)
    }

    /// Returns an entry of this section, or of the nearest before it that has one.
    fn entry(&self, key: &str) -> Option<&'r Entry> {
        self.all.get(key).copied()
    }

    fn required(&self, key: &'static str, what: &'static str) -> Result<&'r Entry, BadIni> {
        self.entry(key).ok_or_else(|| self.reader.missing(&self.name(), key, what))
    }

    fn bad_or_missing(&self, key: &'static str, value: &str, why: BadEntry) -> BadIni {
        match self.own(key) {
            Some(entry) => BadIni::bad(entry, why),
            None => BadIni::Section {
                file: self.reader.file.clone(),
                section: self.name(),
                value: value.to_owned(),
                why,
            },
        }
    }

    fn contradiction(&self) -> BadIni {
        let keys = ["SERIAL_BAUD", "SERIAL_PARITY", "SERIAL_BITS", "SERIAL_STOP", "SERIAL_PORT"];
        match keys.iter().find_map(|key| self.own(key)) {
            Some(entry) => BadIni::bad(entry, BadEntry::TwoSettings),
            None => self.bad_or_missing("SERIAL_PORT", "", BadEntry::TwoSettings),
        }
    }

    fn link(&self, slowdown_ns: i64) -> Result<LinkConfig, BadIni> {
        let link = self.required("LINK_TYPE", "serial or tcp")?;
        let mut pause_ns = slowdown_ns;
        let place = if link.value.eq_ignore_ascii_case("tcp") {
            let host = self.required("TCP_IP", "the address of the device")?.value.clone();
            let port = self.entry("TCP_PORT").map_or(Ok(502), |entry| number(entry, 1, 65535))?;
            LinePlace::Tcp(TcpPlace { host, port: u16::try_from(port).unwrap_or(502) })
        } else if link.value.eq_ignore_ascii_case("serial") {
            let path = self
                .required("SERIAL_PORT", "the device file, such as /dev/ttyUSB0")?
                .value
                .clone();
            let rate = self.required("SERIAL_BAUD", "the bits per second, such as 9600")?;
            let bits = self.entry("SERIAL_BITS").map_or(Ok(8), |entry| number(entry, 5, 8))?;
            let stops = self.entry("SERIAL_STOP").map_or(Ok(1), |entry| number(entry, 1, 2))?;
            let parity = match self.entry("SERIAL_PARITY") {
                Some(entry) => Parity::of(&entry.value)
                    .ok_or_else(|| BadIni::bad(entry, BadEntry::OneOf(&["none", "even", "odd"])))?,
                None => Parity::None,
            };
            if let Some(entry) = self.entry("SERIAL_DELAY_MS") {
                pause_ns = pause_ns.saturating_add(number(entry, 0, 10_000)? * MS);
            }
            let baud = number(rate, 1, 10_000_000)?;
            LinePlace::Serial(SerialPlace {
                path,
                rate: u32::try_from(baud)
                    .ok()
                    .filter(|baud| RATES.contains(baud))
                    .ok_or_else(|| BadIni::bad(rate, BadEntry::Rate))?,
                bits: u8::try_from(bits).unwrap_or(8),
                parity,
                stops: u8::try_from(stops).unwrap_or(1),
            })
        } else {
            return Err(BadIni::bad(link, BadEntry::OneOf(&["serial", "tcp"])));
        };
        Ok(LinkConfig { place, pause_ns })
    }

    fn transaction(&self, link: usize, has_new_names: bool) -> Result<TransactionConfig, BadIni> {
        let code = self.own("MB_TX_CODE").ok_or_else(|| {
            self.reader.missing(
                &self.name(),
                "MB_TX_CODE",
                "the function, such as fnct_03_read_holding_registers",
            )
        })?;
        let kind = KINDS.iter().find(|(name, _)| *name == code.value).map(|(_, kind)| *kind);
        let kind = kind.ok_or_else(|| BadIni::bad(code, BadEntry::Function))?;
        let is_new = matches!(kind, Function::Read(ModbusTable::Coils) | Function::WriteCoil);
        if is_new && !has_new_names {
            return Err(BadIni::bad(code, BadEntry::NeedsVersion));
        }
        let unit = self.required("MB_SLAVE_ID", "the number of the device, 1 to 247")?;
        let first = self.own("FIRST_ELEMENT").ok_or_else(|| {
            self.reader.missing(
                &self.name(),
                "FIRST_ELEMENT",
                "the address of the first element, from 0",
            )
        })?;
        let pins = self.pins(kind)?;
        let rate =
            self.entry("MAX_UPDATE_RATE").map_or(Ok(0.0), |entry| decimal(entry, 0.0, 1000.0))?;
        let timeout = self
            .entry("MB_RESPONSE_TIMEOUT_MS")
            .map_or(Ok(500), |entry| number(entry, 1, 60_000))?;
        let name = self
            .own("HAL_TX_NAME")
            .map_or_else(|| format!("{:02}", self.number), |e| e.value.clone());
        let beyond = number(first, 0, 65535)? + i64::try_from(pins.len()).unwrap_or(i64::MAX);
        if 65536 < beyond {
            return Err(BadIni::bad(first, BadEntry::Beyond));
        }
        Ok(TransactionConfig {
            name,
            link,
            unit: u8::try_from(number(unit, 1, 247)?).unwrap_or(1),
            kind,
            first: u16::try_from(number(first, 0, 65535)?).unwrap_or_default(),
            pins,
            period_ns: if rate == 0.0 { 0 } else { nanoseconds(1.0 / rate) },
            timeout_ns: timeout * MS,
        })
    }

    /// Returns the names of the elements.
    fn pins(&self, kind: Function) -> Result<Vec<String>, BadIni> {
        if let Some(entry) = self.own("PIN_NAMES") {
            let names: Vec<String> =
                entry.value.split(',').map(|name| name.trim().to_owned()).collect();
            if !names.iter().all(|name| is_name(name)) {
                return Err(BadIni::bad(entry, BadEntry::PinNames));
            }
            let count = i64::try_from(names.len()).unwrap_or(i64::MAX);
            if kind.most() < count {
                return Err(BadIni::bad(entry, BadEntry::TooMany(kind.most())));
            }
            return Ok(names);
        }
        let count = self.own("NELEMENTS").ok_or_else(|| {
            self.reader.missing(
                &self.name(),
                "NELEMENTS",
                "the number of elements, or PIN_NAMES= with a name for each",
            )
        })?;
        let count_of = number(count, 1, i64::from(u16::MAX))?;
        if kind.most() < count_of {
            return Err(BadIni::bad(count, BadEntry::TooMany(kind.most())));
        }
        Ok((0..count_of).map(|n| format!("{n:02}")).collect())
    }
}

fn section_name(number: i64) -> String {
    format!("TRANSACTION_{number:02}")
}

/// Reads a whole number, also such as `0x10`.
fn number(entry: &Entry, least: i64, most: i64) -> Result<i64, BadIni> {
    let text = entry.value.trim();
    let read = match text.strip_prefix("0x").or(text.strip_prefix("0X")) {
        Some(digits) => i64::from_str_radix(digits, 16),
        None => text.parse(),
    };
    let fits = read.ok().filter(|n| (least..=most).contains(n));
    fits.ok_or_else(|| BadIni::bad(entry, BadEntry::Whole { least, most }))
}

fn decimal(entry: &Entry, least: f64, most: f64) -> Result<f64, BadIni> {
    let read: Option<f64> = entry.value.trim().parse().ok();
    let fits = read.filter(|n| (least..=most).contains(n));
    fits.ok_or_else(|| BadIni::bad(entry, BadEntry::Number { least, most }))
}
