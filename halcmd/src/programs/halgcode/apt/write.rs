//! Files for controllers, and the drawing.

use super::{super::views::Move, cell::ArmCell};
use hal_arm::{Joints, Kind, Plan, Target, rotation::to_zyz};

/// Returns the points, one to a line: X Y Z of the tip relative to the base, and its angles about Z, the new Y and the
/// new Z.
pub(super) fn points(plan: &Plan) -> String {
    let mut out = String::new();
    for step in plan.steps.iter().filter(|s| s.is_target) {
        let p = step.tip.origin;
        let [a, b, c] = to_zyz(&step.tip.turn);
        out.push_str(&format!("{} {} {} ", exact::<3>(p.x), exact::<3>(p.y), exact::<3>(p.z)));
        out.push_str(&format!("{} {} {}\n", exact::<4>(a), exact::<4>(b), exact::<4>(c)));
    }
    out
}

/// Returns the joints, one point to a line.
pub(super) fn joints(plan: &Plan) -> String {
    let mut out = String::new();
    for step in plan.steps.iter().filter(|s| s.is_target) {
        let words: Vec<String> = step.joints.iter().map(|j| exact::<4>(*j)).collect();
        out.push_str(&format!("{}\n", words.join(" ")));
    }
    out
}

/// Returns a number with so many decimals; 0 has no sign.
fn exact<const N: usize>(x: f64) -> String {
    let text = format!("{x:.N$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if is_zero { text.trim_start_matches('-').to_owned() } else { text }
}

/// Largest change of a joint between two moves of a script, in degrees: straight lines of the joints are then within
/// hundredths of a millimetre of those of the tip.
const APART: f64 = 1.0;

/// Returns a script of moves in which X Y Z A B C are the joints.
pub(super) fn script(file: &str, plan: &Plan, targets: &[Target]) -> String {
    let mut out = format!("# Joints along {file}: X Y Z A B C are joints 0 to 5.\n");
    let mut last: Option<(Joints, Kind)> = None;
    let mut seconds = 0.0;
    for (n, step) in plan.steps.iter().enumerate() {
        let line = targets.get(step.target).map_or(0, |t| t.line);
        seconds += step.seconds;
        let next = plan.steps.get(n + 1);
        let far = |to: &Joints, from: &Joints| {
            to.iter().zip(from).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        // A step is left out if neither it nor the next is far from the last that was written.
        let is_needed = last.is_none_or(|(joints, kind)| {
            step.is_target
                || kind != step.kind
                || next.is_none_or(|s| far(&s.joints, &joints) > APART)
        });
        if !is_needed {
            continue;
        }
        let moved = last.is_none_or(|(joints, _)| far(&step.joints, &joints) > 1e-9);
        if moved {
            let pairs = ["x", "y", "z", "a", "b", "c"].iter().zip(step.joints);
            let words: Vec<String> = pairs.map(|(l, j)| format!("{l}={}", exact::<6>(j))).collect();
            // The first move goes from wherever the arm is.
            let is_rapid = targets.get(step.target).is_none_or(|t| t.feed.is_infinite());
            let speed = if last.is_none() || is_rapid || step.kind == Kind::Change {
                "rapid=TRUE".to_owned()
            } else {
                format!("time={seconds:.6}")
            };
            let ends = next.is_none() || last.is_none() || (step.is_target && n % 50 == 0);
            let wait = if ends { " --wait" } else { "" };
            let mode =
                if last.is_none() || next.is_none() { "stop" } else { "blend tolerance=0.01" };
            out.push_str(&format!(
                "motion.move {} {speed} mode={mode} line={line}{wait}\n",
                words.join(" ")
            ));
        }
        last = Some((step.joints, step.kind));
        seconds = 0.0;
    }
    out
}

/// Returns the path, and the arm at its first point.
pub(super) fn drawing(cell: &ArmCell, plan: &Plan, targets: &[Target]) -> Vec<Move> {
    let mut out: Vec<Move> = Vec::new();
    let mut last = None;
    for step in &plan.steps {
        let feed = targets.get(step.target).map_or(f64::INFINITY, |t| t.feed);
        let rapid = step.kind != Kind::Point || feed.is_infinite();
        let point = [step.tip.origin.x, step.tip.origin.y, step.tip.origin.z];
        match out.last_mut() {
            Some(chain) if chain.rapid == rapid => chain.points.push(point),
            _ => {
                let from = last.unwrap_or(point);
                out.push(Move { rapid, points: vec![from, point] });
            }
        }
        last = Some(point);
    }
    if let Some(first) = plan.steps.iter().find(|s| s.kind == Kind::Point) {
        let mut points: Vec<[f64; 3]> =
            cell.cell.arm.skeleton(&first.joints).iter().map(|p| [p.x, p.y, p.z]).collect();
        points.push([first.tip.origin.x, first.tip.origin.y, first.tip.origin.z]);
        out.push(Move { rapid: true, points });
    }
    out
}
