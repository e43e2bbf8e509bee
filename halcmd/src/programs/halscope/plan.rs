//! The parsed options of `halscope capture`.

use crate::{
    language::units::nanoseconds,
    programs::options::{Opt, from_environment, mixed, plain, usage},
    session::remote::instance_option,
};
use hal_trace::{
    Format,
    trigger::{Condition, HoldOff, Mode, Setup},
};
use std::{collections::BTreeSet, path::PathBuf};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Output,
    Thread,
    Every,
    Length,
    Trigger,
    Before,
    Auto,
    Count,
    HoldOff,
    Timeout,
    Run,
    Depth,
    Quiet,
    Instance,
    Help,
}

const fn with(id: Id, short: char, long: &'static str, value: &'static str) -> Opt<Id> {
    Opt { long: Some(long), ..Opt::short_with(id, short, value) }
}

const fn long(id: Id, long: &'static str, value: &'static str) -> Opt<Id> {
    Opt { short: None, ..with(id, ' ', long, value) }
}

const OPTIONS: &[Opt<Id>] = &[
    Opt {
        help: "where to: .vcd, .fst, .csv or .json; without it, CSV is printed",
        ..with(Id::Output, 'o', "output", "FILE")
    },
    Opt {
        help: "how much: a number of samples, or a time (1000)",
        ..with(Id::Length, 'l', "length", "N|TIME")
    },
    Opt {
        help: "when, as in 'stepgen.0.step rises' (at once)",
        ..with(Id::Trigger, 't', "trigger", "CONDITION")
    },
    Opt {
        help: "how much of it before the trigger, as in 25% (0)",
        ..with(Id::Before, 'b', "before", "SHARE|N|TIME")
    },
    Opt { help: "thread to sample in (the fastest)", ..long(Id::Thread, "thread", "NAME") },
    Opt { help: "sample at each N-th cycle (1)", ..with(Id::Every, 'e', "every", "N") },
    Opt {
        help: "so many captures, at one trigger each: FILE-1, FILE-2, ... (1)",
        ..with(Id::Count, 'n', "count", "N")
    },
    Opt {
        help: "shortest time between two triggers (0)",
        ..long(Id::HoldOff, "hold-off", "N|TIME")
    },
    Opt { help: "capture without a trigger after this time", ..long(Id::Auto, "auto", "TIME") },
    Opt {
        help: "give up after so long without a trigger, in machine time",
        ..long(Id::Timeout, "timeout", "TIME")
    },
    Opt {
        help: "move a virtual clock that is held by so much meanwhile",
        ..long(Id::Run, "run", "TIME")
    },
    Opt { help: "number of samples that the ring holds", ..long(Id::Depth, "depth", "N") },
    Opt { help: "print errors only", long: Some("quiet"), ..Opt::flag(Id::Quiet, 'q') },
    instance_option(Id::Instance),
    Opt { help: "print this", long: Some("help"), ..Opt::flag(Id::Help, 'h') },
];

/// Returns the options for completion.
pub(super) fn completable() -> Vec<Opt<()>> {
    plain(OPTIONS)
}

const MORE: &str = "
A NAME is a pin, signal or parameter; with *, ? or [ ] it means all that match. What the trigger
names is sampled as well. SIGUSR1 triggers at once.

A CONDITION: NAME rises, falls, toggles (bits), NAME (a bit is true), NAME changes,
NAME > 5 (<, <=, >=, =, !=), NAME rises through 5 (falls through, crosses), NAME in -1..1
(outside), with not, and, or and parentheses.
";

const EXIT: &str = "
The exit status: 0 all captures are whole; 1 an error; 2 no trigger came; 3 one came and its
capture did not become whole, because the machine or the user ended it: what there is was written.
";

const VIEW: &str = "view FILE [CHANNEL...], or view [options] NAME...";

const OF_VIEW: &str = "
The captures repeat until q is pressed. ? shows the keys.
";

/// Returns the help of a command, with the options that it takes.
fn help(line: &str) -> String {
    if line != VIEW {
        return usage_of(line, OPTIONS, &format!("{MORE}{EXIT}"));
    }
    let of_files = [Id::Output, Id::Count];
    let options: Vec<_> = OPTIONS.iter().filter(|o| !of_files.contains(&o.id)).copied().collect();
    usage_of(line, &options, &format!("{MORE}{OF_VIEW}"))
}

