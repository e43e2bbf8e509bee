//! Heights of boxes and passing wires in their columns, with few crossings and straight wires.

use super::{
    by_index::ByIndex,
    size::{BY, GRID, IN, OUT, Sized},
};
use std::collections::BTreeMap;

/// Number of times that everything moves towards its linked ports.
const ROUNDS: usize = 24;
/// Number of links above which crossings are not counted.
const COUNTED: usize = 3000;

/// An element of a column: a box, or a wire that passes by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Node {
    /// Number of the box; none for a wire.
    pub(super) boxed: Option<usize>,
    pub(super) column: usize,
    pub(super) height: i64,
    pub(super) y: i64,
}

/// The place at which a signal touches a node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Port {
    pub(super) node: usize,
    pub(super) signal: usize,
    /// True if the port reaches the channel to the left or to the right of the node. A passing wire
    /// reaches both.
    pub(super) left: bool,
    pub(super) right: bool,
    /// Distance below the top of the node.
    pub(super) offset: i64,
}

/// The ports of a signal at a channel: in the column before it, and in the one after it.
#[derive(Clone, Debug, Default)]
pub(super) struct Ends {
    pub(super) before: Vec<Port>,
    pub(super) after: Vec<Port>,
}

/// Columns with their nodes, from top to bottom.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    pub(super) nodes: Vec<Node>,
    pub(super) columns: Vec<Vec<usize>>,
    pub(super) ports: Vec<Port>,
    /// Ports by channel and signal. Channel N is to the left of column N.
    pub(super) ends: BTreeMap<(usize, usize), Ends>,
}

impl Plan {
    /// Places boxes whose columns are known.
    pub(super) fn new(boxes: &[Sized], column: &ByIndex<usize>) -> Self {
        let mut plan = Self::default();
        let mut reach: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
        for (i, b) in boxes.iter().enumerate() {
            let column = column.at(i);
            let height = (b.height + GRID - 1) / GRID * GRID;
            plan.add(Node { boxed: Some(i), column, height, y: 0 });
            for (pin, _, left) in b.pins() {
                let Some(signal) = pin.signal else { continue };
                let channel = if left { column } else { column + 1 };
                let (least, most) = reach.entry(signal).or_insert((channel, channel));
                (*least, *most) = ((*least).min(channel), (*most).max(channel));
            }
        }
        let boxes_only = plan.nodes.len();
        for (signal, (least, most)) in reach {
            for column in least..most {
                let node = plan.add(Node { boxed: None, column, height: GRID, y: 0 });
                plan.ports.push(Port { node, signal, left: true, right: true, offset: BY[0] });
            }
        }
        let passing = plan.ports.clone();
        plan.ports.clear();
        for (node, b) in boxes.iter().enumerate().take(boxes_only) {
            plan.ports.extend(ports_of(node, b));
        }
        plan.ports.extend(passing);
        plan.connect();
        plan.stack();
        plan.order();
        plan.settle();
        plan
    }

    /// Takes new pin positions over and settles again.
    pub(super) fn renew(&mut self, boxes: &[Sized]) {
        let passing = self.ports.iter().copied().filter(|p| p.left && p.right);
        let own = boxes.iter().enumerate().flat_map(|(node, b)| ports_of(node, b));
        self.ports = own.chain(passing).collect();
        self.connect();
        self.order();
        self.settle();
    }

    /// Returns the vertical position of a port.
    pub(super) fn y(&self, port: &Port) -> i64 {
        self.nodes.get(port.node).map_or(0, |n| n.y) + port.offset
    }

    fn add(&mut self, node: Node) -> usize {
        let number = self.nodes.len();
        while self.columns.len() <= node.column {
            self.columns.push(Vec::new());
        }
        if let Some(column) = self.columns.get_mut(node.column) {
            column.push(number);
        }
        self.nodes.push(node);
        number
    }

    fn connect(&mut self) {
        self.ends.clear();
        for port in &self.ports {
            let column = self.nodes.get(port.node).map_or(0, |n| n.column);
            if port.left {
                self.ends.entry((column, port.signal)).or_default().after.push(*port);
            }
            if port.right {
                self.ends.entry((column + 1, port.signal)).or_default().before.push(*port);
            }
        }
    }

