//! The program latency-test: how regularly this computer runs realtime threads, with a verdict.

mod bands;

use crate::{
    Stdio, Terminal,
    language::units::nanoseconds,
    programs::{
        alone::Alone,
        options::{Opt, mixed, plain, program_usage},
    },
    terminal::{ended, termination::ending_flag},
};
pub use bands::Band;
use hal_engine::ClockKind;
use std::{fmt::Write as _, process::ExitCode, sync::atomic::Ordering};

/// Periods without a choice, in nanoseconds.
const BASE_NS: u64 = 25_000;
const SERVO_NS: u64 = 1_000_000;
/// Range of a period in nanoseconds.
const PERIODS: core::ops::RangeInclusive<u64> = 5_000..=1_000_000_000;
/// Numbers without a unit below this are microseconds; others are nanoseconds.
const MICROSECONDS: u64 = 1000;
/// Time between two looks at the signals that end the test, in nanoseconds.
const LOOK_NS: u64 = 100_000_000;
/// Looks between two tables.
const SHOW: u64 = 10;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Flag {
    For,
    Cpu,
    Virtual,
    Json,
    Help,
}

const OPTIONS: &[Opt<Flag>] = &[
    with("for", Flag::For, Some("TIME"), "end after TIME, such as 10min; without it, on Ctrl-C"),
    with("cpu", Flag::Cpu, Some("N"), "run the threads on this processor"),
    with("virtual", Flag::Virtual, None, "use the virtual clock, which is exactly regular"),
    with("json", Flag::Json, None, "print the result as an object"),
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Flag::Help, 'h') },
];

const fn with(
    name: &'static str,
    id: Flag,
    value: Option<&'static str>,
    help: &'static str,
) -> Opt<Flag> {
    Opt { id, short: None, long: Some(name), value, variable: None, help }
}

const ABOUT: &str = "\
Usage: latency-test [options] [BASE-PERIOD] [SERVO-PERIOD]

Runs one or two realtime threads and shows how irregular they are: the longest time between two cycles, and
the largest difference of such a time from the period (jitter). Use the computer meanwhile: move windows, copy
large files, play a film. Without periods there is a base thread of 25us and a servo thread of 1ms; one period
makes one thread. A number without a unit is in us below 1000, otherwise in ns.

Verdict by the largest jitter: up to 20us very good, 30us to 50us still good, above 100us not suitable.
halsetup asks for this number.

options:
";

/// A thread of the test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Thread {
    name: &'static str,
    period_ns: u64,
}

/// Figures of a thread so far, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Figures {
    max_interval: f64,
    max_jitter: f64,
    last_interval: f64,
}

/// Command line.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Wanted {
    threads: Vec<Thread>,
    limit_ns: Option<u64>,
    cpu: Option<usize>,
    clock: ClockKind,
    json: bool,
}

/// Returns the options for completion.
pub(crate) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

/// Runs the program with these command line arguments.
#[must_use]
pub fn main(words: &[String]) -> ExitCode {
    // Errors of options name the program already.
    let named =
        |text: String| format!("latency-test: {}", text.trim_start_matches("latency-test: "));
    ended(run(words).map_err(named))
}

fn run(words: &[String]) -> Result<(), String> {
    let Some(wanted) = wanted(words)? else {
        return Ok(Stdio.out(&format!("{ABOUT}{}", program_usage(OPTIONS)))?);
    };
    let ending = ending_flag();
    let mut engine = Alone::new(wanted.clock, wanted.cpu)?;
    engine.script("latency-test", &script(&wanted.threads))?;
    let scheduling = engine.status()?.scheduling;
    let is_live = Stdio.is_screen() && !wanted.json;
    let mut passed_ns = 0;
    let mut shown = 0;
    for n in 1_u64.. {
        let left = wanted.limit_ns.map_or(LOOK_NS, |limit| (limit - passed_ns).min(LOOK_NS));
        engine.pass(left)?;
        passed_ns += left;
        let is_over = ending.load(Ordering::Relaxed)
            || wanted.limit_ns.is_some_and(|limit| limit <= passed_ns);
        if is_live && (is_over || n.is_multiple_of(SHOW)) {
            let text = table(&wanted.threads, &figures(&mut engine, &wanted.threads)?);
            // The table before is written over.
            let up = if shown > 0 { format!("\x1b[{shown}A\x1b[J") } else { String::new() };
            Stdio.out(&format!("{up}{text}"))?;
            shown = text.lines().count();
        }
        if is_over {
            break;
        }
    }
    let figures = figures(&mut engine, &wanted.threads)?;
    if wanted.json {
        Stdio.out(&json(&wanted.threads, &figures, &scheduling))?;
        return Ok(());
    }
    if !is_live {
        Stdio.out(&table(&wanted.threads, &figures))?;
    }
    Stdio.out(&format!("{}scheduling: {scheduling}\n", verdict(&figures)))?;
    Ok(())
}

