//! Numbers of an INI file. One that is none is an error, so that a limit is never left out by accident.

use hal_gcode::{
    Numbered, Settings,
    parameters::number::{G92, G92_APPLIES},
};
use hal_ini::{Entry, Ini};

/// Returns the number of an entry, if it is stated. Only the first word counts, as in a configuration of motion.
///
/// # Errors
/// The value is not a number.
pub fn number(ini: &Ini, section: &str, name: &str) -> Result<Option<f64>, String> {
    let Some((entry, word)) = stated(ini, section, name) else { return Ok(None) };
    let number = word.parse::<f64>().ok().filter(|n| !n.is_nan());
    number.map(Some).ok_or_else(|| wrong(entry, "a number such as 100 or -2.5"))
}

/// Returns the whole number of an entry, from 0 to `most`, if it is stated.
///
/// # Errors
/// The value is no such number.
pub(crate) fn count(ini: &Ini, section: &str, name: &str, most: u8) -> Result<Option<u8>, String> {
    let Some((entry, word)) = stated(ini, section, name) else { return Ok(None) };
    let number = word.parse::<u8>().ok().filter(|n| *n <= most);
    number.map(Some).ok_or_else(|| wrong(entry, &format!("a whole number from 0 to {most}")))
}

/// Tells whether an entry is 1. Any other value is no, as in LinuxCNC.
pub(crate) fn is_one(ini: &Ini, section: &str, name: &str) -> bool {
    ini.get(section, name).is_some_and(|value| value.trim() == "1")
}

/// Returns the error of an entry, with what its value must be.
pub fn wrong(entry: &Entry, wanted: &str) -> String {
    let Entry { file, line, section, name, value, .. } = entry;
    format!("{file}:{line}: [{section}]{name} '{value}': it must be {wanted}")
}

/// Returns the error of an entry that names no unit of length.
pub fn not_a_unit(entry: &Entry) -> String {
    wrong(entry, "mm or inch")
}

/// Returns the first entry of this name with its first word. An entry without a value states nothing.
fn stated<'a>(ini: &'a Ini, section: &str, name: &str) -> Option<(&'a Entry, &'a str)> {
    let entry = ini.all(section, name).next()?;
    Some((entry, entry.value.split_whitespace().next()?))
}

/// Takes the numbers of the section of the language.
///
/// # Errors
/// A value is not a number.
pub(crate) fn of_language(ini: &Ini, settings: &mut Settings) -> Result<(), String> {
    settings.arc_tolerance = arc_tolerance(ini)?;
    settings.no_fanuc_subs = is_one(ini, "RS274NGC", "DISABLE_FANUC_STYLE_SUB");
    settings.counts_arguments = is_one(ini, "RS274NGC", "OWORD_NARGS");
    settings.orient_offset = number(ini, "RS274NGC", "ORIENT_OFFSET")?.unwrap_or(0.0);
    Ok(())
}

/// Sets the offset of G92 in the parameters to none, if `[RS274NGC]DISABLE_G92_PERSISTENCE` asks for it.
pub(crate) fn forget_g92(ini: Option<&Ini>, numbered: &mut Numbered) {
    if ini.is_some_and(|ini| is_one(ini, "RS274NGC", "DISABLE_G92_PERSISTENCE")) {
        for index in G92_APPLIES..=G92 + 8 {
            numbered.put(index, 0.0);
        }
    }
}

/// Returns the tolerance of an arc's radii in millimetres.
///
/// # Errors
/// A value is not a number.
fn arc_tolerance(ini: &Ini) -> Result<f64, String> {
    let value = |name: &str| number(ini, "RS274NGC", name);
    let inch = value("CENTER_ARC_RADIUS_TOLERANCE_INCH")?.map(|v| v * 25.4);
    let default = Settings::default().arc_tolerance;
    Ok(value("CENTER_ARC_RADIUS_TOLERANCE_MM")?.or(inch).unwrap_or(default))
}

#[cfg(test)]
mod tests {
    use crate::{Files, Machine};
    use hal_gcode::canon::Unit;

