//! Grouping of similar pins, so that sixteen inputs are one entry.

use super::{Entry, Function};
use core::cmp::Ordering;
use hal_protocol::{FunctInfo, ItemInfo};

/// Maximum number of different initial values that are listed.
const DEFAULTS: usize = 8;

/// A pin or parameter with the loads that make it.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) item: ItemInfo,
    /// Numbers of the loads.
    pub(super) loads: Vec<usize>,
}

/// An entry under construction: its common properties, and the numbers in the names of the first
/// and last pin.
struct Group {
    shape: Vec<String>,
    first: Vec<u64>,
    last: Vec<u64>,
    doc: String,
    loads: Vec<usize>,
    defaults: Vec<String>,
    entry: Entry,
}

/// Groups similar items at the position of the first of them. `args` are the arguments of each
/// load.
pub(super) fn gathered(mut found: Vec<Found>, args: &[Vec<String>]) -> Vec<Entry> {
    found.sort_by(|a, b| by_name(&a.item.name, &b.item.name));
    let mut groups: Vec<Group> = Vec::new();
    for Found { item, loads } in found {
        let (shape, numbers) = parts(&item.name);
        let value = item.value.to_string();
        let like = groups.iter_mut().find(|g| {
            let told = g.doc == item.doc
                || general(&g.doc, &g.last, &numbers) == general(&item.doc, &numbers, &g.last);
            let kind = (g.entry.ty, g.entry.direction) == (item.value.ty(), item.direction);
            kind && told
                && g.shape == shape
                && g.loads == loads
                && is_next(&g.first, &g.last, &numbers)
        });
        if let Some(group) = like {
            if group.doc != item.doc {
                group.entry.doc = general(&item.doc, &numbers, &group.last);
            }
            group.entry.last = Some(item.name);
            group.doc = item.doc;
            group.last = numbers;
            group.defaults.push(value);
            continue;
        }
        let entry = Entry {
            first: item.name,
            last: None,
            ty: item.value.ty(),
            direction: item.direction,
            default: String::new(),
            with: with(&loads, args),
            doc: item.doc.clone(),
        };
        groups.push(Group {
            shape,
            first: numbers.clone(),
            last: numbers,
            doc: item.doc,
            loads,
            defaults: vec![value],
            entry,
        });
    }
    groups.into_iter().map(Group::entry).collect()
}

/// Describes the arguments with which an item exists. Returns an empty text if all loads make it.
fn with(loads: &[usize], args: &[Vec<String>]) -> String {
    let is_common = |word: &String| args.iter().all(|words| words.contains(word));
    let own: Vec<Vec<&String>> =
        args.iter().map(|words| words.iter().filter(|w| !is_common(w)).collect()).collect();
    let (has, lacks): (Vec<usize>, Vec<usize>) = (0..own.len()).partition(|i| loads.contains(i));
    let words = |i: usize| own.get(i).map_or(&[][..], Vec::as_slice);
    let in_words = |list: &[&String]| {
        let list: Vec<&str> = list.iter().map(|w| w.as_str()).collect();
        if list.is_empty() { "nothing more".to_owned() } else { format!("`{}`", list.join(" ")) }
    };
    // Returns whether load `a` has all arguments of load `b`.
    let is_more = |a: usize, b: usize| a != b && words(b).iter().all(|w| words(a).contains(w));
    match lacks.as_slice() {
        [] => return String::new(),
        [one] => {
            if let Some(base) = has.iter().find(|i| is_more(*one, **i)) {
                let more = words(*one).iter().filter(|w| !words(*base).contains(w));
                return format!("without {}", in_words(&more.copied().collect::<Vec<_>>()));
            }
        }
        _ => {}
    }
    let least = has.iter().filter(|i| !has.iter().any(|other| is_more(**i, *other)));
    let list: Vec<String> = least.map(|i| in_words(words(*i))).collect();
    format!("with {}", list.join(" or "))
}

/// Groups functions whose names differ only by a number.
pub(super) fn functions(mut list: Vec<FunctInfo>) -> Vec<Function> {
    list.sort_by(|a, b| by_name(&a.name, &b.name));
    let mut out: Vec<Function> = Vec::new();
    for f in list {
        let (shape, numbers) = parts(&f.name);
        let like = out.iter_mut().find(|known| {
            let (first_shape, first) = parts(&known.first);
            let last = known.last.as_ref().map_or(first.clone(), |last| parts(last).1);
            let same = shape == first_shape && (known.fast, &known.doc) == (f.fast, &f.doc);
            same && is_next(&first, &last, &numbers)
        });
        match like {
            Some(known) => known.last = Some(f.name),
            None => out.push(Function { first: f.name, last: None, fast: f.fast, doc: f.doc }),
        }
    }
    out
}

