//! The path of an arm along a cutter-location file, for programs that draw it.

use super::{cell, report};
use hal_arm::{
    Kind, Target,
    apt::{self, Part},
    rotation::{near, to_abc},
    targets,
};
use std::{collections::BTreeMap, path::Path};

/// Number of different cutters of a file at most.
const MAX_CUTTERS: usize = 1000;

/// Path of an arm along a cutter-location file, as it runs.
#[derive(Clone, PartialEq, Debug)]
pub struct ArmPath {
    /// Steps in their order.
    pub steps: Vec<ArmStep>,
    /// Frame of the part relative to the arm's base: X Y Z, and roll, pitch, yaw in degrees.
    pub frame: [f64; 6],
    /// Different cutters in the order of the file.
    pub cutters: Vec<Cutter>,
}

/// Step of the arm.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ArmStep {
    /// Tip relative to the arm's base: X Y Z, and roll, pitch, yaw in degrees, of a frame whose Z points out of the arm.
    pub tip: [f64; 6],
    /// Joints in degrees.
    pub joints: [f64; 6],
    /// Line of the file.
    pub line: u32,
    /// Number of the cutter, from 1; 0 before the first.
    pub cutter: u16,
    /// True where the tool does not cut: approach, retract, change of configuration, `RAPID`.
    pub is_rapid: bool,
    /// Duration from the step before, in seconds.
    pub seconds: f64,
}

/// Cutter of a `CUTTER` statement.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Cutter {
    /// Diameter in millimetres.
    pub diameter: f64,
    /// True if its corner radius is its radius.
    pub is_ball: bool,
}

/// Reads the file `part` and plans its path in the cell of the INI file `ini`.
///
/// # Errors
/// A file cannot be read or is wrong, or the arm cannot run the path: the text that `halgcode apt` prints.
pub fn path(ini: &Path, part: &Path) -> Result<ArmPath, String> {
    let text = hal_ini::file::whole(part);
    let text = text.map_err(|e| format!("{}: {}", part.display(), hal_output::reason(&e)))?;
    path_of(ini, part, &text)
}

/// Plans the path of a text, as [`path`] does; `part` is its file in messages.
///
/// # Errors
/// The text is wrong, or the arm cannot run the path.
pub fn path_of(ini: &Path, part: &Path, text: &[u8]) -> Result<ArmPath, String> {
    let name = part.display().to_string();
    let part = Part::parse(text).map_err(|e| format!("{name}:{e}"))?;
    let cell = cell::read(ini)?;
    let targets = targets(&part.points, &cell.frame, cell.approach, cell.feed);
    let plan = cell.cell.plan(&targets);
    let plan = plan.map_err(|refused| report::refused(&name, &refused, &targets))?;
    let (cutters, changes) = cutters(&part.events).map_err(|e| format!("{name}: {e}"))?;
    let mut last = [0.0; 3];
    let mut steps = Vec::with_capacity(plan.steps.len());
    for step in &plan.steps {
        let target = targets.get(step.target);
        let turn = to_abc(&step.tip.turn, last[2]);
        for (last, angle) in last.iter_mut().zip(turn) {
            *last = near(angle, *last);
        }
        let p = step.tip.origin;
        let before = target.map_or(0, |t| t.point.saturating_sub(1));
        let change = changes.partition_point(|(after, _)| *after <= before).checked_sub(1);
        let cutter = change.and_then(|n| changes.get(n)).map_or(0, |(_, number)| *number);
        steps.push(ArmStep {
            tip: [p.x, p.y, p.z, last[0], last[1], last[2]],
            joints: step.joints,
            line: target.map_or(0, |t| t.line),
            cutter,
            is_rapid: step.kind != Kind::Point
                || target.is_none_or(|t: &Target| t.feed.is_infinite()),
            seconds: step.seconds,
        });
    }
    let o = cell.frame.origin;
    let [a, b, c] = to_abc(&cell.frame.turn, 0.0);
    Ok(ArmPath { steps, frame: [o.x, o.y, o.z, a, b, c], cutters })
}

/// Change of the cutter: the number of points before it, and the number of the cutter.
type Change = (usize, u16);

