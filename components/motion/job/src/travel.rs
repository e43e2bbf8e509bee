//! The travel of the axes: its entries in the INI file, and places beyond it.

use crate::{machine::Machine, number::number};
use hal_gcode::{
    axis::{Axis, AxisMask, Position},
    canon::Unit,
};
use hal_ini::Ini;

impl Machine {
    /// Takes the travel of an axis from `[AXIS_X]`, or from `[AXIS_0]` of the old kind of file. With trivial kinematics
    /// that of its joint counts, too: the narrower one.
    pub(crate) fn axis(&mut self, ini: &Ini, axis: Axis, letters: &[Axis]) -> Result<(), String> {
        let k = if axis.is_rotary() { 1.0 } else { self.settings.unit.millimetres() };
        let mut limit = (None, None);
        for section in self.travel_sections(ini, axis, letters) {
            let value = |name: &str| number(ini, &section, name).map(|n| n.map(|n| n * k));
            let narrower = |a: Option<f64>, b: Option<f64>, pick: fn(f64, f64) -> f64| {
                a.zip(b).map(|(a, b)| pick(a, b)).or(a).or(b)
            };
            limit.0 = narrower(limit.0, value("MIN_LIMIT")?, f64::max);
            limit.1 = narrower(limit.1, value("MAX_LIMIT")?, f64::min);
        }
        if let Some(slot) = self.limits.get_mut(usize::from(axis.index())) {
            *slot = limit;
        }
        if axis.is_rotary() {
            let section = axis_section(ini, axis, letters);
            let is_wrapped = ini.get(&section, "WRAPPED_ROTARY").is_some_and(|v| v.trim() == "1");
            self.settings.wrapped.0 |= u16::from(is_wrapped) << axis.index();
        }
        Ok(())
    }

    /// Returns the limits that a place in millimetres and degrees is beyond: axis, whether it is the upper one, and the limit.
    pub fn beyond(&self, place: Position) -> impl Iterator<Item = (Axis, bool, f64)> {
        Axis::ALL.into_iter().zip(self.limits).filter_map(move |(axis, (low, high))| {
            let value = place[axis];
            // Sums of offsets end in the last digits.
            let below = low.filter(|low| value < low - 1e-6).map(|low| (axis, false, low));
            below.or(high.filter(|high| value > high + 1e-6).map(|high| (axis, true, high)))
        })
    }

    /// Returns by how much a value in millimetres or degrees is beyond a limit, with the limit's entries in the INI file:
    /// `X110.0000 is 10.0000 mm beyond [JOINT_0]MAX_LIMIT = 100 (mill.ini:41)`. If the axis and its joint have the same limit,
    /// both are named.
    pub fn excess(&self, (axis, is_upper, limit): (Axis, bool, f64), value: f64) -> String {
        let (k, unit) = match self.settings.unit {
            _ if axis.is_rotary() => (1.0, "degrees"),
            Unit::Inch => (25.4, "inch"),
            Unit::Millimetre => (1.0, "mm"),
        };
        let letter = axis.letter().to_ascii_uppercase();
        let by = (value - limit).abs() / k;
        let entries = self.limit_entries(axis, is_upper, limit);
        format!("{letter}{:.4} is {by:.4} {unit} beyond {entries}", value / k)
    }

    /// Returns the entries that state a limit.
    fn limit_entries(&self, axis: Axis, is_upper: bool, limit: f64) -> String {
        let name = if is_upper { "MAX_LIMIT" } else { "MIN_LIMIT" };
        let k = if axis.is_rotary() { 1.0 } else { self.settings.unit.millimetres() };
        let mut found = Vec::new();
        if let Some(ini) = &self.ini {
            for section in self.travel_sections(ini, axis, &self.letters) {
                let stated = number(ini, &section, name).ok().flatten();
                if let Some(value) = stated.filter(|value| (value * k).total_cmp(&limit).is_eq()) {
                    let at = ini.all(&section, name).next();
                    let at = at.map(|e| format!(" ({}:{})", e.file, e.line)).unwrap_or_default();
                    found.push(format!("[{section}]{name} = {value}{at}"));
                }
            }
        }
        if found.is_empty() {
            let letter = axis.letter().to_ascii_uppercase();
            found.push(format!("[AXIS_{letter}]{name} = {}", limit / k));
        }
        found.join(" and ")
    }

    /// Returns the sections that state the travel of an axis.
    fn travel_sections(&self, ini: &Ini, axis: Axis, letters: &[Axis]) -> Vec<String> {
        let mut sections = vec![axis_section(ini, axis, letters)];
        if self.kinematics.is_none() && !ini.is_old() {
            let joints = joint_axes(ini, letters);
            let joints = joints.iter().enumerate().filter(|(_, a)| **a == axis);
            sections.extend(joints.map(|(n, _)| format!("JOINT_{n}")));
        }
        sections
    }
}

