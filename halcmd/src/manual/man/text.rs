//! A manual page as terminal text.

use super::{Entry, Function, Page, grid::grid, prose::Doc};
use crate::manual::wrap::wrapped;
use hal_protocol::{ArgInfo, Direction};

/// Indentation of text.
const IN: usize = 4;

impl Page {
    /// Returns the page as lines of a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let doc = Doc::of(&self.offer.doc);
        let name = &self.offer.component;
        let mut out = String::new();
        section(&mut out, "NAME", &wrapped(&format!("{name} - {}", summary(&doc)), IN));
        let library = &self.offer.library;
        let mut load = wrapped(&synopsis(name, &self.offer.args), IN);
        if !library.is_empty() && library != name {
            load.push_str(&wrapped(&format!("It is in the library '{library}'."), IN));
        }
        if !self.also.is_empty() {
            load.push_str(&wrapped(&format!("It is also called {}.", self.also.join(", ")), IN));
        }
        section(&mut out, "SYNOPSIS", &load);
        section(&mut out, "DESCRIPTION", &prose(&doc.paragraphs));
        section(&mut out, "ARGUMENTS", &self.offer.args.iter().map(argument).collect::<String>());
        section(&mut out, "LOADED HERE AS", &self.loaded());
        section(&mut out, "PINS", &entries(self.items.iter().filter(|e| e.direction.is_pin())));
        let parameters = entries(self.items.iter().filter(|e| !e.direction.is_pin()));
        section(&mut out, "PARAMETERS", &parameters);
        let functions = self.functs.iter().map(|f| entry(&funct_title(f), &f.doc));
        section(&mut out, "FUNCTIONS", &functions.collect::<String>());
        let commands = self.commands.iter().map(|c| {
            let args: String = c.args.iter().map(argument).collect();
            entry(&c.name, &c.doc) + &args.lines().map(|l| format!("    {l}\n")).collect::<String>()
        });
        section(&mut out, "COMMANDS", &commands.collect::<String>());
        let lines = doc.example.unwrap_or_default();
        let lines: String = lines.lines().map(|l| format!("    {l}\n")).collect();
        let about = prose(&doc.before);
        section(&mut out, "EXAMPLE", &if about.is_empty() { lines } else { about + "\n" + &lines });
        out
    }

    fn loaded(&self) -> String {
        if let Some(why) = &self.refused {
            return wrapped(&format!("Nothing of it could be made: {why}."), IN);
        }
        self.loaded_lines().lines().map(|line| format!("    {line}\n")).collect()
    }

    /// Returns the lines that made the pins below, unless it is the plain `loadrt NAME`.
    pub(super) fn loaded_lines(&self) -> String {
        let plain = [format!("loadrt {}", self.offer.component)];
        match &*self.loads {
            [lines] if *lines == plain => String::new(),
            [lines] => lines.iter().map(|line| format!("{line}\n")).collect(),
            all => all.iter().filter_map(|l| l.last()).map(|l| format!("{l}\n")).collect(),
        }
    }
}

pub(super) fn summary(doc: &Doc) -> String {
    if doc.summary.is_empty() {
        return "a component in C, of which only its file tells".to_owned();
    }
    plain(&doc.summary)
}

fn section(out: &mut String, title: &str, body: &str) {
    if !body.is_empty() {
        let before = if out.is_empty() { "" } else { "\n" };
        out.push_str(&format!("{before}{title}\n{body}"));
    }
}

/// Returns the `loadrt` line with all arguments.
pub(super) fn synopsis(name: &str, args: &[ArgInfo]) -> String {
    let word = |arg: &ArgInfo| {
        let value = match arg.ty.as_str() {
            "ints" => "N,N...",
            "texts" => "TEXT,TEXT...",
            "text" => "TEXT",
            "float" => "X",
            "bit" => "0|1",
            _ => "N",
        };
        let word = format!("{}={value}", arg.name);
        if arg.required { word } else { format!("[{word}]") }
    };
    let words: Vec<String> = args.iter().map(word).collect();
    format!("loadrt {name} {}", words.join(" ")).trim_end().to_owned()
}

fn argument(arg: &ArgInfo) -> String {
    entry(&argument_title(arg), &arg.doc)
}

pub(super) fn argument_title(arg: &ArgInfo) -> String {
    let default = arg.default.as_ref().map(|d| format!(", {d} if not given")).unwrap_or_default();
    let required = if arg.required { ", required" } else { "" };
    let range = arg.range();
    let comma = if range.is_empty() { "" } else { ", " };
    format!("{} ({}{comma}{range}{required}{default})", arg.name, arg.ty)
}

fn entries<'e>(list: impl Iterator<Item = &'e Entry>) -> String {
    list.map(|e| entry(&item_title(e), &e.doc)).collect()
}

pub(super) fn item_title(e: &Entry) -> String {
    let last = e.last.as_ref().map(|last| format!(" to {last}")).unwrap_or_default();
    let default = match default(e) {
        Some(value) => format!(", default {value}"),
        None => String::new(),
    };
    let comma = if e.with.is_empty() { "" } else { ", " };
    let with = format!("{comma}{}", plain(&e.with));
    format!("{}{last} ({} {}{default}){with}", e.first, e.ty.name(), word(e))
}

pub(super) fn funct_title(f: &Function) -> String {
    let last = f.last.as_ref().map(|last| format!(" to {last}")).unwrap_or_default();
    format!("{}{last} ({} thread)", f.first, thread(f))
}

/// Returns the initial value for items that users set, and for others if it is not 0 or FALSE.
fn default(e: &Entry) -> Option<&str> {
    let is_set = matches!(e.direction, Direction::In | Direction::Io | Direction::Rw);
    let is_nothing = matches!(e.default.as_str(), "0" | "FALSE");
    (is_set || !is_nothing).then_some(e.default.as_str())
}

/// Returns the threads to which a function belongs.
pub(super) const fn thread(funct: &Function) -> &'static str {
    if funct.fast { "fast" } else { "any" }
}

/// Returns the direction, as manuals write it.
pub(super) const fn word(entry: &Entry) -> &'static str {
    match entry.direction {
        Direction::In => "in",
        Direction::Out => "out",
        Direction::Io => "io",
        Direction::Ro => "r",
        Direction::Rw => "rw",
    }
}

fn entry(title: &str, doc: &str) -> String {
    let doc: Vec<&str> = doc.split_whitespace().collect();
    let doc = plain(&doc.join(" "));
    let body = if doc.is_empty() { String::new() } else { wrapped(&doc, 2 * IN) };
    wrapped(title, IN) + &body
}

fn prose(paragraphs: &[String]) -> String {
    let mut out = String::new();
    let mut was = ' ';
    for block in paragraphs.chunk_by(|a, b| a.starts_with('|') && b.starts_with('|')) {
        let Some(p) = block.first() else { continue };
        let is = p.chars().next().filter(|c| "|-*".contains(*c)).unwrap_or(' ');
        if !out.is_empty() && (is == ' ' || is != was) {
            out.push('\n');
        }
        was = is;
        out.push_str(&if is == '|' {
            grid(&block.iter().map(String::as_str).collect::<Vec<_>>(), IN)
        } else {
            wrapped(&plain(p), IN)
        });
    }
    out
}

/// Removes the marks of Markdown.
pub(super) fn plain(text: &str) -> String {
    text.replace('`', "")
}
