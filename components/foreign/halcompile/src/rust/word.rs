//! Conversion of names, types and values from C to Rust.

use crate::{
    Variable,
    expr::{Expr, Gives},
    tree::{Direction, Hal, Value},
};

/// Returns the name of a field.
pub(crate) fn field(c_name: &str) -> String {
    const WORDS: &[&str] = &[
        "as",
        "async",
        "await",
        "break",
        "const",
        "continue",
        "crate",
        "dyn",
        "else",
        "enum",
        "extern",
        "false",
        "fn",
        "for",
        "gen",
        "if",
        "impl",
        "in",
        "let",
        "loop",
        "match",
        "mod",
        "move",
        "mut",
        "pub",
        "ref",
        "return",
        "self",
        "static",
        "struct",
        "super",
        "trait",
        "true",
        "type",
        "use",
        "where",
        "while",
        "abstract",
        "become",
        "box",
        "do",
        "final",
        "macro",
        "override",
        "priv",
        "try",
        "typeof",
        "unsized",
        "virtual",
        "yield",
        "b",
        "period",
        "personality",
    ];
    let name = c_name.trim_matches('_').to_lowercase();
    let starts = name.chars().next();
    if WORDS.contains(&name.as_str()) || name == ["un", "safe"].concat() {
        format!("{name}_")
    } else if starts.is_none_or(|c| c.is_ascii_digit()) {
        format!("n{name}")
    } else {
        name
    }
}

/// Returns the name of a type.
pub(crate) fn camel(c_name: &str) -> String {
    let mut out = String::new();
    for word in c_name.split('_').filter(|w| !w.is_empty()) {
        let mut chars = word.chars();
        out.extend(chars.next().map(|c| c.to_ascii_uppercase()));
        out.extend(chars);
    }
    let out = if out.starts_with(|c: char| c.is_ascii_digit()) { format!("N{out}") } else { out };
    // Names that the interface uses itself.
    let taken = [
        "In",
        "Out",
        "Io",
        "InSet",
        "Update",
        "Period",
        "Port",
        "Component",
        "Touch",
        "Error",
        "Builder",
        "Arg",
        "Self",
        "Some",
        "None",
        "Ok",
        "Err",
        "Vec",
        "String",
        "Option",
        "Result",
    ];
    if taken.contains(&out.as_str()) { format!("{out}Function") } else { out }
}

/// Returns a type's name as the derive macro converts it to the component's name.
pub(crate) fn snake(camel: &str) -> String {
    let mut out = String::new();
    for c in camel.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}

/// Returns the Rust type of a pin's value.
pub(crate) const fn value_type(hal: Hal) -> &'static str {
    match hal {
        Hal::Bit => "bool",
        Hal::Float => "f64",
        Hal::S32 => "i32",
        Hal::U32 => "u32",
        Hal::S64 => "i64",
        Hal::U64 => "u64",
        Hal::Port => "Port",
    }
}

/// Returns the handle type of a direction.
pub(crate) const fn handle(direction: Direction) -> &'static str {
    match direction {
        Direction::In => "In",
        Direction::Out => "Out",
        Direction::Io => "Io",
        Direction::R => "ParamRo",
        Direction::Rw => "ParamRw",
    }
}

/// Returns a value of this type as Rust text, or `None` where only C knows it.
pub(crate) fn value(value: Option<&Value>, kind: &str) -> Option<String> {
    let zero = match kind {
        "bool" => "false",
        "f64" | "f32" => "0.0",
        "Port" => return None,
        _ => "0",
    };
    let Some(value) = value else { return Some(zero.to_owned()) };
    let one = |truth: bool| match kind {
        "bool" => truth.to_string(),
        "f64" | "f32" => format!("{}.0", u8::from(truth)),
        _ => u8::from(truth).to_string(),
    };
    match value {
        Value::Truth(truth) => Some(one(*truth)),
        Value::Whole(n) if kind == "bool" => Some((*n != 0).to_string()),
        Value::Whole(n) if matches!(kind, "f64" | "f32") => Some(format!("{n}.0")),
        Value::Whole(n) => fits(*n, kind).then(|| n.to_string()),
        Value::Real(x) if kind == "bool" => Some((*x != 0.0).to_string()),
        Value::Real(x) if matches!(kind, "f64" | "f32") => Some(format!("{x:?}")),
        Value::Real(x) if x.fract() == 0.0 && x.abs() < 2e9 => Some(format!("{x:.0}")),
        Value::Real(_) | Value::Name(_) | Value::Text(_) => None,
    }
}

fn fits(n: i128, kind: &str) -> bool {
    match kind {
        "i8" => i8::try_from(n).is_ok(),
        "u8" => u8::try_from(n).is_ok(),
        "i16" => i16::try_from(n).is_ok(),
        "u16" => u16::try_from(n).is_ok(),
        "i32" => i32::try_from(n).is_ok(),
        "u32" => u32::try_from(n).is_ok(),
        "i64" => i64::try_from(n).is_ok(),
        _ => u64::try_from(n).is_ok(),
    }
}