    /// Returns the links of each node in a column across the channel on one side; a port without a
    /// partner there links to the ports beside it. A link is the port's own offset and the mean
    /// height of its partners.
    fn links(&self, column: usize, left: bool) -> BTreeMap<usize, Vec<(i64, i64)>> {
        let mut links: BTreeMap<usize, Vec<(i64, i64)>> = BTreeMap::new();
        let mean = |n: usize, sum: i64| Some(sum / i64::try_from(n).ok().filter(|n| *n > 0)?);
        let channel = if left { column } else { column + 1 };
        for (_, ends) in self.ends.range((channel, 0)..=(channel, usize::MAX)) {
            let (own, other) =
                if left { (&ends.after, &ends.before) } else { (&ends.before, &ends.after) };
            let sum = |ports: &[Port]| ports.iter().map(|p| self.y(p)).sum::<i64>();
            let (across, beside) = (mean(other.len(), sum(other)), sum(own));
            for port in own {
                let wish = across.or_else(|| mean(own.len() - 1, beside - self.y(port)));
                if let Some(wish) = wish {
                    links.entry(port.node).or_default().push((port.offset, wish));
                }
            }
        }
        links
    }

    /// Stacks the nodes of each column in their order.
    fn stack(&mut self) {
        for column in &self.columns {
            let mut y = 0;
            let mut before = None;
            for i in column {
                let Some(node) = self.nodes.get_mut(*i) else { continue };
                y += before.map_or(0, |before| gap(before, *node));
                node.y = y;
                y += node.height;
                before = Some(*node);
            }
        }
    }

    /// Finds an order for each column with few crossings.
    fn order(&mut self) {
        let mut best = (self.crossings(), self.columns.clone());
        for round in 0..ROUNDS {
            let left = round % 2 == 0;
            let n = self.columns.len();
            for c in 0..n {
                let c = if left { c } else { n - 1 - c };
                let links = self.links(c, left);
                let Some(column) = self.columns.get(c) else { continue };
                let key = |i: &usize| {
                    let node = self.nodes.get(*i).copied().unwrap_or_default();
                    let own = node.y + node.height / 2;
                    links.get(i).map_or(own, |list| {
                        let sum: i64 = list.iter().map(|(offset, y)| y - offset).sum();
                        sum / i64::try_from(list.len()).unwrap_or(1) + node.height / 2
                    })
                };
                let mut keyed: Vec<(i64, usize)> = column.iter().map(|i| (key(i), *i)).collect();
                keyed.sort_by_key(|(key, _)| *key);
                let sorted = keyed.into_iter().map(|(_, i)| i).collect();
                if let Some(column) = self.columns.get_mut(c) {
                    *column = sorted;
                }
                self.stack();
            }
            let crossings = self.crossings();
            if crossings < best.0 {
                best = (crossings, self.columns.clone());
            }
        }
        self.columns = best.1;
        self.stack();
    }

    /// Returns an approximate number of wire crossings.
    fn crossings(&self) -> usize {
        let mut channels: BTreeMap<usize, Vec<(i64, i64)>> = BTreeMap::new();
        for ((channel, _), ends) in &self.ends {
            for a in &ends.before {
                let pairs = ends.after.iter().map(|b| (self.y(a), self.y(b)));
                channels.entry(*channel).or_default().extend(pairs);
            }
        }
        let count = |lines: &Vec<(i64, i64)>| {
            let pairs = lines
                .iter()
                .enumerate()
                .flat_map(|(i, a)| lines.iter().skip(i + 1).map(move |b| (a, b)));
            pairs.filter(|(a, b)| (a.0 < b.0) != (a.1 < b.1)).count()
        };
        if channels.values().any(|lines| lines.len() > COUNTED) {
            return 0;
        }
        channels.values().map(count).sum()
    }

    /// Moves nodes up or down, in their order, to make wires straight.
    fn settle(&mut self) {
        for round in 0..2 * ROUNDS {
            let sides: &[bool] = match round {
                r if r >= ROUNDS => &[true, false],
                r if r % 2 == 0 => &[true],
                _ => &[false],
            };
            for c in 0..self.columns.len() {
                let c = if round % 2 == 0 { c } else { self.columns.len() - 1 - c };
                let links: Vec<_> = sides.iter().map(|left| self.links(c, *left)).collect();
                self.settle_column(c, &links);
            }
        }
        self.snap();
        self.part();
    }

