//! Inputs, outputs and user codes.

use super::{Run, block::Block, codes::MGroup};
use crate::{canon::Call, error::Problem, question::Request};

/// The codes of outputs as messages show them.
fn shown(code: u16) -> &'static str {
    match code {
        62 => "M62",
        63 => "M63",
        64 => "M64",
        65 => "M65",
        67 => "M67",
        _ => "M68",
    }
}

impl Run<'_> {
    pub(super) fn inputs_and_outputs(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.m(MGroup::Io) else { return Ok(None) };
        let index = |letter: u8| -> Result<Option<u32>, Problem> {
            Ok(b.integer(letter)?.and_then(|n| u32::try_from(n).ok()))
        };
        match code {
            62..=65 => {
                let index = index(b'p')?.ok_or(Problem::OutputP { code: shown(code) })?;
                let (on, with_motion) = (code.is_multiple_of(2), code < 64);
                self.emit(Call::DigitalOutput { index, on, with_motion })?;
                Ok(None)
            }
            66 => self.input(b),
            _ => {
                let index = index(b'e')?.ok_or(Problem::OutputE { code: shown(code) })?;
                let value = b.get(b'q').ok_or(Problem::OutputQ { code: shown(code) })?;
                self.emit(Call::AnalogOutput { index, value, with_motion: code == 67 })?;
                Ok(None)
            }
        }
    }

    fn input(&mut self, b: &Block) -> Result<Option<Request>, Problem> {
        let number = |letter: u8| -> Result<Option<u32>, Problem> {
            Ok(b.integer(letter)?.and_then(|n| u32::try_from(n).ok()))
        };
        let (index, analog) = match (number(b'p')?, number(b'e')?) {
            (Some(p), None) => (p, false),
            (None, Some(e)) => (e, true),
            (Some(_), Some(_)) => return Err(Problem::InputBoth),
            (None, None) => return Err(Problem::InputWords),
        };
        let Ok(mode @ 0..=4) = b.integer(b'l')?.map_or(Ok(0), u8::try_from) else {
            return Err(Problem::InputL);
        };
        if analog && mode != 0 {
            return Err(Problem::InputAnalog);
        }
        let timeout = b.get(b'q').unwrap_or(0.0);
        if timeout < 0.0 || (timeout == 0.0 && mode != 0) {
            return Err(Problem::InputQ);
        }
        if self.state.compensation.is_on() {
            let what = if analog {
                "Cannot wait for analog input"
            } else {
                "Cannot wait for digital input"
            };
            return Err(Problem::OffsetWithComp { what });
        }
        self.emit(Call::Wait { index, analog, mode, timeout })?;
        Ok(Some(Request::Input { index, analog, mode, timeout }))
    }

    pub(super) fn user_code(&mut self, b: &mut Block) -> Result<Option<Request>, Problem> {
        let Some(code) = b.m(MGroup::User) else { return Ok(None) };
        match self.env.user_code(code) {
            Ok(true) => {}
            Ok(false) => return Err(Problem::UnknownM { code: i32::from(code) }),
            Err(reason) => return Err(Problem::UserCodeRefused { code, reason }),
        }
        let (p, q) = (b.get(b'p').unwrap_or(-1.0), b.get(b'q').unwrap_or(-1.0));
        // Behind a compensated move whose end the next one decides, the program runs in its turn, unanswered.
        let waits = !self.state.compensation.holds();
        self.emit(Call::UserCode { code, p, q })?;
        Ok(waits.then_some(Request::UserCode { code, p, q }))
    }
}