    #[test]
    fn a_value_that_is_no_number_is_refused_at_its_place() {
        let folder = std::env::temp_dir().join(format!("hal-job-number-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("m.ini");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Machine::read(&Files { ini: Some(&path), ..Files::default() })
        };
        let kinds = "it must be a number such as 100 or -2.5";
        for (text, wanted) in [
            (
                "[TRAJ]\nSPINDLES = two\n",
                "[TRAJ]SPINDLES 'two': it must be a whole number from 0 to 8",
            ),
            ("[TRAJ]\nSPINDLES = 9\n", "[TRAJ]SPINDLES '9': it must be a whole number from 0 to 8"),
            ("[TRAJ]\nMAX_VELOCITY = fast\n", &format!("[TRAJ]MAX_VELOCITY 'fast': {kinds}")),
            ("[AXIS_X]\nMIN_LIMIT = -1O\n", &format!("[AXIS_X]MIN_LIMIT '-1O': {kinds}")),
            ("[AXIS_Y]\nMAX_LIMIT = nan\n", &format!("[AXIS_Y]MAX_LIMIT 'nan': {kinds}")),
            ("[JOINT_2]\nMAX_JERK = 1,5\n", &format!("[JOINT_2]MAX_JERK '1,5': {kinds}")),
            (
                "[RS274NGC]\nDIALECT = din\n",
                "[RS274NGC]DIALECT 'din': it must be linuxcnc or rs274d",
            ),
            (
                "[RS274NGC]\nDEFAULT_FEED = 0\n",
                "[RS274NGC]DEFAULT_FEED '0': it must be a feed above 0 in the machine's units per minute",
            ),
            ("[TRAJ]\nLINEAR_UNITS = cm\n", "[TRAJ]LINEAR_UNITS 'cm': it must be mm or inch"),
        ] {
            let why = read(text).err().unwrap_or_default();
            assert_eq!(why, format!("{}:2: {wanted}", path.display()), "{text}");
        }
        // Older files have the number of units in a millimetre.
        for (text, unit) in
            [("1.0", Unit::Millimetre), ("0.03937", Unit::Inch), ("Inch", Unit::Inch)]
        {
            let machine = read(&format!("[TRAJ]\nLINEAR_UNITS = {text}\n")).ok().unwrap();
            assert_eq!(machine.settings.unit, unit, "{text}");
        }
        let language =
            "[TRAJ]\nLINEAR_UNITS = inch\n[RS274NGC]\nDIALECT = RS274D\nDEFAULT_FEED = 2\n";
        let machine = read(language).ok().unwrap();
        assert_eq!(machine.settings.dialect, hal_gcode::Dialect::Rs274d);
        assert_eq!(machine.settings.default_feed, 50.8);
        for (value, is_set) in [("1", true), ("0", false), ("TRUE", false), ("", false)] {
            let entries = format!("DISABLE_FANUC_STYLE_SUB = {value}\nOWORD_NARGS = {value}\n");
            let settings = read(&format!("[RS274NGC]\n{entries}")).ok().unwrap().settings;
            let set = (settings.no_fanuc_subs, settings.counts_arguments);
            assert_eq!(set, (is_set, is_set), "{value}");
        }
        let machine = read("[RS274NGC]\nORIENT_OFFSET = -42.5\n").ok().unwrap();
        assert_eq!(machine.settings.orient_offset, -42.5);
        std::fs::write(folder.join("m.var"), "5210 1\n5211 3\n5219 4\n5220 2\n").unwrap();
        for (value, kept) in [(0, [1.0, 3.0, 4.0, 2.0]), (1, [0.0, 0.0, 0.0, 2.0])] {
            let text =
                format!("[RS274NGC]\nPARAMETER_FILE = m.var\nDISABLE_G92_PERSISTENCE = {value}\n");
            let machine = read(&text).ok().unwrap();
            assert_eq!([5210, 5211, 5219, 5220].map(|n| machine.numbered.get(n)), kept, "{value}");
        }
        let machine = read("[AXIS_X]\nMIN_LIMIT = -10 to the left\nMAX_LIMIT =\n").ok().unwrap();
        assert_eq!(machine.limits[0], (Some(-10.0), None));
        // With trivial kinematics, a joint's travel is that of its axis; the narrower one counts.
        let joints = "[TRAJ]\nCOORDINATES = XYY\n[AXIS_Y]\nMAX_LIMIT = 50\n[JOINT_0]\nMIN_LIMIT = -1\nMAX_LIMIT = 2\n\
            [JOINT_1]\nMAX_LIMIT = 60\n[JOINT_2]\nMIN_LIMIT = -3\nMAX_LIMIT = 40\n";
        let machine = read(joints).ok().unwrap();
        assert_eq!(machine.limits[..2], [(Some(-1.0), Some(2.0)), (Some(-3.0), Some(40.0))]);
        let other = format!("[KINS]\nKINEMATICS = armkins\n{joints}");
        let machine = read(&other).ok().unwrap();
        assert_eq!(machine.limits[..2], [(None, None), (None, Some(50.0))]);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
