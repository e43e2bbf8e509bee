//! Meaning of the facts, and the lines that fix what is missing.

use super::computer::Computer;

/// Grade of a fact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Grade {
    /// As a machine needs it.
    Good,
    /// The machine runs, later than it could.
    Better,
    /// A machine that moves needs this.
    Missing,
    /// Said for information.
    Told,
}

impl Grade {
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Better => "better",
            Self::Missing => "MISSING",
            Self::Told => "-",
        }
    }
}

/// A fact with its meaning.
#[derive(Clone, Debug)]
pub(crate) struct Finding {
    pub(crate) grade: Grade,
    pub(crate) subject: &'static str,
    pub(crate) says: String,
    /// Lines for a shell that fix it.
    pub(crate) lines: Vec<String>,
    /// Step for a person after them.
    pub(crate) then: Option<&'static str>,
}

fn finding(grade: Grade, subject: &'static str, says: impl Into<String>) -> Finding {
    Finding { grade, subject, says: says.into(), lines: Vec::new(), then: None }
}

impl Finding {
    fn mended(self, lines: impl IntoIterator<Item = String>, then: Option<&'static str>) -> Self {
        Self { lines: lines.into_iter().collect(), then, ..self }
    }
}

/// Priority that threads want, as `SCHED_FIFO` counts.
const PRIORITY: u64 = 95;
/// Memory that a machine locks, in bytes.
const LOCKED: u64 = 256 << 20;

/// Returns all findings, in the order in which a person mends them.
pub(crate) fn all(of: &Computer) -> Vec<Finding> {
    let mut all = vec![permissions(of), kernel(of), isolated(of), clock(of)];
    all.extend(governor(of));
    all.push(idle(of));
    all.extend(port(of));
    all.extend(devices(of));
    all.extend(cards(of));
    all
}

fn permissions(of: &Computer) -> Finding {
    if of.is_root {
        return finding(Grade::Good, "permissions", "root may run threads in real time");
    }
    let may_run = of.priority.is_none_or(|highest| highest >= PRIORITY);
    let may_lock = of.locked.is_none_or(|bytes| bytes >= LOCKED);
    if may_run && may_lock {
        return finding(Grade::Good, "permissions", "this user may run threads in real time");
    }
    let lacks = match (may_run, may_lock) {
        (true, _) => {
            "this user may not lock memory: a page that comes from the disk makes a thread late"
        }
        (false, _) => "this user may not run threads in real time (SCHED_FIFO): they will be late",
    };
    let limits = r"printf '@realtime - rtprio 95\n@realtime - memlock unlimited\n' | sudo tee /etc/security/limits.d/realtime.conf";
    finding(Grade::Missing, "permissions", lacks).mended(
        [
            "sudo groupadd --force realtime".to_owned(),
            limits.to_owned(),
            "sudo usermod -aG realtime \"$USER\"".to_owned(),
        ],
        Some("log out and in; 'ulimit -r -l' then says 95 and unlimited"),
    )
}

fn kernel(of: &Computer) -> Finding {
    let version = of.kernel.as_deref().and_then(|text| text.split(' ').nth(2)).unwrap_or("unknown");
    if of.is_realtime {
        return finding(Grade::Good, "kernel", format!("{version} is a realtime kernel"));
    }
    let package = realtime_kernel(std::env::consts::ARCH);
    let lines = package.map(|name| format!("sudo apt-get install {name}"));
    finding(
        Grade::Better,
        "kernel",
        format!(
            "{version} is no realtime kernel (PREEMPT_RT): nothing bounds how late a thread wakes"
        ),
    )
    .mended(lines, package.map(|_| "restart the computer"))
}

/// Returns Debian's package of a realtime kernel for an architecture, as Rust names it.
fn realtime_kernel(architecture: &str) -> Option<&'static str> {
    match architecture {
        "x86_64" => Some("linux-image-rt-amd64"),
        "x86" => Some("linux-image-rt-686-pae"),
        "aarch64" => Some("linux-image-rt-arm64"),
        "arm" => Some("linux-image-rt-armmp"),
        _ => None,
    }
}

fn isolated(of: &Computer) -> Finding {
    if let Some(list) = &of.isolated {
        return finding(Grade::Good, "processor", format!("{list} is isolated: threads run there"));
    }
    if of.processors < 2 {
        return finding(Grade::Told, "processor", "there is one: nothing can be kept away from it");
    }
    let last = of.processors - 1;
    finding(Grade::Better, "processor", "none is isolated: other programs run where threads do").mended(
        [format!(
            "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&isolcpus={last} nohz_full={last} /' /etc/default/grub && sudo update-grub"
        )],
        Some("restart the computer"),
    )
}

fn clock(of: &Computer) -> Finding {
    match of.clock.as_deref() {
        Some(name @ ("tsc" | "arch_sys_counter" | "kvm-clock" | "riscv_clocksource")) => {
            finding(Grade::Good, "clock", format!("{name} is read without a call of the system"))
        }
        Some(name) => finding(
            Grade::Better,
            "clock",
            format!(
                "{name} is slow to read; the kernel says why it left the processor's own ('dmesg | grep -i tsc')"
            ),
        ),
        None => finding(Grade::Told, "clock", "the system does not name its clock source"),
    }
}

fn governor(of: &Computer) -> Option<Finding> {
    let slow: Vec<&str> =
        of.governors.iter().map(String::as_str).filter(|g| *g != "performance").collect();
    if of.governors.is_empty() {
        return None;
    }
    if slow.is_empty() {
        return Some(finding(Grade::Good, "frequency", "the processors keep their frequency"));
    }
    let says = format!(
        "the processors change their frequency ({}): a thread begins slowly",
        slow.join(", ")
    );
    let line = "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
    Some(finding(Grade::Better, "frequency", says).mended([line.to_owned()], None))
}

