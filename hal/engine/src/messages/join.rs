//! Joining of messages from the same site: the first is logged at once, and the following ones as
//! at most one line per second of machine time, with their number.
//!
//! A site is a component, a level and a text without its numbers. The lines depend only on the
//! messages and their times, not on when or how often the control side reads them. A site that has
//! been silent for a second is treated as new, so that only active sites are kept.

use std::collections::BTreeMap;

/// Shortest time between two lines of a site, in nanoseconds of machine time.
const SECOND_NS: i64 = 1_000_000_000;

/// Largest number of sites of a component within a second; messages from further sites are only
/// counted.
const MAX_SITES: usize = 256;

/// Largest number of different sets of numbers that a line lists.
const MAX_NAMED: usize = 8;

/// The part that varies between the messages of a site.
#[derive(Clone, Debug)]
pub(crate) enum Said {
    /// The numbers that replace each `{}` of the text.
    Numbers(Vec<f64>),
    /// The whole text, if the component formatted it itself.
    Whole(String),
    /// A count; the counts of several messages are added up.
    Count(u64),
}

/// A line for the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LogLine {
    /// Name of the component.
    pub(crate) component: String,
    pub(crate) level: u8,
    pub(crate) text: String,
}

/// A site that has sent a message within the last second.
#[derive(Debug)]
struct Site {
    /// Time of its last line.
    last: i64,
    /// Number of messages since.
    count: u64,
    /// The latest message.
    latest: Said,
    /// The distinct numbers of earlier messages; `None` if there are too many.
    named: Option<Vec<Vec<f64>>>,
}

/// The sites of a component.
#[derive(Debug)]
struct Source {
    name: String,
    sites: BTreeMap<(u8, String), Site>,
}

/// The sites of all components.
#[derive(Debug)]
pub(crate) struct Joiner {
    sources: BTreeMap<u32, Source>,
    /// Time before which no joined line is due.
    due: i64,
}

impl Default for Joiner {
    fn default() -> Self {
        Self { sources: BTreeMap::new(), due: i64::MAX }
    }
}

impl Joiner {
    /// Adds a message. `text` has `{}` in place of numbers, or something else that is the same for
    /// all messages of the site.
    pub(crate) fn add(
        &mut self,
        at: i64,
        (component, name): (u32, &str),
        (level, text): (u8, &str),
        said: Said,
        lines: &mut Vec<LogLine>,
    ) {
        self.pass(at, lines);
        let source = self
            .sources
            .entry(component)
            .or_insert_with(|| Source { name: name.to_owned(), sites: BTreeMap::new() });
        let mut key = (level, text.to_owned());
        let mut said = said;
        if !source.sites.contains_key(&key) && source.sites.len() >= MAX_SITES {
            source.sites.retain(|_, site| !site.is_over(at));
            if source.sites.len() >= MAX_SITES {
                key.1 = "{} more messages, each of another kind".to_owned();
                said = Said::Count(1);
            }
        }
        if let Some(site) = source.sites.get_mut(&key).filter(|site| !site.is_over(at)) {
            self.due = self.due.min(site.add(said));
            return;
        }
        lines.push(LogLine {
            component: source.name.clone(),
            level,
            text: format_line(&source.name, &key.1, &said),
        });
        let site = Site { last: at, count: 0, latest: said, named: Some(Vec::new()) };
        source.sites.insert(key, site);
    }

    /// Advances to the time `now`: adds the joined lines that are due.
    pub(crate) fn pass(&mut self, now: i64, lines: &mut Vec<LogLine>) {
        while self.due <= now {
            let due = self.due;
            self.due = i64::MAX;
            for source in self.sources.values_mut() {
                for ((level, text), site) in &mut source.sites {
                    if site.count == 0 {
                        continue;
                    }
                    if site.last + SECOND_NS <= due {
                        lines.push(site.flush(*level, &source.name, text));
                    } else {
                        self.due = self.due.min(site.last + SECOND_NS);
                    }
                }
            }
        }
    }

    /// Removes a component, or all, and adds the lines that were not logged yet.
    pub(crate) fn end(&mut self, component: Option<u32>, lines: &mut Vec<LogLine>) {
        let ends = |id: u32| component.is_none_or(|c| c == id);
        for (_, source) in self.sources.iter_mut().filter(|(id, _)| ends(**id)) {
            for ((level, text), site) in &mut source.sites {
                if site.count > 0 {
                    lines.push(site.flush(*level, &source.name, text));
                }
            }
        }
        self.sources.retain(|id, _| !ends(*id));
    }
}

