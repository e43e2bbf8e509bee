//! Mistakes in the order and the wiring of a machine, in HAL files.

use super::{Mutant, hal::Source};

/// Functions of which the first must run before the second.
const ORDER: &[(&str, &str)] = &[
    ("stepgen.capture-position", "motion-controller"),
    ("motion-command-handler", "motion-controller"),
    ("motion-controller", "stepgen.update-freq"),
];

/// Exchanges two functions that a thread must run in order.
pub(super) fn swapped(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let later = ORDER.iter().filter(|(first, _)| *first == words[1]).filter_map(|(_, second)| {
        let same = |w: &[&str]| w[1] == *second && w[2] == words[2];
        s.of("addf").find(|(m, w)| *m > n && same(w))
    });
    later
        .map(|(m, w)| {
            let mut made = s.replace("two functions exchanged", n, &w.join(" "));
            made.lines[m] = words.join(" ");
            made.also(m).cured([format!("{}, ", words[1]), format!(", {}", w[1])])
        })
        .collect()
}

/// Sets a float to NaN.
pub(super) fn nan(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    if words[2].parse::<f64>().is_err() {
        return Vec::new();
    }
    let made = s.replace("setp: NaN", n, &format!("setp {} nan", words[1]));
    vec![made.cured(["number", "integer", "value"])]
}

/// Exchanges step and direction of a step generator.
pub(super) fn step_and_direction(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let Some(channel) = words.get(2).and_then(|pin| pin.strip_suffix(".step")) else {
        return Vec::new();
    };
    let dir = format!("{channel}.dir");
    let Some((m, w)) = s.of("net").find(|(_, w)| w.get(2).is_some_and(|pin| *pin == dir)) else {
        return Vec::new();
    };
    let made = s.replace("step and direction crossed", n, &words.join(" ").replace(words[2], &dir));
    let mut made = made.also(m).cured([words[2], &dir]);
    made.lines[m] = w.join(" ").replace(&dir, words[2]);
    vec![made]
}

/// Removes the answers to tool changes.
pub(super) fn tool_change(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let is_tool = |w: &[&str]| w.iter().any(|pin| pin.starts_with("iocontrol.0.tool-"));
    let first = s.of("net").find(|(_, w)| is_tool(w)).map(|(m, _)| m);
    if !is_tool(words) || first != Some(n) {
        return Vec::new();
    }
    let mut made = s.replace("tool-change loop removed", n, "");
    for (m, w) in s.of("net") {
        if is_tool(&w) {
            made.lines[m].clear();
        }
    }
    vec![made.named(["iocontrol.0.tool-", "TOOL_TABLE"]).cured(["iocontrol.0.tool-", "net "])]
}

/// Writes another letter inside a word of a signal's name.
pub(super) fn letter(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let uses = s.of("net").filter(|(_, w)| w[1] == words[1]).count();
    let mut from = 0;
    let word = words[1].split(['-', '_', '.']).find(|word| {
        from = words[1].find(word).unwrap_or_default();
        word.len() >= 5 && word.bytes().all(|b| b.is_ascii_lowercase())
    });
    let Some(word) = word.filter(|_| uses > 1) else { return Vec::new() };
    let at = from + word.len() / 2;
    let other = if words[1].as_bytes()[at] == b'k' { "l" } else { "k" };
    let wrong = format!("{}{other}{}", &words[1][..at], &words[1][at + 1..]);
    let mut changed = words.to_vec();
    changed[1] = &wrong;
    let made = s.replace("signal with a wrong letter", n, &changed.join(" "));
    vec![made.named([words[1], &wrong]).cured([words[1]])]
}

/// Repeats a letter of the kinematics' coordinates.
pub(super) fn coordinates(s: &Source<'_>, n: usize, words: &[&str]) -> Vec<Mutant> {
    let Some(word) = words.iter().find(|w| w.starts_with("coordinates=")) else {
        return Vec::new();
    };
    let last = &word[word.len() - 1..];
    let line = s.lines[n].replace(word, &format!("{word}{last}"));
    let made = s.replace("a letter twice in coordinates=", n, &line);
    vec![made.named(["coordinates"]).cured(["coordinates", "num_joints", "JOINTS"])]
}
