//! Conditions over two successive samples.

use super::condition::{Compare, Condition, ConditionError, Said, Spot, Tree};
use crate::Trace;
use core::cmp::Ordering;
use hal_protocol::{Type, Value};

/// A checked condition that evaluates a record and the previous one.
#[derive(Clone, Debug)]
pub struct When {
    text: String,
    node: Node,
    /// Number of values that a record must have.
    width: usize,
}

#[derive(Clone, Debug)]
enum Node {
    Any(Vec<Node>),
    All(Vec<Node>),
    Not(Box<Node>),
    Leaf { channel: usize, ty: Type, test: Test },
}

#[derive(Clone, Copy, Debug)]
enum Test {
    True,
    Rises,
    Falls,
    Changes,
    RisesThrough(Value),
    FallsThrough(Value),
    Crosses(Value),
    Compare(Compare, Value),
    In(Value, Value),
    Outside(Value, Value),
}

impl When {
    pub(super) fn bind(
        condition: &Condition,
        channels: &[(String, Type)],
    ) -> Result<Self, ConditionError> {
        let node = bind(condition, &condition.tree, channels)?;
        Ok(Self { text: condition.text.clone(), node, width: channels.len() })
    }

    /// Returns the text of the condition.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns whether the condition holds at a record. The record must have a value for each
    /// channel.
    #[must_use]
    pub fn holds(&self, before: Option<&[u64]>, now: &[u64]) -> bool {
        let before = before.filter(|b| b.len() >= self.width);
        now.len() >= self.width && self.node.holds(before, now)
    }

    /// Returns the first sample of a trace, from `from` on, at which the condition holds. The
    /// condition must be bound to the trace's own channels. Samples with an unknown value are
    /// skipped.
    #[must_use]
    pub fn first(&self, trace: &Trace, from: usize) -> Option<usize> {
        let record = |sample: usize| {
            let bits = |n| trace.value(n, sample).map(|v| v.bits());
            (0..self.width).map(bits).collect::<Option<Vec<u64>>>()
        };
        let mut before = from.checked_sub(1).and_then(record);
        for sample in from..trace.len() {
            let now = record(sample);
            if let Some(now) = &now
                && self.holds(before.as_deref(), now)
            {
                return Some(sample);
            }
            before = now;
        }
        None
    }
}

fn bind(
    condition: &Condition,
    tree: &Tree,
    channels: &[(String, Type)],
) -> Result<Node, ConditionError> {
    let all = |list: &[Tree]| -> Result<Vec<Node>, ConditionError> {
        list.iter().map(|t| bind(condition, t, channels)).collect()
    };
    Ok(match tree {
        Tree::Any(list) => Node::Any(all(list)?),
        Tree::All(list) => Node::All(all(list)?),
        Tree::Not(tree) => Node::Not(Box::new(bind(condition, tree, channels)?)),
        Tree::Leaf(name, said) => {
            let channel = channels.iter().position(|(n, _)| *n == name.text);
            let found = channel.and_then(|n| Some((n, channels.get(n)?.1)));
            let Some((channel, ty)) = found else {
                let why = format!("there is no channel '{}'", name.text);
                return Err(condition.wrong(name, why));
            };
            Node::Leaf { channel, ty, test: test(condition, name, ty, said)? }
        }
    })
}

fn test(condition: &Condition, name: &Spot, ty: Type, said: &Said) -> Result<Test, ConditionError> {
    let refuse = |why: String| Err(condition.wrong(name, why));
    let (shown, of) = (&name.text, ty.name());
    if ty == Type::Port {
        return refuse(format!("'{shown}' is port: a queue of bytes triggers nothing"));
    }
    let value = |spot: &Spot| condition.value(ty, spot);
    let order = |low: &Spot, high: &Spot| {
        let (a, b) = (value(low)?, value(high)?);
        if compare(&a, &b).is_none_or(Ordering::is_gt) {
            let why = format!("the range from {} to {} is empty", low.text, high.text);
            return Err(condition.wrong(low, why));
        }
        Ok((a, b))
    };
    let is_bit = ty == Type::Bit;
    Ok(match said {
        Said::True | Said::Rises | Said::Falls | Said::Toggles if !is_bit => {
            let instead = match said {
                Said::True => "compare it, as in '> 0'",
                Said::Rises => "of a number is said 'rises through 5'",
                Said::Falls => "of a number is said 'falls through 5'",
                _ => "of a number is said 'changes', or 'crosses 5'",
            };
            return refuse(format!("'{shown}' is {of} and no bit: {instead}"));
        }
        Said::RisesThrough(_) | Said::FallsThrough(_) | Said::Crosses(_) if is_bit => {
            return refuse(format!("'{shown}' is bit: say 'rises', 'falls' or 'toggles'"));
        }
        Said::In(..) | Said::Outside(..) if is_bit => {
            return refuse(format!("'{shown}' is bit and has no range"));
        }
        Said::Compare(c, _) if is_bit && !matches!(c, Compare::Equal | Compare::Unequal) => {
            return refuse(format!("'{shown}' is bit: compare it with = or !="));
        }
        Said::True => Test::True,
        Said::Rises => Test::Rises,
        Said::Falls => Test::Falls,
        Said::Toggles | Said::Changes => Test::Changes,
        Said::RisesThrough(v) => Test::RisesThrough(value(v)?),
        Said::FallsThrough(v) => Test::FallsThrough(value(v)?),
        Said::Crosses(v) => Test::Crosses(value(v)?),
        Said::Compare(c, v) => Test::Compare(*c, value(v)?),
        Said::In(low, high) => {
            let (low, high) = order(low, high)?;
            Test::In(low, high)
        }
        Said::Outside(low, high) => {
            let (low, high) = order(low, high)?;
            Test::Outside(low, high)
        }
    })
}

