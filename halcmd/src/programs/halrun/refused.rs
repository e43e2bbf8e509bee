//! Entries of an INI file that a start does not support.

use crate::{
    Error,
    ini::{Entry, Ini},
};

const BUILT_IN: &str = "the trajectory planner is part of motmod: take the entry out";
/// The trajectory planner, as a module name.
const PLANNER: &str = "tpmod";
const BAR: &str = "write what it does into a subroutine and call that: O<name> CALL";
const NO_LINE: &str = "write a line of MDI, or take the entry out";

/// Returns an error for entries that an INI start does not support, before anything is created.
pub(crate) fn refuse(ini: &Ini) -> Result<(), Error> {
    for entry in ini.all("TRAJ", "TPMOD") {
        let module = entry.value.split_whitespace().next().unwrap_or(PLANNER);
        if module != PLANNER {
            let what = format!("{}:{}: [TRAJ]TPMOD '{module}'", entry.file, entry.line).into();
            return Err(Error::NotYet { what, instead: BUILT_IN });
        }
    }
    if operator_entry(ini).is_some() {
        for entry in ini.all("HALUI", "MDI_COMMAND") {
            let at = format!("{}:{}: [HALUI]MDI_COMMAND", entry.file, entry.line);
            // `halui` takes all lines as one argument, with bars between them.
            if entry.value.contains('|') {
                return Err(Error::NotYet { what: format!("{at} with '|'").into(), instead: BAR });
            }
            if entry.value.trim().is_empty() {
                let what = format!("{at} without a line").into();
                return Err(Error::NotYet { what, instead: NO_LINE });
            }
        }
    }
    super::realtime::of_ini(ini)?;
    super::compat::of_ini(ini).map(|_| ())
}

/// Returns the entry that asks for `halui`.
pub(super) fn operator_entry(ini: &Ini) -> Option<&Entry> {
    ini.all("HAL", "HALUI").find(|e| !e.value.is_empty())
}

#[cfg(test)]
mod tests {
    use super::refuse;
    use crate::ini::Ini;

    #[test]
    fn what_cannot_be_done_is_refused_by_name() {
        for (text, want) in [
            ("[TRAJ]\nTPMOD = mine\n", "m.ini:2: [TRAJ]TPMOD 'mine' is not supported; "),
            ("[HAL]\nSTUCK_TIME = 5\n", "m.ini:2: [HAL]STUCK_TIME '5': it is a number and "),
            (
                "[HALUI]\nMDI_COMMAND=M3\nMDI_COMMAND = (a|b) M3\n[HAL]\nHALUI = halui\n",
                "m.ini:3: [HALUI]MDI_COMMAND with '|' is not supported; ",
            ),
            (
                "[HALUI]\nMDI_COMMAND =\nMDI_COMMAND = M3\n[HAL]\nHALUI = halui\n",
                "m.ini:2: [HALUI]MDI_COMMAND without a line is not supported; ",
            ),
        ] {
            let ini = Ini::parse("m.ini", text.as_bytes()).unwrap();
            let error = refuse(&ini).unwrap_err().whole();
            assert!(error.starts_with(want), "{error}");
        }
        for good in [
            "[HAL]\nTWOPASS = on\nHALFILE = a.tcl x y\nPOSTGUI_HALFILE = b.tcl\n",
            "[HALUI]\nMDI_COMMAND = a|b\n",
            "[EMCMOT]\nHOMEMOD = homemod\n[TRAJ]\nTPMOD = tpmod\n",
            "[EMCMOT]\nHOMEMOD = mine a=1\n[TRAJ]\nTPMOD =\n",
        ] {
            assert_eq!(refuse(&Ini::parse("m", good.as_bytes()).unwrap()), Ok(()), "{good}");
        }
    }
}
