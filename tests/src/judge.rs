//! The judge: one of our components and LinuxCNC's own of the same name, in one engine on the
//! virtual clock, given the same inputs and compared after every cycle.

pub mod case;
mod history;
mod inputs;
mod verdict;

pub use inputs::Style;
pub use verdict::Verdict;

use crate::{
    foreign::{Bench, installed},
    machine::{get, script},
    random::Random,
};
use case::Case;
use hal_protocol::{Direction, Kind, Link, Request, Value};
use history::History;
use inputs::{Source, float, of, positive, within};
use std::collections::BTreeMap;

/// How often both are loaded anew: what is not a number stays in a filter for ever, and would hide
/// all that follows.
pub const ROUNDS: usize = 20;
/// Cycles of a round.
pub const CYCLES: u64 = 500;
const PERIOD: u64 = 1_000_000;
/// What is put before the names of LinuxCNC's.
const PREFIX: &str = "c-";

/// Pins and parameters by name, with direction and first value; the prefix is taken off.
type Items = BTreeMap<String, (Direction, Value)>;

/// An input with its way.
struct Driven {
    name: String,
    theirs: String,
    first: Value,
    /// Parameters, and what both sides write, are set now and then.
    seldom: bool,
    steady: bool,
    positive: bool,
    range: Option<[f64; 2]>,
    values: Vec<f64>,
    often: Option<u64>,
    follows: Option<(String, Option<String>)>,
    source: Source,
}

/// Both, side by side.
struct Pair<'c> {
    module: &'c str,
    case: &'c Case,
    verdict: Verdict,
    random: Random,
    bench: Bench,
    history: History,
}

/// Judges a component, in the first so many rounds.
///
/// # Errors
/// One of both cannot be loaded, or what is told of it is wrong.
pub fn judge(module: &str, rounds: usize) -> Result<Verdict, String> {
    let folder = installed().unwrap();
    let case = Case::of(module)?;
    let random = Random::new(module.bytes().map(u64::from).sum());
    let (verdict, bench) = (Verdict::default(), Bench::new(&[&folder]));
    let history = History::default();
    let mut pair = Pair { module, case: &case, verdict, random, bench, history };
    script(&mut pair.bench, &format!("loadrt threads name1=t period1={PERIOD}\nstart"));
    let each = Style::ALL.len() * case.loads.len();
    let whole = case.rounds.unwrap_or(ROUNDS).div_ceil(each) * each;
    for round in 0..rounds.min(whole) {
        let style = Style::ALL[round % Style::ALL.len()];
        let args = &case.loads[round / Style::ALL.len() % case.loads.len()];
        pair.round(round, style, args)?;
    }
    pair.verdict.whole = rounds >= whole;
    Ok(pair.verdict)
}

