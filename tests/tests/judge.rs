//! The judge: each of our components beside LinuxCNC's own of the same name, in one engine on the
//! virtual clock, with the same inputs; every output is compared after every cycle.
//!
//! `cargo test -p hal-tests --test judge -- --ignored` judges all of them, for 10,000 cycles each,
//! and compares with `tests/compat/judge.md`; with `UPDATE_EXPECT=1` it writes that file.
//! `JUDGE=NAME` judges one and prints its row. Without LinuxCNC's package nothing is run, with a
//! word.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "what is skipped is said")]
#![expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "small, or bits")]

use hal_protocol::{Direction, Kind, Link, Reply, Request, Value};
use hal_tests::{
    foreign::{Bench, Random, installed},
    machine::{get, script},
    programs::root,
};
use std::{collections::BTreeMap, fmt::Write, process::Command};

/// What is given to both as they are loaded, where nothing is not enough.
const ARGUMENTS: &[(&str, &str)] = &[
    ("bitslice", "personality=16"),
    ("debounce", "cfg=4"),
    ("logic", "personality=1796"),
    ("pwmgen", "output_type=0,1"),
    ("stepgen", "step_type=0,2"),
    ("watchdog", "num_inputs=2"),
];

/// What is not judged, and why.
const SKIPPED: &[(&str, &str)] = &[
    ("hal_parport", "both would drive the registers of one port"),
    ("motmod", "ours has the names of its pins alone, and plans nothing"),
    ("sampler", "it writes to a ring, which is read by a program of its own side"),
    ("streamer", "it reads from a ring, which is filled by a program of its own side"),
    ("threads", "it makes threads, and has no pins"),
    ("trivkins", "it serves motion, and has no pins"),
];

/// What an input is kept to, and why: its sizes alone.
const POSITIVE: &[(&str, &[&str], &str)] = &[
    ("limit3", &["maxv", "maxa"], "LinuxCNC says that they are"),
    ("mux16", &["debounce-time"], "it is a time"),
    ("pid", &["max"], "they are limits"),
    ("pwmgen", &["max-dc", "min-dc", "pwm-freq", "scale"], "they are sizes"),
    ("sim_encoder", &["scale"], "it is a size"),
    ("stepgen", &["maxvel", "maxaccel", "position-scale"], "they are sizes"),
    ("steptest", &["maxvel", "maxaccel", "epsilon", "amplitude"], "they are sizes"),
    ("watchdog", &["timeout-0", "timeout-1"], "ours takes what is below 0 as 0 sooner"),
];

/// What is set once after each load, and why.
const STEADY: &[(&str, &[&str], &str)] = &[
    ("limit3", &[".min", ".max", "maxv", "maxa", "smooth-steps"], "limits of a machine"),
    ("mux16", &["debounce-time"], "changes of it while it runs are counted in another way"),
];

/// What is left as it is, and why.
const ALONE: &[(&str, &[&str], &str)] = &[
    ("encoder", &["missing-teeth"], "not judged yet"),
    ("pid", &["tune-mode", "tune-start", "tune-type", "tune-cycles", "tune-effort"], TUNING),
    ("sim_encoder", &["ppr"], "ours corrects 0 sooner"),
    ("stepgen", &["steplen", "stepspace", "dirhold", "dirsetup", "dirdelay"], "not judged yet"),
    ("toggle", &["debounce"], "theirs takes what is too large as 2"),
];
const TUNING: &str = "theirs divides by 0 where ours waits for a swing";

/// How far numbers may be apart, in units of the last place, and why.
const TOLERANCES: &[(&str, u64, &str)] = &[
    ("counter", 4, "a sum in another order"),
    ("siggen", 16, "sine and cosine of another library"),
];

