//! Feedback loops, and the better order that keeps them short.

use super::{Study, check, draw, said};

#[test]
fn a_loop_is_cut_where_the_user_cuts_it() {
    for order in ["control drive plant", "drive plant control", "plant control drive"] {
        let text = format!(
            "t 1000: {order}
            control x drive
            drive y plant
            plant z control"
        );
        let said = said(&text);
        assert!(!said.contains("better"), "{said}");
        assert_eq!(said.matches("remains").count(), 1, "{said}");
        assert_eq!(said.matches("loop").count(), 1, "{said}");
        assert!(said.contains(": 1000..1000"), "{said}");
    }
}

#[test]
fn a_loop_that_is_cut_twice_is_cut_once() {
    check(
        "t 1000: plant drive control
           control x drive
           drive y plant
           plant z control",
        "better drive plant control
           move drive 1
           late drive plant
           late control drive, remains
           loop plant control drive plant: 2000..2000",
    );
}

#[test]
fn a_loop_is_cut_where_it_costs_least() {
    // Three values go forward and one back, so the one back is late.
    check(
        "t 1000: b a
           a x b
           a y b
           a z b
           b fb a",
        "better a b
           move a 1
           late a b
           loop b a b: 1000..1000",
    );
}

#[test]
fn a_handshake_is_a_loop_and_no_path() {
    check(
        "t 1000: encoder control
           encoder fb control
           encoder <>index control",
        "
           late control encoder, remains
           loop encoder control encoder: 1000..1000
           path encoder control: 0..0",
    );
}

/// The heavy values go backwards through a, b and c: the order c b a saves them a cycle each.
const BACKWARDS: &str =
    "servo 1000: a b c\na s1 b\nb s2 c\nc h1 b\nc h2 b\nc h3 b\nb h4 a\nb h5 a\nb h6 a\n";

#[test]
fn a_better_order_names_what_becomes_late() {
    let study = Study::new(draw(BACKWARDS).machine);
    assert_eq!(study.better, [[2, 1, 0]]);
    let flow = |i: &usize| (study.machine.flows[*i].from, study.machine.flows[*i].to);
    assert_eq!(study.later().iter().map(flow).collect::<Vec<_>>(), [(0, 1), (1, 2)]);
}

/// With a value from c to a, the loop through all three takes one cycle as added, and two in the order c b a.
#[test]
fn a_better_order_makes_no_loop_longer() {
    let study = Study::new(draw(&format!("{BACKWARDS}c s3 a\n")).machine);
    assert_eq!(study.better, [[0, 1, 2]]);
    assert!(study.later().is_empty());
    for chain in study.as_added().loops().list {
        assert!(study.as_better().along(&chain.flows) <= chain.wait);
    }
}