/// Returns whether `numbers` follows `last`: one number is greater by 1, and the numbers after it
/// are unchanged or start again.
fn is_next(first: &[u64], last: &[u64], numbers: &[u64]) -> bool {
    let Some(k) = last.iter().zip(numbers).position(|(a, b)| a != b) else { return false };
    let behind = numbers.get(k + 1..);
    last.get(k).map(|n| n + 1) == numbers.get(k).copied()
        && (last.get(k + 1..) == behind || first.get(k + 1..) == behind)
}

impl Group {
    fn entry(mut self) -> Entry {
        let first = self.defaults.first().cloned().unwrap_or_default();
        self.entry.default = if self.defaults.iter().all(|d| *d == first) {
            first
        } else if self.defaults.len() <= DEFAULTS {
            self.defaults.join(", ")
        } else {
            "each another".to_owned()
        };
        self.entry
    }
}

/// Splits a name into its text parts and its numbers.
fn parts(name: &str) -> (Vec<String>, Vec<u64>) {
    let mut shape = vec![String::new()];
    let mut numbers: Vec<u64> = Vec::new();
    let mut was_digit = false;
    for c in name.chars() {
        match (c.to_digit(10), numbers.last_mut(), shape.last_mut()) {
            (Some(digit), Some(n), _) if was_digit => {
                *n = n.saturating_mul(10).saturating_add(u64::from(digit));
            }
            (Some(digit), ..) => {
                numbers.push(u64::from(digit));
                shape.push(String::new());
            }
            (None, _, Some(part)) => part.push(c),
            (None, _, None) => {}
        }
        was_digit = c.is_ascii_digit();
    }
    (shape, numbers)
}

/// Replaces the number that differs between two names by N in a text.
fn general(doc: &str, mine: &[u64], other: &[u64]) -> String {
    let mut differ = mine.iter().zip(other).filter(|(a, b)| a != b);
    let (Some((number, _)), None) = (differ.next(), differ.next()) else { return doc.to_owned() };
    let mut out = String::new();
    let mut digits = String::new();
    for c in doc.chars().chain(['\0']) {
        if c.is_ascii_digit() {
            digits.push(c);
            continue;
        }
        if digits.parse() == Ok(*number) {
            out.push('N');
        } else {
            out.push_str(&digits);
        }
        digits.clear();
        if c != '\0' {
            out.push(c);
        }
    }
    out
}

/// Compares names so that 2 comes before 10.
fn by_name(a: &str, b: &str) -> Ordering {
    let ((shape, numbers), (others, other_numbers)) = (parts(a), parts(b));
    for i in 0..shape.len().min(others.len()) {
        let order =
            shape.get(i).cmp(&others.get(i)).then(numbers.get(i).cmp(&other_numbers.get(i)));
        if order.is_ne() {
            return order;
        }
    }
    a.cmp(b)
}

#[cfg(test)]
mod tests {
    use super::{Found, by_name, functions, gathered};
    use hal_protocol::{Direction, FunctInfo, ItemInfo, Value};

    fn found(name: &str, value: Value, doc: &str, loads: &[usize]) -> Found {
        let item = ItemInfo {
            owner: 1,
            owner_name: "x".to_owned(),
            direction: Direction::In,
            value,
            name: name.to_owned(),
            original: None,
            signal: None,
            doc: doc.to_owned(),
        };
        Found { item, loads: loads.to_vec() }
    }

    fn shown(items: &[(&str, Value, &str, &[usize])], args: &[&str]) -> Vec<String> {
        let items = items.iter().map(|(n, v, d, l)| found(n, *v, d, l)).collect();
        let words = |args: &&str| args.split_whitespace().map(str::to_owned).collect();
        let args: Vec<Vec<String>> = args.iter().map(words).collect();
        let line = |e: super::Entry| {
            let last = e.last.map(|l| format!(" to {l}")).unwrap_or_default();
            format!("{}{last} = {} | {} | {}", e.first, e.default, e.doc, e.with)
        };
        gathered(items, &args).into_iter().map(line).collect()
    }

