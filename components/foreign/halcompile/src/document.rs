//! Manual page of a component.

mod adoc;
mod markup;
mod roff;

use crate::{
    Component, Item, TextKind,
    name::{hal_name, prefix},
    tree::Value,
};
use markup::{Block, Run, Style, blocks, runs};

/// Page with its sections, in order.
struct Page {
    name: String,
    /// Section of the manual: 9 for components, 1 for programs.
    chapter: u32,
    sections: Vec<(&'static str, Vec<Block>)>,
}

/// Returns the page as roff, for `man`.
#[must_use]
pub fn roff(component: &Component) -> String {
    roff::write(&page(component))
}

/// Returns the page in `AsciiDoc`.
#[must_use]
pub fn adoc(component: &Component) -> String {
    adoc::write(&page(component))
}

fn page(component: &Component) -> Page {
    let userspace = component.options.on("userspace");
    let doc = component.doc.clone().unwrap_or_default();
    let (summary, rest) = doc.trim().split_once('\n').unwrap_or((doc.trim(), ""));
    let mut about = vec![Run::plain(&format!("{} - ", component.name))];
    about.extend(runs(summary));
    let mut description = blocks(rest);
    description.extend(component.texts(TextKind::Description).flat_map(blocks));
    let written = |kind| component.texts(kind).flat_map(blocks).collect::<Vec<_>>();
    let functions = component.functions.iter().map(|f| {
        let mut head = named(component, &f.name.value, false);
        if f.fp == Some(true) {
            head.push(Run::plain(" (uses floating point)"));
        }
        term(head, f.doc.as_deref())
    });
    let items = |is_pin| {
        let chosen = component.items.iter().filter(move |i| i.is_pin() == is_pin);
        chosen.map(|i| term(item(component, i), i.doc.as_deref())).collect::<Vec<_>>()
    };
    let params = component.mod_params.iter().map(|p| {
        let mut head = vec![Run::bold(&p.name.value)];
        if let Some(default) = &p.default {
            head.push(Run::plain(&format!(" (default: {})", shown(default))));
        }
        term(head, p.doc.as_deref())
    });
    let all = vec![
        ("NAME", vec![Block::Paragraph(about)]),
        ("SYNOPSIS", vec![Block::Paragraph(synopsis(component))]),
        ("DESCRIPTION", description),
        ("MODULE PARAMETERS", params.collect()),
        ("FUNCTIONS", functions.collect()),
        ("PINS", items(true)),
        ("PARAMETERS", items(false)),
        ("EXAMPLES", written(TextKind::Examples)),
        ("NOTES", written(TextKind::Notes)),
        ("SEE ALSO", written(TextKind::SeeAlso)),
        ("AUTHOR", written(TextKind::Author)),
        ("LICENSE", written(TextKind::License)),
    ];
    Page {
        name: component.name.clone(),
        chapter: if userspace { 1 } else { 9 },
        sections: all.into_iter().filter(|(_, blocks)| !blocks.is_empty()).collect(),
    }
}

/// Returns the synopsis: the command that loads the component.
fn synopsis(component: &Component) -> Vec<Run> {
    let on = |name| component.options.on(name);
    let load = if on("userspace") { "loadusr -W " } else { "loadrt " };
    let mut out = vec![Run::bold(&format!("{load}{}", component.name))];
    let one = ["singleton", "homemod", "tpmod", "count_function"].iter().any(|o| on(o));
    if !one && on("rtapi_app") {
        for (word, value) in [(" [count=", "N"), ("|names=", "name1[,name2...]")] {
            out.extend([Run::bold(word), Run::italic(value)]);
        }
        out.push(Run::bold("]"));
    }
    if component.has_personality() && !on("userspace") {
        out.extend([Run::bold(" [personality="), Run::italic("P1[,P2...]"), Run::bold("]")]);
    }
    for p in &component.mod_params {
        let value = if p.is_int { "N" } else { "VALUE" };
        out.extend([
            Run::bold(&format!(" [{}=", p.name.value)),
            Run::italic(value),
            Run::bold("]"),
        ]);
    }
    out
}

/// Returns a full name, with N for the instance number and one M per digit of an index.
fn named(component: &Component, written: &str, is_array: bool) -> Vec<Run> {
    let options = &component.options;
    let mut out = vec![Run::bold(&prefix(&component.name))];
    if !["singleton", "homemod", "tpmod"].iter().any(|o| options.on(o)) {
        out.extend([Run::bold("."), Run::italic("N")]);
    }
    let hal = hal_name(written);
    let (before, rest) = hal.split_at(hal.find('#').unwrap_or(hal.len()));
    let after = rest.trim_start_matches('#');
    if !hal.is_empty() {
        out.push(Run::bold(&format!(".{before}")));
    }
    if is_array {
        out.push(Run::italic(&"M".repeat(rest.len() - after.len())));
        out.push(Run::bold(after));
    }
    out
}

/// Returns the entry of a pin or parameter: name, type, direction, and conditions on the personality.
fn item(component: &Component, item: &Item) -> Vec<Run> {
    let mut out = named(component, &item.name.value, item.array.is_some());
    out.push(Run::plain(&format!(" {} {}", item.kind.word, item.direction.word())));
    if let Some(array) = &item.array {
        let width = item.name.value.matches('#').count();
        let mark = "M".repeat(width);
        let last = array.max.value.saturating_sub(1);
        let text = match &array.size {
            None => format!(" ({mark}={:0width$}..{last:0width$})", 0),
            Some(size) => format!(
                " ({mark}={:0width$}.., as many as {}, at most {})",
                0,
                bare(&size.to_string()),
                array.max.value
            ),
        };
        out.push(Run::plain(&text));
    }
    if let Some(condition) = &item.condition {
        out.push(Run::plain(&format!(" [if {}]", bare(&condition.to_string()))));
    }
    if let Some(default) = &item.default {
        out.push(Run::plain(&format!(" (default: {})", shown(&default.value))));
    }
    out
}

/// Removes the outermost parentheses.
fn bare(expression: &str) -> &str {
    expression.strip_prefix('(').and_then(|e| e.strip_suffix(')')).unwrap_or(expression)
}

fn shown(value: &Value) -> String {
    match value {
        Value::Truth(truth) => truth.to_string(),
        Value::Name(name) => name.clone(),
        Value::Whole(n) => n.to_string(),
        Value::Real(x) => format!("{x:?}"),
        Value::Text(text) => text.clone(),
    }
}

fn term(head: Vec<Run>, doc: Option<&str>) -> Block {
    Block::Term(head, doc.map(blocks).unwrap_or_default())
}

impl Run {
    fn plain(text: &str) -> Self {
        Self { style: Style::Plain, text: text.to_owned() }
    }

    fn bold(text: &str) -> Self {
        Self { style: Style::Bold, text: text.to_owned() }
    }

    fn italic(text: &str) -> Self {
        Self { style: Style::Italic, text: text.to_owned() }
    }
}
