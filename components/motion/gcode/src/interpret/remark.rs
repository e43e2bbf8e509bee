//! Comments with a meaning.

use super::{Run, block::Block};
use crate::{
    canon::Call,
    error::Problem,
    parameters::{number, system::Reader},
    question::Request,
    text::comment::{self, Kind},
};

impl Run<'_> {
    pub(super) fn remark(&mut self, block: &mut Block) -> Result<Option<Request>, Problem> {
        let Some((kind, text)) = block.remark.take() else { return Ok(None) };
        let kinds = comment::KINDS.iter().map(|(_, k)| *k);
        let kind = kinds.into_iter().find(|k| *k as u8 == kind).unwrap_or(Kind::Plain);
        let reader = Reader { state: &*self.state, environment: self.env };
        let expanded = || -> Box<str> { comment::expand(&text, &reader).into() };
        let trimmed: Box<str> = text.trim().into();
        let call = match kind {
            Kind::Plain => Call::Comment(text),
            Kind::Message => Call::Message(text),
            Kind::Debug if self.state.numbered.get(number::DEBUG) <= 0.0 => return Ok(None),
            Kind::Debug => Call::Message(expanded()),
            Kind::Print => Call::Print(expanded()),
            Kind::Log => Call::Log(expanded()),
            Kind::LogOpen => Call::LogOpen { name: trimmed, append: false },
            Kind::LogAppend => Call::LogOpen { name: trimmed, append: true },
            Kind::LogClose => Call::LogClose,
            Kind::ProbeOpen => {
                self.state.probe_file = true;
                Call::ProbeOpen(trimmed)
            }
            Kind::ProbeClose => {
                self.state.probe_file = false;
                Call::ProbeClose
            }
            Kind::Python => return Err(Problem::PythonComment),
            Kind::Abort => return Err(Problem::UserAbort { text: expanded() }),
        };
        self.emit(call)?;
        Ok(None)
    }
}
