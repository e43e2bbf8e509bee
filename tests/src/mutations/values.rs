//! Mistakes in `setp` and `start` lines of HAL files.

use super::{
    Mutant,
    hal::{Source, misspelt},
};

pub(super) fn setp(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let (pin, value) = (words[1], words[2]);
    let line = |pin: &str, value: &str| format!("setp {pin} {value}");
    let mut all = vec![
        s.replace("setp: pin misspelt", n, &line(&misspelt(pin), value)).cured([pin]),
        s.replace("setp without a value", n, &format!("setp {pin}")).cured(["value", "VALUE"]),
        s.replace("setp: a word for a number", n, &line(pin, "fast"))
            .cured(["number", "integer", "1 or 0", "TRUE", "value"]),
    ];
    let mut twice = s.replace("setp twice with another value", n, &s.lines[n]);
    twice.lines.insert(n + 1, line(pin, if value == "2" || value == "TRUE" { "0" } else { "2" }));
    all.push(twice.also(n + 1).cured(["keep", "one"]));
    // A gain of 1 and a delay of 0 are those that the pin has anyway.
    if pin.ends_with("scale") || pin.contains("gain") || pin.contains("-reset") {
        let made = s.replace("setp removed", n, "").named([pin]);
        if !["1", "0"].contains(&value) || pin.ends_with("-scale") {
            all.push(made.cured([pin]));
        }
    }
    if let Some((before, after)) = pin.split_once(".0.") {
        let wrong = format!("{before}.9.{after}");
        all.push(s.replace("setp: channel that does not exist", n, &line(&wrong, value)).cured([
            pin,
            "num_chan",
            "count",
            "step_type",
            "names",
            "cfg",
        ]));
    }
    all
}

pub(super) fn setp_values(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let (pin, value) = (words[1], words[2]);
    let mut all = Vec::new();
    if let Some((whole, rest)) = value.split_once('.')
        && value.parse::<f64>().is_ok()
    {
        let wrong = format!("setp {pin} {whole},{rest}");
        all.push(s.replace("setp: a decimal comma", n, &wrong).cured([value]));
    }
    if pin.ends_with("scale") {
        let made = s.replace("scale of zero", n, &format!("setp {pin} 0"));
        all.push(made.cured(["unit", "not zero"]));
    }
    if value.starts_with('[') {
        let wrong = format!("setp {pin} {}", misspelt(value));
        all.push(
            s.replace("INI entry misspelt", n, &wrong)
                .cured([value, &value.replace(['[', ']'], "")]),
        );
        let (section, key) = value.split_once(']').unwrap();
        if let Some(number) = section.strip_suffix('0') {
            let wrong = format!("setp {pin} {number}7]{key}");
            all.push(
                s.replace("INI section of another machine", n, &wrong).cured([section, "[", key]),
            );
        }
    }
    if let Some((prefix, last)) = pin.rsplit_once('.')
        && last.starts_with("max")
        && let Some((m, w)) =
            s.of("setp").find(|(_, w)| w[1] == format!("{prefix}.{}", last.replace("max", "min")))
        && w[2] != value
    {
        let mut made = s.replace("limits exchanged", n, &format!("setp {pin} {}", w[2]));
        made.lines[m] = format!("setp {} {value}", w[1]);
        all.push(made.also(m).cured(["swap"]));
    }
    let out =
        s.of("net").find_map(|(_, w)| (w.len() == 5 && w[3] == "=>").then(|| w[2].to_owned()));
    if let Some(out) = out {
        let made = s.replace("setp of an output", n, &format!("setp {out} 1"));
        all.push(made.cured(["output", &out, "input"]));
    }
    all
}

pub(super) fn start(s: &Source<'_>, n: usize, _: &[&str]) -> Vec<Mutant> {
    vec![s.replace("start left out", n, "").named(["threads", "start"]).cured(["start"])]
}
