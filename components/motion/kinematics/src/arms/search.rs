//! Realtime. Inverse kinematics of an arm by search: Newton's method, damped near singular positions.
//!
//! Wampler, Manipulator inverse kinematic solutions based on vector formulations and damped least-squares methods
//! (1986). The number of steps is bounded.

use crate::{
    arms::dh::Chain,
    rotation::{Matrix, Vector, to_vector},
};
use hal_component::Unsolved;
use libm::fabs;
use nalgebra::{Matrix6, Vector6};

/// Returns the joints for a pose, in radians, and the number of steps.
pub(crate) fn search(
    chain: &Chain,
    place: &Vector,
    turned: &Matrix,
    from: &[f64; 6],
    steps: u32,
) -> Result<([f64; 6], u32), Unsolved> {
    let size = chain.reach();
    if place.norm() > size * (1.0 + ENOUGH) {
        return Err(Unsolved::Unreachable);
    }
    let mut at = *from;
    let mut off = gap(chain, place, turned, &at);
    let mut best = error(&off, size);
    let mut took = 0;
    while took < steps && best > LEAST {
        took += 1;
        let Some(step) = step(&chain.jacobian(&at), &off, size, best) else { break };
        let mut part = 1.0;
        let mut better = false;
        for _ in 0..HALVES {
            let mut next = at;
            for (angle, way) in next.iter_mut().zip(step.iter()) {
                *angle += part * way;
            }
            let gap = gap(chain, place, turned, &next);
            let far = error(&gap, size);
            if far < best {
                (at, off, best) = (next, gap, far);
                better = true;
                break;
            }
            part *= 0.5;
        }
        if !better {
            break;
        }
    }
    if best < ENOUGH { Ok((at, took)) } else { Err(Unsolved::NotFound) }
}

/// Error at which a search succeeds: lengths as fractions of the reach, angles in radians.
const ENOUGH: f64 = 1e-10;
/// Error below which no further improvement is possible.
const LEAST: f64 = 1e-15;
/// Maximum number of times that a step which increases the error is halved.
const HALVES: u32 = 12;
/// Largest step of a joint, in radians.
const LARGEST: f64 = 0.5;

/// Returns the remaining error: translation and rotation vector.
fn gap(chain: &Chain, place: &Vector, turned: &Matrix, angles: &[f64; 6]) -> Vector6<f64> {
    let (end, hand) = chain.end(angles);
    let way = place - end;
    let turn = to_vector(&(turned * hand.transpose()));
    Vector6::new(way.x, way.y, way.z, turn.x, turn.y, turn.z)
}

fn error(gap: &Vector6<f64>, size: f64) -> f64 {
    let [x, y, z, a, b, c] = (*gap).into();
    Vector::new(x, y, z).norm() / size + Vector::new(a, b, c).norm()
}

/// Returns Newton's step, or a damped one where the equations have no solution.
fn step(jacobian: &Matrix6<f64>, gap: &Vector6<f64>, size: f64, far: f64) -> Option<Vector6<f64>> {
    let scale = Vector6::new(1.0 / size, 1.0 / size, 1.0 / size, 1.0, 1.0, 1.0);
    let j = Matrix6::from_diagonal(&scale) * jacobian;
    let e = scale.component_mul(gap);
    let newton = j.lu().solve(&e).filter(|s| s.iter().all(|x| fabs(*x) < 10.0));
    let mut step = match newton {
        Some(step) => step,
        None => {
            let damping = 1e-4 * if far < 1.0 { far } else { 1.0 };
            let square = j.transpose() * j + Matrix6::identity() * damping;
            square.lu().solve(&(j.transpose() * e))?
        }
    };
    let longest = step.iter().fold(0.0, |m: f64, x| if fabs(*x) > m { fabs(*x) } else { m });
    if !longest.is_finite() {
        return None;
    }
    if longest > LARGEST {
        step *= LARGEST / longest;
    }
    Some(step)
}

/// Calls `take` once with every solution that searches from many starts find, at most [`MAX`].
pub(crate) fn every_way(
    chain: &Chain,
    place: &Vector,
    turned: &Matrix,
    mut take: impl FnMut(&[f64; 6]),
) -> usize {
    let mut found = [[0.0; 6]; MAX];
    let mut count = 0;
    let mut in_vain = 0;
    for n in 1..=STARTS {
        let Ok((way, _)) = search(chain, place, turned, &start(n), STEPS) else {
            in_vain += 1;
            if in_vain > TIMEOUT && count == 0 {
                break;
            }
            continue;
        };
        let is_known = |known: &[f64; 6]| {
            let apart = |(a, b): (&f64, &f64)| fabs(libm::remainder(a - b, TURN));
            known.iter().zip(&way).map(apart).fold(0.0, f64::max) < SAME
        };
        if found.iter().take(count).any(is_known) {
            in_vain += 1;
            if in_vain > TIMEOUT {
                break;
            }
            continue;
        }
        let Some(room) = found.get_mut(count) else { break };
        *room = way;
        count += 1;
        in_vain = 0;
        take(&way);
    }
    count
}

/// Maximum number of solutions of a six-joint arm for one pose (Primrose, 1986; Raghavan and Roth, 1993).
pub(crate) const MAX: usize = 16;
/// Maximum number of starts.
const STARTS: u32 = 1500;
/// Maximum number of searches in a row that find nothing new.
const TIMEOUT: u32 = 250;
/// Maximum number of steps of a search from such a start.
const STEPS: u32 = 60;
/// Largest difference of solutions that count as the same.
const SAME: f64 = 1e-5;
const TURN: f64 = 2.0 * core::f64::consts::PI;

/// Returns the n-th start of a sequence that fills all angles evenly (Halton, 1960).
fn start(n: u32) -> [f64; 6] {
    [2, 3, 5, 7, 11, 13].map(|base| (halton(n, base) - 0.5) * TURN)
}

fn halton(mut n: u32, base: u32) -> f64 {
    let (mut out, mut part) = (0.0, 1.0);
    while n > 0 {
        part /= f64::from(base);
        out += part * f64::from(n % base);
        n /= base;
    }
    out
}
