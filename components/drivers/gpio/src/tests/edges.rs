//! Encoders and counters from edges.

use super::{
    MS,
    fake::{Memory, load, named},
};
use crate::gpio::HalGpio;
use hal_bench::{Bench, trace::replay};
use port::{LineEdge, Lines, RecordedLines, ReplayedLines};
use std::sync::Arc;

#[test]
fn quadrature_on_simulated_lines() {
    let rows = replay::<HalGpio>(
        "load hal_gpio encoders=A:B
         set hal_gpio.encoder.0.position-scale 4
         run hal_gpio.capture-position
         in hal_gpio.sim.A hal_gpio.sim.B
         out hal_gpio.encoder.0.rawcounts hal_gpio.encoder.0.position
         0 0 | 0 0
         1 0 | 1 0.25
         1 1 | 2 0.5
         0 1 | 3 0.75
         0 0 | 4 1
         0 1 | 3 0.75
         1 1 | 2 0.5
         1 0 | 1 0.25
         0 0 | 0 0
         0 1 | -1 -0.25
         1 1 | -2 -0.5
         1 1 | -2 -0.5
         # Both at once: the kernel notes one before the other, here A.
         0 0 | 0 0
         set hal_gpio.encoder.0.position-scale -4
         1 0 | 1 -0.25
         set hal_gpio.encoder.0.position-scale 0
         . . | 1 1
         expect hal_gpio.encoder.0.position-scale 1
         load hal_gpio encoders=A
         run hal_gpio.capture-position
         in hal_gpio.sim.A hal_gpio.encoder.0.reset
         out hal_gpio.encoder.0.rawcounts hal_gpio.encoder.0.counts
         1 0 | 1 1
         0 0 | 1 1
         1 0 | 2 2
         0 1 | 2 0
         1 1 | 3 0
         0 0 | 3 0
         1 0 | 4 1",
    );
    assert_eq!(rows, 22);
}

/// The index makes the position zero at its own edge, in the middle of the others, once.
#[test]
fn the_index_is_where_it_came() {
    let (bench, lines) = encoder("A:B:Z");
    bench.set("hal_gpio.encoder.0.index-enable", true);
    let turn = [(0, true), (1, true), (2, true), (0, false), (2, false), (1, false)];
    send(&lines, &turn.map(|(bit, rising)| (10_000, bit, rising)), 1);
    bench.run("hal_gpio.capture-position", MS);
    let counts =
        || ["rawcounts", "counts"].map(|n| bench.get::<i32>(&format!("hal_gpio.encoder.0.{n}")));
    assert_eq!((counts(), bench.get("hal_gpio.encoder.0.index-enable")), ([4, 2], false));
    send(&lines, &turn.map(|(bit, rising)| (10_000, bit, rising)), 7);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!(counts(), [8, 6], "the second index is not asked for");
}

/// A thousand edges a second for a minute arrive, whatever the period of the function, and none is lost.
#[test]
fn a_thousand_edges_a_second_for_a_minute() {
    for runs_a_second in [1, 10, 1000] {
        let (bench, lines) = encoder("A:B");
        let (mut number, mut at) = (0, 0);
        for _ in 0..60 * runs_a_second {
            let edges: Vec<_> = (0..1000 / runs_a_second)
                .map(|n| {
                    at += 1_000_000;
                    let edge =
                        [(0, true), (1, true), (0, false), (1, false)][(number + n) as usize % 4];
                    (at, edge.0, edge.1)
                })
                .collect();
            send(&lines, &edges, number + 1);
            number += 1000 / runs_a_second;
            bench.run("hal_gpio.capture-position", 1_000_000_000 / i64::from(runs_a_second));
        }
        let pin = |name: &str| bench.get::<i32>(&format!("hal_gpio.encoder.0.{name}"));
        assert_eq!((pin("counts"), lost(&bench)), (60_000, [0, 0]), "{runs_a_second}");
        assert!((bench.get::<f64>("hal_gpio.encoder.0.velocity") - 1000.0).abs() < 1e-6);
        assert!((bench.get::<f64>("hal_gpio.encoder.0.period") - 0.004).abs() < 1e-12);
        assert_eq!(bench.said(), [""; 0]);
    }
}

#[test]
fn edges_that_the_kernel_lost_are_counted_and_reported() {
    let (bench, lines) = encoder("A");
    send(&lines, &[(1, 0, true), (2, 0, false)], 1);
    bench.run("hal_gpio.capture-position", MS);
    send(&lines, &[(9, 0, true)], 10);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!(lost(&bench), [7, 0]);
    let said = bench.said();
    assert!(
        said.len() == 1 && said[0].starts_with("7 edges of hal_gpio.encoder.0 were lost"),
        "{said:?}"
    );
    // The kernel's numbers begin with 1: the first ones may be missing, and they wrap.
    let (bench, lines) = encoder("A");
    send(&lines, &[(9, 0, true)], 4);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!(lost(&bench), [3, 0]);
    let (bench, lines) = encoder("A");
    send(&lines, &[(9, 0, true)], u32::MAX);
    send(&lines, &[(9, 0, false)], 0);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!(lost(&bench), [u32::MAX - 1, 0]);
}

/// An edge to the level that a line has counts nothing.
#[test]
fn repeated_edges_are_not_counted() {
    let (bench, lines) = encoder("A:B");
    send(&lines, &[(1, 0, false), (2, 0, true), (3, 0, true), (4, 1, true), (5, 1, true)], 1);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!((bench.get("hal_gpio.encoder.0.counts"), lost(&bench)), (2, [0, 3]));
}

