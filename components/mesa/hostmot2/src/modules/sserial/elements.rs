//! Pins of a remote's process data and parameters, from its account.

use super::{
    data::{Given, GivenPins, Taken, TakenPins, Wheel},
    describe::{Element, Flow, Form, Setting},
    settings::{RemoteSetting, SettingPin},
};
use crate::making::Making;
use hal_component::Error;

/// Creates the pins of a remote's process data, under a name such as `hm2_7i76e.0.7i76.0.0`.
pub(super) fn make(
    m: &mut Making<'_, '_>,
    name: &str,
    elements: &[Element],
) -> Result<(Vec<Taken>, Vec<Given>), Error> {
    let (mut taken, mut given) = (Vec::new(), Vec::new());
    let (mut from, mut to) = (0, 0);
    for element in elements {
        let bits = u32::from(element.bits);
        let base = format!("{name}.{}", element.name);
        if element.form != Form::Padding {
            if element.flow == Flow::In {
                taken.push(Taken { at: from, bits, pins: taken_pins(m, &base, element)? });
            } else if let Some(pins) = given_pins(m, &base, element)? {
                given.push(Given { at: to, bits, pins });
            }
        }
        from += if element.flow == Flow::Out { 0 } else { bits };
        to += if element.flow == Flow::In { 0 } else { bits };
    }
    Ok((taken, given))
}

/// Returns a meaning with the remote's unit.
fn about(what: &str, element: &Element) -> String {
    let unit = element.unit.as_str();
    if unit.is_empty() || unit.eq_ignore_ascii_case("none") {
        what.to_owned()
    } else {
        format!("{what}, in {unit}")
    }
}

const LEVEL: &str = "Level of the input";
const NOT: &str = "Opposite of the level of the input";
const OUTPUT: &str = "Level of the output";
const INVERT: &str = "True if the output is inverted";

fn taken_pins(m: &mut Making<'_, '_>, base: &str, element: &Element) -> Result<TakenPins, Error> {
    let max = f64::from(element.max);
    Ok(match element.form {
        Form::Bits | Form::Padding => {
            let mut pins = Vec::new();
            for n in 0..element.bits {
                let level = m.b.item(&format!("{base}-{n:02}"), LEVEL, false)?;
                pins.push((level, m.b.item(&format!("{base}-{n:02}-not"), NOT, false)?));
            }
            TakenPins::Bits(pins)
        }
        Form::Boolean => TakenPins::Boolean(
            m.b.item(base, LEVEL, false)?,
            m.b.item(&format!("{base}-not"), NOT, false)?,
        ),
        Form::Unsigned | Form::Signed => TakenPins::Number {
            value: m.b.item(base, &about("Value of the input", element), 0.0)?,
            scale: m.b.item(&format!("{base}-scalemax"), "Value at the end of the range", max)?,
            signed: element.form == Form::Signed,
        },
        Form::Float => {
            TakenPins::Float(m.b.item(base, &about("Value of the input", element), 0.0)?)
        }
        Form::Stream => TakenPins::Stream(m.b.item(base, "Value of the input", 0)?),
        Form::Encoder => TakenPins::Encoder(Box::new(wheel(m, base, element)?)),
    })
}

fn wheel(m: &mut Making<'_, '_>, base: &str, element: &Element) -> Result<Wheel, Error> {
    let max = f64::from(element.max);
    let scale = if max > 0.0 && max.is_finite() { max } else { 1.0 };
    let at = |pin: &str| format!("{base}.{pin}");
    Ok(Wheel {
        count: m.b.item(&at("count"), "Counts since the reset", 0)?,
        position: m.b.item(&at("position"), "Position: counts by scale", 0.0)?,
        raw: m.b.item(&at("rawcounts"), "Counts, which no reset changes", 0)?,
        reset: m.b.item(&at("reset"), "True to hold the count at 0", false)?,
        index: m.b.item(
            &at("index-enable"),
            "Without effect: remotes tell nothing of an index",
            false,
        )?,
        scale: m.b.item(&at("scale"), "Counts per unit; 0 counts as 1", scale)?,
        per_turn: m.b.item(
            &at("counts-per-rev"),
            "Without effect: remotes tell nothing of an index",
            256,
        )?,
        last: None,
        counts: 0,
        zero: 0,
    })
}

/// Creates the pins of a datum that goes to a remote; `None` for an encoder, which takes nothing.
fn given_pins(
    m: &mut Making<'_, '_>,
    base: &str,
    element: &Element,
) -> Result<Option<GivenPins>, Error> {
    let (min, max) = (f64::from(element.min), f64::from(element.max));
    Ok(Some(match element.form {
        Form::Bits | Form::Padding if element.flow == Flow::Both => {
            let pins = (0..element.bits).map(|n| {
                let about = "Level that the remote gets";
                m.b.item(&format!("{base}-{n:02}"), about, false)
            });
            GivenPins::Both(pins.collect::<Result<_, _>>()?)
        }
        Form::Bits | Form::Padding => {
            let mut pins = Vec::new();
            for n in 0..element.bits {
                let level = m.b.item(&format!("{base}-{n:02}"), OUTPUT, false)?;
                pins.push((level, m.b.item(&format!("{base}-{n:02}-invert"), INVERT, false)?));
            }
            GivenPins::Bits(pins)
        }
        Form::Boolean => GivenPins::Boolean(
            m.b.item(base, OUTPUT, false)?,
            m.b.item(&format!("{base}-invert"), INVERT, false)?,
        ),
        Form::Unsigned | Form::Signed => GivenPins::Number {
            value: m.b.item(base, &about("Value of the output; NaN counts as 0", element), 0.0)?,
            low: m.b.item(&format!("{base}-minlim"), "Smallest value", min)?,
            high: m.b.item(&format!("{base}-maxlim"), "Largest value", max)?,
            scale: m.b.item(&format!("{base}-scalemax"), "Value at the end of the range", max)?,
            signed: element.form == Form::Signed,
        },
        Form::Float => {
            GivenPins::Float(m.b.item(base, &about("Value of the output", element), 0.0)?)
        }
        Form::Stream => GivenPins::Stream(m.b.item(base, "Value of the output", 0)?),
        Form::Encoder => return Ok(None),
    }))
}

/// Creates the parameter with the value that the remote has.
pub(super) fn make_setting(
    m: &mut Making<'_, '_>,
    name: &str,
    channel: usize,
    setting: &Setting,
    value: u32,
) -> Result<RemoteSetting, Error> {
    let unit = setting.unit.as_str();
    let mut about = "Value in the remote, which takes another one while `run` is FALSE".to_owned();
    if !unit.is_empty() && !unit.eq_ignore_ascii_case("none") {
        about = format!("{about}, in {unit}");
    }
    if setting.lasts {
        about = format!("{about}; it outlasts power, and has effect when the remote gets power");
    }
    let name = format!("{name}.{}", setting.name);
    let unused = 32 - u32::from(setting.bits.min(32));
    let value = value << unused >> unused;
    let signed = (value << unused).cast_signed() >> unused;
    let pin = match setting.form {
        Form::Signed => SettingPin::Signed(m.b.item(&name, &about, signed)?),
        Form::Float => {
            let value = f64::from(f32::from_bits(value));
            SettingPin::Float(m.b.item(&name, &about, value)?)
        }
        _ => SettingPin::Unsigned(m.b.item(&name, &about, value)?),
    };
    Ok(RemoteSetting::new(channel, setting, pin))
}
