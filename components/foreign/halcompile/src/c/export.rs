//! The C function `export`, which makes an instance.

use super::{value, writer::Writer};
use crate::{
    Component, Item, Variable,
    name::{c_name, hal_format, hashes},
    tree::Hal,
};

/// Returns the head of a function's C definition.
pub(crate) fn signature(component: &Component, name: &str) -> String {
    let period = if component.options.on("period") { ", long period" } else { "" };
    format!("static void {name}(struct __comp_state *__comp_inst{period})")
}

/// Writes the whole of `export`.
pub(crate) fn write(component: &Component, w: &mut Writer<'_>) {
    let options = &component.options;
    let has_personality = component.has_personality();
    w.line("");
    w.line("/* Makes an instance: its pins, parameters and functions. */");
    w.line("__attribute__((unused))");
    let personality = if has_personality { ", long personality" } else { "" };
    w.line(&format!("static int export(char *prefix, long extra_arg{personality})"));
    w.line("{");
    w.line("    struct __comp_state *made = hal_malloc(sizeof(*made));");
    w.line("    long at, count;");
    w.line("    int rc;");
    w.line("    (void)extra_arg; (void)at; (void)count; (void)rc;");
    w.line("    if (!made) return -ENOMEM;");
    w.line("    memset(made, 0, sizeof(*made));");
    if options.word("data").is_some() {
        w.line("    made->_data = hal_malloc(__comp_data_size());");
        w.line("    if (!made->_data) return -ENOMEM;");
        w.line("    memset(made->_data, 0, __comp_data_size());");
    }
    if has_personality {
        w.line("    made->_personality = personality;");
    }
    if options.on("extra_setup") {
        w.line("    rc = extra_setup(made, prefix, extra_arg);");
        w.line("    if (rc != 0) return rc;");
        if has_personality {
            w.line("    personality = made->_personality;");
        }
    }
    // Pins first, whatever the order of declarations.
    for is_pin in [true, false] {
        for i in component.items.iter().filter(|i| i.is_pin() == is_pin) {
            item(i, w);
        }
    }
    for v in &component.variables {
        variable(component, v, w);
    }
    for f in &component.functions {
        let (c, hal) = (c_name(&f.name.value), hal_format(&f.name.value));
        let format = if hal.is_empty() { "%s".to_owned() } else { format!("%s.{hal}") };
        let fp = u8::from(f.fp.unwrap_or(true));
        w.line(&format!("    rc = hal_export_functf((void (*)(void *, long)){c}, made, {fp}, 0, comp_id, \"{format}\", prefix);"));
        w.line("    if (rc != 0) return rc;");
    }
    w.line("    if (__comp_last_inst) __comp_last_inst->_next = made;");
    if component.has_program_inst() {
        w.line("    else __comp_inst = __comp_first_inst = made;");
    } else {
        w.line("    else __comp_first_inst = made;");
    }
    w.line("    __comp_last_inst = made;");
    if options.on("post_export") {
        w.line("    post_export(made, prefix, extra_arg);");
    }
    w.line("    return 0;");
    w.line("}");
}

/// Writes the code that makes a pin or parameter, or all elements of an array.
fn item(item: &Item, w: &mut Writer<'_>) {
    let (c, written) = (c_name(&item.name.value), &item.name.value);
    let index = if item.array.is_some() { "[at]" } else { "" };
    let place = format!("made->{c}_p{index}");
    if let Some(condition) = &item.condition {
        w.line(&format!("    if ({condition}) {{"));
    }
    if let Some(array) = &item.array {
        let max = array.max.value;
        match &array.size {
            None => w.line(&format!("    count = {max};")),
            Some(size) => {
                w.line(&format!("    count = {size};"));
                w.line(&format!("    if (count > {max}) {{"));
                let what = if item.is_pin() { "Pin" } else { "Parameter" };
                w.line(&format!("        rtapi_print_msg(RTAPI_MSG_ERR, \"{what} {written}: Requested size %ld exceeds max size {max}\\n\", count);"));
                w.line("        return -ENOSPC;");
                w.line("    }");
            }
        }
        w.line("    for (at = 0; at < count; at++) {");
    }
    w.line(&format!("    rc = {};", made(item, &place)));
    w.line("    if (rc != 0) return rc;");
    if let (false, Some(default)) = (item.kind.handle, &item.default) {
        let star = if item.is_pin() { "*" } else { "" };
        w.line(&format!("    {star}{place} = {};", value(&default.value)));
    }
    if item.array.is_some() {
        w.line("    }");
    }
    if item.condition.is_some() {
        // If the item does not exist, C code can still read and write it where the interface offers that.
        if item.kind.handle && !item.is_pin() && item.array.is_none() {
            w.line("    } else {");
            w.line(&format!("    rc = hal_param_new_fake(comp_id, (hal_refs_u *)&{place});"));
            w.line("    if (rc != 0) return rc;");
        }
        w.line("    }");
    }
}

/// Returns the call that makes the item.
fn made(item: &Item, place: &str) -> String {
    let name = &item.name.value;
    let args = if hashes(name) > 0 { "prefix, (int)at" } else { "prefix" };
    let name = format!("\"%s.{}\", {args}", hal_format(name));
    let (what, direction) = (if item.is_pin() { "pin" } else { "param" }, item.direction.c());
    if item.kind.handle {
        let kind = item.kind.word;
        let default = item.default.as_ref().map_or_else(|| "0".to_owned(), |d| value(&d.value));
        format!("hal_{what}_new_{kind}(comp_id, {direction}, &{place}, {default}, {name})")
    } else {
        let kind = item.kind.hal.word();
        debug_assert!(item.is_pin() || item.kind.hal != Hal::Port, "no parameter is a port");
        format!("hal_{what}_{kind}_newf({direction}, &{place}, comp_id, {name})")
    }
}

fn variable(component: &Component, v: &Variable, w: &mut Writer<'_>) {
    let Some(default) = &v.default else { return };
    let (name, default) = (&v.name.value, value(default));
    let line = component.line(v.name.span);
    match &v.array {
        None => w.at(line, &format!("    made->{name}_p = {default};")),
        Some(size) => w.at(
            line,
            &format!("    for (at = 0; at < {}; at++) made->{name}_p[at] = {default};", size.value),
        ),
    }
}
