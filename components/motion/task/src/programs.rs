//! Programs of users: M100 to M199.

use crate::outside::Progress;
use std::{
    path::PathBuf,
    process::{Child, Command, Stdio},
};

/// The user's program in execution.
#[derive(Debug, Default)]
pub(crate) struct UserProgram {
    child: Option<(u16, Child)>,
}

impl UserProgram {
    /// Begins the program of a code, with its P and Q words.
    pub(crate) fn begin(
        &mut self,
        folders: &[PathBuf],
        code: u16,
        p: f64,
        q: f64,
    ) -> Result<(), String> {
        let name = format!("M{code}");
        let path = folders.iter().map(|f| f.join(&name)).find(|f| f.is_file());
        let path = path.ok_or_else(|| format!("there is no program {name}"))?;
        let path = std::path::absolute(&path).unwrap_or(path);
        let child = Command::new(path)
            .args([format!("{p:.6}"), format!("{q:.6}")])
            .stdin(Stdio::null())
            .spawn()
            .map_err(|e| format!("{name}: {}", hal_output::reason(&e)))?;
        self.child = Some((code, child));
        Ok(())
    }

    /// Returns how far the program has come; without one, it is done.
    pub(crate) fn progress(&mut self) -> Progress {
        let Some((code, child)) = &mut self.child else { return Progress::Done };
        let result = match child.try_wait() {
            Ok(None) => return Progress::Pending,
            Ok(Some(status)) if status.success() => Progress::Done,
            Ok(Some(status)) => Progress::Failed(format!("M{code} ended with {status}")),
            Err(e) => Progress::Failed(format!("M{code}: {}", hal_output::reason(&e))),
        };
        self.child = None;
        result
    }

    /// Ends the program.
    pub(crate) fn end(&mut self) {
        if let Some((_, mut child)) = self.child.take() {
            // It may have ended by itself meanwhile.
            child.kill().unwrap_or_default();
            child.wait().map(|_| ()).unwrap_or_default();
        }
    }
}

impl Drop for UserProgram {
    fn drop(&mut self) {
        self.end();
    }
}
