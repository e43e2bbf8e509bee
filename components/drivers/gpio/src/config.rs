//! Arguments of `loadrt`: lines with their settings.

use crate::label::{Label, nearest};
use core::fmt;

/// Largest number of lines, as in LinuxCNC.
pub(crate) const MOST_LINES: usize = 128;

/// Resistor that the chip connects to an input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Bias {
    /// As the chip is set.
    #[default]
    AsIs,
    Disabled,
    PullDown,
    PullUp,
}

/// Levels that an output drives; it leaves the line alone otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Drive {
    #[default]
    Both,
    /// Low alone.
    OpenDrain,
    /// High alone.
    OpenSource,
}

/// Settings of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Setting {
    pub(crate) is_output: bool,
    pub(crate) is_active_low: bool,
    pub(crate) bias: Bias,
    pub(crate) drive: Drive,
    pub(crate) debounce_us: u32,
    /// True if the kernel notes its edges.
    pub(crate) has_edges: bool,
}

/// Place of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// The line with this name, on any chip.
    Named,
    /// A line of `gpiochipN`, by its number.
    At { chip: u32, offset: u32 },
    /// A line of the chip that drives the 40-pin header of a Raspberry Pi, by its number.
    Header(u32),
}

/// Line that the user named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NamedLine {
    pub(crate) name: Label,
    pub(crate) place: Place,
    pub(crate) setting: Setting,
    /// True if the reset function returns it to rest.
    pub(crate) is_reset: bool,
}

/// Encoder of one line to three: A, B and the index, by their places in the list of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EncoderLines {
    pub(crate) a: usize,
    pub(crate) b: Option<usize>,
    pub(crate) z: Option<usize>,
}

/// Lines and encoders of a load.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct GpioConfig {
    pub(crate) lines: Vec<NamedLine>,
    pub(crate) encoders: Vec<EncoderLines>,
    /// True if an argument for outputs names an input, where it has no effect.
    pub(crate) is_without_effect: bool,
}

