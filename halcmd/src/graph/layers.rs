//! Assignment of boxes to columns: values flow from left to right, except feedback.

use super::by_index::ByIndex;
use std::collections::{BTreeMap, BTreeSet};

/// Returns the column of each of `n` boxes. `links` gives the number of values from one box to
/// another.
pub(super) fn columns(n: usize, links: &BTreeMap<(usize, usize), i64>) -> ByIndex<usize> {
    let order = order(n, links);
    let mut place = ByIndex::of(n, 0);
    order.iter().enumerate().for_each(|(at, i)| place.set(*i, at));
    let forward: BTreeSet<(usize, usize)> =
        links.keys().copied().filter(|(a, b)| place.at(*a) < place.at(*b)).collect();
    let mut column = ByIndex::of(n, 0_usize);
    for i in &order {
        for (_, b) in forward.range((*i, 0)..=(*i, usize::MAX)) {
            column.set(*b, column.at(*b).max(column.at(*i) + 1));
        }
    }
    // A box without inputs moves next to the boxes that it feeds.
    let taking: BTreeSet<usize> = forward.iter().map(|(_, b)| *b).collect();
    for i in order.iter().rev().filter(|i| !taking.contains(i)) {
        let next = forward.range((*i, 0)..=(*i, usize::MAX)).map(|(_, b)| column.at(*b)).min();
        if let Some(next) = next {
            column.set(*i, next.saturating_sub(1));
        }
    }
    column
}

/// Returns an order in which few values flow backwards: pure sources first, pure sinks last, and of
/// the others the one with the largest difference between outgoing and incoming values next.
fn order(n: usize, links: &BTreeMap<(usize, usize), i64>) -> Vec<usize> {
    let (mut gives, mut takes) = (ByIndex::of(n, 0_i64), ByIndex::of(n, 0_i64));
    let mut near: BTreeMap<usize, Vec<(usize, i64, bool)>> = BTreeMap::new();
    for ((a, b), weight) in links.iter().filter(|((a, b), _)| a != b) {
        gives.set(*a, gives.at(*a) + weight);
        takes.set(*b, takes.at(*b) + weight);
        near.entry(*a).or_default().push((*b, *weight, true));
        near.entry(*b).or_default().push((*a, *weight, false));
    }
    let key = |gives: i64, takes: i64| match (gives, takes) {
        (0, _) => (0, 0),
        (_, 0) => (1, 0),
        _ => (2, takes - gives),
    };
    let mut left: BTreeSet<((u8, i64), usize)> =
        (0..n).map(|i| (key(gives.at(i), takes.at(i)), i)).collect();
    let (mut first, mut last) = (Vec::new(), Vec::new());
    while let Some((k, i)) = left.pop_first() {
        if k.0 == 0 {
            last.push(i);
        } else {
            first.push(i);
        }
        for (other, weight, given) in near.get(&i).into_iter().flatten() {
            if left.remove(&(key(gives.at(*other), takes.at(*other)), *other)) {
                let side = if *given { &mut takes } else { &mut gives };
                side.set(*other, side.at(*other) - weight);
                left.insert((key(gives.at(*other), takes.at(*other)), *other));
            }
        }
    }
    first.extend(last.into_iter().rev());
    first
}
