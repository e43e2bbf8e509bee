//! Machines with Mesa cards: a part, from its program to the counters of the simulated card.
#![expect(clippy::indexing_slicing, reason = "tests")]

use super::job::follows;
use hal_tests::{programs::root, scratch::Scratch, vcd::Vcd};
use std::f64::consts::FRAC_PI_2;

/// Steps of a millimetre of X, Y and Z.
const SCALES: [f64; 3] = [200.0, 200.0, 400.0];
/// Straight parts of each round corner: they are within 0.002 mm of it.
const CHORDS: i32 = 32;

/// A quarter of a circle, clockwise, that begins in a direction seen from its centre; the first point is not in it.
fn corner(path: &mut Vec<[f64; 3]>, centre: [f64; 2], quarter: f64) {
    let z = path[path.len() - 1][2];
    for n in 1..=CHORDS {
        let angle = FRAC_PI_2 * (quarter - f64::from(n) / f64::from(CHORDS));
        path.push([centre[0] + 5.0 * angle.cos(), centre[1] + 5.0 * angle.sin(), z]);
    }
}

/// Programmed points of `part.ngc`, in their order.
fn programmed() -> Vec<[f64; 3]> {
    let mut path = vec![[0.0, 0.0, 0.0], [20.0, 25.0, 2.0]];
    for depth in [-1.5, -3.0] {
        path.extend([[20.0, 25.0, depth], [20.0, 45.0, depth]]);
        corner(&mut path, [25.0, 45.0], 2.0);
        path.push([65.0, 50.0, depth]);
        corner(&mut path, [65.0, 45.0], 1.0);
        path.push([70.0, 25.0, depth]);
        corner(&mut path, [65.0, 25.0], 0.0);
        path.push([25.0, 20.0, depth]);
        corner(&mut path, [25.0, 25.0], 3.0);
    }
    path.extend([[20.0, 25.0, 2.0], [30.0, 30.0, 2.0], [30.0, 30.0, -1.0], [60.0, 40.0, -1.0]]);
    path.extend([[60.0, 40.0, 2.0], [0.0, 0.0, 2.0]]);
    path
}

/// Returns the places of the machine after homing, from the card's counters alone.
fn counted(vcd: &Vcd) -> Vec<[f64; 3]> {
    let offset = |n: usize| vcd.of(&format!("joint.{n}.motor-offset"));
    // Homing gives the motors their offsets once.
    let homed = (0..3).map(|n| offset(n)[offset(n).len() - 1]).collect::<Vec<_>>();
    let begin = homed.iter().map(|(time, _)| *time).max().unwrap_or(0);
    let counters = ["sim-x-steps", "sim-y-steps", "sim-z-steps"].map(|name| vcd.of(name));
    let mut changes: Vec<_> = (0..3)
        .flat_map(|axis| counters[axis].iter().map(move |(time, steps)| (*time, axis, *steps)))
        .collect();
    changes.sort_by_key(|(time, axis, _)| (*time, *axis));
    let (mut at, mut places, mut last) = ([0.0; 3], Vec::new(), 0);
    for (time, axis, steps) in changes {
        // A place is that of all counters of one cycle.
        if last != time && begin < last {
            places.push(at);
        }
        at[axis] = steps / SCALES[axis] - homed[axis].1;
        last = time;
    }
    places.push(at);
    // The joints go on to their zeros before the program begins.
    let arrived = places.iter().position(|at| at.iter().all(|x| x.abs() < 0.002));
    places.split_off(arrived.unwrap_or(0))
}

/// Cuts the part of a machine with so many lost packets of a million.
fn cut(machine: &str, card: &str, lost: u32) -> (Vcd, String) {
    let scratch = Scratch::copy_of(&root().join("configs").join(machine));
    scratch.write("cut.hal", format!("setp {card}.sim.line.lost {lost}\n"));
    scratch.write("cut.ini", "#INCLUDE sim.ini\n[HAL]\nHALFILE = cut.hal\n");
    let words = ["--virtual", "--record", "cut.vcd", "--run", "part.ngc", "cut.ini"];
    let output = scratch.halrun(&words);
    assert_eq!(output.status, Some(0), "{machine}: {}", output.stderr);
    assert!(output.stderr.contains("part.ngc: ended after "), "{machine}: {}", output.stderr);
    (Vcd::parse(&scratch.read("cut.vcd")), output.stderr)
}

#[test]
fn a_cut_is_its_program_within_a_step_also_when_packets_are_lost() {
    for lost in [0, 100] {
        let (vcd, said) = cut("mesa-mill", "hm2_7i96s.0", lost);
        let errors = vcd.rises("hm2_7i96s.0.packet-error").len();
        assert_eq!(errors > 0, lost > 0, "{errors} errors: {said}");
        follows(&counted(&vcd), &programmed(), &SCALES);
    }
}

/// Pitch of the thread of `mesa-76`, in millimetres, and radii of its passes.
const PITCH: f64 = 1.5;
const PASSES: [f64; 2] = [9.0, 8.6];
/// Steps of a millimetre of the lathe's X and Z.
const LATHE: [f64; 2] = [400.0, 200.0];

/// Returns the place along the thread of Z for each change of its counter in a pass: constant where Z follows the spindle.
fn thread(vcd: &Vcd, radius: f64) -> Vec<f64> {
    let offset = |n: usize| {
        let offsets = vcd.of(&format!("joint.{n}.motor-offset"));
        offsets[offsets.len() - 1].1
    };
    let (x, turns) = (vcd.of("sim-x-steps"), vcd.of("sim-turns"));
    let (mut nth, mut turn) = (0, 0);
    let mut places = Vec::new();
    for (time, steps) in vcd.of("sim-z-steps") {
        while x.get(nth + 1).is_some_and(|next| next.0 <= *time) {
            nth += 1;
        }
        while turns.get(turn + 1).is_some_and(|next| next.0 <= *time) {
            turn += 1;
        }
        let depth = x[nth].1 / LATHE[0] - offset(0);
        let z = steps / LATHE[1] - offset(1);
        // Behind the run-in, and before the end.
        if (depth - radius).abs() < 0.005 && (-23.0..-3.0).contains(&z) {
            places.push(z + PITCH * turns[turn].1);
        }
    }
    places
}

#[test]
fn both_passes_of_a_thread_are_in_one_groove() {
    for lost in [0, 100] {
        let (vcd, _) = cut("mesa-76", "hm2_7i76e.0", lost);
        let grooves = PASSES.map(|radius| {
            let places = thread(&vcd, radius);
            assert!(1000 < places.len(), "{radius}: {} places", places.len());
            let least = places.iter().copied().fold(f64::INFINITY, f64::min);
            let most = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            assert!(most - least < 1.0 / LATHE[1] + 0.002, "{radius}: {least} to {most}");
            (least + most) / 2.0
        });
        let turns = (grooves[0] - grooves[1]) / PITCH;
        assert!((turns - turns.round()).abs() * PITCH < 1.0 / LATHE[1] + 0.002, "{grooves:?}");
    }
}
