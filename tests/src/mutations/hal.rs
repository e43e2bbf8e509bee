//! Mistakes in HAL files.

use super::{
    Mutant,
    values::{setp, setp_values, start},
    wiring::{coordinates, letter, nan, step_and_direction, swapped, tool_change},
};

/// Makes the mutants of one line.
type Make = fn(&Source<'_>, usize, &[&str]) -> Vec<Mutant>;

/// A HAL file.
pub(super) struct Source<'a> {
    pub(super) name: &'a str,
    pub(super) lines: &'a [String],
}

impl Source<'_> {
    pub(super) fn replace(&self, kind: &'static str, index: usize, line: &str) -> Mutant {
        Mutant::replace(kind, (self.name, self.lines), index, line)
    }

    /// Returns the lines that begin with this command, as words.
    pub(super) fn of(&self, command: &str) -> impl Iterator<Item = (usize, Vec<&str>)> {
        let lines = self.lines.iter().map(|l| l.split_whitespace().collect::<Vec<_>>());
        lines.enumerate().filter(move |(_, words)| words.first().is_some_and(|w| *w == command))
    }

    /// Returns the number of lines that link this signal.
    fn uses(&self, signal: &str) -> usize {
        self.of("net").filter(|(_, w)| w[1] == signal).count()
    }
}

/// The kinds of mistakes, by the command of the line.
const KINDS: &[(&str, Make)] = &[
    ("net", net_removed),
    ("net", net_misspelt),
    ("net", net_wiring),
    ("net", net_channels),
    ("net", net_crossed),
    ("net", step_and_direction),
    ("net", tool_change),
    ("net", letter),
    ("addf", addf),
    ("addf", swapped),
    ("loadrt", loadrt),
    ("loadrt", loadrt_arguments),
    ("loadrt", coordinates),
    ("setp", nan),
    ("setp", setp),
    ("setp", setp_values),
    ("start", start),
];

/// Returns the mutants of a HAL file.
pub(super) fn mutants(name: &str, lines: &[String]) -> Vec<Mutant> {
    let source = Source { name, lines };
    let mut all = Vec::new();
    for (command, make) in KINDS {
        for (index, words) in source.of(command) {
            all.extend(make(&source, index, &words));
        }
    }
    for (index, line) in lines.iter().enumerate() {
        let Some((word, rest)) = line.split_once(' ') else { continue };
        if ["net", "addf", "loadrt", "setp"].contains(&word) && index % 7 == 0 {
            let wrong = format!("{} {rest}", misspelt(word));
            all.push(source.replace("command misspelt", index, &wrong).cured([word]));
            let wrong = format!("{line} \"x");
            all.push(source.replace("quote left open", index, &wrong).cured(["\""]));
        }
    }
    all
}

/// Swaps the last two letters that differ.
pub(super) fn misspelt(word: &str) -> String {
    let mut letters: Vec<char> = word.chars().collect();
    let at = (1..letters.len()).rev().find(|n| {
        let (a, b) = (letters[n - 1], letters[*n]);
        a != b && a.is_ascii_alphabetic() && b.is_ascii_alphabetic()
    });
    match at {
        Some(n) => letters.swap(n - 1, n),
        None => letters.push('x'),
    }
    letters.into_iter().collect()
}

fn is_arrow(word: &str) -> bool {
    matches!(word, "=>" | "<=" | "<=>")
}

fn pins<'a>(words: &[&'a str]) -> Vec<&'a str> {
    words[2..].iter().copied().filter(|w| !is_arrow(w)).collect()
}

fn net_removed(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    // A signal that nothing reads serves to watch it, and one with a single reader to set it.
    let pins = pins(words);
    if pins.len() < 2 && s.uses(words[1]) == 1 {
        return Vec::new();
    }
    let gone = s.replace("net removed", n, "").named(pins.clone()).named([words[1]]);
    let mut all = vec![gone.cured(pins.clone()).cured([words[1]])];
    if pins.len() > 1 {
        let last = pins[pins.len() - 1];
        let arrow = usize::from(is_arrow(words[words.len() - 2]));
        let without = words[..words.len() - 1 - arrow].join(" ");
        all.push(s.replace("net without its last pin", n, &without).named([last]).cured([last]));
    }
    all
}

