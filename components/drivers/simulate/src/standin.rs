//! `standin`.
use hal_component::{
    Arg, Builder, Component, Decl, Error, In, Io, Out, Period, Touch, Update, Uses, Value,
    abi::{ArgSpec, component_flags},
};
use std::collections::BTreeMap;

/// Pins in place of a component that is not there.
pub(crate) struct Standin;

/// Period of the task that writes the outputs of programs, which have no function: 1 ms.
const TASK_NS: i64 = 1_000_000;

impl Component for Standin {
    const NAME: &'static str = "standin";
    const DOC: &'static str = "Pins and functions in place of components that are not there.\n\n\
        `halrun --stub NAME` and `[HAL]STUB` load it, with the pins that the machine's files name; nobody has to write \
        these arguments by hand. `pins=` lists pins as `NAME|TYPE|DIRECTION|FUNCTION|RULE|OTHER`: \
        the type is `bit`, `float`, `s32`, `u32`, `s64` or `u64`, the direction `in`, `out` or `io`. An output \
        is written by the function with that number in `functs=`, counted from 0; without a number by a task, each \
        millisecond of machine time. The rule tells what it becomes:\n\n\
        - none: the value of `standin.sim.NAME`, an input that is 0 or FALSE, and that a person or a script sets;\n\
        - `copy`: the value of the pin OTHER; a float adds `standin.sim.NAME`, and a bit that is TRUE there inverts;\n\
        - `sum`: the integral of the pin OTHER over time, in its units times seconds;\n\
        - `index`, of an `io` bit: FALSE one cycle after it became TRUE; with OTHER, which is a `sum` in turns, at the \
        next whole turn, from which OTHER then counts.\n\n\
        `show` and `save` list `standin.sim.*` only when a pattern names them. On the real clock without `--simulate` there \
        are none of them, and no rules: outputs stay 0 and FALSE.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt standin pins=card.cmd|float|in,card.fb|float|out||copy|card.cmd,card.ok|bit|out\n\
        loadrt threads name1=servo period1=1000000\n\
        setp card.cmd 2.5\n\
        setp standin.sim.card.ok TRUE\n\
        start\n\
        run 2ms\n\
        getp card.fb # -> 2.5\n\
        getp card.ok # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::texts(
            "pins",
            "Pins, each NAME|TYPE|DIRECTION|FUNCTION|RULE|OTHER, such as card.ok|bit|out.",
        )
        .at_most(32_768),
        &Arg::texts("functs", "Names of functions, such as card.read.").at_most(1_024),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let functs = b.arg_texts("functs");
        if let Some(wrong) = functs.iter().find(|name| !is_name(name)) {
            return Err(Error::new(format!("functs: '{wrong}' is not the name of a function")));
        }
        let mut made = Made::default();
        let texts = b.arg_texts("pins");
        let plans = texts.iter().map(|text| PinPlan::of(text, functs.len()));
        let plans: Vec<PinPlan<'_>> = plans.collect::<Result<_, _>>()?;
        // Rules refer to inputs, so that these come first.
        for plan in plans.iter().filter(|plan| plan.dir != "out") {
            made.input(b, plan)?;
        }
        let mut works: Vec<Work> = functs.iter().map(|_| Work::default()).collect();
        let mut rest = Work::default();
        for plan in &plans {
            let work = match plan.funct {
                Some(n) => works.get_mut(n).ok_or_else(|| plan.wrong("function"))?,
                None => &mut rest,
            };
            made.output(b, plan, work)?;
        }
        for (name, work) in functs.iter().zip(works) {
            b.function(name, "Stands in for the function of a component that is not there.", work)?;
        }
        if rest.is_empty() {
            return Ok(());
        }
        b.task("standin.task", "Writes the outputs of programs that are not there.", TASK_NS, rest)
    }
}

/// Returns whether a text can be the name of a pin or function.
fn is_name(text: &str) -> bool {
    let usable = |c: char| c.is_ascii_alphanumeric() || "-_.:+#[]".contains(c);
    !text.is_empty() && text.chars().all(usable)
}

