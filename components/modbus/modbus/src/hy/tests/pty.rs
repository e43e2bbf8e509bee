//! The component on a real serial line: a pair of terminals, with the simulated inverter at the other end.

use super::{HyVfd, MS};
use hal_bench::Bench;
use hal_modbus_devices::{Device as _, Inverter};
use rustix::{
    event::{PollFd, PollFlags, poll},
    fd::OwnedFd,
    fs::{Mode, OFlags, open},
    io::{ioctl_fionread, read, write},
    pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt},
};
use std::{
    os::unix::fs::symlink,
    path::PathBuf,
    sync::atomic::{AtomicU32, Ordering::Relaxed},
};

/// Returns a pair of terminals: the far end, and the name of the near one.
fn pair() -> (OwnedFd, String) {
    let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&far).unwrap();
    unlockpt(&far).unwrap();
    let name = ptsname(&far, Vec::new()).unwrap().into_string().unwrap();
    (far, name)
}

/// Name that means a terminal, as those of /dev/serial/by-id do.
struct Name(PathBuf);

impl Name {
    fn new(terminal: &str) -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let n = NEXT.fetch_add(1, Relaxed);
        let path = std::env::temp_dir().join(format!("ferrule-hy-{}-{n}", std::process::id()));
        symlink(terminal, &path).unwrap();
        Self(path)
    }
}

impl Drop for Name {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).unwrap();
    }
}

/// The component, its line, and an inverter at the far end. Nothing depends on real time: each side waits for the other's bytes.
struct Line {
    bench: Bench,
    name: Name,
    far: OwnedFd,
    /// The component's end, to see when an answer has arrived there.
    near: OwnedFd,
    inverter: Inverter,
    frames: Vec<Vec<u8>>,
}