impl Site {
    /// Returns whether nothing waits to be logged, and the next message counts as a first one.
    fn is_over(&self, now: i64) -> bool {
        self.count == 0 && self.last.saturating_add(SECOND_NS) <= now
    }

    /// Adds one more message and returns the time at which its line is due.
    fn add(&mut self, said: Said) -> i64 {
        match (&self.latest, &said) {
            (Said::Count(sum), Said::Count(more)) if self.count > 0 => {
                self.latest = Said::Count(sum.saturating_add(*more));
            }
            _ => {
                let before = core::mem::replace(&mut self.latest, said);
                if self.count > 0 {
                    self.name(before);
                }
            }
        }
        self.count = self.count.saturating_add(1);
        self.last.saturating_add(SECOND_NS)
    }

    /// Records the numbers of a message that is no longer the latest.
    fn name(&mut self, said: Said) {
        let Said::Numbers(numbers) = said else { return };
        let Some(named) = &mut self.named else { return };
        if named.iter().any(|n| is_same(n, &numbers)) {
            return;
        }
        if named.len() < MAX_NAMED {
            named.push(numbers);
        } else {
            self.named = None;
        }
    }

    /// Returns the line for all messages since the last one.
    fn flush(&mut self, level: u8, source: &str, text: &str) -> LogLine {
        let mut line = format_line(source, text, &self.latest);
        if !matches!(self.latest, Said::Count(_)) {
            line += &match self.count {
                1 => " (once more)".to_owned(),
                n => format!(" (the last of {n} more)"),
            };
        }
        if let Some(also) = self.also() {
            line.truncate(line.len().saturating_sub(1));
            line += &also;
            line.push(')');
        }
        self.last = self.last.saturating_add(SECOND_NS);
        self.count = 0;
        self.named = Some(Vec::new());
        LogLine { component: source.to_owned(), level, text: line }
    }

