//! The process of functions, and the lines of JSON that go to it and come from it.

use crate::setup::Setup;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    process::{Pid, Signal, kill_process_group},
};
use std::{
    io::{Read, Write},
    os::unix::process::CommandExt,
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
    time::Duration,
};

/// Modules of the process, the first one first.
const MODULES: [(&str, &str); 3] = [
    ("_ferrule_remap", include_str!("../python/driver.py")),
    ("interpreter", include_str!("../python/interpreter.py")),
    ("emccanon", include_str!("../python/emccanon.py")),
];
/// Makes these modules, and begins.
const BEGIN: &str = "\
import json, sys, types
for name, text in json.loads(sys.stdin.buffer.readline()):
    module = sys.modules[name] = types.ModuleType(name)
    exec(compile(text, '<ferrule ' + name + '>', 'exec'), module.__dict__)
sys.modules['_ferrule_remap'].main()
";
/// Variable with the reason why programs do not connect to the instance, as clients read it.
const NO_CLIENTS: &str = "HAL_NO_CLIENTS";
const STANDS_STILL: &str = "on the virtual clock the instance stands still until the function ends, and answers nothing: use the real clock, or #<_hal[NAME]> before the call";
/// Longest line in bytes.
const MAX_LINE: usize = 1 << 24;
/// Time for the last words of a process whose input has ended.
const LAST_WORDS: Duration = Duration::from_millis(1500);

/// A process of functions.
#[derive(Debug)]
pub(crate) struct Process {
    child: Child,
    input: Option<ChildStdin>,
    output: ChildStdout,
    /// Bytes that were read and are no whole line yet.
    read: Vec<u8>,
}

impl Process {
    /// Starts the process and tells it about the machine.
    pub(crate) fn start(setup: &Setup) -> Result<Self, String> {
        let mut command = Command::new("python3");
        command.args(["-c", BEGIN]).current_dir(&setup.folder).process_group(0);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        if let Some(path) = path_of_modules() {
            command.env("PYTHONPATH", path);
        }
        if setup.stands_still {
            command.env(NO_CLIENTS, STANDS_STILL);
        }
        let mut child =
            command.spawn().map_err(|e| format!("python3: {}", hal_output::reason(&e)))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("python3 has no pipes".to_owned());
        };
        let mut out = Self { child, input: Some(input), output, read: Vec::new() };
        out.send(&serde_json::to_string(&MODULES).map_err(|e| e.to_string())?)?;
        out.send(&serde_json::to_string(setup).map_err(|e| e.to_string())?)?;
        Ok(out)
    }

    /// Sends a line.
    pub(crate) fn send(&mut self, line: &str) -> Result<(), String> {
        let input = self.input.as_mut().ok_or("its input has ended")?;
        let sent = input.write_all(line.as_bytes()).and_then(|()| input.write_all(b"\n"));
        sent.map_err(|_| self.end())
    }

    /// Waits this long for a line. `None` without one.
    pub(crate) fn line(&mut self, wait: Duration) -> Result<Option<Vec<u8>>, String> {
        loop {
            if let Some(end) = self.read.iter().position(|b| *b == b'\n') {
                let rest = self.read.split_off(end + 1);
                let mut line = core::mem::replace(&mut self.read, rest);
                line.pop();
                return Ok(Some(line));
            }
            if self.read.len() > MAX_LINE {
                return Err("its answer is too long".to_owned());
            }
            if !self.is_readable(wait) {
                return Ok(None);
            }
            let mut buffer = vec![0; 1 << 16];
            match self.output.read(&mut buffer) {
                Ok(0) => return Err(self.end()),
                Ok(n) => self.read.extend_from_slice(buffer.get(..n).unwrap_or_default()),
                Err(e) => return Err(hal_output::reason(&e)),
            }
        }
    }

    fn is_readable(&self, wait: Duration) -> bool {
        let mut fds = [PollFd::new(&self.output, PollFlags::IN)];
        let wait = Timespec::try_from(wait).ok();
        poll(&mut fds, wait.as_ref()).is_ok_and(|n| n > 0)
    }

    /// Ends the process and all that it has begun, and says how it ended.
    pub(crate) fn end(&mut self) -> String {
        self.input = None;
        if let Some(group) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw)
            && !matches!(self.child.try_wait(), Ok(Some(_)))
        {
            kill_process_group(group, Signal::KILL).unwrap_or_default();
        }
        let ended = self.child.wait();
        ended.map_or_else(
            |e| format!("the process of the functions: {}", hal_output::reason(&e)),
            |status| format!("the process of the functions has ended: {status}"),
        )
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if self.input.take().is_some() {
            // Its output ends with it.
            while let Ok(Some(_)) = self.line(LAST_WORDS) {}
        }
        self.end();
    }
}

/// Returns the path on which Python looks for modules: Ferrule's own beside the program that runs, and those of the user.
fn path_of_modules() -> Option<std::ffi::OsString> {
    let own = std::env::current_exe().ok()?.parent()?.join("python");
    let before = std::env::var_os("PYTHONPATH").filter(|path| !path.is_empty());
    let paths = before.iter().flat_map(std::env::split_paths).chain([own]);
    std::env::join_paths(paths).ok()
}
