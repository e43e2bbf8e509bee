//! Positions of everything in the picture. Each group of boxes that wires connect is laid out by
//! itself; the groups are then put below and beside each other.

use super::{
    by_index::ByIndex,
    drawing::Drawing,
    layers::columns,
    plan::Plan,
    size::{GRID, Sized},
    wires::{Wire, route},
};
use std::collections::BTreeMap;

/// Space between two groups.
const APART: i64 = 3 * GRID;

/// A box at its position.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Placed {
    pub(super) sized: Sized,
    pub(super) x: i64,
    pub(super) y: i64,
}

/// The whole picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layout {
    pub(super) width: i64,
    pub(super) height: i64,
    pub(super) boxes: Vec<Placed>,
    pub(super) wires: Vec<Wire>,
}

impl Layout {
    /// Lays out a drawing.
    pub(super) fn of(drawing: &Drawing) -> Self {
        let mut groups: Vec<Self> = groups(drawing).iter().map(|g| group(drawing, g)).collect();
        // Large groups come first; then as many stand side by side as the widest group leaves room
        // for.
        groups.sort_by_key(|g| core::cmp::Reverse(g.boxes.len() * 1_000_000));
        let widest = groups.iter().map(|g| g.width).max().unwrap_or(0).max(50 * GRID);
        let mut all = Self::default();
        let (mut x, mut y, mut tallest) = (0, 0, 0);
        for group in groups {
            if x > 0 && x + group.width > widest {
                y += tallest + APART;
                (x, tallest) = (0, 0);
            }
            let (width, height) = (group.width, group.height);
            all.take(group, x, y);
            x += width + APART;
            tallest = tallest.max(height);
        }
        all
    }

    /// Adds a group at this position.
    fn take(&mut self, group: Self, x: i64, y: i64) {
        self.width = self.width.max(x + group.width);
        self.height = self.height.max(y + group.height);
        self.boxes.extend(group.boxes.into_iter().map(|b| Placed { x: b.x + x, y: b.y + y, ..b }));
        self.wires.extend(group.wires.into_iter().map(|mut w| {
            w.lines.iter_mut().for_each(|[a, b, c, d]| {
                (*a, *b, *c, *d) = (*a + x, *b + y, *c + x, *d + y);
            });
            w.dots.iter_mut().for_each(|(a, b)| (*a, *b) = (*a + x, *b + y));
            w.label = w.label.map(|(a, b, into)| (a + x, b + y, into));
            w.loose = w.loose.map(|(a, b)| (a + x, b + y));
            w
        }));
    }
}

/// Returns the groups of boxes that wires connect, directly or indirectly.
fn groups(drawing: &Drawing) -> Vec<Vec<usize>> {
    let n = drawing.boxes.len();
    let mut of: ByIndex<usize> = (0..n).collect();
    let root = |of: &ByIndex<usize>, mut i: usize| {
        while of.at(i) != i {
            i = of.at(i);
        }
        i
    };
    let mut first: BTreeMap<usize, usize> = BTreeMap::new();
    for (i, b) in drawing.boxes.iter().enumerate() {
        for signal in b.pins().filter_map(|pin| pin.signal) {
            let other = *first.entry(signal).or_insert(i);
            let (a, b) = (root(&of, i), root(&of, other));
            of.set(a.max(b), a.min(b));
            of.set(i, a.min(b));
        }
    }
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    (0..n).for_each(|i| groups.entry(root(&of, i)).or_default().push(i));
    groups.into_values().collect()
}

fn group(drawing: &Drawing, members: &[usize]) -> Layout {
    let boxes = members.iter().filter_map(|i| drawing.boxes.get(*i));
    let mut boxes: Vec<Sized> = boxes.cloned().map(Sized::new).collect();
    let column = columns(boxes.len(), &links(&boxes));
    let mut plan = Plan::new(&boxes, &column);
    for _ in 0..2 {
        boxes = boxes.into_iter().enumerate().map(|(i, b)| sorted(&plan, i, b)).collect();
        plan.renew(&boxes);
    }
    let mut widths = vec![0; plan.columns.len()];
    for (i, b) in boxes.iter().enumerate() {
        if let Some(width) = widths.get_mut(column.at(i)) {
            *width = b.width.max(*width);
        }
    }
    let name = |s: usize| drawing.signals.get(s).map_or_else(String::new, |s| s.name.clone());
    let routed = route(&plan, &widths, &name);
    let placed = boxes.into_iter().enumerate().filter_map(|(i, mut sized)| {
        let (x, width) = *routed.columns.get(column.at(i))?;
        sized.width = width;
        Some(Placed { sized, x, y: plan.nodes.get(i)?.y })
    });
    let boxes: Vec<Placed> = placed.collect();
    let below = boxes.iter().map(|b| b.y + b.sized.height).max().unwrap_or(0);
    let lines = routed.wires.iter().flat_map(|w| w.lines.iter().map(|l| l[1].max(l[3]))).max();
    Layout {
        width: routed.width,
        height: below.max(lines.unwrap_or(0)),
        boxes,
        wires: routed.wires,
    }
}

/// Counts the values that flow from one box to another.
fn links(boxes: &[Sized]) -> BTreeMap<(usize, usize), i64> {
    let mut ends: BTreeMap<usize, (Vec<usize>, Vec<usize>)> = BTreeMap::new();
    for (i, b) in boxes.iter().enumerate() {
        for (pin, _, left) in b.pins() {
            let Some(signal) = pin.signal else { continue };
            let (from, to) = ends.entry(signal).or_default();
            if left { to.push(i) } else { from.push(i) }
        }
    }
    let mut links = BTreeMap::new();
    for (from, to) in ends.values() {
        for from in from {
            for to in to.iter().filter(|to| *to != from) {
                *links.entry((*from, *to)).or_default() += 1;
            }
        }
    }
    links
}

/// Sorts the pins on each side of a box by the positions of the pins they are linked to.
fn sorted(plan: &Plan, node: usize, sized: Sized) -> Sized {
    let mut wish: BTreeMap<(usize, bool), i64> = BTreeMap::new();
    let column = plan.nodes.get(node).map_or(0, |n| n.column);
    for (left, channel) in [(true, column), (false, column + 1)] {
        for ((_, signal), ends) in plan.ends.range((channel, 0)..=(channel, usize::MAX)) {
            let other = if left { &ends.before } else { &ends.after };
            if let Some(n) = i64::try_from(other.len()).ok().filter(|n| *n > 0) {
                let mean = other.iter().map(|p| plan.y(p)).sum::<i64>() / n;
                wish.insert((*signal, left), mean);
            }
        }
    }
    let mut boxed = sized.boxed;
    for section in &mut boxed.sections {
        for (pins, left) in [(&mut section.left, true), (&mut section.right, false)] {
            // Pins without a preferred position stay below those with one.
            pins.sort_by_key(|pin| {
                pin.signal.and_then(|s| wish.get(&(s, left))).copied().unwrap_or(i64::MAX)
            });
        }
    }
    Sized::new(boxed)
}
