//! The answers from which a machine is written: the form of their TOML text, and what is checked of them before anything
//! is written.

use super::lines;
use serde::Deserialize;
use std::collections::BTreeSet;
use toml::Spanned;

/// Largest number of parallel ports.
const MAX_PORTS: usize = 8;
/// Largest magnitude of lengths, speeds, accelerations and ratios.
const LARGEST: f64 = 1e9;

/// Motors of the joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Motors {
    /// Stepper motors, an axis each.
    Steppers,
    /// Servo motors with encoders, an axis each.
    Servos,
    /// Stepper motors of the six joints of an arm.
    Arm,
}

/// The board with the inputs and outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Driver {
    Parport,
    Viagpio,
}

/// Unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Units {
    Mm,
    Inch,
}

/// Arm, as `armkins` knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ArmModel {
    Rs03n,
    Rx90,
}

impl ArmModel {
    /// Returns the name that `armkins` takes.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Rs03n => "rs03n",
            Self::Rx90 => "rx90",
        }
    }
}

/// A machine as its builder describes it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Answers {
    /// Name of the machine, of its folder and of its files.
    pub(super) name: Spanned<String>,
    pub(super) kind: Motors,
    pub(super) driver: Driver,
    /// Addresses and directions of parallel ports, as `378 out`.
    #[serde(default = "one_port")]
    pub(super) ports: Spanned<Vec<String>>,
    #[serde(default = "mm")]
    pub(super) units: Units,
    /// The largest jitter that a latency test showed, in nanoseconds.
    pub(super) latency: Spanned<f64>,
    /// Model of the arm.
    pub(super) model: Option<ArmModel>,
    /// Times of the drives for steps.
    #[serde(default = "usual_pulse")]
    pub(super) pulse: Spanned<Pulse>,
    /// Lines of the board that belong to the whole machine.
    #[serde(default)]
    pub(super) pins: MachineLines,
    /// The axes of an arm. Other machines have an axis for each joint.
    #[serde(default)]
    pub(super) axis: Vec<Spanned<Axis>>,
    pub(super) joint: Vec<Spanned<Joint>>,
}

fn one_port() -> Spanned<Vec<String>> {
    Spanned::new(0..0, vec!["378 out".to_owned()])
}

const fn mm() -> Units {
    Units::Mm
}

fn usual_pulse() -> Spanned<Pulse> {
    Spanned::new(0..0, Pulse::default())
}

/// Times that a drive needs for a step, in nanoseconds.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct Pulse {
    pub(super) length: f64,
    pub(super) space: f64,
    /// From the end of a step to a change of the direction.
    pub(super) hold: f64,
    /// From a change of the direction to the next step.
    pub(super) setup: f64,
}

impl Default for Pulse {
    fn default() -> Self {
        Self { length: 5000.0, space: 5000.0, hold: 20_000.0, setup: 20_000.0 }
    }
}

/// Lines that belong to the whole machine.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct MachineLines {
    /// Input that is TRUE while the e-stop chain is closed.
    pub(super) estop: Option<String>,
    /// Output that switches the drives on.
    pub(super) enable: Option<String>,
    /// Output that switches the spindle on.
    pub(super) spindle: Option<String>,
}

/// An axis of an arm: its work volume and its speeds.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Axis {
    pub(super) letter: String,
    pub(super) min: f64,
    pub(super) max: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// A joint with its motor. Lengths are in the units of the machine; those of an arm are degrees.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Joint {
    /// Letter of its axis; not for an arm.
    pub(super) axis: Option<String>,
    /// Full steps of a turn of the motor, or edges of the encoder.
    pub(super) turn: f64,
    #[serde(default = "one")]
    pub(super) microsteps: f64,
    /// Turns of the motor for a turn of the screw.
    #[serde(default = "one")]
    pub(super) gear: f64,
    /// Way of a turn of the screw.
    pub(super) pitch: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// Acceleration that the step generator may use; 1.25 times `acceleration` if it is missing.
    pub(super) drive_acceleration: Option<f64>,
    pub(super) min: f64,
    pub(super) max: f64,
    #[serde(default)]
    pub(super) home: f64,
    /// Velocity with its sign at which homing looks for the switch.
    pub(super) search: Option<f64>,
    // Outputs: steps, or the power of a servo; the direction.
    pub(super) step: Option<String>,
    pub(super) direction: Option<String>,
    /// Input: the switch at both ends, which is the home switch as well.
    pub(super) switch: Option<String>,
    // Inputs of an encoder.
    pub(super) a: Option<String>,
    pub(super) b: Option<String>,
    /// Speed of a servo at full power.
    pub(super) full_speed: Option<f64>,
}

