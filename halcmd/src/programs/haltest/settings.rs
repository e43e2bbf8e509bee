//! Entries of a machine's INI file that a test changes.

use super::{outcome::Complaint, step::text_of, test::Test};
use crate::ini::Ini;

/// Applies the changes of the test to the INI file.
pub(super) fn change(test: &Test, ini: Option<&mut Ini>) -> Result<(), Complaint> {
    let Some(first) = test.settings.first() else { return Ok(()) };
    let Some(ini) = ini else {
        let text = "the machine has no INI file whose entries could be changed";
        return Err(
            Complaint::new(&first.spot, text).with("arguments = [\"-i\", \"FILE\"] names one")
        );
    };
    for entry in &test.settings {
        let name = &entry.name;
        let parts = name.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        let Some((section, key)) = parts else {
            let text = format!("'{name}' is not an entry of an INI file");
            let form = "an entry is written \"[SECTION]NAME\" = value";
            return Err(Complaint::new(&entry.spot, text).with(form));
        };
        if !ini.change(section, key, &text_of(&entry.value)) {
            let near = ini.nearest(section, key).filter(|(_, meant)| *meant).map(|(near, _)| near);
            let text = format!("the machine's INI file has no entry {name}");
            return Err(Complaint::new(&entry.spot, text).near(near));
        }
    }
    Ok(())
}
