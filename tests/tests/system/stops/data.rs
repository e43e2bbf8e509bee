//! The tables of `tests/stops`: machines, and rules for each control and kind of motion.

use super::clients::Client;
use hal_tests::programs::root;
use serde::Deserialize;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

/// Kinds of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Motion {
    Jog,
    Line,
    Program,
    Homing,
}

impl Motion {
    pub(super) const ALL: [Self; 4] = [Self::Jog, Self::Line, Self::Program, Self::Homing];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Jog => "jog",
            Self::Line => "line",
            Self::Program => "program",
            Self::Homing => "homing",
        }
    }
}

/// Limits of the following error of joints.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FollowingError {
    /// Limit at `velocity`.
    pub(super) most: f64,
    /// Limit at rest.
    pub(super) least: f64,
    pub(super) velocity: f64,
    /// Joint whose feedback stands still in jogs and on paths.
    #[serde(default)]
    pub(super) joint: usize,
}

/// A jog of a joint, or of an axis.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Jog {
    pub(super) joint: Option<usize>,
    pub(super) axis: Option<char>,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    #[serde(default)]
    pub(super) jerk: f64,
    /// Place towards which it goes.
    pub(super) middle: f64,
}

const fn half() -> f64 {
    0.5
}

const fn whole() -> f64 {
    1.0
}

/// Moves along a path in the plane of two axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PathMoves {
    pub(super) axes: String,
    pub(super) velocity: f64,
    pub(super) acceleration: [f64; 2],
    /// Share of the lower acceleration that the turn of a circle takes.
    #[serde(default = "half")]
    pub(super) turn: f64,
    /// Share of the commanded speed that the planner gives.
    #[serde(default = "whole")]
    pub(super) reached: f64,
    /// Acceleration that moves are given, where that of the path counts and not that of the axes.
    pub(super) given: Option<f64>,
    #[serde(default)]
    pub(super) jerk: f64,
    pub(super) middle: [f64; 2],
}

/// The e-stop input of a machine.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Chain {
    pub(super) pin: String,
    pub(super) open: String,
    pub(super) closed: String,
    /// Cycles after which the controller sees it.
    pub(super) cycles: usize,
}

/// A machine that moves by `motmod`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Machine {
    #[serde(skip)]
    pub(super) name: String,
    /// INI file or script.
    pub(super) script: String,
    pub(super) letters: String,
    pub(super) joints: usize,
    #[serde(default)]
    unit: Option<String>,
    /// Lines of a script that make it ready to be switched on.
    #[serde(default)]
    pub(super) begin: Vec<String>,
    pub(super) jog: Jog,
    /// Search of a joint for its home switch; as the jog, if absent.
    homing: Option<Jog>,
    pub(super) path: PathMoves,
    pub(super) ferror: FollowingError,
    pub(super) chain: Option<Chain>,
    /// Signal of its charge pump.
    pub(super) charge_pump: Option<String>,
    /// True if each cell needs the machine as it is after its start.
    #[serde(default)]
    pub(super) needs_fresh: bool,
    /// Reason why no program with the control lease starts beside it: it says so by name.
    pub(super) no_lease: Option<String>,
}

impl Machine {
    /// Returns the unit of its lengths.
    pub(super) fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or("mm")
    }

    /// Returns the joint that homes.
    pub(super) fn joint(&self) -> usize {
        self.homing().joint.unwrap()
    }

    /// Returns the motion of the joint that looks for its home switch.
    pub(super) fn homing(&self) -> Jog {
        self.homing.clone().unwrap_or_else(|| self.jog.clone())
    }

    /// Returns whether it is started from an INI file.
    pub(super) fn is_ini(&self) -> bool {
        self.script.ends_with(".ini")
    }
}

/// A folder of `configs`.
#[derive(Clone, Debug)]
pub(super) enum Entry {
    Machine(Box<Machine>),
    /// A robot behind a controller of its own, with its script and program.
    Robot(String, String),
    /// Nothing moves, for this reason.
    Still(String),
}

pub(super) fn read(name: &str) -> toml::Table {
    let text = fs::read_to_string(root().join("tests/stops").join(name)).unwrap();
    toml::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Returns the entries of all folders of `configs`.
pub(super) fn entries() -> BTreeMap<String, Entry> {
    let entry = |(name, value): (String, toml::Value)| {
        let text = |key: &str| value.get(key).map(|v| v.as_str().unwrap().to_owned());
        let entry = match (text("still"), text("robot")) {
            (Some(why), _) => Entry::Still(why),
            (None, Some(program)) => Entry::Robot(text("script").unwrap(), program),
            (None, None) => {
                let machine = value.try_into::<Machine>();
                let machine = machine.unwrap_or_else(|e| panic!("machines.toml, {name}: {e}"));
                Entry::Machine(Box::new(Machine { name: name.clone(), ..machine }))
            }
        };
        (name, entry)
    };
    read("machines.toml").into_iter().map(entry).collect()
}

/// Returns the machines that move by `motmod`, by name.
pub(super) fn machines() -> Vec<Machine> {
    let all = entries().into_values();
    all.filter_map(|entry| if let Entry::Machine(m) = entry { Some(*m) } else { None }).collect()
}

/// Effect that a stop must have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Effect {
    /// The machine is off after so many cycles.
    Off(usize),
    /// Braking begins after so many cycles, and the motion is forgotten.
    Brake(usize),
    /// The joint stands after so many cycles, without a ramp; a following error may switch the machine off.
    AtOnce(usize),
    /// Braking begins, and the path waits for a resume.
    Rest(usize),
    /// The same, and the path goes on when the pin has its value again.
    Hold(usize),
    /// Braking begins as soon as the machine knows that a program has ended.
    Ends,
    /// The motion goes on.
    On,
    /// The cell cannot be, for this reason.
    Cannot(String),
}

