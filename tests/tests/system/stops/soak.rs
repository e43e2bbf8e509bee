//! A long run on the real clock: random stops by all clients while eight viewers look on.

use super::{
    cell,
    clients::Panel,
    data::{Machine, machines},
    judge, motion,
    rig::{PERIOD_NS, Rig},
};
use hal_bench::Random;
use hal_protocol::{Kind, Link as _, Reply, Request};
use std::{
    collections::BTreeMap,
    fs,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    thread::{self, JoinHandle},
};

/// Environment variable with the time of the run in minutes.
const MINUTES: &str = "FERRULE_SOAK_MINUTES";
/// Time of the run where the variable says nothing, in minutes.
const LONG: f64 = 30.0;
/// Stops in half an hour.
const STOPS: f64 = 1000.0;
/// Viewers that look on.
const VIEWERS: usize = 8;
/// Cycles of a minute.
const MINUTE: f64 = 60_000.0;
/// Cycles within which a stop must have its effect on the real clock, where requests take time of their own.
const EFFECT: usize = 100;
/// Cycles of each round of wake-ups, without viewers and with them.
const ROUND: usize = 5000;
/// Rounds of each kind, before the stops and behind them.
const ROUNDS: usize = 3;
/// Largest share of the wake-ups without viewers that those with them may have, at 99.9 %.
const SHARE: f64 = 1.2;
/// Lateness below which wake-ups are the same, in nanoseconds: the clock of a computer that others use is no better.
const SAME_NS: f64 = 20_000.0;

/// Viewers, each with a connection that reads all it is sent.
struct Viewers {
    ends: Arc<AtomicBool>,
    got: Arc<AtomicU64>,
    threads: Vec<JoinHandle<()>>,
}

impl Viewers {
    fn of(panel: &Panel) -> Self {
        let (ends, got) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let viewer = |_| {
            let mut socket = panel.socket();
            let (ends, got) = (ends.clone(), got.clone());
            thread::spawn(move || {
                while !ends.load(Relaxed) && socket.receive().is_some() {
                    got.fetch_add(1, Relaxed);
                }
            })
        };
        let threads = (0..VIEWERS).map(viewer).collect();
        Self { ends, got, threads }
    }

    fn end(self) -> u64 {
        self.ends.store(true, Relaxed);
        for thread in self.threads {
            thread.join().unwrap();
        }
        self.got.load(Relaxed)
    }
}

/// Returns how many wake-ups of the servo thread were late by less than 1 us, 2 us, 4 us and so on, as the engine counts them.
fn latency(rig: &mut Rig) -> Vec<u64> {
    let all = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
    match rig.client.call(all) {
        Ok(Reply::Threads(threads)) => {
            threads.into_iter().find(|t| t.period == i64::from(PERIOD_NS)).unwrap().latency
        }
        other => panic!("{other:?}"),
    }
}

/// Adds the wake-ups between two counts.
fn add(sum: &mut Vec<u64>, before: &[u64], after: &[u64]) {
    sum.resize(sum.len().max(after.len()), 0);
    for (n, count) in after.iter().enumerate() {
        sum[n] += count - before.get(n).copied().unwrap_or(0);
    }
}

/// Returns the lateness in nanoseconds below which 99.9 % of the wake-ups are; within a class of the engine's counts they are
/// taken as evenly spread. The last class has no end: a bound in it is infinite.
fn bound(counts: &[u64]) -> f64 {
    let wanted = counts.iter().sum::<u64>() as f64 * 0.999;
    let (mut before, mut from, mut to) = (0.0, 0.0, 1000.0);
    for (n, count) in counts.iter().map(|count| *count as f64).enumerate() {
        if wanted <= before + count && n + 1 == counts.len() {
            return f64::INFINITY;
        }
        if wanted <= before + count {
            return from + (to - from) * (wanted - before) / count;
        }
        before += count;
        (from, to) = (to, to * 2.0);
    }
    from
}

#[test]
fn a_bound_lies_where_so_many_wake_ups_are_before_it() {
    // 999 of 1000 are below 2 us: at its end. 500 and 500: at 998/1000 of the second class.
    assert!((bound(&[0, 999, 1]) - 2000.0).abs() < 1e-6);
    assert!((bound(&[500, 500, 0]) - 1998.0).abs() < 1e-6);
    assert!((bound(&[0, 0, 0, 1000, 0]) - (4000.0 + 4000.0 * 0.999)).abs() < 1e-6);
    assert_eq!(bound(&[500, 500]), f64::INFINITY);
    let mut sum = Vec::new();
    add(&mut sum, &[1], &[3, 5]);
    add(&mut sum, &[3, 5], &[3, 6]);
    assert_eq!(sum, [2, 6]);
}

/// Resident memory of a process in KiB.
fn resident(pid: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}

/// Number of gaps so far.
fn gaps(rig: &mut Rig) -> u64 {
    match rig.client.call(Request::Status) {
        Ok(Reply::Status(status)) => status.gaps.map_or(0, |gaps| u64::from(gaps.count)),
        other => panic!("{other:?}"),
    }
}

