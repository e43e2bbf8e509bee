//! `inihal`: settings of an INI file as pins.

use crate::halui::{LETTERS, configure, count};
use hal_component::{
    Builder, Component, Error, In, Messages, MotionCommand, MotionRef, MotionRefusal, MotionToken,
    Period, Touch, Update, abi::component_flags, motion_flags,
};

/// Period of the looks at the pins, in nanoseconds.
const PERIOD_NS: i64 = 10_000_000;

/// Settings of a joint: name of the pin, of the setting, and description.
const JOINT: &[(&str, &str, &str)] = &[
    ("backlash", "backlash", "Backlash in machine units."),
    ("ferror", "ferror", "Following error allowed at max_velocity, in machine units."),
    ("min_ferror", "min-ferror", "Following error allowed at any velocity, in machine units."),
    ("min_limit", "min-limit", "Lowest position in machine units."),
    ("max_limit", "max-limit", "Highest position in machine units."),
    ("max_velocity", "max-velocity", "Highest velocity in machine units/s."),
    ("max_acceleration", "max-acceleration", "Highest acceleration in machine units/s²."),
    ("home", "home", "Position at the end of homing in machine units."),
    ("home_offset", "home-offset", "Position of the home switch or index in machine units."),
];

/// Settings of an axis.
const AXIS: &[(&str, &str, &str)] = &[
    ("min_limit", "min-limit", "Lowest position in machine units."),
    ("max_limit", "max-limit", "Highest position in machine units."),
    ("max_velocity", "max-velocity", "Highest velocity in machine units/s."),
    ("max_acceleration", "max-acceleration", "Highest acceleration in machine units/s²."),
];

/// Settings of coordinated moves.
const TRAJ: &[(&str, &str, &str)] = &[
    ("traj_default_velocity", "default-velocity", "Velocity if none is given, in machine units/s."),
    ("traj_max_velocity", "max-velocity", "Highest velocity along a path in machine units/s."),
    (
        "traj_max_acceleration",
        "max-acceleration",
        "Highest acceleration along a path in machine units/s².",
    ),
];

const WITHOUT_EFFECT: &str =
    "Accepted for files that set it, without effect: the planner has no such setting.";

/// `loadrt inihal`.
#[derive(Debug)]
pub struct Inihal;

impl Component for Inihal {
    const NAME: &'static str = "inihal";
    const DOC: &'static str = "\
Settings of an INI file as pins: each change is passed to `motion.configure`.

It is loaded after `motmod` was configured, and its pins begin with the settings in force. It looks at
them every 10 ms. A value that motion refuses is reported, and the setting stays as it is until the pin
changes again. Limits that become tighter take effect on what moves: it brakes within them.

The pins ini.traj_arc_blend_* and ini.traj_default_acceleration have no effect, because the planner needs
no such settings.

# Example

```hal
loadrt trivkins coordinates=XYZ
loadrt motmod num_joints=3
addf motion-command-handler servo-thread
addf motion-controller servo-thread
motion.configure joint=0 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
loadrt inihal
start
getp ini.0.max_velocity # -> 100
setp ini.0.max_velocity 40
run 100ms
getp ini.0.max_velocity # -> 40
```";
    const FLAGS: u32 = component_flags::ONCE;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let motion = b.motion()?.ok_or_else(|| {
            Error::new("there is no motion controller for it: loadrt motmod first")
        })?;
        let mut settings = Vec::new();
        let mut sequences = Vec::new();
        for index in 0..count(&motion, motion_flags::JOINT, "ferror") {
            let joint = Object { flags: motion_flags::JOINT, index };
            for row in JOINT {
                settings.push(Setting::make(b, &motion, joint, &format!("{index}."), row)?);
            }
            sequences.push(Sequence::make(b, &motion, joint)?);
        }
        for (index, letter) in (0_u32..).zip(LETTERS) {
            let axis = Object { flags: motion_flags::AXIS, index };
            for row in AXIS {
                settings.push(Setting::make(b, &motion, axis, &format!("{letter}."), row)?);
            }
        }
        for row in TRAJ {
            let path = Object { flags: 0, index: 0 };
            settings.push(Setting::make(b, &motion, path, "", row)?);
        }
        without_effect(b)?;
        let work = Pins { motion, settings, sequences, say: b.messages() };
        b.task("inihal", "Passes changes of the pins to motion.", PERIOD_NS, work)
    }
}

