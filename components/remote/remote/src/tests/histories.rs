//! Operators, one lease, partitions, pauses and restarts: histories of what each of them was answered, checked by a model.

mod operator;

use crate::Remote;
use hal_bench::{
    Bench, Random,
    history::{
        Event, Right,
        RightCall::{self, Lose, Restart, Seen},
        explain,
    },
};
use operator::{Message, Operator, Request};
use std::collections::BTreeSet;

/// Time of a cycle in milliseconds, and number of cycles of a history.
const CYCLE_MS: u32 = 5;
const CYCLES: u32 = 600;
/// Age of a beat up to which the lease lasts, in milliseconds.
const LEASE_MS: u32 = 200;
/// Number of histories.
const HISTORIES: u64 = 3000;
/// Number of histories in which a planted fault is found at the latest.
const WITH_FAULT: u64 = 200;

/// Refusal of a command, in the plugin's words.
#[derive(Debug)]
struct Refusal(String);

/// Fault that is planted between the operators and the plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    /// None.
    None,
    /// A lease that was given back lasts.
    LostRelease,
    /// A lease whose beats have ended lasts.
    LostExpiry,
    /// A lease ends although its beats come.
    EarlyExpiry,
    /// An operator who is refused the lease is answered as if it were given.
    TwoHolders,
    /// A command is obeyed without the lease.
    CommandWithoutLease,
    /// A lease outlives a restart.
    HolderAfterRestart,
}

/// The lease, as the rules of beats have it: who holds it, and since when nothing has renewed it.
#[derive(Clone, Copy, Debug)]
struct Held {
    right: u64,
    /// Machine time at which the servo thread has seen it first.
    taken: Option<u32>,
    /// Pulse that came back last.
    beat: Option<u32>,
}

/// Call in progress: its answer, once the plugin has given one, and its moments.
#[derive(Clone, Copy, Debug)]
struct Open {
    call: Option<RightCall>,
    begun: u64,
    ended: Option<u64>,
}

/// The plugin, the operators, and the ways between them.
struct World {
    bench: Bench,
    fault: Fault,
    random: Random,
    operators: Vec<Operator>,
    calls: Vec<Open>,
    /// Number of events so far: the moments of a history.
    moment: u64,
    /// Machine time in milliseconds.
    now: u32,
    /// The last pulse.
    pulse: u32,
    /// Number of restarts. The plugin gives a lease a number that none had before.
    restarts: u64,
    held: Option<Held>,
    /// Pauses of the plugin's process: cycles until it goes on.
    stands: u32,
}

/// Returns a bench with the plugin, loaded at this time of its clock, in ms.
fn bench_at(ms: i64) -> Bench {
    let mut bench = Bench::new();
    bench.pass(ms * 1_000_000);
    bench.load::<Remote>(&["motion=0", "lease_timeout=0.2"]).unwrap();
    bench
}

/// Returns the plugin's number of a lease, also of one before a restart.
fn number(right: u64) -> u32 {
    u32::try_from(right & 0xffff_ffff).unwrap()
}

impl World {
    fn new(seed: u64, fault: Fault) -> Self {
        let operators = (0..3).map(|_| Operator::default()).collect();
        let (random, bench) = (Random::new(seed), bench_at(0));
        Self {
            bench,
            fault,
            random,
            operators,
            calls: Vec::new(),
            moment: 0,
            now: 0,
            pulse: 0,
            restarts: 0,
            held: None,
            stands: 0,
        }
    }

    fn moment(&mut self) -> u64 {
        self.moment += 1;
        self.moment
    }

    /// Notes something that happens at once.
    fn note(&mut self, call: RightCall, begun: u64) {
        let ended = Some(self.moment());
        self.calls.push(Open { call: Some(call), begun, ended });
    }

    /// Returns the number of a lease in the whole history.
    const fn right(&self, number: u32) -> u64 {
        (self.restarts << 32) | number as u64
    }

    fn command(&self, name: &str, args: &str) -> Result<String, Refusal> {
        let args: Vec<&str> = args.split_whitespace().collect();
        self.bench.command(name, &args).map(|lines| lines.concat()).map_err(Refusal)
    }

    /// Lets the plugin take the lease; returns its number in the history.
    fn take(&mut self, args: &str) -> Option<u64> {
        let taken = self.command("remote.take", &format!("holder=ana {args}"));
        let number = match (taken, self.fault) {
            (Ok(line), _) => line.strip_prefix("lease=").unwrap().parse().unwrap(),
            // No other lease has this number.
            (Err(_), Fault::TwoHolders) => u32::MAX - u32::try_from(self.calls.len()).unwrap(),
            (Err(_), _) => return None,
        };
        let right = self.right(number);
        self.held = Some(Held { right, taken: None, beat: None });
        Some(right)
    }

