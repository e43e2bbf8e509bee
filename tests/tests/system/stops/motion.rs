//! The kinds of motion of a machine: how each begins, and the limits by which it brakes.

use super::{
    data::{Machine, Motion},
    rig::{DT, Frame, Rig},
};
use std::fmt::Write as _;

/// Direction of straight moves along the two axes of the plane.
const DIRECTION: [f64; 2] = [0.8, 0.6];
/// Time that a motion lasts at constant speed before its stop, at least, in seconds.
const CONSTANT: f64 = 0.1;
/// Time that a motion would last without its stop, in seconds.
const LASTS: f64 = 1.5;
/// Cycles on a circle at constant speed before its stop.
const TURNS: usize = 20;
/// Share by which a constant speed may change from one cycle to the next: arms are slower where a joint limits them.
const SAME: f64 = 1e-3;
/// Share of its speed that a motion reaches at least.
const LEAST: f64 = 0.9;
/// Cycles within which a motion reaches its speed.
const BEGIN: usize = 3000;
/// Circles of the program: it goes on for longer than a lease lasts.
const CIRCLES: usize = 4;
/// File of the program.
const PART: &str = "stops-part.ngc";

/// Motion as it was at its stop, and what its braking obeys.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    /// Joint that moves by itself.
    pub(super) joint: Option<usize>,
    /// Speed in units/s: the commanded one, or the share of it that the planner gives.
    pub(super) speed: f64,
    /// Acceleration that braking has at least, in units/s².
    pub(super) acceleration: f64,
    /// Jerk limit in units/s³; 0 without one.
    pub(super) jerk: f64,
    /// True where the task runs a program.
    pub(super) by_task: bool,
}

impl Moving {
    /// Returns the distance that was moved between two cycles.
    pub(super) fn way(&self, from: &Frame, to: &Frame) -> f64 {
        self.joint.map_or_else(|| from.far(to), |n| (to.joints[n] - from.joints[n]).abs())
    }

    /// Returns the speed of each cycle behind the first, in units/s.
    pub(super) fn speeds(&self, frames: &[Frame]) -> Vec<f64> {
        frames.windows(2).map(|pair| self.way(&pair[0], &pair[1]) / DT).collect()
    }

    /// Returns the longest time from the begin of braking to rest, in cycles.
    pub(super) fn cycles(&self, speed: f64, accelerates: bool) -> usize {
        let share = if accelerates { 2.5 } else { 1.0 };
        let time = speed / self.acceleration + share * self.over_jerk();
        // Rounding makes no further cycle.
        (time / DT - 1e-6).ceil() as usize + 2
    }

    /// Returns the longest way from the begin of braking to rest.
    pub(super) fn longest(&self, speed: f64) -> f64 {
        let Self { acceleration, .. } = *self;
        speed * speed / (2.0 * acceleration) + speed * self.over_jerk() / 2.0 + 2.0 * speed * DT
    }

    fn over_jerk(&self) -> f64 {
        if self.jerk == 0.0 { 0.0 } else { self.acceleration / self.jerk }
    }
}

/// Geometry of moves along a path, from the place where the machine is.
struct Plane {
    letters: [char; 2],
    at: [f64; 2],
    /// Signs of the directions towards the middle.
    signs: [f64; 2],
    speed: f64,
    radius: f64,
    lower: f64,
    jerk: f64,
    /// Share of the commanded speed that the planner gives.
    reached: f64,
}

impl Plane {
    fn of(rig: &Rig) -> Self {
        let Machine { path, letters: all, .. } = &rig.machine;
        let letters: Vec<char> = path.axes.chars().collect();
        let place = |n: usize| rig.last().axes[all.find(letters[n]).unwrap()];
        let at = [place(0), place(1)];
        let sign = |n: usize| if at[n] < path.middle[n] { 1.0 } else { -1.0 };
        let lower = path.acceleration[0].min(path.acceleration[1]);
        Self {
            letters: [letters[0], letters[1]],
            at,
            signs: [sign(0), sign(1)],
            speed: path.velocity,
            radius: path.velocity * path.velocity / (lower * path.turn),
            lower,
            jerk: path.jerk,
            reached: path.reached,
        }
    }

    /// Returns the arguments of a place.
    fn place(&self, place: [f64; 2]) -> String {
        let [a, b] = self.letters;
        format!("{a}={} {b}={}", place[0], place[1])
    }

    /// Returns the end of the straight move.
    fn end(&self) -> [f64; 2] {
        let by = self.speed * LASTS;
        [0, 1].map(|n| self.at[n] + self.signs[n] * DIRECTION[n] * by)
    }

    /// Returns where the circle begins, behind a straight move, and its centre.
    fn circle(&self) -> ([f64; 2], [f64; 2]) {
        let run_in = self.speed * (self.speed / self.lower + CONSTANT);
        let begin = [self.at[0] + self.signs[0] * run_in, self.at[1]];
        (begin, [begin[0], begin[1] + self.signs[1] * self.radius])
    }