/// Pin as its argument describes it.
struct PinPlan<'a> {
    text: &'a str,
    name: &'a str,
    ty: &'a str,
    dir: &'a str,
    funct: Option<usize>,
    rule: &'a str,
    other: &'a str,
}

impl<'a> PinPlan<'a> {
    fn of(text: &'a str, functs: usize) -> Result<Self, Error> {
        let mut parts = text.split('|');
        let mut part = || parts.next().unwrap_or_default();
        let (name, ty, dir, number, rule, other) = (part(), part(), part(), part(), part(), part());
        let plan = Self { text, name, ty, dir, funct: number.parse().ok(), rule, other };
        let is_number = number.is_empty() || plan.funct.is_some_and(|n| n < functs);
        if !is_name(name) || !["in", "out", "io"].contains(&dir) || !is_number {
            return Err(plan.wrong("pin"));
        }
        Ok(plan)
    }

    fn wrong(&self, what: &str) -> Error {
        let text = self.text;
        Error::new(format!(
            "pins: '{text}' has no usable {what}: each is NAME|TYPE|DIRECTION|FUNCTION|RULE|OTHER"
        ))
    }
}

/// Pins that rules can refer to.
#[derive(Default)]
struct Made {
    bits: BTreeMap<String, In<bool>>,
    floats: BTreeMap<String, In<f64>>,
    indexes: Vec<(String, Io<bool>)>,
}

impl Made {
    fn input(&mut self, b: &mut Builder<'_>, plan: &PinPlan<'_>) -> Result<(), Error> {
        const DOC: &str = "Stands in for an input that is not there, in the units of that.";
        let name = plan.name;
        match (plan.ty, plan.dir) {
            ("bit", "io") => {
                let pin = b.item(name, DOC, false)?;
                if plan.rule == "index" {
                    self.indexes.push((plan.other.to_owned(), pin));
                }
            }
            ("bit", _) => drop(self.bits.insert(name.to_owned(), b.item(name, DOC, false)?)),
            ("float", "io") => drop::<Io<f64>>(b.item(name, DOC, 0.0)?),
            ("float", _) => drop(self.floats.insert(name.to_owned(), b.item(name, DOC, 0.0)?)),
            ("s32", "io") => drop::<Io<i32>>(b.item(name, DOC, 0)?),
            ("s32", _) => drop::<In<i32>>(b.item(name, DOC, 0)?),
            ("u32", "io") => drop::<Io<u32>>(b.item(name, DOC, 0)?),
            ("u32", _) => drop::<In<u32>>(b.item(name, DOC, 0)?),
            ("s64", "io") => drop::<Io<i64>>(b.item(name, DOC, 0)?),
            ("s64", _) => drop::<In<i64>>(b.item(name, DOC, 0)?),
            ("u64", "io") => drop::<Io<u64>>(b.item(name, DOC, 0)?),
            ("u64", _) => drop::<In<u64>>(b.item(name, DOC, 0)?),
            _ => return Err(plan.wrong("type")),
        }
        Ok(())
    }

    fn output(
        &self,
        b: &mut Builder<'_>,
        plan: &PinPlan<'_>,
        work: &mut Work,
    ) -> Result<(), Error> {
        match (plan.ty, plan.dir) {
            ("bit", "io") if plan.rule == "index" && plan.other.is_empty() => {
                let clears = self.indexes.iter().filter(|(turns, _)| turns.is_empty());
                work.clears = clears.map(|(_, pin)| Clear { pin: *pin, was: false }).collect();
            }
            (_, "in" | "io") => {}
            ("bit", _) => {
                let other = self.bits.get(plan.other).copied();
                let (to, sim) = ends(b, plan, false)?;
                if let Some(sim) = sim {
                    work.bits.push(Bit { to, sim, other: plan.checked(other)? });
                }
            }
            ("float", _) => {
                let other = self.floats.get(plan.other).copied();
                let (to, sim) = ends(b, plan, 0.0)?;
                if let Some(sim) = sim {
                    let index = self.indexes.iter().find(|(turns, _)| turns == plan.name);
                    let is_sum = plan.rule == "sum";
                    work.floats.push(Float {
                        to,
                        sim,
                        other: plan.checked(other)?,
                        index: index.map(|(_, pin)| *pin),
                        sum: is_sum.then_some(0.0),
                    });
                }
            }
            ("s32", _) => work.i32s.extend(plain(b, plan, 0)?),
            ("u32", _) => work.u32s.extend(plain(b, plan, 0)?),
            ("s64", _) => work.i64s.extend(plain(b, plan, 0)?),
            ("u64", _) => work.u64s.extend(plain(b, plan, 0)?),
            _ => return Err(plan.wrong("type")),
        }
        Ok(())
    }
}

