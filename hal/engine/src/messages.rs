//! Messages of components and of the engine: the control side takes them, joins those of the same
//! site, logs them, and keeps them until they are read.

pub(crate) mod join;
pub(crate) mod log;
pub(crate) mod mailbox;
pub(crate) mod text;

use crate::Engine;

impl Engine {
    /// Logs a message of the engine itself.
    pub(crate) fn notice(&mut self, text: String) {
        self.log.notice(text);
    }

    /// Logs messages of the engine itself.
    pub(crate) fn notices(&mut self, texts: Vec<String>) {
        texts.into_iter().for_each(|text| self.log.notice(text));
    }

    /// Returns the messages of components and of the engine since the last call. They are logged as
    /// well.
    pub fn take_messages(&mut self) -> Vec<String> {
        self.drain_messages();
        self.log.take()
    }

    /// Logs the messages of components.
    pub(crate) fn drain_messages(&mut self) {
        self.log.drain_messages(self.runtime.shared(), self.model.graph(), self.model.departed());
    }
}