/// Problem of an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BadLines {
    Nothing,
    TooMany,
    NoName(&'static str),
    TooLong(&'static str, Label),
    Twice(Label),
    Unlisted(&'static str, Label, Option<Label>),
    ForOutputs(&'static str, Label),
    ForInputs(&'static str, Label),
    Both(&'static str, &'static str, Label),
    NoTime(Label),
    NoEncoder(Label),
}

impl fmt::Display for BadLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nothing => {
                write!(f, "no lines: give inputs=, outputs= or encoders=, such as inputs=GPIO17")
            }
            Self::TooMany => write!(f, "more than {MOST_LINES} lines"),
            Self::NoName(arg) => write!(
                f,
                "{arg}= has an empty name: expected names of lines without blanks, such as GPIO5,GPIO6"
            ),
            Self::TooLong(arg, name) => write!(
                f,
                "{arg}= has the name '{name}…': expected names of at most {} bytes, as the kernel's",
                Label::MOST
            ),
            Self::Twice(name) => write!(
                f,
                "line '{name}' is named twice in inputs=, outputs= and encoders=: a line is one of \
                 these, once"
            ),
            Self::Unlisted(arg, name, near) => {
                write!(
                    f,
                    "{arg}= names '{name}', which is in none of inputs=, outputs=, encoders="
                )?;
                near.map_or(Ok(()), |near| write!(f, "; did you mean '{near}'?"))
            }
            Self::ForOutputs(arg, name) => {
                write!(f, "{arg}= names '{name}', which is an input: it is for outputs=")
            }
            Self::ForInputs(arg, name) => {
                write!(
                    f,
                    "{arg}= names '{name}', which is an output: it is for inputs= and encoders="
                )
            }
            Self::Both(one, other, name) => {
                write!(f, "line '{name}' is in {one}= and in {other}=: it can be one of these")
            }
            Self::NoTime(word) => write!(
                f,
                "debounce= has '{word}': expected NAME:MICROSECONDS, such as GPIO17:2000, from 1 to \
                 {MOST_DEBOUNCE}"
            ),
            Self::NoEncoder(word) => write!(
                f,
                "encoders= has '{word}': expected A:B, A:B:INDEX, or the one line of a pulse \
                 counter"
            ),
        }
    }
}

/// Longest debounce time, in microseconds.
const MOST_DEBOUNCE: u32 = 1_000_000;

/// Arguments that set something for lines, in the order in which they take effect.
pub(crate) const MARKS: [&str; 9] = [
    "invert",
    "activelow",
    "reset",
    "opendrain",
    "opensource",
    "biasdisable",
    "pulldown",
    "pullup",
    "debounce",
];

/// Reads the arguments; `texts` returns the list of an argument.
pub(crate) fn parse(texts: impl Fn(&'static str) -> Vec<String>) -> Result<GpioConfig, BadLines> {
    let mut config = GpioConfig::default();
    for (arg, is_output) in [("inputs", false), ("outputs", true)] {
        for word in texts(arg) {
            add(&mut config, arg, &word, Setting { is_output, ..Setting::default() })?;
        }
    }
    for word in texts("encoders") {
        let setting = Setting { has_edges: true, ..Setting::default() };
        let mut lines = [None; 3];
        for (count, name) in word.split(':').enumerate() {
            let slot = lines.get_mut(count).ok_or(BadLines::NoEncoder(Label::cut(&word)))?;
            *slot = Some(add(&mut config, "encoders", name, setting)?);
        }
        let [a, b, z] = lines;
        let a = a.ok_or(BadLines::NoEncoder(Label::cut(&word)))?;
        config.encoders.push(EncoderLines { a, b, z });
    }
    if config.lines.is_empty() {
        return Err(BadLines::Nothing);
    }
    for arg in MARKS {
        for word in texts(arg) {
            mark(&mut config, arg, &word)?;
        }
    }
    Ok(config)
}

/// Adds a line. Returns its place in the list.
fn add(
    config: &mut GpioConfig,
    arg: &'static str,
    word: &str,
    setting: Setting,
) -> Result<usize, BadLines> {
    let name = name(arg, word)?;
    if config.lines.iter().any(|line| line.name == name) {
        return Err(BadLines::Twice(name));
    }
    if config.lines.len() >= MOST_LINES {
        return Err(BadLines::TooMany);
    }
    config.lines.push(NamedLine { name, place: place(word), setting, is_reset: false });
    Ok(config.lines.len() - 1)
}

fn name(arg: &'static str, word: &str) -> Result<Label, BadLines> {
    if word.is_empty() {
        return Err(BadLines::NoName(arg));
    }
    Label::new(word).ok_or_else(|| BadLines::TooLong(arg, Label::cut(word)))
}

/// Returns the place that a name means: `gpiochip0.17` is line 17 of gpiochip0.
fn place(word: &str) -> Place {
    let numbers = word.strip_prefix("gpiochip").and_then(|rest| rest.split_once('.'));
    match numbers.map(|(chip, offset)| (chip.parse(), offset.parse())) {
        Some((Ok(chip), Ok(offset))) => Place::At { chip, offset },
        _ => Place::Named,
    }
}

fn mark(config: &mut GpioConfig, arg: &'static str, word: &str) -> Result<(), BadLines> {
    let (word, time) = if arg == "debounce" {
        let bad = BadLines::NoTime(Label::cut(word));
        let (word, time) = word.rsplit_once(':').ok_or(bad)?;
        let time = time.parse().ok().filter(|time| (1..=MOST_DEBOUNCE).contains(time));
        (word, time.ok_or(bad)?)
    } else {
        (word, 0)
    };
    let name = name(arg, word)?;
    let Some(line) = config.lines.iter_mut().find(|line| line.name == name) else {
        let near = nearest(name, config.lines.iter().map(|line| line.name));
        return Err(BadLines::Unlisted(arg, name, near));
    };
    let setting = &mut line.setting;
    match arg {
        // LinuxCNC takes these two for inputs as well, where they do nothing.
        "invert" | "reset" if !setting.is_output => config.is_without_effect = true,
        "reset" => line.is_reset = true,
        "invert" | "activelow" => setting.is_active_low = true,
        "opendrain" | "opensource" => {
            if !setting.is_output {
                return Err(BadLines::ForOutputs(arg, name));
            }
            let drive = if arg == "opendrain" { Drive::OpenDrain } else { Drive::OpenSource };
            if setting.drive != Drive::Both && setting.drive != drive {
                return Err(BadLines::Both("opendrain", "opensource", name));
            }
            setting.drive = drive;
        }
        "debounce" => {
            if setting.is_output {
                return Err(BadLines::ForInputs(arg, name));
            }
            setting.debounce_us = time;
        }
        _ => {
            let bias = match arg {
                "biasdisable" => Bias::Disabled,
                "pulldown" => Bias::PullDown,
                _ => Bias::PullUp,
            };
            if setting.bias != Bias::AsIs && setting.bias != bias {
                return Err(BadLines::Both(bias_arg(setting.bias), arg, name));
            }
            setting.bias = bias;
        }
    }
    Ok(())
}

const fn bias_arg(bias: Bias) -> &'static str {
    match bias {
        Bias::AsIs | Bias::Disabled => "biasdisable",
        Bias::PullDown => "pulldown",
        Bias::PullUp => "pullup",
    }
}
