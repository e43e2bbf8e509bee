//! Realtime. Parallel machines with struts: finds the pose for given lengths by Newton's method.
//!
//! Merlet, Parallel Robots, section 4.4. The number of steps is bounded.

use hal_component::Unsolved;
use libm::fabs;
use nalgebra::{Const, DimMin, SMatrix, SVector};

/// Bounds of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// Sum of the length errors at which the search succeeds, in units.
    pub(crate) enough: f64,
    /// Sum of the length errors above which the search fails, in units.
    pub(crate) most: f64,
    /// Maximum number of steps.
    pub(crate) steps: u32,
}

impl Bounds {
    /// Returns the bounds of the pins, or `None` if a length is not above 0.
    pub(crate) fn new(enough: f64, most: f64, steps: u32) -> Option<Self> {
        let fits = enough > 0.0 && most > 0.0 && crate::model::is_finite(&[enough, most]);
        fits.then_some(Self { enough, most, steps: steps.min(1000) })
    }
}

/// Length errors at one pose, and their Jacobian.
pub(crate) type Look<const N: usize> = (SVector<f64, N>, SMatrix<f64, N, N>);

/// Searches from a pose for one with the right lengths; `moved` applies a step to a pose. Returns the pose and the
/// number of steps.
pub(crate) fn find<const N: usize, P: Clone>(
    from: P,
    bounds: Bounds,
    look: impl Fn(&P) -> Option<Look<N>>,
    moved: impl Fn(&P, &SVector<f64, N>) -> P,
) -> Result<(P, u32), Unsolved>
where
    Const<N>: DimMin<Const<N>, Output = Const<N>>,
{
    let mut at = from;
    let (mut off, mut jacobian) = look(&at).ok_or(Unsolved::Undetermined)?;
    let mut far = sum(&off);
    let mut took = 0;
    loop {
        let near = far <= bounds.most;
        if !near {
            return Err(Unsolved::NotFound);
        }
        if took >= bounds.steps {
            break;
        }
        let Some(step) = jacobian.lu().solve(&off) else { break };
        if step.iter().any(|x| !x.is_finite()) {
            break;
        }
        took += 1;
        let mut part = 1.0;
        let mut better = None;
        for _ in 0..HALVES {
            let next = moved(&at, &(step * part));
            let seen = look(&next).map(|(off, jacobian)| (sum(&off), next, off, jacobian));
            if let Some(seen) = seen.filter(|(less, ..)| *less < far) {
                better = Some(seen);
                break;
            }
            part *= 0.5;
        }
        // No step reduces the error further: the limit of floating point is reached.
        let Some((less, next, next_off, next_jacobian)) = better else { break };
        (far, at, off, jacobian) = (less, next, next_off, next_jacobian);
    }
    if far <= bounds.enough { Ok((at, took)) } else { Err(Unsolved::NotFound) }
}

/// Maximum number of times that a step which increases the error is halved.
const HALVES: u32 = 20;

fn sum<const N: usize>(off: &SVector<f64, N>) -> f64 {
    off.iter().map(|x| fabs(*x)).sum()
}

/// Returns whether the lengths hardly change with the pose in some direction, judged by the pivots.
pub(crate) fn is_singular<const N: usize>(jacobian: &SMatrix<f64, N, N>) -> bool
where
    Const<N>: DimMin<Const<N>, Output = Const<N>>,
{
    let pivots = jacobian.full_piv_lu().u().diagonal();
    pivots.iter().any(|p| crate::rotation::is_straight(*p))
}