/// Returns the set of these axes.
pub(crate) fn mask(axes: &[Axis]) -> AxisMask {
    AxisMask(axes.iter().fold(0, |mask, a| mask | 1 << a.index()))
}

/// Returns the axes that `[TRAJ]COORDINATES` states; `letters` are those of a machine whose INI file states none.
pub(crate) fn coordinates(ini: &Ini, letters: &str) -> Vec<Axis> {
    axes(ini.get("TRAJ", "COORDINATES").unwrap_or(letters))
}

/// Returns the axis of each joint; `letters` are those of a machine whose INI file states none.
pub(crate) fn joint_axes(ini: &Ini, letters: &[Axis]) -> Vec<Axis> {
    ini.joint_letters().map_or_else(|| letters.to_vec(), |letters| axes(&letters))
}

fn axes(text: &str) -> Vec<Axis> {
    let find = |c: char| Axis::ALL.into_iter().find(|a| a.letter() == c);
    text.to_ascii_lowercase().chars().filter_map(find).collect()
}

/// Returns the section of an axis: `AXIS_X`, or `AXIS_0` in the old kind of file.
fn axis_section(ini: &Ini, axis: Axis, letters: &[Axis]) -> String {
    match letters.iter().position(|a| *a == axis) {
        Some(n) if ini.is_old() => format!("AXIS_{n}"),
        _ => format!("AXIS_{}", axis.letter().to_ascii_uppercase()),
    }
}

#[cfg(test)]
mod tests {
    use crate::{Files, Machine};
    use hal_gcode::axis::{Axis, Position};

    #[test]
    fn a_place_beyond_a_limit_is_told_with_the_entries_of_the_limit() {
        let folder = std::env::temp_dir().join(format!("hal-job-travel-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("m.ini");
        let axis = "[AXIS_X]\nMAX_LIMIT = 100\n";
        for (text, at, wanted) in [
            (axis, 110.0, "X110.0000 is 10.0000 mm beyond [AXIS_X]MAX_LIMIT = 100 (m.ini:2)"),
            (
                "[AXIS_X]\nMIN_LIMIT = -10\n[JOINT_0]\nMIN_LIMIT = -2.5\n",
                -3.0,
                "X-3.0000 is 0.5000 mm beyond [JOINT_0]MIN_LIMIT = -2.5 (m.ini:4)",
            ),
            (
                "[TRAJ]\nCOORDINATES = YXX\n[JOINT_1]\nMAX_LIMIT = 9\n[JOINT_2]\nMAX_LIMIT = 8 # mm\n[AXIS_X]\nMAX_LIMIT = 8\n",
                10.0,
                "X10.0000 is 2.0000 mm beyond [AXIS_X]MAX_LIMIT = 8 (m.ini:8) and [JOINT_2]MAX_LIMIT = 8 (m.ini:6)",
            ),
            // The joints are those of the kinematics, whatever the order of the axes is.
            (
                "[KINS]\nKINEMATICS = trivkins coordinates=YX\n[TRAJ]\nCOORDINATES = XY\n[JOINT_0]\nMAX_LIMIT = 3\n[JOINT_1]\nMAX_LIMIT = 8\n",
                10.0,
                "X10.0000 is 2.0000 mm beyond [JOINT_1]MAX_LIMIT = 8 (m.ini:8)",
            ),
            (
                "[TRAJ]\nLINEAR_UNITS = inch\n[JOINT_0]\nMAX_LIMIT = 0.7\n",
                25.4,
                "X1.0000 is 0.3000 inch beyond [JOINT_0]MAX_LIMIT = 0.7 (m.ini:4)",
            ),
            (
                "[TRAJ]\nAXES = 1\nCOORDINATES = X\n[AXIS_0]\nMAX_LIMIT = 7\n",
                8.0,
                "X8.0000 is 1.0000 mm beyond [AXIS_0]MAX_LIMIT = 7 (m.ini:5)",
            ),
            (
                "[KINS]\nKINEMATICS = armkins\n[JOINT_0]\nMAX_LIMIT = 7\n[AXIS_X]\nMAX_LIMIT = 9\n",
                10.0,
                "X10.0000 is 1.0000 mm beyond [AXIS_X]MAX_LIMIT = 9 (m.ini:6)",
            ),
        ] {
            std::fs::write(&path, text).unwrap();
            let machine = Machine::read(&Files { ini: Some(&path), ..Files::default() }).unwrap();
            let mut place = Position::default();
            place[Axis::X] = at;
            let told: Vec<String> =
                machine.beyond(place).map(|limit| machine.excess(limit, at)).collect();
            let told = told.join("\n").replace(&format!("{}/", folder.display()), "");
            assert_eq!(told, wanted, "{text}");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
