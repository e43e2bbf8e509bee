//! Realtime. The speed of a step generator for the next period, from a position or a velocity that it shall have.

use crate::numbers::within;

/// Limits of a step generator in units; 0 for no limit of the acceleration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub(crate) speed: f64,
    pub(crate) acceleration: f64,
}

/// Position and speed of the pulses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Actual {
    pub(crate) position: f64,
    pub(crate) speed: f64,
}

/// Speed for the next period, and how it came about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Chosen {
    pub(crate) speed: f64,
    /// Speed of the command.
    pub(crate) command: f64,
    /// Speed of the pulses less that of the command.
    pub(crate) error: f64,
    /// Seconds until both speeds are equal, at the highest acceleration.
    pub(crate) to_match: f64,
    /// Distance of the pulses from the command at that time.
    pub(crate) at_match: f64,
}

/// Returns the speed that brings the pulses to the command: it matches the command's speed, and accelerates or brakes
/// depending on the positions that either would lead to.
///
/// `command` is the position of this period and of the period before.
pub(crate) fn position(actual: Actual, command: [f64; 2], bounds: Bounds, period: f64) -> Chosen {
    let [now, before] = command;
    let wanted = (now - before) / period;
    let error = actual.speed - wanted;
    let bounded = bounds.acceleration > 0.0;
    // Without a limit the speeds are equal after one period.
    let towards = match (bounded, error > 0.0) {
        (true, true) => -bounds.acceleration,
        (true, false) => bounds.acceleration,
        (false, _) => -error / period,
    };
    let to_match = if towards == 0.0 { 0.0 } else { -error / towards };
    // Both run on for this time: the pulses by their mean speed, the command by its own. The place of the pulses is that of
    // the period before.
    let mean = 0.5 * (actual.speed + wanted);
    let at_match = actual.position + mean * (to_match + period) - (now + wanted * to_match);
    let speed = if to_match < period {
        let wish = wanted - 0.5 * at_match / period;
        let most = bounds.acceleration * period;
        if bounded { within(wish, actual.speed - most, actual.speed + most) } else { wish }
    } else {
        // What the other direction of acceleration would change until both speeds are equal.
        let other = -2.0 * towards * period * to_match;
        let turns = (at_match + 2.0 * other).abs() < at_match.abs();
        actual.speed + if turns { -towards } else { towards } * period
    };
    Chosen {
        speed: within(speed, -bounds.speed, bounds.speed),
        command: wanted,
        error,
        to_match,
        at_match,
    }
}

/// Returns the speed that brings the pulses to the speed of a command.
pub(crate) fn velocity(actual: f64, command: f64, bounds: Bounds, period: f64) -> f64 {
    let most = bounds.acceleration * period;
    let wish = if bounds.acceleration > 0.0 {
        within(command, actual - most, actual + most)
    } else {
        command
    };
    within(wish, -bounds.speed, bounds.speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.001;

    /// Moves to 10 from rest: the acceleration and speed are held in every period, the command is never passed by more than
    /// the way of one period at the acceleration, and the pulses rest there in time.
    #[test]
    fn a_step_of_the_command_is_followed_within_the_bounds() {
        for (speed, acceleration, distance) in
            [(100.0, 1000.0, 10.0), (5.0, 1000.0, 10.0), (100.0, 50.0, -0.5), (1e6, 2e5, 300.0)]
        {
            let bounds = Bounds { speed, acceleration };
            let mut at = Actual { position: 0.0, speed: 0.0 };
            let mut command = [distance, 0.0];
            // The command jumps: its own speed is seen for one period.
            let mut periods = 0;
            let goal: f64 = distance;
            while periods < 20_000 {
                let chosen = position(at, command, bounds, PERIOD);
                let change = (chosen.speed - at.speed).abs() / PERIOD;
                assert!(change <= acceleration * 1.000_001, "{change} at {periods}");
                assert!(chosen.speed.abs() <= speed * 1.000_001);
                // The pulses have this speed in the whole next period.
                at = Actual { position: at.position + chosen.speed * PERIOD, speed: chosen.speed };
                let beyond = (at.position - goal) * goal.signum();
                assert!(beyond <= 8.0 * acceleration * PERIOD * PERIOD, "{beyond} at {periods}");
                command = [distance, distance];
                periods += 1;
                if (at.position - goal).abs() < 1e-6 && at.speed.abs() < 1e-3 {
                    break;
                }
            }
            let fastest = 2.0 * libm::sqrt(goal.abs() / acceleration);
            let cruise = goal.abs() / speed + speed / acceleration;
            let ideal = if fastest * acceleration / 2.0 < speed { fastest } else { cruise };
            let took = f64::from(periods) * PERIOD;
            assert!(took < ideal * 1.25 + 0.05, "{took} s, {ideal} s at best");
        }
    }

    /// A command at constant speed is followed at that speed, within a period's way.
    #[test]
    fn a_moving_command_is_followed_at_its_speed() {
        let bounds = Bounds { speed: 1000.0, acceleration: 2000.0 };
        let mut at = Actual { position: 0.0, speed: 0.0 };
        for n in 0..5000_i32 {
            let [now, before] = [f64::from(n) * 0.05, f64::from(n - 1) * 0.05];
            let chosen = position(at, [now, before], bounds, PERIOD);
            at = Actual { position: at.position + chosen.speed * PERIOD, speed: chosen.speed };
            if n > 2000 {
                assert!((at.speed - 50.0).abs() < 0.05, "{} at {n}", at.speed);
                assert!((at.position - now).abs() < 0.11, "{} at {n}", at.position - now);
            }
        }
    }

    #[test]
    fn without_a_limit_the_speed_is_the_commands() {
        let free = Bounds { speed: 1000.0, acceleration: 0.0 };
        // The speeds are made equal first, then the places.
        for (from, at, speed) in [(0.0, 1.0, 62.5), (62.5, 1.0, 62.5), (62.5, 0.9375, 93.75)] {
            let actual = Actual { position: at, speed: from };
            let chosen = position(actual, [1.0625, 1.0], free, PERIOD);
            assert!((chosen.speed - speed).abs() < 1e-9, "{chosen:?}");
        }
        assert_eq!(velocity(0.0, -20.0, free, PERIOD).to_bits(), (-20.0_f64).to_bits());
        assert_eq!(velocity(0.0, -2000.0, free, PERIOD).to_bits(), (-1000.0_f64).to_bits());
    }

    #[test]
    fn velocity_changes_within_the_acceleration() {
        let bounds = Bounds { speed: 10.0, acceleration: 100.0 };
        let mut speed = 0.0;
        for n in 1..200_i32 {
            speed = velocity(speed, 20.0, bounds, PERIOD);
            let ideal = (f64::from(n) * 0.1).min(10.0);
            assert!((speed - ideal).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_no_number_stands() {
        let bounds = Bounds { speed: 10.0, acceleration: 100.0 };
        let at = Actual { position: 0.0, speed: 1.0 };
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let chosen = position(at, [bad, 0.0], bounds, PERIOD);
            assert!(chosen.speed.abs() <= 10.0, "{chosen:?}");
            assert!(velocity(1.0, bad, bounds, PERIOD).abs() <= 10.0);
            let unbounded = Bounds { acceleration: bad, ..bounds };
            assert!(position(at, [1.0, 0.0], unbounded, PERIOD).speed.abs() <= 10.0);
        }
    }
}
