//! A manual page as a Markdown file beside the code.

use super::{
    Entry, Page,
    prose::Doc,
    text::{synopsis, thread, word},
};
use std::fmt::Write;

impl Page {
    /// Returns the page in Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let doc = Doc::of(&self.offer.doc);
        let name = &self.offer.component;
        let mut out = format!("# {name}\n\n{}\n", doc.summary);
        let mut was_line = false;
        for p in &doc.paragraphs {
            let is_line = p.starts_with(['|', '-', '*']);
            out.push_str(if was_line && is_line { "" } else { "\n" });
            was_line = is_line;
            out.push_str(&format!("{p}\n"));
        }
        let library = &self.offer.library;
        let file = if library == name { String::new() } else { format!(" Library `{library}`.") };
        let line = synopsis(name, &self.offer.args);
        let also: Vec<String> = self.also.iter().map(|name| code(name)).collect();
        let also = if also.is_empty() {
            also.concat()
        } else {
            format!(" Also called {}.", also.join(", "))
        };
        out.push_str(&format!("\n## Load\n\n`{line}`{file}{also}\n"));
        self.arguments(&mut out);
        self.made_by(&mut out);
        let (pins, params): (Vec<&Entry>, Vec<&Entry>) =
            self.items.iter().partition(|e| e.direction.is_pin());
        items(&mut out, "Pins", &pins);
        items(&mut out, "Parameters", &params);
        if !self.functs.is_empty() {
            out.push_str("\n## Functions\n\n| function | thread | what it does |\n|---|---|---|\n");
            for f in &self.functs {
                row(&mut out, &[&range(&f.first, f.last.as_ref()), thread(f), &f.doc]);
            }
        }
        if !self.commands.is_empty() {
            out.push_str("\n## Commands\n\n| command | what it does |\n|---|---|\n");
            for c in &self.commands {
                let args: Vec<String> = c.args.iter().map(|a| format!(" {}=…", a.name)).collect();
                row(&mut out, &[&code(&format!("{}{}", c.name, args.concat())), &c.doc]);
            }
        }
        if let Some(example) = &doc.example {
            out.push_str("\n## Example\n\n");
            for p in &doc.before {
                out.push_str(&format!("{p}\n\n"));
            }
            out.push_str(&format!("```hal\n{example}```\n"));
        }
        out
    }

    /// Writes the lines that made the pins below, unless it is the plain `loadrt NAME`.
    fn made_by(&self, out: &mut String) {
        let name = &self.offer.component;
        if let Some(why) = &self.refused {
            out.push_str(&format!("\nNothing of it could be made: {why}.\n"));
            return;
        }
        if let [lines] = &*self.loads
            && *lines == [format!("loadrt {name}")]
        {
            return;
        }
        let lines: Vec<String> =
            self.loads.iter().filter_map(|lines| lines.last()).map(|line| code(line)).collect();
        let made =
            if self.items.is_empty() { "Loaded here as" } else { "The pins here are those of" };
        out.push_str(&format!("\n{made} {}.\n", lines.join(" or ")));
    }

    fn arguments(&self, out: &mut String) {
        if self.offer.args.is_empty() {
            return;
        }
        let has_ranges = self.offer.args.iter().any(|a| !a.range().is_empty());
        let (range, line) = if has_ranges { (" range |", "---|") } else { ("", "") };
        let head = format!("| argument | type |{range} without it | what it is |");
        out.push_str(&format!("\n{head}\n|---|---|{line}---|---|\n"));
        for a in &self.offer.args {
            let without = match (&a.default, a.required) {
                (_, true) => "required",
                (Some(default), _) => default.as_str(),
                (None, _) => "-",
            };
            let (name, range) = (code(&a.name), a.range());
            let mut cells = vec![name.as_str(), &a.ty, &range, without, &a.doc];
            if !has_ranges {
                cells.remove(2);
            }
            row(out, &cells);
        }
    }
}

fn items(out: &mut String, title: &str, list: &[&Entry]) {
    if list.is_empty() {
        return;
    }
    write!(out, "\n## {title}\n\n| name | type | direction | default | what it is |\n")
        .unwrap_or(());
    out.push_str("|---|---|---|---|---|\n");
    for e in list {
        let comma = if e.with.is_empty() { "" } else { ", " };
        let name = format!("{}{comma}{}", range(&e.first, e.last.as_ref()), e.with);
        row(out, &[&name, e.ty.name(), word(e), &e.default, &e.doc]);
    }
}

fn range(first: &str, last: Option<&String>) -> String {
    let last = last.map(|last| format!(" to {}", code(last))).unwrap_or_default();
    code(first) + &last
}

fn code(text: &str) -> String {
    format!("`{text}`")
}

fn row(out: &mut String, cells: &[&str]) {
    for cell in cells {
        let words: Vec<&str> = cell.split_whitespace().collect();
        let text = words.join(" ").replace('|', "\\|");
        out.push_str(&format!("| {text} "));
    }
    out.push_str("|\n");
}
