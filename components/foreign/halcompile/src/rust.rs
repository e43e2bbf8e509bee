//! Declaration of a component in Rust: pins, parameters, state and functions, for the interface of `hal-component`. The
//! C text is kept as comments, to be translated.

mod body;
mod by_hand;
mod derived;
mod function;
mod word;

use crate::{
    Component, Item,
    name::{c_name, hal_name},
};
use body::{Parts, comment, names};
use std::collections::BTreeSet;
use word::{camel, field};

/// Returns the Rust file.
#[must_use]
pub fn text(component: &Component) -> String {
    let plan = Plan::new(component);
    let mut out = String::new();
    let name = &component.name;
    out.push_str(&format!("//! `{name}`, from its .comp file: the declaration is whole, the C text is to be translated.\n"));
    out.push_str("#![forbid(");
    // Split, because a search for the word alone would find it in this file.
    out.push_str(&["un", "safe_code)]\n\n"].concat());
    let beside = plan.parts.rest.clone();
    if !beside.is_empty() {
        out.push_str("// The C text beside the functions:\n//\n");
        out.push_str(&comment(&beside, ""));
        out.push('\n');
    }
    let code = match plan.derived() {
        Some(code) => code,
        None => {
            let functions = (0..plan.functions.len()).map(|i| plan.function(i));
            functions.fold(plan.component_impl(), |code, function| code + &function)
        }
    };
    out.push_str(&Plan::imports(&code));
    out.push_str(&code);
    out.push_str(&format!("\nhal_component::export!({});\n", plan.kind));
    out
}

/// Function of the component, or the loop of a program.
struct Function {
    /// Name of its type.
    kind: String,
    /// Part of its HAL name after the instance's.
    hal: String,
    doc: String,
    c_text: String,
}

/// Rust names for everything.
struct Plan<'a> {
    component: &'a Component,
    parts: Parts,
    /// Name of the component's type.
    kind: String,
    /// Field of each item.
    fields: Vec<String>,
    functions: Vec<Function>,
    /// True if items are declared by their full names.
    once: bool,
    is_program: bool,
}

impl<'a> Plan<'a> {
    fn new(component: &'a Component) -> Self {
        let parts = body::parts(component);
        let mut taken = BTreeSet::new();
        let mut unique = |name: String| {
            let mut name = name;
            while !taken.insert(name.clone()) {
                name.push('_');
            }
            name
        };
        let fields =
            component.items.iter().map(|i| unique(field(&c_name(&i.name.value)))).collect();
        let mut kinds = BTreeSet::new();
        let mut of_kind = |name: String| {
            let mut name = name;
            while !kinds.insert(name.clone()) {
                name.push_str("Function");
            }
            name
        };
        let kind = of_kind(camel(&component.name));
        let is_program = component.options.on("userspace");
        let mut functions: Vec<Function> = Vec::new();
        for (f, c_text) in component.functions.iter().zip(&parts.functions) {
            let c = c_name(&f.name.value);
            let name = camel(&c);
            let kind = of_kind(if name.is_empty() { format!("{kind}Function") } else { name });
            let doc = f.doc.clone().unwrap_or_else(|| summary(component));
            functions.push(Function {
                kind,
                hal: hal_name(&f.name.value),
                doc,
                c_text: c_text.clone(),
            });
        }
        if is_program {
            functions.push(Function {
                kind: of_kind(format!("{kind}Loop")),
                hal: "loop".to_owned(),
                doc: "What the program did in its loop.".to_owned(),
                c_text: component.body.text.trim().to_owned(),
            });
        }
        let once = ["singleton", "homemod", "tpmod"].iter().any(|o| component.options.on(o));
        Self { component, parts, kind, fields, functions, once, is_program }
    }

    fn imports(code: &str) -> String {
        let code: String = code.lines().filter(|l| !l.trim_start().starts_with("//")).collect();
        let mut list = Vec::new();
        for name in [
            "Arg",
            "Builder",
            "Component",
            "Error",
            "In",
            "Io",
            "Out",
            "ParamRo",
            "ParamRw",
            "Period",
            "Port",
            "Touch",
            "Update",
        ] {
            if names(&code, name) {
                list.push(name.to_owned());
            }
        }
        let abi: Vec<&str> =
            ["ArgSpec", "component_flags"].into_iter().filter(|n| names(&code, n)).collect();
        match abi.as_slice() {
            [] => {}
            [one] => list.push(format!("abi::{one}")),
            more => list.push(format!("abi::{{{}}}", more.join(", "))),
        }
        format!("use hal_component::{{{}}};\n\n", list.join(", "))
    }
}

fn undocumented(item: &Item) -> String {
    let what = if item.is_pin() { "Pin" } else { "Parameter" };
    format!("{what} `{}`; the C file does not say what it means.", hal_name(&item.name.value))
}

fn summary(component: &Component) -> String {
    let doc = component.doc.clone().unwrap_or_default();
    let first = doc.trim().lines().next().unwrap_or_default().trim().to_owned();
    if first.is_empty() { format!("The component `{}`.", component.name) } else { first }
}

/// Returns the summary, and the description of the file.
fn about(component: &Component) -> String {
    let doc = component.doc.clone().unwrap_or_else(|| summary(component));
    let mut parts = vec![doc.trim().to_owned()];
    parts.extend(component.texts(crate::TextKind::Description).map(|t| t.trim().to_owned()));
    parts.join("\n\n")
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
