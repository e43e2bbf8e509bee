//! Differences between two drawings.

mod shift;

use shift::Shift;

/// Maximum number of edge pairs that are compared to match old and new edges.
const PAIRS: usize = 4_000_000;

/// A parsed line of a drawing.
#[derive(Clone, Debug, Default, PartialEq)]
struct WaveLine {
    name: String,
    first: String,
    /// Time of each change in microseconds, and the change in words.
    changes: Vec<(f64, String)>,
}

impl WaveLine {
    fn read(text: &str) -> Option<Self> {
        let (name, rest) = text.split_once("  ")?;
        let (name, rest) = (name.to_owned(), rest.trim());
        let mut changes = Vec::new();
        let first;
        if rest.starts_with(['_', '‾']) {
            let end = rest.char_indices().nth(1).map_or(rest.len(), |(n, _)| n);
            let (level, mut left) = rest.split_at_checked(end)?;
            first = level.to_owned();
            while !left.is_empty() {
                let (edge, level) = match left.chars().next()? {
                    '/' => ("rises", '‾'),
                    '\\' => ("falls", '_'),
                    _ => return None,
                };
                let after = left.get(1..)?.strip_prefix(level)?;
                let (time, after) = after.split_once(level)?;
                changes.push((time.parse().ok()?, edge.to_owned()));
                left = after;
            }
        } else {
            let mut parts = rest.split(" |");
            first = parts.next()?.to_owned();
            for part in parts {
                let (time, value) = part.split_once(' ')?;
                changes.push((time.parse().ok()?, format!("becomes {value}")));
            }
        }
        Some(Self { name, first, changes })
    }
}

/// Returns the differences between the expected and the found drawing, one sentence each: which
/// edge moved, and by how much. Returns an empty list if both drawings are equal.
#[must_use]
pub fn differences(expected: &str, found: &str) -> Vec<String> {
    let lines = |text: &str| -> Vec<Result<WaveLine, String>> {
        let lines = text.lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'));
        lines.map(|l| WaveLine::read(l).ok_or_else(|| l.to_owned())).collect()
    };
    let (expected, found) = (lines(expected), lines(found));
    let mut said = Vec::new();
    let unread = expected.iter().filter_map(|l| l.as_ref().err());
    said.extend(unread.map(|l| format!("this line of what was kept is not a waveform: {l}")));
    let old: Vec<&WaveLine> = expected.iter().flatten().collect();
    let new: Vec<&WaveLine> = found.iter().flatten().collect();
    let ends = (shift::last(&old), shift::last(&new));
    if let Some(shift) = Shift::of(&old, &new, ends).filter(|_| said.is_empty()) {
        return vec![shift.told("everything")];
    }
    for line in &old {
        match new.iter().find(|l| l.name == line.name) {
            Some(now) => match Shift::of(&[line], &[now], ends).filter(Shift::crosses_ends) {
                Some(shift) => said.push(shift.told(&line.name)),
                None => moved(line, now, &mut said),
            },
            None => said.push(format!("{} is no longer there", line.name)),
        }
    }
    for line in new.iter().filter(|l| !old.iter().any(|o| o.name == l.name)) {
        said.push(format!("{} was not there", line.name));
    }
    said
}

