//! Entry and exit of a component: its parameters, `rtapi_app_main`, and a program's `main`.

use super::{quoted, value, writer::Writer};
use crate::{Component, name::prefix};

/// Maximum number of named instances of a program.
const PROGRAM_NAMES: u32 = 16;

/// Source of the number of instances.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Asked {
    /// Always a single instance.
    One,
    /// The C text decides.
    Function,
    /// The arguments `count=` or `names=`.
    Arguments,
}

fn asked(component: &Component) -> Asked {
    let on = |name| component.options.on(name);
    if on("singleton") || on("homemod") || on("tpmod") {
        Asked::One
    } else if on("count_function") {
        Asked::Function
    } else {
        Asked::Arguments
    }
}

/// Writes the variables that `loadrt` sets.
pub(crate) fn declare(component: &Component, personalities: u32, w: &mut Writer<'_>) {
    let options = &component.options;
    let name = &component.name;
    let userspace = options.on("userspace");
    w.line("");
    for p in component.mod_params.iter().filter(|p| p.is_int) {
        let line = component.line(p.name.span);
        let (name, default) = (&p.name.value, p.default.as_ref().map_or("0".to_owned(), value));
        w.at(line, &format!("static int {name} = {default};"));
        let doc = quoted(p.doc.as_deref().unwrap_or_default());
        if !userspace {
            w.line(&format!("RTAPI_MP_INT({name}, {doc})"));
        }
    }
    if asked(component) == Asked::Arguments {
        let count = options.whole("default_count").unwrap_or(1);
        w.line(&format!("enum {{ __comp_default_count = {count} }};"));
        w.line("static int count;");
        if userspace {
            w.line(&format!("static char *names[{PROGRAM_NAMES}];"));
        } else {
            w.line("static char *names = \"\";");
            w.line(&format!("RTAPI_MP_INT(count, \"How many of {name} there are.\")"));
            w.line(&format!(
                "RTAPI_MP_STRING(names, \"The names of {name}, with commas between them.\")"
            ));
        }
    }
    if component.has_personality() {
        let first = options.whole("default_personality").unwrap_or(0);
        let list = format!("{{[0 ... {personalities} - 1] = {first}}}");
        w.line(&format!("static int personality[{personalities}] = {list};"));
        if !userspace {
            w.line(&format!(
                "RTAPI_MP_ARRAY_INT(personality, {personalities}, \"What each of {name} is.\")"
            ));
        }
    }
}

/// Writes `rtapi_app_main` and `rtapi_app_exit`.
pub(crate) fn write(component: &Component, personalities: u32, w: &mut Writer<'_>) {
    let options = &component.options;
    let name = &component.name;
    let asked = asked(component);
    w.line("");
    if options.on("constructable") {
        w.line("static int __comp_construct(const char *prefix, const char *arg)");
        w.line("{");
        let personality = if component.has_personality() { ", personality[0]" } else { "" };
        let number = if options.on("userspace") { "strtol" } else { "simple_strtol" };
        w.line(&format!(
            "    return export((char *)prefix, arg ? {number}(arg, NULL, 0) : 0{personality});"
        ));
        w.line("}");
        w.line("");
    }
    if asked != Asked::One {
        nth(component, personalities, w);
    }
    if asked == Asked::Function {
        w.line("static int __comp_count;");
    }
    w.line("static int __comp_make_all(void)");
    w.line("{");
    match asked {
        Asked::One => {
            let personality = if component.has_personality() { ", personality[0]" } else { "" };
            w.line(&format!("    return export(\"{}\", 0{personality});", prefix(name)));
        }
        Asked::Function => numbered(component, "__comp_count", w),
        Asked::Arguments => {
            let first = if options.on("userspace") { "names[0]" } else { "names[0] != '\\0'" };
            w.line(&format!("    if ({first}) {{"));
            if options.on("userspace") {
                program_names(w);
            } else {
                module_names(w);
            }
            w.line("    }");
            numbered(component, "(count ? count : __comp_default_count)", w);
        }
    }
    w.line("}");
    w.line("");
    main(component, asked, w);
    w.line("");
    w.line("void rtapi_app_exit(void)");
    w.line("{");
    if options.on("extra_cleanup") {
        w.line("    extra_cleanup();");
    }
    w.line("    hal_exit(comp_id);");
    w.line("}");
}

fn main(component: &Component, asked: Asked, w: &mut Writer<'_>) {
    let options = &component.options;
    let name = &component.name;
    w.line("int rtapi_app_main(void)");
    w.line("{");
    w.line("    int rc;");
    match asked {
        Asked::Function => {
            w.line("    __comp_count = get_count();");
            w.line("    if (__comp_count < 0) return __comp_count;");
        }
        Asked::Arguments if !options.on("userspace") => {
            w.line("    if (count && names[0]) {");
            w.line("        rtapi_print_msg(RTAPI_MSG_ERR, \"count= and names= are mutually exclusive\\n\");");
            w.line("        return -EINVAL;");
            w.line("    }");
        }
        Asked::One | Asked::Arguments => {}
    }
    w.line(&format!("    comp_id = hal_init({});", quoted(name)));
    w.line("    if (comp_id < 0) return comp_id;");
    if options.on("constructable") {
        w.line("    hal_set_constructor(comp_id, __comp_construct);");
    }
    w.line("    rc = __comp_make_all();");
    w.line("    if (rc == 0) rc = hal_ready(comp_id);");
    w.line("    if (rc != 0) {");
    if options.on("extra_cleanup") {
        w.line("        extra_cleanup();");
    }
    w.line("        hal_exit(comp_id);");
    w.line("    }");
    w.line("    return rc;");
    w.line("}");
}