    /// Returns whether the circle turns clockwise, as seen from the tip of the normal of its plane.
    fn is_clockwise(&self) -> bool {
        let turns_back = self.signs[0] * self.signs[1] < 0.0;
        // From x to z it turns clockwise around y.
        turns_back != (self.letters == ['x', 'z'])
    }
}

/// Begins a motion and lets it reach its speed; with `accelerates` only half of it.
pub(super) fn begin(rig: &mut Rig, motion: Motion, accelerates: bool) -> Result<Moving, String> {
    rig.forget();
    let circle = (motion == Motion::Program).then(|| Circle::of(rig));
    let moving = match motion {
        Motion::Jog => jog(rig),
        Motion::Line => line(rig)?,
        Motion::Program => program(rig)?,
        Motion::Homing => homing(rig)?,
    };
    match rig.refused.first() {
        Some(why) => Err(why.clone()),
        None if accelerates => half(rig, moving),
        None => reach(rig, moving, circle.as_ref(), |_| {}),
    }
}

/// Target of a jog: a joint, or an axis.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    Joint(usize),
    Axis(char),
}

/// Returns a jog towards the middle: what jogs, with which velocity, and the limits.
pub(super) fn jog_of(rig: &Rig) -> (Target, f64, Moving) {
    let jog = &rig.machine.jog;
    let (target, at) = match (jog.joint, jog.axis) {
        (Some(n), _) => (Target::Joint(n), rig.last().joints[n]),
        (None, Some(letter)) => {
            let n = rig.machine.letters.find(letter).unwrap();
            (Target::Axis(letter), rig.last().axes[n])
        }
        (None, None) => panic!("{}: a jog of nothing", rig.machine.name),
    };
    let velocity = if at < jog.middle { jog.velocity } else { -jog.velocity };
    let moving = Moving {
        joint: jog.joint,
        speed: jog.velocity,
        acceleration: jog.acceleration,
        jerk: jog.jerk,
        by_task: false,
    };
    (target, velocity, moving)
}

fn jog(rig: &mut Rig) -> Moving {
    let (target, velocity, moving) = jog_of(rig);
    let target = match target {
        Target::Joint(n) => format!("joint={n}"),
        Target::Axis(letter) => format!("axis={letter}"),
    };
    rig.give(&format!("motion.jog {target} velocity={velocity}"));
    moving
}

fn on_path(plane: &Plane, acceleration: f64, by_task: bool) -> Moving {
    let speed = plane.speed * plane.reached;
    Moving { joint: None, speed, acceleration, jerk: plane.jerk, by_task }
}

/// Returns the argument with the acceleration of moves, where the machine has its own.
fn given(rig: &Rig) -> String {
    rig.machine.path.given.map_or_else(String::new, |a| format!(" acceleration={a}"))
}

fn line(rig: &mut Rig) -> Result<Moving, String> {
    rig.finish("motion.mode mode=coord", 100)?;
    let plane = Plane::of(rig);
    let speed = plane.speed;
    let given = given(rig);
    let there = plane.place(plane.end());
    rig.give(&format!("motion.move {there} velocity={speed}{given}"));
    // A move that waits, which a stop must forget or keep.
    let back = plane.place(plane.at);
    rig.give(&format!("motion.move {back} velocity={speed}"));
    let limits = rig.machine.path.acceleration;
    let along = (limits[0] / DIRECTION[0]).min(limits[1] / DIRECTION[1]);
    let along = rig.machine.path.given.map_or(along, |given| along.min(given));
    Ok(on_path(&plane, along, false))
}

/// Begins a program whose stop will be on a circle: there the turn leaves less acceleration for braking.
fn program(rig: &mut Rig) -> Result<Moving, String> {
    let by_task = rig.has_task();
    if !by_task {
        rig.finish("motion.mode mode=coord", 100)?;
    }
    let plane = Plane::of(rig);
    if by_task {
        write(rig, &plane);
        rig.finish("task.mode mode=auto", 500)?;
        rig.finish(&format!("task.open file={PART}"), 1000)?;
        rig.give("task.run");
    } else {
        let (begin, centre) = plane.circle();
        let (speed, there, given) = (plane.speed, plane.place(begin), given(rig));
        rig.give(&format!("motion.move {there} velocity={speed} mode=blend tolerance=0{given}"));
        let [a, b] = plane.letters;
        let turn = plane.is_clockwise();
        let normal = if b == 'z' { "normal-y=1" } else { "normal-z=1" };
        let around = format!("center-{a}={} center-{b}={} {normal}", centre[0], centre[1]);
        let turns = format!("clockwise={turn} turns=1 velocity={speed}{given}");
        rig.give(&format!("motion.arc {there} {around} {turns}"));
        rig.give(&format!("motion.move {} velocity={speed}", plane.place(plane.at)));
    }
    Ok(on_circle(&plane, by_task))
}

/// Returns the motion on the circle, whose turn leaves less acceleration for braking.
fn on_circle(plane: &Plane, by_task: bool) -> Moving {
    let turns = plane.speed * plane.speed / plane.radius;
    let left = (plane.lower * plane.lower - turns * turns).sqrt();
    on_path(plane, left, by_task)
}

