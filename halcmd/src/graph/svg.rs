//! The picture as SVG. It needs no other program, and a wire shows its name under the mouse.

use super::{
    drawing::{Boxed, Drawing, Signal},
    layout::{Layout, Placed},
    size::{GRID, IN, OUT, text_width},
    wires::Wire,
};
use crate::language::units::duration;
use hal_protocol::{Direction, Type};

/// Colours of the threads, fastest first, and of components without a thread.
pub(super) const THREADS: [&str; 6] =
    ["#c2571a", "#2f6db3", "#3b8f3e", "#8a4fa3", "#a8862b", "#b03a5b"];
pub(super) const NO_THREAD: &str = "#6b7280";
/// Colours that only distinguish wires from each other.
const WIRES: [&str; 8] =
    ["#1d4e89", "#9c3d12", "#1b6e3c", "#7a2e8e", "#00707c", "#8c1c47", "#5b4a00", "#37474f"];
const MARGIN: i64 = 24;
const TOP: i64 = 56;

/// Returns the picture.
pub(super) fn svg(drawing: &Drawing) -> String {
    let layout = Layout::of(drawing);
    let legend = legend(drawing);
    let width = layout.width.max(legend.0).max(text_width(&drawing.title, 110)) + 2 * MARGIN;
    let height = layout.height + TOP + MARGIN + 3 * GRID;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\">\n<style>\n{STYLE}</style>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n\
         <text class=\"title\" x=\"{MARGIN}\" y=\"32\">{}</text>\n\
         <g transform=\"translate({MARGIN} {TOP})\">\n",
        escape(&drawing.title)
    );
    // Wires come first, so that boxes and names cover them.
    for wire in &layout.wires {
        paint_wire(&mut out, drawing, wire);
    }
    for placed in &layout.boxes {
        paint_box(&mut out, drawing, placed);
    }
    for wire in &layout.wires {
        paint_label(&mut out, drawing, wire);
    }
    out.push_str(&format!(
        "</g>\n<g transform=\"translate({MARGIN} {})\">\n{}</g>\n</svg>\n",
        layout.height + TOP + MARGIN,
        legend.1
    ));
    out
}

const STYLE: &str = "\
text { font-family: 'DejaVu Sans Mono', 'Liberation Mono', Menlo, Consolas, monospace; \
font-size: 11px; fill: #1f2933; }
.title { font-size: 18px; font-weight: bold; }
.name { font-size: 13px; font-weight: bold; fill: #ffffff; }
.small { font-size: 10px; fill: #52606d; }
.wire { fill: none; stroke-linecap: round; stroke-linejoin: round; }
.label { font-size: 10px; paint-order: stroke; stroke: #ffffff; stroke-width: 3px; }
";

/// Returns the colour of a thread.
pub(super) fn colour(thread: usize) -> &'static str {
    THREADS.iter().cycle().nth(thread % THREADS.len()).copied().unwrap_or(NO_THREAD)
}

/// Returns the line style for a type.
const fn stroke(ty: Type) -> &'static str {
    match ty {
        Type::Bit => "stroke-width=\"1.2\"",
        Type::Float => "stroke-width=\"2.4\"",
        Type::S32 | Type::U32 => "stroke-width=\"1.8\" stroke-dasharray=\"7 3\"",
        Type::S64 | Type::U64 => "stroke-width=\"1.8\" stroke-dasharray=\"9 3 2 3\"",
        Type::Port => "stroke-width=\"3\" stroke-dasharray=\"2 4\"",
    }
}

fn wire_colour(signal: usize) -> &'static str {
    WIRES.get(signal % WIRES.len()).copied().unwrap_or(NO_THREAD)
}

fn signal<'d>(drawing: &'d Drawing, wire: &Wire) -> Option<&'d Signal> {
    drawing.signals.get(wire.signal)
}

fn paint_wire(out: &mut String, drawing: &Drawing, wire: &Wire) {
    let Some(s) = signal(drawing, wire) else { return };
    let colour = wire_colour(wire.signal);
    let path: String = wire.lines.iter().map(|[a, b, c, d]| format!("M{a} {b}L{c} {d}")).collect();
    out.push_str(&format!(
        "<g><title>{} ({})</title><path class=\"wire\" stroke=\"{colour}\" {} d=\"{path}\"/>",
        escape(&s.name),
        s.ty.name(),
        stroke(s.ty)
    ));
    for (x, y) in &wire.dots {
        out.push_str(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"{colour}\"/>"));
    }
    if let Some((x, y)) = wire.loose {
        out.push_str(&format!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"#ffffff\" stroke=\"{colour}\"/>"
        ));
    }
    out.push_str("</g>\n");
}

fn paint_label(out: &mut String, drawing: &Drawing, wire: &Wire) {
    let (Some(s), Some((x, y, into))) = (signal(drawing, wire), wire.label) else { return };
    let anchor = if into { " text-anchor=\"end\"" } else { "" };
    out.push_str(&format!(
        "<text class=\"label\" x=\"{x}\" y=\"{}\" style=\"fill: {}\"{anchor}>{}</text>\n",
        y - 3,
        wire_colour(wire.signal),
        escape(&s.name)
    ));
}

