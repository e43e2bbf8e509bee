//! Two operators of the panel and one beside it, one lease, cuts, pauses and restarts: histories of what each of them was answered,
//! checked by a model.

use super::printer::Printer;
use hal_bench::{
    Random,
    history::{
        Event, Right,
        RightCall::{self, Give, Hand, Lose, NotTaken, Restart, Take, Use},
        explain,
    },
};
use hal_protocol::{Client, Link as _, Reply, Request};
use hal_tests::{scratch::until, web::Socket};
use rustix::process::Signal;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Number of histories, and of steps in each.
const HISTORIES: u64 = 24;
const STEPS: u32 = 24;
/// Machine time in which a lease without beats ends for certain, and the panel learns of it: nanoseconds.
const LOSS_NS: u64 = 2_000_000_000;

/// Fault that is planted between the operators and the checker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    None,
    /// Commands of an operator who has lost the lease are answered as if they were obeyed.
    CommandWithoutLease,
    /// A connection that is cut is another than the holder's.
    LostRelease,
}

/// Request of an operator of the panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    Take,
    Give(u64),
    Use(u64),
}

/// An operator of the panel.
struct Operator {
    socket: Socket,
    right: Option<u64>,
    last: u64,
    /// Number of the last message.
    id: u64,
}

impl Operator {
    fn new(printer: &Printer) -> Self {
        Self { socket: printer.sign_in().socket(), right: None, last: u64::MAX, id: 1000 }
    }

    /// Chooses a call: without the lease, sometimes as one that does not know of its loss.
    fn choose(&self, random: &mut Random) -> Asked {
        match (self.right, random.below(6)) {
            (Some(right), 0) => Asked::Give(right),
            (Some(right), _) => Asked::Use(right),
            (None, 0..2) => Asked::Use(self.last),
            (None, _) => Asked::Take,
        }
    }

    fn send(&mut self, asked: Asked) {
        self.id += 1;
        let message = match asked {
            Asked::Take => json!({ "type": "lease", "do": "take", "id": self.id }),
            Asked::Give(_) => json!({ "type": "lease", "do": "give", "id": self.id }),
            Asked::Use(_) => {
                let args = json!({ "on": true });
                json!({ "type": "command", "name": "optional-stop", "args": args, "id": self.id })
            }
        };
        self.socket.send(&message);
    }

    /// Returns the answer to the last message, as the history has it; `next` is the number of a lease that begins.
    fn answer(&mut self, asked: Asked, next: u64) -> RightCall {
        let id = self.id;
        let reply = self.socket.wait(|m| m["type"] == "reply" && m["id"] == id).unwrap();
        let code = reply["error"]["code"].as_str().unwrap_or_default();
        let refused = |codes: &[&str]| assert!(codes.contains(&code), "{asked:?}: {reply}");
        match (asked, reply["error"].is_null()) {
            (Asked::Take, true) => {
                (self.right, self.last) = (Some(next), next);
                Take(next)
            }
            (Asked::Take, false) => {
                refused(&["conflict", "refused"]);
                NotTaken
            }
            // Who gives back what they do not have any more is not refused.
            (Asked::Give(right), _) => {
                self.right = None;
                Lose(right)
            }
            (Asked::Use(right), true) => Use(right, true),
            (Asked::Use(right), false) => {
                refused(&["lease"]);
                self.right = None;
                Use(right, false)
            }
        }
    }
}

struct Stage {
    printer: Printer,
    /// The operator beside the panel, whose program asks the plugin itself.
    beside: Client,
    own: Option<(u64, String)>,
    /// The plugin's numbers of leases.
    numbers: BTreeMap<String, u64>,
    operators: [Operator; 2],
    fault: Fault,
    /// Connections that last, though their operators have left.
    kept: Vec<Socket>,
    history: Vec<Event<RightCall>>,
    moment: u64,
    rights: u64,
}