/// Compares two values of one type. Returns `None` if one is NaN.
fn compare(a: &Value, b: &Value) -> Option<Ordering> {
    match (a, b) {
        (Value::Float(a), Value::Float(b)) => a.partial_cmp(b),
        (Value::S32(a), Value::S32(b)) => Some(a.cmp(b)),
        (Value::S64(a), Value::S64(b)) => Some(a.cmp(b)),
        _ => Some(a.bits().cmp(&b.bits())),
    }
}

impl Node {
    fn holds(&self, before: Option<&[u64]>, now: &[u64]) -> bool {
        match self {
            Self::Any(list) => list.iter().any(|n| n.holds(before, now)),
            Self::All(list) => list.iter().all(|n| n.holds(before, now)),
            Self::Not(node) => !node.holds(before, now),
            Self::Leaf { channel, ty, test } => {
                let value = |bits: &u64| Value::from_bits(*ty, *bits);
                let Some(now) = now.get(*channel).map(value) else { return false };
                test.holds(before.and_then(|b| b.get(*channel)).map(value), now)
            }
        }
    }
}

impl Test {
    fn holds(&self, before: Option<Value>, now: Value) -> bool {
        let is_true = |v: Value| v.bits() != 0;
        // A crossing needs a value strictly on one side before, and at or past the limit now. NaN
        // never crosses.
        let rises = |b: Value, v: &Value| {
            compare(&b, v).is_some_and(Ordering::is_lt)
                && compare(&now, v).is_some_and(Ordering::is_ge)
        };
        let falls = |b: Value, v: &Value| {
            compare(&b, v).is_some_and(Ordering::is_gt)
                && compare(&now, v).is_some_and(Ordering::is_le)
        };
        match self {
            Self::True => is_true(now),
            Self::Rises => is_true(now) && before.is_some_and(|b| !is_true(b)),
            Self::Falls => !is_true(now) && before.is_some_and(is_true),
            Self::Changes => before.is_some_and(|b| differs(b, now)),
            Self::RisesThrough(v) => before.is_some_and(|b| rises(b, v)),
            Self::FallsThrough(v) => before.is_some_and(|b| falls(b, v)),
            Self::Crosses(v) => before.is_some_and(|b| rises(b, v) || falls(b, v)),
            Self::Compare(c, v) => {
                let order = compare(&now, v);
                match c {
                    Compare::Less => order.is_some_and(Ordering::is_lt),
                    Compare::LessOrEqual => order.is_some_and(Ordering::is_le),
                    Compare::Greater => order.is_some_and(Ordering::is_gt),
                    Compare::GreaterOrEqual => order.is_some_and(Ordering::is_ge),
                    Compare::Equal => order == Some(Ordering::Equal),
                    Compare::Unequal => order != Some(Ordering::Equal),
                }
            }
            Self::In(low, high) => within(low, &now, high),
            Self::Outside(low, high) => {
                let is_below = compare(&now, low).is_some_and(Ordering::is_lt);
                is_below || compare(&now, high).is_some_and(Ordering::is_gt)
            }
        }
    }
}

fn within(low: &Value, now: &Value, high: &Value) -> bool {
    compare(low, now).is_some_and(Ordering::is_le)
        && compare(now, high).is_some_and(Ordering::is_le)
}

/// Returns whether two values differ. All NaNs are equal.
fn differs(a: Value, b: Value) -> bool {
    match (a, b) {
        (Value::Float(a), Value::Float(b)) => {
            a.to_bits() != b.to_bits() && !(a.is_nan() && b.is_nan())
        }
        _ => a.bits() != b.bits(),
    }
}
