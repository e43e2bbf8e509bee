//! The search for the velocity and acceleration that an axis bears, as done on a machine: runs back and forth, harder
//! each time, until the axis does not return to its mark.

use std::fmt::Write as _;

/// Share of what was borne that a machine uses: ten per cent less.
const SHARE: f64 = 0.9;
/// Largest number of trials of one search.
const MAX_TRIALS: u32 = 1000;

/// A run back and forth. Units are those of the machine, and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trial {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Settings of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Settings {
    /// Distance from the start to each end of a run.
    pub(super) amplitude: f64,
    /// Increments of the velocity and of the acceleration.
    pub(super) velocity_step: f64,
    pub(super) acceleration_step: f64,
    /// Acceleration while the velocity is searched.
    pub(super) gentle: f64,
    /// Velocity beyond which the computer makes no steps.
    pub(super) fastest: f64,
}

/// End of a search for one of the two.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Bound {
    /// Highest value without a lost step; 0 if there is none.
    pub(super) held: f64,
    /// First value that lost steps, unless the search ended before.
    pub(super) lost: Option<f64>,
}

/// Values that an axis bears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Borne {
    pub(super) velocity: Bound,
    pub(super) acceleration: Bound,
}

/// Searches the velocity at a gentle acceleration, then the acceleration at that velocity. `returns` runs a trial, and
/// tells whether the axis stands on its mark again.
pub(super) fn search(
    settings: &Settings,
    returns: &mut dyn FnMut(Trial) -> Result<bool, String>,
) -> Result<Borne, String> {
    let Settings { amplitude, gentle, fastest, .. } = *settings;
    // Half of the way for speeding up, half for braking.
    let reached = (2.0 * amplitude * gentle).sqrt();
    let most = fastest.min(reached);
    let why = if reached < fastest {
        "the way is too short for more: a longer --amplitude reaches it"
    } else {
        "the base period permits no more steps a second"
    };
    let velocity = bound(settings.velocity_step, most, &mut |velocity| {
        returns(Trial { velocity, acceleration: gentle })
    })?;
    if velocity.held == 0.0 {
        let step = settings.velocity_step;
        return Err(format!(
            "no velocity is borne: {step} is too fast already, or above {most:.3}, and {why}; a smaller --velocity-step"
        ));
    }
    let acceleration = bound(settings.acceleration_step, f64::INFINITY, &mut |acceleration| {
        returns(Trial { velocity: velocity.held, acceleration })
    })?;
    if acceleration.held == 0.0 {
        let step = settings.acceleration_step;
        return Err(format!(
            "no acceleration is borne: {step} is too much; a smaller --acceleration-step"
        ));
    }
    Ok(Borne { velocity, acceleration })
}

/// Raises a value until steps are lost, or up to the most that can be tried.
fn bound(
    step: f64,
    most: f64,
    holds: &mut dyn FnMut(f64) -> Result<bool, String>,
) -> Result<Bound, String> {
    let mut held = 0.0;
    for n in 1..=MAX_TRIALS {
        let value = step * f64::from(n);
        if most < value {
            return Ok(Bound { held, lost: None });
        }
        if !holds(value)? {
            return Ok(Bound { held, lost: Some(value) });
        }
        held = value;
    }
    Err(format!("{MAX_TRIALS} trials have lost no step: a larger increment"))
}

