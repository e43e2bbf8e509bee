//! Facts of the computer, as its system's files tell them.

use rustix::process::{Resource, getrlimit};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Most bytes of a file that are read.
const MOST: u64 = 1 << 20;

/// Facts of the system. One that it does not tell is `None`, or an empty list.
#[derive(Clone, Debug, Default)]
pub(crate) struct Computer {
    pub(crate) is_root: bool,
    /// Highest realtime priority that this user may set; `None` means any.
    pub(crate) priority: Option<u64>,
    /// Bytes that this user may lock in memory; `None` means any number.
    pub(crate) locked: Option<u64>,
    /// First line of the kernel's version.
    pub(crate) kernel: Option<String>,
    /// The kernel says that it is a realtime kernel.
    pub(crate) is_realtime: bool,
    pub(crate) processors: usize,
    /// Processors that nothing else runs on, as the kernel lists them.
    pub(crate) isolated: Option<String>,
    pub(crate) clock: Option<String>,
    /// Frequency governors in use, each once.
    pub(crate) governors: Vec<String>,
    /// True if `/dev/cpu_dma_latency` may be written; `None` if it is not there.
    pub(crate) idle: Option<bool>,
    /// Parallel ports (`/proc/ioports`), and whether a printer driver holds them.
    pub(crate) ports: usize,
    pub(crate) printer_driver: bool,
    /// Devices that machines are connected to, and whether this user may open each.
    pub(crate) devices: Vec<(String, bool)>,
    /// Wired network cards: name and driver.
    pub(crate) cards: Vec<(String, String)>,
    /// Groups of the system that this user is not in, by name.
    pub(crate) foreign_groups: Vec<String>,
}

impl Computer {
    /// Reads the facts from the system below a folder, which is `/` but in tests.
    pub(crate) fn read(root: &Path) -> Self {
        let line = |path: &str| first_line(&root.join(path));
        let kernel = line("proc/version");
        let told = line("sys/kernel/realtime").is_some_and(|text| text == "1");
        let named = kernel.as_ref().is_some_and(|text| text.contains("PREEMPT_RT"));
        let ioports = whole(&root.join("proc/ioports")).unwrap_or_default();
        let modules = whole(&root.join("proc/modules")).unwrap_or_default();
        let idle = root.join("dev/cpu_dma_latency");
        Self {
            is_root: rustix::process::geteuid().is_root(),
            priority: getrlimit(Resource::Rtprio).current,
            locked: getrlimit(Resource::Memlock).current,
            is_realtime: told || named,
            kernel,
            processors: processors(root),
            isolated: line("sys/devices/system/cpu/isolated").filter(|text| !text.is_empty()),
            clock: line("sys/devices/system/clocksource/clocksource0/current_clocksource"),
            governors: governors(root),
            idle: idle.exists().then(|| is_writable(&idle)),
            ports: ioports.lines().filter(|l| l.contains("parport")).count(),
            printer_driver: modules.lines().any(|l| l.starts_with("lp ")),
            devices: devices(root),
            cards: cards(root),
            foreign_groups: foreign_groups(root),
        }
    }
}

fn whole(path: &Path) -> Option<String> {
    let bytes = hal_ini::file::contents(path, MOST).ok()??;
    Some(String::from_utf8_lossy(&bytes).into_owned())
}

fn first_line(path: &Path) -> Option<String> {
    Some(whole(path)?.lines().next().unwrap_or_default().trim().to_owned())
}

/// Returns the entries of a folder in order of their names.
fn entries(folder: &Path) -> Vec<(String, PathBuf)> {
    let mut all: Vec<(String, PathBuf)> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let entry = entry.ok()?;
            Some((entry.file_name().to_string_lossy().into_owned(), entry.path()))
        })
        .collect();
    all.sort();
    all
}

fn is_numbered(name: &str, kind: &str) -> bool {
    let number = name.strip_prefix(kind).unwrap_or_default();
    !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())
}

fn processors(root: &Path) -> usize {
    let all = entries(&root.join("sys/devices/system/cpu"));
    all.iter().filter(|(name, _)| is_numbered(name, "cpu")).count()
}

fn governors(root: &Path) -> Vec<String> {
    let all = entries(&root.join("sys/devices/system/cpu"));
    let cpus = all.iter().filter(|(name, _)| is_numbered(name, "cpu"));
    let mut used: Vec<String> =
        cpus.filter_map(|(_, path)| first_line(&path.join("cpufreq/scaling_governor"))).collect();
    used.sort();
    used.dedup();
    used
}

fn is_writable(path: &Path) -> bool {
    use rustix::fs::{Access, access};
    access(path, Access::WRITE_OK).is_ok()
}

/// Kinds of devices that machines are connected to.
const KINDS: [&str; 6] = ["parport", "ttyUSB", "ttyACM", "gpiochip", "spidev", "hidraw"];

fn devices(root: &Path) -> Vec<(String, bool)> {
    let all = entries(&root.join("dev")).into_iter();
    all.filter(|(name, _)| KINDS.iter().any(|kind| name.starts_with(kind)))
        .map(|(name, path)| (format!("/dev/{name}"), is_writable(&path)))
        .collect()
}

fn cards(root: &Path) -> Vec<(String, String)> {
    let all = entries(&root.join("sys/class/net")).into_iter();
    all.filter(|(_, path)| path.join("device").exists() && !path.join("wireless").exists())
        .map(|(name, path)| {
            let driver = fs::read_link(path.join("device/driver")).ok();
            let driver = driver.and_then(|d| Some(d.file_name()?.to_string_lossy().into_owned()));
            (name, driver.unwrap_or_default())
        })
        .collect()
}

/// Groups whose members may use hardware or real time.
const GROUPS: [&str; 5] = ["realtime", "dialout", "lp", "gpio", "spi"];

fn foreign_groups(root: &Path) -> Vec<String> {
    let text = whole(&root.join("etc/group")).unwrap_or_default();
    let own: Vec<u32> = rustix::process::getgroups()
        .unwrap_or_default()
        .into_iter()
        .chain([rustix::process::getegid()])
        .map(rustix::process::Gid::as_raw)
        .collect();
    let groups = text.lines().filter_map(|line| {
        let mut parts = line.split(':');
        let name = parts.next()?;
        let number: u32 = parts.nth(1)?.parse().ok()?;
        (GROUPS.contains(&name) && !own.contains(&number)).then(|| name.to_owned())
    });
    groups.collect()
}
