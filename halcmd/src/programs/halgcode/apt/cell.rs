//! The cell of a robot arm, from an INI file.

use hal_arm::{Arm, Cell, Fit, Frame, Joints, fit, rotation::Vector};
use hal_ini::{Entry, Ini};
use std::path::Path;

/// Arm, tool and the place of the part.
pub(super) struct ArmCell {
    pub(super) cell: Cell,
    /// Frame of the design relative to the base of the arm.
    pub(super) frame: Frame,
    /// Fit of the touched points, if they gave the frame.
    pub(super) fit: Option<Fit>,
    /// Distance of the first and last target from the part, in millimetres.
    pub(super) approach: f64,
    /// Feed of points before any feed is given, in millimetres per second.
    pub(super) feed: f64,
}

/// Largest number of ways to reach a place that differ in whole turns alone: each is planned.
const MAX_TURNS: usize = 64;
/// Largest and smallest distance in millimetres, speed, and speed of a joint in degrees per second.
const POSITIVE: core::ops::RangeInclusive<f64> = 1e-3..=1e5;
/// Highest speeds of the RX-90 in degrees per second.
const SPEED_RX90: Joints = [236.0, 200.0, 286.0, 401.0, 320.0, 580.0];
/// Highest speeds of the RS03N in degrees per second.
const SPEED_RS03N: Joints = [360.0, 250.0, 225.0, 540.0, 225.0, 540.0];

/// Reads the sections `[ARM]` and `[PART]`. An error is `file:line: text`.
pub(super) fn read(path: &Path) -> Result<ArmCell, String> {
    let ini = Ini::read(path).map_err(|e| e.to_string())?;
    of(&ini, &path.display().to_string())
}

fn of(ini: &Ini, file: &str) -> Result<ArmCell, String> {
    let mut out = match ini.get("ARM", "MODEL") {
        None => return Err(format!("{file}: [ARM]MODEL is missing: rx90 or rs03n")),
        Some("rx90") => start(Arm::RX90, SPEED_RX90),
        Some("rs03n") => start(Arm::RS03N, SPEED_RS03N),
        Some(other) => {
            return Err(format!("{file}: [ARM]MODEL is '{other}', must be rx90 or rs03n"));
        }
    };
    let mut retract = 100.0;
    let mut may_change = false;
    for entry in ini.section("ARM") {
        match entry.name.as_str() {
            "MODEL" => {}
            "JUMP" => {
                may_change = match entry.value.as_str() {
                    "refuse" => false,
                    "retract" => true,
                    other => {
                        return Err(wrong(
                            entry,
                            &format!("'{other}' is neither refuse nor retract"),
                        ));
                    }
                }
            }
            "RETRACT" => [retract] = positive(entry)?,
            "APPROACH" => [out.approach] = positive(entry)?,
            "FEED" => [out.feed] = positive(entry)?,
            "TOOL" => out.cell.tool = Frame::from_xyzabc(numbers(entry)?),
            "PRESENT" => out.cell.present = numbers(entry)?,
            "SPEED" => out.cell.speed = positive(entry)?,
            _ => dimension(&mut out.cell.arm, entry)?,
        }
    }
    if !out.cell.arm.is_valid() {
        return Err(format!("{file}: the lengths, signs or limits of [ARM] describe no arm"));
    }
    let turns = out.cell.arm.turns();
    if turns > MAX_TURNS {
        return Err(format!(
            "{file}: by whole turns alone, MIN and MAX of [ARM] let the joints reach a place in {turns} ways: {MAX_TURNS} at most"
        ));
    }
    out.cell.back_off = may_change.then_some(retract);
    place(ini, file, &mut out)?;
    Ok(out)
}

fn start(arm: Arm, speed: Joints) -> ArmCell {
    let middle = |(low, high): (&f64, &f64)| {
        if *low <= 0.0 && 0.0 <= *high { 0.0 } else { (low + high) / 2.0 }
    };
    let mut present = [0.0; 6];
    for (to, limits) in present.iter_mut().zip(arm.min.iter().zip(&arm.max)) {
        *to = middle(limits);
    }
    let cell = Cell { arm, speed, tool: Frame::identity(), present, back_off: None };
    ArmCell { cell, frame: Frame::identity(), fit: None, approach: 100.0, feed: 10.0 }
}

/// Sets a dimension of the arm.
fn dimension(arm: &mut Arm, entry: &Entry) -> Result<(), String> {
    let length = match entry.name.as_str() {
        "A1" => &mut arm.a1,
        "A2" => &mut arm.a2,
        "A3" => &mut arm.a3,
        "D1" => &mut arm.d1,
        "D4" => &mut arm.d4,
        "D6" => &mut arm.d6,
        other => {
            let list = match other {
                "OFFSET" => &mut arm.offset,
                "SIGN" => &mut arm.sign,
                "MIN" => &mut arm.min,
                "MAX" => &mut arm.max,
                _ => return Err(wrong(entry, &format!("[ARM]{other} has no meaning"))),
            };
            *list = numbers(entry)?;
            return Ok(());
        }
    };
    [*length] = numbers(entry)?;
    Ok(())
}

