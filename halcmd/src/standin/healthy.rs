//! The values of inputs with which a machine is at rest and ready: no button pressed, no switch closed, no drive at fault.
//!
//! Pins that motion, `iocontrol` and safety components read want a value. A want goes back along the wires, through
//! components of logic, to the pins that stand for hardware.

use super::wires::Wires;
use hal_protocol::{Direction, Type};
use std::collections::{BTreeMap, BTreeSet};

/// Value that a pin should have.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Want {
    Bit(bool),
    /// The value of this pin.
    As(String),
}

/// Kind of writer of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Driver {
    /// No writer.
    Nobody,
    /// Pins that stand for hardware, and nobody else.
    Hardware,
    /// A component.
    Somebody,
}

/// Components whose output has the value of their input `in`, sooner or later.
const PASSING: &[&str] = &[
    "debounce",
    "dbounce",
    "timedelay",
    "tristate_bit",
    "bin2gray",
    "lowpass",
    "invert",
    "limit3",
];

/// Returns what each pin for which `is_source` holds should be.
pub(super) fn wants(wires: &Wires, is_source: &dyn Fn(&str) -> bool) -> BTreeMap<String, Want> {
    let mut back = Back { wires, is_source, found: BTreeMap::new(), seen: BTreeSet::new() };
    let mut roles: Vec<(u8, &str, Want)> = wires
        .pins
        .iter()
        .filter(|(_, pin)| pin.direction != Direction::Out && pin.signal.is_some())
        .filter_map(|(name, pin)| role(name, &pin.owner).map(|(rank, want)| (rank, &**name, want)))
        .collect();
    roles.sort_by_key(|(rank, name, _)| (*rank, name.to_owned()));
    for (_, name, want) in roles {
        back.pin(name, want);
    }
    back.found
}

/// Returns who determines an input.
pub(super) fn driver(wires: &Wires, is_source: &dyn Fn(&str) -> bool, pin: &str) -> Driver {
    let mut todo = vec![pin.to_owned()];
    let mut seen = BTreeSet::new();
    let mut found = Driver::Nobody;
    while let Some(pin) = todo.pop() {
        let signal = wires.signal_of(&pin);
        let Some(writer) = signal.and_then(|signal| wires.writer(signal)) else { continue };
        if is_source(writer) {
            found = Driver::Hardware;
            continue;
        }
        let inputs = inputs(wires, writer);
        if inputs.is_empty() {
            return Driver::Somebody;
        }
        todo.extend(inputs.into_iter().filter(|input| seen.insert(input.clone())));
    }
    found
}

/// Returns the inputs of the component of logic that has this output.
fn inputs(wires: &Wires, output: &str) -> Vec<String> {
    let Some(pin) = wires.pins.get(output) else { return Vec::new() };
    let owner = pin.owner.as_str();
    let is_logic = matches!(
        owner,
        "not" | "and2" | "or2" | "xor2" | "logic" | "lut5" | "maj3" | "nand2" | "nor2"
    );
    if !is_logic && !PASSING.contains(&owner) {
        return Vec::new();
    }
    let base = base(output);
    let all = wires.pins.iter().filter(|(name, pin)| {
        pin.direction == Direction::In
            && pin.value.ty() == Type::Bit
            && name.strip_prefix(base).is_some_and(|rest| rest.starts_with(".in"))
    });
    all.map(|(name, _)| name.clone()).collect()
}

fn base(pin: &str) -> &str {
    pin.rsplit_once('.').map_or(pin, |(base, _)| base)
}

/// Returns what a pin of this name should be, and a rank: the smaller one counts where two disagree.
fn role(name: &str, owner: &str) -> Option<(u8, Want)> {
    let parts: Vec<&str> = name.split('.').collect();
    match (owner, &parts[..]) {
        (_, ["joint", n, "motor-pos-fb"]) => {
            Some((0, Want::As(format!("joint.{n}.motor-pos-cmd"))))
        }
        (_, ["joint", _, "pos-lim-sw-in" | "neg-lim-sw-in" | "amp-fault-in"])
        | (_, ["motion", "feed-hold" | "feed-inhibit" | "probe-input"])
        | (_, ["spindle", _, "amp-fault-in" | "inhibit"])
        | ("estop_latch", [.., "fault-in"]) => Some((1, Want::Bit(false))),
        (_, ["joint", _, "home-sw-in"]) => Some((2, Want::Bit(false))),
        (_, ["iocontrol", _, "emc-enable-in"] | ["motion", "enable"]) => Some((0, Want::Bit(true))),
        (_, ["spindle", _, "at-speed"]) | ("estop_latch", [.., "ok-in"]) => {
            Some((1, Want::Bit(true)))
        }
        (_, ["spindle", n, "speed-in"]) => {
            Some((1, Want::As(format!("spindle.{n}.speed-out-rps"))))
        }
        (_, ["iocontrol", n, "tool-changed"]) => {
            Some((1, Want::As(format!("iocontrol.{n}.tool-change"))))
        }
        (_, ["iocontrol", n, "tool-prepared"]) => {
            Some((1, Want::As(format!("iocontrol.{n}.tool-prepare"))))
        }
        (_, ["iocontrol", _, "lube_level" | "lube-level"]) => Some((2, Want::Bit(true))),
        ("halui", _) => Some((3, Want::Bit(false))),
        _ => None,
    }
}