impl PinPlan<'_> {
    /// Returns the input of a rule, which exists if there is a rule.
    fn checked<T>(&self, other: Option<T>) -> Result<Option<T>, Error> {
        match self.rule {
            "" => Ok(None),
            "copy" | "sum" if other.is_some() => Ok(other),
            _ => Err(self.wrong("rule")),
        }
    }
}

/// An output, and its value in simulation.
type Ends<T> = (Out<T>, Option<In<T>>);

fn ends<T: Value>(b: &mut Builder<'_>, plan: &PinPlan<'_>, zero: T) -> Result<Ends<T>, Error> {
    let to = b.item(
        plan.name,
        "Stands in for an output that is not there, in the units of that.",
        zero,
    )?;
    let sim = if b.is_simulated() {
        let name = format!("standin.sim.{}", plan.name);
        let decl = Decl::new(&name, "Value of the output that has this name, in its units.");
        Some(b.declare(decl.hidden(), zero)?)
    } else {
        None
    };
    Ok((to, sim))
}

fn plain<T: Value>(
    b: &mut Builder<'_>,
    plan: &PinPlan<'_>,
    zero: T,
) -> Result<Option<Same<T>>, Error> {
    let (to, sim) = ends(b, plan, zero)?;
    Ok(sim.map(|sim| Same { to, sim }))
}

/// The outputs that one function writes.
#[derive(Default, Touch)]
struct Work {
    bits: Vec<Bit>,
    floats: Vec<Float>,
    i32s: Vec<Same<i32>>,
    u32s: Vec<Same<u32>>,
    i64s: Vec<Same<i64>>,
    u64s: Vec<Same<u64>>,
    clears: Vec<Clear>,
}

impl Work {
    const fn is_empty(&self) -> bool {
        self.bits.is_empty()
            && self.floats.is_empty()
            && self.i32s.is_empty()
            && self.u32s.is_empty()
            && self.i64s.is_empty()
            && self.u64s.is_empty()
            && self.clears.is_empty()
    }
}

impl Update for Work {
    fn update(&mut self, period: Period) {
        self.bits.iter().for_each(Bit::write);
        self.floats.iter_mut().for_each(|float| float.write(period.secs()));
        self.i32s.iter().for_each(Same::write);
        self.u32s.iter().for_each(Same::write);
        self.i64s.iter().for_each(Same::write);
        self.u64s.iter().for_each(Same::write);
        self.clears.iter_mut().for_each(Clear::write);
    }
}

struct Bit {
    to: Out<bool>,
    sim: In<bool>,
    other: Option<In<bool>>,
}

impl Bit {
    fn write(&self) {
        self.to.set(self.sim.get() ^ self.other.is_some_and(|other| other.get()));
    }
}

impl Touch for Bit {
    fn touch(&self, uses: &mut Uses) {
        self.to.touch(uses);
        self.sim.touch(uses);
        touch(self.other.as_ref(), uses);
    }
}

struct Float {
    to: Out<f64>,
    sim: In<f64>,
    other: Option<In<f64>>,
    index: Option<Io<bool>>,
    /// The integral so far, if the output is one.
    sum: Option<f64>,
}

impl Float {
    fn write(&mut self, seconds: f64) {
        let other = self.other.map_or(0.0, |other| other.get());
        let Some(sum) = &mut self.sum else { return self.to.set(self.sim.get() + other) };
        let before = *sum;
        *sum += other * seconds;
        if let Some(index) = self.index
            && index.get()
            && libm::floor(before) != libm::floor(*sum)
        {
            index.set(false);
            *sum -= if other > 0.0 { libm::floor(*sum) } else { libm::ceil(*sum) };
        }
        self.to.set(self.sim.get() + *sum);
    }
}

