//! Cuts of the connection during a held jog, on the real clock: the dead man ends each jog in time, and nothing moves
//! after a reconnect.

mod eye;
mod hand;
mod judge;
mod link;
mod tabs;

use super::printer::Printer;
use eye::{Eye, Seen};
use hal_bench::Random;
use hal_tests::{
    browser::Browser,
    proxy::Proxy,
    scratch::{Running, until},
};
use judge::{Row, judge, table};
use link::Net;
use rustix::process::Signal;
use std::{
    fs,
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::PathBuf,
};

/// Velocity of the jogs in millimetres per second.
const VELOCITY: f64 = 60.0;
/// Place of X from which jogs go back, in millimetres.
const FAR: f64 = 75.0;
/// Time in seconds after which the lease of a panel that was killed is free.
const LEASE: u32 = 3;
/// The same for pages, which a busy computer lets answer late.
const PAGE_LEASE: u32 = 60;
/// Cycles at a constant speed before a cut, at least and at most.
const BEFORE: (usize, usize) = (40, 140);
/// Cycles after a reconnect in which nothing may move.
const WATCHED: usize = 400;
/// Largest delay of a message in milliseconds.
const LONGEST_MS: usize = 2000;
/// Delay up to which a jog may go on: the dead man permits it.
const SHORT_MS: usize = 95;
/// Jogs that may end before their cut, for each cut: the computer is busy.
const REPEATS: u32 = 200;

/// Ways in which a connection ends, without a browser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// The client is killed.
    Client,
    /// The link goes down.
    Link,
    /// All messages are delayed.
    Delay,
    /// The panel is stopped, and goes on later.
    Stopped,
    /// The panel is killed, and another one is started.
    Killed,
}

impl Way {
    const fn name(self) -> &'static str {
        match self {
            Self::Client => "client killed",
            Self::Link => "link down",
            Self::Delay => "messages delayed",
            Self::Stopped => "panel stopped",
            Self::Killed => "panel killed",
        }
    }
}

/// The printer, homed, and what is between it and its clients.
struct Stage {
    printer: Printer,
    eye: Eye,
    net: Option<Net>,
    proxy: Proxy,
    /// Proxy at this computer's end of the link.
    near: Option<Proxy>,
    random: Random,
    rows: Vec<Row>,
    repeated: u32,
}

/// Switches the machine on and homes it, at the machine itself.
fn ready(printer: &Printer) {
    for line in ["task.estop-reset --wait", "task.on --wait", "task.home joint=all --wait"] {
        printer.halcmd(line);
    }
    until("all joints are homed", || printer.halcmd("getp motion.is-all-homed").trim() == "TRUE");
}

impl Stage {
    /// Starts the printer; its lease lasts so many seconds without a beat, and its link, if any, can be cut.
    fn set(seed: u64, lease: u32, net: Option<Net>) -> Self {
        let printer = Printer::leased("integrator", &["--simulate"], lease);
        ready(&printer);
        let local = IpAddr::from(Ipv4Addr::LOCALHOST);
        let proxy = Proxy::start(local, printer.port);
        let near = net.as_ref().map(|net| Proxy::start(net.address, printer.port));
        let eye = Eye::open(&printer.scratch);
        let random = Random::new(seed);
        Self { printer, eye, net, proxy, near, random, rows: Vec::new(), repeated: 0 }
    }

    /// Adds the verdict on a cut.
    fn add(&mut self, row: Result<Row, String>) {
        self.rows.push(row.unwrap_or_else(|why| panic!("cut {}: {why}", self.rows.len() + 1)));
    }

    /// Renews the proxies after the panel was started again at another port.
    fn reach(&mut self) {
        self.proxy = Proxy::start(Ipv4Addr::LOCALHOST.into(), self.printer.port);
        self.near = self.net.as_ref().map(|net| Proxy::start(net.address, self.printer.port));
    }

    /// Starts a client on the way that will be cut. With a velocity it jogs.
    fn hand(&self, way: Way, velocity: f64) -> Running {
        let session = self.printer.sign_in();
        let here = SocketAddr::from((Ipv4Addr::LOCALHOST, self.printer.port));
        let (before, at) = match (way, &self.net, &self.near) {
            (Way::Link, Some(net), Some(near)) => {
                (vec!["ip", "netns", "exec", net.name.as_str()], near.address())
            }
            (Way::Delay, ..) => (Vec::new(), self.proxy.address()),
            _ => (Vec::new(), here),
        };
        hand::start(&self.printer.scratch, &before, at, &session, velocity)
    }

    /// Returns a client whose jog moves X at its full speed, and has not ended.
    fn jogging(&mut self, way: Way) -> Running {
        for _ in 0..REPEATS {
            let x = self.eye.look().map_or(0.0, |s| s.x);
            let velocity = if FAR < x { -VELOCITY } else { VELOCITY };
            let mut hand = self.hand(way, velocity);
            let cycles = BEFORE.0 + self.random.index(BEFORE.1 - BEFORE.0);
            if hand::jogs(&mut hand) && self.eye.moves(cycles) {
                return hand;
            }
            self.repeated += 1;
        }
        panic!("no jog lasts until its cut: {way:?}");
    }

