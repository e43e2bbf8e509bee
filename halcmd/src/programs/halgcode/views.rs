//! The picture of a way: from above, from the front, from the side, and isometric.

use crate::programs::picture::{Area, COLOURS, INK, MARK, PALE, Painted, Picture, text};
use plotters::{
    backend::DrawingBackend,
    chart::ChartBuilder,
    element::PathElement,
    style::{
        Color, RGBColor, ShapeStyle, WHITE,
        text_anchor::{HPos, Pos, VPos},
    },
};

/// A chain of moves of one kind, in millimetres.
#[derive(Clone, Debug)]
pub(super) struct Move {
    pub(super) rapid: bool,
    pub(super) points: Vec<[f64; 3]>,
}

/// The ends of travel of X, Y and Z.
type Limits = [(f64, f64); 3];

/// The picture.
pub(super) struct Views {
    moves: Vec<Move>,
    /// The path that motion plans, if it is known.
    planned: Vec<[f64; 3]>,
    limits: Option<Limits>,
    low: [f64; 3],
    high: [f64; 3],
    title: String,
    size: (u32, u32),
}

/// A projection: its name, the names of its axes, and the factors of X, Y and Z for each.
struct View {
    name: &'static str,
    axes: Option<[&'static str; 2]>,
    across: [f64; 3],
    up: [f64; 3],
}

const COS30: f64 = 0.866_025_403_784_438_6;

const VIEWS: [View; 4] = [
    View {
        name: "from above",
        axes: Some(["X", "Y"]),
        across: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
    },
    View { name: "isometric", axes: None, across: [COS30, -COS30, 0.0], up: [0.5, 0.5, 1.0] },
    View {
        name: "from the front",
        axes: Some(["X", "Z"]),
        across: [1.0, 0.0, 0.0],
        up: [0.0, 0.0, 1.0],
    },
    View {
        name: "from the side",
        axes: Some(["Y", "Z"]),
        across: [0.0, 1.0, 0.0],
        up: [0.0, 0.0, 1.0],
    },
];

/// The view of a part that is turned: Z along the spindle, X up.
const TURNED: [View; 1] = [View {
    name: "Z and X",
    axes: Some(["Z", "X"]),
    across: [0.0, 0.0, 1.0],
    up: [1.0, 0.0, 0.0],
}];

const FEED: RGBColor = COLOURS[0];
const RAPID: RGBColor = COLOURS[1];
/// The path that motion plans: wide, under the programmed one.
const PLANNED: RGBColor = COLOURS[2];
const PLANNED_SHARE: f64 = 0.35;
const TOP: u32 = 64;
/// The distance in pixels below which points are one.
const NEAR: f64 = 1.5;
/// The limits are in sight unless they are so much larger than the moves.
const LARGER: f64 = 3.0;
/// As [`LARGER`] for a view without axes, which shows the shape of the part.
const LARGER_SHAPE: f64 = 1.3;

impl View {
    fn project(&self, p: [f64; 3]) -> (f64, f64) {
        let dot = |v: [f64; 3]| v[0] * p[0] + v[1] * p[1] + v[2] * p[2];
        (dot(self.across), dot(self.up))
    }
}

impl Views {
    /// Returns the picture of moves, and of the planned path under them; `None` without any move.
    pub(super) fn new(
        moves: Vec<Move>,
        planned: Vec<[f64; 3]>,
        limits: Option<Limits>,
        title: String,
        size: (u32, u32),
    ) -> Option<Self> {
        let first = *moves.first()?.points.first()?;
        let (mut low, mut high) = (first, first);
        for point in moves.iter().flat_map(|m| &m.points) {
            for (i, v) in point.iter().enumerate() {
                if let (Some(l), Some(h)) = (low.get_mut(i), high.get_mut(i)) {
                    *l = l.min(*v);
                    *h = h.max(*v);
                }
            }
        }
        Some(Self { moves, planned, limits, low, high, title, size })
    }

    /// Returns the corners of the box of the moves, or of the limits where they are in sight.
    fn corners(low: [f64; 3], high: [f64; 3]) -> Vec<[f64; 3]> {
        let ([x0, y0, z0], [x1, y1, z1]) = (low, high);
        let pick = |bit: u8, low, high| if bit == 0 { low } else { high };
        (0..8_u8).map(|n| [pick(n & 1, x0, x1), pick(n & 2, y0, y1), pick(n & 4, z0, z1)]).collect()
    }

