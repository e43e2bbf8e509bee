//! Geometry of a program: the points of its path, as `API.md` lays them out.

mod cutter;
mod planned;

pub(crate) use cutter::{Cut, is_cutter};

use crate::pool::Limit;
use hal_gcode::{Call, Interpreter, Text, axis::Position, canon::Unit};
use hal_job::{
    Files, Machine, World,
    run::{Answers, start, step},
    way::{Kind, Way},
};
use planned::PlannedPath;
use std::path::Path;

/// Number of points of a program; its later ones are left out.
const MAX_POINTS: usize = 8_000_000;
/// Steps of the program and points between two looks whether its reading may go on.
const LOOK: usize = 16;
/// Most bytes of a point in an answer.
const POINT_BYTES: usize = 23 + 24 + 24;
/// Number of points that may be left out in a row.
const MAX_LEFT_OUT: usize = 64;

/// A point and the segment that ends there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    at: [f64; 3],
    line: u32,
    feed: f32,
    tool: u16,
    kind: u8,
    /// Place of the tool's offset among those of the geometry.
    offset: u32,
    /// Place of A B C U V W among those of the geometry.
    further: u32,
}

/// The points of a program.
#[derive(Debug, Default)]
pub(crate) struct Geometry {
    points: Vec<Point>,
    /// Points since the last that is kept, all within the tolerance of the line from there.
    pending: Vec<Point>,
    tolerance: f64,
    reduced: bool,
    whole: bool,
    /// Offsets of the tool at the points, one after the other; no two neighbours are equal.
    offsets: Vec<[f64; 3]>,
    /// A B C U V W at the points, one after the other; no two neighbours are equal.
    further: Vec<[f64; 6]>,
    /// A bit for each of A B C U V W that moves.
    others: u32,
    /// Joints of an arm at each point, where they are chosen.
    joints: Vec<[f64; 6]>,
    /// Reason why the program was not read to its end, and its line.
    pub(crate) error: Option<(u32, String)>,
}

/// Wishes for the geometry of a program.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Wishes {
    /// Points within this distance of the line between their neighbours are left out.
    pub(crate) tolerance: f64,
    /// True for the path that motion plans, false for the programmed one.
    pub(crate) is_planned: bool,
}

/// Reads the text of a program as the task would, as long as each `look` at the memory that it takes lets it go on. A planned path
/// of a machine whose limits are not known has no points.
///
/// # Errors
/// A file of the machine cannot be read.
pub(crate) fn read(
    ini: Option<&Path>,
    file: &Path,
    text: Text,
    wishes: Wishes,
    look: &mut dyn FnMut(usize) -> Result<(), Limit>,
) -> Result<Geometry, String> {
    let machine = Machine::read(&Files { ini, ..Files::default() })?;
    let scale = Unit::Millimetre.to(machine.settings.unit);
    let machine_unit = machine.settings.unit;
    let mut it = Interpreter::new(machine.settings.clone(), machine.numbered.clone());
    // Functions in Python have effects, and a look at a path has none.
    let world = World { machine, hal: std::collections::BTreeMap::new(), functions: None };
    start(&mut it, &world)?;
    it.load(&file.display().to_string(), text);
    let mut way = Way::new(it.state.frame, it.state.position);
    let place = |p: Position| [p.x, p.y, p.z].map(|v| v * scale);
    let tolerance = wishes.tolerance;
    let mut geometry = Geometry { tolerance, ..Geometry::default() };
    let begin = others(way.at);
    let (mut unit, mut feed) = (it.state.frame.unit, it.state.modal.feed);
    let mut tool = u16::try_from(it.state.tool.number).unwrap_or(0);
    // Angles have no unit of length; U V W are lengths as X Y Z are.
    let units = [1.0, 1.0, 1.0, scale, scale, scale];
    let turned = |p: Position| {
        let mut all = others(p);
        all.iter_mut().zip(units).for_each(|(v, unit)| *v *= unit);
        all
    };
    let offset = geometry.offset(place(way.tool()));
    let further = geometry.further(turned(way.at));
    let first = Point { at: place(way.at), line: 0, feed: 0.0, tool, kind: 0, offset, further };
    let mut plan = None;
    if wishes.is_planned {
        plan = PlannedPath::new(&it, &world.machine, first);
        if plan.is_none() {
            geometry.error = Some((0, planned::UNKNOWN.to_owned()));
            return Ok(geometry);
        }
    } else {
        geometry.keep(first);
    }
    let mut out = Vec::new();
    let mut next_look = 0;
    for n in 0_usize.. {
        let answers = Answers { probe_trips: true, functions: None };
        let going = step(&mut it, &world, answers, &mut out);
        for issued in out.drain(..) {
            match &issued.call {
                Call::UseLengthUnits(new) => unit = *new,
                Call::SetFeedRate(rate) => feed = *rate,
                Call::ChangeTool(number) | Call::ChangeToolNumber(number) => {
                    tool = u16::try_from(*number).unwrap_or(0);
                }
                _ => {}
            }
            let offset = place(way.tool());
            #[expect(clippy::cast_possible_truncation, reason = "a colour")]
            let feed = (feed * unit.to(machine_unit)) as f32;
            let offset = geometry.offset(offset);
            let (line, further) = (issued.line, 0);
            let attributes = Point { at: [0.0; 3], line, feed, tool, kind: 0, offset, further };
            let mut each = |at: Position, point: Point| {
                for (bit, (from, to)) in begin.into_iter().zip(others(at)).enumerate() {
                    geometry.others |= u32::from((from - to).abs() > 1e-9) << bit;
                }
                let further = geometry.further(turned(at));
                geometry.add(Point { at: place(at), further, ..point });
            };
            let has_plan = plan.is_some();
            way.follow(&issued.call, &mut |kind, at| {
                if !has_plan {
                    each(at, attributes.of(&issued.call, kind == Kind::Rapid));
                }
            });
            if let Some(plan) = &mut plan {
                let is_rapid = matches!(issued.call, Call::StraightTraverse(_));
                plan.call(&issued, attributes.of(&issued.call, is_rapid), &mut each);
            }
        }
        match going {
            Ok(true) => {}
            Ok(false) => {
                geometry.whole = true;
                break;
            }
            Err(error) => {
                geometry.error = Some((error.place.line, error.problem.to_string()));
                break;
            }
        }
        let stopped = if geometry.points.len() >= MAX_POINTS {
            Some(format!("it has more than {MAX_POINTS} points"))
        } else if n + geometry.points.len() >= next_look {
            next_look = n + geometry.points.len() + LOOK;
            look(geometry.memory() + plan.as_ref().map_or(0, PlannedPath::memory))
                .err()
                .map(|limit| limit.to_string())
        } else {
            None
        };
        if let Some(why) = stopped {
            geometry.error = Some((it.state.line, why));
            break;
        }
    }
    if let Some(plan) = &mut plan {
        plan.finish(&mut |at, point| {
            let further = geometry.further(turned(at));
            geometry.add(Point { at: place(at), further, ..point });
        });
    }
    geometry.flush();
    Ok(geometry)
}