fn paint_box(out: &mut String, drawing: &Drawing, placed: &Placed) {
    let (s, b) = (&placed.sized, &placed.sized.boxed);
    let (x, y, w, h) = (placed.x, placed.y, s.width, s.height);
    let dashes = if b.program { " stroke-dasharray=\"4 3\"" } else { "" };
    out.push_str(&format!(
        "<g><title>{}</title><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" rx=\"5\" \
         fill=\"#f8fafc\" stroke=\"#52606d\"{dashes}/>",
        escape(&b.name)
    ));
    // The title has the colours of its threads, side by side.
    let threads: Vec<usize> = b.threads().into_iter().collect();
    let colours: Vec<&str> = if threads.is_empty() {
        vec![NO_THREAD]
    } else {
        threads.iter().map(|t| colour(*t)).collect()
    };
    let n = i64::try_from(colours.len()).unwrap_or(1);
    for (i, colour) in (0..).zip(&colours) {
        let (from, to) = (w * i / n, w * (i + 1) / n);
        out.push_str(&format!(
            "<rect x=\"{}\" y=\"{y}\" width=\"{}\" height=\"22\" fill=\"{colour}\"/>",
            x + from,
            to - from
        ));
    }
    out.push_str(&format!(
        "<text class=\"name\" x=\"{}\" y=\"{}\">{}</text>\n",
        x + 10,
        y + 16,
        escape(&b.title())
    ));
    for ((name, thread), top) in b.functs.iter().zip(&s.functs) {
        out.push_str(&format!(
            "<circle cx=\"{}\" cy=\"{}\" r=\"4\" fill=\"{}\"><title>{}</title></circle>\
             <text class=\"small\" x=\"{}\" y=\"{}\">{}</text>\n",
            x + 14,
            y + top + 8,
            colour(*thread),
            escape(drawing.threads.get(*thread).map_or("", |t| t.name.as_str())),
            x + 24,
            y + top + 12,
            escape(name)
        ));
    }
    for (section, top) in b.sections.iter().zip(&s.headings).filter(|(s, _)| !s.name.is_empty()) {
        out.push_str(&format!(
            "<line x1=\"{x}\" y1=\"{0}\" x2=\"{1}\" y2=\"{0}\" stroke=\"#cbd2d9\"/>\
             <text class=\"small\" x=\"{2}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>\n",
            y + top + 2,
            x + w,
            x + w / 2,
            y + top + 15,
            escape(&section.name)
        ));
    }
    for (pin, top, left) in s.pins() {
        let (at, offset, anchor, inside) =
            if left { (x, IN, "start", 10) } else { (x + w, OUT, "end", -10) };
        let down = y + top + offset;
        let mark = match (pin.signal.is_some(), left, pin.direction) {
            (false, ..) => String::new(),
            (true, true, _) => format!("M{} {}l8 4l-8 4z", at - 8, down - 4),
            (true, false, Direction::Io) => format!("M{at} {}l5 -4l5 4l-5 4z", down),
            (true, false, _) => format!("M{at} {}h4v6h-4z", down - 3),
        };
        out.push_str(&format!(
            "<path d=\"{mark}\" fill=\"#1f2933\"/><text x=\"{}\" y=\"{}\" \
             text-anchor=\"{anchor}\">{}<title>{} ({})</title></text>\n",
            at + inside,
            down + 4,
            escape(&pin.label),
            escape(&pin.name),
            pin.ty.name()
        ));
    }
    for ((name, value), top) in b.params.iter().zip(&s.params) {
        out.push_str(&format!(
            "<text class=\"small\" x=\"{}\" y=\"{}\">{} = {}</text>\n",
            x + 10,
            y + top + 14,
            escape(name),
            escape(value)
        ));
    }
    out.push_str("</g>\n");
}

/// Returns the width of the legend and the legend, which explains colours and lines.
fn legend(drawing: &Drawing) -> (i64, String) {
    let mut out = String::new();
    let mut x = 0;
    let mut item = |out: &mut String, mark: String, text: &str| {
        out.push_str(&format!("{mark}<text x=\"{}\" y=\"14\">{}</text>\n", x + 36, escape(text)));
        x += 36 + text_width(text, 67) + 24;
        x
    };
    let mut at = 0;
    let block = |x: i64, colour: &str| {
        format!("<rect x=\"{x}\" y=\"3\" width=\"28\" height=\"14\" fill=\"{colour}\"/>")
    };
    let used: std::collections::BTreeSet<usize> =
        drawing.boxes.iter().flat_map(Boxed::threads).collect();
    for (i, t) in drawing.threads.iter().enumerate().filter(|(i, _)| used.contains(i)) {
        let text = format!("{}, every {}", t.name, duration(t.period));
        at = item(&mut out, block(at, colour(i)), &text);
    }
    if drawing.boxes.iter().any(|b| b.functs.is_empty()) {
        at = item(&mut out, block(at, NO_THREAD), "no thread");
    }
    let types: std::collections::BTreeMap<&str, Type> =
        drawing.signals.iter().map(|s| (s.ty.name(), s.ty)).collect();
    for (name, ty) in types {
        let line = format!("<path d=\"M{at} 10h28\" stroke=\"#1f2933\" {}/>", stroke(ty));
        at = item(&mut out, line, name);
    }
    (at, out)
}

/// Escapes a text for XML.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML cannot represent control characters.
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}