impl Effect {
    pub(super) fn parse(text: &str) -> Self {
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        let cycles = || rest.parse().unwrap_or_else(|_| panic!("rules.toml: {text}"));
        match word {
            "off" => Self::Off(cycles()),
            "brake" => Self::Brake(cycles()),
            "at-once" => Self::AtOnce(cycles()),
            "rest" => Self::Rest(cycles()),
            "hold" => Self::Hold(cycles()),
            "ends" => Self::Ends,
            "on" => Self::On,
            "none" if !rest.is_empty() => Self::Cannot(rest.to_owned()),
            _ => panic!("rules.toml: {text}"),
        }
    }
}

/// A pin that gets another value, whatever it is linked to.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Force {
    pub(super) pin: String,
    pub(super) value: String,
}

/// A stop control with its rules.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Control {
    pub(super) name: String,
    pub(super) command: Option<String>,
    pub(super) button: Option<String>,
    /// Command of the panel.
    pub(super) panel: Option<String>,
    /// Words behind `set` in the text protocol of linuxcncrsh.
    pub(super) rsh: Option<String>,
    /// Name of a stop that a program in Python gives.
    pub(super) python: Option<String>,
    pub(super) force: Option<Force>,
    #[serde(default)]
    pub(super) chain: bool,
    #[serde(default)]
    pub(super) ferror: bool,
    /// Part that the machine must have: `task`.
    pub(super) needs: Option<String>,
    jog: Option<String>,
    line: Option<String>,
    program: Option<String>,
    homing: Option<String>,
}

impl Control {
    /// Returns the program that gives the stop, with its words.
    pub(super) fn client(&self) -> Option<(Client, &str)> {
        let all = [
            (Client::Panel, &self.panel),
            (Client::Rsh, &self.rsh),
            (Client::Python, &self.python),
        ];
        all.into_iter().find_map(|(client, words)| Some((client, words.as_deref()?)))
    }

    /// Returns the effect on a kind of motion.
    ///
    /// # Panics
    /// There is no rule.
    pub(super) fn effect(&self, motion: Motion) -> Effect {
        let text = match motion {
            Motion::Jog => &self.jog,
            Motion::Line => &self.line,
            Motion::Program => &self.program,
            Motion::Homing => &self.homing,
        };
        let missing = || panic!("rules.toml: {} has no rule for {}", self.name, motion.name());
        Effect::parse(text.as_deref().unwrap_or_else(missing))
    }
}

/// Returns all controls.
pub(super) fn controls() -> Vec<Control> {
    let list = read("rules.toml").remove("control").unwrap();
    let list: Vec<toml::Value> = list.try_into().unwrap();
    list.into_iter().map(|c| c.try_into().unwrap_or_else(|e| panic!("rules.toml: {e}"))).collect()
}

/// Returns the names that `rules.toml` says to be no stop controls, of a list.
pub(super) fn known(list: &str) -> BTreeSet<String> {
    let mut table = read("rules.toml");
    let others = table.remove("others").and_then(|o| o.get(list).cloned());
    let words: Vec<String> = others.unwrap_or_else(|| panic!("others.{list}")).try_into().unwrap();
    words.iter().flat_map(|line| line.split_whitespace()).map(str::to_owned).collect()
}

/// A stop control of a robot behind a controller of its own.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotControl {
    pub(super) name: String,
    pub(super) command: Option<String>,
    pub(super) force: Option<Force>,
    pub(super) panel: Option<String>,
    effect: String,
}

impl RobotControl {
    /// Returns the cycles after which the robot stands; `None` if the move under way ends.
    pub(super) fn cycles(&self) -> Option<usize> {
        match self.effect.split_once(' ') {
            None if self.effect == "ends" => None,
            Some(("stands", cycles)) => Some(cycles.parse().unwrap()),
            _ => panic!("rules.toml: {}", self.effect),
        }
    }
}

/// Returns the controls of a robot.
pub(super) fn robot_controls() -> Vec<RobotControl> {
    let list = read("rules.toml").remove("robot").unwrap();
    list.try_into().unwrap_or_else(|e| panic!("rules.toml: {e}"))
}
