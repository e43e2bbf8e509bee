//! The process of functions, and the lines of JSON that go to it and come from it.

use crate::setup::Setup;
use rustix::{
    event::{PollFd, PollFlags, Timespec, poll},
    io::{Errno, ioctl_fionbio},
    process::{Pid, Signal, kill_process_group},
};
use std::{
    io::Read,
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

/// Output of a process since the last look.
#[derive(Debug)]
pub(crate) enum Sent {
    /// Nothing.
    Nothing,
    /// A part of a line; or it has taken a part of what was sent to it.
    Part,
    /// A line.
    Line(Vec<u8>),
}

/// A process of functions.
#[derive(Debug)]
pub(crate) struct Process {
    child: Child,
    input: Option<ChildStdin>,
    output: ChildStdout,
    /// Lines that the process has not taken as a whole, and the number of bytes that it has.
    unsent: Vec<u8>,
    sent: usize,
    /// Bytes that were read and are no whole line yet.
    read: Vec<u8>,
    /// The number of bytes of `read` that have no end of a line in them.
    searched: usize,
    /// The end of the process is known, and its number may belong to another one.
    has_ended: bool,
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
        // A process that does not read must not stop its host.
        ioctl_fionbio(&input, true).map_err(|e| e.to_string())?;
        let mut out = Self {
            child,
            input: Some(input),
            output,
            unsent: Vec::new(),
            sent: 0,
            read: Vec::new(),
            searched: 0,
            has_ended: false,
        };
        out.send(&serde_json::to_string(&MODULES).map_err(|e| e.to_string())?)?;
        out.send(&serde_json::to_string(setup).map_err(|e| e.to_string())?)?;
        Ok(out)
    }

    /// Sends a line: as much as the process takes now, and the rest while its answer is waited for.
    pub(crate) fn send(&mut self, line: &str) -> Result<(), String> {
        self.unsent.extend_from_slice(line.as_bytes());
        self.unsent.push(b'\n');
        self.write()
    }

    fn write(&mut self) -> Result<(), String> {
        let input = self.input.as_ref().ok_or("its input has ended")?;
        loop {
            let rest = self.unsent.get(self.sent..).unwrap_or_default();
            if rest.is_empty() {
                self.unsent.clear();
                self.sent = 0;
                return Ok(());
            }
            match rustix::io::write(input, rest) {
                Ok(n) => self.sent += n,
                Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => return Ok(()),
                Err(_) => return Err(self.end()),
            }
        }
    }

    /// Waits this long for bytes of a line, and for the process to take what is left of the last one.
    pub(crate) fn line(&mut self, wait: Duration) -> Result<Sent, String> {
        if let Some(line) = self.take_line() {
            return Ok(Sent::Line(line));
        }
        match self.poll(wait) {
            (true, _) => {}
            (false, true) => return self.write().map(|()| Sent::Part),
            (false, false) => return Ok(Sent::Nothing),
        }
        if self.read.len() > MAX_LINE {
            return Err("its answer is too long".to_owned());
        }
        let mut buffer = vec![0; 1 << 16];
        match self.output.read(&mut buffer) {
            Ok(0) => Err(self.end()),
            Ok(n) => {
                self.read.extend_from_slice(buffer.get(..n).unwrap_or_default());
                Ok(self.take_line().map_or(Sent::Part, Sent::Line))
            }
            Err(e) => Err(hal_output::reason(&e)),
        }
    }

    fn take_line(&mut self) -> Option<Vec<u8>> {
        let new = self.read.get(self.searched..).unwrap_or_default();
        let Some(end) = new.iter().position(|b| *b == b'\n') else {
            self.searched = self.read.len();
            return None;
        };
        let rest = self.read.split_off(self.searched + end + 1);
        let mut line = core::mem::replace(&mut self.read, rest);
        line.pop();
        self.searched = 0;
        Some(line)
    }

    /// Waits this long until the process has sent bytes, or takes some that are left.
    fn poll(&self, wait: Duration) -> (bool, bool) {
        let mut fds = vec![PollFd::new(&self.output, PollFlags::IN)];
        if let Some(input) = self.input.as_ref().filter(|_| !self.unsent.is_empty()) {
            fds.push(PollFd::new(input, PollFlags::OUT));
        }
        let wait = Timespec::try_from(wait).ok();
        if !poll(&mut fds, wait.as_ref()).is_ok_and(|n| n > 0) {
            return (false, false);
        }
        let mut is_ready = fds.iter().map(|fd| !fd.revents().is_empty());
        (is_ready.next() == Some(true), is_ready.next() == Some(true))
    }

    /// Ends the process and all that it has begun, and says how it ended.
    pub(crate) fn end(&mut self) -> String {
        self.input = None;
        // Until its end is asked for, the number of the group belongs to no other process, even if its leader has ended.
        if !self.has_ended
            && let Some(group) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw)
        {
            kill_process_group(group, Signal::KILL).unwrap_or_default();
            self.child.kill().unwrap_or_default();
        }
        self.has_ended = true;
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
            self.unsent.clear();
            // Its output ends with it.
            while self.poll(LAST_WORDS).0 && self.line(Duration::ZERO).is_ok() {}
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    /// A process whose top level is this script, and the folder of the script.
    fn process(name: &str, script: &str) -> (Process, PathBuf) {
        let folder = std::env::temp_dir().join(format!("hal-remap-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let toplevel = folder.join("top.py");
        std::fs::write(&toplevel, script).unwrap();
        let setup = Setup {
            folder: folder.clone(),
            prepend: Vec::new(),
            append: Vec::new(),
            toplevel: Some(toplevel),
            task: 0,
            timeout: Duration::from_secs(10),
            stands_still: false,
        };
        (Process::start(&setup).unwrap(), folder)
    }

    /// Tells whether a process is in one of these states; the states of one that is gone are `Z`.
    fn is(pid: &str, states: &str) -> bool {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        let state = stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next());
        states.contains(state.unwrap_or('Z'))
    }

    #[test]
    fn a_process_that_does_not_read_does_not_stop_its_host() {
        let stop = "import os, signal\nos.kill(os.getpid(), signal.SIGSTOP)\n";
        let (mut process, folder) = process("stopped", stop);
        let pid = process.child.id().to_string();
        while !is(&pid, "T") {
            process.line(Duration::from_millis(10)).unwrap();
        }
        process.send(&" ".repeat(1 << 20)).unwrap();
        assert!(matches!(process.line(Duration::from_millis(1)), Ok(Sent::Nothing)));
        assert!(process.end().contains("SIGKILL"));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn long_lines_go_and_come_in_parts() {
        let (mut process, folder) = process(
            "long",
            "import _ferrule_remap as host\nhost._send(len(host._messages.get()) * 'x')\n",
        );
        process.send(&format!("\"{}\"", "y".repeat(3_000_000))).unwrap();
        let mut parts = 0;
        let line = loop {
            match process.line(Duration::from_secs(1)).unwrap() {
                Sent::Nothing => {}
                Sent::Part => parts += 1,
                Sent::Line(line) => break line,
            }
        };
        assert_eq!(line.len(), 3_000_002);
        assert!(parts > 40, "{parts}");
        process.end();
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_a_process_has_begun_ends_with_it() {
        let (mut process, folder) = process(
            "child",
            "import os, subprocess\nchild = subprocess.Popen(['sleep', '300'])\n\
             open('pid', 'w').write(str(child.pid))\nos._exit(3)\n",
        );
        let why = loop {
            match process.line(Duration::from_secs(1)) {
                Ok(_) => {}
                Err(why) => break why,
            }
        };
        assert_eq!(why, "the process of the functions has ended: exit status: 3");
        let child = std::fs::read_to_string(folder.join("pid")).unwrap();
        let mut looks = 0;
        while !is(&child, "ZX") {
            looks += 1;
            assert!(looks < 1000, "the child lives on");
            let wait = Timespec::try_from(Duration::from_millis(10)).ok();
            poll(&mut [], wait.as_ref()).unwrap();
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