    fn view<D: DrawingBackend>(&self, area: &Area<'_, D>, view: &View) -> Painted<D> {
        let (width, height) = area.dim_in_pixel();
        let (width, height) = (f64::from(width) - 86.0, f64::from(height) - 82.0);
        let project = |low, high| {
            let corners: Vec<(f64, f64)> =
                Self::corners(low, high).into_iter().map(|p| view.project(p)).collect();
            let range = |f: fn(&(f64, f64)) -> f64| {
                let values = corners.iter().map(f);
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
            };
            (range(|c| c.0), range(|c| c.1))
        };
        let (mut x, mut y) = project(self.low, self.high);
        if let Some(limits) = self.limits {
            let (lx, ly) = project(limits.map(|l| l.0), limits.map(|l| l.1));
            let size = |x: (f64, f64), y: (f64, f64)| (x.1 - x.0).max(y.1 - y.0);
            let larger = if view.axes.is_some() { LARGER } else { LARGER_SHAPE };
            if size(lx, ly) <= larger * size(x, y) {
                x = (x.0.min(lx.0), x.1.max(lx.1));
                y = (y.0.min(ly.0), y.1.max(ly.1));
            }
        }
        // Both axes have the same scale.
        let scale = ((x.1 - x.0) / width).max((y.1 - y.0) / height).max(1e-6) * 1.1;
        let centred = |(a, b): (f64, f64), pixels: f64| {
            let middle = f64::midpoint(a, b);
            (middle - scale * pixels / 2.0, middle + scale * pixels / 2.0)
        };
        let (x, y) = (centred(x, width), centred(y, height));
        let mut chart = ChartBuilder::on(area);
        chart.margin(12).margin_top(34).x_label_area_size(36).y_label_area_size(62);
        let mut chart = chart.build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        if let Some([across, up]) = view.axes {
            let number = |v: &f64| format!("{v:.*}", digits(scale));
            let mut mesh = chart.configure_mesh();
            mesh.axis_style(PALE.mix(0.5)).light_line_style(WHITE.mix(0.0));
            mesh.bold_line_style(PALE.mix(0.18)).label_style(text(12, INK));
            mesh.x_labels(8).y_labels(8).x_label_formatter(&number).y_label_formatter(&number);
            mesh.axis_desc_style(text(13, INK)).x_desc(across).y_desc(up);
            mesh.draw()?;
        }
        let line = |colour: RGBColor, share: f64, width: u32| ShapeStyle {
            color: colour.mix(share),
            filled: false,
            stroke_width: width,
        };
        for seen in self.seen_edges(view, x, y) {
            chart.draw_series([PathElement::new(seen.to_vec(), line(MARK, 0.8, 1))])?;
        }
        if !self.planned.is_empty() {
            let points = thin(self.planned.iter().map(|p| view.project(*p)), scale * NEAR);
            chart.draw_series([PathElement::new(points, line(PLANNED, PLANNED_SHARE, 4))])?;
        }
        for rapid in [true, false] {
            let style = if rapid { line(RAPID, 0.55, 1) } else { line(FEED, 1.0, 1) };
            for chain in self.moves.iter().filter(|m| m.rapid == rapid) {
                let points = thin(chain.points.iter().map(|p| view.project(*p)), scale * NEAR);
                if rapid {
                    // Dashes set rapid moves apart without colour.
                    chart.draw_series(
                        dashes(&points, scale).into_iter().map(|d| PathElement::new(d, style)),
                    )?;
                } else {
                    chart.draw_series([PathElement::new(points, style)])?;
                }
            }
        }
        let style = text(14, INK).pos(Pos::new(HPos::Left, VPos::Top));
        area.draw_text(view.name, &style, (16, 8))
    }

    /// Returns the edges of the machine's travel within the ranges of a view. Without axes pieces of a box say nothing: there
    /// it is seen as a whole or not at all.
    fn seen_edges(&self, view: &View, x: (f64, f64), y: (f64, f64)) -> Vec<[(f64, f64); 2]> {
        let edges = self.edges(view);
        let is_in = |p: &(f64, f64)| x.0 <= p.0 && p.0 <= x.1 && y.0 <= p.1 && p.1 <= y.1;
        if view.axes.is_none() {
            return if edges.iter().flatten().all(is_in) { edges } else { Vec::new() };
        }
        edges.into_iter().filter_map(|edge| clip(edge, x, y)).collect()
    }