/// Declares the pins of settings that the planner does not have.
fn without_effect(b: &mut Builder<'_>) -> Result<(), Error> {
    for (name, initial) in [
        ("ini.traj_default_acceleration", 0.0),
        ("ini.traj_arc_blend_gap_cycles", 4.0),
        ("ini.traj_arc_blend_ramp_freq", 100.0),
        ("ini.traj_arc_blend_tangent_kink_ratio", 0.1),
    ] {
        let _: In<f64> = b.item(name, WITHOUT_EFFECT, initial)?;
    }
    let _: In<bool> = b.item("ini.traj_arc_blend_enable", WITHOUT_EFFECT, true)?;
    let _: In<bool> = b.item("ini.traj_arc_blend_fallback_enable", WITHOUT_EFFECT, false)?;
    let _: In<i32> = b.item("ini.traj_arc_blend_optimization_depth", WITHOUT_EFFECT, 50)?;
    Ok(())
}

/// The object of a setting, as flag and number.
#[derive(Clone, Copy, Debug)]
struct Object {
    flags: u32,
    index: u32,
}

impl Object {
    fn command(self, setting: &str, value: f64) -> MotionCommand {
        MotionCommand { index: self.index, value, ..configure(self.flags, setting) }
    }
}

/// A setting with a number.
#[derive(Debug, Touch)]
struct Setting {
    pin: In<f64>,
    #[state]
    command: MotionCommand,
    /// Value at the last look.
    #[state]
    last: f64,
}

impl Setting {
    fn make(
        b: &mut Builder<'_>,
        motion: &MotionRef,
        object: Object,
        prefix: &str,
        (pin, setting, doc): &(&str, &str, &str),
    ) -> Result<Self, Error> {
        let command = object.command(setting, 0.0);
        let last = motion.setting(&command).unwrap_or(0.0);
        let pin = b.item(&format!("ini.{prefix}{pin}"), doc, last)?;
        Ok(Self { pin, command, last })
    }
}

/// Place of a joint in the order of homing.
#[derive(Debug, Touch)]
struct Sequence {
    pin: In<i32>,
    #[state]
    command: MotionCommand,
    #[state]
    last: i32,
}

impl Sequence {
    fn make(b: &mut Builder<'_>, motion: &MotionRef, joint: Object) -> Result<Self, Error> {
        let command = joint.command("home-sequence", 0.0);
        let last = hal_component::to_s32(motion.setting(&command).unwrap_or(0.0));
        let name = format!("ini.{}.home_sequence", joint.index);
        let pin = b.item(&name, "Place in the order of homing, -1000 to 1000.", last)?;
        Ok(Self { pin, command, last })
    }
}

/// All pins of `inihal`.
#[derive(Debug, Touch)]
struct Pins {
    motion: MotionRef,
    settings: Vec<Setting>,
    sequences: Vec<Sequence>,
    say: Messages,
}

impl Update for Pins {
    fn update(&mut self, _: Period) {
        for sequence in &mut self.sequences {
            let now = sequence.pin.get();
            let command = MotionCommand { value: f64::from(now), ..sequence.command };
            if now != sequence.last && send(&self.motion, &self.say, &command) {
                sequence.last = now;
            }
        }
        // Twice: a limit may be possible only after its opposite has changed.
        for is_last in [false, true] {
            for setting in &mut self.settings {
                let now = setting.pin.get();
                if now.to_bits() == setting.last.to_bits() {
                    continue;
                }
                let command = MotionCommand { value: now, ..setting.command };
                match self.motion.push(MotionToken::LOCAL, &command) {
                    Ok(_) => setting.last = now,
                    Err(MotionRefusal::Refused(_)) if is_last => {
                        refused(&self.say, &command);
                        setting.last = now;
                    }
                    Err(_) => {}
                }
            }
        }
    }
}

/// Sends a command. Returns false if it has to be sent again.
fn send(motion: &MotionRef, say: &Messages, command: &MotionCommand) -> bool {
    match motion.push(MotionToken::LOCAL, command) {
        Ok(_) => true,
        Err(MotionRefusal::Full | MotionRefusal::NotOwner) => false,
        Err(MotionRefusal::Refused(_)) => {
            refused(say, command);
            true
        }
    }
}

fn refused(say: &Messages, command: &MotionCommand) {
    let (index, value) = (f64::from(command.index), command.value);
    match command.flags {
        motion_flags::JOINT => say
            .error("{} is not possible for a pin of joint {}: the setting stays", &[value, index]),
        motion_flags::AXIS => say.error(
            "{} is not possible for a pin of axis {} (x is 0): the setting stays",
            &[value, index],
        ),
        _ => say.error("{} is not possible for a pin ini.traj_*: the setting stays", &[value]),
    }
}
