//! Names of an FST file.

use super::{Notes, SCOPE, bytes::Bytes};
use crate::Flaw;
use hal_protocol::Type;

/// A variable: its name, handle and kind.
#[derive(Debug)]
pub(super) struct Var {
    pub(super) name: String,
    /// Handle, counted from 1.
    pub(super) handle: u64,
    kind: u8,
}

impl Var {
    /// Returns the HAL type of a variable of this size.
    pub(super) fn ty(&self, size: Size) -> Option<Type> {
        match (size, self.kind) {
            (Size::Real, _) => Some(Type::Float),
            (Size::Text, _) | (Size::Bits(0 | 65..), _) | (_, 0 | 18 | 21) => None,
            // Signed integers: `integer`, `int`, `shortint`, `longint`, `byte`.
            (Size::Bits(1..=32), 1 | 24..=27) => Some(Type::S32),
            (Size::Bits(_), 1 | 24..=27) => Some(Type::S64),
            (Size::Bits(1), _) => Some(Type::Bit),
            (Size::Bits(2..=32), _) => Some(Type::U32),
            (Size::Bits(_), _) => Some(Type::U64),
        }
    }
}

/// Size of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Size {
    Real,
    Bits(u32),
    Text,
}

/// Returns all variables, and the notes if Ferrule wrote the file.
pub(super) fn hierarchy(bytes: &[u8]) -> Result<(Vec<Var>, Option<Notes>), Flaw> {
    let mut input = Bytes::new(bytes);
    let (mut vars, mut scopes, mut notes) = (Vec::new(), Vec::<String>::new(), String::new());
    let mut handles = 0;
    while !input.is_empty() {
        match input.byte()? {
            254 => {
                input.byte()?;
                let (name, component) = (input.text()?, input.text()?);
                if scopes.is_empty() && name == SCOPE {
                    notes.push_str(&component);
                }
                scopes.push(name);
            }
            255 => drop(scopes.pop()),
            252 => {
                // Attributes are ignored.
                input.take(2)?;
                input.text()?;
                input.groups()?;
            }
            253 => {}
            kind @ 0..=29 => {
                input.byte()?;
                let name = input.text()?;
                let _length = input.groups()?;
                let handle = match input.groups()? {
                    0 => {
                        handles += 1;
                        handles
                    }
                    of_other => of_other,
                };
                let name = reference(&name);
                let path: Vec<&str> = scopes.iter().map(String::as_str).chain([&*name]).collect();
                vars.push(Var { name: path.join("."), handle, kind });
            }
            other => {
                let what = format!("an entry of kind {other} among the names");
                return Err(Flaw::Unreadable(what.into()));
            }
        }
    }
    Ok((vars, serde_json::from_str(&notes).ok()))
}

/// Converts an FST reference to a name: `bus [7:0]` becomes `bus`, `bus [3]` becomes `bus[3]`.
fn reference(name: &str) -> String {
    match name.rsplit_once(" [") {
        Some((name, index)) if index.contains(':') => name.to_owned(),
        Some((name, index)) => format!("{name}[{index}"),
        None => name.to_owned(),
    }
}
