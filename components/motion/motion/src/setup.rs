//! Arguments of `loadrt motmod`.

use hal_component::{Arg, Builder, Error, abi::ArgSpec};

/// Maximum number of joints.
pub(crate) const MAX_JOINTS: usize = 16;
pub(crate) const MAX_SPINDLES: usize = 8;
const MAX_LIST: usize = 64;

/// The arguments, with their documentation.
pub(crate) const ARGS: &[&ArgSpec] = &[
    &Arg::int("key", "Accepted for scripts that give it; there is no shared memory.").or("100"),
    &Arg::int(
        "base_period_nsec",
        "Period of base-thread in nanoseconds; 0 or less: there is no base-thread.",
    )
    .or("0"),
    &Arg::bit("base_thread_fp", "With 0, functions that compute with floating-point numbers cannot be added to base-thread.")
        .or("0"),
    &Arg::int(
        "servo_period_nsec",
        "Period of servo-thread in nanoseconds, not shorter than that of base-thread; rounded to \
         a multiple of it.",
    )
    .or("1000000"),
    &Arg::int(
        "traj_period_nsec",
        "Accepted for scripts that give it: a path is followed in every servo cycle.",
    )
    .or("0"),
    &Arg::int("num_joints", "Number of joints, 1 to 16.").or("16"),
    &Arg::int(
        "num_extrajoints",
        "How many of the joints, the last ones, the kinematics do not move; they follow \
         posthome-cmd once homed. Needs kinstype=b.",
    )
    .or("0"),
    &Arg::int("num_spindles", "Number of spindles, 0 to 8.").or("1"),
    &Arg::int("num_dio", "Number of digital inputs and of digital outputs, 1 to 64; 0 means 4.")
        .or("0"),
    &Arg::int("num_aio", "Number of analog inputs and of analog outputs, 1 to 64; 0 means 4.")
        .or("0"),
    &Arg::texts("names_din", "Names for motion.din-NAME instead of numbered digital inputs."),
    &Arg::texts("names_dout", "Names for motion.dout-NAME instead of numbered digital outputs."),
    &Arg::texts("names_ain", "Names for motion.ain-NAME instead of numbered analog inputs."),
    &Arg::texts("names_aout", "Names for motion.aout-NAME instead of numbered analog outputs."),
    &Arg::int("num_misc_error", "Number of motion.misc-error-NN inputs, 0 to 64.").or("0"),
    &Arg::texts("names_misc_errors", "Names for motion.err-NAME instead of numbered inputs."),
    &Arg::text("homemod", "Name of the homing module that must be loaded; a start from an INI file with HOMEMOD gives it."),
    &Arg::int("unlock_joints_mask", "Bit N gives joint N its unlock and is-unlocked pins.").or("0"),
];

/// Positions of all joints.
pub(crate) type Places = [f64; MAX_JOINTS];

/// Numbered pins, or named ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Names {
    /// A number of pins, numbered from 00.
    Count(usize),
    /// A list of names.
    Given(Vec<String>),
}

impl Names {
    pub(crate) const fn len(&self) -> usize {
        match self {
            Self::Count(n) => *n,
            Self::Given(names) => names.len(),
        }
    }
}

/// The checked arguments.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) base_period_ns: i64,
    pub(crate) base_fp: bool,
    pub(crate) servo_period_ns: i64,
    pub(crate) joints: usize,
    pub(crate) extra_joints: usize,
    pub(crate) spindles: usize,
    pub(crate) digital_in: Names,
    pub(crate) digital_out: Names,
    pub(crate) analog_in: Names,
    pub(crate) analog_out: Names,
    pub(crate) misc_errors: Names,
    pub(crate) unlock_mask: u32,
}

