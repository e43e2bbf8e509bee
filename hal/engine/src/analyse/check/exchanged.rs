//! Checks of two channels that are exchanged: each reads a signal of one axis or line, and writes one of the other.

use super::{Look, finding};
use crate::graph::Ix;
use hal_protocol::{At, Code, Direction};
use std::collections::BTreeMap;

/// Largest number of channels of one component that are compared.
const MAX_CHANNELS: usize = 64;
/// Characters between the parts of a signal's name.
const BETWEEN: [char; 3] = ['-', '_', '.'];

/// A linked pin and its signal.
#[derive(Clone, Copy)]
struct End<'g> {
    pin: Ix,
    signal: &'g str,
}

/// Linked pins of a channel, by the last part of their names.
#[derive(Default)]
struct Channel<'g> {
    inputs: BTreeMap<&'g str, End<'g>>,
    outputs: BTreeMap<&'g str, End<'g>>,
}

/// The same two pins of two channels, and the parts in which the names of their signals differ.
struct Pair<'g> {
    ends: [End<'g>; 2],
    parts: Vec<(&'g str, &'g str)>,
}

impl<'g> Pair<'g> {
    /// Returns the pairs of pins of two channels whose signals have similar names.
    fn all(a: &BTreeMap<&'g str, End<'g>>, b: &BTreeMap<&'g str, End<'g>>) -> Vec<Self> {
        let both = a.iter().filter_map(|(tail, a)| Some([*a, *b.get(tail)?]));
        let pair = |ends: [End<'g>; 2]| {
            Some(Self { ends, parts: difference(ends[0].signal, ends[1].signal)? })
        };
        both.filter_map(pair).collect()
    }

    fn is_reverse_of(&self, other: &Self) -> bool {
        let reverse = other.parts.iter().map(|(a, b)| (*b, *a));
        self.parts.iter().copied().eq(reverse)
    }
}

impl<'g> Look<'g> {
    /// Reports channels of one component that are exchanged.
    pub(super) fn exchanged(&mut self) {
        let mut components: BTreeMap<Ix, BTreeMap<&'g str, Channel<'g>>> = BTreeMap::new();
        for (pin, item) in self.items().iter().copied() {
            let Some(signal) = self.graph.signal_of(pin) else { continue };
            let Some((channel, tail)) = item.name.as_str().rsplit_once('.') else { continue };
            let Some(owner) = self.graph.owner_of(pin) else { continue };
            let channel = components.entry(owner).or_default().entry(channel).or_default();
            let end = End { pin, signal: self.signal_name(signal) };
            match item.direction {
                Direction::In => drop(channel.inputs.insert(tail, end)),
                Direction::Out => drop(channel.outputs.insert(tail, end)),
                _ => {}
            }
        }
        for channels in components.values() {
            let all: Vec<_> = channels.iter().map(|(n, c)| (*n, c)).take(MAX_CHANNELS).collect();
            for (n, a) in all.iter().enumerate() {
                self.step_and_direction(a.0, &a.1.outputs);
                for b in all.iter().skip(n + 1) {
                    self.exchange(*a, *b);
                }
            }
        }
    }

    /// Reports a channel whose step is called a direction, and whose direction a step.
    fn step_and_direction(&mut self, channel: &str, outputs: &BTreeMap<&'g str, End<'g>>) {
        let (Some(step), Some(dir)) = (outputs.get("step"), outputs.get("dir")) else { return };
        let has = |signal: &str, words: &[&str]| {
            let mut parts = signal.split(BETWEEN).map(str::to_ascii_lowercase);
            parts.any(|part| words.iter().any(|word| part.ends_with(word)))
        };
        let (steps, turns): (&[&str], &[&str]) = (&["step", "pulse"], &["dir", "direction"]);
        let is =
            |signal: &str, one: &[&str], other: &[&str]| has(signal, one) && !has(signal, other);
        if !is(step.signal, turns, steps) || !is(dir.signal, steps, turns) {
            return;
        }
        let [a, b] = [step, dir].map(|end| (self.shown(end.pin), self.linked_at(end.pin)));
        let text = format!(
            "'{}' writes signal '{}', and '{}' writes '{}': they are crossed",
            a.0, step.signal, b.0, dir.signal
        );
        let remedy = format!("exchange the signals of '{}' and '{}'", a.0, b.0);
        self.add(
            finding(Code::Crossed, channel, text)
                .at(a.1)
                .remedy(remedy)
                .related(b.1, format!("'{}' is linked here", b.0)),
        );
    }

    fn exchange(
        &mut self,
        (first, a): (&'g str, &Channel<'g>),
        (second, b): (&'g str, &Channel<'g>),
    ) {
        let inputs = Pair::all(&a.inputs, &b.inputs);
        let outputs = Pair::all(&a.outputs, &b.outputs);
        let reads = |end: &End<'_>| {
            a.inputs.values().chain(b.inputs.values()).any(|input| input.signal == end.signal)
        };
        // Two that feed each other make a loop; one straight pair leaves it open which is meant.
        let is_loop = a.outputs.values().chain(b.outputs.values()).any(reads);
        let is_straight = outputs.iter().any(|o| inputs.iter().any(|i| i.parts == o.parts));
        if is_loop || is_straight {
            return;
        }
        let found = outputs
            .iter()
            .find_map(|o| Some((inputs.iter().find(|i| i.is_reverse_of(o))?.ends, o.ends)));
        let Some((input, output)) = found else { return };
        let shown = [input[0], input[1], output[0], output[1]].map(|end| self.shown(end.pin));
        let text = format!(
            "'{first}' reads signal '{}' and writes '{}', and '{second}' reads '{}' and writes '{}': they are \
             crossed",
            input[0].signal, output[0].signal, input[1].signal, output[1].signal
        );
        let remedy = format!(
            "exchange the signals of '{}' and '{}', or those of '{}' and '{}'",
            shown[2], shown[3], shown[0], shown[1]
        );
        let at = self.linked_at(output[0].pin);
        let mut new = finding(Code::Crossed, first, text).at(at.clone()).remedy(remedy);
        let mut named: Vec<Option<At>> = vec![at];
        for end in [input[0], output[1], input[1]] {
            let there = self.linked_at(end.pin);
            if !named.contains(&there) {
                let text = format!("'{}' is linked here", self.shown(end.pin));
                new = new.related(there.clone(), text);
                named.push(there);
            }
        }
        self.add(new);
    }
}

/// Returns the parts in which two names differ; `None` if they have nothing in common, or are equal.
fn difference<'g>(a: &'g str, b: &'g str) -> Option<Vec<(&'g str, &'g str)>> {
    let (a, b): (Vec<_>, Vec<_>) = (a.split(BETWEEN).collect(), b.split(BETWEEN).collect());
    let parts: Vec<_> = a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| a != b).collect();
    (a.len() == b.len() && !parts.is_empty() && parts.len() < a.len()).then_some(parts)
}
