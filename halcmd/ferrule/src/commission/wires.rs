//! Pins and their signals, as a person who looks for a wire needs them.

use hal_protocol::{Direction, ItemInfo, Value};

/// Pins of the machine.
pub(crate) struct Wires(Vec<ItemInfo>);

impl Wires {
    pub(crate) const fn new(pins: Vec<ItemInfo>) -> Self {
        Self(pins)
    }

    fn pin(&self, name: &str) -> Option<&ItemInfo> {
        self.0.iter().find(|pin| pin.name == name || pin.original.as_deref() == Some(name))
    }

    /// Returns the signal of a pin.
    pub(crate) fn signal(&self, name: &str) -> Option<&str> {
        self.pin(name)?.signal.as_deref()
    }

    /// Returns the other pins of a pin's signal: those that write it, or those that read it.
    fn others(&self, name: &str, are_writers: bool) -> Vec<&ItemInfo> {
        let Some(signal) = self.signal(name) else { return Vec::new() };
        let is_of = |pin: &&ItemInfo| {
            let is_writer = pin.direction != Direction::In;
            pin.signal.as_deref() == Some(signal) && pin.name != name && is_writer == are_writers
        };
        self.0.iter().filter(is_of).collect()
    }

    /// Returns a pin with its signal and what is at the other end of it.
    pub(crate) fn of(&self, name: &str) -> String {
        let Some(signal) = self.signal(name) else { return format!("{name} (not linked)") };
        let is_input = self.pin(name).is_some_and(|pin| pin.direction == Direction::In);
        let others = self.others(name, is_input);
        let names: Vec<&str> = others.iter().map(|pin| pin.name.as_str()).collect();
        let end = match (is_input, names.is_empty()) {
            (true, true) => "nothing writes it".to_owned(),
            (true, false) => format!("written by {}", names.join(", ")),
            (false, true) => "nothing reads it".to_owned(),
            (false, false) => format!("read by {}", names.join(", ")),
        };
        format!("{name} (signal {signal}, {end})")
    }

    /// Returns several pins as [`Self::of`] does.
    pub(crate) fn all(&self, names: &[String]) -> String {
        names.iter().map(|name| self.of(name)).collect::<Vec<_>>().join("; ")
    }

    /// Returns what makes the movement of a joint: instances that read its command, as `stepgen.0` or `pid.0`.
    fn makers(&self, joint: usize) -> Vec<&str> {
        let command = format!("joint.{joint}.motor-pos-cmd");
        let readers = self.others(&command, false);
        let names = readers.iter().filter(|pin| !pin.name.starts_with("joint."));
        names.filter_map(|pin| Some(pin.name.rsplit_once('.')?.0)).collect()
    }

    /// Returns the outputs of a joint's motor with their wires.
    pub(crate) fn outputs(&self, joint: usize) -> String {
        let makers = self.makers(joint);
        let back = self.signal(&format!("joint.{joint}.motor-pos-fb"));
        let is_of = |pin: &&ItemInfo| {
            let maker = pin.name.rsplit_once('.').map_or("", |(maker, _)| maker);
            let is_wired = pin.signal.is_some() && pin.signal.as_deref() != back;
            makers.contains(&maker) && pin.direction == Direction::Out && is_wired
        };
        let all: Vec<&ItemInfo> = self.0.iter().filter(is_of).collect();
        let is_line = |pin: &&&ItemInfo| matches!(pin.value, Value::Bit(_));
        let lines: Vec<String> = all.iter().filter(is_line).map(|pin| pin.name.clone()).collect();
        let names: Vec<String> = all.iter().map(|pin| pin.name.clone()).collect();
        match (lines.is_empty(), names.is_empty()) {
            (false, _) => self.all(&lines),
            (true, false) => self.all(&names),
            (true, true) => self.of(&format!("joint.{joint}.motor-pos-cmd")),
        }
    }

    /// Returns the instances that make the movement of a joint.
    pub(crate) fn loops(&self, joint: usize) -> String {
        self.makers(joint).join(", ")
    }

    /// Returns whether the controller knows where a joint is only from its own steps.
    pub(crate) fn is_open(&self, joint: usize) -> bool {
        let writers = self.others(&format!("joint.{joint}.motor-pos-fb"), true);
        let makers = self.makers(joint);
        writers
            .iter()
            .any(|pin| pin.name.rsplit_once('.').is_some_and(|(maker, _)| makers.contains(&maker)))
    }
}

#[cfg(test)]
mod tests {
    use super::Wires;
    use hal_protocol::{Direction, ItemInfo, Value};

    fn pin(name: &str, direction: Direction, value: Value, signal: &str) -> ItemInfo {
        ItemInfo {
            owner: 1,
            owner_name: "x".to_owned(),
            direction,
            value,
            name: name.to_owned(),
            original: None,
            signal: (!signal.is_empty()).then(|| signal.to_owned()),
            doc: String::new(),
        }
    }

    #[test]
    fn a_wire_is_told_with_both_ends() {
        let (bit, float) = (Value::Bit(false), Value::Float(0.0));
        let wires = Wires::new(vec![
            pin("joint.0.motor-pos-cmd", Direction::Out, float, "cmd"),
            pin("joint.0.motor-pos-fb", Direction::In, float, "fb"),
            pin("joint.1.motor-pos-cmd", Direction::Out, float, "cmd1"),
            pin("joint.1.motor-pos-fb", Direction::In, float, "fb1"),
            pin("pid.0.command", Direction::In, float, "cmd1"),
            pin("pid.0.output", Direction::Out, float, "power"),
            pin("encoder.0.position", Direction::Out, float, "fb1"),
            pin("stepgen.0.position-cmd", Direction::In, float, "cmd"),
            pin("stepgen.0.position-fb", Direction::Out, float, "fb"),
            pin("stepgen.0.step", Direction::Out, bit, "step"),
            pin("parport.0.pin-02-out", Direction::In, bit, "step"),
            pin("joint.0.home-sw-in", Direction::In, bit, ""),
        ]);
        assert_eq!(wires.of("joint.0.home-sw-in"), "joint.0.home-sw-in (not linked)");
        assert_eq!(wires.outputs(0), "stepgen.0.step (signal step, read by parport.0.pin-02-out)");
        assert_eq!(wires.outputs(1), "pid.0.output (signal power, nothing reads it)");
        assert_eq!(
            wires.of("joint.1.motor-pos-fb"),
            "joint.1.motor-pos-fb (signal fb1, written by encoder.0.position)"
        );
        assert_eq!((wires.is_open(0), wires.is_open(1)), (true, false));
        assert_eq!(wires.loops(1), "pid.0");
    }
}
