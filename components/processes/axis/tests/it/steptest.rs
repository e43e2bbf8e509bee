//! Tests of `steptest` beyond the recorded runs.

#![expect(clippy::unwrap_used, reason = "tests")]

use axis::Steptest;
use hal_bench::Bench;

const NS: i64 = 1_000_000;

fn bench() -> Bench {
    let mut bench = Bench::new();
    bench.load::<Steptest>(&[]).unwrap();
    bench.set("steptest.0.amplitude", 3.0);
    bench.set("steptest.0.maxvel", 10.0);
    bench
}

/// Returns the commanded position with the axis at `at`.
fn at(bench: &Bench, at: f64) -> f64 {
    bench.set("steptest.0.position-fb", at);
    bench.run("steptest.0", NS);
    bench.get("steptest.0.position-cmd")
}

#[test]
fn pins_and_parameters() {
    let expected = "amplitude float IN|dir s32 IN|elapsed float RO|epsilon float RW|\
        jog-minus bit IN|jog-plus bit IN|maxaccel float IN|maxvel float IN|pause s32 IN|\
        position-cmd float OUT|position-fb float IN|run bit IN|run-high float OUT|\
        run-low float OUT|run-start float OUT|run-target float OUT|running bit OUT";
    let names = bench().names();
    let names: Vec<_> = names.iter().map(|n| n.strip_prefix("steptest.0.").unwrap()).collect();
    assert_eq!(names, expected.split('|').collect::<Vec<_>>());
    assert_eq!(bench().get::<f64>("steptest.0.epsilon"), 0.001);
}

#[test]
fn both_ways_of_a_jog_go_backward() {
    let bench = bench();
    for (plus, minus, cmd) in
        [(false, false, 5.0), (true, false, 5.02), (false, true, 4.98), (true, true, 4.98)]
    {
        bench.set("steptest.0.jog-plus", plus);
        bench.set("steptest.0.jog-minus", minus);
        assert_eq!(at(&bench, 5.0), cmd, "{plus} {minus}");
    }
}

#[test]
fn an_end_counts_only_within_epsilon() {
    for (epsilon, near, leaves) in [
        (0.001, -2.9995, true),
        (0.001, -2.998, false),
        (0.5, -2.6, true),
        (0.0, -3.0, false),
        (f64::NAN, -3.0, false),
    ] {
        let bench = bench();
        bench.set("steptest.0.epsilon", epsilon);
        bench.set("steptest.0.run", true);
        assert_eq!(at(&bench, 0.0), -3.0);
        at(&bench, near);
        assert_eq!(at(&bench, near) == 3.0, leaves, "{epsilon} {near}");
    }
}

#[test]
fn a_run_waits_at_its_ends_and_goes_home() {
    let bench = bench();
    bench.set("steptest.0.run", true);
    bench.set("steptest.0.pause", 1);
    assert_eq!(at(&bench, 2.0), -1.0);
    let waits = (0..2000).take_while(|_| at(&bench, -1.0) == -1.0).count();
    assert!((1000..=1001).contains(&waits), "a second, not {waits} ms");
    assert_eq!(at(&bench, 0.0), 5.0);
    bench.set("steptest.0.run", false);
    assert_eq!(at(&bench, 0.0), 2.0);
    assert!(bench.get::<bool>("steptest.0.running"));
    at(&bench, 2.0);
    assert!(!bench.get::<bool>("steptest.0.running"));
}
