//! Computes the order of a thread's functions that its data flow implies.
//!
//! Functions are numbered by their positions in the user's order, so "backwards" means "to a
//! smaller number". If values flow in a loop, the order must cut it somewhere: where the fewest
//! values become late, or where the user has cut it if that costs no more.

use super::by_index::{ByIndex, Lists};
use core::cmp::Reverse;
use petgraph::{algo::kosaraju_scc, graph::DiGraph};
use std::collections::{BTreeMap, BinaryHeap};

/// Weight of a pair whose order must not change.
pub(crate) const FIXED: u64 = 1 << 32;
/// Maximum number of functions in a loop for which the optimal cut is computed.
const EXACT: usize = 12;
/// Maximum number of functions in a loop for which the order is improved function by function.
const IMPROVED: usize = 1000;

/// A flow: index of the writer, index of the reader, cost of its delay.
pub(crate) type Arc = (usize, usize, u64);

/// Returns the cost of an order: the total weight of the flows that go backwards in it.
pub(crate) fn cost(places: &ByIndex<usize>, arcs: &[Arc]) -> u64 {
    let late = arcs.iter().filter(|(a, b, _)| places.at(*a) > places.at(*b));
    late.fold(0, |sum, (_, _, weight)| sum.saturating_add(*weight))
}

/// Returns the best order found for `n` functions. Returns the user's order, which is that of the
/// numbers, unless another costs less.
pub(crate) fn sorted(n: usize, arcs: &[Arc]) -> Vec<usize> {
    let user: Vec<usize> = (0..n).collect();
    let before = cost(&ByIndex::places(&user, n), arcs);
    if before == 0 {
        return user;
    }
    let kept = without_circles(n, arcs);
    let orders = [pulled(n, &kept), pushed(n, &kept)];
    let better = orders.into_iter().min_by_key(|order| n - unmoved(order).len());
    better.filter(|order| cost(&ByIndex::places(order, n), arcs) < before).unwrap_or(user)
}

/// Returns the longest increasing subsequence of an order: the functions that need not move.
pub(crate) fn unmoved(order: &[usize]) -> Vec<usize> {
    // Smallest last number of an increasing subsequence of each length, and the predecessor of each
    // number.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: BTreeMap<usize, usize> = BTreeMap::new();
    for &i in order {
        let length = ends.partition_point(|end| *end < i);
        if let Some(last) = length.checked_sub(1).and_then(|l| ends.get(l)) {
            before.insert(i, *last);
        }
        match ends.get_mut(length) {
            Some(end) => *end = i,
            None => ends.push(i),
        }
    }
    let mut part: Vec<usize> =
        core::iter::successors(ends.last().copied(), |i| before.get(i).copied()).collect();
    part.reverse();
    part
}

/// Returns the arcs without those that are cut, so that no loop remains.
fn without_circles(n: usize, arcs: &[Arc]) -> Vec<(usize, usize)> {
    let pairs = arcs.iter().map(|(a, b, _)| (to_u32(*a), to_u32(*b)));
    let mut g: DiGraph<(), ()> = DiGraph::from_edges(pairs);
    while g.node_count() < n {
        g.add_node(());
    }
    // Position of each function within its loop, and the number of that loop.
    let (mut place, mut circle) = (ByIndex::of(n, 0), ByIndex::of(n, 0));
    let circles = kosaraju_scc(&g);
    for (number, members) in circles.iter().enumerate() {
        members.iter().for_each(|m| circle.set(m.index(), number));
    }
    let inside = arcs.iter().enumerate().filter(|(_, (a, b, _))| circle.at(*a) == circle.at(*b));
    let inside = Lists::sort(circles.len(), inside.map(|(i, (a, _, _))| (circle.at(*a), i)));
    for (number, members) in circles.iter().enumerate().filter(|(_, m)| m.len() > 1) {
        let mut members: Vec<usize> = members.iter().map(|m| m.index()).collect();
        members.sort_unstable();
        let own: Vec<Arc> =
            inside.at(number).iter().filter_map(|i| arcs.get(*i)).copied().collect();
        let order = opened(&members, &own);
        order.iter().enumerate().for_each(|(at, i)| place.set(*i, at));
    }
    let kept = arcs.iter().filter(|(a, b, _)| {
        a != b && (circle.at(*a) != circle.at(*b) || place.at(*a) < place.at(*b))
    });
    kept.map(|(a, b, _)| (*a, *b)).collect()
}

