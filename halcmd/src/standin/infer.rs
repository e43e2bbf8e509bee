//! Pins and functions of what is not there, from the lines that name them.
//!
//! The other ends of a signal give the type and the direction of a pin; where all ends are unknown, arrows, values and
//! the ends of names do, and the pin is listed as doubtful.

use super::{
    names::{PAIRS, outwards, type_by_names, type_named, type_of},
    wires::Wires,
};
use hal_protocol::{At, Direction, Type};
use std::collections::{BTreeMap, BTreeSet};

/// Ends of the names of pins that a function has by itself.
const TIMES: [&str; 3] = [".time", ".tmax", ".tmax-increased"];

/// Beginning of the inputs that get the speed of a spindle, in turns per second; its number follows.
pub(super) const RPS: &str = "standin.sim.rps-";

/// Result for a whole machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Inferred {
    pub(super) pins: Vec<Pin>,
    pub(super) functs: Vec<String>,
}

/// A pin of a stand-in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pin {
    pub(super) name: String,
    ty: Type,
    pub(super) dir: Direction,
    /// Function that writes it, as an index into the list of functions.
    funct: Option<usize>,
    rule: Option<Rule>,
    /// Nothing but its name tells what it is.
    doubtful: bool,
}

/// Rule for the value of an output.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Rule {
    Copy(String),
    Sum(String),
    Index(Option<String>),
}

impl Pin {
    /// Returns the pin for people.
    pub(super) fn shown(&self) -> String {
        let dir = match self.dir {
            Direction::Out => "OUT",
            Direction::Io => "I/O",
            _ => "IN",
        };
        format!("{} {} {dir}", self.name, self.ty.name())
    }

    /// Returns whether it is an output whose value is that of its simulated input.
    pub(super) fn is_plain_bit(&self) -> bool {
        self.dir == Direction::Out && self.ty == Type::Bit && self.rule.is_none()
    }

    /// Returns whether the value follows an input.
    pub(super) const fn has_rule(&self) -> bool {
        self.rule.is_some()
    }

    fn argument(&self) -> String {
        let ty = match self.ty {
            Type::Bit => "bit",
            Type::S32 => "s32",
            Type::U32 => "u32",
            Type::S64 => "s64",
            Type::U64 => "u64",
            Type::Float | Type::Port => "float",
        };
        let dir = match self.dir {
            Direction::Out => "out",
            Direction::Io => "io",
            _ => "in",
        };
        let funct = self.funct.map(|n| n.to_string()).unwrap_or_default();
        let (rule, other) = match &self.rule {
            Some(Rule::Copy(other)) => ("copy", other.as_str()),
            Some(Rule::Sum(other)) => ("sum", other.as_str()),
            Some(Rule::Index(other)) => ("index", other.as_deref().unwrap_or_default()),
            None => ("", ""),
        };
        format!("{}|{ty}|{dir}|{funct}|{rule}|{other}", self.name)
    }
}

impl Inferred {
    /// Returns the arguments of `loadrt standin`.
    pub(super) fn arguments(&self) -> Vec<String> {
        let pins: Vec<String> = self.pins.iter().map(Pin::argument).collect();
        let mut args = vec![format!("pins={}", pins.join(","))];
        if !self.functs.is_empty() {
            args.push(format!("functs={}", self.functs.join(",")));
        }
        args
    }

    /// Returns the pins of which nothing but the name tells what they are.
    pub(super) fn doubtful(&self) -> impl Iterator<Item = &str> {
        self.pins.iter().filter(|pin| pin.doubtful).map(|pin| pin.name.as_str())
    }
}

/// Uses of one name in the lines.
#[derive(Default)]
struct Uses {
    signals: BTreeSet<String>,
    /// An arrow says that it writes its signal.
    is_source: bool,
    /// An arrow says that it reads its signal.
    is_sink: bool,
    /// Value of a line that sets it.
    value: Option<String>,
}

/// Infers the pins and functions that `statements` name and that `wires` has not, if `is_ours` says that they are
/// replaced.
pub(super) fn infer(
    statements: &[(At, Vec<String>)],
    wires: &Wires,
    is_ours: impl Fn(&str) -> bool,
) -> Inferred {
    let mut named = Named::default();
    let ours = |name: &str| !wires.has(name) && is_ours(name);
    for (_, words) in statements {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        named.read(&words, &ours);
    }
    named.finish(wires)
}

#[derive(Default)]
struct Named {
    uses: BTreeMap<String, Uses>,
    functs: Vec<String>,
    /// Types of signals that lines make or set.
    types: BTreeMap<String, Type>,
    /// Signals that lines set.
    set: BTreeSet<String>,
}

