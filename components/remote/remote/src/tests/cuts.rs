//! Random cuts of the connection during held jogs: each ends the jog in time, and nothing moves again by itself.

use super::rig::{ACCELERATION, PERIOD, Rig, VELOCITY};
use hal_bench::Random;
use std::collections::BTreeMap;

/// Number of cuts.
const CUTS: u64 = 200;
/// Cycles from a cut to the begin of braking, at most.
const LIMIT: usize = 100;
/// Largest delay of a message, in cycles.
const LONGEST: u64 = 2000;

/// Ways in which a connection ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cut {
    /// The page answers no more; what is on its way arrives.
    Silent,
    /// The link is gone with all that is on its way.
    Link,
    /// Every message takes up to 2 s from now on.
    Delay,
    /// The lease is given back.
    Lease,
    /// The machine's wiring ends remote motion.
    Wiring,
}

const WAYS: [Cut; 5] = [Cut::Silent, Cut::Link, Cut::Delay, Cut::Lease, Cut::Wiring];

/// Cuts the connection of a jog at a random moment; returns the way that joint 0 went since.
fn trial(random: &mut Random, cut: Cut) -> f64 {
    let mut rig = Rig::leased(&[]);
    rig.delay = random.index(60);
    rig.cycles(200);
    rig.command("remote.jog", "lease=1 joint=0 velocity=20").unwrap();
    rig.cycles(100 + random.index(200));
    assert_eq!(rig.bench.get::<f64>("joint.0.vel-cmd"), VELOCITY, "{cut:?}");
    let at = rig.at(0);
    match cut {
        Cut::Silent => rig.answers = false,
        Cut::Link => rig.lose(),
        Cut::Delay => rig.delay = 96 + random.index(LONGEST as usize - 96),
        Cut::Lease => drop(rig.command("remote.give", "lease=1").unwrap()),
        Cut::Wiring => rig.bench.set("remote.allow-motion", false),
    }
    for n in 0..=LIMIT {
        rig.cycles(1);
        let slower = rig.bench.get::<f64>("joint.0.vel-cmd") < VELOCITY;
        assert!(slower || n < LIMIT, "{cut:?}: no braking {LIMIT} cycles after the cut");
        if slower {
            break;
        }
    }
    rig.rest();
    let way = rig.at(0) - at;
    // The connection is as good as before, in any order of what comes back.
    let rest = rig.at(0);
    rig.bench.set("remote.allow-motion", true);
    rig.answers = true;
    rig.delay = random.index(60);
    if random.index(2) == 1 {
        // A client that comes back takes the lease again. An old lease may last.
        drop(rig.command("remote.take", "holder=ana"));
    }
    for _ in 0..40 {
        rig.cycles(50);
        assert_eq!(rig.at(0).to_bits(), rest.to_bits(), "{cut:?}: motion after a reconnect");
    }
    way
}

#[test]
fn each_of_200_random_cuts_ends_the_jog_in_time() {
    let mut random = Random::new(18);
    let mut table: BTreeMap<Cut, (u32, f64)> = BTreeMap::new();
    for _ in 0..CUTS {
        let cut = random.pick(&WAYS);
        let way = trial(&mut random, cut);
        let most = VELOCITY * LIMIT as f64 * PERIOD as f64 * 1e-9
            + VELOCITY * VELOCITY / (2.0 * ACCELERATION);
        assert!(way <= most, "{cut:?}: {way} of {most} mm");
        let row = table.entry(cut).or_insert((0, 0.0));
        *row = (row.0 + 1, row.1.max(way));
    }
    assert_eq!(table.len(), WAYS.len(), "{table:?}");
    // What ends the lease itself ends the jog at once.
    assert!(table[&Cut::Lease].1 < 1.0 && table[&Cut::Wiring].1 < 1.0, "{table:?}");
    assert!(table[&Cut::Silent].1 > 1.5, "{table:?}");
}