/// Returns the best order found for functions in a loop. `members` is the user's order.
fn opened(members: &[usize], arcs: &[Arc]) -> Vec<usize> {
    let n = members.len();
    let number = |i: &usize| members.binary_search(i).unwrap_or(0);
    let arcs: Vec<Arc> = arcs.iter().map(|(a, b, w)| (number(a), number(b), *w)).collect();
    let user: Vec<usize> = (0..n).collect();
    let mut orders = vec![user.clone()];
    if n <= EXACT {
        orders.push(exact(n, &arcs));
    } else {
        orders.push(greedy(n, &arcs));
        if n <= IMPROVED {
            orders = orders.into_iter().map(|order| improved(order, &arcs)).collect();
            orders.insert(0, user);
        }
    }
    // Among equal costs, the first order wins, which is the user's.
    let best = orders.into_iter().min_by_key(|order| cost(&ByIndex::places(order, n), &arcs));
    best.unwrap_or_default().into_iter().filter_map(|i| members.get(i)).copied().collect()
}

/// Returns the optimal order, by dynamic programming over the sets of functions that come first.
fn exact(n: usize, arcs: &[Arc]) -> Vec<usize> {
    let mut weight = ByIndex::of(n * n, 0_u64);
    arcs.iter().for_each(|(a, b, w)| weight.set(a * n + b, weight.at(a * n + b) + w));
    let sets = 1_usize << n;
    let (mut least, mut last) = (ByIndex::of(sets, u64::MAX), ByIndex::of(sets, 0_usize));
    least.set(0, 0);
    for set in 0..sets {
        for i in (0..n).filter(|i| set & (1 << i) == 0) {
            // Flows from `i` to functions that come before it are late.
            let late = (0..n).filter(|j| set & (1 << j) != 0).map(|j| weight.at(i * n + j));
            let sum = late.fold(least.at(set), u64::saturating_add);
            let with = set | (1 << i);
            if sum < least.at(with) {
                least.set(with, sum);
                last.set(with, i);
            }
        }
    }
    let mut order = Vec::with_capacity(n);
    let mut set = sets - 1;
    while set != 0 {
        let i = last.at(set);
        order.push(i);
        set &= !(1 << i);
    }
    order.reverse();
    order
}

/// Returns a good order: functions without inputs first, functions without outputs last, and of the
/// others first the one with the largest difference between outputs and inputs.
fn greedy(n: usize, arcs: &[Arc]) -> Vec<usize> {
    let gives = Lists::sort(n, arcs.iter().enumerate().map(|(i, (a, _, _))| (*a, i)));
    let takes = Lists::sort(n, arcs.iter().enumerate().map(|(i, (_, b, _))| (*b, i)));
    let sum = |list: &[usize]| -> i128 {
        list.iter().filter_map(|i| arcs.get(*i)).map(|a| i128::from(a.2)).sum()
    };
    let (mut out, mut into) = (ByIndex::of(n, 0_i128), ByIndex::of(n, 0_i128));
    for i in 0..n {
        out.set(i, sum(gives.at(i)));
        into.set(i, sum(takes.at(i)));
    }
    // 0: no outputs left, 1: no inputs left, 2: both left; then by the difference.
    let key = |out: i128, into: i128| match (out, into) {
        (0, _) => (0, 0),
        (_, 0) => (1, 0),
        _ => (2, into - out),
    };
    let mut heap: BinaryHeap<Reverse<((u8, i128), usize)>> =
        (0..n).map(|i| Reverse((key(out.at(i), into.at(i)), i))).collect();
    let mut gone = ByIndex::of(n, false);
    let (mut first, mut last) = (Vec::new(), Vec::new());
    while let Some(Reverse((k, i))) = heap.pop() {
        if gone.at(i) || k != key(out.at(i), into.at(i)) {
            continue;
        }
        gone.set(i, true);
        if k.0 == 0 {
            last.push(i);
        } else {
            first.push(i);
        }
        for (a, b, w) in gives.at(i).iter().chain(takes.at(i)).filter_map(|x| arcs.get(*x)) {
            let other = if *a == i { *b } else { *a };
            if gone.at(other) {
                continue;
            }
            let side = if *a == i { &mut into } else { &mut out };
            side.set(other, side.at(other) - i128::from(*w));
            heap.push(Reverse((key(out.at(other), into.at(other)), other)));
        }
    }
    first.extend(last.into_iter().rev());
    first
}