impl Stage {
    fn new(fault: Fault) -> Self {
        let clock = ["--virtual", "--hold"];
        let printer = Printer::leased("operator", &clock, 1);
        let mut beside = Client::connect(&printer.scratch.place("default"), "").unwrap();
        beside.call(Request::Run { ns: LOSS_NS }).unwrap();
        let operators = [Operator::new(&printer), Operator::new(&printer)];
        let (history, own) = (Vec::new(), None);
        let numbers = BTreeMap::new();
        let (moment, rights, kept) = (0, 0, Vec::new());
        Self { printer, beside, own, numbers, operators, fault, kept, history, moment, rights }
    }

    fn moment(&mut self) -> u64 {
        self.moment += 1;
        self.moment
    }

    fn right(&mut self) -> u64 {
        self.rights += 1;
        self.rights
    }

    fn note(&mut self, call: RightCall, begun: u64) {
        let ended = Some(self.moment());
        self.history.push(Event { call, begun, ended });
    }

    fn command(&mut self, name: &str, args: &str) -> Option<String> {
        let args = args.split_whitespace().map(str::to_owned).collect();
        match self.beside.call(Request::Command { name: name.to_owned(), args }) {
            Ok(Reply::Answer(answer)) => Some(answer.lines.concat()),
            Ok(_) => Some(String::new()),
            Err(_) => None,
        }
    }

    /// Returns the plugin's number of the lease; `0` is nobody's.
    fn number(&mut self) -> String {
        let line = self.command("remote.status", "").unwrap();
        line.strip_prefix("lease=").unwrap().split(' ').next().unwrap().to_owned()
    }

    /// Both operators ask at the same time.
    fn both(&mut self, random: &mut Random) {
        let asked = self.operators.each_ref().map(|operator| operator.choose(random));
        let mut begun = [0; 2];
        for (n, asked) in asked.iter().enumerate() {
            begun[n] = self.moment();
            self.operators[n].send(*asked);
        }
        for (n, asked) in asked.into_iter().enumerate() {
            let next = self.right();
            let mut answer = self.operators[n].answer(asked, next);
            if let (Use(right, false), Fault::CommandWithoutLease) = (answer, self.fault) {
                answer = Use(right, true);
            }
            self.note(answer, begun[n]);
            if let Take(right) = answer {
                // Nobody takes it from there but later.
                let number = self.number();
                self.numbers.insert(number, right);
            }
        }
    }

    /// The operator beside the panel asks for the lease, or uses it, or gives it back.
    fn beside(&mut self, random: &mut Random) {
        let begun = self.moment();
        let call = match (self.own.clone(), random.below(4)) {
            (None, _) => match self.command("remote.take", "holder=eva") {
                Some(line) => {
                    let right = self.right();
                    self.own = Some((right, line));
                    Take(right)
                }
                None => NotTaken,
            },
            (Some((right, lease)), 0..2) => {
                self.own = None;
                Give(right, self.command("remote.give", &lease).is_some())
            }
            (Some((right, lease)), _) => {
                let done = self.command("remote.beat", &lease).is_some();
                self.own = self.own.take().filter(|_| done);
                Use(right, done)
            }
        };
        self.note(call, begun);
    }

    /// The operator beside takes the lease over while the panel stands still; what the panel finds then is late.
    fn pause(&mut self) {
        let number = self.number();
        let Some(before) = self.numbers.get(&number).copied() else { return };
        let holder = self.operators.iter().position(|operator| operator.right == Some(before));
        let Some(n) = holder else { return };
        self.printer.signal_panel(Signal::STOP);
        let begun = self.moment();
        let line = self.command("remote.take", &format!("holder=eva from={number}")).unwrap();
        let right = self.right();
        self.own = Some((right, line));
        self.note(Hand(before, right), begun);
        let begun = self.moment();
        self.operators[n].send(Asked::Use(before));
        self.printer.signal_panel(Signal::CONT);
        let mut answer = self.operators[n].answer(Asked::Use(before), 0);
        if self.fault == Fault::CommandWithoutLease {
            answer = Use(before, true);
        }
        self.note(answer, begun);
    }

