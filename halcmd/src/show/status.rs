//! The output of `status`.

use crate::{language::command::StatusKind, language::units::duration};
use hal_protocol::{Lock, RealtimeInfo, StatusInfo, ThreadInfo, Usage};

const LOCKS: &[(Lock, &str)] = &[
    (Lock::LOAD, "  HAL_LOCK_LOAD    - loading of new components is locked\n"),
    (Lock::CONFIG, "  HAL_LOCK_CONFIG  - link and addf is locked\n"),
    (Lock::PARAMS, "  HAL_LOCK_PARAMS  - setting params is locked\n"),
    (Lock::RUN, "  HAL_LOCK_RUN     - running/stopping HAL is locked\n"),
];

/// Returns the sections that a kind of `status` prints.
#[must_use]
pub(crate) fn text(
    status: &StatusInfo,
    threads: &[ThreadInfo],
    wait: Option<&str>,
    kind: StatusKind,
) -> String {
    let all = kind == StatusKind::All;
    let mut text = String::new();
    if all || kind == StatusKind::Lock {
        lock(&mut text, status.lock);
    }
    if all || kind == StatusKind::Memory {
        memory(&mut text, status);
    }
    if all || kind == StatusKind::Instance {
        instance(&mut text, status, threads);
        if let Some(wait) = wait {
            text.push_str(&format!("  {:<11} {wait}\n", "wait:"));
        }
    }
    text
}

fn lock(text: &mut String, lock: Lock) {
    let level = lock.0;
    text.push_str("HAL locking status:\n");
    text.push_str(&format!("  current lock value {level} ({level:02x})\n"));
    if level == 0 {
        text.push_str("  HAL_LOCK_NONE - nothing is locked\n");
    }
    for (bit, line) in LOCKS {
        if level & bit.0 != 0 {
            text.push_str(line);
        }
    }
}

fn memory(text: &mut String, status: &StatusInfo) {
    let (used, total) = status.memory;
    text.push_str("HAL memory status\n");
    text.push_str(&format!("  used/total shared memory:   {used}/{total}\n"));
    let counts: [(&str, Usage); 7] = [
        ("components:", status.components),
        ("pins:", status.pins),
        ("parameters:", status.params),
        ("aliases:", status.aliases),
        ("signals:", status.signals),
        ("functions:", status.functs),
        ("threads:", status.threads),
    ];
    for (what, n) in counts {
        text.push_str(&format!("  active/recycled {what:<11} {}/{}\n", n.active, n.recycled));
    }
}

fn instance(text: &mut String, status: &StatusInfo, threads: &[ThreadInfo]) {
    text.push_str("HAL instance status\n");
    let mut line = |what: &str, value: &str| text.push_str(&format!("  {what:<11} {value}\n"));
    let running = if status.running { "running" } else { "stopped" };
    let hardware = if status.simulated { "simulated" } else { "real" };
    line("instance:", &format!("{} (process {})", status.instance, status.pid));
    line("time:", &format!("{}, at {}", status.clock, seconds(status.time)));
    line("threads:", &format!("{running}; {}", status.scheduling));
    line("hardware:", hardware);
    if let Some(realtime) = &status.realtime {
        line("memory:", &locked(realtime.memory));
        line("idle:", &idle(realtime));
        let stuck = duration(realtime.stuck_ns);
        line("watchdog:", &format!("stops the machine when a function takes {stuck} in one cycle"));
    }
    for (t, wake_ups) in threads.iter().filter_map(|t| Some((t, wake_ups(t)?))) {
        line("wake-ups:", &format!("of thread '{}': {wake_ups}", t.name));
    }
    for t in threads.iter().filter(|t| t.overruns > 0) {
        let by = t.overrun_by.as_ref().map(|f| format!(", the last by '{f}'")).unwrap_or_default();
        let (overruns, missed, name) = (t.overruns, t.missed, &t.name);
        line("overruns:", &format!("{overruns} of thread '{name}', {missed} cycles missed{by}"));
    }
    if let Some(gaps) = &status.gaps {
        let (last, at) = (gaps.ns as f64 / 1e9, gaps.time as f64 / 1e9);
        let (count, cause) = (gaps.count, &gaps.cause);
        line("gaps:", &format!("{count}, the last of {last:.1} s until {at:.1} s: {cause}"));
    }
    for kind in kinds(status) {
        let of_kind = || status.foreign.iter().filter(|f| f.kind == kind);
        let names: Vec<&str> = of_kind().map(|f| f.component.as_str()).collect();
        let bytes: u64 = of_kind().map(|f| f.memory).sum();
        let each = if names.len() == 1 { "" } else { "each " };
        line(
            "foreign:",
            &format!(
                "{}: {each}a {kind}, whose reads and writes are not known; {bytes} bytes of memory",
                names.join(", ")
            ),
        );
    }
    for w in &status.workers {
        line(
            "worker:",
            &format!(
                "'{}' of component '{}', {}: {} steps, {} items",
                w.name,
                w.owner_name,
                w.state.name(),
                w.steps,
                w.items
            ),
        );
    }
    if let Some(stuck) = &status.stuck {
        line(
            "stuck:",
            &format!(
                "component '{}', function '{}' in thread '{}': {}",
                stuck.component, stuck.funct, stuck.thread, stuck.cause
            ),
        );
    }
    if let Some(fault) = &status.fault {
        line(
            "fault:",
            &if fault.thread.is_empty() {
                format!(
                    "component '{}', worker '{}': {}",
                    fault.component, fault.funct, fault.cause
                )
            } else {
                format!(
                    "component '{}', function '{}' in thread '{}': {}",
                    fault.component, fault.funct, fault.thread, fault.cause
                )
            },
        );
    }
    if let Some((file, lost)) = &status.recording {
        let lost = if *lost > 0 { format!(" ({lost} records lost)") } else { String::new() };
        line("recording:", &format!("{file}{lost}"));
    }
    if let Some(stopped) = &status.recording_stopped {
        line("recording:", &stopped.to_string());
    }
}

