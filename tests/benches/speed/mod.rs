//! Measurement of one component at a time: loaded, driven and timed.

pub(crate) mod bench;
pub(crate) mod loads;

use bench::{ALL_TRUE, BANK, CHANCE, ENABLED, totals};
use hal_engine::{Engine, Offer};
use hal_protocol::{Direction, ItemInfo, Kind, Link, Reply, Request, Value};
use hal_tests::{
    every,
    foreign::written,
    machine::{says, script},
    random::Random,
};

/// Number of instances that run in a cycle.
const COUNT: usize = 32;

/// Number of measurements of each, in each style; the smallest counts.
const ROUNDS: usize = 15;

/// Approximate duration of a round, in nanoseconds.
const ROUND: f64 = 2e6;
/// Maximum and minimum number of cycles of a round.
const MAX_CYCLES: f64 = 20_000.0;
const MIN_CYCLES: f64 = 20.0;

/// Components that are driven by lines of a script, and that need others.
const DRIVEN: &[(&str, &str, &str)] = &[(
    "motmod",
    "loadrt trivkins",
    "motion.configure max-velocity=50 max-acceleration=2000
     motion.enable
     motion.home joint=all
     run 100000000
     motion.move x=3000 y=2000 z=-1000 velocity=10",
)];

/// Cost of a function.
#[derive(Debug)]
pub(crate) struct Cost {
    pub(crate) component: String,
    /// Name of the function, with N for the number of the instance.
    pub(crate) function: String,
    /// Arguments of each instance.
    pub(crate) args: String,
    pub(crate) ns: f64,
}

/// Measures all functions of a component.
pub(crate) fn costs(engine: &mut Engine, offer: &Offer) -> Result<Vec<Cost>, String> {
    let args = every::large(offer, COUNT);
    let costs = measured(engine, &offer.component, &args);
    script(engine, "stop\nunloadrt all");
    for signal in signals(engine) {
        script(engine, &format!("delsig {signal}"));
    }
    let one = every::large(offer, 1);
    let of_one: Vec<&str> = one.split(' ').filter(|w| !w.starts_with("count=")).collect();
    let cost = |(function, ns): (String, f64)| {
        let of_an_instance = every::is_counted(offer) || function.split('.').any(|p| p == "N");
        let args = if of_an_instance { of_one.join(" ") } else { args.clone() };
        Cost { component: offer.component.clone(), function, args, ns }
    };
    Ok(costs?.into_iter().map(cost).collect())
}

/// Returns the cost of an empty function.
pub(crate) fn nothing(engine: &mut Engine) -> f64 {
    let cost = measured(engine, "nothing", &format!("count={COUNT}")).unwrap();
    script(engine, "stop\nunloadrt all");
    cost[0].1
}

fn measured(
    engine: &mut Engine,
    component: &str,
    args: &str,
) -> Result<Vec<(String, f64)>, String> {
    let driven = DRIVEN.iter().find(|(name, ..)| *name == component);
    if let Some((_, before, _)) = driven {
        script(engine, before);
    }
    let said = says(engine, &format!("loadrt {component} {args}"));
    if said != "ok" {
        return Err(said);
    }
    let groups = groups(engine, component);
    if groups.is_empty() {
        return Ok(Vec::new());
    }
    let n = groups.len() + 2;
    script(
        engine,
        &format!(
            "loadrt threads name1=t period1=1000000\nloadrt drive\nloadrt mark n={n}\naddf drive.0 t\naddf mark.0 t\naddf mark.1 t"
        ),
    );
    for (i, (_, functions)) in groups.iter().enumerate() {
        functions.iter().for_each(|f| script(engine, &format!("addf {f} t")));
        script(engine, &format!("addf mark.{} t", i + 2));
    }
    let items = items(engine, component);
    match driven {
        Some((.., lines)) => {
            join(engine);
            script(engine, &format!("start\n{lines}"));
        }
        None => link(engine, &items),
    }
    script(engine, "start");
    let mut best = vec![0.0_f64; groups.len()];
    for style in [ENABLED, ALL_TRUE, CHANCE] {
        script(engine, &format!("setp drive.0.style {style}"));
        if style == CHANCE && driven.is_none() {
            set(engine, &items);
        }
        for (best, (ns, functions)) in
            best.iter_mut().zip(rounds(engine, n).iter().zip(groups.iter().map(|g| g.1.len())))
        {
            *best = best.max(ns / functions as f64);
        }
        assert!(hal_tests::machine::status(engine).fault.is_none(), "{component}");
    }
    Ok(groups.into_iter().map(|g| g.0).zip(best).collect())
}

