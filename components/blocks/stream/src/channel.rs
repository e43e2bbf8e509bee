//! Channels of `depth=` and `cfg=`, and pins of any type, shared by `sampler` and `streamer`.

use hal_component::{
    Arg, Builder, Error, In, Out, Touch, Uses, Value,
    abi::{ArgSpec, MAX_WIDTH},
};
use std::ops::RangeInclusive;

/// Permitted number of slots of a ring.
const DEPTHS: RangeInclusive<u32> = 2..=1 << 24;

/// Arguments of both components.
pub(crate) const ARGS: &[&ArgSpec] = &[
    &Arg::ints(
        "depth",
        "Number of slots of each channel, 2 to 16777216; it holds one record less. There are as many \
         channels as this and `cfg=` have both.",
    )
    .at_most(8),
    &Arg::texts(
        "cfg",
        "Types of the pins of each channel, a letter each, at most 21: `f` or `r` float, `b` bit, \
         `s` s32, `u` u32, `l` s64, `k` u64. At most 8 channels, as many as this and `depth=` have \
         both.",
    )
    .at_most(8),
];

/// Requested channel.
pub(crate) struct Channel {
    /// Number of slots of its ring.
    pub(crate) depth: u32,
    /// Type of each pin.
    pub(crate) types: Vec<Type>,
}

/// Type of a pin.
#[derive(Clone, Copy)]
pub(crate) enum Type {
    Bit,
    Float,
    S32,
    U32,
    S64,
    U64,
}

impl Type {
    fn new(letter: char) -> Option<Self> {
        Some(match letter.to_ascii_lowercase() {
            'b' => Self::Bit,
            'f' | 'r' => Self::Float,
            's' => Self::S32,
            'u' => Self::U32,
            'l' => Self::S64,
            'k' => Self::U64,
            _ => return None,
        })
    }

    /// Returns the type code of the plugin interface.
    pub(crate) const fn code(self) -> u8 {
        match self {
            Self::Bit => bool::TYPE,
            Self::Float => f64::TYPE,
            Self::S32 => i32::TYPE,
            Self::U32 => u32::TYPE,
            Self::S64 => i64::TYPE,
            Self::U64 => u64::TYPE,
        }
    }
}

/// Parses `depth=` and `cfg=`: one channel per pair, up to the first that is absent.
pub(crate) fn channels(b: &Builder<'_>, who: &str) -> Result<Vec<Channel>, Error> {
    let (depths, cfgs) = (b.arg_ints("depth"), b.arg_texts("cfg"));
    let pairs = depths.into_iter().zip(cfgs);
    let channels: Vec<Channel> = pairs
        .take_while(|(depth, cfg)| *depth > 0 && !cfg.is_empty())
        .map(|(depth, cfg)| channel(who, depth, &cfg))
        .collect::<Result<_, _>>()?;
    if channels.is_empty() {
        return Err(Error::new(format!("{who}: ERROR: no channels specified")));
    }
    Ok(channels)
}

fn channel(who: &str, depth: i64, cfg: &str) -> Result<Channel, Error> {
    let depth = u32::try_from(depth).ok().filter(|d| DEPTHS.contains(d)).ok_or_else(|| {
        let (least, most) = (DEPTHS.start(), DEPTHS.end());
        Error::new(format!("{who}: ERROR: depth {depth} is not between {least} and {most}"))
    })?;
    let unknown = |letter| {
        let text = "must be f (or r), b, s, u, l or k";
        Error::new(format!("{who}: ERROR: unknown type '{letter}' in cfg '{cfg}', {text}"))
    };
    let types: Vec<Type> =
        cfg.chars().map(|c| Type::new(c).ok_or_else(|| unknown(c))).collect::<Result<_, _>>()?;
    if types.len() > MAX_WIDTH {
        return Err(Error::new(format!("{who}: ERROR: more than {MAX_WIDTH} items in '{cfg}'")));
    }
    Ok(Channel { depth, types })
}

