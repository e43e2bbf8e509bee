//! A terminal with a program in it, for tests that type when a text appears.

use crate::scratch::Scratch;
use rustix::{
    event::{PollFd, PollFlags, poll},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
    termios::{LocalModes, Winsize, tcgetattr, tcsetwinsize},
    time::Timespec,
};
use std::{
    fs::File,
    os::fd::OwnedFd,
    process::{Child, Stdio},
};

/// A pseudo-terminal with a running program.
#[derive(Debug)]
pub struct Terminal {
    keys: OwnedFd,
    /// The program's end, kept open so that the terminal's settings can be read after the program has ended.
    screen: OwnedFd,
    child: Child,
    /// Output that was shown but not yet examined.
    shown: String,
}

impl Terminal {
    /// Starts a program in a terminal of its own.
    pub fn start(scratch: &Scratch, program: &str, words: &[&str]) -> Self {
        let keys = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&keys).unwrap();
        unlockpt(&keys).unwrap();
        let size = Winsize { ws_row: 24, ws_col: 100, ws_xpixel: 0, ws_ypixel: 0 };
        tcsetwinsize(&keys, size).unwrap();
        let name = ptsname(&keys, Vec::new()).unwrap().into_string().unwrap();
        let screen = || OwnedFd::from(File::options().read(true).write(true).open(&name).unwrap());
        let end = || Stdio::from(screen());
        let mut command = scratch.command(&[], program);
        command.args(words).stdin(end()).stdout(end()).stderr(end());
        command.env("TERM", "xterm").env("HOME", scratch.path()).env_remove("XDG_STATE_HOME");
        // The program echoes input letter by letter, without hints in between.
        command.env("NO_COLOR", "1");
        let child = command.spawn().unwrap();
        Self { keys, screen: screen(), child, shown: String::new() }
    }

    /// Sends keystrokes.
    pub fn keys(&mut self, keys: &str) {
        rustix::io::write(&self.keys, keys.as_bytes()).unwrap();
    }

    /// Waits until this text is shown; returns the output up to its end.
    ///
    /// # Panics
    /// The program ends before the text appears.
    pub fn until(&mut self, text: &str) -> String {
        loop {
            if let Some(at) = self.shown.find(text) {
                let rest = self.shown.split_off(at + text.len());
                return core::mem::replace(&mut self.shown, rest);
            }
            let ended = !self.look(100) && self.child.try_wait().unwrap().is_some();
            assert!(!ended, "ended before {text:?} was shown; what was: {:?}", self.shown);
        }
    }

    /// Waits until the program has ended; returns its exit status, whether the terminal's settings are restored, and
    /// the remaining output.
    pub fn end(mut self) -> (Option<i32>, bool, String) {
        let status = loop {
            self.look(10);
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
        };
        while self.look(0) {}
        let modes = tcgetattr(&self.screen).unwrap().local_modes;
        let sane = modes.contains(LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG);
        (status.code(), sane, core::mem::take(&mut self.shown))
    }

    /// Returns the process id of the program.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Reads output for up to this many milliseconds; returns false if there was none.
    fn look(&mut self, ms: i64) -> bool {
        let mut fds = [PollFd::new(&self.keys, PollFlags::IN)];
        let wait = Timespec { tv_sec: 0, tv_nsec: ms * 1_000_000 };
        if poll(&mut fds, Some(&wait)).unwrap_or(0) == 0 {
            return false;
        }
        let mut chunk = [0; 4096];
        let n = rustix::io::read(&self.keys, &mut chunk).unwrap_or(0);
        self.shown.push_str(&String::from_utf8_lossy(chunk.get(..n).unwrap_or(&[])));
        n > 0
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            drop(self.child.kill());
            drop(self.child.wait());
        }
    }
}
