//! The judgement of a stop: what its rule demands, beside what the machine did in each servo cycle.

use super::{data::FollowingError, motion::Moving, rig::DT, rig::Frame};

/// Difference of places that rounding explains.
const SAME: f64 = 1e-9;

/// Measured stop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Measured {
    /// Cycles from the stop to its effect: off, or the begin of braking.
    pub(super) effect: usize,
    /// Cycles from the stop to rest.
    pub(super) rest: usize,
    /// Way from the stop to rest.
    pub(super) way: f64,
}

/// Returns whether nothing moves from one cycle to the next.
fn stands(a: &Frame, b: &Frame) -> bool {
    let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME);
    same(&a.joints, &b.joints) && same(&a.motors, &b.motors)
}

/// Returns the number of cycles from the first one to the last in which something moves.
fn rest(frames: &[Frame]) -> usize {
    frames.windows(2).rposition(|pair| !stands(&pair[0], &pair[1])).map_or(0, |n| n + 1)
}

/// Returns the way between two cycles, as the sum of the ways of all.
fn way(moving: &Moving, frames: &[Frame]) -> f64 {
    moving.speeds(frames).into_iter().map(|speed| speed * DT).sum()
}

/// Judges a stop that switches the machine off after so many cycles. The first frame is the cycle before the stop.
pub(super) fn off(moving: &Moving, frames: &[Frame], limit: usize) -> Result<Measured, String> {
    let effect = frames.iter().position(|f| !f.on);
    let effect = effect.ok_or("the machine is not switched off")?;
    let rest = rest(frames);
    // Motor commands go back by the following error once, to where the motors are.
    let measured = Measured { effect, rest, way: way(moving, &frames[..=effect]) };
    if limit < effect {
        return Err(format!("off after {effect} cycles, at most {limit}"));
    }
    if let Some(n) = frames.iter().skip(effect).position(|f| f.on || f.amplified) {
        return Err(format!("an amplifier is on {n} cycles behind the end of motion"));
    }
    if effect < rest {
        return Err(format!("motor commands change until cycle {rest}, off since {effect}"));
    }
    Ok(measured)
}

/// Judges a stop by which motion brakes, from so many cycles behind it at the latest.
pub(super) fn brake(
    moving: &Moving,
    frames: &[Frame],
    limit: usize,
    accelerates: bool,
) -> Result<Measured, String> {
    let speeds = moving.speeds(frames);
    if frames.iter().any(|f| !f.on) {
        return Err("the machine is switched off".to_owned());
    }
    let rest = rest(frames);
    if rest + 1 >= frames.len() {
        return Err("it does not come to rest".to_owned());
    }
    // Braking has begun in the first cycle that is slower by a good part of what a cycle of braking takes away; while it accelerates,
    // in the first one that is not faster by a good part of what a cycle of acceleration adds.
    let step = moving.acceleration * DT;
    let slower = if accelerates { step / 2.0 } else { -step / 4.0 };
    let mut before = moving.speed;
    let mut effect = 0;
    for (n, speed) in speeds.iter().enumerate() {
        if *speed < before + slower {
            effect = n + 1;
            break;
        }
        before = if accelerates { *speed } else { before };
    }
    let begin = effect.saturating_sub(1);
    let faster = speeds.get(..begin).and_then(|s| s.last()).copied().unwrap_or(moving.speed);
    // The speed at the end of a cycle is above the mean of it.
    let speed = if accelerates { faster + step } else { moving.speed };
    let measured = Measured { effect, rest, way: way(moving, &frames[..=rest]) };
    if limit < effect {
        return Err(format!("braking begins after {effect} cycles, at most {limit}"));
    }
    let most = begin + moving.cycles(speed, accelerates);
    if most < rest {
        let braked = faster / ((rest - begin) as f64 * DT);
        return Err(format!(
            "at rest after {rest} cycles, at most {most}: it braked with {braked:.1} units/s² on average, its limit is {:.1}",
            moving.acceleration
        ));
    }
    let braked = way(moving, &frames[begin..=rest]);
    let longest = moving.longest(speed);
    if longest * (1.0 + 1e-6) < braked {
        return Err(format!(
            "braked for {braked:.4} in {} cycles from {faster:.2}, at most {longest:.4}",
            rest - begin
        ));
    }
    let faster = speeds[begin..rest].windows(2).find(|s| s[0] * 1.001 + SAME / DT < s[1]);
    if let (false, Some(pair)) = (accelerates, faster) {
        return Err(format!("it becomes faster while it brakes: {pair:?}"));
    }
    Ok(measured)
}

/// Judges a stop without a ramp: the command stands after so many cycles. The machine goes off only if the motor cannot
/// follow that, by its following error.
pub(super) fn at_once(
    moving: &Moving,
    frames: &[Frame],
    limit: usize,
    ferror: FollowingError,
) -> Result<Measured, String> {
    let off = frames.iter().position(|f| !f.on);
    let speeds = moving.speeds(&frames[..off.unwrap_or(frames.len())]);
    let stands = speeds.iter().rposition(|speed| SAME / DT < *speed).map_or(0, |n| n + 1);
    if limit < stands {
        return Err(format!("it stands after {stands} cycles, at most {limit}"));
    }
    if let Some(off) = off {
        // The machine compares its command of the cycle before with what the motor has done since.
        let joint = moving.joint.ok_or("off without a joint that jogs")?;
        let [before, now] = [&frames[off - 1], &frames[off]];
        let error = (before.motors[joint] - now.feedback[joint]).abs();
        if error <= ferror.least {
            return Err(format!("off with a following error of {error}, at most {}", ferror.least));
        }
    }
    let rest = rest(frames);
    if rest + 1 >= frames.len() {
        return Err("it does not come to rest".to_owned());
    }
    Ok(Measured { effect: stands, rest, way: way(moving, &frames[..=rest]) })
}

/// Judges that a motion goes on.
pub(super) fn on(moving: &Moving, frames: &[Frame]) -> Result<Measured, String> {
    let speeds = moving.speeds(frames);
    if frames.iter().any(|f| !f.on) {
        return Err("the machine is switched off".to_owned());
    }
    match speeds.iter().position(|s| *s < moving.speed * 0.5) {
        Some(n) => Err(format!("it does not go on: slower from cycle {}", n + 1)),
        None => Ok(Measured::default()),
    }
}

/// Judges that nothing moves.
pub(super) fn stays(frames: &[Frame], when: &str) -> Result<(), String> {
    match frames.windows(2).position(|pair| !stands(&pair[0], &pair[1])) {
        None => Ok(()),
        Some(n) => {
            let frames = [&frames[n], &frames[n + 1]];
            let joints = frames.map(|f| f.joints.clone());
            Err(format!("{when}: something moves in cycle {}: {joints:?}", n + 1))
        }
    }
}

/// Returns the cycle in which the following error of a joint exceeds its limit.
pub(super) fn exceeds(frames: &[Frame], limit: FollowingError, joint: usize) -> Option<usize> {
    let exceeds = |pair: &[Frame]| {
        let speed = (pair[1].joints[joint] - pair[0].joints[joint]).abs() / DT;
        let by_speed = limit.most * speed / limit.velocity;
        let most = if limit.least < by_speed { by_speed } else { limit.least };
        pair[1].on && most < (pair[1].motors[joint] - pair[1].feedback[joint]).abs()
    };
    frames.windows(2).position(exceeds).map(|n| n + 1)
}
