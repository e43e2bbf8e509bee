//! `meter`: one value, big; or the choice of one.

use crate::{
    Error, Session, screen,
    watch::{Watch, look},
};

impl Session<'_> {
    /// `meter`. Without a screen it is `watch`.
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
