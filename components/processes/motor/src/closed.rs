//! Test of Clarke's transforms against their definition (Clarke, "Circuit Analysis of A-C Power Systems", 1943): three
//! phases a third of a turn apart are a rotating vector, the common component is √2 times their mean, and a²+b²+c² is
//! 3/2 of x²+y²+h².

use crate::{clarke2::Clarke2, clarke3::Clarke3, clarkeinv::Clarkeinv};
use core::f64::consts::{SQRT_2, TAU};
use hal_bench::{Bench, Random};
use hal_component::Component;

/// Error bound of factors with 15 digits, and of the arithmetic.
const DIGITS: f64 = 4e-15;
/// Relative error of a full turn with ten digits.
const TURN: f64 = 1.4e-10;

struct Rig(Bench, &'static str);

impl Rig {
    fn new<C: Component>() -> Self {
        let mut bench = Bench::new();
        bench.load::<C>(&[]).unwrap();
        Self(bench, C::NAME)
    }

    fn of<const N: usize, const M: usize>(
        &self,
        given: [(&str, f64); N],
        names: [&str; M],
    ) -> [f64; M] {
        let Self(bench, name) = self;
        for (pin, value) in given {
            bench.set(&format!("{name}.0.{pin}"), value);
        }
        bench.run(&format!("{name}.0"), 1_000_000);
        names.map(|pin| bench.get(&format!("{name}.0.{pin}")))
    }
}

/// Returns three phases of an amplitude, at an angle in turns, around a common value.
fn phases(size: f64, turns: f64, common: f64) -> [f64; 3] {
    [0.0, 1.0, 2.0].map(|third| common + size * libm::cos(TAU * (turns - third / 3.0)))
}

#[track_caller]
fn near<const N: usize>(is: [f64; N], wanted: [f64; N], bound: f64) {
    for (a, b) in is.into_iter().zip(wanted) {
        assert!((a - b).abs() <= bound, "{is:?}, not {wanted:?}");
    }
}

#[test]
fn a_turning_field_is_a_vector_that_turns() {
    let (two, three) = (Rig::new::<Clarke2>(), Rig::new::<Clarke3>());
    let mut random = Random::new(1);
    for _ in 0..2000 {
        let (size, turns) = (random.scaled(1e-3, 1e3), random.between(-1.0, 1.0));
        let common = random.between(-1.0, 1.0) * size;
        let vector = [size * libm::cos(TAU * turns), size * libm::sin(TAU * turns)];
        let [a, b, _] = phases(size, turns, 0.0);
        near(two.of([("a", a), ("b", b)], ["x", "y"]), vector, DIGITS * size);
        let [a, b, c] = phases(size, turns, common);
        let is = three.of([("a", a), ("b", b), ("c", c)], ["x", "y", "h"]);
        near(is, [vector[0], vector[1], SQRT_2 * common], DIGITS * size);
    }
}

/// The inverse rotates by `theta`; power is preserved except for its factor.
#[test]
fn the_way_back_turns_and_undoes() {
    let (three, back) = (Rig::new::<Clarke3>(), Rig::new::<Clarkeinv>());
    let mut random = Random::new(2);
    for _ in 0..2000 {
        let (size, turns) = (random.scaled(1e-3, 1e3), random.between(-1.0, 1.0));
        let any = random.between(-3.0, 3.0);
        let theta = random.pick(&[0.0, 1.0, 0.25, -0.5, any]);
        let common = random.between(-1.0, 1.0) * size;
        let [a, b, c] = phases(size, turns, common);
        let [x, y, h] = three.of([("a", a), ("b", b), ("c", c)], ["x", "y", "h"]);
        let is = back.of([("x", x), ("y", y), ("h", h), ("theta", theta)], ["a", "b", "c"]);
        let bound = size * (3.0 * DIGITS + TAU * TURN * theta.abs());
        near(is, phases(size, turns + theta, common), bound);
        let power = |v: [f64; 3]| v.map(|n| n * n).iter().sum::<f64>();
        let (of_phases, of_vector) = (power(is), 1.5 * power([x, y, h]));
        assert!((of_phases - of_vector).abs() <= 20.0 * DIGITS * of_vector);
    }
}

/// Unbalanced phases have components that rotate in both directions (Fortescue, 1918): the vector is their sum, without
/// the common component.
#[test]
fn unbalanced_phases_are_the_sum_of_two_fields() {
    let three = Rig::new::<Clarke3>();
    let mut random = Random::new(3);
    for _ in 0..500 {
        let (forth, back) = (random.between(0.0, 5.0), random.between(0.0, 5.0));
        let (at, turned) = (random.between(0.0, 1.0), random.between(0.0, 1.0));
        let [a, b, c] = phases(forth, at, 0.0);
        // The negative sequence: b and c are exchanged.
        let [d, f, e] = phases(back, turned, 0.0);
        let is = three.of([("a", a + d), ("b", b + e), ("c", c + f)], ["x", "y", "h"]);
        let x = forth * libm::cos(TAU * at) + back * libm::cos(TAU * turned);
        let y = forth * libm::sin(TAU * at) - back * libm::sin(TAU * turned);
        near(is, [x, y, 0.0], 10.0 * DIGITS);
    }
}