/// Returns the shortest time between marks, over several rounds.
fn rounds(engine: &mut Engine, marks: usize) -> Vec<f64> {
    let mut run = |cycles: u64| {
        totals();
        engine.call(Request::Run { ns: cycles * 1_000_000 }).unwrap();
        totals().iter().take(marks).map(|t| *t as f64 / cycles as f64).collect::<Vec<_>>()
    };
    run(100);
    let once: f64 = run(100).iter().skip(1).sum();
    let once = once.max(ROUND / MAX_CYCLES);
    let cycles = (ROUND / once).max(MIN_CYCLES) as u64;
    let mut least = vec![f64::INFINITY; marks];
    for _ in 0..ROUNDS {
        for (least, now) in least.iter_mut().zip(run(cycles)) {
            *least = least.min(now);
        }
    }
    // Cost of a mark itself: there is nothing between the first two.
    let mark = least[1];
    least.iter().skip(2).map(|ns| ns - mark).collect()
}

/// Returns the functions of a component, grouped over its instances.
fn groups(engine: &mut Engine, component: &str) -> Vec<(String, Vec<String>)> {
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    let Reply::Functs(list) = list(engine, Kind::Functs) else { panic!("no functions") };
    for f in list.into_iter().filter(|f| f.owner_name == component) {
        let number = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        let parts: Vec<&str> =
            f.name.split('.').map(|part| if number(part) { "N" } else { part }).collect();
        let name = parts.join(".");
        match groups.iter_mut().find(|g| g.0 == name) {
            Some(group) => group.1.push(f.name),
            None => groups.push((name, vec![f.name])),
        }
    }
    groups
}

fn list(engine: &mut Engine, kind: Kind) -> Reply {
    engine.call(Request::List { kind, patterns: Vec::new(), ty: None }).unwrap()
}

/// Returns the items that can be driven.
fn items(engine: &mut Engine, component: &str) -> Vec<ItemInfo> {
    let mut all = Vec::new();
    for kind in [Kind::Pins, Kind::Params] {
        let Reply::Items(list) = list(engine, kind) else { panic!("no items") };
        all.extend(list);
    }
    let may = |i: &ItemInfo| {
        let open = matches!(i.direction, Direction::In | Direction::Io | Direction::Rw);
        open && i.owner_name == component && !i.name.ends_with(".tmax")
    };
    all.retain(may);
    all
}

fn signals(engine: &mut Engine) -> Vec<String> {
    match list(engine, Kind::Signals) {
        Reply::Signals(list) => list.into_iter().map(|s| s.name).collect(),
        other => panic!("{other:?}"),
    }
}

/// Links inputs to values that change.
fn link(engine: &mut Engine, items: &[ItemInfo]) {
    let enables = ["enable", "-on", "run", "active"];
    for (i, item) in items.iter().filter(|i| i.direction == Direction::In).enumerate() {
        let from = match item.value {
            Value::Bit(_) if enables.iter().any(|e| item.name.contains(e)) => "enable",
            Value::Bit(_) => "bit",
            Value::Float(_) => "float",
            Value::S32(_) => "s32",
            Value::U32(_) => "u32",
            Value::S64(_) => "s64",
            Value::U64(_) => "u64",
            Value::Port(_) => continue,
        };
        let from = format!("{from}-{:02}", i * 5 % usize::from(BANK));
        script(engine, &format!("net {from} drive.0.{from} {}", item.name));
    }
}

/// Links each joint's feedback to its command.
fn join(engine: &mut Engine) {
    for j in 0..9 {
        script(
            engine,
            &format!(
                "net j{j} joint.{j}.motor-pos-cmd joint.{j}.motor-pos-fb
                 motion.configure joint={j} max-velocity=50 max-acceleration=2000 ferror=100"
            ),
        );
    }
}

/// Sets parameters, and pins that both sides write, to random values.
fn set(engine: &mut Engine, items: &[ItemInfo]) {
    let mut r = Random::new(7);
    for item in items.iter().filter(|i| i.direction != Direction::In) {
        let size = r.pick(&[1.0, 10.0, 100.0]);
        let (float, number) = (r.unit().abs() * size, r.below(8) + 1);
        let value = match item.value {
            Value::Bit(_) => Value::Bit(number % 2 == 0),
            Value::Float(_) => Value::Float(float),
            Value::S32(_) => Value::S32(i32::try_from(number).unwrap()),
            Value::U32(_) => Value::U32(u32::try_from(number).unwrap()),
            Value::S64(_) => Value::S64(number.cast_signed()),
            Value::U64(_) => Value::U64(number),
            Value::Port(_) => continue,
        };
        script(engine, &format!("setp {} {}", item.name, written(value)));
    }
}
