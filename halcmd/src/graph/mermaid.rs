//! The picture for Mermaid. Boxes list their pins; wires name the pins they connect.

use super::{
    drawing::{Boxed, Drawing},
    svg::{NO_THREAD, colour},
};
use crate::language::units::duration;
use hal_protocol::Type;
use std::collections::BTreeMap;

/// Ends of wires: node and pin.
type Ends = Vec<(String, String)>;

/// Returns the graph in the language of Mermaid.
pub(super) fn mermaid(drawing: &Drawing) -> String {
    let mut out = format!("---\ntitle: {}\n---\nflowchart LR\n", title(&drawing.title));
    let mut ends: BTreeMap<usize, (Ends, Ends)> = BTreeMap::new();
    for (i, b) in drawing.boxes.iter().enumerate() {
        let node = format!("b{i}");
        out.push_str(&format!("  {node}[\"{}\"]\n", contents(b)));
        for section in &b.sections {
            for (pins, left) in [(&section.left, true), (&section.right, false)] {
                for (pin, signal) in pins.iter().filter_map(|p| Some((p, p.signal?))) {
                    let (from, to) = ends.entry(signal).or_default();
                    let list = if left { to } else { from };
                    list.push((node.clone(), short(&b.name, &section.name, &pin.label)));
                }
            }
        }
    }
    for (number, signal) in drawing.signals.iter().enumerate() {
        let (from, to) = ends.remove(&number).unwrap_or_default();
        let loose = |out: &mut String| {
            out.push_str(&format!("  s{number}((\" \"))\n"));
            vec![(format!("s{number}"), String::new())]
        };
        let from = if from.is_empty() { loose(&mut out) } else { from };
        let to = if to.is_empty() { loose(&mut out) } else { to };
        for (a, out_pin) in &from {
            for (b, in_pin) in &to {
                let pins = match (out_pin.as_str(), in_pin.as_str()) {
                    ("", "") => String::new(),
                    (pin, "") | ("", pin) => format!("<br/>{}", escape(pin)),
                    (a, b) => format!("<br/>{} to {}", escape(a), escape(b)),
                };
                let name = escape(&signal.name);
                out.push_str(&format!("  {a} {}|\"{name}{pins}\"| {b}\n", line(signal.ty)));
            }
        }
    }
    for (i, thread) in drawing.threads.iter().enumerate() {
        let text = format!("{}, every {}", thread.name, duration(thread.period));
        out.push_str(&format!("  t{i}([\"{}\"])\n", escape(&text)));
        out.push_str(&format!("  style t{i} fill:{},color:#ffffff\n", colour(i)));
    }
    for (i, b) in drawing.boxes.iter().enumerate() {
        let threads: Vec<usize> = b.threads().into_iter().collect();
        // The border has the colour of the fastest thread; the names of functions have their own
        // threads' colours.
        let border = threads.first().map_or(NO_THREAD, |t| colour(*t));
        let dashes = if b.program { ",stroke-dasharray:4 3" } else { "" };
        out.push_str(&format!(
            "  style b{i} fill:#f8fafc,color:#1f2933,stroke:{border},stroke-width:3px{dashes}\n"
        ));
    }
    out
}

fn contents(b: &Boxed) -> String {
    let mut text = format!("<b>{}</b>", escape(&b.title()));
    for (name, thread) in &b.functs {
        let colour = rgb(colour(*thread));
        text.push_str(&format!("<br/><span style='color:{colour}'>{}</span>", escape(name)));
    }
    for (name, value) in &b.params {
        text.push_str(&format!("<br/>{} = {}", escape(name), escape(value)));
    }
    // A wire names the pins at its ends, so the box lists only the others.
    for pin in b.pins().filter(|p| p.signal.is_none()) {
        text.push_str(&format!("<br/>{}", escape(&pin.label)));
    }
    text
}

/// Returns the name of a pin within its box.
fn short(boxed: &str, section: &str, label: &str) -> String {
    match section.strip_prefix(boxed).and_then(|rest| rest.strip_prefix('.')) {
        Some(rest) => format!("{rest}.{label}"),
        None if section.is_empty() => label.to_owned(),
        None => format!("{section}.{label}"),
    }
}

/// Writes a colour without '#', which begins a character code in Mermaid.
fn rgb(colour: &str) -> String {
    let part = |at: usize| colour.get(at..at + 2).and_then(|t| u8::from_str_radix(t, 16).ok());
    format!("rgb({},{},{})", part(1).unwrap_or(0), part(3).unwrap_or(0), part(5).unwrap_or(0))
}

const fn line(ty: Type) -> &'static str {
    match ty {
        Type::Float => "==>",
        Type::S32 | Type::U32 | Type::S64 | Type::U64 | Type::Port => "-.->",
        Type::Bit => "-->",
    }
}

/// Writes every character but letters, digits and a few others as a number.
fn escape(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        if c.is_alphanumeric() || " .-_,()=µ:/+".contains(c) {
            out.push(c);
        } else if c.is_control() {
            out.push('\u{fffd}');
        } else {
            out.push_str(&format!("#{};", u32::from(c)));
        }
    }
    out
}

/// Quotes a text for YAML.
fn title(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
