//! `halui`: the machine by buttons, knobs and lamps.

mod groups;
mod jog;
mod link;
mod panel;

use crate::pins::Made;
use groups::{
    General, Jog, Joint, Knob, Modes, Positions, Program, Selected, Speeds, Spindle, Stick, Tool,
};
use hal_component::{
    Arg, Builder, Component, Error, MotionCommand, MotionRef,
    abi::{ArgSpec, component_flags},
    motion_flags, motion_kind, motion_setting,
};
use jog::Jogging;
use link::{Machine, Task};
use panel::{AxisPart, JointPart, Panel, SpindlePart};
use std::sync::Mutex;

/// Period of the looks at the pins, in nanoseconds.
const PERIOD_NS: i64 = 10_000_000;

/// Letters of the axes.
pub(crate) const LETTERS: [char; 9] = ['x', 'y', 'z', 'a', 'b', 'c', 'u', 'v', 'w'];

/// `loadrt halui`.
#[derive(Debug)]
pub struct Halui;

impl Component for Halui {
    const NAME: &'static str = "halui";
    const DOC: &'static str = "\
The machine by buttons, knobs and lamps: each pin does what a command does, or shows what a status says.

It is loaded after `motmod`, and after `iocontrol` where e-stop, coolant, lubrication and the number of
the tool are wanted. A machine from an INI file that names it has it once `motmod` is loaded. It looks
at its pins every 10 ms.

A button acts when its pin goes TRUE; one that is TRUE from the start was not pressed. Jog buttons and
joysticks move as long as they are held, at the speed of jog-speed. A knob changes its value by scale
for each count while count-enable is TRUE, or by its buttons; the override of rapid moves ends at 1.
What `halui` commands is local: it is refused while a program moves the machine, except for abort,
pause and overrides. Overrides become those of the task.

Modes, programs and MDI need a task. Without one, pause, resume, step and stop act on the path of
commands, and requests for a task are reported as errors. Each line of `mdi_commands`, from [HALUI]
MDI_COMMAND, has a pin mdi-command-NN.

# Example

```hal
loadrt trivkins coordinates=XYZ
loadrt motmod num_joints=3
loadrt halui coordinates=XYZ
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net x joint.0.motor-pos-cmd joint.0.motor-pos-fb
start
motion.configure joint=0 max-velocity=100 max-acceleration=1000 min-limit=-500 max-limit=500 ferror=1 min-ferror=1
run 50ms
setp halui.machine.on TRUE
run 50ms
getp halui.machine.is-on # -> TRUE
setp halui.joint.jog-speed 20
setp halui.joint.0.plus TRUE
run 1s
setp halui.joint.0.plus FALSE
run 1s
getp joint.0.in-position # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("coordinates", "Letters of the machine's axes, of XYZABCUVW.").or("XYZ"),
        &Arg::text("mdi_commands", "Lines of MDI, separated by |, at most 64.").or(""),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let letters = letters(&b.arg_text("coordinates").unwrap_or_default())?;
        let lines = lines(&b.arg_text("mdi_commands").unwrap_or_default())?;
        let motion = b.motion()?.ok_or_else(|| {
            Error::new("there is no motion controller for it: loadrt motmod first")
        })?;
        let io = b.iocontrol()?.map(Mutex::new);
        let task = Task::default();
        b.offer_operator(task.clone())?;
        let machine = Machine { motion, io, task, say: b.messages() };
        let panel = panel(b, machine, &letters, lines)?;
        b.task("halui", "Looks at the pins and shows the state.", PERIOD_NS, panel)
    }
}

fn letters(text: &str) -> Result<Vec<char>, Error> {
    let letters = text.chars().filter(|c| !c.is_whitespace()).map(|c| c.to_ascii_lowercase());
    let found: Vec<char> = letters.collect();
    match found.iter().find(|c| !LETTERS.contains(c)) {
        Some(c) => Err(Error::new(format!("coordinates has {c}, which is none of XYZABCUVW"))),
        None if found.is_empty() || found.len() > 16 => {
            Err(Error::new(format!("coordinates has {} letters, must have 1 to 16", found.len())))
        }
        None => Ok(found),
    }
}

fn lines(text: &str) -> Result<Vec<String>, Error> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    let lines: Vec<String> = text.split('|').map(str::trim).map(str::to_owned).collect();
    // The numbers of the pins are those of the lines.
    if let Some(n) = lines.iter().position(String::is_empty) {
        return Err(Error::new(format!("line {n} of mdi_commands is empty, counted from 0")));
    }
    if lines.len() > 64 {
        return Err(Error::new(format!("{} lines of MDI, at most 64", lines.len())));
    }
    let max = hal_component::abi::OPERATOR_TEXT;
    match lines.iter().find(|l| l.len() > max) {
        Some(line) => {
            Err(Error::new(format!("a line of MDI has {} bytes, at most {max}", line.len())))
        }
        None => Ok(lines),
    }
}

/// Returns the number of joints or spindles that motion has.
pub(crate) fn count(motion: &MotionRef, flag: u32, name: &str) -> u32 {
    let configure = configure(flag, name);
    let exists =
        |index: &u32| motion.setting(&MotionCommand { index: *index, ..configure }).is_some();
    u32::try_from((0..16).take_while(exists).count()).unwrap_or(0)
}

/// Returns a command that changes a setting, or names it.
pub(crate) fn configure(flags: u32, name: &str) -> MotionCommand {
    let code = motion_setting::NAMES.iter().position(|n| *n == name);
    let setting = code.and_then(|n| u32::try_from(n).ok()).unwrap_or(u32::MAX);
    MotionCommand { flags, setting, ..MotionCommand::new(motion_kind::CONFIGURE) }
}

fn panel(
    b: &mut Builder<'_>,
    machine: Machine,
    letters: &[char],
    lines: Vec<String>,
) -> Result<Panel, Error> {
    let joints = count(&machine.motion, motion_flags::JOINT, "ferror");
    let top = machine.motion.setting(&configure(0, "max-velocity"));
    let first = LETTERS.iter().position(|l| letters.contains(l));
    let first = first.and_then(|n| u32::try_from(n).ok()).unwrap_or(0);
    let spindles = count(&machine.motion, motion_flags::SPINDLE, "max-forward-velocity");
    let panel = Panel {
        general: General::make(b, "halui.")?,
        modes: Modes::make(b, "halui.")?,
        program: Program::make(b, "halui.")?,
        tool: Tool::make(b, "halui.")?,
        offsets: LETTERS
            .iter()
            .map(|l| {
                let doc = format!("Tool offset of {l} in machine units or degrees.");
                b.item(&format!("halui.tool.length_offset.{l}"), &doc, 0.0)
            })
            .collect::<Result<_, _>>()?,
        feed: Knob::factor(b, "halui.feed-override.")?,
        rapid: Knob::factor(b, "halui.rapid-override.")?,
        velocity: Knob::value(b, "halui.max-velocity.", top.unwrap_or(f64::INFINITY))?,
        spindles: (0..spindles).map(|n| spindle(b, n)).collect::<Result<_, _>>()?,
        joint_speeds: Speeds::make(b, "halui.joint.")?,
        joints: (0..joints).map(|n| joint(b, n)).collect::<Result<_, _>>()?,
        joint: Joint::make(b, "halui.joint.selected.")?,
        joint_jog: Jog::make(b, "halui.joint.selected.")?,
        joint_jogging: Jogging::default(),
        axis_speeds: Speeds::make(b, "halui.axis.")?,
        axes: LETTERS.iter().map(|l| axis(b, *l, letters)).collect::<Result<_, _>>()?,
        axis_jog: Jog::make(b, "halui.axis.selected.")?,
        axis_jogging: Jogging::default(),
        mdi: (0..lines.len())
            .map(|n| {
                let name = format!("halui.mdi-command-{n:02}");
                Made::made(b, &name, "Executes this line of mdi_commands.", false)
            })
            .collect::<Result<_, _>>()?,
        lines,
        selected: (0, first),
        top_velocity: top,
        machine,
    };
    panel.show_selected();
    Ok(panel)
}

fn spindle(b: &mut Builder<'_>, n: u32) -> Result<SpindlePart, Error> {
    let prefix = format!("halui.spindle.{n}.");
    Ok(SpindlePart {
        pins: Spindle::make(b, &prefix)?,
        knob: Knob::factor(b, &format!("{prefix}override."))?,
        speed: 0.0,
    })
}

fn joint(b: &mut Builder<'_>, n: u32) -> Result<JointPart, Error> {
    let prefix = format!("halui.joint.{n}.");
    Ok(JointPart {
        pins: Joint::make(b, &prefix)?,
        lamp: Selected::make(b, &prefix)?,
        jog: Jog::make(b, &prefix)?,
        stick: Stick::make(b, &prefix)?,
        jogging: Jogging::default(),
    })
}

fn axis(b: &mut Builder<'_>, letter: char, letters: &[char]) -> Result<AxisPart, Error> {
    let prefix = format!("halui.axis.{letter}.");
    let shown = if letters.contains(&letter) {
        Some((Selected::make(b, &prefix)?, Positions::make(b, &prefix)?))
    } else {
        None
    };
    Ok(AxisPart {
        jog: Jog::make(b, &prefix)?,
        stick: Stick::make(b, &prefix)?,
        shown,
        jogging: Jogging::default(),
    })
}