const fn one() -> f64 {
    1.0
}

impl Joint {
    /// Returns the steps, or the edges of the encoder, of a unit of length.
    pub(super) fn scale(&self) -> f64 {
        self.turn * self.microsteps * self.gear / self.pitch
    }
}

/// An answer that cannot be: the byte at which it stands, and what is wrong with it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    pub(super) at: usize,
    pub(super) text: String,
}

/// Reads answers and checks that they make a machine. The error has the line and all that is wrong with it.
pub(super) fn read(text: &str) -> Result<Answers, Vec<Wrong>> {
    let answers: Answers = toml::from_str(text).map_err(|e| {
        let at = e.span().map_or(0, |s| s.start);
        vec![Wrong { at, text: e.message().to_owned() }]
    })?;
    let mut wrong = Vec::new();
    of_the_whole(&answers, &mut wrong);
    for joint in &answers.joint {
        let mut say = |text: String| wrong.push(Wrong { at: joint.span().start, text });
        of_a_joint(&answers, joint.get_ref(), &mut say);
    }
    lines::are_used_once(&answers, &mut wrong);
    if wrong.is_empty() { Ok(answers) } else { Err(wrong) }
}

fn of_the_whole(answers: &Answers, wrong: &mut Vec<Wrong>) {
    let name = answers.name.get_ref();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || !name.chars().all(is_plain) || name.starts_with('-') {
        let text =
            format!("name '{name}': letters, digits, '-' and '_' make the name of a machine");
        wrong.push(Wrong { at: answers.name.span().start, text });
    }
    let latency = *answers.latency.get_ref();
    if !(0.0..=1e6).contains(&latency) {
        let text =
            format!("latency {latency}: nanoseconds from 0 to 1000000, as a latency test shows");
        wrong.push(Wrong { at: answers.latency.span().start, text });
    }
    let ports = answers.ports.get_ref();
    if !(1..=MAX_PORTS).contains(&ports.len()) || !ports.iter().all(|p| is_port(p)) {
        let text = format!("ports: 1 to {MAX_PORTS} of a form as '378 out'");
        wrong.push(Wrong { at: answers.ports.span().start, text });
    }
    let pulse = answers.pulse.get_ref();
    for (key, ns) in [
        ("length", pulse.length),
        ("space", pulse.space),
        ("hold", pulse.hold),
        ("setup", pulse.setup),
    ] {
        if !(0.0..=1e6).contains(&ns) {
            wrong.push(Wrong {
                at: answers.pulse.span().start,
                text: format!("[pulse] {key} {ns}: nanoseconds from 0 to 1000000"),
            });
        }
    }
    let joints = answers.joint.len();
    let whole = match answers.kind {
        Motors::Arm if joints != 6 => Some(format!("an arm has 6 joints, not {joints}")),
        Motors::Arm if answers.model.is_none() => {
            Some("an arm needs its model: model = \"rs03n\"".to_owned())
        }
        Motors::Arm if answers.axis.is_empty() => {
            Some("an arm needs its work volume: [[axis]] for X, Y and Z".to_owned())
        }
        Motors::Steppers | Motors::Servos if !answers.axis.is_empty() => {
            Some("[[axis]] is for arms; here each [[joint]] is an axis".to_owned())
        }
        Motors::Steppers | Motors::Servos if joints == 0 || joints > 9 => {
            Some(format!("a machine has 1 to 9 joints, not {joints}"))
        }
        _ => None,
    };
    wrong.extend(whole.map(|text| Wrong { at: 0, text }));
    let mut letters = BTreeSet::new();
    let joints = answers.joint.iter().filter(|_| answers.kind != Motors::Arm);
    let named = joints.map(|j| (j.span().start, j.get_ref().axis.as_deref().unwrap_or("")));
    let axes = answers.axis.iter().map(|a| (a.span().start, a.get_ref().letter.as_str()));
    for (at, letter) in named.chain(axes) {
        let is_axis = letter.len() == 1 && letter.chars().all(|c| "XYZABCUVW".contains(c));
        if !is_axis {
            let text = format!("axis '{letter}': one of X Y Z A B C U V W");
            wrong.push(Wrong { at, text });
        } else if !letters.insert(letter) {
            wrong.push(Wrong { at, text: format!("axis {letter} is there twice") });
        }
    }
    for axis in &answers.axis {
        let a = axis.get_ref();
        let mut say = |text: String| wrong.push(Wrong { at: axis.span().start, text });
        range(a.min, a.max, &mut say);
        positive(&[("velocity", a.velocity), ("acceleration", a.acceleration)], &mut say);
    }
}

