//! `meter`: a large display of one value, or the selection of one.

use crate::{Error, Session, language::command::Watch, show::watch::look, terminal::screen};

impl Session<'_> {
    /// Executes `meter`. Without a screen it does the same as `watch`.
    pub(crate) fn meter(&mut self, name: Option<String>) -> Result<(), Error> {
        if let Some(name) = &name
            && look(self.link, core::slice::from_ref(name))?.seen.is_empty()
        {
            return Err(self.nothing(core::slice::from_ref(name)));
        }
        if self.terminal.is_screen() && !self.style.json && !self.style.script {
            return screen::meter(self.link, name);
        }
        let name = name.ok_or(Error::NoScreen)?;
        self.watch(&Watch { patterns: vec![name], every_ms: 200, count: None })
    }
}