/// What is known to differ: component, end of the pin's name, why.
const DIFFERENCES: &[(&str, &str, &str)] = &[
    ("counter", ".counts", UNEXPLAINED),
    ("counter", ".index-enable", UNEXPLAINED),
    ("counter", ".position", UNEXPLAINED),
    ("encoder", ".position-interpolated", UNEXPLAINED),
    ("encoder", ".velocity", UNEXPLAINED),
    ("encoder", ".velocity-rpm", UNEXPLAINED),
    ("limit3", ".maxa", "its default is 1e7 in ours, as in LinuxCNC 2.10, and 1e20 in 2.9"),
    ("limit3", ".out", UNEXPLAINED),
    ("pid", ".output", UNEXPLAINED),
    ("pwmgen", ".pwm-freq", "theirs corrects it while not enabled, ours as it is enabled"),
    ("sim_encoder", ".phase-A", UNEXPLAINED),
    ("sim_encoder", ".phase-B", UNEXPLAINED),
    ("sim_encoder", ".phase-Z", UNEXPLAINED),
    ("sim_encoder", ".rawcounts", "an input that theirs writes and ours does not"),
    ("stepgen", ".frequency", "less than 4e-15 beside 0: sums in another order"),
    ("steptest", ".elapsed", UNEXPLAINED),
    ("steptest", ".position-cmd", UNEXPLAINED),
    ("watchdog", ".ok-out", UNEXPLAINED),
];
const UNEXPLAINED: &str = "not explained yet";

/// What is given no extremes, and why.
const TAME: &[(&str, &str)] = &[
    ("biquad", NUMBERS),
    ("encoder", NUMBERS),
    ("pid", NUMBERS),
    ("pwmgen", NUMBERS),
    ("sim_encoder", NUMBERS),
    ("stepgen", NUMBERS),
    ("oneshot", NUMBERS),
    ("steptest", NUMBERS),
];
const NUMBERS: &str = "what is not a number is kept, or passed over, in other places";

/// In how many rounds the cycles are spent, each with components just loaded: what is not a number
/// stays in a filter for ever, and would hide all that follows.
const ROUNDS: u64 = 20;
const CYCLES: u64 = 10_000;
const QUICK: u64 = 1_000;
const PERIOD: u64 = 1_000_000;
const PREFIX: &str = "c-";

fn of<'a, T>(list: &'a [T], name: impl Fn(&T) -> &str, module: &str) -> Option<&'a T> {
    list.iter().find(|row| name(row) == module)
}

/// What a round does to its inputs.
#[derive(Clone, Copy, Debug)]
enum Style {
    /// Numbers by chance, of a size by chance.
    Chance,
    /// Numbers that grow and shrink steadily and cross each other.
    Ramps,
    /// Numbers that stay, and now and then jump.
    Edges,
    /// Every number that a type has, the odd ones first.
    Extremes,
}

/// One input's way through a round.
struct Source {
    style: Style,
    value: f64,
    slope: f64,
    size: f64,
    often: u64,
}

impl Source {
    fn new(style: Style, r: &mut Random) -> Self {
        let size = [0.1, 1.0, 1.0, 10.0, 1000.0][usize::try_from(r.below(5)).unwrap()];
        let often = 1 + r.below(20);
        Self { style, value: r.unit() * size, slope: r.unit() * size / 50.0, size, often }
    }

    fn next(&mut self, now: Value, r: &mut Random) -> Option<Value> {
        match self.style {
            Style::Chance => self.value = r.unit() * self.size,
            Style::Ramps => {
                self.value += self.slope;
                if self.value.abs() > self.size {
                    self.slope = -self.slope;
                }
            }
            Style::Edges | Style::Extremes => {
                if r.below(self.often) != 0 {
                    return None;
                }
                self.value = (r.unit() * self.size).round();
            }
        }
        let wild = matches!(self.style, Style::Extremes);
        let mut pick = |n: usize| usize::try_from(r.below(u64::try_from(n).unwrap())).unwrap();
        let odd = pick(3) > 0 && wild;
        let whole = self.value.round() as i64;
        Some(match now {
            Value::Bit(_) => Value::Bit(if matches!(self.style, Style::Ramps | Style::Edges) {
                self.value > 0.0
            } else {
                pick(2) == 0
            }),
            Value::Float(_) if odd => Value::Float(
                [0.0, -0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX, f64::MIN]
                    .into_iter()
                    .chain([f64::MIN_POSITIVE, 5e-324, 1e300, 2_147_483_648.0, -2_147_483_649.0])
                    .chain([4_294_967_296.0, 1e19, 0.5, -0.5, 1.5, 2.5])
                    .nth(pick(18))
                    .unwrap(),
            ),
            Value::Float(_) => Value::Float(self.value),
            Value::S32(_) if odd => {
                Value::S32([i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX - 1, i32::MAX][pick(7)])
            }
            Value::S32(_) => Value::S32(i32::try_from(whole).unwrap()),
            Value::U32(_) if odd => {
                Value::U32([0, 1, i32::MAX as u32, 1 << 31, u32::MAX - 1, u32::MAX][pick(6)])
            }
            Value::U32(_) => Value::U32(u32::try_from(whole.abs()).unwrap()),
            Value::S64(_) if odd => Value::S64([i64::MIN, -1, 0, 1, 1 << 53, i64::MAX][pick(6)]),
            Value::S64(_) => Value::S64(whole),
            Value::U64(_) if odd => Value::U64([0, 1, 1 << 53, 1 << 63, u64::MAX][pick(5)]),
            Value::U64(_) => Value::U64(whole.unsigned_abs()),
            Value::Port(_) => return None,
        })
    }
}

