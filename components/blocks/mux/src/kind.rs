//! Pins with a type given by a letter, and conversions between the types.
use hal_component::{Builder, Error, In, Out, Touch, Uses};

/// Magnitude below which a number converts to FALSE.
const NOTHING: f64 = 2e-7;

/// Type of a pin, given by a letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Bit,
    Float,
    S32,
    U32,
}

impl Kind {
    /// Returns the type for a letter, of either case.
    pub(crate) const fn by_letter(letter: char) -> Option<Self> {
        match letter.to_ascii_lowercase() {
            'b' => Some(Self::Bit),
            'f' => Some(Self::Float),
            's' => Some(Self::S32),
            'u' => Some(Self::U32),
            _ => None,
        }
    }

    /// Returns the word used in names of pins.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Bit => "bit",
            Self::Float => "float",
            Self::S32 => "s32",
            Self::U32 => "u32",
        }
    }

    /// Declares an input.
    pub(crate) fn input(self, b: &mut Builder<'_>, name: &str, doc: &str) -> Result<Source, Error> {
        Ok(match self {
            Self::Bit => Source::Bit(b.item(name, doc, false)?),
            Self::Float => Source::Float(b.item(name, doc, 0.0)?),
            Self::S32 => Source::S32(b.item(name, doc, 0)?),
            Self::U32 => Source::U32(b.item(name, doc, 0)?),
        })
    }

    /// Declares an output.
    pub(crate) fn output(self, b: &mut Builder<'_>, name: &str, doc: &str) -> Result<Goal, Error> {
        Ok(match self {
            Self::Bit => Goal::Bit(b.item(name, doc, false)?),
            Self::Float => Goal::Float(b.item(name, doc, 0.0)?),
            Self::S32 => Goal::S32(b.item(name, doc, 0)?),
            Self::U32 => Goal::U32(b.item(name, doc, 0)?),
        })
    }
}

/// Input of any type.
pub(crate) enum Source {
    Bit(In<bool>),
    Float(In<f64>),
    S32(In<i32>),
    U32(In<u32>),
}

impl Touch for Source {
    fn touch(&self, uses: &mut Uses) {
        match self {
            Self::Bit(pin) => pin.touch(uses),
            Self::Float(pin) => pin.touch(uses),
            Self::S32(pin) => pin.touch(uses),
            Self::U32(pin) => pin.touch(uses),
        }
    }
}

/// Output of any type.
pub(crate) enum Goal {
    Bit(Out<bool>),
    Float(Out<f64>),
    S32(Out<i32>),
    U32(Out<u32>),
}

impl Touch for Goal {
    fn touch(&self, uses: &mut Uses) {
        match self {
            Self::Bit(pin) => pin.touch(uses),
            Self::Float(pin) => pin.touch(uses),
            Self::S32(pin) => pin.touch(uses),
            Self::U32(pin) => pin.touch(uses),
        }
    }
}

impl Goal {
    /// Copies a value, converted to the output's type.
    pub(crate) fn follow(&self, from: &Source) {
        match (self, from) {
            (Self::Bit(out), from) => out.set(is_true(from)),
            (Self::Float(out), from) => out.set(as_float(from)),
            (Self::S32(out), Source::Float(v)) => out.set(float_to_s32(v.get())),
            (Self::S32(out), from) => out.set(as_s32(from)),
            (Self::U32(out), Source::Float(v)) => out.set(float_to_u32(v.get())),
            (Self::U32(out), from) => out.set(as_u32(from)),
        }
    }

    /// Sets the output to zero.
    pub(crate) fn clear(&self) {
        match self {
            Self::Bit(out) => out.set(false),
            Self::Float(out) => out.set(0.0),
            Self::S32(out) => out.set(0),
            Self::U32(out) => out.set(0),
        }
    }
}

fn is_true(from: &Source) -> bool {
    match from {
        Source::Bit(v) => v.get(),
        Source::Float(v) => v.get().abs() > NOTHING,
        Source::S32(v) => v.get() != 0,
        Source::U32(v) => v.get() != 0,
    }
}

fn as_float(from: &Source) -> f64 {
    match from {
        Source::Bit(v) => f64::from(u8::from(v.get())),
        Source::Float(v) => v.get(),
        Source::S32(v) => f64::from(v.get()),
        Source::U32(v) => f64::from(v.get()),
    }
}

fn as_s32(from: &Source) -> i32 {
    match from {
        Source::Bit(v) => i32::from(v.get()),
        Source::Float(_) => 0,
        Source::S32(v) => v.get(),
        Source::U32(v) => i32::try_from(v.get()).unwrap_or(i32::MAX),
    }
}

fn as_u32(from: &Source) -> u32 {
    match from {
        Source::Bit(v) => u32::from(v.get()),
        Source::Float(_) => 0,
        Source::S32(v) => u32::try_from(v.get()).unwrap_or(0),
        Source::U32(v) => v.get(),
    }
}

/// Limits the value to the type without its lowest number, which stands for NaN.
fn float_to_s32(v: f64) -> i32 {
    if v.is_nan() {
        return i32::MIN;
    }
    let lowest = f64::from(-i32::MAX);
    #[expect(clippy::cast_possible_truncation, reason = "kept within the type")]
    let whole = if v < lowest { -i32::MAX } else { v as i32 };
    whole
}

fn float_to_u32(v: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let whole = v as u32;
    whole
}