/// Reads the command line; `None` asks for help.
fn wanted(words: &[String]) -> Result<Option<Wanted>, String> {
    let (given, rest) = mixed("latency-test", OPTIONS, words).map_err(|e| e.to_string())?;
    let is_given = |flag| given.iter().any(|(id, _)| *id == flag);
    let value = |flag| given.iter().rev().find(|(id, _)| *id == flag).and_then(|(_, v)| v.clone());
    if is_given(Flag::Help) {
        return Ok(None);
    }
    let limit_ns = value(Flag::For).map(|text| match duration(&text) {
        Some(ns) if ns > 0 => Ok(ns),
        _ => Err(format!("--for '{text}': a time above 0, such as 90s or 10min")),
    });
    let cpu = value(Flag::Cpu).map(|text| {
        text.parse()
            .map_err(|_| format!("--cpu '{text}': it is the number of a processor, such as 3"))
    });
    let periods: Result<Vec<u64>, String> = rest.iter().map(|word| period(word)).collect();
    let clock = if is_given(Flag::Virtual) { ClockKind::Virtual } else { ClockKind::Real };
    let limit_ns = limit_ns.transpose()?;
    if clock == ClockKind::Virtual && limit_ns.is_none() {
        return Err("--virtual needs --for TIME: nobody waits for that clock".to_owned());
    }
    Ok(Some(Wanted {
        threads: threads(&periods?)?,
        limit_ns,
        cpu: cpu.transpose()?,
        clock,
        json: is_given(Flag::Json),
    }))
}

/// Reads a time; `min` is a unit too.
fn duration(text: &str) -> Option<u64> {
    if let Some(minutes) = text.strip_suffix("min") {
        let ns = minutes.trim().parse::<u64>().ok()?.checked_mul(60_000_000_000)?;
        return i64::try_from(ns).is_ok().then_some(ns);
    }
    nanoseconds(text).ok()
}

fn period(word: &str) -> Result<u64, String> {
    let ns = match word.parse::<u64>() {
        Ok(us) if us < MICROSECONDS => us.checked_mul(1000),
        Ok(ns) => Some(ns),
        Err(_) => nanoseconds(word).ok(),
    };
    ns.filter(|ns| PERIODS.contains(ns))
        .ok_or_else(|| format!("period '{word}': from 5us to 1s, such as 25us, 1ms or 50000 (ns)"))
}

/// Returns the threads, the fastest first.
fn threads(periods: &[u64]) -> Result<Vec<Thread>, String> {
    let thread = |name, period_ns| Thread { name, period_ns };
    match *periods {
        [] => Ok(vec![thread("base", BASE_NS), thread("servo", SERVO_NS)]),
        [one] => Ok(vec![thread("servo", one)]),
        [a, b] if a == b => Err("two threads have two periods".to_owned()),
        [a, b] => Ok(vec![thread("base", a.min(b)), thread("servo", a.max(b))]),
        [..] => Err("two periods at most".to_owned()),
    }
}

/// Returns the lines that make the threads and measure them.
fn script(threads: &[Thread]) -> String {
    let mut text = "loadrt threads".to_owned();
    for (n, thread) in (1..).zip(threads) {
        let Thread { name, period_ns } = thread;
        let _: std::fmt::Result = write!(text, " name{n}={name} period{n}={period_ns}");
    }
    let _: std::fmt::Result = write!(text, "\nloadrt timedelta count={}\n", threads.len());
    for (n, thread) in threads.iter().enumerate() {
        let _: std::fmt::Result = writeln!(text, "addf timedelta.{n} {}", thread.name);
    }
    text.push_str("start\n");
    text
}

fn figures(engine: &mut Alone, threads: &[Thread]) -> Result<Vec<Figures>, String> {
    let mut figure = |n: usize, pin: &str| engine.number(&format!("timedelta.{n}.{pin}"));
    let of = |n| {
        Ok(Figures {
            max_interval: figure(n, "max")?,
            max_jitter: figure(n, "jitter")?,
            last_interval: figure(n, "out")?,
        })
    };
    (0..threads.len()).map(of).collect()
}

