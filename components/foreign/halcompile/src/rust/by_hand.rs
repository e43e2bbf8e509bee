//! Component that is declared by hand: with several functions, items that only some instances have, or arguments.

use super::{
    Plan, about,
    body::names,
    one_line, summary, undocumented,
    word::{Spelled, handle, value, value_type},
};
use crate::{
    Item, Value,
    name::{hal_format, hal_name, prefix},
};

/// Name of the variable that holds the personality.
const PERSONALITY: Spelled<'static> = Spelled("personality");

impl Plan<'_> {
    pub(super) fn component_impl(&self) -> String {
        let c = self.component;
        let mut out = format!("/// {}\nstruct {};\n\n", summary(c), self.kind);
        out.push_str(&format!("impl Component for {} {{\n", self.kind));
        out.push_str(&format!("    const NAME: &'static str = {:?};\n", c.name));
        out.push_str(&format!("    const DOC: &'static str = {:?};\n", about(c)));
        let mut flags = Vec::new();
        if self.once {
            flags.push("component_flags::ONCE");
        }
        if c.has_personality() {
            flags.push("component_flags::PERSONALITY");
        }
        if !flags.is_empty() {
            out.push_str(&format!("    const FLAGS: u32 = {};\n", flags.join(" | ")));
        }
        out.push_str(&self.arguments());
        out.push_str("\n    fn create(b: &mut Builder<'_>) -> Result<(), Error> {\n");
        out.push_str(&self.notes());
        let before = out.len();
        for (item, field) in c.items.iter().zip(&self.fields) {
            out.push_str(&self.declared(item, field));
        }
        if c.has_personality() && names(out.get(before..).unwrap_or_default(), "personality") {
            let get = match c.options.whole("default_personality") {
                None => "let personality = b.personality();".to_owned(),
                Some(n) => format!(
                    "// Not given, it is 0.\n        let personality = match b.personality() {{ 0 => {n}, given => given }};"
                ),
            };
            out.insert_str(before, &format!("        {get}\n"));
        }
        for (i, f) in self.functions.iter().enumerate() {
            let mut inits: Vec<String> = self.chosen(i).map(|(_, field)| field.clone()).collect();
            // A list can be moved only once; a handle can be copied.
            let later = |field: &String| {
                (i + 1..self.functions.len()).any(|n| self.chosen(n).any(|(_, f)| f == field))
            };
            for (item, field) in self.chosen(i) {
                if item.array.is_some() && later(field) {
                    let whole = format!("{field}: {field}.clone()");
                    inits.iter_mut().filter(|x| *x == field).for_each(|x| x.clone_from(&whole));
                }
            }
            inits.extend(self.state(i).map(|(name, _, first)| format!("{name}: {first}")));
            let function = format!("{} {{ {} }}", f.kind, inits.join(", "));
            let hal = self.full(&f.hal);
            let (call, period) =
                if self.is_program { ("task", "10_000_000, ") } else { ("function", "") };
            out.push_str(&format!(
                "        b.{call}({hal:?}, {:?}, {period}{function})?;\n",
                one_line(&f.doc)
            ));
        }
        out.push_str("        Ok(())\n    }\n}\n");
        out
    }

    /// Returns notes on differences between the C file and the interface.
    fn notes(&self) -> String {
        let options = &self.component.options;
        let mut out = String::new();
        let mut note = |text: &str| out.push_str(&format!("        // {text}\n"));
        if let Some(n) = options.whole("default_count") {
            note(&format!("The C file made {n} without being asked: scripts say count={n}."));
        }
        if options.on("count_function") {
            note(
                "The C file counted its instances itself (get_count): scripts say count=N, or set",
            );
            note("set component_flags::ONCE, and declare all of them here under their full names.");
        }
        if !options.on("rtapi_app") {
            note("The C file had its own rtapi_app_main: set the flag ONCE, and declare here what");
            note("it exported, under full names.");
        }
        if options.on("extra_setup") {
            note("EXTRA_SETUP ran here, before the pins were made.");
        }
        if options.on("extra_cleanup") {
            note("EXTRA_CLEANUP ran at unloading: what is to end then implements Drop.");
        }
        if self.is_program {
            note(
                "The C file was a program of its own. Here its loop is a task, outside the threads.",
            );
        }
        out
    }

    fn arguments(&self) -> String {
        let params = &self.component.mod_params;
        if params.is_empty() {
            return String::new();
        }
        let mut out = "    const ARGS: &'static [&'static ArgSpec] = &[\n".to_owned();
        for p in params {
            let doc =
                p.doc.clone().unwrap_or_else(|| format!("As the C file's `{}`.", p.name.value));
            let kind = if p.is_int { "int" } else { "text" };
            let default = match &p.default {
                Some(Value::Whole(n)) => format!(".or({:?})", n.to_string()),
                Some(Value::Truth(t)) => format!(".or({:?})", u8::from(*t).to_string()),
                _ => String::new(),
            };
            out.push_str(&format!(
                "        &Arg::{kind}({:?}, {:?}){default},\n",
                p.name.value,
                one_line(&doc)
            ));
        }
        out.push_str("    ];\n");
        out
    }

    /// Returns the name within the instance, or the full name.
    fn full(&self, hal: &str) -> String {
        match (self.once, hal.is_empty()) {
            (false, _) => hal.to_owned(),
            (true, true) => prefix(&self.component.name),
            (true, false) => format!("{}.{hal}", prefix(&self.component.name)),
        }
    }

    /// Returns the lines that declare an item.
    fn declared(&self, item: &Item, field: &str) -> String {
        let hal = hal_name(&item.name.value);
        let kind = value_type(item.kind.hal);
        let first = value(item.default.as_ref().map(|d| &d.value), kind);
        let (first, note) = match first {
            Some(first) => (first, String::new()),
            None if kind == "Port" => ("Port::default()".to_owned(), String::new()),
            None => {
                let zero = value(None, kind).unwrap_or_default();
                let said =
                    item.default.as_ref().map(|d| format!("{:?}", d.value)).unwrap_or_default();
                (zero, format!("        // The C file begins with {said}.\n"))
            }
        };
        let doc = one_line(&item.doc.clone().unwrap_or_else(|| undocumented(item)));
        let handle = format!("{}<{kind}>", handle(item.direction));
        let plain = |name: &str| format!("b.item({name}, {doc:?}, {first})?");
        let Some(array) = &item.array else {
            let call = plain(&format!("{:?}", self.full(&hal)));
            return match &item.condition {
                None => format!("{note}        let {field}: {handle} = {call};\n"),
                Some(e) => format!(
                    "{note}        let {field}: Option<{handle}> = if {} {{ Some({call}) }} else {{ None }};\n",
                    PERSONALITY.truth(e)
                ),
            };
        };
        let format = hal_format(&item.name.value);
        let index = match format.split_once("%0") {
            Some((before, rest)) => {
                let (width, after) = rest.split_once('d').unwrap_or((rest, ""));
                format!("{before}{{i:0{width}}}{after}")
            }
            None => format.replacen("%d", "{i}", 1),
        };
        let mut out = note;
        out.push_str(&format!("        let mut {field}: Vec<{handle}> = Vec::new();\n"));
        let max = array.max.value;
        let mut count = max.to_string();
        let mut check = String::new();
        if let Some(size) = &array.size {
            count = PERSONALITY.number(size);
            let message =
                format!("Pin {}: Requested size {{n}} exceeds max size {max}", item.name.value);
            check = format!(
                "let n = {count};\nif n > {max} {{\n    return Err(Error::new(format!({message:?})));\n}}\n"
            );
            count = "n".to_owned();
        }
        let call = plain(&format!("&format!({:?})", self.full(&index)));
        let looped = format!("{check}for i in 0..{count} {{\n    {field}.push({call});\n}}\n");
        let indented = |depth: usize| -> String {
            let line = |l: &str| format!("{}{l}\n", "    ".repeat(depth));
            looped.lines().map(line).collect()
        };
        match &item.condition {
            None => out.push_str(&indented(2)),
            Some(e) => {
                let condition = PERSONALITY.truth(e);
                out.push_str(&format!("        if {condition} {{\n{}        }}\n", indented(3)));
            }
        }
        out
    }
}