impl Point {
    /// Returns the attributes of a point with the kind and feed that a call gives it.
    const fn of(self, call: &Call, is_rapid: bool) -> Self {
        let kind = match call {
            _ if is_rapid => return Self { kind: 1, feed: 0.0, ..self },
            Call::ArcFeed { .. } => 3,
            Call::StraightProbe { .. } => 4,
            _ => 2,
        };
        Self { kind, ..self }
    }
}

impl Geometry {
    /// Returns the place of the offset of a point that follows all others.
    fn offset(&mut self, offset: [f64; 3]) -> u32 {
        place_of(&mut self.offsets, offset)
    }

    /// Returns the place of the further axes of a point that follows all others.
    fn further(&mut self, further: [f64; 6]) -> u32 {
        place_of(&mut self.further, further)
    }

    fn keep(&mut self, point: Point) {
        self.points.push(point);
    }

    /// Adds a point; leaves out those that the line between their neighbours passes.
    fn add(&mut self, point: Point) {
        let same = |other: &Point| {
            (other.kind, other.tool, other.offset, other.further)
                == (point.kind, point.tool, point.offset, point.further)
                && other.feed == point.feed
        };
        let passes = |from: [f64; 3]| {
            self.pending.len() < MAX_LEFT_OUT
                && self
                    .pending
                    .iter()
                    .all(|p| same(p) && distance(p.at, from, point.at) <= self.tolerance)
        };
        if self.tolerance > 0.0 && self.points.last().is_some_and(|last| passes(last.at)) {
            self.pending.push(point);
            return;
        }
        self.flush();
        if self.tolerance > 0.0 {
            self.pending.push(point);
        } else {
            self.keep(point);
        }
    }

    /// Keeps the last of the points that wait.
    fn flush(&mut self) {
        if let Some(last) = self.pending.pop() {
            self.reduced |= !self.pending.is_empty();
            self.pending.clear();
            self.keep(last);
        }
    }

    /// Returns the memory that it takes, with its bytes, once they are made.
    pub(crate) fn memory(&self) -> usize {
        let of_point = size_of::<Point>() + POINT_BYTES;
        let of_change = size_of::<[f64; 6]>();
        let changes = self.offsets.capacity() + self.further.capacity() + self.joints.capacity();
        self.points.capacity() * of_point + changes * of_change
    }

