//! A machine and its panel, as two programs.

use hal_tests::scratch::{Running, Scratch, until};
use rustix::process::Signal;

/// The two programs. Both end with it, and a test that fails reports their messages; a wait fails at once if one of them ends
/// by itself.
#[derive(Debug)]
pub(super) struct Pair {
    pub(super) machine: Running,
    pub(super) panel: Running,
}

/// Prints a part of the report of a test that fails.
#[expect(clippy::print_stderr, reason = "the report of a test that fails")]
pub(super) fn report(text: &str) {
    eprintln!("{text}");
}

/// Starts a machine by halrun with these arguments, and waits until a command of halcmd succeeds there.
pub(super) fn machine(scratch: &Scratch, words: &[&str], answers: &str) -> Running {
    let mut command = scratch.command(&[], "halrun");
    let machine = scratch.start(command.args(words)).lasting("the machine");
    let answers: Vec<&str> = answers.split(' ').collect();
    until("the machine runs", || scratch.halcmd(&answers).status == Some(0));
    machine
}

/// Starts a panel whose sessions have this role, with further options.
pub(super) fn panel(scratch: &Scratch, role: &str, options: &[&str]) -> Running {
    plain_panel(scratch, &[&["--role", role], options].concat())
}

/// Starts a panel with these options, and the role that it gives by itself where they name none.
pub(super) fn plain_panel(scratch: &Scratch, options: &[&str]) -> Running {
    let mut command = scratch.command(&[], "halpanel");
    command.args(["--listen", "127.0.0.1:0"]);
    command.args(["--address-file", "address", "--audit", &scratch.private("audit")]);
    command.args(options);
    scratch.start(&mut command).lasting("the panel")
}

impl Pair {
    /// Ends the machine, while the panel goes on.
    pub(super) fn end_machine(&mut self) {
        self.machine.signal(Signal::TERM);
        self.machine.ended().unwrap();
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        let Self { machine, panel } = self;
        for program in [&mut *panel, machine] {
            if program.is_running() {
                program.signal(Signal::TERM);
            }
        }
        until("the programs end", || !machine.is_running() && !panel.is_running());
        if std::thread::panicking() {
            report(&format!("the machine said: {}", machine.said().1));
            report(&format!("the panel said: {}", panel.said().1));
        }
    }
}
