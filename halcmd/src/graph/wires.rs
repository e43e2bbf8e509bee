//! The route of each wire: out of a pin, along a track between two columns, and into the next pin.

use super::{
    by_index::ByIndex,
    plan::{Ends, Plan, Port},
    size::{SMALL, text_width},
};
use std::collections::{BTreeMap, BTreeSet};

/// Distance between two tracks, and between the first track and its neighbour.
const TRACK: i64 = 10;
const MARGIN: i64 = 16;
/// Length of the end of an unconnected wire.
const LOOSE: i64 = 14;
/// Length of the arrow at an input.
const ARROW: i64 = 12;

/// A drawn signal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Wire {
    pub(super) signal: usize,
    /// Straight lines: x and y of one end, then x and y of the other.
    pub(super) lines: Vec<[i64; 4]>,
    /// Points at which more than two lines meet.
    pub(super) dots: Vec<(i64, i64)>,
    /// Position of the name, and whether the text ends (instead of begins) there.
    pub(super) label: Option<(i64, i64, bool)>,
    /// Position of an end without a pin.
    pub(super) loose: Option<(i64, i64)>,
}

/// Columns from left to right, and the wires between them.
#[derive(Clone, Debug, Default)]
pub(super) struct Routed {
    /// Left sides and widths of the columns.
    pub(super) columns: Vec<(i64, i64)>,
    pub(super) width: i64,
    pub(super) wires: Vec<Wire>,
}

/// The vertical part of a wire in a channel.
#[derive(Clone, Debug)]
struct Trunk {
    signal: usize,
    before: Vec<i64>,
    after: Vec<i64>,
    least: i64,
    most: i64,
}

/// Draws the wires of a plan. Columns are as wide as their widest box. `names` returns the name of
/// a signal.
pub(super) fn route(plan: &Plan, widths: &[i64], names: &dyn Fn(usize) -> String) -> Routed {
    let mut routed = Routed::default();
    let mut wires: BTreeMap<usize, Wire> = BTreeMap::new();
    let mut named = BTreeSet::new();
    let mut x = 0;
    let mut right = 0;
    for channel in 0..=widths.len() {
        let ends: Vec<(usize, &Ends)> = plan
            .ends
            .range((channel, 0)..=(channel, usize::MAX))
            .map(|((_, s), e)| (*s, e))
            .collect();
        // The name is beside the output of a box, or else beside an input.
        let is_pin = |port: &&Port| !(port.left && port.right);
        let mut zones = (0, 0);
        let mut labels: BTreeMap<usize, (i64, bool)> = BTreeMap::new();
        for (signal, e) in &ends {
            let out = e.before.iter().find(is_pin);
            let into = e.after.iter().find(is_pin).filter(|_| !has_output(plan, *signal));
            let width = text_width(&names(*signal), SMALL) + LOOSE;
            if let Some(port) = out.filter(|_| named.insert(*signal)) {
                labels.insert(*signal, (plan.y(port), false));
                zones.0 = zones.0.max(width);
            } else if let Some(port) = into.filter(|_| named.insert(*signal)) {
                labels.insert(*signal, (plan.y(port), true));
                zones.1 = zones.1.max(width + ARROW);
            }
        }
        let trunks = ordered(ends.iter().filter_map(|(s, e)| trunk(plan, *s, e)).collect());
        let tracks = tracks(&trunks);
        let count = tracks.values().max().map_or(0, |t| t + 1);
        let first = x + zones.0 + MARGIN;
        let end = match (count, ends.is_empty()) {
            (_, true) if channel == 0 || channel == widths.len() => x,
            (0, _) => first + zones.1 + MARGIN,
            _ => first + (count - 1) * TRACK + MARGIN + zones.1,
        };
        for (signal, e) in &ends {
            let wire =
                wires.entry(*signal).or_insert_with(|| Wire { signal: *signal, ..Wire::default() });
            let track = tracks.get(signal).map(|t| first + t * TRACK);
            draw(wire, plan, e, (right, end), track);
            if let Some((y, into)) = labels.get(signal) {
                let at = if *into { end - ARROW } else { right + LOOSE / 2 };
                wire.label = Some((at, *y, *into));
                if e.before.len() + e.after.len() == 1 {
                    loosen(wire, names(*signal).as_str(), (right, end), *y, *into);
                }
            }
        }
        x = end;
        if let Some(width) = widths.get(channel) {
            routed.columns.push((x, *width));
            for port in plan.ports.iter().filter(|p| p.left && p.right) {
                let here = plan.nodes.get(port.node).is_some_and(|n| n.column == channel);
                if let Some(wire) = wires.get_mut(&port.signal).filter(|_| here) {
                    let y = plan.y(port);
                    wire.lines.push([x, y, x + width, y]);
                }
            }
            x += width;
            right = x;
        }
    }
    routed.width = x;
    routed.wires = wires.into_values().collect();
    routed
}

