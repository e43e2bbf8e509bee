//! Functions in Rust: their fields, and the C text to be translated.

use super::{
    Function, Plan,
    body::{comment, names},
    word::{field, handle, value_type, variable},
};
use crate::{Item, name::c_name};

impl Plan<'_> {
    /// Returns the items of a function: those that its C text names, and those that no function names.
    pub(super) fn chosen(&self, index: usize) -> impl Iterator<Item = (&Item, &String)> {
        self.component.items.iter().zip(&self.fields).filter(move |(item, _)| {
            let c = c_name(&item.name.value);
            let touches = |text: &str| {
                ["", "_set", "_ptr"].iter().any(|end| names(text, &format!("{c}{end}")))
            };
            let named = |f: &Function| touches(&f.c_text);
            let here = self.functions.get(index).is_some_and(named);
            here || touches(&self.parts.rest) || !self.functions.iter().any(named)
        })
    }

    /// Returns the variables, which the first function keeps: name, type, initial value.
    pub(super) fn state(&self, index: usize) -> impl Iterator<Item = (String, String, String)> {
        let first = index == 0;
        let all = self.component.variables.iter().filter(move |_| first);
        all.filter_map(|v| {
            let (kind, value) = variable(v)?;
            let mut name = field(&v.name.value);
            while self.fields.contains(&name) {
                name.push('_');
            }
            Some((name, kind, value))
        })
    }

    pub(super) fn function(&self, index: usize) -> String {
        let Some(f) = self.functions.get(index) else { return String::new() };
        let mut out = String::from("\n");
        for line in f.doc.trim().lines() {
            out.push_str(format!("/// {}", line.trim()).trim_end());
            out.push('\n');
        }
        let state: Vec<_> = self.state(index).collect();
        if !state.is_empty() {
            out.push_str(
                "#[expect(dead_code, reason = \"the C text is still to be translated\")]\n",
            );
        }
        out.push_str(&format!("#[derive(Touch)]\nstruct {} {{\n", f.kind));
        for (item, field) in self.chosen(index) {
            let kind = format!("{}<{}>", handle(item.direction), value_type(item.kind.hal));
            let kind = match (&item.array, &item.condition) {
                (Some(_), _) => format!("Vec<{kind}>"),
                (None, Some(_)) => format!("Option<{kind}>"),
                (None, None) => kind,
            };
            out.push_str(&format!("    {field}: {kind},\n"));
        }
        for (name, kind, _) in &state {
            out.push_str(&format!("    #[state]\n    {name}: {kind},\n"));
        }
        for v in self.component.variables.iter().filter(|v| index == 0 && variable(v).is_none()) {
            let array = v.array.as_ref().map_or(String::new(), |a| format!("[{}]", a.value));
            out.push_str(&format!(
                "    // To be chosen: {} {}{}{array};\n",
                v.c_type,
                "*".repeat(v.stars),
                v.name.value
            ));
        }
        if let Some(data) = self.component.options.word("data").filter(|_| index == 0) {
            out.push_str(&format!("    // To be chosen: {data} data;\n"));
        }
        out.push_str("}\n\n");
        out.push_str(&format!("impl Update for {} {{\n", f.kind));
        out.push_str("    fn update(&mut self, _period: Period) {\n        // To be translated:\n        //\n");
        out.push_str(&comment(&f.c_text, "        "));
        if index == 0 && self.functions.len() > 1 && !self.component.variables.is_empty() {
            out.push_str("        //\n        // What another function needs of this one's state goes through `Builder::shared`.\n");
        }
        out.push_str("    }\n}\n");
        out
    }
}
