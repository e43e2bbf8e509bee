//! Files that lines source.

use super::{Outcome, Session};
use crate::{Bytes, Error, language::lex::Reader};

/// Maximum nesting of sourced files.
const MAX_DEPTH: u32 = 64;
/// Maximum number of files that one file sources, with those that they source.
const MAX_SOURCED: u32 = 10_000;

impl Session<'_> {
    /// Executes the lines of another file.
    pub(crate) fn source(&mut self, path: &str) -> Result<(), Error> {
        if self.depth >= MAX_DEPTH {
            return Err(Error::TooDeep { path: path.into() });
        }
        if self.depth == 0 {
            self.sourced = 0;
        }
        self.sourced += 1;
        if self.sourced > MAX_SOURCED {
            return Err(Error::TooManySourced { path: path.into() });
        }
        let found = self.found_at(path);
        if self.is_first_look && found.exists() && !found.is_file() {
            // A pipe can be read only once.
            self.doubt_what_follows(path);
            return Ok(());
        }
        let text = hal_ini::file::whole(&found)
            .map_err(|e| Error::NoFile { path: path.into(), why: crate::ini::plain(&e) })?;
        let before = self.place.clone();
        self.depth += 1;
        let outcome = self.read(path, Reader::plain(Bytes::new(text)), true);
        self.depth -= 1;
        self.stand_at(&before.0, before.1);
        if outcome == Outcome::Good { Ok(()) } else { Err(Error::AlreadyReported) }
    }
}