impl Touch for Float {
    fn touch(&self, uses: &mut Uses) {
        self.to.touch(uses);
        self.sim.touch(uses);
        touch(self.other.as_ref(), uses);
        touch(self.index.as_ref(), uses);
    }
}

struct Same<T> {
    to: Out<T>,
    sim: In<T>,
}

impl<T: Value> Same<T> {
    fn write(&self) {
        self.to.set(self.sim.get());
    }
}

impl<T: Value> Touch for Same<T> {
    fn touch(&self, uses: &mut Uses) {
        self.to.touch(uses);
        self.sim.touch(uses);
    }
}

/// A bit that becomes FALSE one cycle after it became TRUE.
struct Clear {
    pin: Io<bool>,
    was: bool,
}

impl Clear {
    fn write(&mut self) {
        let is = self.pin.get();
        if is && self.was {
            self.pin.set(false);
        }
        self.was = is;
    }
}

impl Touch for Clear {
    fn touch(&self, uses: &mut Uses) {
        self.pin.touch(uses);
    }
}

fn touch(pin: Option<&impl Touch>, uses: &mut Uses) {
    if let Some(pin) = pin {
        pin.touch(uses);
    }
}

#[cfg(test)]
mod tests {
    use super::Standin;
    use hal_bench::Bench;

    fn bench() -> Bench {
        let mut bench = Bench::new();
        let pins = "pins=c.cmd|float|in,c.fb|float|out|0|copy|c.cmd,c.rate|float|in,\
                    c.turns|float|out|0|sum|c.rate,c.index|bit|io|0|index|c.turns,\
                    c.latch|bit|io|0|index,c.enable|bit|in,c.on|bit|out|0|copy|c.enable,\
                    c.ok|bit|out|0,c.count|s32|out|0,c.mask|u32|out|0";
        bench.load::<Standin>(&[pins, "functs=c.read"]).unwrap();
        bench
    }

    #[test]
    fn outputs_follow_their_rules() {
        let bench = bench();
        bench.set("c.cmd", 2.5);
        bench.set("c.enable", true);
        bench.set("c.rate", 600.0);
        bench.set("standin.sim.c.fb", 0.25);
        bench.set("standin.sim.c.count", -7_i32);
        bench.set("standin.sim.c.mask", 9_u32);
        bench.run("c.read", 1_000_000);
        assert_eq!(bench.get::<f64>("c.fb"), 2.75);
        assert!((bench.get::<f64>("c.turns") - 0.6).abs() < 1e-12);
        assert!(bench.get::<bool>("c.on") && !bench.get::<bool>("c.ok"));
        assert_eq!((bench.get::<i32>("c.count"), bench.get::<u32>("c.mask")), (-7, 9));
        bench.set("standin.sim.c.ok", true);
        bench.set("standin.sim.c.on", true);
        bench.run("c.read", 1_000_000);
        assert!(bench.get::<bool>("c.ok") && !bench.get::<bool>("c.on"));
    }

    #[test]
    fn an_index_ends_at_the_next_turn() {
        let bench = bench();
        bench.set("c.rate", 300.0);
        bench.set("c.index", true);
        bench.set("c.latch", true);
        let mut seen = Vec::new();
        for _ in 0..5 {
            bench.run("c.read", 1_000_000);
            let turns = (bench.get::<f64>("c.turns") * 10.0).round() / 10.0;
            seen.push((turns, bench.get::<bool>("c.index"), bench.get::<bool>("c.latch")));
        }
        let want = [
            (0.3, true, true),
            (0.6, true, false),
            (0.9, true, false),
            (0.2, false, false),
            (0.5, false, false),
        ];
        assert_eq!(seen, want);
    }

    #[test]
    fn wrong_pins_are_named() {
        for wrong in [
            "x|bit",
            "x|bits|in",
            "x|bit|out|1",
            "x|bit|out|0|copy|none",
            "x|float|out|0|abs|x",
            "|bit|in",
        ] {
            let pins = format!("pins={wrong}");
            let error = Bench::new().load::<Standin>(&[&pins, "functs=f"]).unwrap_err();
            assert!(error.to_string().contains(wrong), "{wrong}: {error}");
        }
    }
}