/// A number of samples, a duration, or a fraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Amount {
    Samples(u64),
    Time(u64),
    Share(f64),
}

impl Amount {
    fn parse(text: &str) -> Option<Self> {
        if let Some(percent) = text.strip_suffix('%') {
            let percent: f64 = percent.parse().ok()?;
            return (0.0..=100.0).contains(&percent).then_some(Self::Share(percent / 100.0));
        }
        let samples = text.parse().ok().map(Self::Samples);
        samples.or_else(|| nanoseconds(text).ok().map(Self::Time))
    }

    /// Converts to samples, one every `each` nanoseconds. A fraction is a fraction of `of`.
    fn samples(self, each: i64, of: u64) -> u64 {
        match self {
            Self::Samples(n) => n,
            Self::Time(ns) => ns.div_ceil(each.max(1).unsigned_abs()),
            Self::Share(share) => Setup { length: of, ..Setup::default() }.with_share(share).before,
        }
    }
}

/// Machine time without a trigger after which a view captures anyway, in nanoseconds.
const VIEW_AUTO_NS: i64 = 500_000_000;

fn is_pattern(name: &str) -> bool {
    name.contains(['*', '?', '['])
}

/// The parsed command line.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) names: Vec<String>,
    pub(super) output: Option<PathBuf>,
    pub(super) thread: Option<String>,
    pub(super) every: u32,
    pub(super) depth: u32,
    length: Amount,
    before: Amount,
    hold_off: Amount,
    pub(super) condition: Option<Condition>,
    auto: Option<u64>,
    pub(super) count: u64,
    pub(super) timeout: Option<u64>,
    pub(super) run: Option<u64>,
    pub(super) is_quiet: bool,
    is_view: bool,
    pub(super) instance: Option<String>,
}

/// A plan, or the usage text if the user asked for it.
pub(super) enum Asked {
    Plan(Box<Plan>),
    Help(String),
}

impl Plan {
    pub(super) fn parse(words: &[String]) -> Result<Asked, String> {
        Self::of("capture [options] NAME...", words)
    }

    /// Parses the command line of a view, whose captures repeat until the user leaves it.
    pub(super) fn for_view(words: &[String]) -> Result<Asked, String> {
        let asked = Self::of(VIEW, words)?;
        let Asked::Plan(mut plan) = asked else { return Ok(asked) };
        if plan.output.is_some() || plan.count > 1 {
            return Err(
                "a view writes when w is pressed; halscope capture has -o and -n".to_owned()
            );
        }
        plan.is_view = true;
        Ok(Asked::Plan(plan))
    }

    fn of(line: &str, words: &[String]) -> Result<Asked, String> {
        let (mut given, names) =
            mixed("halscope capture", OPTIONS, words).map_err(|e| e.to_string())?;
        from_environment(OPTIONS, &|name| std::env::var(name).ok(), &mut given);
        let mut plan = Self {
            names,
            output: None,
            thread: None,
            every: 1,
            depth: 0,
            length: Amount::Samples(1000),
            before: Amount::Samples(0),
            hold_off: Amount::Samples(0),
            condition: None,
            auto: None,
            count: 1,
            timeout: None,
            run: None,
            is_quiet: false,
            is_view: false,
            instance: None,
        };
        for (id, value) in given {
            if id == Id::Help {
                return Ok(Asked::Help(help(line)));
            }
            plan.option(id, value.unwrap_or_default())?;
        }
        if plan.names.is_empty() && plan.condition.is_none() {
            return Err("no pin to capture is named".to_owned());
        }
        let of_trigger = plan.condition.iter().flat_map(|c| c.names()).map(str::to_owned);
        let of_trigger: Vec<String> = of_trigger.collect();
        // A name that a pattern also matches is listed once, because patterns come after names.
        let more = of_trigger.into_iter().filter(|n| !plan.names.contains(n));
        let more: Vec<String> = more.collect();
        let (patterns, mut names): (Vec<_>, Vec<_>) =
            plan.names.drain(..).partition(|n| is_pattern(n));
        names.extend(more);
        // A name that is given twice is one channel, at its first place.
        let mut known = BTreeSet::new();
        names.retain(|name| known.insert(name.clone()));
        plan.names = names.into_iter().chain(patterns).collect();
        if plan.auto.is_some() && plan.condition.is_none() {
            return Err("--auto is for a trigger: say one with -t".to_owned());
        }
        if plan.count > 1 && plan.output.is_none() {
            return Err("several captures need files: say -o FILE".to_owned());
        }
        Ok(Asked::Plan(Box::new(plan)))
    }

