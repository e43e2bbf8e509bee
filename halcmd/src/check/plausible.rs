//! Entries of one machine or joint that contradict each other, or that no machine can have.

use super::{
    coordinates::is_rotary,
    entries::{Joint, about},
    joints::{place, value},
};
use crate::ini::{Entry, Ini};
use hal_protocol::{Code, Finding};

/// Backlash beyond which an entry is a slip of the point or of the unit, in millimetres or degrees. A worn lead screw
/// has some tenths; a machine with a whole millimetre of play cannot be made good by an entry.
const MOST_BACKLASH: f64 = 1.0;
/// Millimetres in an inch.
const INCH: f64 = 25.4;
/// Travel and speed that together no machine in inches has: five metres, and 76 metres in a minute.
const LONG: f64 = 200.0;
const FAST: f64 = 50.0;
/// Travel and speed that together no machine in millimetres has: it would be as small as a hand, and slower than it.
const SHORT: f64 = 60.0;
const SLOW: f64 = 8.0;

/// Returns the findings about one joint's own entries.
pub(super) fn joint(joint: &Joint<'_>) -> Vec<Finding> {
    [turns(joint), following(joint), limits(joint), latch(joint), backlash(joint)]
        .into_iter()
        .flatten()
        .collect()
}

/// Reports a type that is not that of the axis which the joint moves.
fn turns(joint: &Joint<'_>) -> Option<Finding> {
    let (entry, letter) = (joint.entry("TYPE")?, joint.letter?);
    let right = if is_rotary(letter) { "ANGULAR" } else { "LINEAR" };
    let is = entry.value.trim();
    if is == right || !["LINEAR", "ANGULAR"].contains(&is) {
        return None;
    }
    let whole = format!("[{}]TYPE", joint.section);
    let text = format!("{whole} is {is}, and the joint moves axis {letter}, which is {right}");
    let remedy = format!("TYPE = {right}, or correct the coordinates of the kinematics");
    Some(about(Code::EntriesDisagree, entry, text).remedy(remedy))
}

/// Reports permitted following errors that contradict each other, or that the first fast move exceeds.
fn following(joint: &Joint<'_>) -> Option<Finding> {
    let (entry, error) = (joint.entry("FERROR")?, joint.number("FERROR")?);
    let least = joint.number("MIN_FERROR");
    if let (Some(least), Some(lower)) = (least, joint.entry("MIN_FERROR"))
        && error < least
    {
        let text = format!(
            "[{}]FERROR is {error}, less than MIN_FERROR, which is {least}: FERROR is for the \
             joint's full speed, MIN_FERROR for slow moves",
            joint.section
        );
        return Some(
            about(Code::EntriesDisagree, entry, text)
                .remedy("let FERROR be MIN_FERROR or more, several steps in any case")
                .related(place(lower), "MIN_FERROR is here"),
        );
    }
    // A joint whose command is its feedback has no following error.
    let signal = |name| joint.pin(name)?.signal.as_ref();
    let (command, feedback) = (signal("motor-pos-cmd")?, signal("motor-pos-fb")?);
    let period = joint.ini.all("EMCMOT", "SERVO_PERIOD").next().and_then(value)?;
    let way = joint.number("MAX_VELOCITY")? * period / 1e9;
    if command == feedback || !way.is_finite() || error >= way {
        return None;
    }
    let text = format!(
        "[{}]FERROR is {error}, and the joint moves {way} in one servo period at MAX_VELOCITY: it \
         fails in the first fast move",
        joint.section
    );
    let remedy = format!("let FERROR be more than {way}, by several times");
    Some(about(Code::EntriesDisagree, entry, text).remedy(remedy))
}

/// Reports travel limits without travel between them.
fn limits(joint: &Joint<'_>) -> Option<Finding> {
    let (entry, low) = (joint.entry("MIN_LIMIT")?, joint.number("MIN_LIMIT")?);
    let (upper, high) = (joint.entry("MAX_LIMIT")?, joint.number("MAX_LIMIT")?);
    if low.partial_cmp(&high) != Some(core::cmp::Ordering::Equal) {
        return None;
    }
    let text =
        format!("[{}]MIN_LIMIT and MAX_LIMIT are both {low}: the joint cannot move", joint.section);
    Some(
        about(Code::EntriesDisagree, entry, text)
            .remedy("let MIN_LIMIT be less than MAX_LIMIT, by the joint's travel")
            .related(place(upper), "MAX_LIMIT is here"),
    )
}

