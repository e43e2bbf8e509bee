//! The version of LinuxCNC whose first values items have: `--compat`, `HAL_COMPAT`, `[HAL]COMPAT`.

use crate::{Error, ini::Ini};

const EXPECTED: &str = "it is 2.9 or 2.10";

/// Parses the option. Returns whether items begin with the values of 2.9.
pub(super) fn option(value: Option<String>) -> Result<bool, Error> {
    let Some(text) = value else { return Ok(false) };
    version(&text).ok_or_else(|| {
        let (option, value, why) = ("--compat".into(), text.into(), EXPECTED.into());
        Error::OptionValue { program: "halrun", option, value, why }
    })
}

/// Reads `[HAL]COMPAT`. Returns whether items begin with the values of 2.9.
pub(crate) fn of_ini(ini: &Ini) -> Result<bool, Error> {
    let Some(entry) = ini.all("HAL", "COMPAT").next() else { return Ok(false) };
    version(&entry.value).ok_or_else(|| Error::Profile {
        place: format!("{}:{}", entry.file, entry.line).into(),
        why: format!("[HAL]COMPAT '{}': {EXPECTED}", entry.value).into(),
    })
}

fn version(text: &str) -> Option<bool> {
    match text {
        "2.9" => Some(true),
        "2.10" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{of_ini, option};
    use crate::ini::Ini;

    #[test]
    fn two_versions_are_known() {
        let ini = |text: &str| of_ini(&Ini::parse("m.ini", text.as_bytes()).unwrap());
        assert_eq!(ini("[HAL]\nCOMPAT = 2.9\n"), Ok(true));
        assert_eq!(ini("[HAL]\nCOMPAT = 2.10\n"), Ok(false));
        assert_eq!(ini("[HAL]\n"), Ok(false));
        let said = ini("[HAL]\nCOMPAT = 2.8\n").unwrap_err().to_string();
        assert_eq!(said, "m.ini:2: [HAL]COMPAT '2.8': it is 2.9 or 2.10");
        assert_eq!(option(Some("2.9".to_owned())), Ok(true));
        assert!(option(Some("3".to_owned())).is_err());
    }
}