/// Lines that are active when they are requested count nothing for that, and the first edge counts from there: with B
/// high, a rise of A is backward.
#[test]
fn the_first_levels_are_no_edges() {
    let chips = named(&["A", "B"]);
    let mut bench = Bench::new().with_hardware();
    chips_high(&chips);
    load(&mut bench, &chips, &["encoders=A:B"]).unwrap();
    let lines = chips.requested.lock().unwrap()[0].1.clone();
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!(bench.get::<i32>("hal_gpio.encoder.0.counts"), 0);
    send(&lines, &[(5, 0, true)], 1);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!((bench.get::<i32>("hal_gpio.encoder.0.counts"), lost(&bench)), (-1, [0, 0]));
}

/// Speed by the times of the edges: exact between edges that lie unevenly in the periods, falling while none comes, and
/// 0 below the lowest speed.
#[test]
fn speed_follows_from_the_times_of_the_edges() {
    let (bench, lines) = encoder("A");
    bench.set("hal_gpio.encoder.0.position-scale", 10.0);
    let mut speeds = Vec::new();
    let rows: [&[u64]; 6] = [&[100], &[200, 300], &[], &[600], &[], &[]];
    let mut number = 1;
    for row in rows {
        let edges: Vec<_> = row
            .iter()
            .flat_map(|at| [(at * 10_000, 0, true), (at * 10_000 + 5, 0, false)])
            .collect();
        send(&lines, &edges, number);
        number += u32::try_from(edges.len()).unwrap();
        bench.run("hal_gpio.capture-position", 2 * MS);
        speeds.push(bench.get::<f64>("hal_gpio.encoder.0.velocity"));
    }
    // 1 count each ms is 100 units a second; then one in 3 ms, of which nothing came for 2 and 4 ms.
    for (speed, wanted) in speeds.iter().zip([0.0, 100.0, 50.0, 100.0 / 3.0, 100.0 / 3.0, 25.0]) {
        assert!((speed - wanted).abs() < 1e-9, "{speeds:?}");
    }
    bench.run("hal_gpio.capture-position", 96 * MS);
    assert!((bench.get::<f64>("hal_gpio.encoder.0.velocity") - 1.0).abs() < 1e-9);
    bench.run("hal_gpio.capture-position", MS);
    assert_eq!(bench.get::<f64>("hal_gpio.encoder.0.velocity"), 0.0);
    for bad in [0.0, -1.0, f64::NAN] {
        bench.set("hal_gpio.encoder.0.min-speed-estimate", bad);
        bench.run("hal_gpio.capture-position", MS);
        assert_eq!(bench.get::<f64>("hal_gpio.encoder.0.min-speed-estimate"), 1.0);
    }
}

/// A backward speed falls toward 0 while no edge comes.
#[test]
fn a_backward_speed_stays_backward() {
    let (bench, lines) = encoder("A:B");
    send(&lines, &[(1_000_000, 1, true)], 1);
    bench.run("hal_gpio.capture-position", MS);
    send(&lines, &[(2_000_000, 0, true)], 2);
    bench.run("hal_gpio.capture-position", MS);
    assert!((bench.get::<f64>("hal_gpio.encoder.0.velocity") + 1000.0).abs() < 1e-9);
    bench.run("hal_gpio.capture-position", 4 * MS);
    assert!((bench.get::<f64>("hal_gpio.encoder.0.velocity") + 250.0).abs() < 1e-9);
}

/// A recording has each call with its answer, and can be read again.
#[test]
fn a_recording_replays() {
    let (bench, lines) = encoder("A:B");
    send(&lines, &[(1000, 0, true), (2000, 1, true), (3000, 0, false)], 1);
    bench.run("hal_gpio.capture-position", MS);
    let tape = lines.text();
    assert_eq!(tape, "read 3 = 0\nedges 1000:0:1:1 2000:1:1:2 3000:0:0:3\n");
    let replayed = ReplayedLines::new(&tape).unwrap();
    let mut room = [LineEdge::default(); 64];
    assert_eq!((replayed.read(3), replayed.edges(&mut room), replayed.left()), (Ok(0), Ok(3), 0));
}

fn lost(bench: &Bench) -> [u32; 2] {
    ["lost", "repeated"].map(|name| bench.get(&format!("hal_gpio.encoder.0.{name}")))
}

fn chips_high(chips: &super::fake::FakeChips) {
    *chips.initial.lock().unwrap() = 0b10;
}

/// Returns a bench with one encoder on a fake chip, and its lines.
fn encoder(lines: &str) -> (Bench, Arc<RecordedLines<Memory>>) {
    let chips = named(&["A", "B", "Z"]);
    let mut bench = Bench::new().with_hardware();
    load(&mut bench, &chips, &[&format!("encoders={lines}")]).unwrap();
    let lines = chips.requested.lock().unwrap()[0].1.clone();
    (bench, lines)
}

/// Adds edges with the kernel's numbers from `first`.
fn send(lines: &RecordedLines<Memory>, edges: &[(u64, u8, bool)], first: u32) {
    let edges = (0..).zip(edges).map(|(n, (at_ns, bit, is_rising))| LineEdge {
        at_ns: *at_ns,
        number: first.wrapping_add(n),
        bit: *bit,
        is_rising: *is_rising,
    });
    lines.inner().waiting.lock().unwrap().extend(edges);
}
