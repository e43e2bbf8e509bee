//! Pictures of randomly generated machines: nothing overlaps, and every wire connects its pins.

use super::{
    Boxed, Drawing, Format, Pin, Section, Signal, Thread,
    layout::Layout,
    size::{IN, OUT},
    text,
};
use hal_protocol::{Direction, Type};
use std::collections::{BTreeMap, BTreeSet};

const TYPES: [Type; 5] = [Type::Bit, Type::Float, Type::S32, Type::U64, Type::Port];

/// Random numbers that are the same in every run.
struct Chance(u64);

impl Chance {
    fn below(&mut self, n: usize) -> usize {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap() % n
    }
}

fn machine(seed: u64) -> Drawing {
    let mut chance = Chance(seed);
    let boxes = 1 + chance.below(14);
    let signals = 1 + chance.below(3 * boxes);
    let mut drawing = Drawing { title: format!("machine {seed}"), ..Drawing::default() };
    for (name, period) in [("base", 50_000), ("servo", 1_000_000)] {
        drawing.threads.push(Thread { name: name.into(), period });
    }
    for i in 0..signals {
        let ty = TYPES[chance.below(TYPES.len())];
        let name = "s".repeat(1 + chance.below(20)) + &i.to_string();
        drawing.signals.push(Signal { name, ty });
    }
    for i in 0..boxes {
        let mut boxed = Boxed { name: format!("box.{i}"), program: i % 5 == 4, ..Boxed::default() };
        for f in 0..chance.below(3) {
            boxed.functs.push((format!("box.{i}.f{f}"), chance.below(2)));
        }
        for s in 0..1 + chance.below(2) {
            let name = if s == 0 { String::new() } else { format!("box.{i}.part{s}") };
            boxed.sections.push(Section { name, ..Section::default() });
        }
        drawing.boxes.push(boxed);
    }
    for signal in 0..signals {
        let add = |drawing: &mut Drawing, direction: Direction, chance: &mut Chance| {
            let boxed = chance.below(boxes);
            let parts = drawing.boxes[boxed].sections.len();
            let section = &mut drawing.boxes[boxed].sections[chance.below(parts)];
            let label = format!("pin{}", section.left.len() + section.right.len());
            let name = format!("box.{boxed}.{}.{label}", section.name);
            let ty = drawing.signals[signal].ty;
            let side =
                if direction == Direction::In { &mut section.left } else { &mut section.right };
            side.push(Pin { label, name, direction, ty, signal: Some(signal) });
        };
        let (ins, outs) = (chance.below(4), chance.below(3));
        for i in 0..outs {
            let direction = if i == 0 { Direction::Out } else { Direction::Io };
            add(&mut drawing, direction, &mut chance);
        }
        for _ in 0..ins.max(usize::from(outs == 0)) {
            add(&mut drawing, Direction::In, &mut chance);
        }
    }
    drawing
}

/// The rectangles of boxes, and the lines of wires.
struct Picture {
    layout: Layout,
    /// Positions of the pins of each signal.
    pins: BTreeMap<usize, Vec<(i64, i64)>>,
}

fn picture(drawing: &Drawing) -> Picture {
    let layout = Layout::of(drawing);
    let mut pins: BTreeMap<usize, Vec<(i64, i64)>> = BTreeMap::new();
    for b in &layout.boxes {
        for (pin, top, left) in b.sized.pins() {
            let at =
                if left { (b.x, b.y + top + IN) } else { (b.x + b.sized.width, b.y + top + OUT) };
            pins.entry(pin.signal.unwrap()).or_default().push(at);
        }
    }
    Picture { layout, pins }
}

fn is_on([a, b, c, d]: [i64; 4], (x, y): (i64, i64)) -> bool {
    a.min(c) <= x && x <= a.max(c) && b.min(d) <= y && y <= b.max(d)
}

#[test]
fn nothing_lies_on_anything_else() {
    for seed in 0..150 {
        let drawing = machine(seed);
        let p = picture(&drawing);
        let boxes = &p.layout.boxes;
        assert_eq!(boxes.len(), drawing.boxes.len());
        for (i, a) in boxes.iter().enumerate() {
            assert!(0 <= a.x && 0 <= a.y, "{seed}");
            assert!(a.x + a.sized.width <= p.layout.width, "{seed}");
            assert!(a.y + a.sized.height <= p.layout.height, "{seed}");
            for b in &boxes[i + 1..] {
                let apart = a.x + a.sized.width < b.x
                    || b.x + b.sized.width < a.x
                    || a.y + a.sized.height < b.y
                    || b.y + b.sized.height < a.y;
                assert!(apart, "{seed}: {} and {}", a.sized.boxed.name, b.sized.boxed.name);
            }
            // No wire goes through a box.
            for [x1, y1, x2, y2] in p.layout.wires.iter().flat_map(|w| &w.lines) {
                let inside = a.x < *x2.max(x1)
                    && *x1.min(x2) < a.x + a.sized.width
                    && a.y < *y2.max(y1)
                    && *y1.min(y2) < a.y + a.sized.height;
                assert!(!inside, "{seed}: a wire in {}", a.sized.boxed.name);
            }
        }
    }
}

