//! The end of programs whose test was killed: nothing else would end them then.

use std::{
    io::Write as _,
    os::unix::process::CommandExt as _,
    process::{Child, Command, Stdio},
    sync::{Mutex, OnceLock, PoisonError},
};

/// Reads which programs begin (`+ PID`) and have ended (`- PID`). The end of its input is the end of the tests, however
/// they ended: then it kills the programs that are left, and what those have started. The system also has a signal
/// for this, but that follows the thread that started a program, and does not reach what the program starts.
const SCRIPT: &str = "\
all=' '
while read -r sign pid; do
  case $sign in
    +) all=\"$all$pid \" ;;
    -) all=\"${all%% $pid *} ${all#* $pid }\" ;;
  esac
done
end() {
  kill -STOP \"$1\" 2>/dev/null
  for child in $(cat /proc/\"$1\"/task/*/children 2>/dev/null); do end \"$child\"; done
  kill -KILL \"$1\" 2>/dev/null
}
for pid in $all; do end \"$pid\"; done";

/// Tells the guard that a program of the tests has begun (`+`) or ended (`-`).
pub(crate) fn note(sign: char, pid: u32) {
    static GUARD: OnceLock<Mutex<Child>> = OnceLock::new();
    let guard = GUARD.get_or_init(|| {
        // A group of its own: what ends the tests at the terminal leaves it.
        let mut command = Command::new("sh");
        command.args(["-c", SCRIPT]).process_group(0);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
        Mutex::new(command.spawn().unwrap())
    });
    let mut guard = guard.lock().unwrap_or_else(PoisonError::into_inner);
    // Without it a test is the same.
    if let Some(pipe) = &mut guard.stdin {
        drop(pipe.write_all(format!("{sign} {pid}\n").as_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use crate::{programs::own_test, scratch::Scratch, scratch::until};
    use rustix::process::Signal;
    use std::{fs, process::Command};

    #[test]
    fn programs_end_with_a_test_that_is_killed() {
        let key = "HAL_TEST_TO_KILL";
        let scratch = Scratch::new("guard");
        if let Some(file) = std::env::var_os(key) {
            // A program that has started another, as chromedriver has.
            let script = "sleep 1000 & echo $$ $! > pids.new; mv pids.new \"$0\"; wait";
            let _running = scratch.start(Command::new("sh").args(["-c", script]).arg(file));
            loop {
                std::thread::park();
            }
        }
        let pids = scratch.path().join("pids");
        let mut again = Command::new(std::env::current_exe().unwrap());
        again.arg(own_test(module_path!(), "programs_end_with_a_test_that_is_killed"));
        let test = scratch.start(again.env(key, &pids));
        until("the programs run", || pids.is_file());
        let pids = scratch.read("pids");
        let runs =
            |pid| fs::read(format!("/proc/{pid}/cmdline")).is_ok_and(|line| !line.is_empty());
        assert!(pids.split_whitespace().count() == 2 && pids.split_whitespace().all(runs));
        test.signal(Signal::KILL);
        until("the programs end", || !pids.split_whitespace().any(runs));
    }
}