struct Back<'a> {
    wires: &'a Wires,
    is_source: &'a dyn Fn(&str) -> bool,
    found: BTreeMap<String, Want>,
    /// Outputs that have been gone back from, since wires may run in circles.
    seen: BTreeSet<String>,
}

impl Back<'_> {
    /// Goes back from an input.
    fn pin(&mut self, pin: &str, want: Want) {
        let wires = self.wires;
        let Some(writer) = wires.signal_of(pin).and_then(|signal| wires.writer(signal)) else {
            return;
        };
        self.output(writer, want);
    }

    /// Goes back from an output.
    fn output(&mut self, output: &str, want: Want) {
        if (self.is_source)(output) {
            self.found.entry(output.to_owned()).or_insert(want);
            return;
        }
        let Some(pin) = self.wires.pins.get(output) else { return };
        if !self.seen.insert(output.to_owned()) {
            return;
        }
        let (base, owner) = (base(output), pin.owner.as_str());
        let end = output.rsplit('.').next().unwrap_or_default();
        let mut to = |end: &str, want: Want| self.pin(&format!("{base}.{end}"), want);
        match (owner, end, want) {
            ("not", "out", Want::Bit(value)) => to("in", Want::Bit(!value)),
            ("and2", "out", Want::Bit(true)) => {
                to("in0", Want::Bit(true));
                to("in1", Want::Bit(true));
            }
            ("or2", "out", Want::Bit(false)) => {
                to("in0", Want::Bit(false));
                to("in1", Want::Bit(false));
            }
            // One of two inputs is enough.
            ("and2" | "or2", "out", Want::Bit(value)) => to("in0", Want::Bit(value)),
            ("xor2", "out", Want::Bit(value)) => {
                to("in0", Want::Bit(value));
                to("in1", Want::Bit(false));
            }
            ("logic", "and" | "nor", Want::Bit(value)) => {
                let all = if end == "and" { value } else { !value };
                self.every(output, Want::Bit(all));
            }
            ("logic", "or" | "nand", Want::Bit(value)) => {
                let all = if end == "or" { value } else { !value };
                self.every(output, Want::Bit(all));
            }
            ("estop_latch", "ok-out", Want::Bit(value)) => {
                to("ok-in", Want::Bit(value));
                to("fault-in", Want::Bit(!value));
            }
            ("estop_latch", "fault-out", Want::Bit(value)) => {
                to("ok-in", Want::Bit(!value));
                to("fault-in", Want::Bit(value));
            }
            ("lut5", "out", Want::Bit(value)) => self.table(base, value),
            // The input is near a value that another pin has.
            ("near", "out", Want::Bit(true)) => {
                let other = |n: &str| format!("{base}.{n}");
                to("in1", Want::As(other("in2")));
                to("in2", Want::As(other("in1")));
            }
            (owner, "out", want) if PASSING.contains(&owner) => to("in", want),
            _ => {}
        }
    }

    fn every(&mut self, output: &str, want: Want) {
        for input in inputs(self.wires, output) {
            self.pin(&input, want.clone());
        }
    }

    /// Chooses the inputs of a look-up table: of the rows with this result, the first with the fewest TRUE among those
    /// inputs that are linked.
    fn table(&mut self, base: &str, value: bool) {
        let name = |n: u32| format!("{base}.in-{n}");
        let function = self.wires.pins.get(&format!("{base}.function"));
        let bits = match function.map(|pin| pin.value) {
            Some(hal_protocol::Value::U32(bits)) => bits,
            Some(hal_protocol::Value::S32(bits)) => bits.cast_unsigned(),
            _ => return,
        };
        let linked = |n: u32| self.wires.signal_of(&name(n)).is_some();
        let is_possible = |row: u32| (0..5).all(|n| row >> n & 1 == 0 || linked(n));
        let rows = (0..32_u32).filter(|row| (bits >> row & 1 == 1) == value && is_possible(*row));
        let Some(row) = rows.min_by_key(|row| row.count_ones()) else { return };
        for n in 0..5 {
            self.pin(&name(n), Want::Bit(row >> n & 1 == 1));
        }
    }
}
