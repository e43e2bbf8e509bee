//! The motion controller: joints, axes and spindles.
#![forbid(unsafe_code)]

mod axis;
mod commands;
mod compensation;
mod controller;
mod cycle;
mod guards;
mod homing;
mod included;
mod jogger;
mod joint;
mod lock;
mod names;
mod offset;
mod offsets;
mod outputs;
mod path;
mod pins;
mod safety;
mod setup;
mod simple_tp;
mod source;
mod spindle;
mod state;
mod status;
mod switch;
mod waits;

use commands::{configure::ConfigCache, interface::CommandInterface, service::Service};
use controller::{Controller, Handler};
use guards::{
    interlock::{Interlock, Lockout},
    stops::{MAX_STOPS, Stops},
};
use hal_component::{
    Builder, Component, Error, HomingRef,
    abi::{ArgSpec, component_flags},
};
use path::{
    Path,
    order::{HandOver, PathSetup},
    worker::{self, PlannerWorker},
};
use pins::Pins;
use setup::{MAX_JOINTS, Setup};
use state::State;
use std::sync::{Arc, Mutex};

/// Capacity of the command queue to the realtime side.
const QUEUE_LEN: usize = 256;

/// `loadrt motmod`.
#[derive(Debug)]
pub struct Motmod;

impl Component for Motmod {
    const NAME: &'static str = "motmod";
    const DOC: &'static str = "\
The motion controller: makes joints, axes and spindles do what commands ask.

It creates `servo-thread`, and `base-thread` when there is a base period. Add
`motion-command-handler` and then `motion-controller` to servo-thread. Kinematics such as
`trivkins` must be loaded before it.

`motion.configure joint=N …` sets the limits of each joint; then `motion.enable` switches the
machine on, `motion.home` finds home switches, `motion.jog` moves a joint or an axis, and
`motion.move` moves along a straight line.
It goes off by itself when `motion.enable` goes FALSE, a limit switch closes, an amplifier has a
fault, or a joint does not follow its command.

In a machine from an INI file, and after `loadrt iocontrol interlock=1`, it reads the e-stop of
iocontrol in every cycle: it is never switched on in e-stop, it goes off in the cycle in which an
e-stop comes, and it stays off until the next `motion.enable`. Elsewhere a script wires that itself:
lead `iocontrol.0.user-enable-out` and the chain of e-stop contacts to `motion.enable`.

Axes move only where the kinematics have a pose for the joints, and for that pose the same joints;
elsewhere teleop and coordinated mode, jogs of axes and moves are refused, naming a joint and its
place, and a machine that is switched on is in free mode. Whatever goes wrong, no motor is sent
farther in one cycle than its joint's max-velocity allows: the last commands are held, the machine
goes off, and a message and `motion.status` say which joint would have gone from where to where and
what moved it. A max-velocity that is lowered in motion makes what moves brake.

The snapshot `motion.status` holds the state at the end of each cycle as a whole: mode, pose, and
for each joint its position, velocity and switches. `halcmd snapshot motion.status` prints it, and
programs read it from shared memory, without delaying motion.

A homing module of the user that is loaded before `motmod` homes the joints in its place, and makes
the pins for that.

With kinematics of several types, such as `scarakins`, `motion.switchkins-type` says which one is in
force.

# Example

```hal
loadrt trivkins coordinates=XYZ
loadrt motmod num_joints=3
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd joint.0.motor-pos-fb
start
motion.configure joint=0 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
motion.enable
run 10ms
motion.jog joint=0 velocity=50
run 1s
motion.jog-stop joint=0
run 1s
getp motion.motion-enabled # -> TRUE
getp joint.0.in-position # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = setup::ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (handler, controller) = make(b)?;
        b.function(
            "motion-command-handler",
            "Takes the commands that wait, at most 16 in a cycle.",
            handler,
        )?;
        b.function(
            "motion-controller",
            "Carries out commands, watches for faults and moves the joints.",
            controller,
        )
    }
}

/// Declares everything except the two functions.
fn make(b: &mut Builder<'_>) -> Result<(Handler, Controller), Error> {
    let setup = Setup::read(b)?;
    let kinematics = b.kinematics()?;
    if kinematics.joints() > MAX_JOINTS {
        return Err(Error::new(format!(
            "the kinematics move {} joints, motmod has at most {MAX_JOINTS}",
            kinematics.joints()
        )));
    }
    if setup.extra_joints > 0 && kinematics.kind() != hal_component::KinematicsKind::Both {
        return Err(Error::new("num_extrajoints needs kinematics with kinstype=b"));
    }
    let interlock = Interlock::bind(b)?;
    let homing = homing_module(b, &setup)?;
    let pins = Pins::make(b, &setup, kinematics.types(), homing.is_none())?;
    if setup.base_period_ns > 0 {
        if setup.base_fp {
            b.thread("base-thread", setup.base_period_ns)?;
        } else {
            b.integer_thread("base-thread", setup.base_period_ns)?;
        }
    }
    b.thread("servo-thread", setup.servo_period_ns)?;

    let (to_handler, from_interface) = b.queue(QUEUE_LEN);
    let (to_controller, from_handler) = b.queue(QUEUE_LEN);
    let (hand, planner_hand) = b.shared(HandOver::new());
    let (path_setup, planner_setup) = b.seqlock(PathSetup::NONE);
    let planner = PlannerWorker::new(planner_hand, planner_setup, kinematics.for_worker());
    let doc = "Plans the path of coordinated moves ahead of the motion, within all limits.";
    b.worker("motmod.planner", doc, worker::PERIOD_NS, worker::ITEMS, planner)?;
    let path = Path::new(hand.clone(), path_setup);
    let (to_reader, stops) = b.queue(MAX_STOPS);
    let mut state =
        State::new(&setup, kinematics, homing, path, b.messages(), Stops::new(to_reader));
    state.has_interlock = interlock.is_bound();
    // The machine comes up in e-stop: the first cycle notes none.
    state.inputs.lockout = interlock.is_bound().then_some(Lockout::Commanded);
    let cache = ConfigCache::new(state.tables.clone());
    let interface = CommandInterface {
        to: to_handler,
        joints: setup.joints,
        spindles: setup.spindles,
        digital_out: setup.digital_out.len(),
        analog_out: setup.analog_out.len(),
        kinematics,
        cache: Arc::new(Mutex::new(cache)),
        line: state.line.clone(),
    };
    let status = status::Status::open(b)?;
    let service = Service {
        interface: interface.clone(),
        handled: to_controller.clone(),
        status: status.reader(),
        claimed: state.origin.claimed.clone(),
    };
    b.offer_motion(service)?;
    interface.open(b)?;
    let last_jump = state.last_jump.clone();
    commands::status::open(b, pins.clone(), status.reader(), last_jump, stops)?;
    let controller = Controller {
        from: from_handler,
        pins,
        interlock,
        kinematics,
        clock: b.clock(),
        last_ns: None,
        gaps: None,
        failures: None,
        cycle: 0,
        outputs: outputs::Outputs::default(),
        status,
        hand,
        state,
    };
    Ok((Handler::new(from_interface, to_controller), controller))
}

/// Returns the homing module that is loaded. It makes the pins for homing that it has.
fn homing_module(b: &mut Builder<'_>, setup: &Setup) -> Result<Option<HomingRef>, Error> {
    let period = setup.servo_period_ns as f64 * 1e-9;
    let found = b.homing(period, setup.joints, setup.extra_joints)?;
    match (&found, b.arg_text("homemod")) {
        (None, Some(name)) => Err(Error::new(format!(
            "the module '{name}' offers no homing: it needs the functions of homing.h, each with \
             EXPORT_SYMBOL"
        ))),
        (Some(found), Some(name)) if found.name() != name => Err(Error::new(format!(
            "the module '{}' offers homing, and '{name}' is to home: load that one alone",
            found.name()
        ))),
        _ => Ok(found),
    }
}

hal_component::export!(Motmod, included::Homemod, included::Tpmod);

#[cfg(test)]
mod tests;