/// Describes the amount of locked memory. Arguments in bytes.
fn locked((locked, present): (u64, u64)) -> String {
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let rest = present.saturating_sub(locked);
    let rest =
        if rest == 0 { String::new() } else { format!("; {:.1} MiB may be pushed out", mib(rest)) };
    format!("{:.1} of {:.1} MiB stay in RAM{rest}", mib(locked), mib(present))
}

/// Describes how deeply processors may sleep.
fn idle(realtime: &RealtimeInfo) -> String {
    match (realtime.idle_us, &realtime.idle_refusal) {
        (Some(us), _) => format!("/dev/cpu_dma_latency is held: processors wake within {us} us"),
        (None, Some(why)) => format!("processors may sleep deeply: {why}"),
        (None, None) => "processors sleep as the system lets them".to_owned(),
    }
}

/// Describes the wake-up latency of a thread by upper bounds; `None` if none was counted.
fn wake_ups(t: &ThreadInfo) -> Option<String> {
    let all: u64 = t.latency.iter().fold(0, |sum, n| sum.saturating_add(*n));
    if all == 0 {
        return None;
    }
    let within = |thousandths: u64| {
        // Number of wake-ups in this fraction, rounded up.
        let wanted = (u128::from(all) * u128::from(thousandths)).div_ceil(1000);
        let mut sum = 0_u128;
        let bin = t.latency.iter().position(|n| {
            sum += u128::from(*n);
            sum >= wanted
        });
        let latest = t.latency_max.max(0).unsigned_abs().div_ceil(1000);
        match bin {
            // The last bin has no upper bound.
            Some(bin) if bin + 1 < t.latency.len() => (1_u64 << bin.min(63)).min(latest),
            _ => latest,
        }
    };
    let latest = t.latency_max as f64 / 1000.0;
    Some(format!(
        "half within {} us, 99 % within {} us, 99.9 % within {} us, the latest {latest:.1} us",
        within(500),
        within(990),
        within(999)
    ))
}

/// Returns the kinds of foreign parts, in order of appearance.
fn kinds(status: &StatusInfo) -> Vec<&str> {
    let mut kinds: Vec<&str> = Vec::new();
    for part in &status.foreign {
        if !kinds.contains(&part.kind.as_str()) {
            kinds.push(&part.kind);
        }
    }
    kinds
}

/// Writes nanoseconds as seconds, without trailing zeros.
fn seconds(ns: u64) -> String {
    let (whole, part) = (ns / 1_000_000_000, ns % 1_000_000_000);
    let part = format!("{part:09}");
    let part = part.trim_end_matches('0');
    if part.is_empty() { format!("{whole} s") } else { format!("{whole}.{part} s") }
}

#[cfg(test)]
pub(crate) mod samples {
    use hal_protocol::{Lock, StatusInfo, Usage};