/// Moves one function at a time to its cheapest position, as long as that reduces the cost.
fn improved(mut order: Vec<usize>, arcs: &[Arc]) -> Vec<usize> {
    let n = order.len();
    let near = arcs.iter().enumerate().flat_map(|(x, (a, b, _))| [(*a, x), (*b, x)]);
    let near = Lists::sort(n, near);
    for _ in 0..4 {
        let mut helped = false;
        for i in 0..n {
            let place = ByIndex::places(&order, n);
            let at = place.at(i);
            // Change of the cost when `i` moves past each function to which it gives values or from
            // which it takes them.
            let mut steps: BTreeMap<usize, i128> = BTreeMap::new();
            for (a, b, w) in near.at(i).iter().filter_map(|x| arcs.get(*x)) {
                let (other, w) = if *a == i { (*b, i128::from(*w)) } else { (*a, -i128::from(*w)) };
                *steps.entry(place.at(other)).or_default() += w;
            }
            let (mut best, mut to, mut sum) = (0, at, 0);
            for (p, w) in steps.range(at + 1..) {
                sum += w;
                if sum < best {
                    (best, to) = (sum, *p);
                }
            }
            sum = 0;
            for (p, w) in steps.range(..at).rev() {
                sum -= w;
                if sum < best {
                    (best, to) = (sum, *p);
                }
            }
            if to != at {
                let moved = order.remove(at);
                order.insert(to, moved);
                helped = true;
            }
        }
        if !helped {
            break;
        }
    }
    order
}

/// Returns the functions in the user's order, except that each comes after those from which it
/// takes values.
fn pulled(n: usize, arcs: &[(usize, usize)]) -> Vec<usize> {
    let mut takes = Lists::sort(n, arcs.iter().map(|(a, b)| (*b, *a)));
    takes.each(|list| list.sort_unstable());
    after(0..n, n, &takes)
}

/// As [`pulled`], from the end: each function comes before those to which it gives values.
fn pushed(n: usize, arcs: &[(usize, usize)]) -> Vec<usize> {
    let mut gives = Lists::sort(n, arcs.iter().map(|(a, b)| (*a, *b)));
    gives.each(|list| list.sort_unstable_by_key(|i| Reverse(*i)));
    let mut order = after((0..n).rev(), n, &gives);
    order.reverse();
    order
}

/// Returns all functions, each after those in its list.
fn after(all: impl Iterator<Item = usize>, n: usize, lists: &Lists) -> Vec<usize> {
    let mut order = Vec::with_capacity(n);
    let mut seen = ByIndex::of(n, false);
    let mut stack: Vec<(usize, usize)> = Vec::new();
    for root in all {
        if !seen.at(root) {
            seen.set(root, true);
            stack.push((root, 0));
        }
        while let Some((i, next)) = stack.pop() {
            match lists.at(i).get(next) {
                Some(&j) => {
                    stack.push((i, next + 1));
                    if !seen.at(j) {
                        seen.set(j, true);
                        stack.push((j, 0));
                    }
                }
                None => order.push(i),
            }
        }
    }
    order
}

fn to_u32(i: usize) -> u32 {
    u32::try_from(i).unwrap_or(u32::MAX)
}
