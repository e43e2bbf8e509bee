//! Form of a value on the wire.

use super::{Value, float, general};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

/// Form on the wire: `{"float": 1.5}`, with a string where a JSON number cannot hold the value.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Wire {
    Bit(bool),
    Float(Float),
    S32(i32),
    U32(u32),
    S64(String),
    U64(String),
    Port(u32),
}

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Float {
    Finite(f64),
    Other(String),
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        let wire = match *self {
            Self::Bit(b) => Wire::Bit(b),
            Self::Float(f) if f.is_finite() => Wire::Float(Float::Finite(f)),
            Self::Float(f) => Wire::Float(Float::Other(general(f))),
            Self::S32(i) => Wire::S32(i),
            Self::U32(u) => Wire::U32(u),
            Self::S64(i) => Wire::S64(i.to_string()),
            Self::U64(u) => Wire::U64(u.to_string()),
            Self::Port(u) => Wire::Port(u32::try_from(u).unwrap_or(u32::MAX)),
        };
        wire.serialize(s)
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        Ok(match Wire::deserialize(d)? {
            Wire::Bit(b) => Self::Bit(b),
            Wire::Float(Float::Finite(f)) => Self::Float(f),
            Wire::Float(Float::Other(s)) => {
                Self::Float(float(&s).map_err(|_| D::Error::custom("not a number"))?)
            }
            Wire::S32(i) => Self::S32(i),
            Wire::U32(u) => Self::U32(u),
            Wire::S64(s) => Self::S64(s.parse().map_err(D::Error::custom)?),
            Wire::U64(s) => Self::U64(s.parse().map_err(D::Error::custom)?),
            Wire::Port(u) => Self::Port(u64::from(u)),
        })
    }
}
