//! Programs that must run as long as their test waits for something: without them, nothing comes any more.

use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
use std::{cell::RefCell, fs, path::PathBuf};

/// Program that a test needs, with the file of its standard error.
struct Needed {
    name: &'static str,
    pid: u32,
    said: PathBuf,
}

thread_local! {
    /// Programs that the test of this thread needs.
    static ALL: RefCell<Vec<Needed>> = const { RefCell::new(Vec::new()) };
}

/// Adds a program, whose parent is this process.
pub(crate) fn add(name: &'static str, pid: u32, said: PathBuf) {
    ALL.with_borrow_mut(|all| all.push(Needed { name, pid, said }));
}

/// Removes a program, which may end from now on.
pub(crate) fn remove(pid: u32) {
    ALL.with_borrow_mut(|all| all.retain(|needed| needed.pid != pid));
}

/// Returns what has ended too early, and its last words.
pub(crate) fn ended() -> Option<String> {
    ALL.with_borrow(|all| {
        all.iter().find_map(|Needed { name, pid, said }| {
            let pid = Pid::from_raw(i32::try_from(*pid).ok()?)?;
            // Its status stays for the one who waits for it; a process that is no child any more has none.
            let look = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
            waitid(WaitId::Pid(pid), look).ok()??;
            Some(format!("{name} has ended: {}", fs::read_to_string(said).unwrap_or_default()))
        })
    })
}

#[cfg(test)]
mod tests {
    use crate::scratch::{Scratch, until};
    use rustix::process::Signal;
    use std::{panic::catch_unwind, process::Command};

    #[test]
    fn a_wait_ends_with_the_program_that_it_needs() {
        let scratch = Scratch::new("lasting");
        let start =
            |script| scratch.start(Command::new("sh").args(["-c", script])).lasting("the machine");
        let mut running = start("echo no port >&2; exit 3");
        let why = catch_unwind(|| until("the page is there", || false)).unwrap_err();
        let why = why.downcast_ref::<String>().unwrap();
        assert_eq!(why, "the page is there: the machine has ended: no port\n");
        // Who waits for its end has its status, and from then on nothing needs it.
        assert_eq!(running.ended().unwrap().code(), Some(3));
        let mut looks = 0;
        let mut thrice = || {
            looks += 1;
            looks % 3 == 0
        };
        until("two looks pass", &mut thrice);
        // One that the test itself ends may end.
        let running = start("sleep 1000");
        running.signal(Signal::TERM);
        until("it has ended, and two looks pass", &mut thrice);
        assert_eq!(running.wait().status, None);
    }
}
