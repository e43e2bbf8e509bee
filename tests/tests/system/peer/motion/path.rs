//! The programmed path of a program, from the canonical calls of the interpreter, and the distance from it.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_gcode::{
    Call, Interpreter,
    axis::{Axis, Position},
    canon::{PathMode, curve_point},
};
use hal_job::{
    Files, Machine, World,
    run::{self, Answers, Stop},
    way::Way,
    world,
};
use hal_watchman::{PathWatch, Shape, Tolerance};
use std::{collections::BTreeMap, f64::consts::TAU, path::Path};

/// Tolerance of G61 and G61.1 in millimetres, and of rotary axes in degrees, as `[TRAJ]` has them by default.
const EXACT: f64 = 0.002;
const ANGULAR: f64 = 0.05;
/// Lines that stand for a spline.
const PIECES: u32 = 2000;
/// Shapes ahead of the last one that was nearest, and behind it, that are examined first; and all that are examined.
const AHEAD: usize = 64;
const BEHIND: usize = 8;
const FAR: usize = 4096;

/// A programmed path.
pub(super) struct Programmed {
    shapes: Vec<(Shape, Tolerance)>,
    /// Largest tolerance in XYZ, in millimetres.
    pub(super) tolerance: f64,
    /// Last position of the path.
    pub(super) end: [f64; 9],
}

impl Programmed {
    /// Reads a program; the machine's INI file stands beside it.
    pub(super) fn read(folder: &Path, name: &str) -> Self {
        let machine =
            Machine::read(&Files { ini: Some(&folder.join("machine.ini")), ..Files::default() });
        let world = World { machine: machine.unwrap(), hal: BTreeMap::new(), functions: None };
        let settings = &world.machine;
        let mut it = Interpreter::new(settings.settings.clone(), settings.numbered.clone());
        it.load(name, world::program(&folder.join(name)).unwrap());
        let mut frame = it.state.frame;
        let mut way = Way::new(frame, it.state.position);
        let mut out = Self { shapes: Vec::new(), tolerance: 0.0, end: [0.0; 9] };
        let (mut path, mut joining) = (f64::INFINITY, 0.0_f64);
        run::run(&mut it, &world, Answers { probe_trips: false, functions: None }, |_, issued| {
            match issued.call {
                Call::SetPathMode(PathMode::Continuous { tolerance }) => path = tolerance,
                Call::SetPathMode(_) => path = EXACT,
                Call::SetNaiveCamTolerance(tolerance) => joining = tolerance,
                _ => {}
            }
            frame.apply(&issued.call);
            let from = way.at;
            way.follow(&issued.call, &mut |_, _| ());
            let linear = path.max(joining);
            let mut add = |shape| {
                out.shapes.push((shape, Tolerance { linear, angular: ANGULAR }));
                out.tolerance = out.tolerance.max(linear);
            };
            let (start, to) = (pose(from), pose(way.at));
            match &issued.call {
                Call::ArcFeed { plane, end, centre_first, centre_second, turns } => {
                    let (first, second, third) = plane.axes();
                    let mut middle = *end;
                    (middle[first], middle[second]) = (*centre_first, *centre_second);
                    let mut above = middle;
                    above[third] += 1.0;
                    let [middle, above] = [middle, above].map(|p| pose(frame.machine_mm(p)));
                    add(arc(start, to, middle, above, *turns));
                }
                Call::NurbsFeed { order, points, end } => {
                    let mut last = start;
                    for n in 1..=PIECES {
                        let at = curve_point(*order, points, f64::from(n) / f64::from(PIECES));
                        let at = at.map_or(*end, |(x, y)| Position { x, y, ..*end });
                        let next = pose(frame.machine_mm(at));
                        add(Shape::Line { from: last, to: next });
                        last = next;
                    }
                }
                _ if start != to => add(Shape::Line { from: start, to }),
                _ => {}
            }
            Ok::<(), Stop>(())
        })
        .unwrap();
        out.end = pose(way.at);
        out
    }

    /// Returns the largest distance of the poses from the path, as a part of the tolerance at the nearest place.
    pub(super) fn worst(&self, poses: impl Iterator<Item = [f64; 9]>) -> f64 {
        let watch = PathWatch::new(self.shapes.clone().into(), 1.0, 0);
        let (mut near, mut worst) = (0_usize, 0.0_f64);
        for pose in poses {
            let least = |from: usize, to: usize| {
                (from..to.min(self.shapes.len()))
                    .map(|n| (watch.ratio(&pose, n, 0), n))
                    .fold((f64::INFINITY, near), |a, b| if b.0 < a.0 { b } else { a })
            };
            let mut found = least(near.saturating_sub(BEHIND), near + AHEAD);
            if found.0 > 1.0 {
                found = least(near.saturating_sub(FAR), near + FAR);
            }
            near = found.1;
            worst = worst.max(found.0);
        }
        worst
    }
}

/// An arc from `from` to `to` around the line from `middle` to `above`; clockwise if `turns` is negative.
fn arc(from: [f64; 9], to: [f64; 9], middle: [f64; 9], above: [f64; 9], turns: i32) -> Shape {
    let normal = [0, 1, 2].map(|k| above[k] - middle[k]);
    let across = normal.iter().position(|n| *n != 0.0).unwrap();
    let mut center = [middle[0], middle[1], middle[2]];
    center[across] = from[across];
    let (a, b) = ((across + 1) % 3, (across + 2) % 3);
    let angle = |p: &[f64; 9]| (p[b] - center[b]).atan2(p[a] - center[a]);
    let direction = if turns < 0 { -1.0 } else { 1.0 };
    let mut sweep = direction * (angle(&to) - angle(&from));
    while sweep <= 1e-9 {
        sweep += TAU;
    }
    sweep += TAU * f64::from(turns.unsigned_abs().saturating_sub(1));
    Shape::Arc { from, to, center, normal, angle: direction * sweep }
}

fn pose(p: Position) -> [f64; 9] {
    Axis::ALL.map(|axis| p[axis])
}