impl Setup {
    pub(crate) fn read(b: &Builder<'_>) -> Result<Self, Error> {
        let base = b.arg_int("base_period_nsec").unwrap_or(0).max(0);
        let joints = number(b, "num_joints", 1, MAX_JOINTS)?;
        let (digital_in, digital_out) = pair(b, "num_dio", "names_din", "names_dout")?;
        let (analog_in, analog_out) = pair(b, "num_aio", "names_ain", "names_aout")?;
        let errors = number(b, "num_misc_error", 0, MAX_LIST)?;
        let error_names = b.arg_texts("names_misc_errors");
        if errors > 0 && !error_names.is_empty() {
            return Err(Error::new("num_misc_error= and names_misc_errors= exclude each other"));
        }
        let mask = b.arg_int("unlock_joints_mask").unwrap_or(0);
        Ok(Self {
            base_period_ns: base,
            base_fp: b.arg_int("base_thread_fp") == Some(1),
            servo_period_ns: servo_period(b.arg_int("servo_period_nsec").unwrap_or(0), base)?,
            joints,
            extra_joints: number(b, "num_extrajoints", 0, joints)?,
            spindles: number(b, "num_spindles", 0, MAX_SPINDLES)?,
            digital_in,
            digital_out,
            analog_in,
            analog_out,
            misc_errors: named("names_misc_errors", error_names, errors)?,
            unlock_mask: u32::try_from(mask).map_err(|_| {
                Error::new(format!("unlock_joints_mask is {mask}, must be a mask of joints"))
            })?,
        })
    }
}

/// Sets the element `n` of a list, if the list has it.
pub(crate) fn put<T>(list: &mut [T], n: usize, value: T) {
    if let Some(place) = list.get_mut(n) {
        *place = value;
    }
}

/// Returns whether all values are zero, without a branch for each.
pub(crate) fn is_zero<const N: usize>(values: [f64; N]) -> bool {
    // Both zeros have no other bit than the sign.
    values.iter().fold(0, |bits, value| bits | value.to_bits()) << 1 == 0
}

/// Returns the multiple of the base period that is nearest to the servo period.
fn servo_period(servo: i64, base: i64) -> Result<i64, Error> {
    if servo <= 0 || servo < base {
        return Err(Error::new(if base > 0 {
            format!("servo_period_nsec is {servo}, must be at least base_period_nsec, {base}")
        } else {
            format!("servo_period_nsec is {servo}, must be above 0")
        }));
    }
    if base == 0 {
        return Ok(servo);
    }
    let times = servo / base + i64::from(servo % base >= base - base / 2);
    Ok(base.saturating_mul(times))
}

fn number(b: &Builder<'_>, name: &str, least: usize, most: usize) -> Result<usize, Error> {
    let given = b.arg_int(name).unwrap_or(0);
    match usize::try_from(given) {
        Ok(n) if least <= n && n <= most => Ok(n),
        _ => Err(Error::new(format!("{name} is {given}, must be between {least} and {most}"))),
    }
}

fn named(what: &str, names: Vec<String>, count: usize) -> Result<Names, Error> {
    if names.len() > MAX_LIST {
        return Err(Error::new(format!("{what} has {} names, at most {MAX_LIST}", names.len())));
    }
    Ok(if names.is_empty() { Names::Count(count) } else { Names::Given(names) })
}

/// Inputs and outputs: if only one side has names, the other has the same number of numbered pins.
fn pair(
    b: &Builder<'_>,
    count: &str,
    inputs: &str,
    outputs: &str,
) -> Result<(Names, Names), Error> {
    let given = number(b, count, 0, MAX_LIST)?;
    let (ins, outs) = (b.arg_texts(inputs), b.arg_texts(outputs));
    let most = ins.len().max(outs.len());
    if given > 0 && most > 0 {
        return Err(Error::new(format!("{count}= excludes {inputs}= and {outputs}=")));
    }
    let n = match (given, most) {
        (0, 0) => 4,
        (0, n) | (n, _) => n,
    };
    Ok((named(inputs, ins, n)?, named(outputs, outs, n)?))
}