fn net_misspelt(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let mut all = Vec::new();
    let with = |at: usize, word: &str| {
        let mut words = words.to_vec();
        words[at] = word;
        words.join(" ")
    };
    if s.uses(words[1]) > 1 {
        let wrong = misspelt(words[1]);
        let made = s.replace("signal misspelt", n, &with(1, &wrong));
        all.push(made.named([words[1], &wrong]).cured([words[1]]));
    }
    for (at, word) in words.iter().enumerate().skip(2).filter(|(_, w)| !is_arrow(w)) {
        all.push(s.replace("pin misspelt", n, &with(at, &misspelt(word))).cured([*word]));
    }
    if words.len() > 4 {
        let without = with(1, "").replace("net  ", "net ");
        all.push(s.replace("signal's name left out", n, &without).cured(["net SIGNAL"]));
    }
    all
}

fn net_wiring(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let mut all = Vec::new();
    let pins = pins(words);
    if let Some(at) = words.iter().position(|w| *w == "=>" || *w == "<=")
        && at == 3
    {
        let mut turned = words.to_vec();
        turned[at] = if words[at] == "=>" { "<=" } else { "=>" };
        all.push(s.replace("arrow turned round", n, &turned.join(" ")).cured(["=>", "<="]));
        if words.len() == 5 {
            // The writer is linked to the next net's signal too.
            let other = s.of("net").find(|(m, w)| *m > n && w.len() == 5 && w[1] != words[1]);
            if let Some((_, w)) = other {
                let mut made = s.replace("pin linked twice", n, &words.join(" "));
                made.lines.insert(n + 1, format!("net {} {}", w[1], words[2]));
                made.line = n + 2;
                let taken = [words[1].to_owned(), format!("unlinkp {}", words[2])];
                all.push(made.also(n).cured(taken));
            }
        }
    }
    if pins.len() > 1 && words[words.len() - 2] == "=>" {
        let other = s.of("net").find(|(m, w)| {
            *m != n && w.len() == 5 && w[3] == "=>" && w[2] != words[2] && kin(w[2], words[2])
        });
        if let Some((m, w)) = other {
            let line = format!("{} {}", words.join(" "), w[2]);
            let made = s.replace("second writer", n, &line);
            all.push(made.also(m).cured([words[1], w[1], w[2], "or2", "mux2"]));
        }
    }
    all
}

/// Returns whether two pins are the same pin of two channels.
fn kin(a: &str, b: &str) -> bool {
    let plain = |name: &str| name.replace(|c: char| c.is_ascii_digit(), "#");
    a != b && plain(a) == plain(b)
}

fn net_channels(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let mut all = Vec::new();
    for (at, word) in words.iter().enumerate().skip(2) {
        let parts: Vec<&str> = word.split('.').collect();
        let Some(number) = parts.iter().position(|p| p.parse::<u32>().is_ok()) else { continue };
        let own = parts[number].parse::<u32>().unwrap();
        let mut with = |kind, channel: u32| {
            let text = channel.to_string();
            let mut parts = parts.clone();
            parts[number] = &text;
            let mut changed = words.to_vec();
            let name = parts.join(".");
            changed[at] = &name;
            let made = s.replace(kind, n, &changed.join(" "));
            all.push(made.named([*word, name.as_str()]).cured([*word]));
        };
        with("channel that does not exist", 9);
        if own > 0 {
            with("channel of another axis", own - 1);
        }
    }
    all
}

fn net_crossed(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let mut all = Vec::new();
    if words.len() != 5 || words[3] != "=>" {
        return all;
    }
    // The same net of the next channel: their sources are exchanged.
    let other =
        s.of("net").find(|(m, w)| *m > n && w.len() == 5 && w[3] == "=>" && kin(w[2], words[2]));
    let Some((m, w)) = other else { return all };
    for (kind, at) in [("two sources crossed", 2), ("two readers crossed", 4)] {
        let (mut a, mut b) = (words.to_vec(), w.clone());
        core::mem::swap(&mut a[at], &mut b[at]);
        let mut made = s.replace(kind, n, &a.join(" "));
        made.lines[m] = b.join(" ");
        let names = [words[2], words[4], w[2], w[4]];
        all.push(made.also(m).named(names).cured(names));
    }
    all
}