/// How far two values are apart, in units of the last place; `None`: they are no numbers that
/// could be compared so.
fn apart(ours: Value, theirs: Value) -> Option<u64> {
    match (ours, theirs) {
        (Value::Float(a), Value::Float(b)) => {
            if a.is_nan() && b.is_nan() || a.to_bits() == b.to_bits() {
                return Some(0);
            }
            let place = |f: f64| {
                let size = (f.abs().to_bits()) as i64;
                if f.is_sign_negative() { -size } else { size }
            };
            (a.is_finite() && b.is_finite()).then(|| place(a).abs_diff(place(b)))
        }
        _ => (ours == theirs).then_some(0),
    }
}

fn exact(value: Value) -> String {
    match value {
        Value::Float(f) => format!("{f:?}"),
        other => other.to_string(),
    }
}

/// Pins and parameters by name, with direction and first value; the prefix is taken off.
type Items = BTreeMap<String, (Direction, Value)>;

fn items(b: &mut Bench, owner: &str, prefix: &str) -> Items {
    let mut all = b.items(Kind::Pins, "");
    all.extend(b.items(Kind::Params, ""));
    let mine = all.into_iter().filter(|i| i.owner_name == owner);
    mine.map(|i| (i.name[prefix.len()..].to_owned(), (i.direction, i.value))).collect()
}

/// Both of a name, loaded and in one thread.
fn load(b: &mut Bench, module: &str) -> Result<(Items, Items), String> {
    let args = of(ARGUMENTS, |r| r.0, module).map_or("", |r| r.1);
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

/// Why a pin is known to differ.
fn reason(module: &str, pin: &str) -> Option<&'static str> {
    let mut rows = DIFFERENCES.iter().filter(|(m, ..)| *m == module);
    rows.find(|(_, end, _)| pin.ends_with(end)).map(|(.., why)| *why)
}

/// What came of it.
#[derive(Default)]
struct Verdict {
    pins: usize,
    cycles: u64,
    ulps: u64,
    zeros: u64,
    differ: BTreeMap<String, String>,
    ours_only: Vec<String>,
    theirs_only: Vec<String>,
}