impl Pair<'_> {
    /// Both loaded, driven, unloaded.
    fn round(&mut self, round: usize, style: Style, args: &str) -> Result<(), String> {
        let (ours, theirs) = self.load(args)?;
        let (mut inputs, outputs) = self.matched(style, &ours, &theirs);
        self.history.begin();
        for cycle in 0..self.case.cycles.unwrap_or(CYCLES) {
            self.drive(&mut inputs, cycle, round % 2 == 1);
            self.bench.call(Request::Run { ns: PERIOD }).unwrap();
            self.verdict.cycles += 1;
            self.compare(style, &outputs);
        }
        let module = self.module;
        script(&mut self.bench, &format!("unloadrt {PREFIX}{module}\nunloadrt {module}"));
        Ok(())
    }

    /// Loads both, their functions in one thread.
    fn load(&mut self, args: &str) -> Result<(Items, Items), String> {
        let (module, b) = (self.module, &mut self.bench);
        let words = args.split(' ').filter(|w| !w.is_empty()).map(str::to_owned).collect();
        b.call(Request::Load { module: module.to_owned(), args: words })
            .map_err(|e| format!("ours: {e}"))?;
        b.load_c(PREFIX, &format!("{module} {args}"))?;
        let theirs = format!("{PREFIX}{module}");
        let found = b.functs(&theirs);
        for f in b.functs(module) {
            let of_theirs = format!("{PREFIX}{f}");
            if !found.contains(&of_theirs) {
                return Err(format!("theirs has no function {f}, but {}", found.join(", ")));
            }
            script(b, &format!("addf {f} t\naddf {of_theirs} t"));
        }
        Ok((items(b, module, ""), items(b, &theirs, PREFIX)))
    }

    /// What both have: what is to be driven, and what is to be compared.
    fn matched(
        &mut self,
        style: Style,
        ours: &Items,
        theirs: &Items,
    ) -> (Vec<Driven>, Vec<(String, String)>) {
        let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
        let (case, v) = (self.case, &mut self.verdict);
        let lone = |a: &Items, b: &Items| -> Vec<_> {
            a.keys().filter(|k| !b.contains_key(*k)).cloned().collect()
        };
        v.ours_only.extend(lone(ours, theirs));
        v.theirs_only.extend(lone(theirs, ours));
        for (name, value) in case.sets(&v.ours_only) {
            self.bench.call(Request::Set { name, value }).unwrap();
        }
        v.names.extend(ours.keys().chain(theirs.keys()).cloned());
        for (name, &(direction, first)) in ours.iter().filter(|(n, _)| theirs.contains_key(*n)) {
            let (other, value) = theirs[name];
            let known = case.kinds.iter().any(|k| case::named(&k.pins, name));
            if (other, value.ty()) != (direction, first.ty())
                && !(known && value.ty() == first.ty())
            {
                let of = |d, v: Value| format!("{d:?} {:?}", v.ty());
                v.shape(name, format!("{}, theirs {}", of(direction, first), of(other, value)));
                continue;
            }
            let of_theirs = format!("{PREFIX}{name}");
            let given = matches!(direction, Direction::In | Direction::Io | Direction::Rw);
            if given && value != first && v.begins(case, name, first, value) {
                self.bench.set(&of_theirs, first);
            }
            if let Some(value) = case.set(name) {
                script(&mut self.bench, &format!("setp {name} {value}\nsetp {of_theirs} {value}"));
            } else if given && !case.keeps(name, |i| i.alone) {
                let tame = matches!(style, Style::Extremes) && case.keeps(name, |i| i.tame);
                let style = if tame { Style::Chance } else { style };
                let often = case.often(name);
                let source = Source::new(style, &mut self.random);
                inputs.push(Driven {
                    name: name.clone(),
                    theirs: of_theirs.clone(),
                    first,
                    seldom: !matches!(direction, Direction::In),
                    steady: case.keeps(name, |i| i.steady),
                    positive: case.keeps(name, |i| i.positive),
                    range: case.range(name),
                    values: case.values(name),
                    often,
                    follows: case.follows(name).map(|(p, by)| (p.into(), by.map(str::to_owned))),
                    source: if often.is_some() { source.each_time() } else { source },
                });
            }
            outputs.push((name.clone(), of_theirs));
        }
        v.compared = v.compared.max(outputs.len());
        (inputs, outputs)
    }

    /// Gives both what is due before a cycle.
    fn drive(&mut self, inputs: &mut [Driven], cycle: u64, all_at_first: bool) {
        for i in inputs {
            if let Some((pin, times)) = &i.follows {
                let by = times
                    .as_ref()
                    .map_or(1.0, |t| t.parse().unwrap_or_else(|_| float(get(&mut self.bench, t))));
                let value = of(i.first, float(get(&mut self.bench, pin)) * by);
                self.bench.set(&i.name, value);
                self.bench.set(&i.theirs, value);
                continue;
            }
            let now_and_then = (cycle == 0 && all_at_first) || self.random.below(100) == 0;
            let due = match i.often {
                _ if i.steady => cycle == 0,
                Some(n) => cycle == 0 || self.random.below(n) == 0,
                None => !i.seldom || now_and_then,
            };
            let mut next = i.source.next(i.first, &mut self.random);
            if !i.values.is_empty() {
                next = Some(of(i.first, self.random.pick(&i.values)));
            }
            if let Some(value) = next.filter(|_| due) {
                let value = if i.positive { positive(value) } else { value };
                let value = i.range.map_or(value, |range| within(value, range));
                self.bench.set(&i.name, value);
                self.bench.set(&i.theirs, value);
            }
        }
    }

    /// Compares all after a cycle.
    #[expect(clippy::print_stdout, reason = "asked for")]
    fn compare(&mut self, style: Style, names: &[(String, String)]) {
        let b = &mut self.bench;
        let values: Vec<_> =
            names.iter().map(|(our, their)| (get(b, our), get(b, their))).collect();
        let mut new = Vec::new();
        for ((name, _), &(ours, theirs)) in names.iter().zip(&values) {
            if self.verdict.compare(name, ours, theirs, self.case.ulps(name)) {
                new.push(name);
            }
        }
        if History::wanted() {
            self.history.push(self.verdict.cycles, values);
            for name in new {
                let said = &self.verdict.apart[name].said;
                println!("{style:?}, {name}, {said}");
                print!("{}", self.history.of(name, names));
            }
        }
    }
}

fn items(b: &mut Bench, owner: &str, prefix: &str) -> Items {
    let mut all = b.items(Kind::Pins, "");
    all.extend(b.items(Kind::Params, ""));
    let mine = all.into_iter().filter(|i| i.owner_name == owner);
    mine.map(|i| (i.name[prefix.len()..].to_owned(), (i.direction, i.value))).collect()
}
