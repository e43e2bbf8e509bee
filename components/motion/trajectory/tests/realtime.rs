//! The follower allocates nothing, whatever it follows.
//!
//! The counts are those of the process, so this test has no harness, whose threads would allocate too.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

#[path = "it/judge/mod.rs"]
mod judge;

use hal_trajectory::{Follower, Path, Planner, Pose, Trivial, share};
use judge::{case, convert};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;

#[global_allocator]
static COUNTED: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Steps until the end, at overrides that change; returns the number of allocations in the steps.
fn steps(follower: &mut Follower, path: &impl Path) -> usize {
    let region = Region::new(COUNTED);
    for cycle in 0..20_000_u32 {
        let scale = if cycle / 500 % 4 == 3 { 0.0 } else { f64::from(cycle / 100 % 3) * 0.5 };
        let _ = follower.step(path, scale, cycle / 1000 % 5 == 2);
    }
    let change = region.change();
    change.allocations + change.deallocations + change.reallocations
}

fn main() {
    // A culprit is counted.
    let region = Region::new(COUNTED);
    drop(std::hint::black_box(vec![1_u8; 10]));
    assert_eq!(region.change().allocations, 1);

    for seed in 0..42 {
        let c = case(seed, 60);
        let (moves, _) = convert(&c.program, &c.machine);
        let start = Pose(c.program.start);
        let mut planner = Planner::new(c.machine, c.robot, start).unwrap();
        for m in &moves {
            if m.push(&mut planner).is_err() {
                break;
            }
        }
        planner.finish();
        let mut follower = Follower::new(c.machine.period, start);
        assert_eq!(steps(&mut follower, planner.track()), 0, "seed {seed}");
    }
    // Through the hand-over.
    let c = case(0, 60);
    let (moves, _) = convert(&c.program, &c.machine);
    let mut planner = Planner::new(c.machine, Trivial, Pose::ZERO).unwrap();
    for m in &moves[..40] {
        m.push(&mut planner).unwrap();
    }
    planner.finish();
    let (mut publisher, reader) = share(4096, 100);
    publisher.publish(&mut planner);
    let mut follower = Follower::new(c.machine.period, Pose::ZERO);
    assert_eq!(steps(&mut follower, &reader), 0);
}
