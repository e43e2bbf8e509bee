//! Module parameters: arguments of `loadrt`, stored in the variables that the file's symbols name.

use crate::{module::Module, system};
use core::ffi::{CStr, c_char, c_int, c_long, c_void};
use std::ffi::CString;

/// Parameter declared by the file.
#[derive(Debug)]
struct Parameter {
    /// Type letter: `i`, `l` or `s`.
    letter: u8,
    address: *mut c_void,
    /// Number of elements, for an array.
    items: Option<usize>,
}

/// Value converted to the parameter's type.
#[derive(Debug)]
enum Value {
    Int(c_int),
    Long(c_long),
    Text(CString),
}

/// Stores every argument in its variable, after all have been checked.
///
/// # Errors
/// An argument is not of the form `NAME=VALUE`, names no parameter of the file, has too many elements, or an element is
/// not a number.
pub(crate) fn set(module: &Module, names: &[String], words: &[String]) -> Result<(), String> {
    let mut values = Vec::new();
    for word in words {
        let word = word.replace('"', "");
        let (name, text) =
            word.split_once('=').ok_or_else(|| format!("Invalid parameter `{word}'"))?;
        if !names.iter().any(|n| n == name) {
            let takes = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            return Err(format!("Unknown parameter `{word}'; its parameters: {takes}"));
        }
        let p = Parameter::find(module, name)
            .ok_or_else(|| format!("parameter '{name}' is not well declared in the file"))?;
        values.extend(p.read(name, text, &word)?);
    }
    for (place, value) in values {
        put(module, place, value);
    }
    Ok(())
}

impl Parameter {
    fn find(module: &Module, name: &str) -> Option<Self> {
        let symbol = |what: &str| {
            let name = CString::new(format!("rtapi_info_{what}_{name}")).unwrap_or_default();
            system::symbol(module.handle, &name)
        };
        // SAFETY: by the interface, the symbol is the address of a C string, if it exists.
        let letter = unsafe { symbol("type").cast::<*const c_char>().as_ref() }?;
        // SAFETY: as above.
        let address = unsafe { symbol("address").cast::<*mut c_void>().as_ref() }?;
        // SAFETY: by the interface, the symbol is a number, if it exists.
        let items = unsafe { symbol("size").cast::<c_int>().as_ref() };
        if letter.is_null() || address.is_null() {
            return None;
        }
        // SAFETY: a C string of the file's.
        let letter = unsafe { CStr::from_ptr(*letter) }.to_bytes().first().copied()?;
        let items = items.map(|n| usize::try_from(*n).unwrap_or(0));
        Some(Self { letter, address: *address, items })
    }

    /// Converts an argument to values with their addresses.
    fn read(
        &self,
        name: &str,
        text: &str,
        word: &str,
    ) -> Result<Vec<(*mut c_void, Value)>, String> {
        let Some(most) = self.items else {
            return Ok(vec![(self.address, self.value(text, word)?)]);
        };
        let items: Vec<&str> = text.split(',').collect();
        if items.len() > most {
            return Err(format!(
                "{name}: can only take {most} arguments, and `{word}' has {}",
                items.len()
            ));
        }
        let width = match self.letter {
            b'i' => size_of::<c_int>(),
            _ => size_of::<c_long>(),
        };
        let placed = |(i, item): (usize, &&str)| {
            let place = self.address.wrapping_byte_add(i * width);
            Ok((place, self.value(item, word)?))
        };
        items.iter().enumerate().map(placed).collect()
    }

    fn value(&self, text: &str, word: &str) -> Result<Value, String> {
        let invalid =
            || format!("`{text}' invalid for parameter `{word}': a number, such as 10 or 0x1f");
        Ok(match self.letter {
            b'i' => {
                let n = number(text).ok_or_else(invalid)?;
                Value::Int(c_int::try_from(n).map_err(|_| invalid())?)
            }
            b'l' => Value::Long(number(text).ok_or_else(invalid)?),
            b's' => Value::Text(CString::new(text).map_err(|_| invalid())?),
            other => {
                let letter = char::from(other);
                return Err(format!("parameter `{word}' is of the unknown type '{letter}'"));
            }
        })
    }
}

/// Parses an integer in C notation; an empty text is zero.
fn number(text: &str) -> Option<i64> {
    let t = text.trim_start();
    let (minus, digits) = match t.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, t.strip_prefix('+').unwrap_or(t)),
    };
    let (radix, digits) =
        if let Some(hex) = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X")) {
            (16, hex)
        } else if digits.len() > 1 && digits.starts_with('0') {
            (8, digits.get(1..).unwrap_or_default())
        } else {
            (10, digits)
        };
    if t.is_empty() {
        return Some(0);
    }
    if digits.starts_with(['+', '-']) {
        return None;
    }
    let n = i128::from_str_radix(digits, radix).ok()?;
    i64::try_from(if minus { -n } else { n }).ok()
}

fn put(module: &Module, place: *mut c_void, value: Value) {
    match value {
        // SAFETY: the variable that the file declares with this type; none of its code runs yet.
        Value::Int(n) => unsafe { place.cast::<c_int>().write(n) },
        // SAFETY: as above.
        Value::Long(n) => unsafe { place.cast::<c_long>().write(n) },
        Value::Text(text) => {
            // A copy that the component may change, and that lives as long as the component.
            let bytes = text.as_bytes_with_nul();
            if let Some(at) = module.memory.take(bytes.len()) {
                // SAFETY: a block of this size.
                unsafe { at.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
                // SAFETY: as above.
                unsafe { place.cast::<*mut u8>().write(at) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_are_those_of_c() {
        for (text, value) in [
            ("10", Some(10)),
            ("-0x1f", Some(-31)),
            ("017", Some(15)),
            ("0", Some(0)),
            ("", Some(0)),
            (" 7", Some(7)),
            ("7 ", None),
            ("1e3", None),
            ("--1", None),
            ("0x", None),
            ("-9223372036854775808", Some(i64::MIN)),
            ("9223372036854775808", None),
        ] {
            assert_eq!(number(text), value, "{text:?}");
        }
    }
}
