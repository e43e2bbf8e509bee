//! Whole programs: ours, and LinuxCNC's for comparison.

pub(crate) use hal_tests::foreign::peer;
use std::{
    fmt::Write,
    path::PathBuf,
    process::{Command, Stdio},
    time::Duration,
};

/// Number of gates in a chain.
pub(crate) const CHAIN: usize = 800;

/// Returns the folder of the programs that `cargo build --release` built.
pub(crate) fn programs() -> PathBuf {
    let me = std::env::current_exe().unwrap();
    me.parent().and_then(|deps| deps.parent()).unwrap().to_owned()
}

/// Returns a chain of gates as a script for both systems, given the load command and the gates' name.
pub(crate) fn chain_script(load: &str, name: &str) -> String {
    let mut s = String::from("loadrt threads name1=t period1=1000000\n");
    writeln!(s, "{load} count={CHAIN}").unwrap();
    (0..CHAIN).for_each(|i| writeln!(s, "addf {name}.{i} t").unwrap());
    for i in 1..CHAIN {
        let from = i - 1;
        writeln!(s, "net s{i} {name}.{from}.out {name}.{i}.in0 {name}.{i}.in1").unwrap();
    }
    s.push_str("start\n");
    s
}

/// Returns the nanoseconds per function according to the thread's own time pin: the minimum of ten reads after the
/// program has started.
pub(crate) fn account(halcmd: &dyn Fn() -> Command) -> Option<f64> {
    let look = || {
        std::thread::park_timeout(Duration::from_millis(100));
        let out = halcmd().args(["getp", "t.time"]).output().ok()?;
        let text = String::from_utf8(out.stdout).ok()?;
        text.trim().parse::<f64>().ok().filter(|t| *t > 0.0)
    };
    let looks: Vec<f64> = (0..200).filter_map(|_| look()).take(10).collect();
    looks.into_iter().reduce(f64::min).map(|t| t / CHAIN as f64)
}

/// Starts a script, measures while it runs, and ends it.
pub(crate) fn while_running<R>(
    mut halrun: Command,
    end: &dyn Fn() -> Command,
    f: impl Fn() -> R,
) -> Option<R> {
    let null = || Stdio::null();
    let mut child = halrun.stdin(Stdio::piped()).stdout(null()).stderr(null()).spawn().ok()?;
    std::thread::park_timeout(Duration::from_secs(2));
    let r = f();
    drop(end().stdout(null()).stderr(null()).status());
    drop(child.stdin.take());
    std::thread::park_timeout(Duration::from_millis(300));
    drop(child.kill());
    drop(child.wait());
    Some(r)
}