/// Tells what an axis bears, and what that means for the files of the machine.
pub(super) fn told(axis: &str, unit: &str, joint: usize, borne: &Borne) -> String {
    let mut text = format!("axis {axis}\n");
    let both = [
        ("velocity", format!("{unit}/s"), borne.velocity),
        ("acceleration", format!("{unit}/s^2"), borne.acceleration),
    ];
    for (name, unit, bound) in both {
        let end = match bound.lost {
            Some(lost) => format!("{lost} lost steps"),
            None => "more was not tried".to_owned(),
        };
        let _: std::fmt::Result = writeln!(text, "  {name}: {} {unit} held, {end}", bound.held);
    }
    let (velocity, acceleration) = (borne.velocity.held * SHARE, borne.acceleration.held * SHARE);
    let drive = borne.acceleration.held;
    let _: std::fmt::Result = write!(
        text,
        "for the answers of halsetup, ten per cent less:\n\
         velocity = {velocity:.6}\nacceleration = {acceleration:.6}\ndrive-acceleration = {drive:.6}\n\
         for the INI file:\n\
         [JOINT_{joint}]\nMAX_VELOCITY = {velocity:.6}\nMAX_ACCELERATION = {acceleration:.6}\n\
         STEPGEN_MAXACCEL = {drive:.6}\n"
    );
    text
}

#[cfg(test)]
mod tests {
    use super::{Borne, Bound, Settings, Trial, search};

    const X: Settings = Settings {
        amplitude: 95.0,
        velocity_step: 10.0,
        acceleration_step: 100.0,
        gentle: 675.0,
        fastest: 2500.0,
    };

    /// An axis that loses steps from these values on.
    fn axis(velocity: f64, acceleration: f64) -> impl FnMut(Trial) -> Result<bool, String> {
        move |t| Ok(t.velocity < velocity && t.acceleration < acceleration)
    }

    #[test]
    fn the_figures_are_those_of_the_document() {
        let got = search(&X, &mut axis(100.0, 1600.0)).unwrap();
        let want = Borne {
            velocity: Bound { held: 90.0, lost: Some(100.0) },
            acceleration: Bound { held: 1500.0, lost: Some(1600.0) },
        };
        assert_eq!(got, want);
        let z = Settings {
            amplitude: 45.0,
            velocity_step: 3.0,
            acceleration_step: 5.0,
            gentle: 17.5,
            ..X
        };
        let got = search(&z, &mut axis(15.0, 45.0)).unwrap();
        assert_eq!((got.velocity.held, got.acceleration.held), (12.0, 40.0));
    }

    #[test]
    fn another_increment_ends_below_the_stall_by_less_than_itself() {
        for (step, more) in [(7.0, 130.0), (3.3, 41.0), (0.9, 55.5)] {
            let settings = Settings { velocity_step: step, acceleration_step: more, ..X };
            let got = search(&settings, &mut axis(100.0, 1600.0)).unwrap();
            let (v, a) = (got.velocity.held, got.acceleration.held);
            assert!(100.0 - step <= v && v < 100.0, "{step}: {v}");
            assert!(1600.0 - more <= a && a < 1600.0, "{more}: {a}");
        }
    }

    #[test]
    fn an_axis_that_never_stalls_ends_where_no_more_can_be_tried() {
        let got = search(&X, &mut axis(1e9, 1600.0)).unwrap();
        // 190 mm suffice for 358 mm/s at 675 mm/s^2.
        assert_eq!(got.velocity, Bound { held: 350.0, lost: None });
        let slow = Settings { fastest: 55.0, ..X };
        assert_eq!(search(&slow, &mut axis(1e9, 1600.0)).unwrap().velocity.held, 50.0);
        assert!(search(&X, &mut axis(1e9, 1e9)).unwrap_err().contains("1000 trials"));
    }

    #[test]
    fn an_axis_that_bears_nothing_is_told() {
        assert!(search(&X, &mut axis(5.0, 1e9)).unwrap_err().contains("--velocity-step"));
        assert!(search(&X, &mut axis(1e9, 700.0)).is_ok_and(|b| b.acceleration.held == 600.0));
        let hard = Settings { acceleration_step: 5000.0, ..X };
        assert!(search(&hard, &mut axis(1e9, 1600.0)).unwrap_err().contains("--acceleration-step"));
        let refusal = search(&X, &mut |_| Err("the e-stop is open".to_owned()));
        assert_eq!(refusal, Err("the e-stop is open".to_owned()));
    }
}
