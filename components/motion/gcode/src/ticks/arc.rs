//! Arcs in XY: of the steps that go on round the circle, the one that stays nearest to it.

use core::f64::consts::TAU;

use super::{Place, Step, line};

/// Largest distance in steps, along the circle, between an arc's end and the end of its sweep.
const EARLY: f64 = 1.5;

/// Hands out the ticks of an arc from `start` to `end`, whose X and Y are relative to the centre. A full circle ends where it
/// starts. Z rises evenly.
pub fn arc(start: Place, end: Place, clockwise: bool, each: &mut dyn FnMut(Step)) {
    let sweep = sweep((start[0], start[1]), (end[0], end[1]), clockwise);
    arc_of(start, end, clockwise, sweep, each);
}

/// As [`arc`], for an arc that turns by `programmed` radians. Where the ends fall on the same step, or change their order, a
/// short arc is a line and not a circle, and a long one goes round.
pub fn arc_of(
    start: Place,
    end: Place,
    clockwise: bool,
    programmed: f64,
    each: &mut dyn FnMut(Step),
) {
    let stepped = sweep((start[0], start[1]), (end[0], end[1]), clockwise);
    let sweep = stepped + TAU * libm::round((programmed - stepped) / TAU);
    let ([x, y, from], [u, v, to]) = (start, end);
    let mut flat = Vec::new();
    let rises = from != to;
    // A helix has to know its ticks in XY before the first one.
    let mut plane = |step: [i8; 2]| {
        if rises { flat.push(step) } else { each([step[0], step[1], 0]) }
    };
    round((x, y), (u, v), clockwise, sweep, &mut plane);
    if rises {
        helix(&flat, to - from, each);
    }
}

/// Hands out the ticks of a helix: X and Y as in the plane, and Z evenly between them.
fn helix(flat: &[[i8; 2]], rise: i64, each: &mut dyn FnMut(Step)) {
    let around = i64::try_from(flat.len()).unwrap_or(i64::MAX);
    let mut plane = flat.iter();
    for [turn, _, lift] in line([around, 0, rise]) {
        let [x, y] = if turn == 0 { [0, 0] } else { plane.next().copied().unwrap_or([0, 0]) };
        each([x, y, lift]);
    }
}

/// The state of a circle: the place, the direction, and the errors of the next steps.
struct Circle {
    x: i64,
    y: i64,
    dx: i64,
    dy: i64,
    /// The error of the place: by how much the square of its radius has grown.
    error: i64,
    /// The change of the error by a step of X and of Y.
    sx: i64,
    sy: i64,
}

impl Circle {
    fn new(x: i64, y: i64, clockwise: bool) -> Self {
        let turn = if clockwise { 1 } else { -1 };
        let (dx, dy) = (turn * y.signum(), -turn * x.signum());
        Self { x, y, dx, dy, error: 0, sx: (2 * x + dx) * dx, sy: (2 * y + dy) * dy }
    }

    /// Returns the next step, which is `[0, 0]` if none comes nearer.
    fn next(&mut self) -> [i64; 2] {
        if self.x == 0 {
            self.dy = -self.y.signum();
            self.sy = (2 * self.y + self.dy) * self.dy;
        } else if self.y == 0 {
            self.dx = -self.x.signum();
            self.sx = (2 * self.x + self.dx) * self.dx;
        }
        let of_x = (self.error + self.sx).abs();
        let of_y = (self.error + self.sy).abs();
        let of_both = (self.error + self.sx + self.sy).abs();
        [
            if of_x < of_y || of_both <= of_y { self.dx } else { 0 },
            if of_y < of_x || of_both <= of_x { self.dy } else { 0 },
        ]
    }

    fn take(&mut self, [x, y]: [i64; 2]) {
        if x != 0 {
            self.x += x;
            self.error += self.sx;
            self.sx += 2;
        }
        if y != 0 {
            self.y += y;
            self.error += self.sy;
            self.sy += 2;
        }
    }
}

/// Returns the angle of an arc above 0, up to a whole turn.
fn sweep(start: (i64, i64), end: (i64, i64), clockwise: bool) -> f64 {
    match angle(start, end) * if clockwise { -1.0 } else { 1.0 } {
        a if a > 0.0 => a,
        a => a + TAU,
    }
}

/// Hands out the ticks in XY.
fn round(
    start: (i64, i64),
    end: (i64, i64),
    clockwise: bool,
    sweep: f64,
    each: &mut dyn FnMut([i8; 2]),
) {
    let turn = if clockwise { -1.0 } else { 1.0 };
    let radius = libm::hypot(start.0 as f64, start.1 as f64);
    let mut circle = Circle::new(start.0, start.1, clockwise);
    let mut done = 0.0;
    let small = |v: i64| i8::try_from(v).unwrap_or(0);
    loop {
        let here = (circle.x, circle.y);
        if here == end && (done > 0.0 || sweep <= 0.0) && done >= sweep - EARLY / radius {
            return;
        }
        let step = circle.next();
        let next = (here.0 + step[0], here.1 + step[1]);
        done += turn * angle(here, next);
        // Behind the sweep, or where no step goes on, the rest is straight.
        if step == [0, 0] || done > sweep + 1e-9 || radius == 0.0 {
            for [x, y, _] in line([end.0 - here.0, end.1 - here.1, 0]) {
                each([x, y]);
            }
            return;
        }
        circle.take(step);
        each(step.map(small));
    }
}

/// Returns the angle from one direction to another, counter-clockwise, from -π to π.
fn angle(from: (i64, i64), to: (i64, i64)) -> f64 {
    let (a, b) = ((from.0 as f64, from.1 as f64), (to.0 as f64, to.1 as f64));
    libm::atan2(a.0 * b.1 - a.1 * b.0, a.0 * b.0 + a.1 * b.1)
}
