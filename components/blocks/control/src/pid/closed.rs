//! Test of `pid` against its equation: each term alone, and loops with plants whose discrete response is a sum of
//! powers of the loop's poles.

#![expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "how many poles")]

use super::Pid;
use hal_bench::Bench;
use nalgebra::{Complex, DMatrix, DVector};

const NS: i64 = 1_000_000;
const DT: f64 = 0.001;

/// Returns a loop without gains, with the error against the present command.
fn bench(set: &[(&str, f64)]) -> Bench {
    let mut bench = Bench::new();
    bench.load::<Pid>(&["names=x", "debug=1"]).unwrap();
    bench.set("x.error-previous-target", false);
    bench.set("x.Pgain", 0.0);
    for (name, value) in set {
        bench.set(&format!("x.{name}"), *value);
    }
    bench.set("x.enable", true);
    bench
}

fn run(bench: &Bench, command: f64, feedback: f64) -> f64 {
    bench.set("x.command", command);
    bench.set("x.feedback", feedback);
    bench.run("x.do-pid-calcs", NS);
    bench.get("x.output")
}

#[track_caller]
fn near(is: f64, wanted: f64, bound: f64) {
    assert!((is - wanted).abs() <= bound, "{is}, not {wanted} within {bound}");
}

#[test]
fn parts_without_memory() {
    for (part, command, feedback, wanted) in [
        (&[("Pgain", 7.5)][..], 3.0, 1.0, 15.0),
        (&[("FF0", -2.0)], 3.0, 1.0, -6.0),
        (&[("bias", 0.75)], 3.0, 1.0, 0.75),
        (&[("Pgain", 2.0), ("deadband", 0.5)], 3.0, 1.0, 3.0),
        (&[("Pgain", 2.0), ("deadband", 0.5)], 1.0, 3.0, -3.0),
        (&[("Pgain", 2.0), ("deadband", 2.0)], 1.0, 3.0, 0.0),
        (&[("Pgain", 2.0), ("maxerror", 0.25)], 1.0, 3.0, -0.5),
        (&[("Pgain", 2.0), ("maxoutput", 3.5)], 3.0, 1.0, 3.5),
        (&[("Pgain", 2.0), ("maxoutput", 3.5)], 1.0, 3.0, -3.5),
    ] {
        assert_eq!(run(&bench(part), command, feedback), wanted, "{part:?}");
    }
}

/// The integral of a constant error e is e·t, up to its limit.
#[test]
fn the_integral_is_a_ramp() {
    for most in [0.0, 0.25] {
        let bench = bench(&[("Igain", 4.0), ("maxerrorI", most)]);
        for n in 1..=1000 {
            let t = f64::from(n) * DT;
            let integral = if most > 0.0 { (2.0 * t).min(most) } else { 2.0 * t };
            // One rounding per cycle of a sum that is at most 2.
            near(run(&bench, 3.0, 1.0), 4.0 * integral, 4.0 * f64::from(n) * 2.0 * f64::EPSILON);
        }
    }
}

/// Backward differences: for c·t it is c, for a·t²/2 it is a·(t - T/2), and the second and third ones of a·t²/2 and
/// j·t³/6 are a and j.
#[test]
fn derivatives_of_powers_of_time() {
    // Two roundings of the operands, in two, four or eight terms, larger by 1/T with each order.
    let rounded = |x: f64, order: i32| f64::EPSILON * (2.0 / DT).powi(order) * (2.0 * x.abs());
    let (c, a, j) = (3.7, 12.5, -40.0);
    for feedback_moves in [false, true] {
        let bench = bench(&[("Dgain", 2.0)]);
        for n in 0..500 {
            let t = f64::from(n) * DT;
            let (ramp, parabola) = (c * t, 0.5 * a * t * t);
            let (command, feedback) =
                if feedback_moves { (ramp, parabola) } else { (parabola, 0.0) };
            let is = run(&bench, command, feedback);
            let bent = a * (t - DT / 2.0);
            let wanted = if feedback_moves { c - bent } else { bent };
            if n > 0 {
                let bound =
                    rounded(command.abs() + feedback.abs(), 1) + 4.0 * f64::EPSILON * wanted.abs();
                near(is, 2.0 * wanted, 2.0 * bound);
            }
        }
    }
    let forward = [("FF1", 0.5), ("FF2", 0.25), ("FF3", 0.125)];
    for (order, (name, gain)) in (1..).zip(forward) {
        let bench = bench(&[(name, gain)]);
        for n in 0..500 {
            let t = f64::from(n) * DT;
            let (command, wanted) = match order {
                1 => (c * t, c),
                2 => (0.5 * a * t * t, a),
                // The other derivatives of T·n·(n - 1)·(n - 2)/6 vanish at its start.
                _ => (j * t * (t - DT) * (t - 2.0 * DT) / 6.0, j),
            };
            let is = run(&bench, command, 0.0);
            if n > 3 {
                let bound = rounded(command, order) + 4.0 * f64::EPSILON * wanted.abs();
                near(is, gain * wanted, gain * bound);
            }
        }
    }
}