/// Returns a variable's type and initial value, or `None` for pointers and for types of the C text.
pub(crate) fn variable(v: &Variable) -> Option<(String, String)> {
    let kind = match v.c_type.trim_start_matches("volatile ").trim_start_matches("const ") {
        "bool" | "_Bool" | "hal_bit_t" | "rtapi_bool" => "bool",
        "double" | "real_t" | "hal_float_t" | "rtapi_real" => "f64",
        "float" => "f32",
        "char" | "signed char" | "int8_t" | "rtapi_s8" => "i8",
        "unsigned char" | "uint8_t" | "rtapi_u8" => "u8",
        "short" | "int16_t" | "rtapi_s16" => "i16",
        "unsigned short" | "uint16_t" | "rtapi_u16" => "u16",
        "int" | "signed" | "signed int" | "int32_t" | "hal_s32_t" | "rtapi_s32" => "i32",
        "unsigned" | "unsigned int" | "uint32_t" | "hal_u32_t" | "rtapi_u32" => "u32",
        "long" | "long int" | "long long" | "long long int" | "int64_t" | "hal_s64_t"
        | "rtapi_s64" | "rtapi_sint" | "ssize_t" => "i64",
        "unsigned long" | "unsigned long long" | "unsigned long int" | "uint64_t" | "hal_u64_t"
        | "rtapi_u64" | "rtapi_uint" | "size_t" => "u64",
        _ => return None,
    };
    if v.stars > 0 {
        return None;
    }
    let first = value(v.default.as_ref(), kind)?;
    match &v.array {
        None => Some((kind.to_owned(), first)),
        Some(n) => {
            let n: u32 = n.value.parse().ok().filter(|n| *n <= 65_536)?;
            Some((format!("[{kind}; {n}]"), format!("[{first}; {n}]")))
        }
    }
}

/// Writer of expressions in Rust, with this text for the personality.
#[derive(Clone, Copy)]
pub(crate) struct Spelled<'a>(pub(crate) &'a str);

impl Spelled<'_> {
    /// Returns the expression as a number.
    pub(crate) fn number(self, e: &Expr) -> String {
        match e {
            Expr::Number(n) => i64::try_from(*n).unwrap_or(i64::MAX).to_string(),
            Expr::Personality => self.0.to_owned(),
            Expr::Pair(_, sign, _) if sign.gives != Gives::Number => {
                format!("i64::from({})", self.truth(e))
            }
            Expr::Pair(a, sign, b) => {
                let plain = (self.number(a), self.number(b));
                match sign.text {
                    "/" => format!("i64::checked_div({}, {}).unwrap_or(0)", plain.0, plain.1),
                    "*" => format!("i64::wrapping_mul({}, {})", plain.0, plain.1),
                    "<<" => format!("i64::wrapping_shl({}, {})", plain.0, self.shift(b)),
                    ">>" => format!("i64::wrapping_shr({}, {})", plain.0, self.shift(b)),
                    text => format!("{} {text} {}", self.part(a), self.part(b)),
                }
            }
            Expr::Choice(a, b, c) => {
                format!(
                    "if {} {{ {} }} else {{ {} }}",
                    self.truth(a),
                    self.number(b),
                    self.number(c)
                )
            }
        }
    }

    /// Returns the expression as a truth value.
    pub(crate) fn truth(self, e: &Expr) -> String {
        match e {
            Expr::Pair(a, sign, b) if sign.gives == Gives::Both => {
                let part = |e: &Expr| match e {
                    Expr::Pair(_, inner, _) if inner.gives == Gives::Both => {
                        format!("({})", self.truth(e))
                    }
                    _ => self.truth(e),
                };
                format!("{} {} {}", part(a), sign.text, part(b))
            }
            Expr::Pair(a, sign, b) if sign.gives == Gives::Truth => {
                format!("{} {} {}", self.part(a), sign.text, self.part(b))
            }
            other => format!("{} != 0", self.part(other)),
        }
    }

    /// Returns the expression as an operand, in parentheses where needed.
    fn part(self, e: &Expr) -> String {
        let text = self.number(e);
        let whole = match e {
            Expr::Number(_) | Expr::Personality => true,
            Expr::Pair(_, sign, _) => {
                sign.gives != Gives::Number || matches!(sign.text, "/" | "*" | "<<" | ">>")
            }
            Expr::Choice(..) => false,
        };
        if whole { text } else { format!("({text})") }
    }

    fn shift(self, e: &Expr) -> String {
        match e {
            Expr::Number(n) => n.to_string(),
            _ => format!("{} as u32", self.part(e)),
        }
    }
}
