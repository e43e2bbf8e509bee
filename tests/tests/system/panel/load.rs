//! Many viewers, and one that does not read.

use super::printer::Printer;
use hal_protocol::{Client, Kind, Link as _, Reply, Request, ThreadInfo};
use hal_tests::scratch::until;
use serde_json::Value;
use std::{
    fs,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    thread,
};

/// Machine time in milliseconds in which a viewer gets a message, whatever others do: a message takes others 10 s.
const GAP_MS: f64 = 2000.0;
/// Viewers of the measurement.
const VIEWERS: usize = 100;
/// Rounds with viewers and without, one after the other.
const ROUNDS: usize = 6;
/// Machine time of each, in milliseconds.
const ROUND_MS: f64 = 5000.0;
/// Clock ticks of a process's time in a second.
const TICKS: f64 = 100.0;

#[test]
fn a_viewer_that_does_not_read_slows_nobody() {
    let printer = Printer::start("viewer");
    let mut fast = printer.sign_in().socket();
    let mut slow = printer.sign_in().socket();
    slow.narrow();
    let clients = |m: &Value| m["panel"]["clients"].as_array().map(Vec::len);
    fast.wait(|m| clients(m) == Some(2)).unwrap();
    // A message to a client takes 10 s at most: then its connection ends, and the others are told. Until then the
    // other viewer sees the machine move on at least every two seconds.
    let (mut pulse, mut longest, mut got) = (printer.number("getp remote.pulse"), 0.0, 0);
    loop {
        let message = fast.wait(|m| m["type"] == "status").unwrap();
        let now = printer.number("getp remote.pulse");
        longest = f64::max(longest, now - pulse);
        pulse = now;
        got += 1;
        if clients(&message) == Some(1) {
            break;
        }
    }
    assert!(longest < GAP_MS, "the other viewer saw nothing for {longest} ms");
    let mut had = 0;
    while let Some(message) = slow.receive() {
        had += usize::from(message["type"] == "status");
    }
    // Each gets at most one in 50 ms, so 10 s are 200 messages; a busy computer makes fewer.
    assert!(had < got, "the slow viewer had {had} messages, the other {got}");
}

/// Returns the ticks of processor time that a process has used, and its memory in bytes.
fn usage(pid: u32) -> (f64, u64) {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
    let ticks = fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap();
    let status = fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    let kib: u64 = resident.split_whitespace().next().unwrap().parse().unwrap();
    (ticks, kib << 10)
}

/// Wake-ups of the servo thread in a round: their number by delay.
#[derive(Default)]
struct Wakes(Vec<u64>);

impl Wakes {
    fn add(&mut self, before: &ThreadInfo, after: &ThreadInfo) {
        self.0.resize(after.latency.len(), 0);
        let pairs = after.latency.iter().zip(&before.latency);
        for (sum, (after, before)) in self.0.iter_mut().zip(pairs) {
            *sum += after - before;
        }
    }

    /// Returns the bound in microseconds below which this share of the wake-ups lies.
    fn bound(&self, share: f64) -> u64 {
        let all: u64 = self.0.iter().sum();
        let mut sum = 0;
        let bin = self.0.iter().position(|n| {
            sum += n;
            share * all as f64 <= sum as f64
        });
        1 << bin.unwrap_or(0)
    }
}

fn servo(client: &mut Client) -> ThreadInfo {
    let list = Request::List { kind: Kind::Threads, patterns: Vec::new(), ty: None };
    let Reply::Threads(threads) = client.call(list).unwrap() else { panic!("no threads") };
    threads.into_iter().find(|thread| thread.name == "servo-thread").unwrap()
}

#[test]
#[ignore = "a measurement: cargo test -p hal-tests --test system panel::load::a_hundred -- --ignored --nocapture"]
fn a_hundred_viewers() {
    let printer = Printer::start("viewer");
    let place = printer.scratch.place("default");
    let mut client = Client::connect(&place, "").unwrap();
    let sockets: Vec<_> = (0..VIEWERS).map(|_| printer.sign_in()).collect();
    let pulse = || printer.number("getp remote.pulse");
    let round = || {
        let from = pulse();
        until("a round passes", || from + ROUND_MS < pulse());
        (pulse() - from) / 1000.0
    };
    let pid = printer.panel_pid();
    let (mut quiet, mut busy) = (Wakes::default(), Wakes::default());
    let (mut ticks, mut seconds, mut memory) = ([0.0; 2], [0.0; 2], [0; 2]);
    let frames = Arc::new(AtomicU64::new(0));
    for n in 0..ROUNDS {
        for with in [false, true] {
            let ends = Arc::new(AtomicBool::new(false));
            let viewers: Vec<_> = sockets
                .iter()
                .filter(|_| with)
                .map(|session| {
                    let mut socket = session.socket();
                    let (ends, frames) = (ends.clone(), frames.clone());
                    thread::spawn(move || {
                        while !ends.load(Relaxed) && socket.receive().is_some() {
                            frames.fetch_add(1, Relaxed);
                        }
                    })
                })
                .collect();
            let (before, (used, _)) = (servo(&mut client), usage(pid));
            frames.store(0, Relaxed);
            let passed = round();
            let (now, bytes) = usage(pid);
            let wakes = if with { &mut busy } else { &mut quiet };
            wakes.add(&before, &servo(&mut client));
            ticks[usize::from(with)] += now - used;
            seconds[usize::from(with)] += passed;
            memory[usize::from(with)] = memory[usize::from(with)].max(bytes);
            if with {
                let rate = frames.load(Relaxed) as f64 / passed / VIEWERS as f64;
                println!("round {n}: {rate:.1} messages a second for each of {VIEWERS} viewers");
            }
            ends.store(true, Relaxed);
            for viewer in viewers {
                viewer.join().unwrap();
            }
        }
    }
    for (with, wakes) in [(0, &quiet), (1, &busy)] {
        println!(
            "{} viewers: {:.1} % of a processor, {} MiB; wake-ups of the servo thread: 99 % below {} us, 99.9 % below {} us, all below {} us",
            with * VIEWERS,
            100.0 * ticks[with] / TICKS / seconds[with],
            memory[with] >> 20,
            wakes.bound(0.99),
            wakes.bound(0.999),
            wakes.bound(1.0)
        );
    }
}
