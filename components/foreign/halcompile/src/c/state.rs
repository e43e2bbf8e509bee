//! State of each instance: `struct __comp_state`.

use super::{export::signature, writer::Writer};
use crate::{
    Component, Item,
    name::c_name,
    tree::{Hal, Kind},
};

/// Returns the C type that an instance holds for an item: a pointer, a handle, or the value itself.
fn held(item: &Item) -> String {
    let Kind { hal, handle, .. } = item.kind;
    match (handle, item.is_pin()) {
        (true, _) => format!("{} ", handle_type(hal)),
        (false, true) => format!("hal_{}_t *", hal.word()),
        (false, false) => format!("hal_{}_t ", hal.word()),
    }
}

const fn handle_type(hal: Hal) -> &'static str {
    match hal {
        Hal::Bit => "hal_bool_t",
        Hal::Float => "hal_real_t",
        Hal::S32 | Hal::S64 | Hal::Port => "hal_sint_t",
        Hal::U32 | Hal::U64 => "hal_uint_t",
    }
}

/// Writes the struct, the list of instances, and the forward declarations.
pub(crate) fn write(component: &Component, w: &mut Writer<'_>) {
    // C text without the macros may use either name of a member.
    let plain = component.options.on("no_convenience_defines");
    let member = |kind: &str, c: &str, array: &str| {
        let alone = format!("{kind}{c}_p{array};");
        if plain {
            format!("    union {{ {alone} {kind}{c}{array}; }};")
        } else {
            format!("    {alone}")
        }
    };
    w.line("");
    w.line("struct __comp_state {");
    w.line("    struct __comp_state *_next;");
    if component.has_personality() {
        w.line("    int _personality;");
    }
    for item in &component.items {
        let array = item.array.as_ref().map_or(String::new(), |a| format!("[{}]", a.max.value));
        w.line(&member(&held(item), &c_name(&item.name.value), &array));
    }
    for v in &component.variables {
        let kind = format!("{} {}", v.c_type, "*".repeat(v.stars));
        let array = v.array.as_ref().map_or(String::new(), |a| format!("[{}]", a.value));
        w.at(component.line(v.name.span), &member(&kind, &v.name.value, &array));
    }
    if component.options.word("data").is_some() {
        w.line("    void *_data;");
    }
    w.line("};");
    w.line("static struct __comp_state *__comp_first_inst, *__comp_last_inst;");
    if component.has_program_inst() {
        w.line("static struct __comp_state *__comp_inst;");
    }
    w.line("");
    for f in &component.functions {
        w.line(&format!("{};", signature(component, &c_name(&f.name.value))));
    }
    let later = [
        (
            "extra_setup",
            "int extra_setup(struct __comp_state *__comp_inst, char *prefix, long extra_arg);",
        ),
        ("extra_cleanup", "void extra_cleanup(void);"),
        (
            "post_export",
            "void post_export(struct __comp_state *__comp_inst, char *prefix, long extra_arg);",
        ),
        ("count_function", "int get_count(void);"),
        ("userspace", "void user_mainloop(void);"),
        ("userinit", "void userinit(int argc, char **argv);"),
    ];
    for (_, text) in later.iter().filter(|(option, _)| component.options.on(option)) {
        w.line(&format!("static {text}"));
    }
    if component.options.word("data").is_some() {
        w.line("static unsigned long __comp_data_size(void);");
    }
}