fn addf(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let mut all = Vec::new();
    let (funct, thread) = (words[1], words[2]);
    let line = |funct: &str, thread: &str| format!("addf {funct} {thread}");
    let cure = line(funct, thread);
    // The board of the printer's machine is read, and nothing uses its inputs.
    if funct != "viagpio.read" {
        all.push(s.replace("addf removed", n, "").named([funct]).cured([cure.clone()]));
    }
    let wrong = line(&misspelt(funct), thread);
    all.push(s.replace("addf: function misspelt", n, &wrong).cured([funct]));
    let wrong = line(funct, &misspelt(thread));
    all.push(s.replace("addf: thread misspelt", n, &wrong).cured([thread]));
    all.push(
        s.replace("addf without a thread", n, &format!("addf {funct}")).cured(["thread", "THREAD"]),
    );
    let other = s.of("addf").map(|(_, w)| w[2].to_owned()).find(|t| t != thread);
    if let Some(other) = other {
        let fast = ["make-pulses", "update-counters", "charge-pump", "parport", "viagpio"];
        if fast.iter().any(|f| funct.contains(f))
            || funct.starts_with("motion")
            || funct.contains('.')
        {
            let made = s.replace("addf in the wrong thread", n, &line(funct, &other));
            all.push(made.cured([cure.clone()]));
        }
    }
    let mut twice = s.replace("addf twice", n, &s.lines[n]);
    twice.lines.insert(n + 1, s.lines[n].clone());
    all.push(twice.also(n + 1).cured(["delf", "once", "take", "remove", "is added"]));
    if let Some((component, _)) = funct.rsplit_once('.') {
        let wrong = line(component, thread);
        all.push(s.replace("addf of the component", n, &wrong).cured([funct]));
    }
    all
}

fn loadrt(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let module = words[1];
    let line = &s.lines[n];
    let names = words.iter().find_map(|w| w.strip_prefix("names="));
    let makes: Vec<&str> = names.map_or_else(|| vec![module], |n| n.split(',').collect());
    let mut all = Vec::new();
    let load = format!("loadrt {module}");
    let gone = s.replace("loadrt removed", n, "").named(makes.clone()).named([module]);
    all.push(
        gone.cured([load.clone(), module.to_owned()])
            .cured(makes.iter().map(|m| format!("names={m}"))),
    );
    if !module.starts_with('[') {
        let wrong = line.replacen(module, &misspelt(module), 1);
        all.push(s.replace("loadrt: module misspelt", n, &wrong).cured([module]));
    }
    if let Some((key, _)) = words.get(2).and_then(|w| w.split_once('=')) {
        let wrong = line.replacen(&format!("{key}="), &format!("{}=", misspelt(key)), 1);
        all.push(s.replace("loadrt: argument misspelt", n, &wrong).cured([key]));
    }
    let mut twice = s.replace("loadrt twice", n, line);
    twice.lines.insert(n + 1, line.clone());
    twice.line = n + 2;
    all.push(twice.also(n).cured(["already", "names=", "one", "unloadrt", "loadrt"]));
    let mut late = s.replace("loadrt at the end", n, "");
    late.lines.push(line.clone());
    all.push(late.named(makes).named([module]).cured([load, module.to_owned()]));
    all
}

fn loadrt_arguments(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let mut all = Vec::new();
    let line = &s.lines[n];
    let lists = ["names=", "step_type=", "cfg=", "output_type="];
    for word in &words[2..] {
        let Some((key, value)) = word.split_once('=') else { continue };
        let is_list = lists.iter().any(|l| word.starts_with(l));
        if is_list && let Some((kept, lost)) = value.rsplit_once(',') {
            let wrong = line.replacen(value, kept, 1);
            let made = s.replace("loadrt: one channel too few", n, &wrong);
            all.push(made.named([words[1], lost]).cured([key]));
        }
        if key == "names" {
            let wrong = line.replacen(value, &misspelt(value), 1);
            all.push(s.replace("loadrt: name misspelt", n, &wrong).cured([
                misspelt(value),
                value.to_owned(),
                "names=".to_owned(),
            ]));
        } else if !value.starts_with('[') && value.parse::<i64>().is_ok() {
            let wrong = line.replacen(&**word, &format!("{key}=two"), 1);
            all.push(
                s.replace("loadrt: a word for a number", n, &wrong)
                    .cured(["number", "integer", key]),
            );
        }
        if value.starts_with('[') {
            let wrong = line.replacen(value, &misspelt(value), 1);
            all.push(
                s.replace("INI entry misspelt", n, &wrong)
                    .cured([value, &value.replace(['[', ']'], "")]),
            );
        }
    }
    all
}
