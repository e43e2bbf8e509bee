//! Conditions that make the flight recorder keep its contents; they have the syntax of triggers.

use super::history::History;
use hal_protocol::Type;
use hal_trace::trigger::{Condition as Read, ConditionError, When};

/// Events in every machine: the end of a bit's name, the value that it changes to, and the meaning.
const DEFAULT: &[(&str, bool, &str)] = &[
    (".f-errored", true, "following error"),
    (".amp-fault-in", true, "amplifier fault"),
    (".emc-enable-in", false, "e-stop"),
    ("motion.enable", false, "e-stop"),
];

/// Condition; an event occurs when it becomes true.
#[derive(Clone, Debug)]
pub(super) struct Condition {
    read: Read,
    /// Reason to report for the event.
    pub(super) why: String,
    /// Types of its values when it was checked; empty while one of them does not exist.
    types: Vec<Type>,
    when: Option<When>,
    /// Columns of its values.
    pub(super) columns: Vec<u32>,
    /// Values at the previous evaluated sample, and now; empty if unknown.
    before: Vec<u64>,
    now: Vec<u64>,
    /// True if one of its values has changed since then.
    pub(super) stirred: bool,
}

impl Condition {
    /// Creates a condition from a parsed trigger.
    pub(super) fn new(read: Read) -> Self {
        let why = read.text().to_owned();
        let (types, columns, before, now) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { read, why, types, when: None, columns, before, now, stirred: false }
    }

    /// Parses a text and checks it against the existing types.
    pub(super) fn check<E: From<ConditionError>>(
        text: &str,
        type_of: impl Fn(&str) -> Result<Type, E>,
    ) -> Result<Self, E> {
        let read = Read::parse(text)?;
        let named = read.names().into_iter().map(|n| Ok((n.to_owned(), type_of(n)?)));
        let named: Result<Vec<_>, E> = named.collect();
        read.bind(&named?)?;
        Ok(Self::new(read))
    }

    /// Creates the condition that every machine has for a bit with such a name, if there is one.
    pub(super) fn usual(name: &str, ty: Type) -> Option<Self> {
        let is_it = |(end, _, _): &&(&str, bool, &str)| name.ends_with(end);
        let (_, wanted, what) = DEFAULT.iter().find(is_it).filter(|_| ty == Type::Bit)?;
        let read = Read::parse(&format!("{}'{name}'", if *wanted { "" } else { "not " })).ok()?;
        Some(Self { why: format!("{what}: {name}"), ..Self::new(read) })
    }

    /// Returns whether it refers to this name only.
    pub(super) fn is_of(&self, name: &str) -> bool {
        self.read.names() == [name]
    }

    /// Returns whether it refers to this name.
    pub(super) fn names(&self, name: &str) -> bool {
        self.read.names().contains(&name)
    }

    /// Finds the columns of its values. Returns whether they have changed.
    pub(super) fn find(&mut self, history: &History) -> bool {
        let names = self.read.names();
        let found = names.iter().map(|n| history.column(n.strip_prefix("sig:").unwrap_or(n)));
        let found: Vec<(u32, Type)> = found.collect::<Option<_>>().unwrap_or_default();
        let (columns, types): (Vec<u32>, Vec<Type>) = found.into_iter().unzip();
        if types != self.types {
            let channels = names.iter().map(|n| (*n).to_owned()).zip(types.iter().copied());
            // With types other than those that it was checked against, it may be invalid.
            self.when = self.read.bind(&channels.collect::<Vec<_>>()).ok();
            self.types = types;
            self.before.clear();
        }
        let others = columns != self.columns;
        self.columns = columns;
        others
    }

    /// Evaluates a complete sample. Returns whether the condition has become true with it.
    pub(super) fn sees(&mut self, history: &History) -> bool {
        self.stirred = false;
        self.now.clear();
        self.now.extend(self.columns.iter().filter_map(|c| history.now(*c)));
        if self.now.len() < self.columns.len() {
            self.now.clear();
        }
        let (before, now) = (&self.before, &self.now);
        let holds = |now: &Vec<u64>| {
            self.when.as_ref().is_some_and(|w| !before.is_empty() && w.holds(Some(before), now))
        };
        // Samples in between were like the previous one, because nothing changed.
        let event = !holds(before) && holds(now);
        core::mem::swap(&mut self.before, &mut self.now);
        event
    }
}

