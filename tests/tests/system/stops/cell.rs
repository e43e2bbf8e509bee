//! A cell of the table: a machine, a control and a kind of motion.

use super::{
    clients,
    data::{Control, Effect, Motion},
    judge::{self, Measured},
    motion::{self, Moving},
    rig::Rig,
};

/// Cycles for which nothing may move after a stop.
const STAYS: usize = 1000;
/// Cycles for which nothing may move after the machine was switched on again.
const AGAIN: usize = 200;
/// Cycles in which a motion that goes on is watched.
const GOES_ON: usize = 200;
/// Cycles within which everything rests.
const RESTS: usize = 1500;

/// Cycles behind the stop in which a fault of the machine acts.
const LATER: usize = 300;
/// A move that nobody has given.
const MOVE: &str = "motion.move x=1 velocity=1";

/// Result of a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    Good(Measured),
    /// The motion is not stopped by this control, and goes on.
    GoesOn,
    /// The cell cannot be, for this reason.
    Cannot(String),
    Bad(String),
}

/// Phase of the motion in which the stop comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Constant,
    Accelerates,
}

/// A fault of the machine that a test puts into a cell, to see that the cell finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    None,
    /// The control sends the command of the task, as on machines that have one.
    OldCommand,
    /// The stop is late by a cycle.
    Late,
    /// A move that waited begins 0.3 s behind the stop.
    Queue,
    /// A paused path goes on by itself 0.3 s behind the stop.
    Resumes,
    /// The motion goes on when the machine is switched on again.
    Restarts,
    /// Joint 0 and the path brake at half of their accelerations.
    Slow,
}

/// Carries a cell out.
pub(super) fn cell(rig: &mut Rig, control: &Control, motion: Motion, phase: Phase) -> Outcome {
    faulty(rig, control, motion, phase, Fault::None)
}

/// Carries a cell out on a machine with a fault.
pub(super) fn faulty(
    rig: &mut Rig,
    control: &Control,
    motion: Motion,
    phase: Phase,
    fault: Fault,
) -> Outcome {
    let accelerates = phase == Phase::Accelerates;
    let effect = control.effect(motion);
    if let Effect::Cannot(why) = effect {
        return Outcome::Cannot(why);
    }
    if control.needs.as_deref() == Some("task") && !rig.has_task() {
        return Outcome::Cannot("the machine has no task".to_owned());
    }
    if let Some(command) = &control.command
        && !rig.commands.contains(command)
    {
        return Outcome::Bad(format!("there is no command {command}"));
    }
    if let Some((client, _)) = control.client()
        && client.needs_lease()
        && let Some(why) = &rig.machine.no_lease
    {
        return Outcome::Cannot(why.clone());
    }
    if let Some((client, _)) = control.client()
        && let Err(why) = clients::ready(rig, client)
    {
        return Outcome::Cannot(why);
    }
    let slow = if fault == Fault::Slow { 0.5 } else { 1.0 };
    let moving = ready(rig)
        .and_then(|()| brakes(rig, slow))
        .and_then(|()| motion::begin(rig, motion, accelerates));
    let moving = match moving {
        Ok(moving) => moving,
        Err(why) => {
            let why = format!("before the stop: {why}");
            return clear(rig, control).err().map_or(Outcome::Bad(why), Outcome::Bad);
        }
    };
    rig.forget();
    let stop = Stop { control, effect: &effect, moving: &moving, accelerates, fault };
    let judged = stop.judged(rig);
    // The cell before the next one leaves nothing.
    let cleared = clear(rig, control);
    match (judged, cleared) {
        (Ok(_), Ok(())) if effect == Effect::On => Outcome::GoesOn,
        (Ok(measured), Ok(())) => Outcome::Good(measured),
        (Err(why), _) | (Ok(_), Err(why)) => Outcome::Bad(why),
    }
}

/// A stop of a motion.
struct Stop<'a> {
    control: &'a Control,
    effect: &'a Effect,
    moving: &'a Moving,
    accelerates: bool,
    fault: Fault,
}

impl Stop<'_> {
    /// Gives the stop, and judges it.
    fn judged(&self, rig: &mut Rig) -> Result<Measured, String> {
        let Self { control, effect, moving, accelerates, fault } = *self;
        if fault == Fault::Late {
            rig.run(1);
        }
        let late = give(rig, control, moving, fault)?;
        match fault {
            Fault::Queue | Fault::Resumes => {
                rig.run(LATER);
                rig.give(if fault == Fault::Queue { MOVE } else { "motion.resume" });
                rig.run(STAYS - LATER);
            }
            _ => rig.run(if *effect == Effect::On { GOES_ON } else { STAYS }),
        }
        let seen = rig.seen.clone();
        let refused = rig.refused.join("; ");
        let judged = match effect {
            Effect::Off(n) if control.ferror => {
                let exceeds = judge::exceeds(&seen, rig.machine.ferror, stuck(rig, moving));
                let exceeds = exceeds.unwrap_or(STAYS);
                judge::off(moving, &seen, exceeds + n)
            }
            Effect::Off(n) => judge::off(moving, &seen, n + late),
            Effect::Brake(n) | Effect::Rest(n) | Effect::Hold(n) => {
                judge::brake(moving, &seen, *n, accelerates)
            }
            Effect::AtOnce(n) => judge::at_once(moving, &seen, *n, rig.machine.ferror),
            Effect::On => judge::on(moving, &seen),
            Effect::Ends => Err("only a program that is lost has this effect".to_owned()),
            Effect::Cannot(why) => Err(why.clone()),
        };
        let judged = judged.map_err(|why| format!("{why} {refused}").trim_end().to_owned())?;
        rig.forget();
        self.after(rig)?;
        Ok(judged)
    }

    /// Judges what follows the stop.
    fn after(&self, rig: &mut Rig) -> Result<(), String> {
        let Self { control, moving, .. } = *self;
        unpress(rig, control);
        if control.ferror {
            // The place of a joint that is off follows its feedback.
            rig.forget();
        }
        match self.effect {
            Effect::Off(_) | Effect::AtOnce(_) => {
                switch_on(rig)?;
                if self.fault == Fault::Restarts {
                    rig.give(MOVE);
                }
                rig.run(AGAIN);
                if !rig.last().on {
                    return Err("it is not switched on again".to_owned());
                }
                judge::stays(&rig.seen, "after reset and on")
            }
            Effect::Brake(_) => {
                rig.give("motion.enable");
                rig.run(AGAIN);
                judge::stays(&rig.seen, "after the stop")
            }
            Effect::Rest(_) => {
                judge::stays(&rig.seen, "before the resume")?;
                let resume = if moving.by_task { "task.resume" } else { "motion.resume" };
                rig.finish(resume, 100)?;
                goes_on(rig, moving, "resume")
            }
            Effect::Hold(_) => goes_on(rig, moving, "its end"),
            Effect::On | Effect::Ends | Effect::Cannot(_) => Ok(()),
        }
    }
}