    /// Executes a request as the plugin does; returns the answer.
    fn execute(&mut self, request: Request) -> RightCall {
        match request {
            Request::Take => match self.take("") {
                Some(right) => RightCall::Take(right),
                None => RightCall::NotTaken,
            },
            Request::Hand(from) => {
                match self.take(&format!("from={}", number(from))) {
                    Some(right) => RightCall::Hand(from, right),
                    // The refusal of a lease that is not the one handed over.
                    None => RightCall::Use(from, false),
                }
            }
            Request::Give(right) => {
                let given = match self.fault {
                    Fault::LostRelease => self.judge("remote.beat", right),
                    _ => self.judge("remote.give", right),
                };
                if given {
                    self.held = None;
                }
                RightCall::Give(right, given)
            }
            Request::Use(right, command) => {
                let done = self.judge(command, right);
                RightCall::Use(right, done || self.fault == Fault::CommandWithoutLease)
            }
            Request::Look => {
                let line = self.command("remote.status", "").unwrap();
                let number = line.strip_prefix("lease=").unwrap().split(' ').next().unwrap();
                let number: u32 = number.parse().unwrap();
                Seen(if number == 0 { 0 } else { self.right(number) })
            }
            Request::Beat(right, pulse) => {
                let args = format!("lease={} pulse={pulse}", number(right));
                let done = self.command("remote.beat", &args).is_ok();
                if let Some(held) = &mut self.held
                    && done
                    && held.right == right
                {
                    held.beat = Some(pulse);
                }
                RightCall::Use(right, done)
            }
        }
    }

    /// Gives a command under a lease; returns false if it is refused for want of it. Other refusals concern its holder.
    fn judge(&self, name: &str, right: u64) -> bool {
        match self.command(name, &format!("lease={}", number(right))) {
            Ok(_) => true,
            Err(Refusal(why)) => !why.starts_with("this is not the number of the control lease"),
        }
    }

    /// Lets the messages arrive that are due, each operator's in their order.
    fn arrive(&mut self) {
        let mut order: Vec<usize> = (0..self.operators.len()).collect();
        self.random.shuffle(&mut order);
        for n in order {
            while let Some(message) = self.operators[n].up.due(self.now) {
                let answer = self.execute(message.request);
                if let Some(call) = message.call {
                    self.calls[call].call = Some(answer);
                }
                let delay = self.delay();
                self.operators[n]
                    .down
                    .send(self.now + delay, Message { answer: Some(answer), ..message });
            }
        }
    }

    fn delay(&mut self) -> u32 {
        u32::try_from(self.random.below(30)).unwrap()
    }

    /// Lets machine time pass; the lease ends as the rule says.
    fn cycle(&mut self, ms: u32) {
        let begun = self.moment();
        self.now += ms;
        self.bench.pass(i64::from(ms) * 1_000_000);
        if self.fault == Fault::EarlyExpiry && self.random.below(100) == 0 {
            let line = self.command("remote.status", "").unwrap();
            drop(self.command("remote.give", line.split(' ').next().unwrap()));
        }
        let keeps = self.held.filter(|_| self.fault == Fault::LostExpiry);
        if let Some(held) = keeps {
            let args = format!("lease={} pulse={}", number(held.right), self.now - ms);
            drop(self.command("remote.beat", &args));
        }
        self.bench.run("remote", i64::from(CYCLE_MS) * 1_000_000);
        self.pulse = self.bench.get("remote.pulse");
        assert_eq!(self.pulse, self.now);
        if self.now.is_multiple_of(2 * CYCLE_MS) {
            self.bench.run("remote-keeper", 10_000_000);
        }
        let Some(held) = &mut self.held else { return };
        let taken = *held.taken.get_or_insert(self.now);
        let renewed = held.beat.filter(|beat| taken < *beat).unwrap_or(taken);
        if self.now - renewed > LEASE_MS {
            let right = held.right;
            self.held = None;
            self.note(Lose(right), begun);
        }
    }

    /// Begins again: connections are cut, and who called has no answer.
    fn restart(&mut self) {
        let begun = self.moment();
        if self.fault != Fault::HolderAfterRestart {
            // The computer's clock goes on.
            self.bench = bench_at(i64::from(self.now));
            self.restarts += 1;
            self.held = None;
        }
        self.operators.iter_mut().for_each(Operator::cut);
        self.note(Restart, begun);
        if self.fault != Fault::HolderAfterRestart {
            self.cycle(CYCLE_MS);
        }
        let begun = self.moment();
        let seen = self.execute(Request::Look);
        self.note(seen, begun);
    }

