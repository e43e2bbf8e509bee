//! Realtime. Record of the jump that switched the machine off: the joint, its intended step, and the source of the motion.

use crate::{
    guards::step::Jump,
    names::{JointText, joint_text},
};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Source of a joint's motion, in the order of [`WORDS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mover {
    Nothing,
    Jog,
    Wheel,
    Homing,
    TeleopJog,
    TeleopWheel,
    Move,
    ExternalOffset,
    Kinematics,
    PosthomeCmd,
    Correction,
}

/// Texts for a source: for tickets, for the operator, and by itself.
pub(crate) struct Words {
    pub(crate) cause: &'static str,
    pub(crate) say: JointText,
    name: &'static str,
}

macro_rules! words {
    ($name:literal) => {
        Words {
            cause: concat!("a joint would have jumped: ", $name),
            say: joint_text!(
                "",
                concat!(
                    " would jump from {} to {} in one cycle, where at most {} is allowed: ",
                    $name,
                    "; the machine is switched off"
                )
            ),
            name: $name,
        }
    };
}

static WORDS: [Words; 11] = [
    words!("nothing should move it"),
    words!("a jog of the joint"),
    words!("the joint's jog wheel"),
    words!("homing"),
    words!("a jog of an axis"),
    words!("an axis's jog wheel"),
    words!("a coordinated move"),
    words!("an external offset"),
    words!("the kinematics, while no axis moves"),
    words!("its posthome-cmd"),
    words!("its backlash correction"),
];

/// Returns the texts for a source.
pub(crate) fn words(mover: Mover) -> &'static Words {
    numbered(mover as usize)
}

fn numbered(mover: usize) -> &'static Words {
    WORDS.get(mover).unwrap_or(&WORDS[0])
}

/// Jump that switched the machine off, kept until the machine is switched on again.
#[derive(Debug, Default)]
pub(crate) struct LastJump {
    /// Number of the joint plus 1; 0 if there was no jump.
    joint: AtomicU32,
    mover: AtomicU32,
    from: AtomicU64,
    to: AtomicU64,
    allowed: AtomicU64,
}

/// Contents of a [`LastJump`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct JumpRecord {
    pub(crate) joint: u32,
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) allowed: f64,
    pub(crate) mover: &'static str,
}

impl LastJump {
    pub(crate) fn set(&self, n: usize, mover: Mover, jump: Jump) {
        self.mover.store(mover as u32, Ordering::Relaxed);
        self.from.store(jump.from.to_bits(), Ordering::Relaxed);
        self.to.store(jump.to.to_bits(), Ordering::Relaxed);
        self.allowed.store(jump.allowed.to_bits(), Ordering::Relaxed);
        let joint = u32::try_from(n).map_or(0, |n| n.wrapping_add(1));
        self.joint.store(joint, Ordering::Release); // Pairs with `get`.
    }

    pub(crate) fn clear(&self) {
        self.joint.store(0, Ordering::Relaxed);
    }

    /// Control side: returns the jump, if one switched the machine off.
    pub(crate) fn get(&self) -> Option<JumpRecord> {
        // Pairs with `set`.
        let joint = self.joint.load(Ordering::Acquire).checked_sub(1)?;
        let number = |n: &AtomicU64| f64::from_bits(n.load(Ordering::Relaxed));
        Some(JumpRecord {
            joint,
            from: number(&self.from),
            to: number(&self.to),
            allowed: number(&self.allowed),
            mover: numbered(self.mover.load(Ordering::Relaxed) as usize).name,
        })
    }
}