#[cfg(test)]
mod tests {
    use super::{Condition, History};
    use crate::observe::flight::history::Group;
    use hal_protocol::{Type, Value};
    use hal_trace::trigger::ConditionError;

    /// Returns the samples at which a condition becomes true (`!`), for values of `p` and of the
    /// bit `q`.
    fn seen(ty: Type, text: &str, p: &str, q: &str) -> String {
        let types = |name: &str| Ok::<_, ConditionError>(if name == "p" { ty } else { Type::Bit });
        let mut c = Condition::check(text, types).unwrap();
        let mut history = History::new(1 << 12, 0);
        let group = |name: &str, ty| Group { ty, names: vec![name.to_owned()], before: None };
        let columns = history.regroup(0, &[group("p", ty), group("q", Type::Bit)]);
        assert!(c.find(&history));
        let samples = p.split_whitespace().zip(q.split_whitespace());
        let look = |(at, (p, q)): (usize, (&str, &str))| {
            let mut stirred = false;
            for (column, ty, text) in [(columns[0], ty, p), (columns[1], Type::Bit, q)] {
                let bits = Value::parse(ty, text).unwrap().bits();
                let of_it = c.columns.contains(&column);
                stirred |= history.push(i64::try_from(at).unwrap(), column, bits) && of_it;
            }
            if stirred && c.sees(&history) { '!' } else { '.' }
        };
        samples.enumerate().map(look).collect()
    }

    #[test]
    fn they_become_true() {
        let same = "0 0 0 0 0";
        for (ty, text, values, want) in [
            (Type::Bit, "p", "1 0 1 1 0", "..!.."),
            (Type::Bit, " ! p ", "1 0 1 1 0", ".!..!"),
            (Type::Bit, "p != 1", "1 0 1 1 0", ".!..!"),
            (Type::Bit, "p toggles", "1 0 1 1 0", ".!!.!"),
            (Type::Bit, "p rises", "1 0 1 1 0", "..!.."),
            (Type::Float, "p>2.5", "2.5 2.6 nan 2.6 9", ".!.!."),
            (Type::Float, "p <= -1", "-2 0 -1 -2 nan", "..!.."),
            (Type::Float, "p in 1..2", "0 1 2 3 1", ".!..!"),
            (Type::Float, "p crosses 2", "0 1 2 3 1", "..!.!"),
            (Type::S32, "p = 0x10", "1 16 16 17 16", ".!..!"),
            (Type::U64, "p>=18446744073709551615", "0 18446744073709551615", ".!"),
            (Type::S64, "p < -5", "-5 -6 7", ".!."),
        ] {
            assert_eq!(seen(ty, text, values, same), want, "{text}");
        }
        for (text, p, q, want) in [
            ("p > 5 and not q", "0 6 6 6 0 9", "0 1 0 1 1 0", "..!..!"),
            // Both change in one sample, so no mixture of old and new values counts.
            ("p > 5 and not q", "0 6 0 6", "0 1 0 1", "...."),
            ("p > 5 and q rises", "0 6 6 0 6", "0 1 0 1 0", ".!..."),
            ("p > 5 or q", "0 6 6 0 0 6", "0 0 1 1 0 0", ".!...!"),
        ] {
            assert_eq!(seen(Type::S32, text, p, q), want, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_says_where_and_why() {
        for (ty, text, want) in [
            (Type::Bit, "p > 0", "trigger: 'p' is bit: compare it with = or !=\n    p > 0\n    ^"),
            (
                Type::S32,
                "p > 1.5",
                "trigger: '1.5' is not of type s32: expected an integer from -2147483648 to 2147483647\n    p > 1.5\n        ^^^",
            ),
            (Type::Float, "p > ", "trigger: expected a value\n    p > \n       ^"),
        ] {
            let said = Condition::check(text, |_| Ok::<_, ConditionError>(ty)).unwrap_err();
            assert_eq!(said.to_string(), want);
        }
    }
}