    /// Returns the geometry as bytes.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let first = self.points.first().map_or([0.0; 3], |p| p.at);
        let (mut low, mut high) = (first, first);
        for point in &self.points {
            for ((low, high), v) in low.iter_mut().zip(&mut high).zip(point.at) {
                *low = low.min(v);
                *high = high.max(v);
            }
        }
        let middle = |(a, b): (f64, f64)| f64::midpoint(a, b);
        let mut origin = [0.0; 3];
        for (origin, ends) in origin.iter_mut().zip(low.into_iter().zip(high)) {
            *origin = middle(ends);
        }
        #[expect(clippy::cast_possible_truncation, reason = "pictures need no more")]
        let near = |at: [f64; 3]| {
            let [x, y, z] = at;
            let [a, b, c] = origin;
            [(x - a) as f32, (y - b) as f32, (z - c) as f32]
        };
        let count = u32::try_from(self.points.len()).unwrap_or(u32::MAX);
        let (moves, has_joints) = (self.others != 0, self.joints.len() == self.points.len());
        let of_point = 23 + 24 * (usize::from(moves) + usize::from(has_joints));
        let changes = self.changes();
        let room = 64 + of_point * self.points.len() + 3 + 16 * changes.len();
        let mut out = Vec::with_capacity(room);
        out.extend_from_slice(b"FERPATH1");
        out.extend_from_slice(&count.to_le_bytes());
        let flags = u32::from(self.whole)
            | u32::from(self.reduced) << 1
            | self.others << 2
            | u32::from(moves) << 8
            | u32::from(has_joints) << 9;
        out.extend_from_slice(&flags.to_le_bytes());
        out.extend(origin.into_iter().flat_map(f64::to_le_bytes));
        out.extend(near(low).into_iter().chain(near(high)).flat_map(f32::to_le_bytes));
        out.extend(self.points.iter().flat_map(|p| near(p.at)).flat_map(f32::to_le_bytes));
        out.extend(self.points.iter().flat_map(|p| p.line.to_le_bytes()));
        out.extend(self.points.iter().flat_map(|p| p.feed.to_le_bytes()));
        out.extend(self.points.iter().flat_map(|p| p.tool.to_le_bytes()));
        out.extend(self.points.iter().map(|p| p.kind));
        if moves || has_joints || !changes.is_empty() {
            out.resize(out.len().next_multiple_of(4), 0);
        }
        #[expect(clippy::cast_possible_truncation, reason = "pictures need no more")]
        let mut write = |numbers: &[f64; 6]| {
            out.extend(numbers.iter().flat_map(|v| (*v as f32).to_le_bytes()));
        };
        if moves {
            for point in &self.points {
                write(self.further.get(point.further as usize).unwrap_or(&[0.0; 6]));
            }
        }
        if has_joints {
            self.joints.iter().for_each(&mut write);
        }
        for (first, offset) in changes {
            out.extend_from_slice(&first.to_le_bytes());
            #[expect(clippy::cast_possible_truncation, reason = "pictures need no more")]
            out.extend(offset.into_iter().flat_map(|v| (v as f32).to_le_bytes()));
        }
        out
    }

    /// Returns the points from which on another offset of the tool is in force; before the first there is none.
    fn changes(&self) -> Vec<(u32, [f64; 3])> {
        let mut last = [0.0; 3];
        let mut out = Vec::new();
        for (first, point) in (0_u32..).zip(&self.points) {
            let Some(offset) = self.offsets.get(point.offset as usize) else { continue };
            if *offset != last {
                last = *offset;
                out.push((first, last));
            }
        }
        out
    }
}

/// Returns the place of a value in a list whose last may be equal to it.
fn place_of<T: PartialEq>(list: &mut Vec<T>, value: T) -> u32 {
    if list.last() != Some(&value) {
        list.push(value);
    }
    u32::try_from(list.len() - 1).unwrap_or(u32::MAX)
}

/// Returns the places of the axes beside X, Y and Z.
const fn others(p: Position) -> [f64; 6] {
    [p.a, p.b, p.c, p.u, p.v, p.w]
}

/// Returns the distance of a point from the line between two others.
fn distance(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let difference = |u: [f64; 3], v: [f64; 3]| [u[0] - v[0], u[1] - v[1], u[2] - v[2]];
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let (ab, ap) = (difference(b, a), difference(p, a));
    let length = dot(ab, ab);
    let share = if length > 0.0 { dot(ap, ab) / length } else { 0.0 };
    let share = if share > 1.0 { 1.0 } else { share.max(0.0) };
    let off = difference(ap, ab.map(|v| v * share));
    dot(off, off).sqrt()
}

#[cfg(test)]
mod tests;