#[test]
fn every_pin_has_its_wire_and_wires_hold_together() {
    for seed in 0..150 {
        let p = picture(&machine(seed));
        assert_eq!(p.layout.wires.len(), p.pins.len(), "{seed}");
        for wire in &p.layout.wires {
            let pins = &p.pins[&wire.signal];
            assert!(wire.label.is_some(), "{seed}: no name");
            assert_eq!(wire.loose.is_some(), pins.len() == 1, "{seed}");
            // Starting at the first pin, connected lines reach all the others.
            let mut reached: BTreeSet<usize> = BTreeSet::new();
            let mut next: Vec<usize> =
                (0..wire.lines.len()).filter(|i| is_on(wire.lines[*i], pins[0])).collect();
            while let Some(i) = next.pop() {
                if !reached.insert(i) {
                    continue;
                }
                let [a, b, c, d] = wire.lines[i];
                let meets = |j: &usize| {
                    let [e, f, g, h] = wire.lines[*j];
                    [(a, b), (c, d)].iter().any(|p| is_on(wire.lines[*j], *p))
                        || [(e, f), (g, h)].iter().any(|p| is_on(wire.lines[i], *p))
                };
                next.extend((0..wire.lines.len()).filter(meets));
            }
            for pin in pins {
                let on = reached.iter().any(|i| is_on(wire.lines[*i], *pin));
                assert!(on, "{seed}: signal {} does not reach {pin:?}", wire.signal);
            }
            assert_eq!(reached.len(), wire.lines.len(), "{seed}: a wire in pieces");
        }
    }
}

#[test]
fn wires_do_not_lie_on_each_other() {
    let mut pairs = 0;
    for seed in 0..150 {
        let layout = picture(&machine(seed)).layout;
        let lines: Vec<(usize, [i64; 4])> =
            layout.wires.iter().flat_map(|w| w.lines.iter().map(|l| (w.signal, *l))).collect();
        for (i, (s, a)) in lines.iter().enumerate() {
            for (t, b) in lines[i + 1..].iter().filter(|(t, _)| t != s) {
                let level = a[1] == a[3] && b[1] == b[3] && a[1] == b[1];
                let upright = a[0] == a[2] && b[0] == b[2] && a[0] == b[0];
                let (k, both) = if level { (0, true) } else { (1, upright) };
                let from = a[k].min(a[k + 2]).max(b[k].min(b[k + 2]));
                let to = a[k].max(a[k + 2]).min(b[k].max(b[k + 2]));
                assert!(!both || to <= from, "{seed}: signals {s} and {t}: {a:?} {b:?}");
                pairs += 1;
            }
        }
    }
    assert!(pairs > 100_000, "{pairs}");
}

#[test]
fn the_same_machine_has_the_same_picture() {
    for seed in 0..20 {
        for format in [Format::Svg, Format::Dot, Format::Mermaid] {
            assert_eq!(text(&machine(seed), format), text(&machine(seed), format));
        }
    }
}

#[test]
fn odd_names_break_nothing() {
    let mut drawing = machine(3);
    let odd = "a\"b<c>&d\\e|f]g}h#i;j%k'l`m\u{7}n-->x\u{1f600}";
    drawing.title = odd.into();
    drawing.threads[0].name = odd.into();
    drawing.signals.iter_mut().for_each(|s| s.name = odd.into());
    for b in &mut drawing.boxes {
        b.name = odd.into();
        b.params.push((odd.into(), odd.into()));
        b.functs.push((odd.into(), 0));
        for s in &mut b.sections {
            s.name = odd.into();
            s.left.iter_mut().chain(&mut s.right).for_each(|p| p.label = odd.into());
        }
    }
    let svg = text(&drawing, Format::Svg);
    assert!(!svg.contains("b<c") && !svg.contains("&d") && !svg.contains('\u{7}'));
    assert!(svg.contains("a&quot;b&lt;c&gt;&amp;d\\e|f]g}h#i;"));
    let dot = text(&drawing, Format::Dot);
    assert!(dot.contains("label=\"a\\\"b<c>&d\\\\e|f]g}"), "{dot}");
    assert!(dot.contains("<b>a&quot;b&lt;c&gt;&amp;d"), "{dot}");
    let mermaid = text(&drawing, Format::Mermaid);
    assert!(mermaid.contains("a#34;b#60;c#62;#38;d#92;e#124;f#93;g#125;h#35;i#59;j"), "{mermaid}");
    for line in mermaid.lines().skip(3) {
        assert!(line.matches('"').count() % 2 == 0, "{line}");
    }
}

#[test]
fn a_large_machine_is_drawn_as_well() {
    let mut drawing = Drawing::default();
    for i in 0..1500 {
        drawing.signals.push(Signal { name: format!("s{i}"), ty: TYPES[i % 2] });
        let pin = |signal: usize, direction| Pin {
            label: "pin".into(),
            name: format!("b{i}.pin"),
            direction,
            ty: TYPES[signal % 2],
            signal: Some(signal),
        };
        let mut section = Section::default();
        section.right.push(pin(i, Direction::Out));
        if i > 6 {
            section.left.push(pin(i - i % 7 - 1, Direction::In));
        }
        drawing.boxes.push(Boxed {
            name: format!("b{i}"),
            sections: vec![section],
            ..Boxed::default()
        });
    }
    assert!(text(&drawing, Format::Svg).len() > 100_000);
}
