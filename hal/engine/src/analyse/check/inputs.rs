//! Checks of channels that compute from inputs that nothing feeds, or for outputs that nothing uses.

use super::{Look, finding, names, protection::is_driver};
use crate::graph::{Component, Item, Ix};
use hal_protocol::{Code, Direction};
use std::collections::BTreeMap;

/// Inputs without which a channel computes nothing.
const NEEDED: &[&str] = &[
    "in",
    "sel",
    "sel0",
    "sel1",
    "ok-in",
    "phase-A",
    "phase-B",
    "value",
    "position-cmd",
    "command",
    "feedback",
    "fb-in",
    "speed",
];
/// Components of which one fed input is enough.
const ANY: &[&str] = &[
    "comp",
    "mux2",
    "mux4",
    "mux8",
    "mux16",
    "mux_generic",
    "lut5",
    "logic",
    "select8",
    "match8",
    "weighted_sum",
    "multiclick",
    "hypot",
    "bitslice",
    "sum2",
    "scaled_s32_sums",
    "pid",
];
/// Components whose outputs only report.
const REPORTS: &[&str] =
    &["sampler", "streamer", "message", "motmod", "speaker", "or2", "select8", "pwmgen"];

/// An item of a channel, with the last part of its name.
type Part<'g> = (Ix, &'g str, &'g Item);

impl<'g> Look<'g> {
    /// Reports inputs that nothing feeds, and channels whose outputs nothing uses.
    pub(super) fn inputs(&mut self) {
        // The names of a channel's items are the same up to the last part.
        let mut channels: BTreeMap<&str, Vec<Part<'g>>> = BTreeMap::new();
        for (ix, item) in self.items().iter().copied() {
            if let Some((channel, last)) = item.name.as_str().rsplit_once('.')
                && self.graph.owner(ix).is_some_and(is_block)
            {
                channels.entry(channel).or_default().push((ix, last, item));
            }
        }
        for (name, channel) in channels {
            self.open_inputs(name, &channel);
            self.unused_result(name, &channel);
        }
    }

    fn open_inputs(&mut self, name: &str, channel: &[Part<'g>]) {
        let data: Vec<_> = channel
            .iter()
            .filter(|(_, last, i)| i.direction == Direction::In && is_data(name, last))
            .collect();
        let is_alive = channel.iter().any(|(ix, ..)| self.graph.signal_of(*ix).is_some());
        let Some((first, ..)) = data.first().filter(|_| is_alive) else { return };
        let module = self.loaded_by(*first);
        // An open input of an or2 is FALSE and changes nothing.
        if module == "or2" {
            return;
        }
        let is_selected = |last: &str| last.starts_with("sel") || last == "feedback";
        let fed = data.iter().any(|(ix, last, _)| !last.starts_with("sel") && self.is_used(*ix));
        let enough = fed && ANY.contains(&module);
        let linked = channel.iter().find_map(|(ix, ..)| self.linked_at(*ix));
        for (ix, last, item) in data.iter().copied() {
            let runs = self.readers(*ix).iter().any(|f| self.graph.is_in_use(*f));
            if self.is_used(*ix) || !runs || enough && !is_selected(last) {
                continue;
            }
            // A counter of one line, and a step generator in the other mode, need no such input.
            // A pid whose gains are 0 passes its command on, and its feedback changes nothing.
            if *last == "feedback" && self.passes_command(name) {
                continue;
            }
            let mode = self.number_of(&format!("{name}.counter-mode"));
            if *last == "phase-B" && mode.is_some_and(|m| m != 0.0)
                || *last == "speed" && self.item(&format!("{name}.ppr")).is_none()
            {
                continue;
            }
            let pin = item.shown().as_str();
            let text = format!("nothing feeds '{pin}', and other pins of '{name}' are in use");
            let at = linked.clone().or_else(|| self.loaded_at(*ix));
            self.add(finding(Code::InputOpen, pin, text).at(at).remedy(format!(
                "link it: net SIGNAL PIN => {pin}; or give it its value: setp {pin} VALUE"
            )));
        }
    }

    /// Returns whether a control loop has gains, all of them are 0, and no signal sets them.
    fn passes_command(&self, channel: &str) -> bool {
        ["Pgain", "Igain", "Dgain"].iter().all(|gain| {
            self.item(&format!("{channel}.{gain}")).is_some_and(|(ix, _)| {
                self.graph.signal_of(ix).is_none() && self.number(ix) == Some(0.0)
            })
        })
    }

    fn unused_result(&mut self, name: &str, channel: &[Part<'g>]) {
        let is = |direction| channel.iter().filter(move |(.., i)| i.direction == direction);
        let outputs: Vec<&str> = is(Direction::Out).map(|(.., i)| i.shown().as_str()).collect();
        let fed = is(Direction::In)
            .find(|(ix, last, _)| is_data(name, last) && self.graph.signal_of(*ix).is_some());
        let Some((ix, ..)) = fed else { return };
        let pins = channel.iter().filter(|(.., i)| i.direction != Direction::In);
        let used = pins.clone().any(|(ix, ..)| self.graph.signal_of(*ix).is_some());
        let runs = self.readers(*ix).iter().any(|f| self.graph.is_in_use(*f));
        if used || !runs || outputs.is_empty() || REPORTS.contains(&self.loaded_by(*ix)) {
            return;
        }
        let text = format!(
            "'{}' is linked, and no output of '{name}': {}",
            self.shown(*ix),
            names(outputs.iter().copied())
        );
        let at = self.linked_at(*ix);
        let out = outputs.iter().find(|o| o.contains("out")).or_else(|| outputs.first());
        let out = out.copied().unwrap_or_default();
        self.add(
            finding(Code::ResultUnused, name, text).at(at).remedy(format!(
                "link what it makes: net SIGNAL {out} => PIN; or take '{name}' out"
            )),
        );
    }
}

/// Returns whether a component computes: it is loaded into realtime, is not a driver, and its functions
/// are known.
fn is_block(component: &Component) -> bool {
    component.realtime && component.foreign.is_none() && !is_driver(component)
}

/// Returns whether an input carries the values that its channel works on.
fn is_data(channel: &str, last: &str) -> bool {
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let numbered = last.strip_prefix("in").map(|n| n.strip_prefix('-').unwrap_or(n));
    NEEDED.contains(&last)
        || numbered.is_some_and(digits)
        || digits(last) && channel.ends_with(".pin")
}