/// Returns the cutters, and where which is taken.
fn cutters(events: &[apt::Event]) -> Result<(Vec<Cutter>, Vec<Change>), String> {
    let (mut all, mut changes) = (Vec::new(), Vec::new());
    let mut numbers_of = BTreeMap::new();
    for event in events {
        let Some(list) = event.text.strip_prefix("CUTTER/") else { continue };
        let mut numbers = list.split(',').map(|word| word.parse::<f64>().ok());
        let Some(diameter) = numbers.next().flatten().filter(|d| d.is_finite() && *d > 0.0) else {
            continue;
        };
        let corner = numbers.next().flatten().unwrap_or(0.0);
        let cutter = Cutter { diameter, is_ball: corner >= diameter / 2.0 - 1e-9 };
        let number = *numbers_of.entry((diameter.to_bits(), cutter.is_ball)).or_insert_with(|| {
            all.push(cutter);
            all.len()
        });
        if number > MAX_CUTTERS {
            return Err(format!("CUTTER/{list}: more than {MAX_CUTTERS} different cutters"));
        }
        changes.push((event.after, u16::try_from(number).unwrap_or(u16::MAX)));
    }
    Ok((all, changes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const CELL: &str = "[ARM]\nMODEL = rx90\nTOOL = 0 0 275 0 0 0\nPRESENT = 0 -90 180 0 90 180\n\
                        [PART]\nFRAME = 500 -100 -100 0 0 30\n";

    #[test]
    fn a_part_has_steps_cutters_and_its_frame() {
        let folder = std::env::temp_dir().join(format!("halgcode-path-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let (cell, part) = (folder.join("cell.conf"), folder.join("part.apt"));
        let run = |text: &str| {
            fs::write(&part, text).unwrap();
            path(&cell, &part)
        };
        fs::write(&cell, CELL).unwrap();
        let text = "PARTNO P\nCUTTER/8\nFROM/0,0,100\nRAPID\nGOTO/20,20,0\nFEDRAT/600,MMPM\n\
                    GOTO/40,20,0\nCUTTER/6,3\nGOTO/60,20,0\nFINI\n";
        let found = run(text).unwrap();
        assert_eq!(found.frame.map(|v| (v * 1e6).round() / 1e6), [500., -100., -100., 0., 0., 30.]);
        let flat = Cutter { diameter: 8.0, is_ball: false };
        assert_eq!(found.cutters, [flat, Cutter { diameter: 6.0, is_ball: true }]);
        let cuts: Vec<_> = found.steps.iter().filter(|s| !s.is_rapid).collect();
        // A step for each millimetre at 10 mm/s.
        assert_eq!(cuts.len(), 40);
        assert!(cuts.iter().all(|s| (s.seconds - 0.1).abs() < 1e-9), "{:?}", cuts[0]);
        assert_eq!((cuts[0].cutter, cuts[0].line, cuts[39].cutter, cuts[39].line), (1, 7, 2, 9));
        let end = cuts[39].tip;
        let expected =
            [500.0 + 60.0 * 0.75_f64.sqrt() - 10.0, -100.0 + 30.0 + 20.0 * 0.75_f64.sqrt()];
        assert!((end[0] - expected[0]).abs() < 1e-9 && (end[1] - expected[1]).abs() < 1e-9);
        for pair in found.steps.windows(2) {
            let apart = |k: usize| (pair[1].tip[k] - pair[0].tip[k]).abs();
            assert!((3..6).all(|k| apart(k) < 2.0), "{pair:?}");
        }

        // A cutter that is taken again keeps its number; too many are refused by the one that is too much.
        let text = "CUTTER/8\nFROM/0,0,100\nGOTO/20,20,0\nCUTTER/8\nCUTTER/6\nGOTO/21,20,0\nCUTTER/8\n\
                    GOTO/22,20,0\nFINI\n";
        let found = run(text).unwrap();
        assert_eq!(found.cutters.len(), 2);
        let mut numbers: Vec<_> = found.steps.iter().map(|s| (s.line, s.cutter)).collect();
        numbers.dedup();
        assert!(numbers.contains(&(6, 2)) && numbers.contains(&(8, 1)), "{numbers:?}");
        let many = |last: usize| -> String {
            let all = (1..=last).map(|n| format!("CUTTER/{n}\n"));
            all.collect::<String>() + "FROM/0,0,100\nGOTO/20,20,0\nFINI\n"
        };
        assert_eq!(run(&many(MAX_CUTTERS)).unwrap().cutters.len(), MAX_CUTTERS);
        let refused = run(&many(MAX_CUTTERS + 1)).unwrap_err();
        assert!(refused.contains("CUTTER/1001: more than 1000"), "{refused}");

        let refused = run("FROM/0,0,100\nGOTO/5000,20,0\nFINI\n").unwrap_err();
        assert!(refused.contains("no configuration reaches"), "{refused}");
        let refused = run("GOTO/1,2,X\nFINI\n").unwrap_err();
        assert!(refused.contains("part.apt:1:"), "{refused}");
        let refused = path(&folder.join("none.conf"), &part).unwrap_err();
        assert!(!refused.is_empty());
        fs::remove_dir_all(&folder).unwrap();
    }
}
