//! The picture of a simulation: a corner for each tick, a colour for each command, in perspective or along an axis.

use crate::programs::picture::{Area, COLOURS, INK, PALE, Painted, Picture, text};
use hal_gcode::ticks::{Move, MoveKind, Step};
use plotters::{
    backend::DrawingBackend,
    element::PathElement,
    style::{
        Color, ShapeStyle, WHITE,
        text_anchor::{HPos, Pos, VPos},
    },
};

/// The direction from which a simulation is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    name: &'static str,
    /// Directions to the right, up and towards the eye.
    right: [f64; 3],
    up: [f64; 3],
    eye: [f64; 3],
    is_perspective: bool,
}

/// The distance of the eye from the middle, in diagonals of the box around the part.
const DISTANCE: f64 = 2.5;
/// Room at the top for the title, and at the sides, in pixels.
const TOP: f64 = 64.0;
const MARGIN: f64 = 40.0;

impl View {
    /// Returns the view of a name, and of the angles of a perspective.
    ///
    /// # Errors
    /// There is no view of this name, or the angles are none.
    pub(super) fn of(name: Option<&str>, turn: Option<&str>) -> Result<Self, String> {
        const X: [f64; 3] = [1.0, 0.0, 0.0];
        const Y: [f64; 3] = [0.0, 1.0, 0.0];
        const Z: [f64; 3] = [0.0, 0.0, 1.0];
        let back = |[x, y, z]: [f64; 3]| [-x, -y, -z];
        let along = |name, right, up, eye| Ok(Self { name, right, up, eye, is_perspective: false });
        match name.unwrap_or("perspective") {
            "perspective" => Self::perspective(turn.unwrap_or("30,35")),
            other if turn.is_some() => {
                Err(format!("--turn is for the perspective, not for {other}"))
            }
            "front" => along("front", X, Z, back(Y)),
            "side" => along("side", Y, Z, X),
            "top" => along("top", X, Y, Z),
            other => Err(format!("'{other}' is no view: perspective, front, side or top")),
        }
    }

    fn perspective(turn: &str) -> Result<Self, String> {
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|n| n.is_finite());
        let angles = turn.split_once(',').and_then(|(a, b)| number(a).zip(number(b)));
        let (right, up) =
            angles.filter(|(right, up)| right.abs() <= 360.0 && up.abs() <= 90.0).ok_or_else(
                || format!("'{turn}' is no turn: RIGHT,UP in degrees, UP from -90 to 90"),
            )?;
        let ((sa, ca), (se, ce)) = (right.to_radians().sin_cos(), up.to_radians().sin_cos());
        Ok(Self {
            name: "perspective",
            right: [ca, sa, 0.0],
            up: [-sa * se, ca * se, ce],
            eye: [sa * ce, -ca * ce, se],
            is_perspective: true,
        })
    }
}

/// The ticks of one command.
struct Chain {
    kind: MoveKind,
    points: Vec<[f64; 3]>,
}

/// The picture.
pub(super) struct Drawing {
    chains: Vec<Chain>,
    low: [f64; 3],
    high: [f64; 3],
    view: View,
    scale: f64,
    title: String,
    size: (u32, u32),
}

impl Drawing {
    /// Returns the picture of the ticks of moves; `None` without any.
    pub(super) fn new(
        ticks: &[Step],
        moves: &[Move],
        scale: f64,
        view: View,
        title: String,
        size: (u32, u32),
    ) -> Option<Self> {
        let mut ticks = ticks.iter();
        let mut at = [0_i64; 3];
        let inches = |at: [i64; 3]| at.map(|v| v as f64 / scale);
        let mut chains = Vec::new();
        let (mut low, mut high) = ([0.0_f64; 3], [0.0_f64; 3]);
        for by in moves {
            let mut points = vec![inches(at)];
            for step in ticks.by_ref().take(usize::try_from(by.ticks).unwrap_or(usize::MAX)) {
                for (at, step) in at.iter_mut().zip(step) {
                    *at += i64::from(*step);
                }
                points.push(inches(at));
            }
            for point in &points {
                for ((low, high), v) in low.iter_mut().zip(&mut high).zip(point) {
                    *low = low.min(*v);
                    *high = high.max(*v);
                }
            }
            if points.len() > 1 {
                chains.push(Chain { kind: by.kind, points });
            }
        }
        (!chains.is_empty()).then_some(Self { chains, low, high, view, scale, title, size })
    }