fn judge(module: &str, cycles: u64) -> Result<Verdict, String> {
    let folder = installed().unwrap();
    let mut v = Verdict::default();
    let allowed = of(TOLERANCES, |r| r.0, module).map_or(0, |r| r.1);
    let positive = of(POSITIVE, |r| r.0, module).map_or(&[][..], |r| r.1);
    let alone = of(ALONE, |r| r.0, module).map_or(&[][..], |r| r.1);
    let steady = of(STEADY, |r| r.0, module).map_or(&[][..], |r| r.1);
    let tame = of(TAME, |r| r.0, module).is_some();
    let mut r = Random::new(module.bytes().map(u64::from).sum());
    let mut b = Bench::new(&[&folder]);
    script(&mut b, "loadrt threads name1=t period1=1000000\nstart");
    for round in 0..ROUNDS {
        let style = match round % 4 {
            0 => Style::Chance,
            1 => Style::Ramps,
            2 => Style::Edges,
            _ if tame => Style::Chance,
            _ => Style::Extremes,
        };
        let (ours, theirs) = load(&mut b, module)?;
        let without = |a: &Items, b: &Items| -> Vec<_> {
            a.keys().filter(|k| !b.contains_key(*k)).cloned().collect()
        };
        (v.ours_only, v.theirs_only) = (without(&ours, &theirs), without(&theirs, &ours));
        let both = ours.iter().filter(|(name, _)| theirs.contains_key(*name));
        let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
        for (name, &(direction, first)) in both {
            let (other, value) = theirs[name];
            if (other, value.ty()) != (direction, first.ty()) {
                let said =
                    format!("{direction:?} {:?}, theirs {other:?} {:?}", first.ty(), value.ty());
                v.differ.entry(name.clone()).or_insert(said);
                continue;
            }
            let given = matches!(direction, Direction::In | Direction::Io | Direction::Rw);
            if given && value != first && reason(module, name).is_some() {
                // The defaults differ.
                b.set(&format!("{PREFIX}{name}"), first);
            }
            if given && !alone.iter().any(|end| name.ends_with(end)) {
                inputs.push((name.clone(), first, direction, Source::new(style, &mut r)));
            }
            outputs.push((name.clone(), format!("{PREFIX}{name}")));
        }
        v.pins = outputs.len();
        for cycle in 0..cycles / ROUNDS {
            for (name, first, direction, source) in &mut inputs {
                // Parameters and what both sides write are set now and then.
                let seldom = !matches!(direction, Direction::In);
                let steady = steady.iter().any(|end| name.ends_with(end));
                let now_and_then = (cycle == 0 && round % 2 == 1) || r.below(100) == 0;
                let due = if steady { cycle == 0 } else { !seldom || now_and_then };
                if let Some(mut value) = source.next(*first, &mut r).filter(|_| due) {
                    if let Value::Float(f) = value
                        && positive.iter().any(|p| name.contains(p))
                    {
                        let size = if f.is_finite() { f.abs().max(1e-3) } else { 1e9 };
                        value = Value::Float(size);
                    }
                    b.set(name, value);
                    b.set(&format!("{PREFIX}{name}"), value);
                }
            }
            b.call(Request::Run { ns: PERIOD }).unwrap();
            v.cycles += 1;
            for (ours, theirs) in &outputs {
                let (a, c) = (get(&mut b, ours), get(&mut b, theirs));
                if let (Value::Float(x), Value::Float(y)) = (a, c)
                    && x == 0.0
                    && y == 0.0
                    && a != c
                {
                    v.zeros += 1;
                }
                match apart(a, c) {
                    Some(ulps) if ulps <= allowed => v.ulps = v.ulps.max(ulps),
                    _ if v.differ.contains_key(ours) => (),
                    ulps => {
                        let mut said =
                            format!("cycle {}: {}, theirs {}", v.cycles, exact(a), exact(c));
                        if let Some(ulps) = ulps.filter(|n| *n < 1_000_000) {
                            write!(said, ", {ulps} ULPs").unwrap();
                        }
                        if std::env::var_os("JUDGE").is_some() {
                            println!("{style:?} {ours} {said}");
                            for (name, ..) in &inputs {
                                println!("    {name} {}", exact(get(&mut b, name)));
                            }
                        }
                        v.differ.insert(ours.clone(), said);
                    }
                }
            }
        }
        script(&mut b, &format!("unloadrt {PREFIX}{module}\nunloadrt {module}"));
    }
    Ok(v)
}

/// A row of the table, and whether it is as it should be.
fn told(module: &str, v: &Verdict) -> String {
    let new: Vec<_> = v.differ.iter().filter(|(n, _)| reason(module, n).is_none()).collect();
    let mut result = if let Some((name, said)) = new.first() {
        format!("DIFFERS: {} of {}; `{name}` {said}", new.len(), v.pins)
    } else if !v.differ.is_empty() {
        format!("equal but for {} of {}, which are known", v.differ.len(), v.pins)
    } else if v.ulps > 0 {
        let why = of(TOLERANCES, |r| r.0, module).map_or("", |r| r.2);
        format!("equal within {} ULPs: {why}", v.ulps)
    } else {
        "equal".to_owned()
    };
    if v.zeros > 0 {
        write!(result, "; 0 beside -0: {}", v.zeros).unwrap();
    }
    for (name, said) in &v.differ {
        if let Some(why) = reason(module, name) {
            write!(result, "; `{name}` {said}: {why}").unwrap();
        }
    }
    if let Some((_, list, why)) = of(POSITIVE, |r| r.0, module) {
        write!(result, "; {} kept positive: {why}", list.join(", ")).unwrap();
    }
    if let Some((_, list, why)) = of(STEADY, |r| r.0, module) {
        write!(result, "; {} set once: {why}", list.join(", ")).unwrap();
    }
    if let Some((_, list, why)) = of(ALONE, |r| r.0, module) {
        write!(result, "; {} left alone: {why}", list.join(", ")).unwrap();
    }
    if let Some((_, why)) = of(TAME, |r| r.0, module) {
        write!(result, "; without extremes: {why}").unwrap();
    }
    for (side, list) in [("only ours", &v.ours_only), ("only theirs", &v.theirs_only)] {
        if !list.is_empty() {
            write!(result, "; {side}: {}", list.join(", ")).unwrap();
        }
    }
    format!("{} | {} | {result}", v.pins, v.cycles)
}

