//! Kinds of Mesa's cards that a machine's files name: in simulation and in `check` no card can be asked for its pins.

use crate::{
    Command, Session,
    ini::Ini,
    language::vars::{Values, replace},
    programs::halrun::folders::Folders,
};
use hal_ini::file::whole;
use hal_protocol::Request;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// Component that drives the cards.
const DRIVER: &str = "hm2_eth";

/// Largest number of files that are looked at.
const MAX_FILES: usize = 64;

/// Largest number of cards.
const MAX_CARDS: usize = 16;

impl Session<'_> {
    /// Adds the kinds of the cards to the line that loads their driver, unless the line names them.
    pub(crate) fn with_cards(&self, command: Command) -> Command {
        let Command::Send(Request::Load { module, mut args }, note) = command else {
            return command;
        };
        if module == DRIVER && !args.iter().any(|arg| arg.starts_with("card=")) {
            let kinds = self.card_kinds();
            if !kinds.is_empty() {
                args.push(format!("card=\"{}\"", kinds.join(",")));
            }
        }
        Command::Send(Request::Load { module, args }, note)
    }

    /// Returns the kinds in the order in which the files name the cards, each with its remotes.
    fn card_kinds(&self) -> Vec<String> {
        let mut cards = Cards::default();
        let mut seen = BTreeSet::new();
        let ini = self.own_ini.as_ref().or(self.ini);
        let values = Values { environment: self.environment, ini };
        let mut files: Vec<PathBuf> = vec![self.place().0.into()];
        if let Some(ini) = ini {
            let entries = ["HALFILE", "POSTGUI_HALFILE"].map(|name| ini.all("HAL", name));
            files.extend(entries.into_iter().flatten().filter_map(|entry| {
                let folders = Folders::of(Path::new(&entry.file));
                Some(folders.find(entry.value.split_whitespace().next()?)?.1)
            }));
            for entry in ini.all("HAL", "HALCMD") {
                cards.add(&entry.value, values);
            }
        }
        for file in files {
            look(&file, values, &mut seen, &mut cards);
        }
        cards.sort();
        let kinds: Vec<String> = cards.0.iter().map(NamedCard::words).collect();
        if kinds.is_empty() { ini.map(configured).unwrap_or_default() } else { kinds }
    }
}

/// Returns the kinds of cards that `PnCconf`'s entries name: `[HOSTMOT2]BOARD = 7i96s`, `[HMOT]CARD0 = hm2_7i96s.0`.
fn configured(ini: &Ini) -> Vec<String> {
    let cards = (0..MAX_CARDS).filter_map(|n| ini.get("HMOT", &format!("CARD{n}")));
    let kinds = cards.filter_map(|card| card.strip_prefix("hm2_")?.split('.').next());
    let kinds: Vec<String> = kinds.map(str::to_ascii_lowercase).collect();
    if kinds.is_empty() {
        return ini.get("HOSTMOT2", "BOARD").map(str::to_ascii_lowercase).into_iter().collect();
    }
    kinds
}

/// Cards that lines name, in the order of the lines.
#[derive(Debug, Default)]
struct Cards(Vec<NamedCard>);

/// Card that lines name.
#[derive(Debug, PartialEq, Eq)]
struct NamedCard {
    kind: String,
    /// Number among the cards of the kind.
    number: u32,
    /// Remotes by port and channel.
    remotes: BTreeMap<(u8, u8), String>,
    /// Number of the modules of each kind whose pins are named.
    modules: BTreeMap<&'static str, u8>,
}

/// Kinds of modules whose instances are counted.
const MODULES: [&str; 7] = ["encoder", "inm", "inmux", "outm", "pwmgen", "ssr", "stepgen"];

impl NamedCard {
    /// Returns the kind and the remotes as the driver reads them: `7i92 0.0=7i77`.
    fn words(&self) -> String {
        let mut words = self.kind.clone();
        for ((port, channel), remote) in &self.remotes {
            words.push_str(&format!(" {port}.{channel}={remote}"));
        }
        for (module, count) in &self.modules {
            words.push_str(&format!(" {module}={count}"));
        }
        words
    }
}

impl Cards {
    /// Sorts the cards of each kind by their numbers, as the driver gives them.
    fn sort(&mut self) {
        for at in 0..self.0.len() {
            for later in at + 1..self.0.len() {
                if let Ok([a, b]) = self.0.get_disjoint_mut([at, later])
                    && a.kind == b.kind
                    && b.number < a.number
                {
                    core::mem::swap(a, b);
                }
            }
        }
    }

