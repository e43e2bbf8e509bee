//! Entries of the INI file: the slow machine's, and changes that a person agrees to.

use crate::failure::Failure;
use hal_ini::{Entry, Ini};
use similar::TextDiff;
use std::path::{Path, PathBuf};

/// Speed of a spindle without a highest one, in turns a minute.
const SPINDLE: f64 = 500.0;
/// Share of its speeds that a machine has while it is commissioned.
const SHARE: f64 = 0.1;
/// Largest following errors that are permitted, at rest and at speed: in millimetres and degrees, and in inches. The one at
/// rest is less than the first way of a joint, so that one without an encoder does not get past it.
const ERRORS: [(f64, f64); 2] = [(0.2, 0.008), (1.0, 0.04)];
/// Names of entries in sections of joints and axes, and of the trajectory, that are scaled.
const SCALED: &[&str] = &[
    "MAX_VELOCITY",
    "MAX_ACCELERATION",
    "MAX_JERK",
    "HOME_SEARCH_VEL",
    "HOME_LATCH_VEL",
    "HOME_FINAL_VEL",
    "DEFAULT_LINEAR_VELOCITY",
    "MAX_LINEAR_VELOCITY",
    "DEFAULT_LINEAR_ACCELERATION",
    "MAX_LINEAR_ACCELERATION",
    "DEFAULT_ANGULAR_VELOCITY",
    "MAX_ANGULAR_VELOCITY",
    "DEFAULT_ANGULAR_ACCELERATION",
    "MAX_ANGULAR_ACCELERATION",
    "DEFAULT_VELOCITY",
    "DEFAULT_ACCELERATION",
];
/// Names of entries that state the steps of a unit.
const SCALES: &[&str] = &["SCALE", "INPUT_SCALE", "STEP_SCALE", "ENCODER_SCALE"];

/// The INI file of the slow machine, and what the steps need of the entries.
pub(crate) struct Slow {
    /// Text of the file.
    pub(crate) text: String,
    /// The file of the machine itself.
    pub(crate) path: PathBuf,
    pub(crate) joints: Vec<JointEntries>,
    /// Speed of the spindle, in turns a minute: a tenth of its highest, and not below its lowest.
    pub(crate) spindle: f64,
}

/// Entries of a joint.
#[derive(Clone, Debug)]
pub(crate) struct JointEntries {
    /// Name for the person: the letter of its axis, or `joint 2`.
    pub(crate) name: String,
    pub(crate) unit: &'static str,
    /// Velocity and acceleration of the slow machine.
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
    /// Velocity at which homing looks for its switch, in the slow machine; 0 without a switch.
    pub(crate) search: f64,
    pub(crate) latch: f64,
    /// Entry with the steps of a unit.
    pub(crate) scale: Option<Entry>,
}

impl Slow {
    /// Returns the slow machine of an INI file.
    pub(crate) fn of(path: &Path, ini: &Ini) -> Result<Self, Failure> {
        let unsuited = |why: &str| Failure::Unsuited { path: path.into(), why: why.into() };
        let count = number(ini, "KINS", "JOINTS").filter(|n| (1.0..=16.0).contains(n));
        let count =
            count.ok_or_else(|| unsuited("[KINS]JOINTS: 1 to 16 joints are commissioned"))?;
        let kinematics = ini.get("KINS", "KINEMATICS").unwrap_or_default();
        let letters = ini.joint_letters().unwrap_or_else(|| "XYZ".to_owned());
        let unit = if ini.is_inch() == Ok(true) { "inch" } else { "mm" };
        let mut joints = Vec::new();
        for n in (0_u32..).take_while(|n| f64::from(*n) < count) {
            let section = format!("JOINT_{n}");
            let of = |name: &str| number(ini, &section, name);
            let at = usize::try_from(n).unwrap_or(usize::MAX);
            let letter = letters.chars().nth(at).filter(|_| kinematics.starts_with("trivkins"));
            let is_angular = ini.get(&section, "TYPE").is_some_and(|kind| kind.trim() == "ANGULAR");
            let needed = |name: &str| {
                of(name).ok_or_else(|| unsuited(&format!("[{section}]{name}: a number is needed")))
            };
            if of("HOME_SEQUENCE").is_some_and(f64::is_sign_negative) {
                return Err(unsuited(&format!(
                    "[{section}]HOME_SEQUENCE is negative: joints that home together cannot be jogged one by one before, \
                     and are not commissioned"
                )));
            }
            let velocity = needed("MAX_VELOCITY")? * SHARE;
            joints.push(JointEntries {
                name: letter.map_or_else(|| format!("joint {n}"), String::from),
                unit: if is_angular { "degrees" } else { unit },
                velocity,
                acceleration: needed("MAX_ACCELERATION")? * SHARE,
                min: needed("MIN_LIMIT")?,
                max: needed("MAX_LIMIT")?,
                search: of("HOME_SEARCH_VEL").unwrap_or(0.0) * SHARE,
                latch: of("HOME_LATCH_VEL").unwrap_or(0.0) * SHARE,
                scale: SCALES.iter().find_map(|name| ini.all(&section, name).next().cloned()),
            });
        }
        let of_spindle = |name: &str| number(ini, "SPINDLE_0", name).filter(|speed| *speed > 0.0);
        let spindle = of_spindle("MAX_FORWARD_VELOCITY").map_or(SPINDLE, |most| {
            (most * SHARE).max(of_spindle("MIN_FORWARD_VELOCITY").unwrap_or(0.0)).min(most)
        });
        Ok(Self { text: text(ini), path: path.to_owned(), joints, spindle })
    }
}