    /// Returns the edges of the machine's travel as lines of a view.
    fn edges(&self, view: &View) -> Vec<[(f64, f64); 2]> {
        let Some(limits) = self.limits else { return Vec::new() };
        let corners = Self::corners(limits.map(|l| l.0), limits.map(|l| l.1));
        let mut out = Vec::new();
        for (i, from) in corners.iter().enumerate() {
            for bit in [1, 2, 4] {
                if i & bit == 0
                    && let Some(to) = corners.get(i | bit)
                {
                    out.push([view.project(*from), view.project(*to)]);
                }
            }
        }
        out
    }
}

impl Picture for Views {
    fn size(&self) -> (u32, u32) {
        self.size
    }

    fn paint<D: DrawingBackend>(&self, root: &Area<'_, D>) -> Painted<D> {
        root.fill(&WHITE)?;
        let left = |size, colour| text(size, colour).pos(Pos::new(HPos::Left, VPos::Top));
        root.draw_text(&self.title, &left(19, INK), (16, 12))?;
        let [x, y, z] = [0, 1, 2].map(|i: usize| {
            let (low, high) = (self.low.get(i), self.high.get(i));
            format!("{:.3} to {:.3}", low.copied().unwrap_or(0.0), high.copied().unwrap_or(0.0))
        });
        let extents = format!("X {x}   Y {y}   Z {z}   (machine, mm)");
        root.draw_text(&extents, &left(13, PALE), (16, 38))?;
        let (width, _) = self.size;
        let mut at = i32::try_from(width).unwrap_or(i32::MAX) - 430;
        let mut legend = vec![(FEED, "feed"), (RAPID, "rapid")];
        legend.extend(self.limits.map(|_| (MARK, "limits")));
        legend.extend((!self.planned.is_empty()).then_some((PLANNED, "planned")));
        for (colour, name) in legend {
            let (share, stroke_width) =
                if name == "planned" { (PLANNED_SHARE, 4) } else { (1.0, 2) };
            let style = ShapeStyle { color: colour.mix(share), filled: false, stroke_width };
            root.draw(&PathElement::new(vec![(at, 24), (at + 26, 24)], style))?;
            root.draw_text(name, &left(13, INK), (at + 32, 16))?;
            at += 100;
        }
        let (_, below) = root.split_vertically(TOP);
        // Moves in X and Z alone are a lathe's: the other views would show a line.
        let flat = self.low.get(1) == self.high.get(1) && self.low.first() != self.high.first();
        if flat && self.low.get(2) != self.high.get(2) {
            return TURNED.iter().try_for_each(|view| self.view(&below, view));
        }
        for (area, view) in below.split_evenly((2, 2)).iter().zip(&VIEWS) {
            self.view(area, view)?;
        }
        Ok(())
    }
}

/// Returns the digits behind the point of labels at this many millimetres for a pixel.
fn digits(scale: f64) -> usize {
    match scale {
        s if s > 0.05 => 0,
        s if s > 0.005 => 1,
        _ => 2,
    }
}

/// Returns the part of a line within the ranges.
fn clip(line: [(f64, f64); 2], x: (f64, f64), y: (f64, f64)) -> Option<[(f64, f64); 2]> {
    let [a, b] = line;
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (way, room) in [(-dx, a.0 - x.0), (dx, x.1 - a.0), (-dy, a.1 - y.0), (dy, y.1 - a.1)] {
        if way == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if way < 0.0 {
            from = from.max(room / way);
        } else {
            to = to.min(room / way);
        }
    }
    let at = |share: f64| (a.0 + dx * share, a.1 + dy * share);
    (from <= to).then(|| [at(from), at(to)])
}

/// Leaves out points that are nearer than `near` to the one before; the last one stays.
fn thin(points: impl Iterator<Item = (f64, f64)>, near: f64) -> Vec<(f64, f64)> {
    let mut out: Vec<(f64, f64)> = Vec::new();
    let mut last = None;
    for point in points {
        let far = out.last().is_none_or(|p| (p.0 - point.0).hypot(p.1 - point.1) >= near);
        if far {
            out.push(point);
        }
        last = (!far).then_some(point);
    }
    out.extend(last);
    out
}

/// Cuts a line into dashes of six pixels with gaps of four, at most a thousand for a line.
fn dashes(points: &[(f64, f64)], scale: f64) -> Vec<Vec<(f64, f64)>> {
    let mut out = Vec::new();
    for pair in points.windows(2) {
        let [a, b] = pair else { continue };
        let length = (a.0 - b.0).hypot(a.1 - b.1);
        let step = (10.0 * scale).max(length / 1000.0);
        let on = 0.6 * step;
        let at = |l: f64| {
            let share = if length > 0.0 { (l / length).min(1.0) } else { 0.0 };
            (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share)
        };
        let mut from = 0.0;
        while from < length {
            out.push(vec![at(from), at(from + on)]);
            from += step;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Move> {
        let corners = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 5.0, -1.0], [0.0, 5.0, -1.0]];
        vec![
            Move { rapid: true, points: vec![[0.0, 0.0, 20.0], [0.0, 0.0, 0.0]] },
            Move { rapid: false, points: corners.to_vec() },
        ]
    }

    #[test]
    fn a_picture_has_four_views_with_equal_scales() {
        let limits = Some([(-5.0, 15.0), (-5.0, 15.0), (-5.0, 25.0)]);
        let views =
            Views::new(square(), Vec::new(), limits, "A <title>".into(), (1000, 800)).unwrap();
        let svg = views.to_svg().unwrap();
        for wanted in
            ["A &lt;title&gt;", "isometric", "from the side", "X 0.000 to 10.000", "limits"]
        {
            assert!(svg.contains(wanted), "{wanted}");
        }
        let lines = svg.lines().filter(|l| l.contains("polyline") && l.contains("#0072B2"));
        let top = lines.map(|l| l.split('"').find(|p| p.contains(',')).unwrap()).nth(1).unwrap();
        let points: Vec<(f64, f64)> = top
            .split_whitespace()
            .map(|p| p.split_once(',').unwrap())
            .map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap()))
            .collect();
        let (width, height) = (points[1].0 - points[0].0, points[1].1 - points[2].1);
        assert!((width / height - 2.0).abs() < 0.02, "{points:?}");
        assert_eq!(views.to_svg().unwrap(), svg, "the same on every run");
        assert!(views.to_png().unwrap().len() > 5000);
        assert!(Views::new(Vec::new(), Vec::new(), None, String::new(), (500, 500)).is_none());
    }

    #[test]
    fn a_box_without_axes_is_drawn_as_a_whole_or_not_at_all() {
        // Numbers whose differences are rounded.
        let limits = [(-5.1, 15.3), (-5.7, 15.9), (-5.3, 25.1)];
        let views =
            Views::new(square(), Vec::new(), Some(limits), String::new(), (500, 500)).unwrap();
        let [above, shape, ..] = VIEWS;
        let large = (-100.0, 100.0);
        assert_eq!(views.seen_edges(&shape, large, large).len(), 12);
        assert!(views.seen_edges(&shape, (0.0, 100.0), large).is_empty());
        assert_eq!(
            views.seen_edges(&above, (0.0, 100.0), large).len(),
            8,
            "four at X, four beside"
        );
    }

    #[test]
    fn lines_are_cut_off_at_the_border() {
        let (x, y) = ((0.0, 10.0), (0.0, 10.0));
        assert_eq!(clip([(-5.0, 5.0), (5.0, 5.0)], x, y), Some([(0.0, 5.0), (5.0, 5.0)]));
        assert_eq!(clip([(-5.0, 11.0), (5.0, 11.0)], x, y), None);
        assert_eq!(clip([(-1.0, -1.0), (11.0, 11.0)], x, y), Some([(0.0, 0.0), (10.0, 10.0)]));
    }

    #[test]
    fn a_point_or_a_line_has_a_picture_too() {
        for points in [vec![[1.0; 3]; 2], vec![[0.0; 3], [0.0, 0.0, 7.0]]] {
            let views = Views::new(
                vec![Move { rapid: false, points }],
                Vec::new(),
                None,
                String::new(),
                (600, 500),
            );
            assert!(views.unwrap().to_svg().unwrap().contains("polyline"));
        }
    }
}