/// Two matching edges, or one edge without a match.
#[derive(Clone, Copy)]
enum Pair<'l> {
    Both(&'l (f64, String), &'l (f64, String)),
    Gone(&'l (f64, String)),
    New(&'l (f64, String)),
}

fn moved(old: &WaveLine, new: &WaveLine, said: &mut Vec<String>) {
    let name = &old.name;
    if old.first != new.first {
        let level = |text: &str| match text {
            "_" => "low".to_owned(),
            "‾" => "high".to_owned(),
            "?" => "not known".to_owned(),
            value => value.to_owned(),
        };
        said.push(format!("{name} begins {}, not {}", level(&new.first), level(&old.first)));
    }
    let mut pairs = pairs(&old.changes, &new.changes).into_iter().peekable();
    while let Some(pair) = pairs.next() {
        match pair {
            Pair::Both(a, b) if a.0 == b.0 => {}
            Pair::Both(a, b) => {
                // Following edges that moved by the same amount are reported in the same sentence.
                let by = rounded(b.0 - a.0);
                let mut more = 0;
                while let Some(Pair::Both(c, d)) = pairs.peek()
                    && rounded(d.0 - c.0) == by
                {
                    more += 1;
                    pairs.next();
                }
                let way = if by < 0.0 { "earlier" } else { "later" };
                let edges = if more == 1 { "edge" } else { "edges" };
                let rest = if more == 0 {
                    String::new()
                } else {
                    format!(", and {more} {edges} after it as much")
                };
                said.push(format!(
                    "{name} {} at {} µs, not at {} µs: {} µs {way}{rest}",
                    a.1,
                    b.0,
                    a.0,
                    by.abs()
                ));
            }
            Pair::Gone(a) => said.push(format!("{name} no longer {} at {} µs", a.1, a.0)),
            Pair::New(b) => said.push(format!("{name} {} at {} µs, which it did not", b.1, b.0)),
        }
    }
}

/// Rounds to nanoseconds, to remove binary rounding errors.
fn rounded(us: f64) -> f64 {
    (us * 1e3).round() / 1e3
}

/// Matches old and new edges. Minimizes removed and added edges first, then moved ones.
fn pairs<'l>(old: &'l [(f64, String)], new: &'l [(f64, String)]) -> Vec<Pair<'l>> {
    // Equal edges at both ends need no search.
    let same = |(a, b): &(&(f64, String), &(f64, String))| a == b;
    let head = old.iter().zip(new).take_while(same).count();
    let (old_rest, new_rest) = (old.get(head..).unwrap_or(&[]), new.get(head..).unwrap_or(&[]));
    let tail = old_rest.iter().rev().zip(new_rest.iter().rev()).take_while(same).count();
    let a = old_rest.get(..old_rest.len() - tail).unwrap_or(&[]);
    let b = new_rest.get(..new_rest.len() - tail).unwrap_or(&[]);
    if a.len().saturating_mul(b.len()) > PAIRS {
        let gone = a.iter().map(Pair::Gone);
        return gone.chain(b.iter().map(Pair::New)).collect();
    }
    // Least cost of matching the remaining edges of both lists, from each pair of indices on.
    let width = b.len() + 1;
    let mut costs = vec![0_u32; (a.len() + 1) * width];
    let at = |i: usize, j: usize| i * width + j;
    let cost = |costs: &[u32], i, j| costs.get(at(i, j)).copied().unwrap_or(u32::MAX / 2);
    let pair = |x: &(f64, String), y: &(f64, String)| {
        (x.1 == y.1).then_some(if x.0 == y.0 { 0 } else { 3 })
    };
    for i in (0..=a.len()).rev() {
        for j in (0..=b.len()).rev() {
            let one = u32::MAX / 2;
            let both = match (a.get(i), b.get(j)) {
                (None, None) => 0,
                (Some(x), Some(y)) => pair(x, y).map_or(one, |c| c + cost(&costs, i + 1, j + 1)),
                _ => one,
            };
            let gone = if i < a.len() { 5 + cost(&costs, i + 1, j) } else { one };
            let come = if j < b.len() { 5 + cost(&costs, i, j + 1) } else { one };
            if let Some(place) = costs.get_mut(at(i, j)) {
                *place = both.min(gone).min(come);
            }
        }
    }
    let mut found = Vec::new();
    let (mut i, mut j) = (0, 0);
    while let (x, y) = (a.get(i), b.get(j))
        && (x.is_some() || y.is_some())
    {
        let here = cost(&costs, i, j);
        match (x, y) {
            (Some(x), Some(y))
                if pair(x, y).is_some_and(|c| here == c + cost(&costs, i + 1, j + 1)) =>
            {
                found.push(Pair::Both(x, y));
                (i, j) = (i + 1, j + 1);
            }
            (Some(x), _) if here == 5 + cost(&costs, i + 1, j) => {
                found.push(Pair::Gone(x));
                i += 1;
            }
            (_, Some(y)) => {
                found.push(Pair::New(y));
                j += 1;
            }
            (Some(x), None) => {
                found.push(Pair::Gone(x));
                i += 1;
            }
            (None, None) => break,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Trace, draw::edges};
    use hal_protocol::{Type, Value};

    fn drawn(rises: &[i64], width: i64) -> String {
        let mut trace = Trace::default();
        let (step, pos) = (trace.add("step", Type::Bit), trace.add("motor.pos", Type::Float));
        trace.push(0, &[0, 0.5_f64.to_bits()]).unwrap();
        for (n, rise) in rises.iter().enumerate() {
            trace.sample(*rise).unwrap();
            trace.set(step, Value::Bit(true)).unwrap();
            trace.set(pos, Value::Float(n as f64 + 1.0)).unwrap();
            trace.sample(rise + width).unwrap();
            trace.set(step, Value::Bit(false)).unwrap();
        }
        edges(&trace, &["step", "motor.pos"], 0, 1_000_000).unwrap()
    }

    #[test]
    fn each_edge_has_its_time() {
        let want = "step       _/‾100‾\\_150.5_/‾300‾\\_350.5_\nmotor.pos  0.5 |100 1 |300 2\n";
        assert_eq!(drawn(&[100_000, 300_000], 50_500), want);
        let no = edges(&Trace::default(), &["x"], 0, 1).unwrap_err().to_string();
        assert_eq!(no, "'x' is not in the trace");
    }

    #[test]
    fn what_moved_is_told() {
        let before = drawn(&[100_000, 300_000, 500_000], 50_000);
        let check = |after: &str, want: &[&str]| assert_eq!(differences(&before, after), want);
        check(&before, &[]);
        check(
            &drawn(&[100_000, 300_000, 510_000], 50_000),
            &[
                "step rises at 510 µs, not at 500 µs: 10 µs later, and 1 edge after it as much",
                "motor.pos becomes 3 at 510 µs, not at 500 µs: 10 µs later",
            ],
        );
        check(&drawn(&[90_000, 290_000, 490_000], 50_000), &["everything is 10 µs earlier"]);
        check(
            &drawn(&[100_000, 500_000], 50_000),
            &[
                "step no longer rises at 300 µs",
                "step no longer falls at 350 µs",
                "motor.pos becomes 2 at 500 µs, not at 300 µs: 200 µs later",
                "motor.pos no longer becomes 3 at 500 µs",
            ],
        );
        check(
            "step  ‾\\_20_\nother  ?\n",
            &[
                "step begins high, not low",
                "step no longer rises at 100 µs",
                "step falls at 20 µs, not at 150 µs: 130 µs earlier",
                "step no longer rises at 300 µs",
                "step no longer falls at 350 µs",
                "step no longer rises at 500 µs",
                "step no longer falls at 550 µs",
                "motor.pos is no longer there",
                "other was not there",
            ],
        );
    }

    #[test]
    fn edges_that_leave_the_window_do_not_contradict_the_others() {
        let before = "step  _/‾100‾\\_200_/‾400‾\\_500_/‾900‾\npos  0 |100 1 |400 2 |900 3\n";
        let check = |after: &str, want: &[&str]| assert_eq!(differences(before, after), want);
        // The last rise is beyond the end, and so is its value.
        let later = "step  _/‾250‾\\_350_/‾550‾\\_650_\npos  0 |250 1 |550 2\n";
        check(later, &["everything is 150 µs later; 2 edges have left the window"]);
        // The first rise was before the start; a fall has come in at the end.
        let earlier = "step  ‾\\_50_/‾250‾\\_350_/‾750‾\\_850_\npos  1 |250 2 |750 3\n";
        check(
            earlier,
            &[
                "everything is 150 µs earlier; 2 edges have left the window; 1 edge has come into it",
            ],
        );
        // One of two channels.
        let one = "step  _/‾250‾\\_350_/‾550‾\\_650_\npos  0 |100 1 |400 2 |900 3\n";
        check(one, &["step is 150 µs later; 1 edge has left the window"]);
        // A fall that is missing inside the window has not left it.
        let lost = "step  _/‾250‾\\_350_/‾550‾\npos  0 |100 1 |400 2 |900 3\n";
        assert!(differences(before, lost).contains(&"step no longer falls at 500 µs".to_owned()));
        // Another level in the middle is no shift.
        let other = "step  _/‾250‾\\_350_/‾560‾\\_650_\npos  0 |250 1 |550 2\n";
        assert!(differences(before, other).len() > 1);
    }

    #[test]
    fn what_is_no_drawing_is_told_and_does_no_harm() {
        for text in
            ["x", "x  _/", "x  _/‾", "x  _/‾1_", "x  1 |", "x  1 |2", "x  _?", "\u{203e}", "  "]
        {
            drop(differences(text, "x  _\n"));
        }
        let said = differences("x  _/‾a‾\n", "x  _\n");
        assert_eq!(said.len(), 2, "{said:?}");
    }
}