fn number(ini: &Ini, section: &str, name: &str) -> Option<f64> {
    let text = ini.get(section, name)?;
    text.split_whitespace().next()?.parse().ok().filter(|x: &f64| x.is_finite())
}

/// Returns the largest following error that a joint may have, at rest (0) or at speed (1).
fn permitted(ini: &Ini, section: &str, at: usize) -> f64 {
    let is_angular = ini.get(section, "TYPE").is_some_and(|kind| kind.trim() == "ANGULAR");
    let (mm, inch) = ERRORS.get(at).copied().unwrap_or_default();
    if ini.is_inch() == Ok(true) && !is_angular { inch } else { mm }
}

/// Returns the text of the slow machine: all entries, files that are included as well.
fn text(ini: &Ini) -> String {
    let mut to = String::from("# Written by ferrule commission, and removed at its end.\n");
    let mut section = None;
    for entry in ini.entries() {
        if section != Some(&entry.section) {
            to.push_str(&format!("[{}]\n", entry.section));
            section = Some(&entry.section);
        }
        let is_of_motion = ["JOINT_", "AXIS_"].iter().any(|begin| entry.section.starts_with(begin))
            || entry.section == "TRAJ";
        let value = stated(entry).filter(|_| is_of_motion);
        let slow = match (entry.name.as_str(), value) {
            ("MIN_FERROR", Some(value)) => Some(value.min(permitted(ini, &entry.section, 0))),
            ("FERROR", Some(value)) => Some(permitted(ini, &entry.section, 1).min(value * SHARE)),
            (name, Some(value)) if SCALED.contains(&name) => Some(value * SHARE),
            _ => None,
        };
        match slow {
            Some(value) => to.push_str(&format!("{} = {value}\n", entry.name)),
            None => to.push_str(&format!("{} = {}\n", entry.name, entry.value)),
        }
    }
    to
}

/// Returns the number that an entry states; what follows it stays as it is.
pub(crate) fn stated(entry: &Entry) -> Option<f64> {
    first(entry).parse().ok().filter(|x: &f64| x.is_finite())
}

fn first(entry: &Entry) -> &str {
    entry.value.split_whitespace().next().unwrap_or_default()
}

/// A change of an entry.
#[derive(Clone, Debug)]
pub(crate) struct Change {
    entry: Entry,
    path: PathBuf,
    value: String,
}

impl Change {
    /// Returns the change of an entry to a value.
    pub(crate) fn new(entry: &Entry, value: f64) -> Self {
        let text = format!("{value:.9}");
        let value = text.trim_end_matches('0').trim_end_matches('.').to_owned();
        Self { entry: entry.clone(), path: PathBuf::from(&entry.file), value }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns what is changed, in a line.
    pub(crate) fn summary(&self) -> String {
        let Entry { section, name, .. } = &self.entry;
        let value = first(&self.entry);
        format!("[{section}]{name} from {value} to {}", self.value)
    }

    /// Returns the difference that the change makes in its file, as `diff -u` shows it.
    pub(crate) fn difference(&self) -> Result<String, Failure> {
        let (before, after) = self.texts()?;
        let name = self.path.display().to_string();
        let lines = TextDiff::from_lines(&before, &after);
        Ok(lines.unified_diff().context_radius(2).header(&name, &name).to_string())
    }

    /// Writes the file as a whole, with the one line changed; `ferrule restore` has the one before.
    pub(crate) fn write(&self) -> Result<(), Failure> {
        let (_, after) = self.texts()?;
        hal_output::write_kept(&self.path, after.as_bytes())
            .map_err(|e| Failure::file(&self.path, &e))
    }

    /// Returns the file as it is, and with the change.
    fn texts(&self) -> Result<(String, String), Failure> {
        let unsuited = |why: String| Failure::Unsuited { path: self.path.clone(), why: why.into() };
        let bytes = hal_ini::file::whole(&self.path).map_err(|e| Failure::file(&self.path, &e))?;
        let before = String::from_utf8(bytes)
            .map_err(|_| unsuited("not in UTF-8: change the entry by hand".to_owned()))?;
        let mut is_done = false;
        let lines = (1..).zip(before.split_inclusive('\n')).map(|(number, line)| {
            let changed = (number == self.entry.line).then(|| self.line(line)).flatten();
            is_done |= changed.is_some();
            changed.unwrap_or_else(|| line.to_owned())
        });
        let after: String = lines.collect();
        if is_done {
            return Ok((before, after));
        }
        let Entry { line, name, .. } = &self.entry;
        Err(unsuited(format!("line {line} is not {name} = {} any more", first(&self.entry))))
    }

    /// Returns a line with the new value; comment and blanks stay.
    fn line(&self, line: &str) -> Option<String> {
        let (before, after) = line.split_once('=')?;
        if before.trim() != self.entry.name {
            return None;
        }
        let start = after.find(|c: char| !c.is_whitespace())?;
        let value = after.get(start..)?.strip_prefix(first(&self.entry))?;
        Some(format!("{before}={}{}{value}", after.get(..start)?, self.value))
    }
}

#[cfg(test)]
mod tests {
    use super::{Change, Slow};
    use hal_ini::Ini;
    use std::path::Path;

