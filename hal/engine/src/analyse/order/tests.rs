//! Tests with machines as text: `THREAD PERIOD: FUNCTS...` and `FROM SIGNAL TO...`.

mod loops;
mod many;

use super::{
    By, Flow, FlowGraph, Study, Timed,
    flow_graph::{Funct, Thread},
};
use crate::graph::Ix;
use std::fmt::Write;

struct Drawn {
    machine: FlowGraph,
    names: Vec<String>,
    signals: Vec<String>,
}

/// Parses a machine. `?name` is an unknown function, `!name` takes commands, `name@c` belongs to
/// component c. A flow by `~` is hidden and one by `<>signal` goes in both directions. `a|b` is a
/// pair whose order must not change.
fn draw(text: &str) -> Drawn {
    let mut d = Drawn { machine: FlowGraph::default(), names: Vec::new(), signals: Vec::new() };
    let mut owners: Vec<String> = Vec::new();
    for line in text.lines().map(str::trim).filter(|l| !l.is_empty()) {
        if let Some((head, functs)) = line.split_once(':') {
            let (_, period) = head.split_once(' ').unwrap();
            let mut order = Vec::new();
            for word in functs.split_whitespace() {
                let (word, owner) = word.split_once('@').unwrap_or((word, word));
                let name = word.trim_start_matches(['?', '!']);
                let at = owners.iter().position(|o| o == owner).unwrap_or(owners.len());
                if at == owners.len() {
                    owners.push(owner.to_owned());
                }
                order.push(d.names.len());
                d.machine.functs.push(Funct {
                    ix: Ix::new(d.names.len()),
                    edge: None,
                    owner: Some(Ix::new(1000 + at)),
                    thread: d.machine.threads.len(),
                    unknown: word.starts_with('?'),
                    drives: false,
                    told: word.starts_with('!'),
                });
                d.names.push(name.to_owned());
            }
            let ix = Ix::new(2000 + d.machine.threads.len());
            d.machine.threads.push(Thread { ix, period: period.parse().unwrap(), order });
            continue;
        }
        let number = |name: &str| d.names.iter().position(|n| n == name).unwrap();
        if let Some((a, b)) = line.split_once('|') {
            d.machine.fixed.push((number(a), number(b)));
            continue;
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let signal = Ix::new(d.signals.len());
        d.signals.push(words[1].to_owned());
        for to in &words[2..] {
            let (from, to) = (number(words[0]), number(to));
            let by = match words[1] {
                "~" => By::Hidden,
                w if w.starts_with("<>") => By::Shared(signal),
                _ => By::Signal(signal),
            };
            let ways = if matches!(by, By::Shared(_)) {
                vec![(from, to), (to, from)]
            } else {
                vec![(from, to)]
            };
            for (from, to) in ways {
                let flows = &mut d.machine.flows;
                match flows.iter_mut().find(|f| (f.from, f.to) == (from, to)) {
                    Some(flow) => flow.by.push(by),
                    None => flows.push(Flow { from, to, by: vec![by], numbers: true }),
                }
            }
        }
    }
    d.machine.flows.sort_by_key(|f| (f.from, f.to));
    d
}

fn chain(d: &Drawn, study: &Study, flows: &[usize]) -> String {
    let mut text = String::new();
    for (i, x) in flows.iter().enumerate() {
        let flow = &study.machine.flows[*x];
        if i == 0 {
            text.push_str(&d.names[flow.from]);
        }
        write!(text, " {}", d.names[flow.to]).unwrap();
    }
    text
}

/// Formats the results of the analysis as lines.
fn said(text: &str) -> String {
    let d = draw(text);
    let study = Study::new(d.machine.clone());
    let name = |i: &usize| d.names[*i].as_str();
    let mut out = String::new();
    for (t, thread) in study.machine.threads.iter().enumerate() {
        let better = &study.better[t];
        if *better != thread.order {
            let names: Vec<&str> = better.iter().map(name).collect();
            writeln!(out, "better {}", names.join(" ")).unwrap();
            for m in study.moves(t) {
                writeln!(out, "move {} {}", name(&m.funct), m.position).unwrap();
            }
        }
    }
    for late in study.late() {
        let flow = &study.machine.flows[late.flow];
        let remains = if late.remains { ", remains" } else { "" };
        writeln!(out, "late {} {}{remains}", name(&flow.from), name(&flow.to)).unwrap();
    }
    let user: Timed<'_> = study.as_added();
    for l in study.as_added().loops().list {
        writeln!(out, "loop {}: {}..{}", chain(&d, &study, &l.flows), l.wait.least, l.wait.most)
            .unwrap();
    }
    for p in user.paths().list {
        let mut line = format!(
            "path {}: {}..{}",
            chain(&d, &study, &p.quickest.flows),
            p.quickest.wait.least,
            p.quickest.wait.most
        );
        if p.slowest.flows != p.quickest.flows {
            write!(
                line,
                ", {}: {}..{}",
                chain(&d, &study, &p.slowest.flows),
                p.slowest.wait.least,
                p.slowest.wait.most
            )
            .unwrap();
        }
        writeln!(out, "{line}").unwrap();
    }
    out
}

fn check(text: &str, want: &str) {
    let want: String = want.lines().map(|l| format!("{}\n", l.trim())).collect();
    let want = want.trim_start_matches('\n');
    assert_eq!(said(text), want, "{text}");
}

#[test]
fn an_order_that_loses_nothing_is_left_alone() {
    check(
        "t 1000: a b c
           a x b
           b y c",
        "path a b c: 0..0",
    );
    check("t 1000: a b c", "");
    // A function between others that is independent of them stays there.
    check(
        "t 1000: a z b y c
           a x b
           b y c",
        "path a b c: 0..0",
    );
}

#[test]
fn a_chain_against_its_order_loses_a_cycle_for_each_step() {
    check(
        "t 1000: d c b a
           a x b
           b y c
           c z d",
        "better a b c d
           move a 1
           move b 2
           move c 3
           late a b
           late b c
           late c d
           path a b c d: 3000..3000",
    );
}

#[test]
fn only_what_must_move_moves() {
    check(
        "t 1000: write a b c read
           read x a
           a y b
           c z write",
        "better c write read a b
           move c 1
           move read 3
           late c write
           late read a
           path c write: 1000..1000
           path read a b: 1000..1000",
    );
}

#[test]
fn values_wait_for_the_cycle_of_another_thread() {
    check(
        "base 50: read pulses@step write
           servo 1000: capture@step control freq@step
           read in control
           control cmd freq
           freq ~ pulses
           pulses ~ capture
           capture fb control
           pulses step write",
        "
           loop capture control freq pulses capture: 1000..1000
           path read control freq pulses write: 50..1000",
    );
    // Periods that are not multiples of each other.
    check(
        "base 40: a
           servo 100: b
           a x b",
        "path a b: 0..80",
    );
    check(
        "base 40: a
           servo 100: b
           b x a",
        "path b a: 20..40",
    );
    // Of two threads with the same period, the older one runs first.
    check(
        "one 100: a
           two 100: b
           a x b",
        "path a b: 0..0",
    );
    check(
        "one 100: a
           two 100: b
           b x a",
        "path b a: 100..100",
    );
}

#[test]
fn the_way_that_takes_longest_is_told_as_well() {
    check(
        "t 1000: in mix slow out
           in a mix
           in b slow
           slow c mix
           mix d out",
        "better in slow mix out
           move slow 2
           late slow mix
           path in mix out: 0..0, in slow mix out: 1000..1000",
    );
}

#[test]
fn a_function_that_takes_commands_begins_a_path() {
    check(
        "t 1000: capture@step !control freq@step
           control cmd freq
           freq ~ capture
           capture fb control",
        "
           late freq capture, remains
           loop capture control freq capture: 1000..1000",
    );
    check(
        "t 1000: !control drive plant write
           control cmd drive
           drive v plant
           plant fb control
           plant p write",
        "
           late plant control, remains
           loop control drive plant control: 1000..1000
           path control drive plant write: 0..0",
    );
}

#[test]
fn what_nobody_knows_stays_where_it_is() {
    // Without the unknown function, the better order would be `a b`.
    check(
        "t 1000: b ?u a
           b|u
           u|a
           a x b",
        "late a b, remains
           path a b: 1000..1000",
    );
    check(
        "t 1000: b a ?u
           a|u
           a x b",
        "better a b u
           move a 1
           late a b
           path a b: 1000..1000",
    );
}