/// Reads the place of the part: a frame, or designed and touched points.
fn place(ini: &Ini, file: &str, out: &mut ArmCell) -> Result<(), String> {
    let (mut design, mut touched) = (Vec::new(), Vec::new());
    let mut frame = None;
    for entry in ini.section("PART") {
        match entry.name.as_str() {
            "FRAME" => frame = Some(Frame::from_xyzabc(numbers(entry)?)),
            "DESIGN" => design.push(Vector::from(numbers::<3>(entry)?)),
            "TOUCHED" => touched.push(Vector::from(numbers::<3>(entry)?)),
            other => return Err(wrong(entry, &format!("[PART]{other} has no meaning"))),
        }
    }
    match (frame, design.is_empty() && touched.is_empty()) {
        (Some(_), false) => {
            Err(format!("{file}: [PART] has a FRAME, and points that give another"))
        }
        (Some(frame), true) => {
            out.frame = frame;
            Ok(())
        }
        (None, true) => Err(format!(
            "{file}: [PART] says nothing of the part's place: FRAME, or DESIGN and TOUCHED of three points or more"
        )),
        (None, false) => {
            let found = fit(&design, &touched).map_err(|e| format!("{file}: [PART]: {e}"))?;
            out.frame = found.frame;
            out.fit = Some(found);
            Ok(())
        }
    }
}

fn wrong(entry: &Entry, text: &str) -> String {
    format!("{}:{}: {text}", entry.file, entry.line)
}

/// Reads numbers separated by blanks.
fn numbers<const N: usize>(entry: &Entry) -> Result<[f64; N], String> {
    let mut out = [0.0; N];
    let mut words = entry.value.split_whitespace();
    for to in &mut out {
        let number = words.next().and_then(|w| w.parse::<f64>().ok()).filter(|x| x.abs() < 1e7);
        let text =
            || wrong(entry, &format!("{} takes {N} numbers, not '{}'", entry.name, entry.value));
        *to = number.ok_or_else(text)?;
    }
    if words.next().is_some() {
        return Err(wrong(
            entry,
            &format!("{} takes {N} numbers, not '{}'", entry.name, entry.value),
        ));
    }
    Ok(out)
}

/// Reads numbers that must be above 0, and neither so small nor so large that no path would end.
fn positive<const N: usize>(entry: &Entry) -> Result<[f64; N], String> {
    let numbers = numbers(entry)?;
    if numbers.iter().all(|x| POSITIVE.contains(x)) {
        return Ok(numbers);
    }
    let (low, high) = (POSITIVE.start(), POSITIVE.end());
    Err(wrong(entry, &format!("{} must be between {low} and {high}", entry.name)))
}

#[cfg(test)]
mod tests {
    //! Cells that are refused, each with its place.

    use super::{Ini, of};

    #[test]
    fn wrong_entries_are_refused_with_their_place() {
        for (line, why) in [
            ("FEED = nan", "c.conf:3: FEED takes 1 numbers, not 'nan'"),
            ("FEED = 1e-300", "c.conf:3: FEED must be between 0.001 and 100000"),
            ("SPEED = 1 1 1 1 1 1e6", "c.conf:3: SPEED must be between 0.001 and 100000"),
            ("APPROACH = -1", "c.conf:3: APPROACH must be between 0.001 and 100000"),
            ("TOOL = 1 2 3", "c.conf:3: TOOL takes 6 numbers, not '1 2 3'"),
            ("JUMP = high", "c.conf:3: 'high' is neither refuse nor retract"),
            ("SPIN = 1", "c.conf:3: [ARM]SPIN has no meaning"),
            ("SIGN = 1 1 1 1 1 0", "c.conf: the lengths, signs or limits of [ARM] describe no arm"),
            (
                "MIN = -1e6 -1e6 -1e6 -1e6 -1e6 -1e6\nMAX = 1e6 1e6 1e6 1e6 1e6 1e6",
                "c.conf: by whole turns alone, MIN and MAX of [ARM] let the joints reach a place in 15625 ways: 64 at most",
            ),
            ("[PART]\nFRAME = 0 0 0 0 0 0\nTOUCHED = 1 2 3", "c.conf: [PART] has a FRAME, and"),
            ("[PART]\nDESIGN = 0 0 0\nDESIGN = 1 0 0", "c.conf: [PART]: 2 designed and 0 touched"),
            ("[PART]\nPLACE = 0 0 0", "c.conf:4: [PART]PLACE has no meaning"),
            ("", "c.conf: [PART] says nothing of the part's place"),
        ] {
            let text = format!("[ARM]\nMODEL = rx90\n{line}\n");
            let ini = Ini::parse("c.conf", text.as_bytes()).unwrap();
            let said = of(&ini, "c.conf").err().unwrap_or_default();
            assert!(said.starts_with(why), "{line}: {said}");
        }
    }
}