    #[test]
    fn like_ones_are_one_entry() {
        let (on, off) = (Value::Bit(true), Value::Bit(false));
        let all: &[usize] = &[0];
        let items = [
            ("x.0.in-00", on, "Input.", all),
            ("x.0.in-01", on, "Input.", all),
            ("x.0.in-03", on, "Input.", all),
            ("x.0.out", Value::S32(0), "Output.", all),
            ("x.0.s32-0", Value::S32(5), "Number.", all),
            ("x.0.s32-1", Value::S32(6), "Number.", all),
            ("x.0.pin-09", off, "Pin 9 of 9.", all),
            ("x.0.pin-10", off, "Pin 10 of 9.", all),
            ("x.0.r0c0", off, "Key.", all),
            ("x.0.r0c1", off, "Key.", all),
            ("x.0.r1c0", off, "Key.", all),
            ("x.0.r1c1", off, "Key.", all),
        ];
        let wanted = [
            "x.0.in-00 to x.0.in-01 = TRUE | Input. | ",
            "x.0.in-03 = TRUE | Input. | ",
            "x.0.out = 0 | Output. | ",
            "x.0.pin-09 = FALSE | Pin 9 of 9. | ",
            "x.0.pin-10 = FALSE | Pin 10 of 9. | ",
            "x.0.r0c0 to x.0.r1c1 = FALSE | Key. | ",
            "x.0.s32-0 to x.0.s32-1 = 5, 6 | Number. | ",
        ];
        assert_eq!(shown(&items, &[""]), wanted);
    }

    #[test]
    fn what_only_the_number_tells_apart_is_told_once() {
        let items = [
            ("p.1-out", Value::S32(0), "Pin 1, inverted by p.01-not.", &[0_usize][..]),
            ("p.2-out", Value::S32(0), "Pin 2, inverted by p.02-not.", &[0]),
            ("p.3-out", Value::S32(0), "Pin 3, inverted by p.03-not.", &[0]),
        ];
        assert_eq!(
            shown(&items, &[""]),
            ["p.1-out to p.3-out = 0 | Pin N, inverted by p.N-not. | "]
        );
    }

    #[test]
    fn what_not_every_load_makes_says_which_does() {
        let items = [
            ("x.0.a", Value::S32(0), "A.", &[0_usize, 1, 2, 3][..]),
            ("x.0.b", Value::S32(0), "B.", &[1]),
            ("x.0.c", Value::S32(0), "C.", &[0, 1, 2]),
            ("x.0.d", Value::S32(0), "D.", &[0, 3]),
            ("x.0.e", Value::S32(0), "E.", &[3]),
            ("x.0.f", Value::S32(0), "F.", &[1, 2]),
        ];
        let wanted = [
            "x.0.a = 0 | A. | ",
            "x.0.b = 0 | B. | with `type=1`",
            "x.0.c = 0 | C. | without `fast=1`",
            "x.0.d = 0 | D. | with `type=0`",
            "x.0.e = 0 | E. | with `type=0 fast=1`",
            "x.0.f = 0 | F. | with `type=1` or `type=2`",
        ];
        let args = ["n=1 type=0", "n=1 type=1", "n=1 type=2", "n=1 type=0 fast=1"];
        assert_eq!(shown(&items, &args), wanted);
        let items =
            [("x.0.a", Value::S32(0), "A.", &[1_usize][..]), ("b", Value::S32(0), "B.", &[0])];
        let wanted = ["b = 0 | B. | without `debug=1`", "x.0.a = 0 | A. | with `debug=1`"];
        assert_eq!(shown(&items, &["n=1", "n=1 debug=1"]), wanted);
    }

    #[test]
    fn functions_are_told_once() {
        let named = |name: &str| FunctInfo {
            owner: 1,
            owner_name: "x".to_owned(),
            code: 0,
            arg: 0,
            users: 0,
            name: name.to_owned(),
            foreign: false,
            fp: false,
            doc: "It.".to_owned(),
            fast: false,
        };
        let list = functions(["x.10", "x.9", "x.11", "x.read"].map(named).into());
        let shown: Vec<_> = list.iter().map(|f| (f.first.as_str(), f.last.as_deref())).collect();
        assert_eq!(shown, [("x.9", Some("x.11")), ("x.read", None)]);
    }

    #[test]
    fn two_is_before_ten() {
        let mut names = ["x.10", "x.2", "x.2.b", "x.a", "x"];
        names.sort_by(|a, b| by_name(a, b));
        assert_eq!(names, ["x", "x.2", "x.2.b", "x.10", "x.a"]);
    }
}