    /// The connection of an operator is cut: the panel gives the lease back.
    fn cut(&mut self, n: usize) {
        let begun = self.moment();
        let before = self.operators[n].right;
        let number = self.number();
        let new = Operator::new(&self.printer);
        let old = core::mem::replace(&mut self.operators[n], new);
        match self.fault {
            Fault::LostRelease => self.kept.push(old.socket),
            _ => drop(old.socket),
        }
        let Some(right) = before else { return };
        if self.fault == Fault::None && self.own.is_none() {
            until("the lease is given back", || self.number() != number || number == "0");
        }
        self.note(Lose(right), begun);
    }

    /// Returns who has the lease, as the panel shows it.
    fn shown(&self) -> Value {
        let mut socket = self.printer.sign_in().open();
        socket.wait(|m| m["type"] == "status").unwrap()["panel"]["lease"].clone()
    }

    /// Nobody answers a pulse for so long that every lease ends.
    fn silence(&mut self) {
        let begun = self.moment();
        self.beside.call(Request::Run { ns: LOSS_NS }).unwrap();
        until("the panel knows of the loss", || {
            self.beside.call(Request::Run { ns: 10_000_000 }).unwrap();
            self.shown().is_null()
        });
        let own = self.own.take().map(|(right, _)| right);
        for right in self.operators.each_ref().map(|one| one.right).into_iter().flatten().chain(own)
        {
            self.note(Lose(right), begun);
        }
    }

    /// The panel is killed and begins again: nobody has the lease once that of the old one has ended.
    fn restart(&mut self) {
        let begun = self.moment();
        self.printer.signal_panel(Signal::KILL);
        self.printer.begin_again("operator");
        self.beside.call(Request::Run { ns: LOSS_NS }).unwrap();
        self.own = None;
        self.operators = [Operator::new(&self.printer), Operator::new(&self.printer)];
        self.note(Restart, begun);
        let begun = self.moment();
        let seen = if self.number() == "0" { 0 } else { u64::MAX };
        self.note(RightCall::Seen(seen), begun);
    }

    fn run(&mut self, seed: u64) -> Vec<Event<RightCall>> {
        let mut random = Random::new(seed);
        for _ in 0..STEPS {
            match random.below(16) {
                0..8 => self.both(&mut random),
                8..11 => self.beside(&mut random),
                11..13 => self.pause(),
                13 => self.cut(random.index(2)),
                14 => self.silence(),
                _ if random.below(4) == 0 => self.restart(),
                _ => self.both(&mut random),
            }
        }
        // The next history begins without a lease.
        self.silence();
        core::mem::take(&mut self.history)
    }
}

#[test]
fn every_history_of_the_panel_is_one_of_a_right_that_one_operator_has_at_a_time() {
    let mut stage = Stage::new(Fault::None);
    let (mut calls, mut taken) = (0, 0);
    for seed in 0..HISTORIES {
        let history = stage.run(seed);
        if let Err(why) = explain(&Right, &history) {
            let stuck: Vec<_> = why.stuck.iter().map(|n| &history[*n]).collect();
            panic!("history {seed}: no order explains {stuck:?} in {history:#?}");
        }
        calls += history.len();
        taken += history.iter().filter(|event| matches!(event.call, Take(_))).count();
    }
    assert!(calls > 400 && taken > 40, "{calls} calls, {taken} leases");
}

#[test]
fn faults_between_the_panel_and_its_operators_are_found() {
    for fault in [Fault::CommandWithoutLease, Fault::LostRelease] {
        let mut stage = Stage::new(fault);
        let found = (0..HISTORIES).any(|seed| explain(&Right, &stage.run(seed)).is_err());
        assert!(found, "{fault:?}");
    }
}