    fn settle_column(&mut self, c: usize, links: &[BTreeMap<usize, Vec<(i64, i64)>>]) {
        let Some(column) = self.columns.get(c) else { return };
        // Each block of adjoining nodes takes the mean of the heights that its nodes prefer.
        let mut blocks: Vec<(f64, f64, Vec<usize>)> = Vec::new();
        let (mut above, mut before) = (0, None);
        let mut tops: BTreeMap<usize, i64> = BTreeMap::new();
        for i in column {
            let node = self.nodes.get(*i).copied().unwrap_or_default();
            above += before.map_or(0, |b: Node| b.height + gap(b, node));
            before = Some(node);
            tops.insert(*i, above);
            let wishes = links.iter().filter_map(|l| l.get(i)).flatten();
            let wishes: Vec<i64> = wishes.map(|(offset, y)| y - offset).collect();
            let (sum, weight) = if wishes.is_empty() {
                (node.y as f64 * 0.1, 0.1)
            } else {
                (wishes.iter().sum::<i64>() as f64, wishes.len() as f64)
            };
            let mut block = (sum - above as f64 * weight, weight, vec![*i]);
            while let Some(last) = blocks.last()
                && last.0 / last.1 >= block.0 / block.1
            {
                let Some(last) = blocks.pop() else { break };
                let mut nodes = last.2;
                nodes.extend(block.2);
                block = (last.0 + block.0, last.1 + block.1, nodes);
            }
            blocks.push(block);
        }
        for (sum, weight, nodes) in blocks {
            #[expect(clippy::cast_possible_truncation, reason = "a mean of heights is one")]
            let base = (sum / weight).round() as i64;
            for i in nodes {
                if let Some(node) = self.nodes.get_mut(i) {
                    node.y = base + tops.get(&i).copied().unwrap_or(0);
                }
            }
        }
    }

    /// Aligns everything to the grid, with the highest node at zero.
    fn snap(&mut self) {
        let least = self.nodes.iter().map(|n| n.y).min().unwrap_or(0);
        for column in &self.columns {
            let mut before: Option<Node> = None;
            for i in column {
                let Some(node) = self.nodes.get_mut(*i) else { continue };
                let y = (node.y - least + GRID / 2).div_euclid(GRID) * GRID;
                let room = before.map_or(0, |b| b.y + b.height + gap(b, *node));
                node.y = y.max(room);
                before = Some(*node);
            }
        }
    }
}

// Passing wires of neighbouring columns at the same height.
impl Plan {
    /// Moves one of two passing wires that would lie on each other between two columns.
    fn part(&mut self) {
        let mut at: BTreeMap<(usize, i64), usize> = BTreeMap::new();
        for port in self.ports.iter_mut().filter(|p| p.left && p.right) {
            let node = self.nodes.get(port.node).copied().unwrap_or_default();
            let beside = [node.column.checked_sub(1), node.column.checked_add(1)];
            let is_free = |offset: &i64| {
                let other = |c| at.get(&(c, node.y + offset)).copied();
                beside.into_iter().flatten().filter_map(other).all(|s| s == port.signal)
            };
            port.offset = BY.into_iter().find(is_free).unwrap_or(BY[0]);
            at.insert((node.column, node.y + port.offset), port.signal);
        }
        self.connect();
    }
}

fn ports_of(node: usize, b: &Sized) -> Vec<Port> {
    let ports = b.pins().filter_map(|(pin, top, left)| {
        let offset = top + if left { IN } else { OUT };
        Some(Port { node, signal: pin.signal?, left, right: !left, offset })
    });
    ports.collect()
}

/// Returns the space between two nodes that stand one below the other.
const fn gap(above: Node, below: Node) -> i64 {
    match (above.boxed, below.boxed) {
        (Some(_), Some(_)) => 2 * GRID,
        (None, None) => 0,
        _ => GRID,
    }
}
