//! Draws the pictures of the README: paths with blends, and velocity, acceleration and jerk over time.
//!
//! `cargo run -p hal-trajectory --release --example pictures -- components/motion/trajectory/docs`
#![allow(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::manual_clamp,
    clippy::allow_attributes,
    reason = "an example"
)]

use hal_corpus::{Mode as CorpusMode, Motion, Program, Step, named};
use hal_trajectory::{Error, Follower, Limits, Machine, Mode, Move, Planner, Pose, Shape, Trivial};
use std::fmt::Write;

const LIMITS: Limits = Limits { velocity: 200.0, acceleration: 1750.0, jerk: 1e5 };

fn main() -> Result<(), Error> {
    let folder = std::env::args().nth(1).expect("a folder");
    let line = |x, y| Step {
        motion: Motion::Line { by: [x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] },
        mode: CorpusMode::Blend(2.0),
        feed: 150.0,
    };
    let steps = vec![line(40.0, 0.0), line(0.0, 25.0)];
    let corner = Program { name: "corner", seed: 0, start: [0.0; 9], steps };
    let pocket = named("pocket", 0.1, 150.0).expect("a program");
    let spiral = named("spiral", 0.01, 150.0).expect("a program");
    for (program, share) in [(corner, 1.0), (pocket, 0.25), (spiral, 0.1)] {
        for (kind, jerk) in [("trapezoid", f64::INFINITY), ("jerk", LIMITS.jerk)] {
            let poses = run(&program, jerk)?;
            let text = picture(&program, &poses, share, jerk);
            let path = format!("{folder}/{}-{kind}.svg", program.name);
            std::fs::write(path, text).expect("a file that can be written");
        }
    }
    Ok(())
}

/// Positions of the first three axes in each period.
fn run(program: &Program, jerk: f64) -> Result<Vec<Pose>, Error> {
    let machine = Machine::uniform(Limits { jerk, ..LIMITS });
    let mut planner = Planner::new(machine, Trivial, Pose::ZERO)?;
    let poses = program.poses();
    for (k, step) in program.steps.iter().enumerate() {
        let (Some(from), Some(to)) = (poses.get(k), poses.get(k + 1)) else { continue };
        let end = Pose(*to);
        let shape = match step.motion {
            Motion::Line { .. } => Shape::Line { end },
            Motion::Arc { center: [x, y, z], normal: [a, b, c], angle, .. } => Shape::Arc {
                end,
                center: [from[0] + x, from[1] + y, from[2] + z],
                normal: [a, b, c].map(|n| n * angle.signum()),
                turns: if angle.abs() > 15.0 { 2 } else { 0 },
            },
            // No picture has one.
            Motion::Spline(_) => continue,
        };
        let CorpusMode::Blend(p) = step.mode else { continue };
        planner.push(&Move {
            shape,
            feed: step.feed,
            rapid: false,
            mode: Mode::Blend(p),
            line: 0,
        })?;
    }
    planner.finish();
    let mut follower = Follower::new(machine.period, Pose::ZERO);
    let mut out = vec![Pose::ZERO; 4];
    while !follower.is_done(planner.track()) {
        out.push(follower.step(planner.track(), 1.0, false).pose);
    }
    Ok(out)
}

/// The programmed path, with points along its arcs.
fn programmed(program: &Program) -> Vec<[f64; 2]> {
    let mut out = Vec::new();
    for (start, step) in program.poses().iter().zip(&program.steps) {
        out.push([start[0], start[1]]);
        if let Motion::Arc { center, normal, angle, .. } = step.motion {
            for k in 1..64 {
                let turn = angle * f64::from(k) / 64.0;
                let part = Motion::Arc { center, normal, angle: turn, rise: 0.0, others: [0.0; 6] };
                let at = part.end(start);
                out.push([at[0], at[1]]);
            }
        }
    }
    out.extend(program.poses().last().map(|p| [p[0], p[1]]));
    out
}

/// The path on the left, derivatives of X and Y on the right.
fn picture(program: &Program, poses: &[Pose], share: f64, jerk: f64) -> String {
    let mut out = String::from(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 420' font-family='sans-serif' font-size='12'>\
         <rect width='900' height='420' fill='white'/>",
    );
    let corners: Vec<[f64; 2]> = poses.iter().map(|p| [p.0[0], p.0[1]]).collect();
    let bound = |k: usize, high: bool| {
        let pick = if high { f64::max } else { f64::min };
        corners.iter().map(|c| c[k]).reduce(pick).unwrap_or(0.0)
    };
    let (x0, x1, y0, y1) = (bound(0, false), bound(0, true), bound(1, false), bound(1, true));
    let scale = 340.0 / (x1 - x0).max(y1 - y0).max(1e-9);
    let place =
        |x: f64, y: f64| format!("{:.2},{:.2} ", 20.0 + (x - x0) * scale, 390.0 - (y - y0) * scale);
    if program.steps.len() < 100 {
        let sharp: String = programmed(program).iter().map(|p| place(p[0], p[1])).collect();
        let _ =
            write!(out, "<polyline points='{sharp}' fill='none' stroke='#bbb' stroke-width='1'/>");
    }
    let way: String =
        corners.iter().step_by(1 + corners.len() / 1200).map(|c| place(c[0], c[1])).collect();
    let _ = write!(out, "<polyline points='{way}' fill='none' stroke='#06c' stroke-width='1.2'/>");
    let shown = ((poses.len() as f64 * share) as usize).max(8);
    let h = 1e-3;
    let rows = [
        ("velocity", LIMITS.velocity, 1),
        ("acceleration", LIMITS.acceleration, 2),
        ("jerk", LIMITS.jerk, 3),
    ];
    for (row, (name, limit, order)) in rows.into_iter().enumerate() {
        let middle = 75.0 + 130.0 * row as f64;
        let limited = order < 3 || jerk.is_finite();
        let label = if limited {
            format!("{name}, limit {limit}")
        } else {
            format!("{name}, no limit, cut at {limit}")
        };
        let _ = write!(
            out,
            "<text x='400' y='{}'>{label}</text><path d='M400 {a}H880M400 {middle}H880M400 {b}H880' stroke='#ddd'/>",
            middle - 54.0,
            a = middle - 50.0,
            b = middle + 50.0
        );
        for (axis, color) in [(0, "#c30"), (1, "#093")] {
            let mut points = String::new();
            for (k, w) in poses.windows(4).take(shown).enumerate() {
                let [a, b, c, d] = [w[0].0[axis], w[1].0[axis], w[2].0[axis], w[3].0[axis]];
                let value = match order {
                    1 => (d - c) / h,
                    2 => (d - 2.0 * c + b) / (h * h),
                    _ => (d - 3.0 * c + 3.0 * b - a) / (h * h * h),
                };
                let y = middle - 50.0 * (value / limit).max(-1.1).min(1.1);
                let x = 400.0 + 480.0 * k as f64 / shown as f64;
                let _ = write!(points, "{x:.1},{y:.1} ");
            }
            let _ = write!(
                out,
                "<polyline points='{points}' fill='none' stroke='{color}' stroke-width='1'/>"
            );
        }
    }
    let _ = write!(
        out,
        "<text x='640' y='412'>first {:.2} s of {:.2} s; X red, Y green</text></svg>",
        shown as f64 * h,
        poses.len() as f64 * h
    );
    out
}
