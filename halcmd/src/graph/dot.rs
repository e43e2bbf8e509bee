//! The picture for Graphviz. Boxes are tables with a port for each pin.

use super::{
    drawing::{Boxed, Drawing, Pin},
    svg::{NO_THREAD, colour, escape},
};
use crate::language::units::duration;
use hal_protocol::Type;
use std::collections::BTreeMap;

/// The ends of a signal: the writing pins, then the reading pins.
type Ends = (Vec<String>, Vec<String>);

/// Returns the graph in the DOT language.
pub(super) fn dot(drawing: &Drawing) -> String {
    let mut out = format!(
        "digraph machine {{\n  rankdir=LR;\n  labelloc=t;\n  label={};\n  \
         node [shape=plain, fontname=\"monospace\", fontsize=10];\n  \
         edge [fontname=\"monospace\", fontsize=9];\n",
        quoted(&drawing.title)
    );
    let mut ends: BTreeMap<usize, Ends> = BTreeMap::new();
    for (i, b) in drawing.boxes.iter().enumerate() {
        boxed(&mut out, i, b, &mut ends);
    }
    for (number, signal) in drawing.signals.iter().enumerate() {
        let (from, to) = ends.remove(&number).unwrap_or_default();
        let loose = |out: &mut String| {
            let node = format!("s{number}");
            out.push_str(&format!("  {node} [shape=circle, label=\"\", width=0.08];\n"));
            vec![node]
        };
        let from = if from.is_empty() { loose(&mut out) } else { from };
        let to = if to.is_empty() { loose(&mut out) } else { to };
        let name = quoted(&signal.name);
        for from in &from {
            for to in &to {
                out.push_str(&format!("  {from} -> {to} [label={name}, {}];\n", style(signal.ty)));
            }
        }
    }
    for (i, thread) in drawing.threads.iter().enumerate() {
        let text = format!("{}, every {}", thread.name, duration(thread.period));
        out.push_str(&format!(
            "  t{i} [shape=box, style=filled, fontcolor=white, fillcolor=\"{}\", label={}];\n",
            colour(i),
            quoted(&text)
        ));
    }
    out + "}\n"
}

fn boxed(out: &mut String, number: usize, b: &Boxed, ends: &mut BTreeMap<usize, Ends>) {
    let threads = b.threads();
    // Graphviz shows two colours at most.
    let colours: Vec<&str> = threads.iter().take(2).map(|t| colour(*t)).collect();
    let colours = if colours.is_empty() { NO_THREAD.to_owned() } else { colours.join(":") };
    let mut rows = format!(
        "<tr><td colspan=\"2\" bgcolor=\"{colours}\"><font color=\"white\"><b>{}</b></font></td></tr>",
        escape(&b.title())
    );
    for (name, thread) in &b.functs {
        rows.push_str(&format!(
            "<tr><td colspan=\"2\" align=\"left\"><font color=\"{}\">{}</font></td></tr>",
            colour(*thread),
            escape(name)
        ));
    }
    let mut next = 0;
    for section in &b.sections {
        if !section.name.is_empty() {
            rows.push_str(&format!(
                "<tr><td colspan=\"2\"><i>{}</i></td></tr>",
                escape(&section.name)
            ));
        }
        for row in 0..section.left.len().max(section.right.len()) {
            let mut cell = |pin: Option<&Pin>, left: bool| {
                let align = if left { "left" } else { "right" };
                let Some(pin) = pin else { return "<td border=\"0\"></td>".to_owned() };
                let port = format!("p{next}");
                next += 1;
                if let Some(signal) = pin.signal {
                    let side = if left { "w" } else { "e" };
                    let (from, to) = ends.entry(signal).or_default();
                    let list = if left { to } else { from };
                    list.push(format!("b{number}:{port}:{side}"));
                }
                format!("<td port=\"{port}\" align=\"{align}\">{}</td>", escape(&pin.label))
            };
            let (left, right) =
                (cell(section.left.get(row), true), cell(section.right.get(row), false));
            rows.push_str(&format!("<tr>{left}{right}</tr>"));
        }
    }
    for (name, value) in &b.params {
        let text = format!("{} = {}", escape(name), escape(value));
        rows.push_str(&format!("<tr><td colspan=\"2\" align=\"left\">{text}</td></tr>"));
    }
    out.push_str(&format!(
        "  b{number} [label=<<table border=\"1\" cellborder=\"0\" cellspacing=\"0\" \
         cellpadding=\"3\">{rows}</table>>];\n"
    ));
}

const fn style(ty: Type) -> &'static str {
    match ty {
        Type::Bit => "penwidth=1",
        Type::Float => "penwidth=2",
        Type::S32 | Type::U32 => "style=dashed",
        Type::S64 | Type::U64 => "style=\"dashed\", penwidth=2",
        Type::Port => "style=dotted, penwidth=2",
    }
}

fn quoted(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
