//! Descriptions that halcompile writes into a module: strings `KIND:NAME:…` behind symbols `rtapi_info_linuxcnc_LINE`.

use crate::system;
use core::ffi::{CStr, c_char, c_void};
use std::ffi::CString;

/// Prefix of the symbols.
pub(crate) const PREFIX: &str = "rtapi_info_linuxcnc_";

/// Descriptions of a module.
#[derive(Debug, Default)]
pub(crate) struct Docs {
    /// Description of the component.
    pub(crate) component: String,
    items: Vec<Doc>,
    functs: Vec<Doc>,
}

/// Description of all items whose names match.
#[derive(Debug)]
struct Doc {
    /// Name without that of the instance. A `#` stands for any digit.
    pattern: String,
    text: String,
}

impl Docs {
    /// Reads the strings of an open module.
    pub(crate) fn read(handle: *mut c_void, symbols: &[String]) -> Self {
        let mut docs = Self::default();
        for symbol in symbols {
            let Ok(symbol) = CString::new(symbol.as_str()) else { continue };
            let place = system::symbol(handle, &symbol).cast::<*const c_char>();
            if place.is_null() || !place.is_aligned() {
                continue;
            }
            // SAFETY: the interface defines these symbols as pointers to C strings.
            let text = unsafe { *place };
            if text.is_null() {
                continue;
            }
            // SAFETY: as above; alive while the module is open.
            if let Ok(text) = unsafe { CStr::from_ptr(text) }.to_str() {
                docs.add(text);
            }
        }
        docs
    }

    fn add(&mut self, line: &str) {
        let Some((kind, rest)) = line.split_once(':') else { return };
        match kind {
            "component" => {
                self.component = rest.split_once(':').map_or("", |(_, doc)| doc).into();
            }
            // NAME:TYPE:ARRAY:DIRECTION:DOC:DEFAULT:CONDITION
            "pin" | "param" => {
                let mut words = rest.splitn(5, ':');
                let (Some(name), Some(doc)) = (words.next(), words.nth(3)) else { return };
                let doc = doc.rsplitn(3, ':').nth(2).unwrap_or_default();
                self.items.extend(Doc::new(name, doc));
            }
            // NAME:FP:DOC
            "funct" => {
                let mut words = rest.splitn(3, ':');
                let (Some(name), Some(doc)) = (words.next(), words.nth(1)) else { return };
                self.functs.extend(Doc::new(name, doc));
            }
            _ => {}
        }
    }

    /// Returns the description of a pin or parameter by its absolute name, or an empty text.
    pub(crate) fn item(&self, name: &str) -> &str {
        best(&self.items, name)
    }

    /// Returns the description of a function by its absolute name, or an empty text.
    pub(crate) fn funct(&self, name: &str) -> &str {
        best(&self.functs, name)
    }
}

impl Doc {
    /// Makes the description of a name as the language writes it.
    fn new(name: &str, text: &str) -> Option<Self> {
        let pattern = name.replace('_', "-").trim_end_matches(['-', '.']).to_owned();
        let text = plain(text);
        (!text.is_empty()).then_some(Self { pattern, text })
    }

    fn matches(&self, name: &str) -> bool {
        let Some(start) = name.len().checked_sub(self.pattern.len()) else { return false };
        let Some((instance, end)) = name.split_at_checked(start) else { return false };
        let alike = |(p, c): (u8, u8)| if p == b'#' { c.is_ascii_digit() } else { p == c };
        (self.pattern.is_empty() || instance.is_empty() || instance.ends_with('.'))
            && self.pattern.bytes().zip(end.bytes()).all(alike)
    }
}

/// Returns the description with the longest pattern that matches.
fn best<'d>(docs: &'d [Doc], name: &str) -> &'d str {
    let matching = docs.iter().filter(|doc| doc.matches(name));
    matching.max_by_key(|doc| doc.pattern.len()).map_or("", |doc| &doc.text)
}

/// Returns a text on one line, without the marks of troff.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for word in text.split_whitespace() {
        if !out.is_empty() {
            out.push(' ');
        }
        let mut chars = word.chars();
        while let Some(c) = chars.next() {
            match (c, if c == '\\' { chars.next() } else { None }) {
                ('\\', Some('f')) => drop(chars.next()),
                ('\\', Some(other)) => out.push(other),
                _ => out.push(c),
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::Docs;

    #[test]
    fn descriptions_of_items_and_functions() {
        let mut docs = Docs::default();
        for line in [
            "component:sum2:Adds: two numbers.",
            "pin:in-##:float:4:in:one \\fBof\\fR the\n inputs: any:None:None",
            "pin:a_b_:bit:0:out:whether it\\-s on:None:personality & 1",
            "param:gain:float:0:rw::2:None",
            "pin:b:bit:0:out:the short one:None:None",
            "funct:_:1:adds",
            "funct:fast:0:adds fast",
            "license:GPL",
            "pin:short",
            "no colon",
        ] {
            docs.add(line);
        }
        assert_eq!(docs.component, "Adds: two numbers.");
        for (name, want) in [
            ("sum2.0.in-03", "one of the inputs: any"),
            ("sum2.0.in-x3", ""),
            ("x.a-b", "whether it-s on"),
            ("x.b", "the short one"),
            ("b", "the short one"),
            ("x.gain", ""),
            ("xgain", ""),
            ("é", ""),
        ] {
            assert_eq!(docs.item(name), want, "{name}");
        }
        assert_eq!(docs.funct("sum2.0"), "adds");
        assert_eq!(docs.funct("sum2.0.fast"), "adds fast");
    }
}