/// In a process of its own: the row of the component that the environment names.
#[test]
fn one_component() {
    let Ok(module) = std::env::var("HAL_TEST_MODULE").or_else(|_| std::env::var("JUDGE")) else {
        return;
    };
    let cycles = std::env::var("HAL_TEST_CYCLES").map_or(CYCLES, |n| n.parse().unwrap());
    match judge(&module, cycles) {
        Ok(v) => println!("\nROW {}", told(&module, &v)),
        Err(e) => println!("\nROW | | DIFFERS: not judged: {e}"),
    }
}

fn row(module: &str, cycles: u64) -> String {
    if let Some((_, why)) = of(SKIPPED, |r| r.0, module) {
        return format!("| `{module}` | | | not judged: {why} |");
    }
    let mut me = Command::new(std::env::current_exe().unwrap());
    me.args(["--exact", "one_component", "--nocapture"]).env_remove("JUDGE");
    me.env("HAL_TEST_MODULE", module).env("HAL_TEST_CYCLES", cycles.to_string());
    let out = me.output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    match text.lines().find_map(|l| l.strip_prefix("ROW ")) {
        Some(row) => format!("| `{module}` | {row} |"),
        None => {
            let said = String::from_utf8_lossy(&out.stderr).into_owned();
            let said: Vec<&str> = said.lines().filter(|l| !l.trim().is_empty()).collect();
            format!("| `{module}` | | | DIFFERS: ended: {} |", said.join(" "))
        }
    }
}

/// What both have.
fn shared() -> Vec<String> {
    let folder = installed().unwrap();
    let mut b = Bench::new(&[]);
    let all = Request::List { kind: Kind::Offers, patterns: Vec::new(), ty: None };
    let Ok(Reply::Offers(list)) = b.call(all) else { return Vec::new() };
    let mut names: Vec<String> = list.into_iter().map(|o| o.component).collect();
    names.retain(|n| folder.join(format!("{n}.so")).is_file());
    names.sort();
    names.dedup();
    names
}

/// A component of each kind, for a while.
#[test]
fn some_components_do_as_theirs() {
    if installed().is_none() {
        eprintln!("skipped: LinuxCNC's package is not installed");
        return;
    }
    for module in ["and2", "pid", "limit3", "mux2"] {
        let row = row(module, QUICK);
        assert!(!row.contains("DIFFERS"), "{row}");
    }
}

#[test]
#[ignore = "takes minutes: every component that LinuxCNC's package has as well, 10,000 cycles each"]
fn every_component_does_as_theirs() {
    if installed().is_none() {
        eprintln!("skipped: LinuxCNC's package is not installed");
        return;
    }
    let rows: Vec<String> = shared().iter().map(|m| row(m, CYCLES)).collect();
    let judged = rows.iter().filter(|r| !r.contains("| not judged")).count();
    let equal = rows.iter().filter(|r| r.contains("| equal") && !r.contains("| equal but")).count();
    let mut text = format!(
        "# Our components beside LinuxCNC's, cycle by cycle\n\n\
         Both of a name are loaded into one engine on the virtual clock and given the same inputs\n\
         and parameters: chance, ramps, edges and extremes. Every pin and parameter is compared\n\
         after every cycle, bit for bit, but for the sign of zero: LinuxCNC's `.comp` modules add 0\n\
         to every number that they read, and have no -0. The components are loaded anew every {} cycles.\n\
         `UPDATE_EXPECT=1 cargo test -p hal-tests --test judge -- --ignored` writes this file.\n\n\
         Of {} that both have, {judged} are judged; {equal} are equal in all that is compared,\n\
         and the others but for what their rows tell.\n\n\
         | component | compared | cycles | result |\n\
         |---|---|---|---|\n",
        CYCLES / ROUNDS,
        rows.len()
    );
    for row in &rows {
        writeln!(text, "{row}").unwrap();
    }
    let file = root().join("tests/compat/judge.md");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(file, &text).unwrap();
    } else {
        assert_eq!(std::fs::read_to_string(file).unwrap_or_default(), text);
    }
    assert!(!text.contains("DIFFERS"), "{text}");
}