macro_rules! any {
    ($(#[$m:meta])* $name:ident, $item:ident, $($method:item)*) => {
        $(#[$m])*
        pub(crate) enum $name {
            Bit($item<bool>),
            Float($item<f64>),
            S32($item<i32>),
            U32($item<u32>),
            S64($item<i64>),
            U64($item<u64>),
        }

        impl $name {
            pub(crate) fn create(
                b: &mut Builder<'_>,
                ty: Type,
                name: &str,
                doc: &str,
            ) -> Result<Self, Error> {
                Ok(match ty {
                    Type::Bit => Self::Bit(b.item(name, doc, false)?),
                    Type::Float => Self::Float(b.item(name, doc, 0.0)?),
                    Type::S32 => Self::S32(b.item(name, doc, 0)?),
                    Type::U32 => Self::U32(b.item(name, doc, 0)?),
                    Type::S64 => Self::S64(b.item(name, doc, 0)?),
                    Type::U64 => Self::U64(b.item(name, doc, 0)?),
                })
            }

            $($method)*
        }

        impl Touch for $name {
            fn touch(&self, uses: &mut Uses) {
                match self {
                    Self::Bit(pin) => pin.touch(uses),
                    Self::Float(pin) => pin.touch(uses),
                    Self::S32(pin) => pin.touch(uses),
                    Self::U32(pin) => pin.touch(uses),
                    Self::S64(pin) => pin.touch(uses),
                    Self::U64(pin) => pin.touch(uses),
                }
            }
        }
    };
}

any! {
    /// Input pin of any type.
    AnyIn, In,
    /// Returns its value in the form that rings hold.
    pub(crate) fn bits(&self) -> u64 {
        match self {
            Self::Bit(pin) => pin.get().to_bits(),
            Self::Float(pin) => pin.get().to_bits(),
            Self::S32(pin) => pin.get().to_bits(),
            Self::U32(pin) => pin.get().to_bits(),
            Self::S64(pin) => pin.get().to_bits(),
            Self::U64(pin) => pin.get().to_bits(),
        }
    }
}

any! {
    /// Output pin of any type.
    AnyOut, Out,
    /// Writes a value in the form that rings hold.
    pub(crate) fn set(&self, bits: u64) {
        match self {
            Self::Bit(pin) => pin.set(Value::from_bits(bits)),
            Self::Float(pin) => pin.set(Value::from_bits(bits)),
            Self::S32(pin) => pin.set(Value::from_bits(bits)),
            Self::U32(pin) => pin.set(Value::from_bits(bits)),
            Self::S64(pin) => pin.set(Value::from_bits(bits)),
            Self::U64(pin) => pin.set(Value::from_bits(bits)),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{sampler::Sampler, streamer::Streamer};
    use hal_bench::Bench;

    #[test]
    fn refusals() {
        let many = format!("cfg={}", "f".repeat(22));
        for (args, wanted) in [
            (&[][..], "no channels specified"),
            (&["depth=10"], "no channels specified"),
            (&["cfg=f"], "no channels specified"),
            (&["depth=0", "cfg=f"], "no channels specified"),
            (&["depth=-1", "cfg=f"], "no channels specified"),
            (&["depth=10", "cfg="], "no channels specified"),
            (&["depth=1", "cfg=f"], "depth 1 is not between 2 and 16777216"),
            (&["depth=16777217", "cfg=f"], "depth 16777217 is not between 2 and 16777216"),
            (&["depth=4294967298", "cfg=f"], "depth 4294967298 is not between 2 and 16777216"),
            (
                &["depth=10", "cfg=fxb"],
                "unknown type 'x' in cfg 'fxb', must be f (or r), b, s, u, l or k",
            ),
            (&["depth=10", &many], &format!("more than 21 items in '{}'", "f".repeat(22))),
        ] {
            let mut bench = Bench::new();
            let said = bench.load::<Sampler>(args).unwrap_err();
            assert_eq!(said, format!("SAMPLER: ERROR: {wanted}"), "{args:?}");
            let said = bench.load::<Streamer>(args).unwrap_err();
            assert_eq!(said, format!("STREAMER: ERROR: {wanted}"), "{args:?}");
            assert!(bench.names().is_empty(), "{args:?}");
        }
    }

    #[test]
    fn the_list_of_channels_ends_where_one_is_absent() {
        for (depth, cfg, wanted) in [
            ("10,20", "f", 1),
            ("10", "f,b", 1),
            ("10,20", "f,b", 2),
            ("10,20,30", "f,,b", 1),
            ("10,0,30", "f,b,b", 1),
            ("2,2,2,2,2,2,2,2", "f,f,f,f,f,f,f,f", 8),
            ("10", "fffffffffffffffffffff", 1),
        ] {
            let mut bench = Bench::new();
            let args = [format!("depth={depth}"), format!("cfg={cfg}")];
            bench.load::<Sampler>(&[&args[0], &args[1]]).unwrap();
            assert_eq!(bench.functs().len(), wanted, "{args:?}");
        }
    }
}