    fn option(&mut self, id: Id, value: String) -> Result<(), String> {
        let table = OPTIONS.iter().find(|o| o.id == id);
        let name = table.and_then(|o| o.long).unwrap_or_default();
        let bad = |wanted: &str| format!("--{name} '{value}': {wanted}");
        let number = || value.parse::<u64>().ok().filter(|n| *n > 0);
        let small = || number().and_then(|n| u32::try_from(n).ok());
        let time = || nanoseconds(&value).ok();
        let amount = || Amount::parse(&value);
        let a_number = "a number from 1 is expected";
        let a_time = "a time such as 20ms or 1.5s is expected";
        let an_amount = "a number of samples or a time such as 20ms is expected";
        match id {
            Id::Output => {
                let path = PathBuf::from(&value);
                if Format::of(&path).is_none() && !value.starts_with("/dev/") {
                    return Err(bad("a file ends in .vcd, .fst, .csv or .json"));
                }
                self.output = Some(path);
            }
            Id::Thread => self.thread = Some(value),
            Id::Instance => self.instance = Some(value),
            Id::Every => self.every = small().ok_or_else(|| bad(a_number))?,
            Id::Depth => self.depth = small().ok_or_else(|| bad(a_number))?,
            Id::Count => self.count = number().ok_or_else(|| bad(a_number))?,
            Id::Length => {
                let got = amount().filter(|a| {
                    !matches!(a, Amount::Share(_) | Amount::Samples(0) | Amount::Time(0))
                });
                self.length = got.ok_or_else(|| bad(an_amount))?;
            }
            Id::Before => {
                let wanted = "a share such as 25%, a number of samples or a time is expected";
                self.before = amount().ok_or_else(|| bad(wanted))?;
            }
            Id::HoldOff => {
                let got = amount().filter(|a| !matches!(a, Amount::Share(_)));
                self.hold_off = got.ok_or_else(|| bad(an_amount))?;
            }
            Id::Trigger => {
                let read = Condition::parse(&value);
                self.condition = Some(read.map_err(|e| e.to_string())?);
            }
            Id::Auto => self.auto = Some(time().ok_or_else(|| bad(a_time))?),
            Id::Timeout => self.timeout = Some(time().ok_or_else(|| bad(a_time))?),
            Id::Run => self.run = Some(time().ok_or_else(|| bad(a_time))?),
            Id::Quiet => self.is_quiet = true,
            Id::Help => {}
        }
        Ok(())
    }

    /// Returns the names that are not patterns; they come first.
    pub(super) fn whole_names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str).take_while(|n| !is_pattern(n))
    }

    /// Returns the lengths of the capture for a sample every `each` nanoseconds.
    pub(super) fn setup(&self, each: i64) -> Result<Setup, String> {
        let length = self.length.samples(each, 0);
        let before = self.before.samples(each, length);
        if before >= length {
            return Err(format!(
                "--before is {before} samples, of {length} in all: the trigger would be \
                 behind the end"
            ));
        }
        let hold_off = match self.hold_off {
            Amount::Time(ns) => HoldOff::Time(i64::try_from(ns).unwrap_or(i64::MAX)),
            other => HoldOff::Samples(other.samples(each, 0)),
        };
        let mode = match (self.auto, self.count) {
            (auto, _) if self.is_view => {
                Mode::Auto(auto.map_or(VIEW_AUTO_NS, |ns| i64::try_from(ns).unwrap_or(i64::MAX)))
            }
            (Some(ns), _) => Mode::Auto(i64::try_from(ns).unwrap_or(i64::MAX)),
            (None, 1) => Mode::Single,
            (None, _) => Mode::Normal,
        };
        Ok(Setup { length, before, mode, hold_off })
    }
}

/// Returns the usage text of a command.
pub(super) fn usage_of<T>(line: &str, table: &[Opt<T>], more: &str) -> String {
    format!("Usage: halscope {line}\n\n{}{more}", usage(table))
}