    /// Something that goes wrong, now and then.
    fn trouble(&mut self) {
        let (n, time) = (self.random.index(self.operators.len()), self.random.below(600));
        let until = self.now + u32::try_from(time).unwrap();
        match self.random.below(1200) {
            0..10 => self.operators[n].up.hold(until),
            10..20 => self.operators[n].down.hold(until),
            20..30 => self.operators[n].stands_until = until,
            30..35 => self.operators[n].cut(),
            35..40 => self.stands = u32::try_from(time).unwrap() / CYCLE_MS,
            40..42 => self.restart(),
            42..50 => drop(self.command("remote.release", "")),
            _ => {}
        }
    }

    /// Lets the operators send what they send.
    fn act(&mut self) {
        for n in 0..self.operators.len() {
            let moment = self.moment();
            let Self { operators, random, calls, now, pulse, .. } = self;
            let operator = &mut operators[n];
            if *now < operator.stands_until {
                continue;
            }
            while let Some(message) = operator.down.due(*now) {
                if let Some(call) = message.call {
                    calls[call].ended = Some(moment);
                }
                operator.answered(message);
            }
            let delay = u32::try_from(random.below(30)).unwrap();
            // The page sends each pulse back that it gets; here it gets them with the answers.
            if let Some(request) = operator.beat(*now, *pulse) {
                operator.up.send(*now + delay, Message { request, call: None, answer: None });
            }
            if let Some(request) = operator.next(random) {
                let call = Some(calls.len());
                calls.push(Open { call: None, begun: moment, ended: None });
                operator.up.send(*now + delay, Message { request, call, answer: None });
            }
        }
    }

    /// Returns the history: what nobody has executed is no part of it.
    fn run(mut self) -> Vec<Event<RightCall>> {
        self.cycle(CYCLE_MS);
        for _ in 0..CYCLES {
            self.trouble();
            self.act();
            if self.stands > 0 {
                // Nothing arrives and no cycle runs; machine time is behind all the more when it goes on.
                self.stands -= 1;
                self.now += CYCLE_MS;
                self.bench.pass(i64::from(CYCLE_MS) * 1_000_000);
                continue;
            }
            self.arrive();
            self.cycle(CYCLE_MS);
        }
        let event =
            |open: Open| Some(Event { call: open.call?, begun: open.begun, ended: open.ended });
        self.calls.into_iter().filter_map(event).collect()
    }
}

#[test]
fn every_history_is_one_of_a_right_that_one_operator_has_at_a_time() {
    let mut kinds = [0_u32; 9];
    for seed in 0..HISTORIES {
        let history = World::new(seed, Fault::None).run();
        if let Err(why) = explain(&Right, &history) {
            let stuck: Vec<_> = why.stuck.iter().map(|n| &history[*n]).collect();
            let before: Vec<_> = why.order.iter().rev().take(8).map(|n| &history[*n]).collect();
            panic!("seed {seed}: no order explains {stuck:#?} after {before:#?}");
        }
        let mut given = BTreeSet::new();
        for event in &history {
            let (kind, new) = match event.call {
                RightCall::Take(right) => (0, Some(right)),
                RightCall::NotTaken => (1, None),
                RightCall::Hand(_, right) => (2, Some(right)),
                RightCall::Give(_, done) => (if done { 3 } else { 4 }, None),
                RightCall::Use(_, done) => (if done { 5 } else { 6 }, None),
                Lose(_) => (7, None),
                Seen(_) | Restart => (8, None),
            };
            kinds[kind] += 1;
            assert!(new.is_none_or(|right| given.insert(right)), "seed {seed}: {new:?} twice");
        }
    }
    // Each kind of answer is a good part of them.
    let least = u32::try_from(HISTORIES).unwrap() / 10;
    assert!(kinds.iter().all(|count| *count > least), "{kinds:?}");
}

#[test]
fn planted_faults_are_found() {
    for fault in [
        Fault::LostRelease,
        Fault::LostExpiry,
        Fault::EarlyExpiry,
        Fault::TwoHolders,
        Fault::CommandWithoutLease,
        Fault::HolderAfterRestart,
    ] {
        let found = (0..WITH_FAULT)
            .filter(|seed| explain(&Right, &World::new(*seed, fault).run()).is_err())
            .count();
        assert!(found > 0, "{fault:?} is in none of {WITH_FAULT} histories");
    }
}
