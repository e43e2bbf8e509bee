//! Parser of the argument `config=` of `mux_generic` and `demux_generic`.
use crate::kind::Kind;
use hal_component::Error;

/// Maximum number of inputs or outputs.
const MAX: u32 = 1024;

/// Entry of the list: types, and number of inputs or outputs.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Config {
    pub(crate) from: Kind,
    pub(crate) to: Kind,
    pub(crate) size: u32,
}

/// Parses a text such as `ff4`: at most two type letters and a number, in any order.
pub(crate) fn read(text: &str) -> Result<Config, Error> {
    let refused = |why: &str| {
        let text = format!(
            "config={text}: {why}; a config is two letters of b, f, s, u and a number \
             from 2 to {MAX}, such as bf4"
        );
        Error::new(text)
    };
    let (mut kinds, mut size) = (Vec::new(), None::<u32>);
    for letter in text.chars() {
        if let Some(digit) = letter.to_digit(10) {
            size = Some(size.unwrap_or(0).saturating_mul(10).saturating_add(digit));
        } else {
            let kind = Kind::by_letter(letter);
            kinds.push(kind.ok_or_else(|| refused(&format!("'{letter}' is not a type")))?);
        }
    }
    let (from, to) = match *kinds.as_slice() {
        [kind] => (kind, kind),
        [from, to] => (from, to),
        [] => return Err(refused("no type is given")),
        _ => return Err(refused("there are too many types")),
    };
    match size {
        None | Some(0) => Err(refused("no number is given")),
        Some(1) => Err(refused("one place makes no sense")),
        Some(size) if size > MAX => Err(refused(&format!("{size} is too many"))),
        Some(size) => Ok(Config { from, to, size }),
    }
}

#[cfg(test)]
mod tests {
    use super::{Config, read};
    use crate::kind::Kind::{Bit, Float, S32, U32};

    #[test]
    fn texts() {
        let is = |text: &str| read(text).unwrap();
        assert_eq!(is("ff4"), Config { from: Float, to: Float, size: 4 });
        assert_eq!(is("BU12"), Config { from: Bit, to: U32, size: 12 });
        assert_eq!(is("4s"), Config { from: S32, to: S32, size: 4 });
        assert_eq!(is("f1024b"), Config { from: Float, to: Bit, size: 1024 });
        for (wrong, why) in [
            ("xx4", "'x' is not a type"),
            ("ff", "no number is given"),
            ("ff0", "no number is given"),
            ("4", "no type is given"),
            ("", "no type is given"),
            ("ff4f", "there are too many types"),
            ("ff1", "one place makes no sense"),
            ("ff1025", "1025 is too many"),
            ("ff99999999999999999999", "4294967295 is too many"),
            ("ff-3", "'-' is not a type"),
            ("ff\u{0664}", "'\u{0664}' is not a type"),
        ] {
            let said = read(wrong).unwrap_err();
            let said = said.text().unwrap().to_owned();
            assert!(said.starts_with(&format!("config={wrong}: {why};")), "{said}");
        }
    }
}
