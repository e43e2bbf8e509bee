//! Texts about a part and its path.

use super::cell::ArmCell;
use crate::terminal::colour::visible;
use hal_arm::{Change, Kind, Plan, Refused, Target, apt::Part};

/// Returns the text about a file and the place of its part, without what the file could change the terminal with.
pub(super) fn part(file: &str, part: &Part, cell: &ArmCell) -> String {
    let mut out = format!("{file}: ");
    if !part.name.is_empty() {
        out.push_str(&format!("{}, ", part.name));
    }
    out.push_str(&format!("{} points", part.points.len()));
    if let Some(centre) = part.centre() {
        let c = cell.frame.point(&centre);
        out.push_str(&format!(", centre {:.3} {:.3} {:.3}", c.x, c.y, c.z));
    }
    out.push('\n');
    for (line, text) in &part.warnings {
        out.push_str(&format!("{file}:{line}: warning: {text}\n"));
    }
    if let Some(fit) = &cell.fit {
        out.push_str(&format!(
            "  place by {} points, residual {:.3} mm, at most {:.3} mm\n",
            fit.residuals.len(),
            fit.rms(),
            fit.largest()
        ));
        for (a, b, by) in &fit.differences {
            out.push_str(&format!(
                "  warning: the distance of points {a} and {b} is {by:+.3} mm different from the design's\n"
            ));
        }
    }
    visible(&out)
}

/// Returns the place of a target as text.
fn place(target: usize, is_target: bool, targets: &[Target]) -> String {
    let Some(t) = targets.get(target) else { return "the end".to_owned() };
    let before = if is_target { "" } else { "before " };
    match t.kind {
        Kind::Approach => format!("{before}the approach to point {} line {}", t.point, t.line),
        Kind::Retract => format!("{before}the retract from point {} line {}", t.point, t.line),
        Kind::Point | Kind::Change => format!("{before}point {} line {}", t.point, t.line),
    }
}

/// Returns the verdict of each configuration on every target.
pub(super) fn verdicts(cell: &ArmCell, targets: &[Target]) -> String {
    let mut out = String::new();
    for (n, target) in targets.iter().enumerate() {
        for (configuration, verdict) in cell.cell.judge(&target.tip).into_iter().enumerate() {
            let text = match verdict {
                Ok((joint, margin)) => format!("ok margin {margin:.1} (J{})", joint + 1),
                Err(miss) => miss.to_string(),
            };
            out.push_str(&format!("  {}: {configuration}: {text}\n", place(n, true, targets)));
        }
    }
    out
}

/// Returns a configuration in words.
fn named(configuration: usize) -> String {
    let word = |bit, none, set| if configuration & bit == 0 { none } else { set };
    format!(
        "{configuration} ({}, elbow {}, {})",
        word(4, "front", "back"),
        word(2, "up", "down"),
        word(1, "no flip", "flip")
    )
}

fn change(change: &Change, targets: &[Target]) -> String {
    format!(
        "{}: configuration {} to {}, J{} by {:+.1}",
        place(change.target, change.is_target, targets),
        change.from,
        change.to,
        change.joint + 1,
        change.by
    )
}

/// Returns the reason why there is no plan, with each place.
pub(super) fn refused(file: &str, refused: &Refused, targets: &[Target]) -> String {
    let mut out = format!("{file}: error: ");
    match refused {
        Refused::Empty => out.push_str("there is no point\n"),
        Refused::TooLong => out.push_str("the path is too long to be examined\n"),
        Refused::NoRoom { target } => out.push_str(&format!(
            "{}: the path cannot go on, and there is no room to change the configuration\n",
            place(*target, true, targets)
        )),
        Refused::Unreached(failures) => {
            out.push_str("no configuration reaches the whole path; the first failure of each:\n");
            for (configuration, f) in failures.iter().enumerate() {
                let at = place(f.target, f.is_target, targets);
                out.push_str(&format!("  {}: {at}: {}\n", named(configuration), f.why));
            }
            out.push_str("  move the stock, or change the path\n");
        }
        Refused::Changes(changes) => {
            out.push_str("the configuration would have to change:\n");
            for c in changes {
                out.push_str(&format!("  {}\n", change(c, targets)));
            }
        }
    }
    out
}

/// Returns the text about a plan.
pub(super) fn plan(cell: &ArmCell, plan: &Plan, targets: &[Target]) -> String {
    let first = plan.steps.first().map_or(0, |s| s.configuration);
    let mut out = format!("  configuration {}\n", named(first));
    for c in &plan.changes {
        out.push_str(&format!("  change at {}\n", change(c, targets)));
    }
    let mut least: Option<(f64, usize, usize, bool)> = None;
    for step in &plan.steps {
        let (joint, margin) = cell.cell.arm.margin(&step.joints);
        if least.is_none_or(|l| margin < l.0) {
            least = Some((margin, joint, step.target, step.is_target));
        }
    }
    if let Some((margin, joint, target, is_target)) = least {
        let at = place(target, is_target, targets);
        out.push_str(&format!("  least margin {margin:.1} (J{}) at {at}\n", joint + 1));
    }
    let seconds: f64 = plan.steps.iter().map(|s| s.seconds).sum();
    let length: f64 = plan
        .steps
        .windows(2)
        .map(|p| match p {
            [a, b] => (b.tip.origin - a.tip.origin).norm(),
            _ => 0.0,
        })
        .sum();
    out.push_str(&format!("  path {length:.1} mm, {seconds:.1} s without accelerations\n"));
    let slowed = plan.steps.iter().filter(|s| s.is_slowed).count();
    if slowed > 0 {
        let all = plan.steps.len();
        out.push_str(&format!(
            "  slower than its feed on {slowed} of {all} steps: a joint is too slow\n"
        ));
    }
    out
}
