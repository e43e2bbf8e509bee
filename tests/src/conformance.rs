//! The judge: runs one of our components and LinuxCNC's component of the same name in one engine on the virtual clock,
//! with the same inputs, and compares them after every cycle.

pub mod case;
mod history;
pub(crate) mod inputs;
mod plan;
pub mod rows;
mod verdict;

pub use inputs::Style;
pub use plan::CYCLES;
pub use verdict::Verdict;

use crate::{
    foreign::{Bench, installed},
    machine::{get, script},
    random::Random,
};
use case::Case;
use hal_protocol::{Direction, Kind, Link, Request, Value};
use history::History;
use inputs::Driven;
use plan::{LoadPlan, Plan, with_names};
use std::collections::{BTreeMap, BTreeSet};

/// Prefix of the names of LinuxCNC's component.
const PREFIX: &str = "c-";

/// Pins and parameters by name, without the prefix, with direction and first value.
type Items = BTreeMap<String, (Direction, Value)>;

/// Both components, side by side.
struct Pair<'c> {
    module: &'c str,
    case: &'c Case,
    verdict: Verdict,
    random: Random,
    bench: Bench,
    history: History,
}

/// Judges a component for this many rounds.
///
/// # Errors
/// One of the two cannot be loaded, or the case file is wrong.
pub fn judge(module: &str, rounds: usize) -> Result<Verdict, String> {
    let folder = installed().unwrap();
    let case = Case::of(module)?;
    let more: u64 = std::env::var("JUDGE_SEED").map_or(0, |n| n.parse().unwrap());
    let random = Random::new(module.bytes().map(u64::from).sum::<u64>() + (more << 16));
    let (verdict, bench) = (Verdict::default(), Bench::new(&[&folder]));
    let history = History::default();
    let mut pair = Pair { module, case: &case, verdict, random, bench, history };
    let named = case.loads.iter().any(|l| l.contains("names="));
    let names = !named && case.single.is_none() && pair.takes_names(&case.loads[0]);
    let plan = Plan::new(&case.loads, names, &case);
    for round in plan.rounds().take(rounds) {
        pair.round(&round)?;
    }
    pair.verdict.whole = rounds >= plan.rounds().count();
    Ok(pair.verdict)
}

