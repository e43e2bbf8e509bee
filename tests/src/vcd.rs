//! Reader for recordings.

use hal_protocol::Value;
use hal_trace::{Trace, draw, vcd};
use std::collections::BTreeMap;

/// A recording: all changes of all pins, as numbers.
#[derive(Clone, Debug, Default)]
pub struct Vcd {
    trace: Trace,
    changes: BTreeMap<String, Vec<(i64, f64)>>,
}

impl Vcd {
    /// Reads the text of a VCD file as the recorder writes it.
    pub fn parse(text: &str) -> Self {
        let read = vcd::read(text.as_bytes());
        assert_eq!((&read.flaw, read.notes.len()), (&None, 0), "VCD: {:?}", read.notes);
        let trace = read.trace;
        let mut changes = BTreeMap::new();
        for channel in trace.channels() {
            let list = channel.changes().map(|c| {
                let value = match c.value.unwrap() {
                    Value::Bit(b) => f64::from(u8::from(b)),
                    Value::Float(x) => x,
                    whole => whole.to_string().parse().unwrap(),
                };
                (trace.times().get(c.sample).unwrap(), value)
            });
            let list: Vec<(i64, f64)> = list.collect();
            for name in channel.names() {
                changes.insert(name.clone(), list.clone());
            }
        }
        Self { trace, changes }
    }

    /// Returns the changes of a pin or signal: time in nanoseconds, new value. The first entry is the initial value.
    pub fn of(&self, name: &str) -> &[(i64, f64)] {
        self.changes.get(name).unwrap_or_else(|| panic!("'{name}' is not in the recording"))
    }

    /// Returns the names of the recorded items.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.changes.keys().map(String::as_str)
    }

    /// Returns the end time of the recording.
    pub fn end(&self) -> i64 {
        self.trace.times().last().unwrap_or(0)
    }

    /// Returns the value of a pin at a time.
    pub fn at(&self, name: &str, time: i64) -> f64 {
        let before = self.of(name).iter().take_while(|(t, _)| *t <= time);
        before.last().unwrap_or_else(|| panic!("'{name}' was not recorded at {time}")).1
    }

    /// Returns the times of a bit's rising edges.
    pub fn rises(&self, name: &str) -> Vec<i64> {
        let changes = self.of(name);
        let later = changes.iter().skip(1);
        changes
            .iter()
            .zip(later)
            .filter(|(a, b)| a.1 == 0.0 && b.1 != 0.0)
            .map(|(_, b)| b.0)
            .collect()
    }

    /// Draws channels as text, one line each, from one time to another, in microseconds after `from`.
    pub fn drawing(&self, bits: &[&str], from: i64, to: i64) -> String {
        draw::edges(&self.trace, bits, from, to).unwrap()
    }
}

#[cfg(test)]
mod tests {
    use super::Vcd;

    #[test]
    fn what_the_recorder_writes() {
        let vcd = Vcd::parse(
            "$version Ferrule $end\n$timescale 1 ns $end\n$scope module a $end\n\
             $var wire 1 ! x $end\n$var real 64 \" y $end\n$upscope $end\n$var wire 32 # n $end\n\
             $var wire 1 ! sig $end\n$enddefinitions $end\n#0\n$dumpvars\n0!\nr1.5e0 \"\nb0 #\n\
             $end\n#100\n1!\nb101 #\n#200\n0!\n#300\n1!\nr-2e-1 \"\n#400\n",
        );
        assert_eq!(vcd.rises("a.x"), [100, 300]);
        assert_eq!(vcd.of("sig"), vcd.of("a.x"));
        assert_eq!(vcd.at("a.y", 299), 1.5);
        assert_eq!(vcd.at("a.y", 300), -0.2);
        assert_eq!(vcd.at("n", 1000), 5.0);
        assert_eq!(vcd.end(), 400);
        let drawing = "a.x  _/‾0.05‾\\_0.15_\nsig  _/‾0.05‾\\_0.15_\n";
        assert_eq!(vcd.drawing(&["a.x", "sig"], 50, 250), drawing);
    }
}
