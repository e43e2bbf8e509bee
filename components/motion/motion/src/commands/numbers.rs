//! The control side: arguments that are numbers, with their ranges.

use crate::commands::call::Call;
use hal_component::Error;

/// Returns an argument that is a finite number.
pub(super) fn number(call: &Call<'_>, name: &str) -> Result<Option<f64>, Error> {
    match call.float(name) {
        Some(v) if !v.is_finite() => {
            Err(Error::new(format!("{name} is {v}, must be a finite number")))
        }
        given => Ok(given),
    }
}

/// Returns an argument above 0.
pub(super) fn above(call: &Call<'_>, name: &str) -> Result<Option<f64>, Error> {
    match number(call, name)? {
        Some(v) if v <= 0.0 => Err(Error::new(format!("{name} is {v}, must be above 0"))),
        given => Ok(given),
    }
}

/// Returns an argument of 0 or more.
pub(super) fn factor(call: &Call<'_>, name: &str) -> Result<Option<f64>, Error> {
    match number(call, name)? {
        Some(v) if v < 0.0 => Err(Error::new(format!("{name} is {v}, must be 0 or more"))),
        given => Ok(given),
    }
}

/// Returns a factor from 0 to 1.
pub(super) fn share(call: &Call<'_>, name: &str) -> Result<Option<f64>, Error> {
    match number(call, name)? {
        Some(v) if !(0.0..=1.0).contains(&v) => {
            Err(Error::new(format!("{name} is {v}, must be 0 to 1")))
        }
        given => Ok(given),
    }
}
