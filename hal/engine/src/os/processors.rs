//! Processors: those that exist, those isolated for realtime, and their idle states.

use std::{fs::File, io::Write};

/// Returns the processors that this process may use by default.
pub(crate) fn cpus() -> Vec<usize> {
    let Ok(set) = rustix::thread::sched_getaffinity(None) else { return Vec::new() };
    (0..rustix::thread::CpuSet::MAX_CPU).filter(|c| set.is_set(*c)).collect()
}

/// Returns the processors that the kernel keeps free (`isolcpus=`). No process is started on them,
/// and they are not among [`cpus`], but a thread may move there.
pub(crate) fn isolated() -> Vec<usize> {
    listed(&std::fs::read_to_string("/sys/devices/system/cpu/isolated").unwrap_or_default())
}

/// Returns the processors that are online, as the kernel writes them (`0-3`).
pub(crate) fn online() -> String {
    let list = std::fs::read_to_string("/sys/devices/system/cpu/online").unwrap_or_default();
    list.trim().to_owned()
}

/// Reads a list such as `1,4-6`.
fn listed(text: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    text.trim()
        .split(',')
        .filter_map(range)
        .flatten()
        .take(rustix::thread::CpuSet::MAX_CPU)
        .collect()
}

/// Returns whether a thread of this process may run on a processor, by trying it on a thread that
/// ends at once.
pub(crate) fn may_use(cpu: usize) -> bool {
    std::thread::spawn(move || stay_on(cpu)).join().unwrap_or(false)
}

/// Binds this thread to one processor. Returns whether the system accepts it.
pub(crate) fn stay_on(cpu: usize) -> bool {
    stay_among(&[cpu])
}

/// Binds this thread to some processors. Returns whether the system accepts it.
pub(crate) fn stay_among(cpus: &[usize]) -> bool {
    let mut set = rustix::thread::CpuSet::new();
    for cpu in cpus.iter().filter(|c| **c < rustix::thread::CpuSet::MAX_CPU) {
        set.set(*cpu);
    }
    rustix::thread::sched_setaffinity(None, &set).is_ok()
}

/// The file that accepts the longest permitted wake-up time.
const IDLE_LATENCY: &str = "/dev/cpu_dma_latency";

/// Requests that no processor sleeps so deeply that waking takes more than `us` microseconds, as
/// long as the returned file is open.
pub(crate) fn hold_idle_latency(us: u32) -> Result<File, Box<str>> {
    let refused =
        |e: std::io::Error| -> Box<str> { format!("{IDLE_LATENCY}: {}", super::said(&e)).into() };
    let mut file = File::options().write(true).open(IDLE_LATENCY).map_err(refused)?;
    let us = i32::try_from(us).unwrap_or(i32::MAX);
    file.write_all(&us.to_ne_bytes()).map_err(refused)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::listed;

    #[test]
    fn lists_of_processors() {
        for (text, want) in [
            ("\n", &[][..]),
            ("3\n", &[3]),
            ("1,4-6\n", &[1, 4, 5, 6]),
            ("x,2", &[2]),
            ("5-4", &[]),
        ] {
            assert_eq!(listed(text), want, "{text:?}");
        }
    }
}