    /// Adds the cards that a line names. Returns the line without its comment and with its variables replaced.
    fn add(&mut self, line: &str, values: Values<'_>) -> String {
        let code = line.split('#').next().unwrap_or_default();
        // A line with a variable that is missing is refused when it is executed.
        let code = replace(code, values).unwrap_or_else(|_| code.to_owned());
        for text in code.split("hm2_").skip(1) {
            let Some((kind, number, rest)) = card(text) else { continue };
            let is_it = |card: &NamedCard| card.kind == kind && card.number == number;
            let at = self.0.iter().position(is_it).unwrap_or_else(|| {
                let (remotes, modules) = (BTreeMap::new(), BTreeMap::new());
                self.0.push(NamedCard { kind, number, remotes, modules });
                self.0.len() - 1
            });
            let Some(card) = self.0.get_mut(at).filter(|_| at < MAX_CARDS) else {
                self.0.truncate(MAX_CARDS);
                continue;
            };
            if let Some((port, channel, remote)) = remote(rest) {
                // Other pins have the same names in both halves of a 7I77.
                let known = card.remotes.entry((port, channel)).or_insert_with(|| remote.clone());
                if remote == "7i77-analog" {
                    *known = remote;
                }
            }
            if let Some((module, number)) = module(rest) {
                let count = card.modules.entry(module).or_default();
                *count = (*count).max(number.saturating_add(1));
            }
        }
        code
    }
}

/// Adds the cards of a file and of those that it sources.
fn look(path: &Path, values: Values<'_>, seen: &mut BTreeSet<PathBuf>, cards: &mut Cards) {
    if seen.len() >= MAX_FILES || !path.is_file() || !seen.insert(path.to_owned()) {
        return;
    }
    let Ok(text) = whole(path) else { return };
    let here = path.parent().unwrap_or_else(|| Path::new(""));
    for line in String::from_utf8_lossy(&text).lines() {
        let code = cards.add(line, values);
        if let Some(file) = code.trim().strip_prefix("source ") {
            look(&hal_ini::beside(here, file.trim()), values, seen, cards);
        }
    }
}

/// Reads `MODULE.NN.PIN`, such as `stepgen.02.counts`.
fn module(rest: &str) -> Option<(&'static str, u8)> {
    let mut parts = rest.split('.');
    let (kind, number) = (parts.next()?, parts.next()?);
    let kind = MODULES.into_iter().find(|module| *module == kind)?;
    // Further dots: it is not a pin of the whole module.
    (number.len() == 2 && parts.next().is_some()).then_some((kind, number.parse().ok()?))
}

/// Beginnings of the names of pins that only the analogue half of a 7I77 has.
const ANALOGUE: [&str; 3] = ["analogout", "analogena", "spinena"];

/// Reads `REMOTE.PORT.CHANNEL.PIN`, such as `7i77.0.1.analogout0`: port, channel, and the kind of the remote.
fn remote(rest: &str) -> Option<(u8, u8, String)> {
    let mut parts = rest.split(|c: char| c.is_whitespace() || c == '.');
    let (kind, port, channel) = (parts.next()?, parts.next()?, parts.next()?);
    let is_kind = kind
        .strip_prefix("7i")
        .is_some_and(|n| n.len() == 2 && n.chars().all(|c| c.is_ascii_digit()));
    let (port, channel) = (port.parse().ok()?, channel.parse().ok()?);
    // A 7I77 has its analogue outputs on a channel of their own.
    let is_analogue = kind == "7i77"
        && parts.next().is_some_and(|pin| ANALOGUE.iter().any(|begin| pin.starts_with(begin)));
    let kind = if is_analogue { "7i77-analog" } else { kind };
    (is_kind && port < 8 && channel < 8).then(|| (port, channel, kind.to_owned()))
}

