//! Pins of a device, with the names that LinuxCNC's `hal_input` gives.

use crate::{
    bus::{Abilities, AxisRange},
    codes,
    described::{WheelKind, Wheels},
    event::kind,
    spec::Features,
};
use hal_component::{Builder, Error, In, Out, ParamRo, ParamRw, Touch, pins};

pins! {
    /// State of a device.
    pub(crate) struct StatePins {
        /// TRUE while the node of the device can be read.
        connected: Out<bool> = "connected", false;
        /// TRUE while the node of the device cannot be read: its buttons are FALSE then, and its axes at their centres.
        fault: Out<bool> = "fault", false;
        /// TRUE switches the motion controller off while the node of the device cannot be read.
        required: ParamRw<bool> = "required", false;
    }
}

/// Pins of a button or key.
#[derive(Debug, Touch)]
pub(crate) struct KeyPins {
    #[state]
    pub(crate) code: u16,
    pub(crate) is_down: Out<bool>,
    pub(crate) not: Out<bool>,
}

/// Pins of an absolute axis.
#[derive(Debug, Touch)]
pub(crate) struct AxisPins {
    #[state]
    pub(crate) code: u16,
    #[state]
    pub(crate) range: AxisRange,
    pub(crate) counts: Out<i32>,
    pub(crate) position: Out<f64>,
    pub(crate) is_pos: Out<bool>,
    pub(crate) is_neg: Out<bool>,
    pub(crate) scale: In<f64>,
    pub(crate) offset: In<f64>,
    pub(crate) fuzz: In<i32>,
    pub(crate) flat: In<i32>,
}

/// Pins of a relative axis.
#[derive(Debug, Touch)]
pub(crate) struct WheelPins {
    #[state]
    pub(crate) code: u16,
    #[state]
    pub(crate) kind: WheelKind,
    pub(crate) counts: Out<i32>,
    pub(crate) position: Out<f64>,
    pub(crate) reset: In<bool>,
    pub(crate) scale: In<f64>,
}

/// Pins of a light.
#[derive(Debug, Touch)]
pub(crate) struct LightPins {
    #[state]
    pub(crate) code: u16,
    pub(crate) is_on: In<bool>,
    pub(crate) invert: In<bool>,
}

/// All pins of a device.
#[derive(Debug, Touch)]
pub(crate) struct DevicePins {
    pub(crate) state: StatePins,
    pub(crate) keys: Vec<KeyPins>,
    pub(crate) axes: Vec<AxisPins>,
    pub(crate) wheels: Vec<WheelPins>,
    pub(crate) lights: Vec<LightPins>,
}

/// Returns the abilities that have pins.
pub(crate) fn chosen(abilities: &Abilities, features: Features) -> Abilities {
    let Abilities { keys, abs, rel, leds } = abilities.clone();
    Abilities {
        keys: if features.keys { keys } else { Vec::new() },
        abs: if features.abs { abs } else { Vec::new() },
        rel: if features.rel { rel } else { Vec::new() },
        leds: if features.leds { leds } else { Vec::new() },
    }
}

impl DevicePins {
    /// Makes the pins of a device; `prefix` is `input.0` for the first.
    ///
    /// # Errors
    /// A name is taken.
    pub(crate) fn make(
        b: &mut Builder<'_>,
        prefix: &str,
        abilities: &Abilities,
        wheels: &Wheels,
    ) -> Result<Self, Error> {
        let state = StatePins::make(b, prefix)?;
        let keys = abilities.keys.iter().map(|code| key(b, prefix, *code));
        let keys = keys.collect::<Result<_, _>>()?;
        let mut made = Vec::new();
        for code in &abilities.rel {
            let meaning = wheels.get(usize::from(*code)).copied().unwrap_or_default();
            made.push(wheel(b, prefix, *code, meaning)?);
        }
        let axes = abilities.abs.iter().map(|(code, range)| axis(b, prefix, *code, *range));
        let axes = axes.collect::<Result<_, _>>()?;
        let lights = abilities.leds.iter().map(|code| light(b, prefix, *code));
        let lights = lights.collect::<Result<_, _>>()?;
        Ok(Self { state, keys, axes, wheels: made, lights })
    }
}

fn key(b: &mut Builder<'_>, prefix: &str, code: u16) -> Result<KeyPins, Error> {
    let name = format!("{prefix}.{}", codes::name(kind::KEY, code));
    let about = "TRUE while it is down, unless it was down when the device came back";
    Ok(KeyPins {
        code,
        is_down: b.item(&name, about, false)?,
        not: b.item(&format!("{name}-not"), "The opposite, TRUE also without the device", true)?,
    })
}

fn axis(b: &mut Builder<'_>, prefix: &str, code: u16, range: AxisRange) -> Result<AxisPins, Error> {
    let name = format!("{prefix}.{}", codes::name(kind::ABS, code));
    let half = (f64::from(range.max) - f64::from(range.min)) / 2.0;
    let scale = if half == 0.0 { 1.0 } else { half };
    let offset = f64::from(range.min) + half;
    let min = format!("{name}-min");
    let _: ParamRo<i32> = b.item(&min, "Smallest value that the device states", range.min)?;
    let max = format!("{name}-max");
    let _: ParamRo<i32> = b.item(&max, "Largest value that the device states", range.max)?;
    Ok(AxisPins {
        code,
        range,
        counts: b.item(
            &format!("{name}-counts"),
            "Value of the device after flat and fuzz; offset without the device",
            hal_component::to_s32(offset),
        )?,
        position: b.item(
            &format!("{name}-position"),
            "(counts - offset) / scale; 0 at the centre and without the device",
            0.0,
        )?,
        is_pos: b.item(&format!("{name}-is-pos"), "TRUE if position is above 0.01", false)?,
        is_neg: b.item(&format!("{name}-is-neg"), "TRUE if position is below -0.01", false)?,
        scale: b.item(&format!("{name}-scale"), "Counts per unit of position; 0 is 1", scale)?,
        offset: b.item(&format!("{name}-offset"), "Counts at the centre", offset)?,
        fuzz: b.item(&format!("{name}-fuzz"), "Change of counts that is noise", range.fuzz)?,
        flat: b.item(
            &format!("{name}-flat"),
            "Distance from the centre that is the centre, in counts",
            range.flat,
        )?,
    })
}

fn wheel(
    b: &mut Builder<'_>,
    prefix: &str,
    code: u16,
    meaning: WheelKind,
) -> Result<WheelPins, Error> {
    let name = format!("{prefix}.{}", codes::name(kind::REL, code));
    let about = if meaning == WheelKind::Ring {
        "Place of the ring; 0 without the device"
    } else {
        "Sum of the movements since reset, which wraps; it stays without the device"
    };
    Ok(WheelPins {
        code,
        kind: meaning,
        counts: b.item(&format!("{name}-counts"), about, 0)?,
        position: b.item(&format!("{name}-position"), "counts / scale", 0.0)?,
        reset: b.item(&format!("{name}-reset"), "TRUE holds counts at 0", false)?,
        scale: b.item(&format!("{name}-scale"), "Counts per unit of position; 0 is 1", 1.0)?,
    })
}

fn light(b: &mut Builder<'_>, prefix: &str, code: u16) -> Result<LightPins, Error> {
    let name = format!("{prefix}.{}", codes::name(kind::LED, code));
    Ok(LightPins {
        code,
        is_on: b.item(&name, "TRUE switches the light on", false)?,
        invert: b.item(&format!("{name}-invert"), "TRUE makes FALSE switch it on", false)?,
    })
}