/// Returns whether any box has the signal as an output.
fn has_output(plan: &Plan, signal: usize) -> bool {
    plan.ports.iter().any(|p| p.signal == signal && p.right && !p.left)
}

fn trunk(plan: &Plan, signal: usize, ends: &Ends) -> Option<Trunk> {
    let down = |ports: &[Port]| -> Vec<i64> { ports.iter().map(|p| plan.y(p)).collect() };
    let (before, after) = (down(&ends.before), down(&ends.after));
    let all = || before.iter().chain(&after).copied();
    let (least, most) = (all().min()?, all().max()?);
    (least < most).then_some(Trunk { signal, before, after, least, most })
}

/// Counts the horizontal lines that cross vertical ones when `a` is to the left of `b`.
fn crossings(a: &Trunk, b: &Trunk) -> usize {
    let inside = |y: &&i64, t: &Trunk| t.least <= **y && **y <= t.most;
    a.after.iter().filter(|y| inside(y, b)).count()
        + b.before.iter().filter(|y| inside(y, a)).count()
}

/// Orders trunks from left to right with few crossings.
fn ordered(mut trunks: Vec<Trunk>) -> Vec<Trunk> {
    trunks.sort_by_key(|t| (t.least + t.most, t.signal));
    for _ in 0..trunks.len().min(200) {
        let mut better = false;
        for i in 1..trunks.len() {
            let Some([a, b]) = trunks.get(i - 1..=i) else { continue };
            if crossings(b, a) < crossings(a, b) {
                trunks.swap(i - 1, i);
                better = true;
            }
        }
        if !better {
            break;
        }
    }
    trunks
}

/// Assigns a track to each trunk. Trunks that never overlap in height share one.
fn tracks(trunks: &[Trunk]) -> BTreeMap<usize, i64> {
    let mut tracks = BTreeMap::new();
    let mut taken: ByIndex<i64> = ByIndex::of(trunks.len(), 0);
    for (i, t) in trunks.iter().enumerate() {
        let beside = trunks
            .iter()
            .enumerate()
            .take(i)
            .filter(|(_, o)| o.least <= t.most + TRACK && t.least <= o.most + TRACK);
        let track = beside.map(|(j, _)| taken.at(j) + 1).max().unwrap_or(0);
        taken.set(i, track);
        tracks.insert(t.signal, track);
    }
    tracks
}

/// Draws the lines of a wire in a channel between these sides.
fn draw(wire: &mut Wire, plan: &Plan, ends: &Ends, (left, right): (i64, i64), track: Option<i64>) {
    let Some(x) = track else {
        // All ends are at the same height.
        if let (Some(port), false) = (ends.before.first(), ends.after.is_empty()) {
            let y = plan.y(port);
            wire.lines.push([left, y, right, y]);
        }
        return;
    };
    let mut at: BTreeMap<i64, usize> = BTreeMap::new();
    for (port, side) in
        ends.before.iter().map(|p| (p, left)).chain(ends.after.iter().map(|p| (p, right)))
    {
        let y = plan.y(port);
        wire.lines.push([side.min(x), y, side.max(x), y]);
        *at.entry(y).or_default() += 1;
    }
    let (least, most) = (at.keys().next().copied(), at.keys().next_back().copied());
    if let (Some(least), Some(most)) = (least, most) {
        wire.lines.push([x, least, x, most]);
    }
    for (y, count) in at {
        let ways = count + usize::from(Some(y) != least) + usize::from(Some(y) != most);
        if ways > 2 {
            wire.dots.push((x, y));
        }
    }
}

/// Draws a wire with a single end; it is as long as its name.
fn loosen(wire: &mut Wire, name: &str, (left, right): (i64, i64), y: i64, into: bool) {
    let length = text_width(name, SMALL) + LOOSE;
    let (from, to) = if into { (right - length - ARROW, right) } else { (left, left + length) };
    wire.lines.push([from, y, to, y]);
    wire.loose = Some((if into { from } else { to }, y));
}
