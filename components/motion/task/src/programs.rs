//! Programs of users: M100 to M199.

use crate::{
    error::UserProgramError,
    outside::{Progress, Rights},
};
use hal_job::user_programs::UserPrograms;
use rustix::process::{Pid, Signal, kill_process_group};
use std::{
    os::unix::process::CommandExt,
    process::{Child, Command, Stdio},
};

/// Variable that is set for programs which people start from elsewhere: the engine refuses their clients what it refuses those
/// people.
const FROM_AFAR: &str = "HAL_FROM_AFAR";
/// End of the message of such a program that has failed.
const LIMITED: &str = "; a job that was begun from afar runs it with the rights of people elsewhere, who change nothing that \
                       leads to motion or drives the machine: [REMOTE]USER_CODES = full gives it the owner's";

/// The user's program in execution.
#[derive(Debug, Default)]
pub(crate) struct UserProgram {
    child: Option<Running>,
}

#[derive(Debug)]
struct Running {
    code: u16,
    rights: Rights,
    child: Child,
}

impl UserProgram {
    /// Begins the program of a code, with its P and Q words.
    pub(crate) fn begin(
        &mut self,
        programs: &UserPrograms,
        code: u16,
        [p, q]: [f64; 2],
        rights: Rights,
    ) -> Result<(), UserProgramError> {
        let path = programs.find(code).map_err(|why| UserProgramError::NotRun { code, why })?;
        let path = path.ok_or(UserProgramError::NoProgram(code))?;
        let mut command = Command::new(path);
        if rights == Rights::FromAfar {
            command.env(FROM_AFAR, "1");
        }
        let child = command
            .args([format!("{p:.6}"), format!("{q:.6}")])
            .stdin(Stdio::null())
            .process_group(0)
            .spawn()
            .map_err(|e| UserProgramError::NotStarted {
                code,
                why: hal_output::reason(&e).into(),
            })?;
        self.child = Some(Running { code, rights, child });
        Ok(())
    }

    /// Returns how far the program has come; without one, it is done.
    pub(crate) fn progress(&mut self) -> Progress {
        let Some(Running { code, rights, child }) = &mut self.child else { return Progress::Done };
        let limited = if *rights == Rights::FromAfar { LIMITED } else { "" };
        let result = match child.try_wait() {
            Ok(None) => return Progress::Pending,
            Ok(Some(status)) if status.success() => Progress::Done,
            Ok(Some(status)) => Progress::Failed(format!("M{code} ended with {status}{limited}")),
            Err(e) => Progress::Failed(format!("M{code}: {}", hal_output::reason(&e))),
        };
        self.child = None;
        result
    }

    /// Ends the program, and the programs that it has begun.
    pub(crate) fn end(&mut self) {
        if let Some(Running { mut child, .. }) = self.child.take() {
            // The group exists until its leader was waited for; all of it may have ended by itself meanwhile.
            if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
                kill_process_group(group, Signal::KILL).unwrap_or_default();
            }
            child.wait().map(|_| ()).unwrap_or_default();
        }
    }
}

impl Drop for UserProgram {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fs, io::Read, os::unix::fs::PermissionsExt};

    #[test]
    fn the_programs_of_a_program_end_with_it() {
        let folder = std::env::temp_dir().join(format!("hal-task-group-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let fifo = folder.join("fifo");
        assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let code = folder.join("M101");
        let text = format!("#!/bin/sh\n(sleep 9; echo alive) > '{}' &\nwait\n", fifo.display());
        fs::write(&code, text).unwrap();
        fs::set_permissions(&code, fs::Permissions::from_mode(0o755)).unwrap();
        let mut program = UserProgram::default();
        let programs = UserPrograms::new(vec![folder.clone()], None);
        program.begin(&programs, 101, [0.0; 2], Rights::Owner).unwrap();
        // The pipe opens when the second program does, and ends when nobody has it open.
        let mut pipe = fs::File::open(&fifo).unwrap();
        assert_eq!(program.progress(), Progress::Pending);
        program.end();
        let mut said = String::new();
        pipe.read_to_string(&mut said).unwrap();
        assert_eq!(said, "");
        fs::remove_dir_all(&folder).unwrap();
    }
}