/// Reports a search for a home switch that does not end at the switch.
fn latch(joint: &Joint<'_>) -> Option<Finding> {
    let (entry, speed) = (joint.entry("HOME_SEARCH_VEL")?, joint.number("HOME_SEARCH_VEL")?);
    let absolute = joint.number("HOME_ABSOLUTE_ENCODER").is_some_and(|x| x != 0.0);
    let latch = joint.entry("HOME_LATCH_VEL");
    if speed == 0.0 || absolute || latch.is_some_and(|e| value(e) != Some(0.0)) {
        return None;
    }
    let is = if latch.is_some() { "is 0" } else { "is missing" };
    let text = format!(
        "[{}]HOME_SEARCH_VEL is {speed}, and HOME_LATCH_VEL {is}: homing stops with an error at \
         the switch",
        joint.section
    );
    Some(about(Code::EntriesDisagree, latch.unwrap_or(entry), text).remedy(format!(
        "write a slow HOME_LATCH_VEL, such as {}; or HOME_SEARCH_VEL = 0, to home without a switch",
        speed.abs() / 10.0
    )))
}

/// Reports a backlash that no machine has.
fn backlash(joint: &Joint<'_>) -> Option<Finding> {
    let (entry, play) = (joint.entry("BACKLASH")?, joint.number("BACKLASH")?);
    let angular = joint.entry("TYPE").is_some_and(|e| e.value.trim() == "ANGULAR");
    let inches = !angular && joint.ini.is_inch() == Ok(true);
    let most = if inches { MOST_BACKLASH / INCH } else { MOST_BACKLASH };
    if play.is_nan() || play.abs() <= most {
        return None;
    }
    let text = format!(
        "[{}]BACKLASH is {play}: each reversal moves the motor that far at once",
        joint.section
    );
    Some(about(Code::EntriesDisagree, entry, text).remedy(format!(
        "write BACKLASH as measured, in the joint's own unit; it is seldom more than {most:.2}"
    )))
}

/// Reports a sequence of homing that leaves joints out.
pub(super) fn sequence(joints: &[Joint<'_>]) -> Option<Finding> {
    let of =
        |j: &Joint<'_>| Some((j.number("HOME_SEQUENCE")?.abs(), j.entry("HOME_SEQUENCE")?.clone()));
    let mut all: Vec<(f64, Entry)> = joints.iter().filter_map(of).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut last = 0.0;
    for (n, entry) in all {
        if n > last + 1.0 {
            let text = format!(
                "[{}]HOME_SEQUENCE is {n}, and no joint has {}: 'home all' ends before it",
                entry.section,
                last + 1.0
            );
            let remedy = format!("write HOME_SEQUENCE = {}, without a gap", last + 1.0);
            return Some(about(Code::EntriesDisagree, &entry, text).remedy(remedy));
        }
        last = n;
    }
    None
}

/// Returns the longest travel and the highest speed of joints.
pub(crate) fn largest(joints: &[(f64, f64)]) -> (f64, f64) {
    joints.iter().fold((0.0_f64, 0.0_f64), |most, j| (most.0.max(j.0), most.1.max(j.1)))
}

/// Returns whether no machine has linear joints of these travels and speeds in this unit.
pub(crate) fn is_odd(inches: bool, joints: &[(f64, f64)]) -> bool {
    let (travel, speed) = largest(joints);
    if inches {
        joints.iter().any(|j| LONG <= j.0 && j.0 < 1e5 && FAST <= j.1)
    } else {
        0.0 < travel && travel <= SHORT && 0.0 < speed && speed <= SLOW
    }
}

/// Reports a unit of length in which the machine would be impossibly large and fast, or small and slow.
pub(super) fn units(ini: &Ini, joints: &[Joint<'_>]) -> Option<Finding> {
    let entry = ini.all("TRAJ", "LINEAR_UNITS").next()?;
    let inches = ini.is_inch().ok()?;
    let linear = joints.iter().filter(|j| {
        j.entry("TYPE").is_none_or(|e| e.value.trim() == "LINEAR")
            && !j.letter.is_some_and(is_rotary)
    });
    let of = |j: &Joint<'_>| {
        let travel = j.number("MAX_LIMIT")? - j.number("MIN_LIMIT")?;
        Some((travel, j.number("MAX_VELOCITY")?))
    };
    let all: Vec<(f64, f64)> = linear.filter_map(of).collect();
    let (travel, speed) = largest(&all);
    let odd = is_odd(inches, &all);
    let other = if inches { "mm" } else { "inch" };
    if !odd {
        return None;
    }
    let unit = if inches { "inch" } else { "mm" };
    let text = format!(
        "[TRAJ]LINEAR_UNITS is {unit}, and the joints travel up to {travel} {unit} with up to \
         {speed} {unit}/s: their entries look like {other}"
    );
    Some(
        about(Code::EntriesDisagree, entry, text)
            .remedy(format!("LINEAR_UNITS = {other}, or write the joints' entries in {unit}")),
    )
}