impl Named {
    fn read(&mut self, words: &[&str], ours: &impl Fn(&str) -> bool) {
        match words {
            ["net" | "linksp", signal, rest @ ..] => self.net(signal, rest, ours),
            ["linkps", pin, rest @ ..] => {
                let signal = rest.iter().find(|word| !is_arrow(word));
                signal.iter().for_each(|signal| self.net(signal, &[pin], ours));
            }
            ["newsig", signal, ty] => {
                if let Some(ty) = type_named(ty) {
                    self.types.insert((*signal).to_owned(), ty);
                }
            }
            ["sets", signal, value] => {
                self.set.insert((*signal).to_owned());
                if let Some(ty) = type_of(value) {
                    self.types.entry((*signal).to_owned()).or_insert(ty);
                }
            }
            ["setp", name, value] | [name, "=", value] if ours(name) => {
                let uses = self.uses.entry((*name).to_owned()).or_default();
                uses.value.get_or_insert_with(|| (*value).to_owned());
            }
            ["getp" | "ptype" | "unlinkp", name] | ["alias", "pin" | "param", name, _]
                if ours(name) =>
            {
                self.uses.entry((*name).to_owned()).or_default();
            }
            ["addf" | "initf", name, ..]
                if ours(name) && !self.functs.iter().any(|f| f == name) =>
            {
                self.functs.push((*name).to_owned());
            }
            _ => {}
        }
    }

    fn net(&mut self, signal: &str, words: &[&str], ours: &impl Fn(&str) -> bool) {
        for (at, name) in words.iter().enumerate().filter(|(_, w)| !is_arrow(w) && ours(w)) {
            let before = at.checked_sub(1).and_then(|at| words.get(at)).copied();
            let after = words.get(at + 1).copied();
            let uses = self.uses.entry((*name).to_owned()).or_default();
            uses.signals.insert(signal.to_owned());
            uses.is_source |= before == Some("<=") || after == Some("=>") && before != Some("=>");
            uses.is_sink |= before == Some("=>") || after == Some("<=");
        }
    }

    fn finish(self, wires: &Wires) -> Inferred {
        let mut members: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for (name, uses) in &self.uses {
            for signal in &uses.signals {
                members.entry(signal).or_default().push(name);
            }
        }
        let mut pins = Vec::new();
        // Times of functions are pins that functions have by themselves.
        let is_time = |name: &str| {
            TIMES.iter().any(|end| {
                let funct = name.strip_suffix(end);
                funct.is_some_and(|funct| self.functs.iter().any(|other| other == funct))
            })
        };
        for (name, uses) in self.uses.iter().filter(|(name, _)| !is_time(name)) {
            let known = uses.signals.iter().find_map(|signal| self.known_type(signal, wires));
            let given = uses.value.as_deref().and_then(type_of);
            let ty = known.or_else(|| given.filter(|_| uses.signals.is_empty()));
            let dir = self.direction(name, uses, &members, wires);
            let ty_sure = ty.is_some();
            let doubtful = !(uses.signals.is_empty() || ty_sure && dir.1);
            let joined = uses.signals.iter().filter_map(|signal| members.get(signal.as_str()));
            let all: Vec<&str> = joined.flatten().copied().chain([name.as_str()]).collect();
            let ty = ty.unwrap_or_else(|| type_by_names(&all));
            pins.push(Pin {
                name: name.clone(),
                ty,
                dir: dir.0,
                funct: None,
                rule: None,
                doubtful,
            });
        }
        let linked = |name: &str| self.uses.get(name).is_some_and(|u| !u.signals.is_empty());
        let rules: Vec<_> = pins.iter().map(|pin| rule(pin, &pins, &linked)).collect();
        for (pin, rule) in pins.iter_mut().zip(rules) {
            pin.rule = rule;
            pin.funct = funct(&pin.name, &self.functs);
        }
        self.spindles(&mut pins, wires);
        Inferred { pins, functs: self.functs }
    }

