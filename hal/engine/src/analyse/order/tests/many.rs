//! Large machines and random ones.

use super::{By, Flow, FlowGraph, Funct, Ix, Study, Thread, Timed};

#[test]
fn ten_thousand_functions() {
    let n = 10_000;
    let mut machine = FlowGraph::default();
    let order: Vec<usize> = (0..n).collect();
    for i in 0..n {
        machine.functs.push(Funct {
            ix: Ix::new(i),
            edge: None,
            owner: Some(Ix::new(i)),
            thread: 0,
            unknown: false,
            drives: false,
            told: false,
        });
    }
    machine.threads.push(Thread { ix: Ix::new(n), period: 1000, order });
    // A chain backwards through all functions, and from every seventh a flow a hundred functions
    // forward.
    for i in 0..n {
        let by = vec![By::Signal(Ix::new(i))];
        if i > 0 {
            machine.flows.push(Flow { from: i, to: i - 1, by: by.clone(), numbers: true });
        }
        if i % 7 == 0 && i + 100 < n {
            machine.flows.push(Flow { from: i, to: i + 100, by, numbers: true });
        }
    }
    let study = Study::new(machine);
    let before = study.late().len();
    let better = study.as_better();
    let after = study.machine.flows.iter().filter(|f| better.is_late(f)).count();
    assert_eq!(before, n - 1);
    assert!(after <= n / 7 + 1, "{after}");
    assert!(!study.as_added().loops().list.is_empty());
    study.as_added().paths();
}

/// For all flows, the better order contains the same functions and costs no more than the user's.
/// Without loops it costs nothing.
#[test]
fn random_machines() {
    let mut seed = 7_u64;
    let mut next = |below: usize| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(seed >> 33).unwrap() % below
    };
    for round in 0..300 {
        let n = 2 + next(30);
        let threads = 1 + next(3);
        let mut machine = FlowGraph::default();
        for t in 0..threads {
            let period = 50 * (1 + next(5)) as u64 * (t as u64 + 1);
            machine.threads.push(Thread { ix: Ix::new(t), period, order: Vec::new() });
        }
        for i in 0..n {
            let thread = next(threads);
            machine.threads[thread].order.push(i);
            machine.functs.push(Funct {
                ix: Ix::new(i),
                edge: None,
                owner: Some(Ix::new(next(n))),
                thread,
                unknown: false,
                drives: next(5) == 0,
                told: next(5) == 0,
            });
        }
        let acyclic = round % 2 == 0;
        let rank: Vec<usize> = (0..n).map(|_| next(1000)).collect();
        let mut flows: Vec<(usize, usize)> = (0..next(3 * n)).map(|_| (next(n), next(n))).collect();
        flows.sort_unstable();
        flows.dedup();
        flows.retain(|(a, b)| a != b && (!acyclic || (rank[*a], a) < (rank[*b], b)));
        for (from, to) in flows {
            let by = (0..=next(2)).map(|i| By::Signal(Ix::new(i))).collect();
            machine.flows.push(Flow { from, to, by, numbers: true });
        }
        let study = Study::new(machine);
        let late = |timed: &Timed<'_>| -> u64 {
            study.machine.flows.iter().filter(|f| timed.is_late(f)).map(Flow::weight).sum()
        };
        let (user, better) = (late(&study.as_added()), late(&study.as_better()));
        assert!(better <= user);
        assert!(!acyclic || better == 0);
        for (t, thread) in study.machine.threads.iter().enumerate() {
            let sort = |list: &[usize]| {
                let mut list = list.to_vec();
                list.sort_unstable();
                list
            };
            assert_eq!(sort(&study.better[t]), sort(&thread.order));
            // The moves lead to the better order.
            let moves = study.moves(t);
            let mut order = thread.order.clone();
            order.retain(|f| moves.iter().all(|m| m.funct != *f));
            moves.iter().for_each(|m| order.insert(m.position - 1, m.funct));
            assert_eq!(order, study.better[t]);
        }
        let timed = study.as_added();
        let loops = timed.loops().list;
        assert!(!acyclic || loops.is_empty());
        for l in &loops {
            assert_eq!(l.wait, timed.along(&l.flows));
            assert!(l.wait.most > 0, "a loop without delay");
        }
        for p in timed.paths().list {
            assert!(p.quickest.wait <= p.slowest.wait);
        }
    }
}
