//! Load times of libraries, each measured in a process of its own.

use hal_tests::{every, machine::script, programs::programs};
use std::{collections::BTreeMap, process::Command, time::Instant};

/// Environment variable that names the load of a child process.
const CHILD: &str = "FERRULE_BENCH_LOADS";

/// Number of measurements of each; the smallest counts.
const ROUNDS: usize = 15;

/// Load times of a library.
#[derive(Debug)]
pub(crate) struct Load {
    pub(crate) library: String,
    pub(crate) components: usize,
    pub(crate) kib: u64,
    /// Load time of one of its components, in milliseconds: the first load of a process, and a later one.
    pub(crate) first: f64,
    pub(crate) again: f64,
}

/// Loads the component that the environment names, and prints the duration in nanoseconds.
pub(crate) fn child() -> bool {
    let Ok(wanted) = std::env::var(CHILD) else { return false };
    let mut engine = every::engine();
    let mut load = || {
        let begin = Instant::now();
        script(&mut engine, &format!("loadrt {wanted}"));
        let took = begin.elapsed().as_nanos();
        script(&mut engine, "unloadrt all");
        took
    };
    println!("{} {}", load(), load());
    true
}

/// Measures every library, the slowest first.
pub(crate) fn loads() -> Vec<Load> {
    let mut libraries: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for offer in every::offers() {
        libraries.entry(offer.library.clone()).or_default().push(format!(
            "{} {}",
            offer.component,
            every::ways(&offer.component)[0]
        ));
    }
    let mut all: Vec<Load> =
        libraries.into_iter().map(|(library, of)| load(library, &of)).collect();
    all.sort_by(|a, b| b.first.total_cmp(&a.first));
    all
}

fn load(library: String, of: &[String]) -> Load {
    let (mut first, mut again) = (f64::INFINITY, f64::INFINITY);
    // Motion needs kinematics.
    let wanted = of.iter().map(|w| w.replace("motmod", "trivkins\nloadrt motmod")).next().unwrap();
    for _ in 0..ROUNDS {
        let mut child = Command::new(std::env::current_exe().unwrap());
        let output =
            child.env(CHILD, &wanted).env("HAL_TEST_PROGRAMS", programs()).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        let mut ms = said.split_whitespace().map(|ns| ns.parse::<f64>().unwrap() / 1e6);
        first = first.min(ms.next().unwrap());
        again = again.min(ms.next().unwrap());
    }
    let file = programs().join(format!("lib{library}.so"));
    let kib = std::fs::metadata(file).unwrap().len() / 1024;
    Load { library, components: of.len(), kib, first, again }
}
