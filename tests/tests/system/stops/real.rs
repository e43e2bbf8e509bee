//! Stops of the machine's own process, on the real clock: it stands still, is ended, is killed.

use super::{
    cell,
    data::{Machine, Motion, machines},
    judge,
    motion::{self, Moving},
    rig::{Frame, Rig},
};
use rustix::process::Signal;
use std::process::Command;

/// Time for which the process stands still, in seconds.
const STANDS: &str = "2";
/// Shortest gap in machine time, in nanoseconds.
const GAP_NS: i64 = 1_000_000_000;
/// Time for which a step generator still moves after the switch-off, in seconds: one base period (100 us), and as long again for the
/// servo thread.
const BASE_S: f64 = 2.0 * 100e-6;
/// Time after which a card's watchdog bites, in nanoseconds: less than the process stands still.
const WATCHDOG_NS: &str = "300000000";
/// Cycles that are watched behind it.
const WATCHED: usize = 300;

/// Lets real time pass.
fn pass(seconds: &str) {
    assert!(Command::new("sleep").arg(seconds).status().unwrap().success(), "time passes");
}

/// Begins a motion of a machine that is ready.
fn begin(machine: &Machine, motion: Motion) -> Result<(Rig, Moving), String> {
    let mut rig = Rig::real(machine);
    // A busy computer wakes a thread late by more than a card's watchdog waits.
    rig.set_all("*.watchdog.timeout_ns", WATCHDOG_NS);
    cell::ready(&mut rig)?;
    let moving = motion::begin(&mut rig, motion, false)?;
    rig.forget();
    Ok((rig, moving))
}

/// Judges a machine that stood still: it is off in the first cycle behind that, and nothing is commanded any more.
fn judge_gap(moving: &Moving, frames: &[Frame]) -> Result<(), String> {
    let gap = frames.windows(2).position(|pair| GAP_NS < pair[1].ns - pair[0].ns);
    let gap = gap.ok_or("there is no gap in the cycles")?;
    // The first cycle that runs is the one that was due when the process stood still, at its own time; or the next one.
    let off = (gap..=gap + 1).find(|n| frames.get(*n).is_some_and(|f| !f.on));
    let off = off.ok_or("the machine is not off in the first cycle")?;
    if !frames[..gap].iter().all(|f| f.on) {
        return Err("the machine was off before the gap".to_owned());
    }
    if let Some(n) = frames[off..].iter().position(|f| f.on || f.amplified) {
        return Err(format!("an amplifier is on {n} cycles behind the gap"));
    }
    // Commands follow the motors while the machine is off. A step generator of the base thread makes its steps until the end of
    // this cycle takes its speed away.
    let [first, next, later @ ..] = &frames[off..] else {
        return Err("nothing was watched behind the gap".to_owned());
    };
    if later.len() < WATCHED / 2 {
        return Err(format!("only {} cycles were watched behind the gap", later.len()));
    }
    let ways = first.motors.iter().zip(&next.motors).map(|(a, b)| (a - b).abs());
    let way = ways.fold(0.0, f64::max);
    if moving.speed * BASE_S < way {
        return Err(format!("the motors move by {way} behind the gap"));
    }
    match later.iter().position(|frame| frame.motors != next.motors) {
        Some(n) => Err(format!("motor commands change {n} cycles behind the gap")),
        None => Ok(()),
    }
}

/// The process stands still for two seconds in the middle of a motion, and goes on: the machine is off in the first cycle.
fn stopped(machine: &Machine, motion: Motion) -> Result<(), String> {
    let (mut rig, moving) = begin(machine, motion)?;
    rig.running.signal(Signal::STOP);
    pass(STANDS);
    rig.running.signal(Signal::CONT);
    rig.run(WATCHED);
    judge_gap(&moving, &rig.seen)?;
    // A card's watchdog has bitten meanwhile, and those of its remotes: a person has looked.
    rig.set_all("*.watchdog.has_bit", "FALSE");
    for run in ["FALSE", "TRUE"] {
        rig.set_all("*.sserial.port-*.run", run);
        rig.run(WATCHED);
    }
    rig.forget();
    cell::switch_on(&mut rig)?;
    rig.run(WATCHED);
    judge::stays(&rig.seen, "after reset and on")
}

/// SIGTERM ends the process in an orderly way.
fn ended(machine: &Machine, motion: Motion) -> Result<(), String> {
    let (mut rig, _) = begin(machine, motion)?;
    rig.running.signal(Signal::TERM);
    match rig.running.ended().map(|status| status.code()) {
        Some(Some(0)) => Ok(()),
        other => Err(format!("it ends with {other:?}")),
    }
}

/// `kill -9` promises the charge pump alone.
fn killed(machine: &Machine, motion: Motion) -> Result<&'static str, String> {
    let (mut rig, _) = begin(machine, motion)?;
    let pumped = machine.charge_pump.as_ref().map(|signal| rig.changes(signal));
    rig.running.signal(Signal::KILL);
    rig.running.ended().ok_or("it does not end")?;
    match pumped {
        None => Ok("no charge pump: nothing is promised"),
        Some(true) => Ok("the charge pump, which only the process keeps alive, ends with it"),
        Some(false) => Err("the charge pump does not run while the machine is on".to_owned()),
    }
}

#[test]
#[ignore = "on the real clock: cargo test -p hal-tests --test system stops::real -- --ignored"]
fn full_own_process() {
    let case = std::env::var("CASE").unwrap_or_default();
    let (mut bad, mut cells) = (Vec::new(), 0);
    for machine in machines().into_iter().filter(|m| m.name.starts_with(&case)) {
        for motion in Motion::ALL {
            let results = [
                ("SIGSTOP of halrun", stopped(&machine, motion).map(|()| "off, and stays")),
                ("SIGTERM of halrun", ended(&machine, motion).map(|()| "ends")),
                ("kill -9 of halrun", killed(&machine, motion)),
            ];
            for (name, result) in results {
                cells += 1;
                let cell = format!("{}, {name}, {}", machine.name, motion.name());
                match result {
                    Ok(what) => println!("{cell}: {what}"),
                    Err(why) => bad.push(format!("{cell}: {why}")),
                }
            }
        }
    }
    println!("{cells} cells on the real clock, {} bad", bad.len());
    assert!(bad.is_empty(), "{} cells are not as they should be:\n{}", bad.len(), bad.join("\n"));
}