/// At its limit the output freezes the integral; as soon as the error changes sign, the output returns without first
/// unwinding what would have been added meanwhile.
#[test]
fn the_integral_does_not_wind_up() {
    let bench = bench(&[("Igain", 7.9), ("maxoutput", 1.0)]);
    // 7.9·n·T first exceeds 1 after 127 cycles.
    for n in 1..=5000 {
        let is = run(&bench, 1.0, 0.0);
        near(is, (7.9 * f64::from(n) * DT).min(1.0), 127.0 * 2.0 * f64::EPSILON);
        assert_eq!(bench.get::<bool>("x.saturated"), n >= 127, "run {n}");
    }
    near(bench.get("x.errorI"), 0.127, 127.0 * f64::EPSILON);
    near(bench.get("x.saturated-s"), 4.874, 4874.0 * 5.0 * f64::EPSILON);
    for n in 1..=200 {
        let wanted = 7.9 * (0.127 - f64::from(n) * DT);
        near(run(&bench, -1.0, 0.0), wanted, 400.0 * f64::EPSILON);
    }
}

/// Returns the first element of the response x[n+1] = M·x[n] + b from x[0] = 0: a constant and powers of the poles,
/// with weights from the first samples.
fn answer(m: &DMatrix<f64>, b: &DVector<f64>) -> (f64, impl Fn(i32) -> f64, f64) {
    let order = m.nrows();
    let rest = (DMatrix::identity(order, order) - m).lu().solve(b).unwrap();
    let poles = m.complex_eigenvalues();
    let mut x = DVector::zeros(order);
    let mut first = DVector::zeros(order);
    for n in 0..order {
        first[n] = Complex::from(x[0] - rest[0]);
        x = m * x + b;
    }
    let powers = DMatrix::from_fn(order, order, |n, pole| poles[pole].powi(n as i32));
    let weights = powers.lu().solve(&first).unwrap();
    let slowest = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let fading = move |n: i32| {
        poles.iter().zip(weights.iter()).map(|(p, w)| p.powi(n) * w).sum::<Complex<f64>>().re
    };
    (rest[0], move |n| rest[0] + fading(n), slowest)
}

/// First-order lag y[n+1] = a·y[n] + b·u[n] with u from the loop.
#[test]
fn a_lag_answers_with_the_poles_of_the_loop() {
    let (a, b) = (0.98, 0.04);
    let command = 1.5;
    for (p, i, d) in
        [(4.0, 0.0, 0.0), (20.0, 0.0, 0.0), (4.0, 60.0, 0.0), (2.0, 400.0, 0.0), (6.0, 90.0, 0.004)]
    {
        // The state is y, the previous y, and the integral, which includes the present error.
        let m = DMatrix::from_row_slice(
            3,
            3,
            &[a - b * (p + i * DT + d / DT), b * d / DT, b * i, 1.0, 0.0, 0.0, -DT, 0.0, 1.0],
        );
        let given = DVector::from_row_slice(&[b * (p + i * DT) * command, 0.0, DT * command]);
        // Without I, the integral is a separate state that never settles.
        let (m, given) = if i == 0.0 {
            (m.view((0, 0), (2, 2)).into_owned(), given.rows(0, 2).into_owned())
        } else {
            (m, given)
        };
        let (m, given) = if d == 0.0 {
            (m.clone().remove_row(1).remove_column(1), given.remove_row(1))
        } else {
            (m, given)
        };
        let (rest, wanted, slowest) = answer(&m, &given);
        // With the plant's gain G = b/(1 - a), P alone leaves r/(1 + P·G); with I, nothing remains.
        let left = if i == 0.0 { command / (1.0 + p * b / (1.0 - a)) } else { 0.0 };
        near(command - rest, left, 1e-12);
        let bench = bench(&[("Pgain", p), ("Igain", i), ("Dgain", d)]);
        // The step of the command happens before the loop is enabled.
        bench.set("x.enable", false);
        run(&bench, command, 0.0);
        bench.set("x.enable", true);
        let mut y = 0.0;
        for n in 0..2000 {
            // About ten roundings of the output per cycle, which decay with the slowest pole; the weights have the
            // rounding of the matrix of powers.
            let bound = 100.0 * f64::EPSILON * (p + d / DT) / (1.0 - slowest);
            near(y, wanted(n), bound);
            y = a * y + b * run(&bench, command, y);
        }
        near(command - y, left, 1e-9);
    }
}

/// Integrator y[n+1] = y[n] + T·u[n]: the response to a step is 1 - (1 - P·T)^n; a ramp of speed v has a lag of v/P, or
/// none with `FF1` = 1.
#[test]
fn an_integrator_answers_steps_and_ramps() {
    for p in [5.0, 50.0, 400.0] {
        let bound = 10.0 * f64::EPSILON * p / (p * DT);
        let loop_ = bench(&[("Pgain", p)]);
        let mut y = 0.0;
        for n in 0..2000 {
            near(y, 2.0 * (1.0 - (1.0 - p * DT).powi(n)), bound);
            y += DT * run(&loop_, 2.0, y);
        }
        for (forward, previous, lag) in
            [(0.0, false, 1.0), (1.0, false, 0.0), (1.0, true, 0.0), (0.0, true, 1.0)]
        {
            let speed = 3.0;
            let bench = bench(&[("Pgain", p), ("FF1", forward)]);
            bench.set("x.error-previous-target", previous);
            let mut y = 0.0;
            for n in 0..10_000 {
                let command = speed * f64::from(n) * DT;
                let out = run(&bench, command, y);
                if n == 9999 {
                    // The error is computed against the command that the feedback responds to.
                    let is: f64 = bench.get("x.error");
                    let rounding =
                        10.0 * command * f64::EPSILON / (p * DT) * (1.0 + 1.0 / (p * DT));
                    near(is, lag * speed / p, rounding + 2.0 * speed / p * (1.0 - p * DT).powi(n));
                }
                y += DT * out;
            }
        }
    }
}