/// Gives a stop; returns by how many cycles the machine sees it later.
fn give(rig: &mut Rig, control: &Control, moving: &Moving, fault: Fault) -> Result<usize, String> {
    let late = rig.machine.chain.as_ref().map_or(0, |chain| chain.cycles - 1);
    if let Some(command) = &control.command {
        let (_, verb) = command.split_once('.').unwrap();
        let old = format!("task.{verb}");
        rig.give(if fault == Fault::OldCommand { &old } else { command });
    } else if let Some((client, words)) = control.client() {
        let refused = clients::give(rig, client, words)?;
        rig.refused.extend(refused);
    } else if let Some(pin) = &control.button {
        rig.set(pin, "TRUE");
    } else if let Some(force) = &control.force {
        rig.force(&force.pin, Some(&force.value))?;
    } else if control.chain {
        match rig.machine.chain.clone() {
            Some(chain) => rig.set(&chain.pin, &chain.open),
            None => rig.force("iocontrol.0.emc-enable-in", Some("FALSE"))?,
        }
        return Ok(late);
    } else if control.ferror {
        rig.force(&format!("joint.{}.motor-pos-fb", stuck(rig, moving)), None)?;
    }
    Ok(0)
}

/// Returns the joint whose feedback stands still.
fn stuck(rig: &Rig, moving: &Moving) -> usize {
    moving.joint.unwrap_or(rig.machine.ferror.joint)
}

/// Ends what keeps a stop given.
fn unpress(rig: &mut Rig, control: &Control) {
    if let Some(pin) = &control.button {
        rig.set(pin, "FALSE");
    }
    rig.release();
    if let (true, Some(chain)) = (control.chain, rig.machine.chain.clone()) {
        rig.set(&chain.pin, &chain.closed);
    }
    rig.run(20);
}

/// Leaves e-stop and switches the machine on.
pub(super) fn switch_on(rig: &mut Rig) -> Result<(), String> {
    if !rig.last().on {
        rig.finish("iocontrol.estop-reset", 200)?;
        rig.run(20);
        rig.finish("motion.enable", 100)?;
        rig.run(2);
    }
    Ok(())
}

/// Gives the machine a share of its acceleration, where a test wants that.
fn brakes(rig: &mut Rig, share: f64) -> Result<(), String> {
    if share < 1.0 {
        let acceleration = rig.machine.jog.acceleration * share;
        let configure = format!("motion.configure joint=0 max-acceleration={acceleration}");
        rig.finish(&configure, 20)?;
    }
    Ok(())
}

/// Watches that a motion goes on.
fn goes_on(rig: &mut Rig, moving: &Moving, behind: &str) -> Result<(), String> {
    rig.forget();
    rig.run(AGAIN);
    let has_moved = moving.speeds(&rig.seen).iter().any(|speed| *speed > moving.speed * 0.5);
    if has_moved { Ok(()) } else { Err(format!("it does not go on behind {behind}")) }
}

/// Ends whatever is left of a cell.
fn clear(rig: &mut Rig, control: &Control) -> Result<(), String> {
    unpress(rig, control);
    clear_all(rig)
}

/// Ends all motion.
pub(super) fn clear_all(rig: &mut Rig) -> Result<(), String> {
    if rig.has_task() {
        rig.give("task.abort");
    }
    rig.give("motion.abort");
    rig.run(20);
    for _ in 0..RESTS / 100 {
        rig.forget();
        rig.run(100);
        if judge::stays(&rig.seen, "").is_ok() {
            break;
        }
    }
    judge::stays(&rig.seen, "after an abort")?;
    // It homes where it stands, and keeps its place.
    let joint = rig.machine.joint();
    let at = rig.last().joints[joint];
    let still = format!("home-search-vel=0 home-latch-vel=0 home={at} home-offset={at}");
    rig.finish(&format!("motion.configure joint={joint} {still}"), 20)
}

/// Makes the machine ready for the next cell: on, homed, at rest.
pub(super) fn ready(rig: &mut Rig) -> Result<(), String> {
    switch_on(rig)?;
    if rig.has_task() {
        rig.finish("task.mode mode=manual", 500)?;
    }
    if !rig.is("motion.is-all-homed") {
        rig.finish("motion.home joint=all", 5000)?;
    }
    rig.run(50);
    rig.forget();
    Ok(())
}