    pub(crate) fn status(lock: Lock) -> StatusInfo {
        let n = |active| Usage { active, recycled: 0 };
        StatusInfo {
            instance: "default".to_owned(),
            pid: 77,
            lock,
            memory: (18032, 2_097_152),
            components: n(11),
            pins: n(75),
            params: n(38),
            aliases: n(2),
            signals: n(5),
            functs: n(12),
            threads: n(2),
            clock: "virtual".to_owned(),
            time: 2_500_000_000,
            scheduling: "all in one place".to_owned(),
            realtime: None,
            gaps: None,
            simulated: true,
            starting: false,
            running: true,
            fault: None,
            stuck: None,
            foreign: Vec::new(),
            workers: Vec::new(),
            recording: None,
            recording_stopped: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{samples, seconds, text};
    use crate::{language::command::StatusKind, show};
    use hal_protocol::{
        FaultInfo, ForeignPart, GapInfo, Lock, RealtimeInfo, ThreadInfo, WorkerInfo, WorkerState,
    };

    /// Scripts search the output for `lock`: only the lines that LinuxCNC prints have it.
    #[test]
    fn added_lines_do_not_say_lock() {
        let status = samples::status(Lock(0));
        let mut text = String::new();
        super::instance(&mut text, &status, &[]);
        assert!(text.contains("virtual") && !text.to_lowercase().contains("lock"), "{text}");
    }

    #[test]
    fn locks() {
        for (level, want) in [
            (0, "  current lock value 0 (00)\n  HAL_LOCK_NONE - nothing is locked\n"),
            (
                3,
                "  current lock value 3 (03)\n\
                 \x20 HAL_LOCK_LOAD    - loading of new components is locked\n\
                 \x20 HAL_LOCK_CONFIG  - link and addf is locked\n",
            ),
            (
                255,
                "  current lock value 255 (ff)\n\
                 \x20 HAL_LOCK_LOAD    - loading of new components is locked\n\
                 \x20 HAL_LOCK_CONFIG  - link and addf is locked\n\
                 \x20 HAL_LOCK_PARAMS  - setting params is locked\n\
                 \x20 HAL_LOCK_RUN     - running/stopping HAL is locked\n",
            ),
        ] {
            let got = text(&samples::status(Lock(level)), &[], None, StatusKind::Lock);
            assert_eq!(got, format!("HAL locking status:\n{want}"));
        }
    }

    #[test]
    fn memory() {
        let got = text(&samples::status(Lock::NONE), &[], None, StatusKind::Memory);
        let want = "HAL memory status\n\
             \x20 used/total shared memory:   18032/2097152\n\
             \x20 active/recycled components: 11/0\n\
             \x20 active/recycled pins:       75/0\n\
             \x20 active/recycled parameters: 38/0\n\
             \x20 active/recycled aliases:    2/0\n\
             \x20 active/recycled signals:    5/0\n\
             \x20 active/recycled functions:  12/0\n\
             \x20 active/recycled threads:    2/0\n";
        assert_eq!(got, want);
    }

    #[test]
    fn what_there_is_of_real_time() {
        let mut status = samples::status(Lock::NONE);
        let mut lines = |realtime: RealtimeInfo, latency: &[u64], latency_max| {
            status.realtime = Some(realtime);
            let latency = latency.to_vec();
            let thread =
                ThreadInfo { latency, latency_max, ..show::samples::thread("t", 1_000_000, &[]) };
            let text = text(&status, &[thread], None, StatusKind::Instance);
            let lines = text.lines().skip_while(|l| !l.contains("memory:"));
            lines.map(|l| l.trim_start().to_owned()).collect::<Vec<_>>()
        };
        let good = RealtimeInfo {
            memory: (10_171_187, 10_171_187),
            idle_us: Some(0),
            idle_refusal: None,
            stuck_ns: 2_000_000,
        };
        // Of 1000 wake-ups: 600 below 1 us, 380 below 16 us, 19 below 32 us, one beyond the last
        // bin.
        let bins = [600, 0, 0, 0, 380, 19, 0, 1];
        assert_eq!(
            lines(good.clone(), &bins, 307_040),
            [
                "memory:     9.7 of 9.7 MiB stay in RAM",
                "idle:       /dev/cpu_dma_latency is held: processors wake within 0 us",
                "watchdog:   stops the machine when a function takes 2 ms in one cycle",
                "wake-ups:   of thread 't': half within 1 us, 99 % within 32 us, 99.9 % within 32 \
                 us, the latest 307.0 us",
            ]
        );
        let refused = "/dev/cpu_dma_latency: Permission denied".to_owned();
        let bad = RealtimeInfo {
            memory: (1 << 20, 10_171_187),
            idle_us: None,
            idle_refusal: Some(refused),
            ..good
        };
        assert_eq!(
            lines(bad.clone(), &[0, 1], 1_200)[..2],
            [
                "memory:     1.0 of 9.7 MiB stay in RAM; 8.7 MiB may be pushed out",
                "idle:       processors may sleep deeply: /dev/cpu_dma_latency: Permission denied",
            ]
        );
        let off = RealtimeInfo { idle_refusal: None, ..bad };
        let off = lines(off, &[0, 0, 0, 3], 20_000_000);
        assert_eq!(off[1], "idle:       processors sleep as the system lets them");
        // All wake-ups are in the last bin, which has no upper bound.
        let late = "half within 20000 us, 99 % within 20000 us, 99.9 % within 20000 us, the latest \
                    20000.0 us";
        assert_eq!(off[3], format!("wake-ups:   of thread 't': {late}"));
    }

    #[test]
    fn the_instance_says_what_went_wrong() {
        let mut status = samples::status(Lock::NONE);
        status.fault = Some(FaultInfo {
            component: "siggen".to_owned(),
            funct: "siggen.0.update".to_owned(),
            thread: "fast".to_owned(),
            cause: "index out of range".to_owned(),
        });
        status.recording = Some(("/tmp/x.vcd".to_owned(), 3));
        status.stuck = status.fault.clone().map(|f| FaultInfo { cause: "why".to_owned(), ..f });
        status.gaps = Some(GapInfo {
            count: 2,
            ns: 3_040_000_000,
            time: 12_345_678_901,
            cause: "the computer slept".to_owned(),
        });
        let part = |name: &str, memory| ForeignPart {
            component: name.to_owned(),
            kind: "component in C".to_owned(),
            memory,
        };
        status.foreign = vec![part("probe", 64), part("laser", 128)];
        let late = ThreadInfo {
            overruns: 3,
            missed: 1012,
            overrun_by: Some("adder".to_owned()),
            ..show::samples::thread("fast", 1_000_000, &[])
        };
        let want = "HAL instance status\n\
             \x20 instance:   default (process 77)\n\
             \x20 time:       virtual, at 2.5 s\n\
             \x20 threads:    running; all in one place\n\
             \x20 hardware:   simulated\n\
             \x20 overruns:   3 of thread 'fast', 1012 cycles missed, the last by 'adder'\n\
             \x20 gaps:       2, the last of 3.0 s until 12.3 s: the computer slept\n\
             \x20 foreign:    probe, laser: each a component in C, whose reads and writes are not known; 192 \
             bytes of memory\n\
             \x20 stuck:      component 'siggen', function 'siggen.0.update' in thread 'fast': \
             why\n\
             \x20 fault:      component 'siggen', function 'siggen.0.update' in thread 'fast': \
             index out of range\n\
             \x20 recording:  /tmp/x.vcd (3 records lost)\n\
             \x20 wait:       for=m0 a person\n";
        assert_eq!(text(&status, &[late], Some("for=m0 a person"), StatusKind::Instance), want);
        assert_eq!(seconds(3_000_000_000), "3 s");
        assert_eq!(seconds(1), "0.000000001 s");
    }

    #[test]
    fn a_failed_worker_is_named_without_a_thread() {
        let mut status = samples::status(Lock::NONE);
        status.workers = vec![WorkerInfo {
            name: "planner.plan".to_owned(),
            owner_name: "planner".to_owned(),
            period: 10_000_000,
            most: 20,
            steps: 12,
            items: 240,
            state: WorkerState::Failed,
            doc: String::new(),
        }];
        status.fault = Some(FaultInfo {
            component: "planner".to_owned(),
            funct: "planner.plan".to_owned(),
            thread: String::new(),
            cause: "index out of range".to_owned(),
        });
        let got = text(&status, &[], None, StatusKind::Instance);
        let want = "\x20 worker:     'planner.plan' of component 'planner', failed: 12 steps, 240 items\n\
             \x20 fault:      component 'planner', worker 'planner.plan': index out of range\n";
        assert!(got.ends_with(want), "{got}");
    }
}
