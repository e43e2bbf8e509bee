//! Properties that every component must have: nothing in it panics, sane inputs give sane outputs within their limits,
//! the effects of NaN and extreme inputs pass, and equal inputs give equal outputs.

mod bounds;
pub mod case;
mod recover;

use crate::{
    conformance::{
        Style,
        case::{Input, named},
        inputs::{Source, positive, within},
    },
    foreign::Bench,
    machine::{get, says, script, status, thread},
    random::Random,
    random::text_argument,
};
use bounds::Limits;
use case::Case;
use hal_protocol::{
    ArgInfo, CommandInfo, Direction, Kind, Link, Offer, Reply, Request, Type, Value,
};
use std::collections::{BTreeMap, BTreeSet};

/// Minimum number of times that a component is loaded.
const ROUNDS: usize = 6;
/// Number of cycles of each of the three parts of a round.
const CYCLES: u64 = 60;
/// Number of repetitions of the last part, with other inputs, while an integer stays at an end of its type: some are
/// there for a while by chance.
const AGAIN: usize = 4;
/// Number of cycles for which a reset is held.
const HELD: u64 = 5;
/// Number of inputs above which they are not all set in each cycle.
const MANY: u64 = 60;

/// Periods of a fast and a slow thread, in nanoseconds.
const PACES: [(u64, u64); 6] = [
    (1_000_000, 2_000_000),
    (1_000, 5_000),
    (50_000, 1_000_000),
    (33_333, 99_999),
    (1_000_000_000, 3_000_000_000),
    (125_000, 125_000),
];

/// Result of the rounds.
#[derive(Debug, Default)]
struct Report {
    faults: BTreeMap<String, String>,
    /// State after each cycle, as one number.
    trace: Vec<u64>,
    /// Rows of the case file that were needed.
    needed: BTreeSet<String>,
}

/// Examines a component and returns its faults.
///
/// # Errors
/// Its case file is wrong, or the component cannot be loaded.
pub fn examine(offer: &Offer) -> Result<Vec<String>, String> {
    let case = Case::of(offer)?;
    let mut ways = case.ways(offer)?;
    if ways == [""] && offer.args.iter().any(|a| a.name == "count") && case.after.is_empty() {
        ways.extend(["count=3", "names=one,two.b"].map(str::to_owned));
    }
    let first = examined(offer, &case, &ways)?;
    let again = examined(offer, &case, &ways)?;
    let mut out: Vec<String> = first.faults.into_values().collect();
    let same = first.trace.iter().zip(&again.trace).take_while(|(a, b)| a == b).count();
    if same < first.trace.len().max(again.trace.len()) {
        out.push(format!("the second run differs from the first in cycle {same}"));
    }
    let rows = case.inputs.iter().map(|i| &i.pins).chain(case.open.iter().map(|o| &o.pins));
    for pin in rows.flatten().chain(case.stays.iter().flat_map(|s| &s.pins)) {
        if !first.needed.contains(pin) {
            out.push(format!("`{pin}` needs no word: take it out of its file"));
        }
    }
    Ok(out)
}

fn examined(offer: &Offer, case: &Case, ways: &[String]) -> Result<Report, String> {
    let mut report = Report::default();
    let mut bench = Bench::new(&[]);
    let mut random = Random::new(offer.component.bytes().map(u64::from).sum());
    let styles = [Style::Chance, Style::Ramps, Style::Edges];
    let rounds = ROUNDS.div_ceil(ways.len()) * ways.len();
    for number in 0..rounds {
        let way = &ways[number % ways.len()];
        let style = styles[number % styles.len()];
        let mut round = Lifetime {
            said: format!("loadrt {} {way}, round {number}", offer.component),
            bench: &mut bench,
            case,
            random: &mut random,
            report: &mut report,
            items: Vec::new(),
            functs: Vec::new(),
            commands: Vec::new(),
            fast: 0,
            at: 0,
            ends: BTreeSet::new(),
        };
        round.load(offer, way)?;
        round.run(style, number);
        let done = says(&mut bench, "unloadrt all");
        if done != "ok" {
            return Err(format!("unloadrt all: {done}"));
        }
    }
    bench.engine.close();
    Ok(report)
}

/// A pin or parameter, with its stimulus if it has one.
struct Item {
    name: String,
    direction: Direction,
    first: Value,
    source: Option<Source>,
}

impl Item {
    fn given(&self) -> bool {
        matches!(self.direction, Direction::In | Direction::Io | Direction::Rw)
    }
}

