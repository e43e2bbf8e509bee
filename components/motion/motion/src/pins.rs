//! Pins and parameters of motion, grouped by the object that they belong to.

mod axis;
mod general;
mod joint;
mod lists;
mod shown;
mod spindle;

pub(crate) use axis::AxisPins;
pub(crate) use general::{GeneralPins, Traces, WatchPins};
pub(crate) use joint::{HomingPins, JointPins};
pub(crate) use lists::{ExtraPins, Lists, UnlockPins};
pub(crate) use shown::{Shown, packed};
pub(crate) use spindle::SpindlePins;

use crate::{setup::Setup, switch::SwitchPins};
use hal_component::{Builder, Decl, Error, Field, ParamRo, Touch};

/// The axis letters, in the order of a pose.
pub(crate) const LETTERS: [char; 9] = ['x', 'y', 'z', 'a', 'b', 'c', 'u', 'v', 'w'];

/// Declares a struct of pins with their names, defaults, old names and documentation, and with other pins that it may
/// have.
macro_rules! pins {
    (
        $(#[$about:meta])* $name:ident {
            $($(#[doc = $doc:literal])+
            $field:ident: $ty:ty = $initial:expr, $pin:literal
                $(was $old:literal)? $([$safety:ident])?;)*
        }
        $($(#[doc = $about_part:literal])+ optional $part:ident: $part_ty:ty)?
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, hal_component::Touch)]
        pub(crate) struct $name {
            $($(#[doc = $doc])+ pub(crate) $field: $ty,)*
            $($(#[doc = $about_part])+ pub(crate) $part: Option<$part_ty>,)?
        }

        impl $name {
            /// Creates the pins under `prefix`; their old names begin with the old prefix, if there is one.
            pub(crate) fn make(
                b: &mut hal_component::Builder<'_>,
                prefix: &str,
                old: Option<&str>,
            ) -> Result<Self, hal_component::Error> {
                Ok(Self {
                    $($field: $crate::pins::make(
                        b,
                        &[prefix, $pin],
                        &[old.unwrap_or_default() $(, $old)?],
                        concat!($($doc),+),
                        $crate::pins::pins!(@safety $($safety)?),
                        $initial,
                    )?,)*
                    $($part: None,)?
                })
            }
        }
    };
    (@safety safety) => { true };
    (@safety) => { false };
}
pub(crate) use pins;

/// Creates one pin. `old` is the old prefix and the old name, or the prefix alone if the pin has no old name.
pub(crate) fn make<F: Field>(
    b: &mut Builder<'_>,
    name: &[&str; 2],
    old: &[&str],
    doc: &str,
    safety: bool,
    initial: F::Value,
) -> Result<F, Error> {
    let name = name.concat();
    let old = match old {
        [prefix, pin] if !prefix.is_empty() => format!("{prefix}{pin}"),
        _ => String::new(),
    };
    let decl = Decl::new(&name, doc.trim()).old(&old);
    F::make(b, if safety { decl.safety() } else { decl }, initial)
}

/// All pins and parameters of motion.
#[derive(Clone, Debug, Touch)]
pub(crate) struct Pins {
    pub(crate) general: GeneralPins,
    pub(crate) traces: Traces,
    pub(crate) watch: WatchPins,
    pub(crate) lists: Lists,
    pub(crate) joints: Vec<JointPins>,
    /// For each joint, TRUE while a sensor measures motor-pos-fb.
    pub(crate) measured: Vec<ParamRo<bool>>,
    pub(crate) unlocks: Vec<UnlockPins>,
    pub(crate) extras: Vec<ExtraPins>,
    pub(crate) axes: Vec<AxisPins>,
    pub(crate) spindles: Vec<SpindlePins>,
    pub(crate) switch: SwitchPins,
}

impl Pins {
    /// Creates all pins; those for homing only if the controller itself homes.
    pub(crate) fn make(
        b: &mut Builder<'_>,
        setup: &Setup,
        types: u32,
        homes: bool,
    ) -> Result<Self, Error> {
        let (mut joints, mut unlocks, mut extras) = (Vec::new(), Vec::new(), Vec::new());
        let mut measured = Vec::new();
        for n in 0..setup.joints {
            let prefix = format!("joint.{n}.");
            let mut joint = JointPins::make(b, &prefix, Some(&format!("axis.{n}.")))?;
            if homes {
                joint.homing = Some(HomingPins::make(b, &prefix, Some(&format!("axis.{n}.")))?);
            }
            measured.push(joint.measured(b, &prefix)?);
            joints.push(joint);
            if setup.unlock_mask >> n & 1 == 1 {
                unlocks.push(UnlockPins::make(b, &prefix, Some(&format!("axis.{n}.")))?);
            }
            if n >= setup.joints - setup.extra_joints {
                extras.push(ExtraPins::make(b, &prefix, None)?);
            }
        }
        let mut axes = Vec::new();
        for letter in LETTERS {
            axes.push(AxisPins::make(b, &format!("axis.{letter}."), None)?);
        }
        let mut spindles = Vec::new();
        for n in 0..setup.spindles {
            let old = (n == 0).then_some("motion.spindle-");
            spindles.push(SpindlePins::make(b, &format!("spindle.{n}."), old)?);
        }
        Ok(Self {
            general: GeneralPins::make(b, "motion.", None)?,
            traces: Traces::make(b, "", None)?,
            watch: WatchPins::make(b, "motion.", None)?,
            lists: Lists::make(b, setup)?,
            joints,
            measured,
            unlocks,
            extras,
            axes,
            spindles,
            switch: SwitchPins::make(b, types)?,
        })
    }
}