/// Returns the band of a thread.
#[expect(clippy::cast_possible_truncation, reason = "a pin of 32 bits")]
fn band(figures: &Figures) -> Band {
    Band::of(figures.max_jitter as i64)
}

fn table(threads: &[Thread], figures: &[Figures]) -> String {
    let mut text = format!(
        "{:8}{:>14}{:>20}{:>18}{:>20}  verdict\n",
        "thread", "period, ns", "max interval, ns", "max jitter, ns", "last interval, ns"
    );
    for (thread, f) in threads.iter().zip(figures) {
        let _: std::fmt::Result = writeln!(
            text,
            "{:8}{:>14}{:>20}{:>18}{:>20}  {}",
            thread.name,
            thread.period_ns,
            f.max_interval,
            f.max_jitter,
            f.last_interval,
            band(f).words()
        );
    }
    text
}

/// Returns the largest jitter of all threads, and what it means.
fn verdict(figures: &[Figures]) -> String {
    let worst = figures.iter().fold(0.0, |most, f| f64::max(most, f.max_jitter));
    let words = band(&Figures { max_jitter: worst, ..Figures::default() }).words();
    format!("largest jitter: {worst} ns, {words}\nfor halsetup: latency = {worst}\n")
}

fn json(threads: &[Thread], figures: &[Figures], scheduling: &str) -> String {
    let rows = threads.iter().zip(figures).map(|(thread, f)| {
        serde_json::json!({
            "thread": thread.name, "period": thread.period_ns, "max_interval": f.max_interval,
            "max_jitter": f.max_jitter, "verdict": band(f).name(), "words": band(f).words(),
        })
    });
    let all = serde_json::json!({ "threads": rows.collect::<Vec<_>>(), "scheduling": scheduling });
    format!("{all}\n")
}

#[cfg(test)]
mod tests {
    //! Command lines.

    use super::{ClockKind, Figures, PERIODS, Thread, period, script, verdict, wanted};

    fn read(line: &str) -> Result<Option<super::Wanted>, String> {
        wanted(&line.split_whitespace().map(str::to_owned).collect::<Vec<_>>())
    }

    #[test]
    fn periods_are_in_the_units_of_linuxcnc() {
        for (line, base, servo) in [
            ("", Some(25_000), 1_000_000),
            ("50000 1000000", Some(50_000), 1_000_000),
            ("1ms 50us", Some(50_000), 1_000_000),
            ("25 1000000", Some(25_000), 1_000_000),
            ("1ms", None, 1_000_000),
            ("500µs", None, 500_000),
        ] {
            let got = read(line).unwrap().unwrap().threads;
            let mut want: Vec<Thread> =
                base.map(|period_ns| Thread { name: "base", period_ns }).into_iter().collect();
            want.push(Thread { name: "servo", period_ns: servo });
            assert_eq!(got, want, "{line}");
        }
        assert_eq!(period("5us"), Ok(*PERIODS.start()));
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_can() {
        for (line, why) in [
            ("4us", "period '4us': from 5us to 1s"),
            ("2s", "period '2s': from 5us to 1s"),
            ("fast", "period 'fast': from 5us to 1s"),
            ("-5", "invalid option"),
            ("1ms 1ms", "two threads have two periods"),
            ("1 2 3", "period '1': from 5us to 1s"),
            ("10 20 30", "two periods at most"),
            ("--for 0s", "--for '0s': a time above 0"),
            ("--for ever", "--for 'ever': a time above 0"),
            ("--cpu x", "--cpu 'x': it is the number of a processor"),
            ("--virtual", "--virtual needs --for TIME"),
            ("--nothing", "nothing"),
        ] {
            let said = read(line).unwrap_err();
            assert!(said.contains(why), "{line}: {said}");
        }
        let wanted = read("--virtual --for 10min --json").unwrap().unwrap();
        assert_eq!((wanted.limit_ns, wanted.clock), (Some(600_000_000_000), ClockKind::Virtual));
    }

    #[test]
    fn the_worst_thread_decides() {
        let of = |max_jitter| Figures { max_jitter, ..Figures::default() };
        let said = verdict(&[of(11_732.0), of(41_000.0)]);
        assert_eq!(said, "largest jitter: 41000 ns, still good\nfor halsetup: latency = 41000\n");
        let thread = Thread { name: "servo", period_ns: 1_000_000 };
        let lines = "loadrt threads name1=servo period1=1000000\nloadrt timedelta count=1\naddf timedelta.0 servo\nstart\n";
        assert_eq!(script(&[thread]), lines);
    }
}