    /// Lets outputs that are a spindle's turns count them, and their index end at a whole one.
    fn spindles(&self, pins: &mut Vec<Pin>, wires: &Wires) {
        let end = |pin: &Pin, end: &str| {
            let signals = self.uses.get(&pin.name).map(|uses| &uses.signals)?;
            let ends = signals.iter().filter_map(|signal| wires.signals.get(signal));
            ends.flat_map(|signal| &signal.pins).find_map(|(_, name)| {
                let number = name.strip_prefix("spindle.")?.strip_suffix(end)?;
                Some(number.to_owned())
            })
        };
        let mut speeds = BTreeSet::new();
        let turns: Vec<(usize, String)> = pins
            .iter()
            .enumerate()
            .filter(|(_, pin)| pin.dir == Direction::Out && pin.ty == Type::Float)
            .filter_map(|(n, pin)| Some((n, end(pin, ".revs")?)))
            .collect();
        for (n, spindle) in turns {
            let Some(pin) = pins.get_mut(n) else { continue };
            pin.rule = Some(Rule::Sum(format!("{RPS}{spindle}")));
            let (name, funct) = (pin.name.clone(), pin.funct);
            let index = pins.iter_mut().find(|pin| {
                pin.dir == Direction::Io
                    && end(pin, ".index-enable").as_deref() == Some(spindle.as_str())
            });
            if let Some(index) = index {
                index.rule = Some(Rule::Index(Some(name)));
                index.funct = funct;
            }
            speeds.insert(spindle);
        }
        pins.extend(speeds.iter().map(|spindle| Pin {
            name: format!("{RPS}{spindle}"),
            ty: Type::Float,
            dir: Direction::In,
            funct: None,
            rule: None,
            doubtful: false,
        }));
    }

    fn known_type(&self, signal: &str, wires: &Wires) -> Option<Type> {
        let linked = wires.signals.get(signal).filter(|s| !s.pins.is_empty());
        linked.map(|s| s.value.ty()).or_else(|| self.types.get(signal).copied())
    }

    /// Returns the direction of a pin, and whether its other ends or an arrow tell it.
    fn direction(
        &self,
        name: &str,
        uses: &Uses,
        members: &BTreeMap<&str, Vec<&str>>,
        wires: &Wires,
    ) -> (Direction, bool) {
        if uses.value.is_some() || uses.signals.iter().any(|signal| self.set.contains(signal)) {
            return (Direction::In, true);
        }
        let ends = || {
            let signals = uses.signals.iter().filter_map(|signal| wires.signals.get(signal));
            signals.flat_map(|signal| &signal.pins)
        };
        if ends().any(|(dir, _)| *dir == Direction::Out) {
            return (Direction::In, true);
        }
        if ends().any(|(dir, _)| *dir == Direction::Io) {
            return (Direction::Io, true);
        }
        let others: Vec<&str> = uses
            .signals
            .iter()
            .filter_map(|signal| members.get(signal.as_str()))
            .flatten()
            .copied()
            .filter(|other| *other != name)
            .collect();
        let others_source = others
            .iter()
            .any(|other| self.uses.get(*other).is_some_and(|u| u.is_source && !u.is_sink));
        if others.is_empty() && ends().next().is_some() {
            // It is the only end that can write.
            return (Direction::Out, true);
        }
        if uses.is_source && !others_source {
            return (Direction::Out, true);
        }
        if others_source || uses.is_sink {
            return (Direction::In, true);
        }
        let mine = outwards(name);
        let best = others.iter().all(|other| {
            let theirs = outwards(other);
            mine > theirs || mine == theirs && name < *other
        });
        let out = if others.is_empty() { mine > 0 } else { best };
        (if out { Direction::Out } else { Direction::In }, false)
    }
}

/// Returns the function that writes an output: of those with the longest common beginning, one that reads.
fn funct(name: &str, functs: &[String]) -> Option<usize> {
    let common =
        |funct: &str| name.split('.').zip(funct.split('.')).take_while(|(a, b)| a == b).count();
    let reads = |funct: &str| funct.contains("read") || funct.contains("update");
    let best = functs.iter().enumerate().filter(|(_, funct)| common(funct) > 0);
    best.max_by_key(|(n, funct)| (common(funct), reads(funct), usize::MAX - n)).map(|(n, _)| n)
}

/// Returns what an output follows: an input of the same channel.
fn rule(pin: &Pin, pins: &[Pin], linked: &impl Fn(&str) -> bool) -> Option<Rule> {
    let there = |name: String, ty: Type| {
        let other = pins.iter().find(|other| other.name == name)?;
        (other.dir == Direction::In && other.ty == ty && linked(&name)).then_some(name)
    };
    match (pin.dir, pin.ty) {
        (Direction::Out, Type::Float | Type::Bit) => PAIRS.iter().find_map(|(out, input, sum)| {
            let channel = pin.name.strip_suffix(out).filter(|c| c.ends_with(['.', '-', '_']))?;
            let other = there(format!("{channel}{input}"), pin.ty)?;
            Some(if *sum { Rule::Sum(other) } else { Rule::Copy(other) })
        }),
        (Direction::Io, Type::Bit) if pin.name.contains("index") => Some(Rule::Index(None)),
        _ => None,
    }
}

fn is_arrow(word: &str) -> bool {
    matches!(word, "=>" | "<=" | "<=>")
}