/// Stops, by who gives them, with whether they switch the machine off.
const GIVEN: [(&str, &str, bool); 8] = [
    ("panel", "estop", true),
    ("panel", "off", true),
    ("panel", "abort", false),
    ("panel", "pause", false),
    ("halcmd", "iocontrol.estop", true),
    ("halcmd", "motion.disable", true),
    ("halcmd", "motion.abort", false),
    ("halcmd", "motion.pause", false),
];

/// Counts the wake-ups of a round.
fn wakes(rig: &mut Rig, sum: &mut Vec<u64>) {
    let before = latency(rig);
    rig.forget();
    rig.run(ROUND);
    add(sum, &before, &latency(rig));
}

#[test]
#[ignore = "half an hour, or FERRULE_SOAK_MINUTES: cargo test -p hal-tests --test system stops::soak -- --ignored --nocapture"]
fn soak() {
    let minutes = std::env::var(MINUTES).ok().and_then(|m| m.parse().ok()).unwrap_or(LONG);
    let case = std::env::var("CASE").unwrap_or_else(|_| "printer".to_owned());
    let machine: Machine = machines().into_iter().find(|m| m.name == case).unwrap();
    let mut rig = Rig::real(&machine);
    let panel = {
        let Rig { scratch, client, machine, .. } = &mut rig;
        Panel::beside(scratch, machine.is_ini(), &mut || {
            client.call(Request::Idle { ms: 10, flow: false }).unwrap();
        })
    };
    rig.skip();
    let (mut quiet, mut busy) = (Vec::new(), Vec::new());
    let compare = |rig: &mut Rig, quiet: &mut Vec<u64>, busy: &mut Vec<u64>| {
        for _ in 0..ROUNDS {
            wakes(rig, quiet);
            let viewers = Viewers::of(&panel);
            wakes(rig, busy);
            assert!(viewers.end() > 0, "viewers see nothing");
        }
    };
    compare(&mut rig, &mut quiet, &mut busy);

    let viewers = Viewers::of(&panel);
    let mut random = Random::new(36);
    let pids = [rig.running.pid(), panel.pid()];
    let total = (minutes * MINUTE) as i64;
    let wanted = (STOPS * minutes / LONG).ceil() as usize;
    let begun = rig.last().ns / 1_000_000;
    let mut memory: BTreeMap<i64, u64> = BTreeMap::new();
    let (mut given, mut lost, mut slowest) = (0, Vec::new(), 0);
    loop {
        let now = rig.last().ns / 1_000_000 - begun;
        if total <= now {
            break;
        }
        memory.insert(now, pids.iter().map(|pid| resident(*pid)).sum());
        cell::ready(&mut rig).unwrap();
        let motion = super::Motion::ALL[random.index(2)];
        let moving = motion::begin(&mut rig, motion, false).unwrap();
        let (who, what, is_off) = GIVEN[random.index(GIVEN.len())];
        rig.run(1 + random.index(50));
        rig.forget();
        let refused = if who == "panel" {
            panel.give(what)
        } else {
            rig.give(what);
            rig.refused.pop()
        };
        rig.run(EFFECT + 1);
        let effect = if is_off {
            rig.seen.iter().position(|f| !f.on)
        } else {
            let speeds = moving.speeds(&rig.seen);
            speeds.iter().position(|speed| *speed < moving.speed * 0.99)
        };
        given += 1;
        match effect {
            Some(cycles) => slowest = slowest.max(cycles),
            None => lost.push(format!("{who} {what}: {refused:?}")),
        }
        cell::clear_all(&mut rig).unwrap();
        // The rest of the time until the next stop.
        let due = (total as f64 * given as f64 / wanted as f64) as i64;
        let wait = due - (rig.last().ns / 1_000_000 - begun);
        rig.forget();
        if wait > 0 {
            rig.run(wait as usize);
            judge::stays(&rig.seen, "between two stops").unwrap();
        }
    }
    let got = viewers.end();
    compare(&mut rig, &mut quiet, &mut busy);

    let third = total / 3;
    let mean = |from: i64, to: i64| {
        let part: Vec<u64> = memory.range(from..to).map(|(_, kib)| *kib).collect();
        part.iter().sum::<u64>() as f64 / part.len().max(1) as f64
    };
    let (first, last) = (mean(0, third), mean(total - third, total + 1));
    let wakes = quiet.iter().sum::<u64>().min(busy.iter().sum());
    // Before the stops and behind them.
    assert!(wakes as usize >= 2 * ROUND * ROUNDS, "{wakes} wake-ups");
    let (quiet, busy) = (bound(&quiet), bound(&busy));
    let gaps = gaps(&mut rig);
    println!(
        "{minutes} minutes, {VIEWERS} viewers, {got} messages: {given} stops, {} lost, the slowest after {slowest} cycles; {gaps} gaps; \
         resident {first:.0} KiB in the first third, {last:.0} KiB in the last; 99.9 % of wake-ups within {quiet:.0} ns without viewers, \
         {busy:.0} ns with them",
        lost.len()
    );
    assert!(lost.is_empty(), "lost stops: {lost:?}");
    assert!(wanted <= given + 1, "{given} stops, not {wanted}");
    assert_eq!(gaps, 0, "gaps");
    assert!(last <= first * 1.05, "resident memory grows");
    assert!(quiet.is_finite(), "later than the engine counts, without viewers");
    assert!(busy <= (quiet * SHARE).max(quiet + SAME_NS), "viewers make wake-ups late");
}