    const TEXT: &str = "[EMC]\nMACHINE = x\n[KINS]\nJOINTS = 1\nKINEMATICS = trivkins coordinates=X\n[TRAJ]\nCOORDINATES = X\n\
        MAX_LINEAR_VELOCITY = 50\n[JOINT_0]\nMAX_VELOCITY = 50\nMAX_ACCELERATION = 400\nMIN_LIMIT = 0\nMAX_LIMIT = 10\n\
        FERROR = 1\nMIN_FERROR = 0.25\nHOME_SEARCH_VEL = -10\nHOME_LATCH_VEL = 1\nSCALE = 200   # steps\n";

    #[test]
    fn speeds_are_a_tenth_and_nothing_else_changes() {
        let slow =
            Slow::of(Path::new("m.ini"), &Ini::parse("m.ini", TEXT.as_bytes()).unwrap()).unwrap();
        let ini = Ini::parse("slow.ini", slow.text.as_bytes()).unwrap();
        for (section, name, want) in [
            ("TRAJ", "MAX_LINEAR_VELOCITY", "5"),
            ("JOINT_0", "MAX_VELOCITY", "5"),
            ("JOINT_0", "MAX_ACCELERATION", "40"),
            ("JOINT_0", "FERROR", "0.1"),
            ("JOINT_0", "MIN_FERROR", "0.2"),
            ("JOINT_0", "HOME_SEARCH_VEL", "-1"),
            ("JOINT_0", "HOME_LATCH_VEL", "0.1"),
            ("JOINT_0", "MAX_LIMIT", "10"),
            ("EMC", "MACHINE", "x"),
        ] {
            assert_eq!(ini.get(section, name), Some(want), "[{section}]{name}");
        }
        assert_eq!(ini.entries().count(), 14);
    }

    /// The kinematics say which axis a joint moves.
    #[test]
    fn a_joint_has_the_letter_of_the_axis_that_it_moves() {
        for (kinematics, name) in
            [("trivkins coordinates=YX", "Y"), ("trivkins", "X"), ("corexykins", "joint 0")]
        {
            let text = TEXT.replace("trivkins coordinates=X", kinematics);
            let text = text.replace("COORDINATES = X", "COORDINATES = XY");
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            let slow = Slow::of(Path::new("m.ini"), &ini).unwrap();
            assert_eq!(slow.joints[0].name, name, "{kinematics}");
        }
    }

    #[test]
    fn the_spindle_turns_at_a_tenth_or_at_its_lowest_speed() {
        for (entries, want) in [
            ("", 500.0),
            ("[SPINDLE_0]\nMAX_FORWARD_VELOCITY = 3000\n", 300.0),
            ("[SPINDLE_0]\nMAX_FORWARD_VELOCITY = 24000\nMIN_FORWARD_VELOCITY = 6000\n", 6000.0),
        ] {
            let text = format!("{TEXT}{entries}");
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            let slow = Slow::of(Path::new("m.ini"), &ini).unwrap();
            assert!((slow.spindle - want).abs() < 1e-9, "{entries}: {}", slow.spindle);
        }
    }

    #[test]
    fn a_change_keeps_the_rest_of_the_file() {
        let path = std::env::temp_dir().join(format!("ferrule-change-{}.ini", std::process::id()));
        std::fs::write(&path, TEXT).unwrap();
        let ini = Ini::read(&path).unwrap();
        let slow = Slow::of(&path, &ini).unwrap();
        let change = Change::new(slow.joints[0].scale.as_ref().unwrap(), -100.0);
        let shown = change.difference().unwrap();
        assert!(
            shown.ends_with(
                " HOME_LATCH_VEL = 1\n-SCALE = 200   # steps\n+SCALE = -100   # steps\n"
            ),
            "{shown}"
        );
        change.write().unwrap();
        let kept = hal_output::states(&path).unwrap();
        assert_eq!(kept.last().unwrap().read().unwrap(), TEXT.as_bytes());
        let after = std::fs::read_to_string(&path).unwrap();
        assert_eq!(after, TEXT.replace("SCALE = 200 ", "SCALE = -100 "));
        // The line is another one now: nothing is written.
        assert!(change.write().is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), after);
        std::fs::remove_file(path).unwrap();
    }
}