    /// Returns a place on the picture, without its unit.
    fn project(&self, point: [f64; 3]) -> (f64, f64) {
        let mut middle = [0.0; 3];
        let mut diagonal = 0.0_f64;
        for (m, (low, high)) in middle.iter_mut().zip(self.low.iter().zip(&self.high)) {
            *m = f64::midpoint(*low, *high);
            diagonal = diagonal.hypot(high - low);
        }
        let dot = |v: [f64; 3]| {
            let parts = v.iter().zip(point.iter().zip(middle));
            parts.map(|(v, (p, m))| v * (p - m)).sum::<f64>()
        };
        let far = DISTANCE * diagonal.max(1e-9);
        let near = if self.view.is_perspective { far / (far - dot(self.view.eye)) } else { 1.0 };
        (near * dot(self.view.right), near * dot(self.view.up))
    }

    /// Returns the axes from the machine's zero: their names and ends.
    fn axes(&self) -> [(&'static str, [f64; 3]); 3] {
        let size = self.low.iter().zip(&self.high).fold(0.0_f64, |s, (l, h)| s.max(h - l));
        let length = size / 8.0;
        [("X", [length, 0.0, 0.0]), ("Y", [0.0, length, 0.0]), ("Z", [0.0, 0.0, length])]
    }
}

impl Picture for Drawing {
    fn size(&self) -> (u32, u32) {
        self.size
    }

    fn paint<D: DrawingBackend>(&self, root: &Area<'_, D>) -> Painted<D> {
        root.fill(&WHITE)?;
        let left = |size, colour| text(size, colour).pos(Pos::new(HPos::Left, VPos::Top));
        root.draw_text(&self.title, &left(19, INK), (16, 12))?;
        let range = |(low, high): (&f64, &f64)| format!("{low:.3} to {high:.3}");
        let ranges: Vec<String> = self.low.iter().zip(&self.high).map(range).collect();
        let ticks: usize = self.chains.iter().map(|c| c.points.len() - 1).sum();
        let said = format!(
            "{}   X Y Z {} in   {} commands, {ticks} ticks of 1/{} in",
            self.view.name,
            ranges.join(", "),
            self.chains.len(),
            self.scale
        );
        root.draw_text(&said, &left(13, PALE), (16, 38))?;
        // Both directions have the same scale.
        let axes = self.axes();
        let ends = axes.iter().map(|(_, end)| self.project(*end));
        let all = self.chains.iter().flat_map(|c| &c.points).map(|p| self.project(*p));
        let (mut low, mut high) = (self.project([0.0; 3]), self.project([0.0; 3]));
        for (x, y) in all.chain(ends) {
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x), high.1.max(y));
        }
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let room = (width - 2.0 * MARGIN, height - TOP - 2.0 * MARGIN);
        let fits = |room: f64, low: f64, high: f64| room.max(10.0) / (high - low).max(1e-9);
        let scale = fits(room.0, low.0, high.0).min(fits(room.1, low.1, high.1));
        let centre = (f64::midpoint(low.0, high.0), f64::midpoint(low.1, high.1));
        let pixel = |point: [f64; 3]| {
            let (x, y) = self.project(point);
            let across = width / 2.0 + (x - centre.0) * scale;
            let down = TOP + (height - TOP) / 2.0 - (y - centre.1) * scale;
            #[expect(clippy::cast_possible_truncation, reason = "within the picture")]
            (across.round() as i32, down.round() as i32)
        };
        for (name, end) in axes {
            let style = ShapeStyle { color: PALE.to_rgba(), filled: false, stroke_width: 1 };
            let (from, to) = (pixel([0.0; 3]), pixel(end));
            if from != to {
                root.draw(&PathElement::new(vec![from, to], style))?;
                root.draw_text(name, &left(13, PALE), (to.0 + 4, to.1 - 8))?;
            }
        }
        for (number, chain) in self.chains.iter().enumerate() {
            let colour = COLOURS.get(number % COLOURS.len()).copied().unwrap_or(INK);
            let share = if chain.kind == MoveKind::Rapid { 0.4 } else { 1.0 };
            let style = ShapeStyle { color: colour.mix(share), filled: false, stroke_width: 2 };
            let points: Vec<(i32, i32)> = chain.points.iter().map(|p| pixel(*p)).collect();
            root.draw(&PathElement::new(points, style))?;
        }
        Ok(())
    }
}
