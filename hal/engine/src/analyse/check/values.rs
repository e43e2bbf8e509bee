//! Checks of values that script lines set: set twice, without effect, or implausible.

use super::{Look, finding};
use crate::graph::{Item, Ix};
use hal_protocol::{Code, Direction, Type};

/// Names of the lower and the upper bound of a range.
const BOUNDS: [(&str, &str); 3] = [("min", "max"), ("minv", "maxv"), ("min-limit", "max-limit")];

impl Look<'_> {
    pub(super) fn values(&mut self) {
        for (ix, item) in self.items().iter().copied() {
            self.set_twice(ix, item.shown().as_str());
            self.set_then_linked(ix, item);
            self.scale(ix, item);
            self.finite(ix, item);
            self.bounds(ix, item);
        }
        for (_, signal) in self.graph.signal_names() {
            self.set_twice(signal, self.signal_name(signal));
            self.set_then_written(signal);
        }
    }

    fn set_twice(&mut self, node: Ix, name: &str) {
        let sites = &self.graph.sites;
        let Some(values) = sites.values_of(node) else { return };
        let Some(other) = values.other else { return };
        let (Some(at), Some(before)) = (sites.at(values.last.site), sites.at(other.site)) else {
            return;
        };
        let (now, was) = (self.value(node, values.last.bits), self.value(node, other.bits));
        let text = format!("'{name}' is set to {now}, and was set to {was} before");
        self.add(
            finding(Code::SetTwice, name, text)
                .at(Some(at))
                .remedy("keep the one that is meant")
                .related(Some(before), format!("set to {was} here")),
        );
    }

    fn set_then_linked(&mut self, pin: Ix, item: &Item) {
        let (Some(signal), Some(set)) = (self.graph.signal_of(pin), self.set_at(pin)) else {
            return;
        };
        let (writers, _) = self.ends(signal);
        let Some(writer) = writers.iter().copied().find(|w| *w != pin) else { return };
        if item.direction != Direction::In {
            return;
        }
        let name = item.shown().as_str();
        let text = format!(
            "'{name}' is set here and then linked to signal '{}', which '{}' writes: the value is \
             lost",
            self.signal_name(signal),
            self.shown(writer)
        );
        let linked = self.linked_at(pin);
        self.add(
            finding(Code::SetThenLinked, name, text)
                .at(Some(set))
                .remedy("take this line out, or the link")
                .related(linked, "linked here"),
        );
    }

    fn set_then_written(&mut self, signal: Ix) {
        let Some(set) = self.set_at(signal) else { return };
        let (writers, _) = self.ends(signal);
        // A port is set to the size of its queue.
        let out = |w: &&Ix| {
            let writes = |i: &Item| i.direction == Direction::Out && i.ty != Type::Port;
            self.graph.item(**w).is_some_and(writes)
        };
        let Some(writer) = writers.iter().find(out).copied() else { return };
        let name = self.signal_name(signal);
        let text = format!("signal '{name}' is set here, and '{}' writes it: the value is lost", {
            self.shown(writer)
        });
        let linked = self.linked_at(writer);
        self.add(
            finding(Code::SetThenWritten, name, text)
                .at(Some(set))
                .remedy("take this line out, or the output off the signal")
                .related(linked, "linked here"),
        );
    }

    fn scale(&mut self, ix: Ix, item: &Item) {
        let name = item.shown().as_str();
        let last = item.name.as_str().rsplit('.').next().unwrap_or_default();
        let is_setting = matches!(item.direction, Direction::In | Direction::Io | Direction::Rw);
        let is_scale = last == "scale" || last.ends_with("-scale");
        if !is_setting
            || !is_scale
            || item.ty != Type::Float
            || self.graph.signal_of(ix).is_some()
            || self.number(ix) != Some(0.0)
        {
            return;
        }
        let Some(at) = self.set_at(ix) else { return };
        self.add(
            finding(Code::ScaleZero, name, format!("'{name}' is 0"))
                .at(Some(at))
                .remedy("set what one unit is, in steps, counts or volts; negative turns it round"),
        );
    }

    /// Reports a float that a script line has set to NaN, or to infinity where that is no open bound.
    fn finite(&mut self, ix: Ix, item: &Item) {
        let (Some(at), Some(value)) = (self.set_at(ix), self.number(ix)) else { return };
        let last = item.name.as_str().rsplit('.').next().unwrap_or_default();
        let is_bound = ["min", "max"].iter().any(|bound| last.contains(bound));
        if item.ty != Type::Float || value.is_finite() || !value.is_nan() && is_bound {
            return;
        }
        let name = item.shown().as_str();
        let text = format!("'{name}' is set to {value}, which is no finite number");
        self.add(
            finding(Code::NotFinite, name, text)
                .at(Some(at))
                .remedy(format!("write a number: setp {name} 1.5")),
        );
    }

    fn bounds(&mut self, ix: Ix, item: &Item) {
        let Some((prefix, last)) = item.name.as_str().rsplit_once('.') else { return };
        let Some((_, upper)) = BOUNDS.iter().find(|(lower, _)| *lower == last) else { return };
        let Some((other, top)) = self.item(&format!("{prefix}.{upper}")) else { return };
        let settable = |i: &Item, ix: Ix| {
            matches!(i.direction, Direction::In | Direction::Rw)
                && i.ty == Type::Float
                && self.graph.signal_of(ix).is_none()
        };
        let (Some(low), Some(high)) = (self.number(ix), self.number(other)) else { return };
        if !settable(item, ix) || !settable(top, other) || low <= high {
            return;
        }
        let (name, upper) = (item.shown().as_str(), top.shown().as_str());
        let text = format!("'{name}' is {low}, above '{upper}', which is {high}");
        let at = self.set_at(ix).or_else(|| self.set_at(other));
        let Some(at) = at else { return };
        let there = self.set_at(other).filter(|other| *other != at);
        self.add(
            finding(Code::BoundsCross, name, text)
                .at(Some(at))
                .remedy("swap them, or correct the one that is wrong")
                .related(there, format!("'{upper}' is set here")),
        );
    }
}
