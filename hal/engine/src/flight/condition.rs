//! What makes the flight recorder keep what it has: conditions on one value each.

use crate::{Error, watch_error::WatchError};
use core::cmp::Ordering;
use hal_protocol::{Type, Value};

/// What is an event in every machine: how a bit's name ends, what it becomes, and what that is.
pub(super) const USUAL: &[(&str, bool, &str)] = &[
    (".f-errored", true, "following error"),
    (".amp-fault-in", true, "amplifier fault"),
    (".emc-enable-in", false, "e-stop"),
    ("motion.enable", false, "e-stop"),
];

/// Which orders of two values it holds for.
type Relation = fn(Ordering) -> bool;

/// The relations, those first that begin with another one.
const RELATIONS: &[(&str, Relation)] = &[
    ("<=", Ordering::is_le),
    (">=", Ordering::is_ge),
    ("==", Ordering::is_eq),
    ("!=", Ordering::is_ne),
    ("<", Ordering::is_lt),
    (">", Ordering::is_gt),
    ("=", Ordering::is_eq),
];

/// What a value is compared with.
#[derive(Clone, Copy, Debug)]
enum Test {
    /// A bit is this.
    Bit(bool),
    /// A number is in this relation to that one.
    Number(Relation, Value),
}

/// Becomes true: an event.
#[derive(Clone, Debug)]
pub(super) struct Condition {
    /// The pin or signal.
    pub(super) name: String,
    /// Why something was kept.
    pub(super) why: String,
    test: Test,
    /// Whether it was true, if that is known.
    was: Option<bool>,
}

impl Condition {
    /// Reads `PIN`, `!PIN` or `PIN RELATION VALUE`; `type_of` knows what there is.
    pub(super) fn parse(
        text: &str,
        type_of: impl Fn(&str) -> Result<Type, Error>,
    ) -> Result<Self, Error> {
        let bad = |why: &'static str| WatchError::Condition { text: text.trim().into(), why };
        let relation = RELATIONS.iter().filter_map(|(sign, holds)| {
            let at = text.find(sign)?;
            // `!PIN` has no relation.
            (at > 0).then_some((at, *sign, *holds))
        });
        let relation = relation.min_by_key(|(at, sign, _)| (*at, core::cmp::Reverse(sign.len())));
        let (name, test) = if let Some((at, sign, holds)) = relation {
            let (name, value) = text.split_at(at);
            let value = value.strip_prefix(sign).unwrap_or_default().trim();
            let name = name.trim();
            let ty = type_of(name)?;
            if ty == Type::Bit && !matches!(sign, "=" | "==" | "!=") {
                return Err(bad("a bit is neither more nor less than another").into());
            }
            let value =
                Value::parse(ty, value).map_err(|_| bad("its value is none of the pin's"))?;
            (name, Test::Number(holds, value))
        } else {
            let text = text.trim();
            let (name, wanted) = match text.strip_prefix('!') {
                Some(name) => (name.trim(), false),
                None => (text, true),
            };
            if type_of(name)? != Type::Bit {
                return Err(bad("it is compared with nothing, and is no bit").into());
            }
            (name, Test::Bit(wanted))
        };
        Ok(Self { name: name.to_owned(), why: text.trim().to_owned(), test, was: None })
    }

    /// One that every machine has, if this is such a name.
    pub(super) fn usual(name: &str, ty: Type) -> Option<Self> {
        let is_it = |(end, _, _): &&(&str, bool, &str)| name.ends_with(end);
        let (_, wanted, what) = USUAL.iter().find(is_it).filter(|_| ty == Type::Bit)?;
        let (name, why) = (name.to_owned(), format!("{what}: {name}"));
        Some(Self { name, why, test: Test::Bit(*wanted), was: None })
    }

    /// The value is this now: whether the condition has become true.
    pub(super) fn sees(&mut self, ty: Type, bits: u64) -> bool {
        let holds = match (self.test, Value::from_bits(ty, bits)) {
            (Test::Bit(wanted), Value::Bit(is)) => is == wanted,
            (Test::Number(holds, wanted), is) => order(is, wanted).is_some_and(holds),
            (Test::Bit(_), _) => false,
        };
        self.was.replace(holds) == Some(false) && holds
    }
}

/// How two values of one type are ordered; NaN is in no order.
fn order(a: Value, b: Value) -> Option<Ordering> {
    match (a, b) {
        (Value::Bit(a), Value::Bit(b)) => Some(a.cmp(&b)),
        (Value::Float(a), Value::Float(b)) => a.partial_cmp(&b),
        (Value::S32(a), Value::S32(b)) => Some(a.cmp(&b)),
        (Value::U32(a), Value::U32(b)) => Some(a.cmp(&b)),
        (Value::S64(a), Value::S64(b)) => Some(a.cmp(&b)),
        (Value::U64(a), Value::U64(b)) => Some(a.cmp(&b)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::Condition;
    use hal_protocol::{Type, Value};

    fn of(ty: Type, text: &str) -> Result<Condition, String> {
        Condition::parse(text, |_| Ok(ty)).map_err(|e| e.to_string())
    }

    #[test]
    fn they_become_true() {
        for (ty, text, values, want) in [
            (Type::Bit, "p", "1 0 1 1 0", "  !  "),
            (Type::Bit, " ! p ", "1 0 1 1 0", " !  !"),
            (Type::Bit, "p != 1", "1 0 1 1 0", " !  !"),
            (Type::Float, "p>2.5", "2.5 2.6 nan 2.6 9", " ! ! "),
            (Type::Float, "p <= -1", "-2 0 -1 -2 nan", "  !  "),
            (Type::S32, "p = 0x10", "1 16 16 17 16", " !  !"),
            (Type::U64, "p>=18446744073709551615", "0 18446744073709551615", " !"),
            (Type::S64, "p < -5", "-5 -6 7", " ! "),
        ] {
            let mut c = of(ty, text).unwrap();
            assert_eq!(c.name, "p");
            let values = values.split(' ').map(|v| Value::parse(ty, v).unwrap());
            let seen: String =
                values.map(|v| if c.sees(ty, v.bits()) { '!' } else { ' ' }).collect();
            assert_eq!(seen, want, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_says_why() {
        for (ty, text, want) in [
            (
                Type::Bit,
                "p > 0",
                "'p > 0' is no condition: a bit is neither more nor less than another",
            ),
            (Type::Float, "!p", "'!p' is no condition: it is compared with nothing, and is no bit"),
            (Type::S32, "p > 1.5", "'p > 1.5' is no condition: its value is none of the pin's"),
            (Type::Float, "p > ", "'p >' is no condition: its value is none of the pin's"),
        ] {
            assert_eq!(of(ty, text).unwrap_err(), want);
        }
    }
}