fn idle(of: &Computer) -> Finding {
    match of.idle {
        Some(true) => finding(Grade::Good, "idle", "processors can be kept from deep sleep"),
        Some(false) => {
            let rule = r#"echo 'KERNEL=="cpu_dma_latency", GROUP="realtime", MODE="0660"' | sudo tee /etc/udev/rules.d/99-realtime.rules"#;
            finding(Grade::Better, "idle", "this user may not keep processors from deep sleep")
                .mended(
                    [
                        rule.to_owned(),
                        "sudo udevadm control --reload && sudo udevadm trigger".to_owned(),
                    ],
                    None,
                )
        }
        None => finding(Grade::Told, "idle", "the system has no /dev/cpu_dma_latency"),
    }
}

fn port(of: &Computer) -> Option<Finding> {
    if of.ports == 0 {
        return None;
    }
    if of.printer_driver {
        let line =
            "echo 'blacklist lp' | sudo tee /etc/modprobe.d/ferrule-lp.conf && sudo modprobe -r lp";
        let says = "the driver of printers (lp) holds the parallel port";
        return Some(
            finding(Grade::Missing, "parallel port", says).mended([line.to_owned()], None),
        );
    }
    Some(finding(Grade::Good, "parallel port", "is there, and no printer's driver holds it"))
}

/// Returns the group whose members may open a device.
fn group(device: &str) -> &'static str {
    if device.contains("tty") {
        "dialout"
    } else if device.contains("parport") {
        "lp"
    } else if device.contains("gpio") {
        "gpio"
    } else if device.contains("spi") {
        "spi"
    } else {
        "plugdev"
    }
}

fn devices(of: &Computer) -> Vec<Finding> {
    let told = of.devices.iter().map(|(device, is_open)| {
        if *is_open {
            return finding(Grade::Good, "device", format!("{device} may be opened"));
        }
        let group = group(device);
        let says = if of.foreign_groups.iter().any(|g| g == group) {
            format!("{device} may not be opened: this user is not in the group '{group}'")
        } else {
            format!("{device} may not be opened")
        };
        finding(Grade::Missing, "device", says)
            .mended([format!("sudo usermod -aG {group} \"$USER\"")], Some("log out and in"))
    });
    told.collect()
}

fn cards(of: &Computer) -> Vec<Finding> {
    let told = of.cards.iter().map(|(name, driver)| {
        finding(
            Grade::Told,
            "network card",
            format!("{name} ({driver}): for a machine's card or drives, 'sudo ethtool -C {name} rx-usecs 0' keeps its packets from waiting"),
        )
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn good() -> Computer {
        Computer {
            kernel: Some("Linux version 6.1.0-rt (x)".to_owned()),
            is_realtime: true,
            processors: 4,
            isolated: Some("3".to_owned()),
            clock: Some("tsc".to_owned()),
            governors: vec!["performance".to_owned()],
            idle: Some(true),
            ..Computer::default()
        }
    }

    #[test]
    fn the_realtime_kernel_is_that_of_the_computer() {
        let of = |architecture| realtime_kernel(architecture).unwrap_or("none");
        let all = ["x86_64", "aarch64", "arm", "riscv64"].map(of);
        assert_eq!(
            all,
            ["linux-image-rt-amd64", "linux-image-rt-arm64", "linux-image-rt-armmp", "none"]
        );
    }

    /// Each fact, spoilt alone, is found by its subject with a grade and, where something can be done, the line that does it.
    #[test]
    fn each_fault_is_found_alone() {
        let no_fault = all(&good());
        assert!(
            no_fault.iter().all(|f| f.grade == Grade::Good && f.lines.is_empty()),
            "{no_fault:#?}"
        );
        type Spoilt = (fn(&mut Computer), &'static str, Grade, &'static str);
        let spoilt: [Spoilt; 11] = [
            (|c| c.priority = Some(0), "permissions", Grade::Missing, "groupadd"),
            (|c| c.locked = Some(65_536), "permissions", Grade::Missing, "groupadd"),
            (|c| c.is_realtime = false, "kernel", Grade::Better, "linux-image-rt"),
            (|c| c.isolated = None, "processor", Grade::Better, "isolcpus=3"),
            (|c| c.clock = Some("hpet".to_owned()), "clock", Grade::Better, ""),
            (
                |c| c.governors = vec!["powersave".to_owned()],
                "frequency",
                Grade::Better,
                "scaling_governor",
            ),
            (|c| c.idle = Some(false), "idle", Grade::Better, "cpu_dma_latency"),
            (
                |c| (c.ports, c.printer_driver) = (1, true),
                "parallel port",
                Grade::Missing,
                "modprobe -r lp",
            ),
            (
                |c| c.devices = vec![("/dev/ttyUSB0".to_owned(), false)],
                "device",
                Grade::Missing,
                "-aG dialout",
            ),
            (
                |c| c.devices = vec![("/dev/gpiochip0".to_owned(), false)],
                "device",
                Grade::Missing,
                "-aG gpio",
            ),
            (
                |c| c.devices = vec![("/dev/hidraw0".to_owned(), false)],
                "device",
                Grade::Missing,
                "-aG plugdev",
            ),
        ];
        for (spoil, subject, grade, line) in spoilt {
            let mut computer = good();
            spoil(&mut computer);
            let found: Vec<Finding> =
                all(&computer).into_iter().filter(|f| f.grade != Grade::Good).collect();
            let [finding] = found.as_slice() else { panic!("{subject}: {found:#?}") };
            assert_eq!((finding.subject, finding.grade), (subject, grade));
            assert!(
                line.is_empty() || finding.lines.iter().any(|l| l.contains(line)),
                "{finding:?}"
            );
        }
    }
}