impl Line {
    fn new() -> Self {
        let (far, terminal) = pair();
        let near = open(&terminal, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
        let name = Name::new(&terminal);
        let mut bench = Bench::new().with_hardware();
        bench.load::<HyVfd>(&[&format!("device={}", name.0.display()), "rate=9600"]).unwrap();
        Self { bench, name, far, near, inverter: Inverter::new(1), frames: Vec::new() }
    }

    /// Pulls the adapter, and plugs it in again.
    fn replug(&mut self) {
        let (far, terminal) = pair();
        self.near = open(&terminal, OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
        self.far = far;
        std::fs::remove_file(&self.name.0).unwrap();
        symlink(&terminal, &self.name.0).unwrap();
    }

    /// Lets milliseconds pass. The inverter answers each request at once.
    fn pass(&mut self, ms: u32) {
        for _ in 0..ms {
            self.bench.pass(MS);
            self.bench.run("hy_vfd", MS);
            self.bench.work("hy_vfd", 1).unwrap();
            self.inverter.advance(self.bench.now_ns());
            if self.is_asked() {
                self.answer();
            }
        }
    }

    /// Returns whether the worker has sent a frame, which may still be on its way through the system.
    fn is_asked(&self) -> bool {
        let sent = self.bench.get::<u32>("hy_vfd.requests");
        usize::try_from(sent).unwrap() > self.frames.len()
    }

    fn answer(&mut self) {
        let mut frame = Vec::new();
        // Number, function and length say how long it is.
        while frame.get(2).is_none_or(|length| frame.len() < usize::from(*length) + 5) {
            let mut into = [0; 64];
            let count = read(&self.far, &mut into).unwrap();
            frame.extend(&into[..count]);
        }
        self.frames.push(frame.clone());
        let Some(answer) = self.inverter.answered(&frame, self.bench.now_ns()) else { return };
        write(&self.far, &answer).unwrap();
        while ioctl_fionread(&self.near).unwrap() < answer.len() as u64 {
            poll(&mut [PollFd::new(&self.near, PollFlags::IN)], None).unwrap();
        }
    }
}

#[test]
fn a_real_line_carries_a_run_and_its_stop() {
    let mut line = Line::new();
    line.bench.set("hy_vfd.enable", true);
    line.bench.set("hy_vfd.speed-command", 12_000.0);
    line.bench.set("hy_vfd.spindle-forward", true);
    line.pass(1000);
    assert!(line.bench.get::<bool>("hy_vfd.hycomm-ok"));
    assert_eq!(line.frames[0], [1, 3, 1, 8, 0xF1, 0x8E], "a stop comes first");
    line.bench.set("hy_vfd.spindle-on", true);
    line.pass(3000);
    assert!(line.bench.get::<bool>("hy_vfd.spindle-at-speed"));
    assert_eq!(line.inverter.hz(), 200.0);
    line.bench.set("hy_vfd.spindle-on", false);
    line.pass(3000);
    assert_eq!(line.inverter.hz(), 0.0);
    assert_eq!(line.bench.get::<i32>("hy_vfd.error-count"), 0);
}

#[test]
fn a_line_that_vanishes_is_lost_and_motion_is_off() {
    let mut line = Line::new();
    line.bench.set("hy_vfd.enable", true);
    line.pass(500);
    let Line { bench, far, near, .. } = line;
    drop((far, near));
    for _ in 0..1000 {
        bench.pass(MS);
        bench.run("hy_vfd", MS);
        bench.work("hy_vfd", 1).unwrap();
    }
    assert!(bench.get::<bool>("hy_vfd.fault"));
    assert_eq!((bench.failed_hardware(), bench.get::<u32>("hy_vfd.errors-line")), (1, 1));
    let said = bench.said().join("\n");
    assert!(said.contains("the serial line of the inverter is lost"), "{said}");
    assert!(said.contains("is the adapter plugged in?"), "{said}");
}

/// The adapter is back before the inverter counts as lost.
#[test]
fn a_spindle_stands_after_a_short_loss_of_its_line() {
    let mut line = Line::new();
    line.bench.set("hy_vfd.enable", true);
    line.bench.set("hy_vfd.speed-command", 12_000.0);
    line.bench.set("hy_vfd.spindle-forward", true);
    line.pass(1000);
    line.bench.set("hy_vfd.spindle-on", true);
    line.pass(1000);
    assert!(line.inverter.runs());
    let before = line.frames.len();
    line.replug();
    line.pass(2000);
    assert_eq!(line.bench.get::<u32>("hy_vfd.errors-line"), 1);
    assert_eq!(line.frames[before], [1, 3, 1, 8, 0xF1, 0x8E], "a stop comes first");
    assert_eq!((line.inverter.runs(), line.inverter.starts()), (false, 1));
    assert!(!line.bench.get::<bool>("hy_vfd.fault") && line.bench.get::<bool>("hy_vfd.hycomm-ok"));
    line.bench.set("hy_vfd.spindle-on", false);
    line.pass(100);
    line.bench.set("hy_vfd.spindle-on", true);
    line.pass(100);
    assert_eq!((line.inverter.runs(), line.inverter.starts()), (true, 2));
}

#[test]
fn the_loss_of_a_line_is_noticed_while_nothing_is_asked() {
    let mut line = Line::new();
    line.pass(1000);
    assert_eq!(line.frames.len(), 1, "the stop of the load");
    line.replug();
    line.pass(1000);
    assert_eq!(line.bench.get::<u32>("hy_vfd.errors-line"), 1);
    assert!(!line.bench.get::<bool>("hy_vfd.fault"));
    assert!(line.bench.said().join("\n").contains("the serial line of the inverter is lost"));
}

#[test]
fn the_end_of_the_component_is_a_stop_on_the_line() {
    let mut line = Line::new();
    line.bench.set("hy_vfd.enable", true);
    line.bench.set("hy_vfd.speed-command", 12_000.0);
    line.bench.set("hy_vfd.spindle-forward", true);
    line.pass(500);
    line.bench.set("hy_vfd.spindle-on", true);
    line.pass(1000);
    assert!(line.inverter.runs());
    let Line { bench, far, near: _near, .. } = line;
    drop(bench);
    let mut came = Vec::new();
    while !came.ends_with(&[1, 3, 1, 8, 0xF1, 0x8E]) {
        let mut into = [0; 64];
        let count = read(&far, &mut into).unwrap();
        came.extend(&into[..count]);
    }
}