fn of_a_joint(answers: &Answers, joint: &Joint, say: &mut impl FnMut(String)) {
    positive(
        &[
            ("turn", joint.turn),
            ("microsteps", joint.microsteps),
            ("gear", joint.gear),
            ("pitch", joint.pitch),
            ("velocity", joint.velocity),
            ("acceleration", joint.acceleration),
            ("drive-acceleration", joint.drive_acceleration.unwrap_or(joint.acceleration)),
            ("full-speed", joint.full_speed.unwrap_or(1.0)),
        ],
        say,
    );
    range(joint.min, joint.max, say);
    if !(joint.min..=joint.max).contains(&joint.home) {
        say(format!("home {} is outside of {} to {}", joint.home, joint.min, joint.max));
    }
    if joint.drive_acceleration.is_some_and(|a| a < joint.acceleration) {
        say("drive-acceleration is below acceleration: the steps could not follow".to_owned());
    }
    match (&joint.switch, joint.search) {
        (Some(_), None) => {
            say("switch: homing needs search, its velocity with its sign".to_owned());
        }
        (None, Some(_)) => {
            say("search: homing needs switch, the input to look for".to_owned());
        }
        (Some(_), Some(v)) if !v.is_finite() || v == 0.0 || v.abs() > joint.velocity => {
            say(format!("search {v}: not 0, and at most {} to either side", joint.velocity));
        }
        _ => {}
    }
    if answers.kind == Motors::Arm && joint.axis.is_some() {
        say("axis: a joint of an arm is no axis".to_owned());
    }
    let servo = [
        ("a", joint.a.is_some()),
        ("b", joint.b.is_some()),
        ("full-speed", joint.full_speed.is_some()),
    ];
    for (key, is_there) in servo {
        if is_there != (answers.kind == Motors::Servos) {
            say(if is_there {
                format!("{key} is for servos")
            } else {
                format!("a servo needs {key}")
            });
        }
    }
    if joint.step.is_some() != joint.direction.is_some() {
        say("step and direction belong together".to_owned());
    }
    if answers.kind == Motors::Servos && joint.step.is_none() {
        say("a servo needs step, the output of its power, and direction".to_owned());
    }
}

fn positive(values: &[(&str, f64)], say: &mut impl FnMut(String)) {
    for (key, value) in values {
        if !(f64::MIN_POSITIVE..=LARGEST).contains(value) {
            say(format!("{key} {value:?}: a number above 0 and at most {LARGEST}"));
        }
    }
}

fn range(min: f64, max: f64, say: &mut impl FnMut(String)) {
    if !(min < max && -LARGEST <= min && max <= LARGEST) {
        say(format!(
            "min {min:?} and max {max:?}: min is below max, each at most {LARGEST} from 0"
        ));
    }
}

/// Returns whether a text is an address in hexadecimal digits and perhaps a word. Anything else could be more than the
/// argument that it is written into.
fn is_port(text: &str) -> bool {
    let words: Vec<&str> = text.split(' ').filter(|word| !word.is_empty()).collect();
    let is_plain = |word: &&str| word.len() <= 8 && word.bytes().all(|b| b.is_ascii_alphanumeric());
    (1..=2).contains(&words.len()) && words.iter().all(is_plain)
}
