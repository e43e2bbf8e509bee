//! Kinds of Mesa's cards that a machine's files name: in simulation and in `check` no card can be asked for its pins.

use crate::{Command, Session, ini::Ini, programs::halrun::folders::Folders};
use hal_ini::file::whole;
use hal_protocol::Request;
use std::{
    collections::BTreeSet,
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
                args.push(format!("card={}", kinds.join(",")));
            }
        }
        Command::Send(Request::Load { module, args }, note)
    }

    /// Returns the kinds in the order in which the files name the cards.
    fn card_kinds(&self) -> Vec<String> {
        let mut cards = Vec::new();
        let mut seen = BTreeSet::new();
        let mut files: Vec<PathBuf> = vec![self.place().0.into()];
        if let Some(ini) = self.ini {
            let entries = ["HALFILE", "POSTGUI_HALFILE"].map(|name| ini.all("HAL", name));
            files.extend(entries.into_iter().flatten().filter_map(|entry| {
                let folders = Folders::of(Path::new(&entry.file));
                Some(folders.find(entry.value.split_whitespace().next()?)?.1)
            }));
            for entry in ini.all("HAL", "HALCMD") {
                add(&entry.value, self.ini, &mut cards);
            }
        }
        for file in files {
            look(&file, self.ini, &mut seen, &mut cards);
        }
        let kinds: Vec<String> = cards.into_iter().map(|(kind, _)| kind).collect();
        match self.ini.and_then(|ini| ini.get("HOSTMOT2", "BOARD")) {
            Some(board) if kinds.is_empty() => vec![board.to_ascii_lowercase()],
            _ => kinds,
        }
    }
}

/// Adds the cards of a file and of those that it sources.
fn look(
    path: &Path,
    ini: Option<&Ini>,
    seen: &mut BTreeSet<PathBuf>,
    cards: &mut Vec<(String, u32)>,
) {
    if seen.len() >= MAX_FILES || !path.is_file() || !seen.insert(path.to_owned()) {
        return;
    }
    let Ok(text) = whole(path) else { return };
    let here = path.parent().unwrap_or_else(|| Path::new(""));
    for line in String::from_utf8_lossy(&text).lines() {
        add(line, ini, cards);
        if let Some(file) = line.trim().strip_prefix("source ") {
            look(&hal_ini::beside(here, file.trim()), ini, seen, cards);
        }
    }
}

/// Adds the cards that a line names: their kind and their number among those of the kind.
fn add(line: &str, ini: Option<&Ini>, cards: &mut Vec<(String, u32)>) {
    let code = expanded(line.split('#').next().unwrap_or_default(), ini);
    for rest in code.split("hm2_").skip(1) {
        let Some(card) = card(rest) else { continue };
        if !cards.contains(&card) && cards.len() < MAX_CARDS {
            cards.push(card);
        }
    }
}

/// Returns a line with the entries of the INI file in place of `[SECTION](NAME)` and `[SECTION]NAME`.
fn expanded(line: &str, ini: Option<&Ini>) -> String {
    let mut parts = line.split('[');
    let mut whole = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let found = part.split_once(']').and_then(|(section, rest)| {
            let (name, rest) = match rest.strip_prefix('(') {
                Some(rest) => rest.split_once(')')?,
                None => {
                    let end = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
                    rest.split_at(rest.find(end).unwrap_or(rest.len()))
                }
            };
            Some((ini?.get(section, name)?, rest))
        });
        match found {
            Some((value, rest)) => {
                whole.push_str(value);
                whole.push_str(rest);
            }
            None => {
                whole.push('[');
                whole.push_str(part);
            }
        }
    }
    whole
}

/// Reads `KIND.NUMBER.`.
fn card(rest: &str) -> Option<(String, u32)> {
    let (kind, rest) = rest.split_once('.')?;
    let number = rest.split_once('.')?.0.parse().ok()?;
    let is_kind = !kind.is_empty() && kind.chars().all(|c| c.is_ascii_alphanumeric());
    is_kind.then(|| (kind.to_ascii_lowercase(), number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_name_cards() {
        let ini = Ini::parse("a.ini", b"[HOSTMOT2]\nBOARD = 7i96s\nX = a b\nCARD = hm2_7i95.1\n")
            .unwrap();
        // (line, cards)
        let rows: &[(&str, &[(&str, u32)])] = &[
            ("net x hm2_7i92.0.gpio.000.in hm2_7I92.1.gpio.000.in", &[("7i92", 0), ("7i92", 1)]),
            ("setp hm2_[HOSTMOT2](BOARD).0.watchdog.timeout_ns 5", &[("7i96s", 0)]),
            ("setp hm2_[HOSTMOT2]BOARD.2.watchdog.timeout_ns 5", &[("7i96s", 2)]),
            ("setp hm2_[HOSTMOT2](X).0.a 5", &[]),
            ("setp hm2_[HOSTMOT2](Y).0.a 5", &[]),
            ("addf [HOSTMOT2](CARD).read servo", &[("7i95", 1)]),
            ("addf [HOSTMOT2]CARD.read servo # [", &[("7i95", 1)]),
            ("[HOSTMOT2 [HOSTMOT2] [](", &[]),
            ("# hm2_7i76e.0.read", &[]),
            ("loadrt hm2_eth board_ip=10.10.10.10", &[]),
            ("addf hm2_5i25.0.read servo", &[("5i25", 0)]),
            ("hm2_.0.a hm2_7i92.x.a hm2_7i92.0", &[]),
        ];
        for (line, expected) in rows {
            let mut cards = Vec::new();
            add(line, Some(&ini), &mut cards);
            let expected: Vec<_> = expected.iter().map(|(k, n)| ((*k).to_owned(), *n)).collect();
            assert_eq!(cards, expected, "{line}");
        }
    }
}