fn write(rig: &Rig, plane: &Plane) {
    for folder in [".", "programs"] {
        if rig.scratch.path().join(folder).is_dir() {
            rig.scratch.write(&format!("{folder}/{PART}"), text(plane, rig.machine.unit()));
        }
    }
}

/// Writes the program for somebody who starts it: in the machine's folder, and in that of the panel.
pub(super) fn part(rig: &Rig) -> (&'static str, Moving, Circle) {
    let plane = Plane::of(rig);
    write(rig, &plane);
    (PART, on_circle(&plane, true), Circle::of(rig))
}

/// Returns the same moves as a program.
fn text(plane: &Plane, unit: &str) -> String {
    let letters = plane.letters.map(|l| l.to_ascii_uppercase());
    let (begin, centre) = plane.circle();
    let word =
        |place: [f64; 2]| format!("{}{:.6} {}{:.6}", letters[0], place[0], letters[1], place[1]);
    let by: [f64; 2] = [0, 1].map(|n| centre[n] - begin[n]);
    let (plane_code, words) = if letters[1] == 'Z' { ("G18 ", "IK") } else { ("", "IJ") };
    let mut around = String::new();
    for (letter, by) in words.chars().zip(by) {
        write!(around, " {letter}{by:.6}").unwrap();
    }
    let turn = if plane.is_clockwise() { "G02" } else { "G03" };
    let units = if unit == "in" { "G20" } else { "G21" };
    let circle = format!("{turn} {}{around}\n", word(begin));
    let mut text =
        format!("{plane_code}{units} G90\nG01 {} F{:.4}\n", word(begin), plane.speed * 60.0);
    text.push_str(&circle.repeat(CIRCLES));
    writeln!(text, "G01 {}\nM02", word(plane.at)).unwrap();
    text
}

/// Begins to look for a home switch that never closes.
fn homing(rig: &mut Rig) -> Result<Moving, String> {
    let limits = rig.machine.homing();
    let joint = rig.machine.joint();
    let at = rig.last().joints[joint];
    let velocity = if at < limits.middle { limits.velocity } else { -limits.velocity };
    let latch = velocity / 10.0;
    let search = format!("home-search-vel={velocity} home-latch-vel={latch}");
    rig.finish(&format!("motion.configure joint={joint} {search}"), 20)?;
    if rig.has_task() {
        rig.finish("task.mode mode=manual", 500)?;
    }
    rig.give(&format!("motion.home joint={joint}"));
    Ok(Moving {
        joint: Some(joint),
        speed: limits.velocity,
        acceleration: limits.acceleration,
        jerk: limits.jerk,
        by_task: false,
    })
}

/// Circle of a program.
pub(super) struct Circle {
    /// Places of its axes among the letters.
    axes: [usize; 2],
    centre: [f64; 2],
    radius: f64,
}

impl Circle {
    fn of(rig: &Rig) -> Self {
        let plane = Plane::of(rig);
        let (_, centre) = plane.circle();
        let axes = plane.letters.map(|l| rig.machine.letters.find(l).unwrap());
        Self { axes, centre, radius: plane.radius }
    }

    /// Returns whether a place is on it.
    fn has(&self, frame: &Frame) -> bool {
        let [a, b] = [0, 1].map(|n| frame.axes[self.axes[n]] - self.centre[n]);
        (a.hypot(b) - self.radius).abs() < self.radius * 1e-3
    }
}

/// Waits until the speed has been the same for a while; in a program, on its circle. Who keeps the motion up does so every few
/// cycles.
pub(super) fn reach(
    rig: &mut Rig,
    moving: Moving,
    circle: Option<&Circle>,
    mut keep: impl FnMut(&mut Rig),
) -> Result<Moving, String> {
    let constant = (CONSTANT / DT) as usize;
    for _ in 0..BEGIN / 10 {
        rig.run(10);
        keep(rig);
        let speeds = moving.speeds(&rig.seen);
        let speed = speeds.last().copied().unwrap_or(0.0);
        let is_same = |speeds: &[f64]| {
            LEAST * moving.speed < speeds[0] && (speeds[1] - speeds[0]).abs() < SAME * speeds[1]
        };
        let same = speeds.windows(2).rev().take_while(|pair| is_same(pair)).count();
        let turns = |circle: &Circle| rig.seen.iter().rev().take(TURNS).all(|f| circle.has(f));
        let needed = if circle.is_some() { TURNS } else { constant };
        if needed <= same && circle.is_none_or(turns) {
            return Ok(Moving { speed, ..moving });
        }
    }
    let most = moving.speeds(&rig.seen).into_iter().fold(0.0, f64::max);
    let said = rig.said();
    let last = said.lines().last().unwrap_or_default();
    Err(format!("it does not reach {}, but {most}: {:?} {last}", moving.speed, rig.refused))
}

/// Waits until half of the speed is reached.
fn half(rig: &mut Rig, moving: Moving) -> Result<Moving, String> {
    for _ in 0..BEGIN {
        rig.run(1);
        let speed = moving.speeds(&rig.seen).pop().unwrap_or(0.0);
        if moving.speed * 0.5 <= speed {
            return Ok(Moving { speed, ..moving });
        }
    }
    Err(format!("it does not begin: {:?}", rig.refused))
}