/// Reads `KIND.NUMBER.` and returns both, and what follows.
fn card(text: &str) -> Option<(String, u32, &str)> {
    let (kind, rest) = text.split_once('.')?;
    let (number, rest) = rest.split_once('.')?;
    let number = number.parse().ok()?;
    let is_kind = !kind.is_empty() && kind.chars().all(|c| c.is_ascii_alphanumeric());
    is_kind.then(|| (kind.to_ascii_lowercase(), number, rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_cards() {
        let ini = Ini::parse("a.ini", b"[HOSTMOT2]\nBOARD = 7i96s\nX = a b\nCARD = hm2_7i95.1\n")
            .unwrap();
        // (line, cards: kind with remotes, number)
        let rows: &[(&str, &[(&str, u32)])] = &[
            ("net x hm2_7i92.0.gpio.000.in hm2_7I92.1.gpio.000.in", &[("7i92", 0), ("7i92", 1)]),
            ("net x hm2_7i92.1.gpio.000.in hm2_7i92.0.gpio.000.in", &[("7i92", 0), ("7i92", 1)]),
            ("setp hm2_[HOSTMOT2](BOARD).0.watchdog.timeout_ns 5", &[("7i96s", 0)]),
            ("setp hm2_[HOSTMOT2](BOARD).2.watchdog.timeout_ns 5", &[("7i96s", 2)]),
            // The name of the entry is BOARD.2.watchdog.timeout_ns: there is none.
            ("setp hm2_[HOSTMOT2]BOARD.2.watchdog.timeout_ns 5", &[]),
            ("setp hm2_[HOSTMOT2](X).0.a 5", &[]),
            ("setp hm2_[HOSTMOT2](Y).0.a 5", &[]),
            ("addf [HOSTMOT2](CARD).read servo", &[("7i95", 1)]),
            ("addf [HOSTMOT2](CARD).read servo # [", &[("7i95", 1)]),
            ("[HOSTMOT2 [HOSTMOT2] [](", &[]),
            ("# hm2_7i76e.0.read", &[]),
            ("loadrt hm2_eth board_ip=10.10.10.10", &[]),
            ("addf hm2_5i25.0.read servo", &[("5i25", 0)]),
            ("hm2_.0.a hm2_7i92.x.a hm2_7i92.0", &[]),
            (
                "net x hm2_7i92.0.7i77.0.1.analogout0 hm2_7i92.0.7i77.0.0.input-00",
                &[("7i92 0.0=7i77 0.1=7i77-analog", 0)],
            ),
            (
                "net x hm2_7i92.0.7i77.0.0.analogin0 hm2_7i92.0.7i77.0.1.analogout0 hm2_7i92.0.7i77.0.1.x",
                &[("7i92 0.0=7i77 0.1=7i77-analog", 0)],
            ),
            ("net x hm2_7i92.0.7i77.0.1.spinena", &[("7i92 0.1=7i77-analog", 0)]),
            ("net x hm2_7i76e.0.7i76.0.0.input-01-not", &[("7i76e 0.0=7i76", 0)]),
            ("net x hm2_7i76e.0.7i84.0.9.input-01", &[("7i76e", 0)]),
            (
                "net x hm2_7i92.0.pwmgen.01.value hm2_7i92.0.stepgen.04.enable hm2_7i92.0.pwmgen.00.x",
                &[("7i92 pwmgen=2 stepgen=5", 0)],
            ),
            ("setp hm2_7i92.0.pwmgen.pwm_frequency 5 hm2_7i92.0.encoder.300.x", &[("7i92", 0)]),
        ];
        for (line, expected) in rows {
            let mut cards = Cards::default();
            cards.add(line, Values { environment: &|_| None, ini: Some(&ini) });
            cards.sort();
            let found: Vec<_> = cards.0.iter().map(|card| (card.words(), card.number)).collect();
            let expected: Vec<_> = expected.iter().map(|(k, n)| ((*k).to_owned(), *n)).collect();
            assert_eq!(found, expected, "{line}");
        }
    }

    #[test]
    fn sourced_files_name_cards() {
        let folder = std::env::temp_dir().join(format!("ferrule-cards-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let ini = Ini::parse("a.ini", b"[HAL]\nCARDS = cards.hal\n").unwrap();
        let values = Values { environment: &|_| None, ini: Some(&ini) };
        let main = folder.join("main.hal");
        std::fs::write(folder.join("cards.hal"), "addf hm2_7i92.0.read servo\n").unwrap();
        for (line, want) in [
            ("source cards.hal", 1),
            ("  source  cards.hal  # the cards", 1),
            ("source [HAL]CARDS", 1),
            ("source [HAL](CARDS) # by variable", 1),
            ("# source cards.hal", 0),
            ("source [HAL]OTHER", 0),
        ] {
            std::fs::write(&main, line).unwrap();
            let mut cards = Cards::default();
            look(&main, values, &mut BTreeSet::new(), &mut cards);
            assert_eq!(cards.0.len(), want, "{line}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