impl Pair<'_> {
    /// Returns whether LinuxCNC's component accepts instance names in addition to these arguments.
    fn takes_names(&mut self, args: &str) -> bool {
        let (module, b) = (self.module, &mut self.bench);
        let takes =
            b.load_c(PREFIX, &format!("{module} {}", with_names(args, &["a", "b"]))).is_ok();
        if takes {
            script(b, &format!("unloadrt {PREFIX}{module}"));
        }
        takes
    }

    /// Loads both, drives them, and unloads them.
    fn round(&mut self, round: &LoadPlan) -> Result<(), String> {
        let (ours, theirs) = self.load(round)?;
        for (name, (_, first)) in ours.iter().filter(|(_, (direction, _))| is_given(*direction)) {
            self.case.suits(self.module, name, *first)?;
        }
        let (mut inputs, outputs) = self.matched(round.style, &ours, &theirs);
        self.verdict.begin(self.module, round, outputs.iter().map(|(n, _)| (&**n, ours[n])));
        self.history.begin();
        script(&mut self.bench, "start");
        for cycle in 0..self.case.cycles.unwrap_or(CYCLES) {
            self.drive(&mut inputs, cycle, round.all_at_first);
            self.bench.call(Request::Run { ns: round.period }).unwrap();
            self.verdict.cycles += 1;
            self.compare(round, &outputs);
        }
        let module = self.module;
        let away = format!("stop\nunloadrt {PREFIX}{module}\nunloadrt {module}\nunloadrt threads");
        script(&mut self.bench, &away);
        Ok(())
    }

    /// Loads both, and adds their functions to the same threads in the same order.
    fn load(&mut self, round: &LoadPlan) -> Result<(Items, Items), String> {
        let (module, args, b) = (self.module, &round.args, &mut self.bench);
        let words = args.split(' ').filter(|w| !w.is_empty()).map(str::to_owned).collect();
        b.call(Request::Load { module: module.to_owned(), args: words })
            .map_err(|e| format!("ours: {e}"))?;
        b.load_c(PREFIX, &format!("{module} {args}"))?;
        let theirs = format!("{PREFIX}{module}");
        let found: Vec<String> = b.functs(&theirs).into_iter().map(|f| f.name).collect();
        let mut functs = b.functs(module);
        if round.shuffled {
            shuffle(&mut functs, &mut self.random);
        }
        let slow = functs.iter().any(|f| f.fast) && functs.iter().any(|f| !f.fast);
        script(b, &round.threads(slow));
        for f in functs {
            let (of_ours, of_theirs) = (&f.name, format!("{PREFIX}{}", f.name));
            if !found.contains(&of_theirs) {
                return Err(format!("theirs has no function {of_ours}, but {}", found.join(", ")));
            }
            let thread = if slow && !f.fast { "slow" } else { "fast" };
            script(b, &format!("addf {of_ours} {thread}\naddf {of_theirs} {thread}"));
        }
        Ok((items(b, module, ""), items(b, &theirs, PREFIX)))
    }

    /// Matches the items of both; returns the inputs to drive and the items to compare.
    fn matched(
        &mut self,
        style: Style,
        ours: &Items,
        theirs: &Items,
    ) -> (Vec<Driven>, Vec<(String, String)>) {
        let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
        let (case, v) = (self.case, &mut self.verdict);
        let lone = |a: &Items, b: &Items| -> BTreeSet<_> {
            a.keys().filter(|k| !b.contains_key(*k)).cloned().collect()
        };
        let extra = lone(ours, theirs);
        v.theirs_only.extend(lone(theirs, ours));
        for (name, value) in case.sets(&extra) {
            self.bench.call(Request::Set { name, value }).unwrap();
        }
        v.ours_only.extend(extra);
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
            let given = is_given(direction);
            if given && value != first && v.begins(case, name, first, value) {
                self.bench.set(&of_theirs, first);
            }
            if let Some(value) = case.set(name) {
                script(&mut self.bench, &format!("setp {name} {value}\nsetp {of_theirs} {value}"));
            } else if given && !case.keeps(name, |i| i.alone) {
                let seldom = !matches!(direction, Direction::In);
                let (theirs, r) = (of_theirs.clone(), &mut self.random);
                inputs.push(Driven::new(case, style, (name, theirs), first, seldom, r));
            }
            outputs.push((name.clone(), of_theirs));
        }
        v.compared = v.compared.max(outputs.len());
        (inputs, outputs)
    }

    /// Sets the inputs of both that are due before a cycle.
    fn drive(&mut self, inputs: &mut [Driven], cycle: u64, all_at_first: bool) {
        for i in inputs {
            let b = &mut self.bench;
            let value = i.next(cycle == 0, all_at_first, &mut self.random, |name| get(b, name));
            if let Some(value) = value {
                self.bench.set(&i.name, value);
                self.bench.set(&i.theirs, value);
            }
        }
    }

    /// Compares all items after a cycle.
    #[expect(clippy::print_stdout, reason = "asked for")]
    fn compare(&mut self, round: &LoadPlan, names: &[(String, String)]) {
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
                println!("{round}, {name}, {said}");
                print!("{}", self.history.of(name, names));
            }
        }
    }
}

/// Returns whether the judge sets an item of this direction.
const fn is_given(direction: Direction) -> bool {
    matches!(direction, Direction::In | Direction::Io | Direction::Rw)
}

fn items(b: &mut Bench, owner: &str, prefix: &str) -> Items {
    let mut all = b.items(Kind::Pins, "");
    all.extend(b.items(Kind::Params, ""));
    let mine = all.into_iter().filter(|i| i.owner_name == owner);
    mine.map(|i| (i.name[prefix.len()..].to_owned(), (i.direction, i.value))).collect()
}

/// Shuffles a list.
fn shuffle<T>(list: &mut [T], r: &mut Random) {
    for i in (1..list.len()).rev() {
        list.swap(i, r.index(i + 1));
    }
}
