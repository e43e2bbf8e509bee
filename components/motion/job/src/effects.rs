//! The effects of a program that the state of the interpreter does not have.

use hal_gcode::{Call, Issued};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Number of user codes that are noted.
const MAX_CODES: usize = 100;

/// The effects of the lines before a place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effects {
    /// Outputs that the program has set.
    pub outputs: Outputs,
    /// User codes (M100 to M199) that the program has run.
    pub user_codes: UserCodes,
    /// Name of the file of `LOGOPEN` or `LOGAPPEND`, while it is open.
    pub log: Option<Box<str>>,
    /// Name of the file of `PROBEOPEN`, while it is open.
    pub probe: Option<Box<str>>,
}

/// Outputs that the program has set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outputs {
    /// Digital ones, by number.
    pub digital: BTreeMap<u32, bool>,
    /// Analog ones, by number.
    pub analog: BTreeMap<u32, f64>,
}

/// User codes, each line of a code once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UserCodes {
    /// The first ones in the order of execution: code and line.
    pub known: Vec<(u16, u32)>,
    /// There were more than are known.
    pub more: bool,
}

impl Effects {
    /// Notes the effect of a call.
    pub fn note(&mut self, issued: &Issued) {
        match &issued.call {
            Call::DigitalOutput { index, on, .. } => {
                self.outputs.digital.insert(*index, *on);
            }
            Call::AnalogOutput { index, value, .. } => {
                self.outputs.analog.insert(*index, *value);
            }
            Call::UserCode { code, .. } => self.user_codes.add(*code, issued.line),
            Call::LogOpen { name, .. } => self.log = Some(name.clone()),
            Call::LogClose => self.log = None,
            Call::ProbeOpen(name) => self.probe = Some(name.clone()),
            Call::ProbeClose => self.probe = None,
            _ => {}
        }
    }
}

impl UserCodes {
    fn add(&mut self, code: u16, line: u32) {
        if self.known.contains(&(code, line)) {
            return;
        }
        if self.known.len() < MAX_CODES {
            self.known.push((code, line));
        } else {
            self.more = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_of_user_codes_is_noted_once_and_a_long_program_in_part() {
        let mut effects = Effects::default();
        let mut run = |line| {
            let call = Call::UserCode { code: 101, p: 0.0, q: 0.0 };
            effects.note(&Issued { number: None, call, line });
        };
        (0..1000).for_each(|_| run(7));
        (1..=1000).for_each(run);
        let codes = effects.user_codes;
        assert_eq!((codes.known.len(), codes.more), (MAX_CODES, true));
        assert_eq!(codes.known[..3], [(101, 7), (101, 1), (101, 2)]);
    }
}
