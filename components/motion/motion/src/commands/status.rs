//! `motion.status`: the state of the machine in a few lines.

use crate::{
    guards::last_jump::LastJump,
    guards::stops::Stop,
    pins::{JointPins, LETTERS, Pins},
};
use hal_component::{
    Arg, Builder, Call, Error, MotionStatus, Receiver, SnapshotReader, Wait, abi::ArgSpec,
};
use std::sync::{Arc, Mutex, PoisonError};

const DOC: &str = "\
Tells how the machine is: one line for all, one per joint that takes part, one per axis that is not
at zero. After a joint would have jumped, one line says where, how far and what moved it, until the
machine is switched on again. While motion waits at rest, one line says for what, since when, and how to go on. At the
end, one line for each stop since the last motion.status: its time and its cause.";

const STOPS: ArgSpec =
    Arg::bit("stops", "FALSE: leaves the stops to the next motion.status.").or("TRUE");

/// Declares the command.
pub(crate) fn open(
    b: &mut Builder<'_>,
    pins: Pins,
    status: SnapshotReader<MotionStatus>,
    last_jump: Arc<LastJump>,
    stops: Receiver<Stop>,
) -> Result<(), Error> {
    let stops = Mutex::new(stops);
    b.command("motion.status", DOC, &[&STOPS], move |call| {
        tell(&pins, status.get().as_ref(), &last_jump, call);
        if call.bit("stops") == Some(false) {
            return Ok(());
        }
        let mut stops = stops.lock().unwrap_or_else(PoisonError::into_inner);
        read_stops(&mut stops).iter().for_each(|line| call.reply(line));
        Ok(())
    })
}

/// Returns the stops since the last call, as lines of text.
fn read_stops(from: &mut Receiver<Stop>) -> Vec<String> {
    let stops = core::iter::from_fn(|| from.take());
    stops
        .map(|stop| {
            // Braces mark names of pins, which messages explain.
            let cause = stop.cause.replace(['{', '}'], "");
            format!("stop time={:.3} s: {cause}", stop.time_ns as f64 / 1e9)
        })
        .collect()
}

fn tell(pins: &Pins, status: Option<&MotionStatus>, last_jump: &LastJump, call: &Call<'_>) {
    let g = &pins.general;
    let mode = match (g.coord_mode.get(), g.teleop_mode.get()) {
        (true, _) => "coord",
        (false, true) => "teleop",
        (false, false) => "free",
    };
    call.reply(&format!(
        "machine enabled={} mode={mode} in-position={} homed={} velocity={:.6} \
         distance-to-go={:.6}",
        bit(g.motion_enabled.get()),
        bit(g.in_position.get()),
        bit(g.is_all_homed.get()),
        g.current_vel.get(),
        g.distance_to_go.get(),
    ));
    if let Some(line) = status.and_then(wait_line) {
        call.reply(&line);
    }
    if let Some(jump) = last_jump.get() {
        call.reply(&format!(
            "jump joint={} from={:.6} to={:.6} allowed={:.6} by {}",
            jump.joint, jump.from, jump.to, jump.allowed, jump.mover
        ));
    }
    for (n, joint) in pins.joints.iter().enumerate().filter(|(_, j)| j.active.get()) {
        // A homing module may have no pin for it.
        let homed = status.and_then(|s| s.joint_homed.get(n)).is_some_and(|homed| *homed);
        call.reply(&line(n, joint, homed));
    }
    for (letter, axis) in LETTERS.iter().zip(&pins.axes).filter(|(_, a)| a.pos_cmd.get() != 0.0) {
        call.reply(&format!("axis {letter} position={:.6}", axis.pos_cmd.get()));
    }
}

/// Returns the line about what motion waits for, as `task.status` has it.
fn wait_line(status: &MotionStatus) -> Option<String> {
    let (wait, number) = (Wait::of(status.wait), status.wait_number);
    let until = if status.wait_ends { "itself" } else { "never" };
    (wait != Wait::Nothing).then(|| {
        let (name, text) = (wait.name(), wait.text("motion", number));
        let since = status.wait_since_ns as f64 / 1e9;
        format!("wait for={name} number={number} since={since:.3} until={until} {text}")
    })
}

fn line(n: usize, joint: &JointPins, homed: bool) -> String {
    format!(
        "joint {n} position={:.6} feedback={:.6} velocity={:.6} following-error={:.6} homed={} \
         in-position={} limit={} error={}",
        joint.pos_cmd.get(),
        joint.pos_fb.get(),
        joint.vel_cmd.get(),
        joint.f_error.get(),
        bit(homed),
        bit(joint.in_position.get()),
        match (joint.neg_hard_limit.get(), joint.pos_hard_limit.get()) {
            (true, true) => "both",
            (true, false) => "negative",
            (false, true) => "positive",
            (false, false) => "none",
        },
        bit(joint.error.get()),
    )
}

const fn bit(value: bool) -> &'static str {
    if value { "TRUE" } else { "FALSE" }
}
