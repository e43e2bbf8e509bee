//! Macros for the names that a user's C text uses.

use super::{export::signature, writer::Writer};
use crate::{Component, Direction, Item, name::c_name};
use std::collections::BTreeSet;

/// Writes all macros.
pub(crate) fn write(component: &Component, w: &mut Writer<'_>) {
    let mut define = |name: &str, args: &str, text: &str| {
        w.line(&format!("#undef {name}"));
        w.line(&format!("#define {name}{args} {text}"));
    };
    for (name, text) in [("TRUE", "(1)"), ("FALSE", "(0)"), ("true", "(1)"), ("false", "(0)")] {
        define(name, "", text);
    }
    define("FUNCTION", "(name)", &signature(component, "name"));
    let inst = "struct __comp_state *__comp_inst";
    let setup = |name: &str| format!("static int {name}({inst}, char *prefix, long extra_arg)");
    define("EXTRA_SETUP", "()", &setup("extra_setup"));
    define("EXTRA_CLEANUP", "()", "static void extra_cleanup(void)");
    define("POST_EXPORT", "()", &setup("post_export").replacen("int", "void", 1));
    let loop_ =
        format!("for ({inst} = __comp_first_inst; __comp_inst; __comp_inst = __comp_inst->_next)");
    define("FOR_ALL_INSTS", "()", &loop_);
    if component.options.on("period") {
        define("fperiod", "", "(period * 1e-9)");
    }
    if let Some(kind) = component.options.word("data") {
        define("data", "", &format!("(*({kind} *)__comp_inst->_data)"));
    }
    if component.has_personality() {
        define("personality", "", "(__comp_inst->_personality)");
    }
    let taken: BTreeSet<String> = component
        .items
        .iter()
        .map(|i| c_name(&i.name.value))
        .chain(component.variables.iter().map(|v| v.name.value.clone()))
        .collect();
    for item in &component.items {
        for (name, args, text) in of_item(item) {
            // If a pin is called `x_ptr`, it gets that name, and the pin `x` has no pointer macro.
            let derived = name != c_name(&item.name.value);
            if !derived || !taken.contains(&name) {
                define(&name, args, &text);
            }
        }
    }
    for v in &component.variables {
        let name = &v.name.value;
        define(name, "", &format!("(__comp_inst->{name}_p)"));
    }
}

/// Returns the macros of an item: name, arguments, text.
fn of_item(item: &Item) -> Vec<(String, &'static str, String)> {
    let c = c_name(&item.name.value);
    let (args, index) = if item.array.is_some() { ("(i)", "[i]") } else { ("", "") };
    let place = format!("__comp_inst->{c}_p{index}");
    if item.kind.handle {
        let kind = item.kind.word;
        let set_args = if item.array.is_some() { "(i, v)" } else { "(v)" };
        return vec![
            (c.clone(), args, format!("(hal_get_{kind}({place}))")),
            (format!("{c}_set"), set_args, format!("(hal_set_{kind}({place}, (v)))")),
            (format!("{c}_ptr"), args, format!("({place})")),
        ];
    }
    let (read, at) = match item.direction {
        // An rvalue: C code cannot assign to an input.
        Direction::In => (format!("(0 + *{place})"), format!("({place})")),
        Direction::Out | Direction::Io => (format!("(*{place})"), format!("({place})")),
        Direction::R | Direction::Rw => (format!("({place})"), format!("(&{place})")),
    };
    vec![(c.clone(), args, read), (format!("{c}_ptr"), args, at)]
}
