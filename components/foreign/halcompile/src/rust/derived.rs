//! Component that a struct declares completely: one function, and the same items for all instances.

use super::{
    Plan, about,
    body::comment,
    one_line, undocumented,
    word::{Spelled, field, handle, value, value_type, variable},
};
use crate::{Item, name::hal_name};

/// Expression for the personality where a count is needed.
const PERSONALITY: Spelled<'static> = Spelled("b.personality()");

impl Plan<'_> {
    /// Returns the struct and its code, or `None` where a struct cannot express the component.
    pub(super) fn derived(&self) -> Option<String> {
        let c = self.component;
        let options = ["count_function", "extra_setup", "extra_cleanup"].map(|o| c.options.on(o));
        let other = options.contains(&true)
            || !c.options.on("rtapi_app")
            || self.once
            || self.is_program
            || !c.mod_params.is_empty()
            || c.options.whole("default_count").is_some()
            || c.options.whole("default_personality").is_some()
            || c.items.iter().any(|i| i.condition.is_some());
        let [function] = self.functions.as_slice() else { return None };
        if other {
            return None;
        }
        let mut hal = Vec::new();
        if super::word::snake(&self.kind) != c.name {
            hal.push(format!("name = {:?}", c.name));
        }
        if !function.hal.is_empty() {
            hal.push(format!("function = {:?}", function.hal));
        }
        if c.has_personality() {
            hal.push("personality".to_owned());
        }
        let mut out = docs(&about(c), "");
        let state: Vec<_> = c.variables.iter().map(|v| (v, variable(v))).collect();
        if state.iter().any(|(_, known)| known.is_some()) {
            out.push_str(
                "#[expect(dead_code, reason = \"the C text is still to be translated\")]\n",
            );
        }
        out.push_str("#[derive(Component)]\n");
        if !hal.is_empty() {
            out.push_str(&format!("#[hal({})]\n", hal.join(", ")));
        }
        out.push_str(&format!("struct {} {{\n", self.kind));
        for (item, field) in c.items.iter().zip(&self.fields) {
            out.push_str(&of_item(item, field));
        }
        for (v, known) in state {
            let array = v.array.as_ref().map_or(String::new(), |a| format!("[{}]", a.value));
            let Some((kind, first)) = known else {
                let stars = "*".repeat(v.stars);
                out.push_str(&format!(
                    "    // To be chosen: {} {stars}{}{array};\n",
                    v.c_type, v.name.value
                ));
                continue;
            };
            let mut name = field(&v.name.value);
            while self.fields.contains(&name) {
                name.push('_');
            }
            out.push_str("    #[state]\n");
            if v.default.is_some() || v.array.is_some() {
                out.push_str(&format!("    #[hal(default = {first})]\n"));
            }
            out.push_str(&format!("    {name}: {kind},\n"));
        }
        if let Some(data) = c.options.word("data") {
            out.push_str(&format!("    // To be chosen: {data} data;\n"));
        }
        out.push_str(&format!("}}\n\nimpl Update for {} {{\n", self.kind));
        out.push_str("    fn update(&mut self, _period: Period) {\n        // To be translated:\n        //\n");
        out.push_str(&comment(&function.c_text, "        "));
        out.push_str("    }\n}\n");
        if out.contains("count = at_most(") {
            out.push_str(AT_MOST);
        }
        Some(out)
    }
}

/// Generated Rust function that refuses arrays larger than the C file allows.
const AT_MOST: &str = "
/// The size of a list; more than there can be is refused.
fn at_most(most: i64, wanted: i64) -> Result<i64, Error> {
    if wanted > most {
        return Err(Error::new(format!(\"Requested size {wanted} exceeds max size {most}\")));
    }
    Ok(wanted.max(0))
}
";

/// Returns the field of the struct for an item.
fn of_item(item: &Item, field: &str) -> String {
    let kind = value_type(item.kind.hal);
    let hal = hal_name(&item.name.value);
    let mut out =
        docs(&item.doc.clone().map_or_else(|| undocumented(item), |d| one_line(&d)), "    ");
    let mut words = Vec::new();
    if hal != field.replace('_', "-").trim_end_matches('-') {
        words.push(format!("name = {hal:?}"));
    }
    if let Some(default) = &item.default {
        match value(Some(&default.value), kind) {
            Some(first) => words.push(format!("default = {first}")),
            None => out.push_str(&format!("    // The C file begins with {:?}.\n", default.value)),
        }
    }
    if let Some(array) = &item.array {
        let max = array.max.value;
        words.push(match &array.size {
            None => format!("count = {max}"),
            Some(size) => format!("count = at_most({max}, {})?", PERSONALITY.number(size)),
        });
    }
    if !words.is_empty() {
        out.push_str(&format!("    #[hal({})]\n", words.join(", ")));
    }
    let handle = format!("{}<{kind}>", handle(item.direction));
    let whole = if item.array.is_some() { format!("Vec<{handle}>") } else { handle };
    out.push_str(&format!("    {field}: {whole},\n"));
    out
}

/// Returns the text as lines of documentation.
fn docs(text: &str, indent: &str) -> String {
    let line = |l: &str| format!("{}\n", format!("{indent}/// {}", l.trim()).trim_end());
    text.trim().lines().map(line).collect()
}
