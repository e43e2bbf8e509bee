//! Generation of C text from a component.
//!
//! The names that a user's C text relies on (`FUNCTION`, `fperiod`, `__comp_inst`, `NAME(i)` …) belong to the language;
//! all other names are this crate's own.

mod entry;
mod export;
mod macros;
mod state;
mod writer;

use crate::{Component, TextKind};
use writer::Writer;

/// Inputs of the C text other than the component.
#[derive(Clone, Debug)]
pub struct Wanted<'a> {
    /// Path of the .comp file, as the compiler's messages show it.
    pub source: &'a str,
    /// Path of the C file, as the compiler's messages show it.
    pub out: &'a str,
    /// Number of personalities that `personality=` can hold.
    pub personalities: u32,
}

/// Returns the whole C file.
#[must_use]
pub fn text(component: &Component, wanted: &Wanted<'_>) -> String {
    let mut w = Writer::new(wanted.source, wanted.out);
    let userspace = component.options.on("userspace");
    w.line(&format!(
        "/* Made by halcompile from {}: change that file, not this one. */",
        component.name
    ));
    w.line("#include \"rtapi.h\"");
    if !userspace {
        w.line("#include \"rtapi_app.h\"");
    }
    for header in ["rtapi_string.h", "rtapi_errno.h", "rtapi_math64.h", "hal.h"] {
        w.line(&format!("#include \"{header}\""));
    }
    if userspace {
        w.line("#include <stdlib.h>");
    }
    w.line("");
    w.line("static int comp_id;");
    for header in &component.includes {
        w.at(component.line(header.span), &format!("#include {}", header.value));
    }
    said(component, &mut w);
    state::write(component, &mut w);
    entry::declare(component, wanted.personalities, &mut w);
    export::write(component, &mut w);
    if component.options.on("rtapi_app") {
        entry::write(component, wanted.personalities, &mut w);
    }
    if userspace {
        entry::program(component, &mut w);
    }
    if !component.options.on("no_convenience_defines") {
        macros::write(component, &mut w);
    }
    body(component, &mut w);
    w.finish()
}

/// Writes module information, for tools that read the file without running it.
fn said(component: &Component, w: &mut Writer<'_>) {
    let mut info = |text: String| w.line(&format!("MODULE_INFO(linuxcnc, {});", quoted(&text)));
    let doc = |d: &Option<String>| d.clone().unwrap_or_default();
    let none = || "None".to_owned();
    info(format!("component:{}:{}", component.name, doc(&component.doc)));
    for i in &component.items {
        let array = i.array.as_ref().map_or(0, |a| a.max.value);
        let default = i.default.as_ref().map_or_else(none, |d| value(&d.value));
        let condition = i.condition.as_ref().map_or_else(none, ToString::to_string);
        let what = if i.is_pin() { "pin" } else { "param" };
        let (name, kind, direction) = (&i.name.value, i.kind.word, i.direction.word());
        info(format!(
            "{what}:{name}:{kind}:{array}:{direction}:{}:{default}:{condition}",
            doc(&i.doc)
        ));
    }
    for f in &component.functions {
        let fp = u8::from(f.fp.unwrap_or(true));
        info(format!("funct:{}:{fp}:{}", f.name.value, doc(&f.doc)));
    }
    let license = component.texts(TextKind::License).next().unwrap_or_default();
    let license = license.trim().lines().next().unwrap_or_default();
    info(format!("license:{license}"));
    if !component.options.on("userspace") {
        w.line(&format!("MODULE_LICENSE({});", quoted(license)));
    }
}

/// Writes the user's own text, with its original line numbers.
fn body(component: &Component, w: &mut Writer<'_>) {
    w.line("");
    let bare = component.functions.first().filter(|_| component.is_bare());
    if let Some(function) = bare {
        let name = crate::name::c_name(&function.name.value);
        w.line(&format!("{} {{", export::signature(component, &name)));
    }
    let text = component.body.text.trim_end_matches('\n');
    // The closing brace gets a line of the user's file, so that compiler messages about it name that file.
    let close = if bare.is_some() { "\n}" } else { "" };
    w.user(&format!("{text}{close}"), component.body.line);
    if let Some(kind) = component.options.word("data") {
        let line = component.options.place("data").map_or(1, |p| component.line(p.span));
        let size =
            format!("static unsigned long __comp_data_size(void) {{ return sizeof({kind}); }}");
        w.at(line, &size);
    }
}

/// Returns the text as a C string literal.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            // Escaped, so that no trigraph such as ??( can result.
            '?' => out.push_str("\\?"),
            '\n' => out.push_str("\\n"),
            '\t' => out.push_str("\\t"),
            '\r' => out.push_str("\\r"),
            c if c.is_control() => {
                out.extend(c.to_string().bytes().map(|b| format!("\\{b:03o}")));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Returns the value as C text.
fn value(value: &crate::Value) -> String {
    use crate::Value;
    match value {
        Value::Truth(truth) => u8::from(*truth).to_string(),
        Value::Name(name) => name.clone(),
        Value::Text(text) => quoted(text),
        Value::Real(x) => format!("{x:?}"),
        Value::Whole(n) => match n {
            _ if *n == i128::from(i64::MIN) => "(-9223372036854775807LL - 1)".to_owned(),
            _ if i64::try_from(*n).is_err() => format!("{n}ULL"),
            _ if i32::try_from(*n).is_err() => format!("{n}LL"),
            _ => n.to_string(),
        },
    }
}
