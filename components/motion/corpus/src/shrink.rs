//! Reduces a failing program.

use crate::{Program, Step};

/// Removes moves, in ever smaller parts, as long as the program still fails. `fails` must be a pure function.
pub fn shrink(program: &Program, mut fails: impl FnMut(&Program) -> bool) -> Program {
    let mut best = program.clone();
    let mut part = best.steps.len() / 2;
    while part > 0 {
        let mut from = 0;
        while from < best.steps.len() {
            let kept = |(k, step): (usize, &Step)| {
                let removed = from <= k && k < from + part;
                if removed { None } else { Some(step.clone()) }
            };
            let steps: Vec<Step> = best.steps.iter().enumerate().filter_map(kept).collect();
            let smaller = Program { steps, ..best.clone() };
            if !smaller.steps.is_empty() && fails(&smaller) {
                best = smaller;
            } else {
                from += part;
            }
        }
        part /= 2;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, Mode, Motion, Options, random};

    #[test]
    fn a_failing_program_shrinks_to_its_cause() {
        let options =
            Options { count: 200, axes: 3, mode: Mode::Exact, feed: 60.0, stops: 0.0, area: 1e3 };
        let program = random(Kind::Mixed, 5, &options);
        let arcs =
            |p: &Program| p.steps.iter().filter(|s| matches!(s.motion, Motion::Arc { .. })).count();
        assert!(arcs(&program) > 5);
        let small = shrink(&program, |p| arcs(p) >= 2);
        assert_eq!((small.steps.len(), arcs(&small)), (2, 2));
    }

    #[test]
    fn the_same_seed_gives_the_same_program() {
        let options = Options {
            count: 50,
            axes: 9,
            mode: Mode::Blend(0.1),
            feed: 60.0,
            stops: 0.1,
            area: 1e3,
        };
        for kind in Kind::ALL {
            assert_eq!(random(kind, 3, &options), random(kind, 3, &options));
            assert_ne!(random(kind, 3, &options), random(kind, 4, &options));
        }
    }
}