/// A component from its load to its unload.
struct Lifetime<'r> {
    said: String,
    bench: &'r mut Bench,
    case: &'r Case,
    random: &'r mut Random,
    report: &'r mut Report,
    items: Vec<Item>,
    functs: Vec<String>,
    commands: Vec<CommandInfo>,
    /// Period of the fast thread, in nanoseconds.
    fast: u64,
    at: u64,
    /// Items that are integers at an end of their type after the last cycle: a saturated sum, or a converted float that
    /// was NaN or too large.
    ends: BTreeSet<usize>,
}

impl Lifetime<'_> {
    fn load(&mut self, offer: &Offer, way: &str) -> Result<(), String> {
        let line = format!("loadrt {} {way}", offer.component);
        for line in self.case.before.iter().chain([&line]).chain(&self.case.after) {
            let said = says(self.bench, line);
            if said != "ok" {
                return Err(format!("{line}: {said}"));
            }
        }
        for kind in [Kind::Pins, Kind::Params] {
            self.items.extend(self.bench.items(kind, "").into_iter().map(|i| Item {
                name: i.name,
                direction: i.direction,
                first: i.value,
                source: None,
            }));
        }
        for pin in self.case.inputs.iter().flat_map(|i| &i.pins) {
            let glob = std::slice::from_ref(pin);
            if self.items.iter().any(|i| i.given() && named(glob, &i.name)) {
                self.report.needed.insert(pin.clone());
            }
        }
        let all = Request::List { kind: Kind::Functs, patterns: Vec::new(), ty: None };
        if let Ok(Reply::Functs(list)) = self.bench.call(all) {
            self.functs = list.into_iter().map(|f| f.name).collect();
        }
        let all = Request::List { kind: Kind::Commands, patterns: Vec::new(), ty: None };
        if let Ok(Reply::Commands(list)) = self.bench.call(all) {
            self.commands = list;
        }
        Ok(())
    }

    /// Runs the three parts, sane inputs, exceptional ones, sane ones again, each with other periods.
    fn run(&mut self, style: Style, number: usize) {
        let mut limits = Limits::of(self.case, self.items.iter().map(|i| &*i.name));
        // Outputs with limits are checked after each run of the component's functions, in one thread.
        self.pace(PACES[number % PACES.len()], !limits.is_empty() || number.is_multiple_of(2));
        self.begin(style);
        let mut sane = BTreeSet::new();
        for _ in 0..CYCLES {
            self.cycle();
            sane.extend(self.ends.iter().copied());
            self.all_finite("with sane inputs");
            for fault in limits.broken(self.bench, self.fast as f64 * 1e-9) {
                self.fault(&fault.0, &fault.1);
            }
        }
        self.pace(PACES[(number + 1 + number / 6) % PACES.len()], false);
        self.begin(Style::Extremes);
        for _ in 0..CYCLES {
            self.cycle();
        }
        self.pace(PACES[(number + 3) % PACES.len()], number.is_multiple_of(3));
        let mut stuck: BTreeSet<usize> =
            (0..self.items.len()).filter(|i| !sane.contains(i)).collect();
        for _ in 0..AGAIN {
            self.begin(Style::Chance);
            for _ in 0..CYCLES {
                self.cycle();
                stuck.retain(|i| self.ends.contains(i));
            }
            if stuck.is_empty() {
                break;
            }
        }
        self.recover(&stuck);
    }

    /// Moves the functions to threads of other periods, in another order.
    fn pace(&mut self, (fast, slow): (u64, u64), one: bool) {
        self.random.shuffle(&mut self.functs);
        let threads = self.case.threads.clone();
        if let Some(first) = threads.first() {
            self.fast = u64::try_from(thread(self.bench, first).period).unwrap();
            for f in &self.functs {
                let to = &threads[if one { 0 } else { self.random.index(threads.len()) }];
                says(self.bench, &format!("delf {f}"));
                script(self.bench, &format!("addf {f} {to}"));
            }
        } else {
            self.fast = fast;
            says(self.bench, "unloadrt threads");
            let line = format!("loadrt threads name1=f period1={fast} name2=s period2={slow}");
            script(self.bench, &line);
            for f in &self.functs {
                let slow = !one && self.random.below(3) == 0;
                script(self.bench, &format!("addf {f} {}", if slow { "s" } else { "f" }));
            }
        }
        // Refused after a function has failed; that failure is reported separately.
        says(self.bench, "start");
    }

    /// Gives every input a first value of a style, and calls the commands with valid arguments.
    fn begin(&mut self, style: Style) {
        for item in self.items.iter_mut().filter(|i| i.given()) {
            let keeps = |is: fn(&Input) -> bool| {
                self.case.inputs.iter().any(|i| is(i) && named(&i.pins, &item.name))
            };
            item.source = (!keeps(|i| i.alone)).then(|| Source::new(style, self.random));
        }
        self.drive(true);
        for c in self.commands.clone() {
            let args = c.args.iter().filter_map(|a| self.argument(a)).collect();
            // Most commands are refused, which is irrelevant to the properties.
            drop(self.bench.call(Request::Command { name: c.name, args }));
        }
    }

    fn argument(&mut self, a: &ArgInfo) -> Option<String> {
        let r = &mut *self.random;
        if !a.required && r.index(2) == 0 {
            return None;
        }
        let value = match &*a.ty {
            "float" => format!("{}", r.unit() * 100.0),
            "int" | "ints" => r.below(4).to_string(),
            "bit" => r.below(2).to_string(),
            _ => text_argument(&a.name, r).to_owned(),
        };
        Some(format!("{}={value}", a.name))
    }

    /// Sets the inputs that are due.
    fn drive(&mut self, all: bool) {
        let given = self.items.iter().filter(|i| i.source.is_some()).count();
        let many = u64::try_from(given).unwrap() / MANY;
        for i in 0..self.items.len() {
            let item = &mut self.items[i];
            let Some(source) = &mut item.source else { continue };
            let (name, first) = (&item.name, item.first);
            let rows = self.case.inputs.iter().filter(|i| named(&i.pins, name));
            // Exceptional values ignore the constraints of the case file.
            let rows: Vec<&Input> = rows.filter(|_| !source.is_odd()).collect();
            if let Some(value) = rows.iter().find_map(|i| i.set.as_deref()) {
                if all {
                    script(self.bench, &format!("setp {name} {value}"));
                }
                continue;
            }
            let mut next = source.next(first, self.random);
            while all && next.is_none() && first.ty() != Type::Port {
                next = source.next(first, self.random);
            }
            let seldom = !matches!(item.direction, Direction::In);
            let held = self.case.is_rate(name) || rows.iter().any(|i| i.steady);
            let due = all
                || !(held
                    || seldom && self.random.below(100) != 0
                    || self.random.below(many + 1) != 0);
            let Some(mut value) = next.filter(|_| due) else { continue };
            for row in rows {
                if row.positive {
                    value = positive(value);
                }
                value = row.range.map_or(value, |range| within(value, range));
            }
            self.bench.set(name, value);
        }
    }

    fn cycle(&mut self) {
        self.drive(false);
        self.run_once();
    }

    fn run_once(&mut self) {
        self.bench.call(Request::Run { ns: self.fast }).unwrap();
        self.at += 1;
        let mut trace = 0xcbf2_9ce4_8422_2325_u64;
        self.ends.clear();
        for (n, i) in self.items.iter().enumerate() {
            let value = get(self.bench, &i.name);
            if recover::is_end(value) {
                self.ends.insert(n);
            }
            trace = (trace ^ value.bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(17);
        }
        self.report.trace.push(trace);
        if let Some(fault) = status(self.bench).fault {
            self.fault(&fault.funct, &format!("has failed: {}", fault.cause));
        }
    }

    /// Returns the outputs that are not finite.
    fn odd(&mut self) -> Vec<(String, f64)> {
        let floats = self.items.iter().filter(|i| i.first.ty() == Type::Float);
        let mut out = Vec::new();
        for i in floats {
            if let Value::Float(f) = get(self.bench, &i.name)
                && !f.is_finite()
            {
                out.push((i.name.clone(), f));
            }
        }
        out
    }

    fn all_finite(&mut self, when: &str) {
        for (name, value) in self.odd() {
            if let Some(row) = self.case.open(&name) {
                self.report.needed.extend(row.pins.iter().cloned());
            } else {
                self.fault(&name, &format!("is {value} {when}"));
            }
        }
    }

    /// Records the first fault of each kind.
    fn fault(&mut self, name: &str, what: &str) {
        let (said, at) = (&self.said, self.at);
        let kind = format!("{name} {}", what.split(' ').next().unwrap_or_default());
        self.report
            .faults
            .entry(kind)
            .or_insert_with(|| format!("`{name}` {what} ({said}, cycle {at})"));
    }
}