/// Writes the function that makes the instance of an index, with its personality.
fn nth(component: &Component, personalities: u32, w: &mut Writer<'_>) {
    w.line("static int __comp_make(char *prefix, int index)");
    w.line("{");
    if component.has_personality() {
        w.line(&format!("    if (index >= {personalities})"));
        w.line(&format!("        rtapi_print_msg(RTAPI_MSG_ERR, \"{}: there are {personalities} personalities; instance %d takes that of %d\\n\", index, index % {personalities});", component.name));
        w.line(&format!("    return export(prefix, index, personality[index % {personalities}]);"));
    } else {
        w.line("    return export(prefix, index);");
    }
    w.line("}");
    w.line("");
}

/// Writes the loop that makes numbered instances.
fn numbered(component: &Component, count: &str, w: &mut Writer<'_>) {
    w.line("    for (int i = 0; i < COUNT; i++) {".replace("COUNT", count).as_str());
    w.line("        char name[HAL_NAME_LEN + 1];");
    w.line(&format!(
        "        rtapi_snprintf(name, sizeof(name), \"{}.%d\", i);",
        prefix(&component.name)
    ));
    w.line("        int rc = __comp_make(name, i);");
    w.line("        if (rc != 0) return rc;");
    w.line("    }");
    w.line("    return 0;");
}

/// Writes the loop that makes instances named in one comma-separated text.
fn module_names(w: &mut Writer<'_>) {
    w.line("        const char *rest = names;");
    w.line("        for (int i = 0; rest; i++) {");
    w.line("            char name[HAL_NAME_LEN + 1];");
    w.line("            const char *comma = strchr(rest, ',');");
    w.line(
        "            unsigned long length = comma ? (unsigned long)(comma - rest) : strlen(rest);",
    );
    w.line("            if (length >= sizeof(name)) {");
    w.line("                rtapi_print_msg(RTAPI_MSG_ERR, \"names: \\\"%.*s\\\" too long\\n\", (int)length, rest);");
    w.line("                return -EINVAL;");
    w.line("            }");
    w.line("            if (length == 0) {");
    w.line("                rtapi_print_msg(RTAPI_MSG_ERR, \"names[%d] is invalid (empty string)\\n\", i);");
    w.line("                return -EINVAL;");
    w.line("            }");
    w.line("            memcpy(name, rest, length);");
    w.line("            name[length] = '\\0';");
    w.line("            int rc = __comp_make(name, i);");
    w.line("            if (rc != 0) return rc;");
    w.line("            rest = comma ? comma + 1 : NULL;");
    w.line("        }");
    w.line("        return 0;");
}

/// Writes the loop that makes instances named in a list.
fn program_names(w: &mut Writer<'_>) {
    w.line(&format!("        for (int i = 0; i < {PROGRAM_NAMES} && names[i]; i++) {{"));
    w.line("            int rc = __comp_make(names[i], i);");
    w.line("            if (rc != 0) return rc;");
    w.line("        }");
    w.line("        return 0;");
}

/// Writes the `main` of a program, which removes `count=` and `names=` from its arguments wherever they occur.
pub(crate) fn program(component: &Component, w: &mut Writer<'_>) {
    let options = &component.options;
    w.line("");
    w.line("int argc;");
    w.line("char **argv;");
    w.line("int main(int given, char **words)");
    w.line("{");
    w.line("    int kept = 0;");
    if asked(component) == Asked::Arguments {
        w.line("    int counted = 0, named = 0;");
        w.line("    for (int i = 0; i < given; i++) {");
        w.line("        char *end;");
        w.line("        if (strncmp(words[i], \"count=\", 6) == 0) {");
        w.line("            counted = 1;");
        w.line("            count = strtol(words[i] + 6, &end, 0);");
        w.line("            if (*end || end == words[i] + 6 || count < 0) {");
        w.line("                rtapi_print_msg(RTAPI_MSG_ERR, \"%s is not a number of instances\\n\", words[i]);");
        w.line("                return 1;");
        w.line("            }");
        w.line("        } else if (strncmp(words[i], \"names=\", 6) == 0) {");
        w.line("            named = 1;");
        w.line("            char *word = strtok(words[i] + 6, \",\");");
        w.line(&format!("            for (int n = 0; word && n < {PROGRAM_NAMES}; n++) {{"));
        w.line("                names[n] = word;");
        w.line("                word = strtok(NULL, \",\");");
        w.line("            }");
        w.line("        } else {");
        w.line("            words[kept++] = words[i];");
        w.line("        }");
        w.line("    }");
        w.line("    words[kept] = NULL;");
        w.line("    if (counted && named) {");
        w.line("        rtapi_print_msg(RTAPI_MSG_ERR, \"count= and names= are mutually exclusive\\n\");");
        w.line("        return 1;");
        w.line("    }");
    } else {
        w.line("    kept = given;");
    }
    w.line("    argc = kept;");
    w.line("    argv = words;");
    if options.on("userinit") {
        w.line("    userinit(argc, argv);");
    }
    if options.on("rtapi_app") {
        w.line("    if (rtapi_app_main() < 0) return 1;");
    } else {
        w.line("    extern int rtapi_app_main(void);");
        w.line("    if (rtapi_app_main() < 0) return 1;");
    }
    w.line("    user_mainloop();");
    w.line("    extern void rtapi_app_exit(void);");
    w.line("    rtapi_app_exit();");
    w.line("    return 0;");
    w.line("}");
}
