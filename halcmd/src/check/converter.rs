//! Remedies for a pin and a signal of different types: a converter, or a pin of the right type.

use crate::session::dry_run::DryRun;
use hal_protocol::{Code, Direction, Finding, ItemInfo, Kind};

/// Largest number of other pins that a remedy names.
const MOST: usize = 4;

/// Adds a remedy to findings about a pin and a signal of different types.
pub(super) fn advise(findings: &mut [Finding], dry_run: &mut DryRun) {
    if findings.iter().all(|f| f.code != Code::TypeMismatch) {
        return;
    }
    let pins = dry_run.items(Kind::Pins);
    for finding in findings.iter_mut().filter(|f| f.code == Code::TypeMismatch) {
        let pin = pins.iter().find(|p| p.name == finding.subject);
        let (Some(pin), Some(signal)) = (pin, signal_type(finding)) else { continue };
        if let Some(text) = remedy(pin, signal, &pins) {
            let before = core::mem::take(&mut finding.remedy);
            finding.remedy = if before.is_empty() { text } else { format!("{before}; {text}") };
        }
    }
}

/// Returns the type of the signal, which the text of the finding names, or its remedy as the last word.
fn signal_type(finding: &Finding) -> Option<&str> {
    match finding.text.split_once("of type '") {
        Some((_, rest)) => rest.split('\'').next(),
        None => finding.remedy.rsplit(' ').next(),
    }
}

fn remedy(pin: &ItemInfo, signal: &str, pins: &[ItemInfo]) -> Option<String> {
    let own = pin.value.ty().name();
    let between = match pin.direction {
        Direction::In => converter(signal, own),
        Direction::Out => converter(own, signal),
        _ => None,
    };
    let between = between.map(|name| format!("put a component {name} between them"));
    let channel = |name: &str| name.rsplit_once('.').map(|(channel, _)| channel.to_owned());
    let fits = |p: &&ItemInfo| {
        p.signal.is_none()
            && p.direction == pin.direction
            && p.value.ty().name() == signal
            && channel(&p.name) == channel(&pin.name)
    };
    let others: Vec<&str> = pins.iter().filter(fits).map(|p| p.name.as_str()).take(MOST).collect();
    let others =
        (!others.is_empty()).then(|| format!("pins of type {signal}: {}", others.join(", ")));
    let all: Vec<String> = between.into_iter().chain(others).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// Returns the component that converts values from one type to another.
fn converter(from: &str, to: &str) -> Option<String> {
    let is_value = |ty: &str| ["bit", "float", "s32", "u32", "s64", "u64"].contains(&ty);
    match (from, to) {
        // A threshold decides which numbers are true.
        ("float", "bit") => Some("comp".to_owned()),
        _ if from != to && is_value(from) && is_value(to) => Some(format!("conv_{from}_{to}")),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::converter;
    use std::path::Path;

    #[test]
    fn every_converter_exists() {
        let pages = Path::new(env!("CARGO_MANIFEST_DIR")).join("../components/pages");
        let types = ["bit", "float", "s32", "u32", "s64", "u64"];
        for from in types {
            assert_eq!(converter(from, from), None);
            assert_eq!(converter(from, "port"), None);
            for to in types.into_iter().filter(|to| *to != from) {
                let name = converter(from, to).map(|name| format!("{name}.md"));
                assert!(name.is_some_and(|name| pages.join(name).is_file()), "{from} to {to}");
            }
        }
    }
}