    /// Cuts a jog, judges it, and watches what follows the reconnect.
    fn cut(&mut self, way: Way) {
        let hand = self.jogging(way);
        let delay = self.random.index(LONGEST_MS);
        self.eye.forget();
        let Some(before) = self.eye.look().filter(|s| s.v != 0.0) else {
            self.repeated += 1;
            return self.cut(way);
        };
        match way {
            Way::Client => hand.signal(Signal::KILL),
            Way::Link => self.net.as_ref().unwrap().link(false),
            Way::Delay => self.proxy.delay(delay as u64),
            Way::Stopped => self.printer.signal_panel(Signal::STOP),
            Way::Killed => self.printer.signal_panel(Signal::KILL),
        }
        self.eye.look();
        let mut after = self.eye.seen.len();
        let mut note = String::new();
        if way == Way::Delay {
            note = format!(" by {delay} ms");
            if delay <= SHORT_MS {
                // A short delay may keep the jog: then the end of the client ends it.
                self.eye.pass(2 * SHORT_MS);
                if self.eye.look().is_some_and(|s| s.v == before.v) {
                    note.push_str(", then client killed");
                    self.eye.forget();
                    hand.signal(Signal::KILL);
                    self.eye.look();
                    after = self.eye.seen.len();
                }
            }
        }
        self.eye.rests();
        let seen = self.eye.all();
        let from = seen.iter().position(|s| s.ns == before.ns).unwrap_or(0);
        let row = judge(way.name(), note, &seen[from..], after.saturating_sub(from));
        self.add(row);
        self.reconnect(way, hand);
    }

    /// Mends what was cut, lets a client take the lease, and watches that nothing moves.
    fn reconnect(&mut self, way: Way, hand: Running) {
        self.eye.forget();
        let rest = self.eye.look().unwrap();
        match way {
            Way::Client => {}
            Way::Link => self.net.as_ref().unwrap().link(true),
            Way::Delay => self.proxy.delay(0),
            Way::Stopped => self.printer.signal_panel(Signal::CONT),
            Way::Killed => {
                self.printer.begin_again("integrator");
                self.reach();
            }
        }
        // The client that was cut off is still there; another one comes beside it.
        self.eye.pass(WATCHED / 2);
        let next = self.hand(Way::Client, 0.0);
        until("the new client has the lease, and its beats arrive", || {
            self.eye.look().is_some_and(|s| s.age < 80)
        });
        self.eye.pass(WATCHED / 2);
        unmoved(way.name(), rest, self.eye.all());
        drop((hand, next));
    }

    /// Writes the table to `cuts.md` in the folder that `FERRULE_PICTURES` names, if it does.
    fn end(&self, name: &str) {
        let text = table(&self.rows, self.repeated);
        println!("{text}");
        let Some(folder) = std::env::var_os("FERRULE_PICTURES") else { return };
        fs::write(PathBuf::from(folder).join(name), text).unwrap();
    }
}

/// Checks that X stands where it rested, in each sample.
fn unmoved(way: &str, rest: Seen, seen: &[Seen]) {
    let moved = seen.iter().find(|s| s.x.to_bits() != rest.x.to_bits() || s.v != 0.0);
    assert!(moved.is_none(), "{way}: motion after the reconnect: {rest:?}, then {moved:?}");
}

/// Cuts each way so many times, in a random order.
fn cuts(seed: u64, counts: [(Way, usize); 5]) -> Stage {
    let mut stage = Stage::set(seed, LEASE, Net::make());
    let all = counts.iter().flat_map(|&(way, n)| std::iter::repeat_n(way, n));
    let mut all: Vec<_> = all.filter(|way| *way != Way::Link || stage.net.is_some()).collect();
    stage.random.shuffle(&mut all);
    for way in all {
        stage.cut(way);
    }
    stage
}

#[test]
fn a_cut_connection_ends_a_held_jog() {
    let two = [Way::Client, Way::Link, Way::Delay, Way::Stopped, Way::Killed].map(|way| (way, 2));
    let stage = cuts(1, two);
    assert!(8 <= stage.rows.len(), "{} cuts", stage.rows.len());
    stage.end("cuts-short.md");
}

#[test]
#[ignore = "it takes five minutes: cargo test -p hal-tests --test system panel::cuts::two_hundred -- --ignored"]
fn two_hundred_cuts() {
    let ways = [Way::Client, Way::Link, Way::Delay, Way::Stopped, Way::Killed];
    let mut stage = cuts(18, ways.map(|way| (way, 32)));
    let mut pages = Stage::set(19, PAGE_LEASE, None);
    pages.tabs(40);
    stage.rows.append(&mut pages.rows);
    stage.repeated += pages.repeated;
    let without_browser = if stage.net.is_some() { 160 } else { 128 };
    let in_browser = if Browser::is_there() { 40 } else { 0 };
    assert_eq!(stage.rows.len(), without_browser + in_browser);
    stage.end("cuts.md");
}
