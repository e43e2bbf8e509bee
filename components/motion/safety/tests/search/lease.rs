//! Judgement of the beats of a lease, row by row: what the search's model takes as given.

use hal_safety::lease::{Judge, Judgement, OnLoss, Rules};

const RULES: Rules = Rules { jog_ms: 100, lease_ms: 1000 };

#[test]
fn beats_keep_a_lease_and_permit_jogs_as_long_as_the_rules_say() {
    let at = |ends, beats, permit| Judgement { ends, beats, permit };
    let waits = at(false, false, false);
    let keeps = at(false, true, false);
    let permits = at(false, true, true);
    let ends = at(true, false, false);
    // (what, rows of one history: time, beats of pin and command, allowed, number, judgement)
    type Row = (u32, [u32; 2], bool, u32, Judgement);
    let histories: &[(&str, &[Row])] = &[
        (
            "the first beat is waited for as long as a lease lasts",
            &[
                (5000, [0, 0], true, 1, waits),
                (6000, [0, 0], true, 1, waits),
                (6001, [0, 0], true, 1, ends),
            ],
        ),
        (
            "a beat of the lease's first millisecond may be of the lease before",
            &[
                (5000, [4999, 0], true, 1, waits),
                (5001, [5000, 0], true, 1, waits),
                (5002, [5001, 0], true, 1, permits),
            ],
        ),
        (
            "ages at their bounds",
            &[
                (5000, [0, 0], true, 1, waits),
                (5001, [5001, 0], true, 1, permits),
                (5101, [5001, 0], true, 1, permits),
                (5102, [5001, 0], true, 1, keeps),
                (6001, [5001, 0], true, 1, keeps),
                (6002, [5001, 0], true, 1, ends),
                (6003, [6003, 0], true, 1, permits),
            ],
        ),
        (
            "of two beats the younger one counts",
            &[
                (5000, [0, 0], true, 1, waits),
                (5101, [5001, 5050], true, 1, permits),
                (5201, [5102, 5050], true, 1, permits),
                (5203, [5102, 5050], true, 1, keeps),
            ],
        ),
        (
            "a beat that goes back takes nothing away",
            &[
                (5000, [0, 0], true, 1, waits),
                (5001, [5001, 0], true, 1, permits),
                (5050, [4990, 0], true, 1, permits),
            ],
        ),
        (
            "a beat from the future is as old as can be",
            &[
                (5000, [0, 0], true, 1, waits),
                (5001, [5002, 5002], true, 1, ends),
                (6001, [6002, 6002], true, 1, ends),
            ],
        ),
        (
            "wiring that forbids motion",
            &[
                (5000, [0, 0], false, 1, waits),
                (5001, [5001, 0], false, 1, keeps),
                (5002, [5001, 0], true, 1, permits),
            ],
        ),
        (
            "without a lease nothing ends, and nothing is permitted",
            &[(5000, [4999, 0], true, 0, keeps), (9000, [0, 0], true, 0, waits)],
        ),
        (
            "the next lease has its own first beat",
            &[
                (5000, [0, 0], true, 1, waits),
                (5001, [5001, 0], true, 1, permits),
                (5002, [5001, 0], true, 2, waits),
                (5003, [5003, 0], true, 2, permits),
            ],
        ),
        (
            "the clock begins again at zero",
            &[
                (u32::MAX - 4, [u32::MAX - 9, 0], true, 1, waits),
                (3, [2, 0], true, 1, permits),
                (103, [2, 0], true, 1, keeps),
            ],
        ),
    ];
    for (what, rows) in histories {
        let mut judge = Judge::default();
        for (now, beats, allowed, number, expected) in *rows {
            let judged = judge.beats(*now, *beats, *allowed, *number, &RULES);
            assert_eq!(judged, *expected, "{what}: {now}");
        }
    }
}

#[test]
fn the_effects_of_a_lost_lease_have_names() {
    for (name, effect, holds) in [
        ("hold", OnLoss::Hold, true),
        ("continue", OnLoss::Continue, false),
        ("abort", OnLoss::Abort, true),
    ] {
        assert_eq!(
            (effect.name(), OnLoss::named(name), effect.holds()),
            (name, Some(effect), holds)
        );
    }
    assert_eq!(OnLoss::named("stop"), None);
}

#[test]
fn wiring_that_forbids_motion_ends_a_lease_and_a_job_once() {
    // (allowed before, allowed, number, job, ends)
    let rows = [
        (true, false, 1, false, true),
        (true, false, 0, true, true),
        (true, false, 1, true, true),
        (true, false, 0, false, false),
        (false, false, 1, true, false),
        (false, true, 1, true, false),
        (true, true, 1, true, false),
    ];
    for (before, allowed, number, job, ends) in rows {
        let mut judge = Judge { allowed: before, ..Judge::default() };
        assert_eq!(judge.forbids(allowed, number, job), ends, "{before} {allowed} {number} {job}");
        assert_eq!(judge.allowed, allowed);
    }
}