    /// Formats the other numbers of the joined messages, if they are few.
    fn also(&self) -> Option<String> {
        let Said::Numbers(latest) = &self.latest else { return None };
        let others: Vec<String> = self
            .named
            .as_ref()?
            .iter()
            .filter(|n| !is_same(n, latest))
            .map(|n| n.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
            .collect();
        (!others.is_empty()).then(|| format!("; also with {}", others.join("; ")))
    }
}

/// Formats a message for the log.
fn format_line(source: &str, text: &str, said: &Said) -> String {
    match said {
        Said::Numbers(numbers) => format!("{source}: {}", filled(text, numbers)),
        Said::Whole(text) => format!("{source}: {text}"),
        Said::Count(n) => format!("{source}: {}", text.replacen("{}", &n.to_string(), 1)),
    }
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
}

/// Returns a text with each `{}` replaced by the next number.
pub(crate) fn filled(text: &str, numbers: &[f64]) -> String {
    numbers.iter().fold(text.to_owned(), |s, x| s.replacen("{}", &x.to_string(), 1))
}

/// Returns a text without its numbers: each run of digits becomes a `#`.
pub(crate) fn kind_of(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if !c.is_ascii_digit() {
            out.push(c);
        } else if !out.ends_with('#') {
            out.push('#');
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn say(joiner: &mut Joiner, ms: i64, who: u32, text: &str, numbers: &[f64]) -> Vec<String> {
        let mut lines = Vec::new();
        let name = ["one", "two", "three"][who as usize];
        let said = Said::Numbers(numbers.to_vec());
        joiner.add(ms * MS, (who, name), (1, text), said, &mut lines);
        lines.into_iter().map(|l| l.text).collect()
    }

    fn pass(joiner: &mut Joiner, ms: i64) -> Vec<String> {
        let mut lines = Vec::new();
        joiner.pass(ms * MS, &mut lines);
        lines.into_iter().map(|l| l.text).collect()
    }

    fn end(joiner: &mut Joiner) -> Vec<String> {
        let mut lines = Vec::new();
        joiner.end(None, &mut lines);
        lines.into_iter().map(|l| l.text).collect()
    }

    #[test]
    fn the_first_at_once_and_then_one_in_a_second() {
        let mut joiner = Joiner::default();
        assert_eq!(say(&mut joiner, 0, 0, "at {}", &[0.0]), ["one: at 0"]);
        for ms in 1..1000 {
            assert!(say(&mut joiner, ms, 0, "at {}", &[ms as f64]).is_empty());
        }
        assert_eq!(
            say(&mut joiner, 1000, 0, "at {}", &[1000.0]),
            ["one: at 999 (the last of 999 more)"]
        );
        assert!(say(&mut joiner, 1001, 0, "at {}", &[1001.0]).is_empty());
        assert!(pass(&mut joiner, 1999).is_empty());
        assert_eq!(pass(&mut joiner, 2000), ["one: at 1001 (the last of 2 more; also with 1000)"]);
        // Within a second of that line the message waits; after that second it counts as a first
        // one.
        assert!(say(&mut joiner, 2999, 0, "at {}", &[7.0]).is_empty());
        assert_eq!(pass(&mut joiner, 50_000), ["one: at 7 (once more)"]);
        assert_eq!(say(&mut joiner, 50_001, 0, "at {}", &[8.0]), ["one: at 8"]);
        assert!(end(&mut joiner).is_empty());
    }

    #[test]
    fn sites_do_not_disturb_each_other() {
        let mut joiner = Joiner::default();
        assert_eq!(say(&mut joiner, 0, 0, "joint {} fault", &[0.0]), ["one: joint 0 fault"]);
        assert_eq!(say(&mut joiner, 0, 1, "joint {} fault", &[5.0]), ["two: joint 5 fault"]);
        assert_eq!(say(&mut joiner, 100, 0, "off", &[]), ["one: off"]);
        for n in [1.0, 2.0, 1.0, 3.0] {
            assert!(say(&mut joiner, 100, 0, "joint {} fault", &[n]).is_empty());
            assert!(say(&mut joiner, 200, 0, "off", &[]).is_empty());
        }
        assert!(say(&mut joiner, 300, 1, "joint {} fault", &[5.0]).is_empty());
        // The lines come in the order in which they are due, whenever `pass` is called.
        assert_eq!(
            pass(&mut joiner, 5000),
            [
                "one: joint 3 fault (the last of 4 more; also with 1; 2)",
                "two: joint 5 fault (once more)",
                "one: off (the last of 4 more)",
            ]
        );
    }

    #[test]
    fn a_later_site_does_not_delay_an_earlier_one() {
        let mut joiner = Joiner::default();
        for (ms, text) in [(0, "a"), (100, "a"), (500, "b"), (600, "b")] {
            drop(say(&mut joiner, ms, 0, text, &[]));
        }
        assert!(pass(&mut joiner, 999).is_empty());
        assert_eq!(pass(&mut joiner, 1000), ["one: a (once more)"]);
        assert!(pass(&mut joiner, 1499).is_empty());
        assert_eq!(pass(&mut joiner, 1500), ["one: b (once more)"]);
    }

    #[test]
    fn what_waits_is_told_as_a_component_goes() {
        let mut joiner = Joiner::default();
        for who in [0, 1] {
            for _ in 0..3 {
                drop(say(&mut joiner, 5, who, "late", &[]));
            }
        }
        let mut lines = Vec::new();
        joiner.end(Some(1), &mut lines);
        assert_eq!(
            lines,
            [LogLine {
                component: "two".into(),
                level: 1,
                text: "two: late (the last of 2 more)".into()
            }]
        );
        // A component that is loaded later under the same number starts over.
        assert_eq!(say(&mut joiner, 6, 1, "late", &[]), ["two: late"]);
        assert_eq!(end(&mut joiner), ["one: late (the last of 2 more)"]);
        assert!(end(&mut joiner).is_empty());
    }

    #[test]
    fn counts_are_added_up() {
        let mut joiner = Joiner::default();
        let mut lines = Vec::new();
        for (ms, n) in [(0, 7), (10, 5), (20, 6), (2000, 1)] {
            joiner.add(ms * MS, (0, "one"), (2, "{} lost"), Said::Count(n), &mut lines);
        }
        let lines: Vec<String> = lines.into_iter().map(|l| l.text).collect();
        assert_eq!(lines, ["one: 7 lost", "one: 11 lost", "one: 1 lost"]);
    }

    #[test]
    fn a_line_names_eight_other_sets_of_numbers_or_none() {
        for (last, want) in [
            (9_u32, "one: at 9 (the last of 9 more; also with 1; 2; 3; 4; 5; 6; 7; 8)"),
            (10, "one: at 10 (the last of 10 more)"),
        ] {
            let mut joiner = Joiner::default();
            for n in 0..=last {
                drop(say(&mut joiner, 1, 0, "at {}", &[f64::from(n)]));
            }
            assert_eq!(pass(&mut joiner, 1001), [want]);
        }
    }

    #[test]
    fn a_component_has_256_sites_and_one_for_the_others() {
        let mut joiner = Joiner::default();
        for n in 1..=256 {
            let text = "x".repeat(n);
            assert_eq!(say(&mut joiner, 0, 0, &text, &[]), [format!("one: {text}")]);
        }
        assert_eq!(
            say(&mut joiner, 0, 0, "y", &[]),
            ["one: 1 more messages, each of another kind"]
        );
        // Another component has its own, and those that are silent make room.
        assert_eq!(say(&mut joiner, 0, 1, "y", &[]), ["two: y"]);
        assert_eq!(say(&mut joiner, 5000, 0, "y", &[]), ["one: y"]);
    }

    /// The number of lines is limited even for a component that sends a different text each time.
    #[test]
    fn sites_without_end_are_counted() {
        let mut joiner = Joiner::default();
        let mut told = 0;
        let mut count = 0;
        for n in 0..5000 {
            let text = format!("text of {}", "x".repeat(n % 1300 + 1));
            for line in say(&mut joiner, i64::try_from(n).unwrap(), 0, &text, &[]) {
                told += 1;
                count += counted(&line);
            }
        }
        for line in end(&mut joiner) {
            told += 1;
            count += counted(&line);
        }
        assert_eq!(count, 5000);
        assert!(told < 2000, "{told}");
    }

    /// Returns the number of messages that a line represents.
    fn counted(line: &str) -> u64 {
        if line.ends_with(" more messages, each of another kind") {
            return line.split(' ').nth(1).unwrap().parse().unwrap();
        }
        let Some((_, rest)) = line.split_once(" (") else { return 1 };
        let number = rest.strip_prefix("the last of ").and_then(|r| r.split(' ').next());
        number.map_or(1, |n| n.parse().unwrap())
    }

    #[test]
    fn texts_without_their_numbers() {
        for (text, kind) in [
            ("", ""),
            ("no number", "no number"),
            ("joint 12 at -3.50e-7", "joint # at -#.#e-#"),
            ("7", "#"),
        ] {
            assert_eq!(kind_of(text), kind);
        }
    }

    /// The lines are the same whenever the control side reads the messages: none is lost, and no
    /// site has a line too often.
    #[test]
    fn looking_changes_nothing() {
        let mut seed = 12345_u64;
        let mut random = |below: u64| {
            seed ^= seed << 13;
            seed ^= seed >> 7;
            seed ^= seed << 17;
            seed % below
        };
        for _ in 0..50 {
            let mut messages = Vec::new();
            let mut ms = 0;
            for _ in 0..3000 {
                ms += [0, 0, 1, 5, 300, 2500][usize::try_from(random(6).min(random(6))).unwrap()];
                messages.push((
                    ms,
                    u32::try_from(random(3)).unwrap(),
                    ["a {}", "b {}"][usize::try_from(random(2)).unwrap()],
                    random(5),
                ));
            }
            let mut runs: Vec<Vec<String>> = Vec::new();
            for how in 0..3 {
                let mut joiner = Joiner::default();
                let (mut lines, mut now) = (Vec::new(), 0);
                for (ms, who, text, n) in &messages {
                    // `pass` is never called, in every millisecond, or at random intervals.
                    let until = if how == 0 { now } else { *ms };
                    while now < until {
                        now += if how == 1 { 1 } else { 1 + random(700).cast_signed() };
                        lines.extend(pass(&mut joiner, now.min(*ms)));
                    }
                    now = now.min(*ms);
                    lines.extend(say(&mut joiner, *ms, *who, text, &[*n as f64]));
                }
                lines.extend(end(&mut joiner));
                assert_eq!(lines.iter().map(|l| counted(l)).sum::<u64>(), 3000);
                runs.push(lines);
            }
            assert_eq!(runs[0], runs[1]);
            assert_eq!(runs[0], runs[2]);
        }
    }
}
