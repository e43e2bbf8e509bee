//! The base period and what follows from it, by the formulas of LinuxCNC's configuration wizard (its manual, chapter
//! "Stepper Configuration Wizard"; `min_base_period` as the printer's document shows it: 26732 ns for a jitter of 11732 ns).

use super::answers::{Answers, Driver, Joint, Motors, Pulse};

/// Shortest base period that a thread is given, in nanoseconds.
const SHORTEST_BASE_NS: f64 = 10_000.0;
/// A step may begin and end in one period if it is at most this long: the port resets it.
const RESET_NS: f64 = 5000.0;

/// Periods and the figures of the step generators.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Timing {
    /// Base period, in nanoseconds.
    pub(super) base: f64,
    /// Shortest base period that the computer's jitter allows, in nanoseconds.
    pub(super) shortest: f64,
    /// True if steps begin and end in one period.
    pub(super) resets: bool,
    /// Periods between two steps.
    pub(super) space: u32,
    /// Time from the end of a step to a change of the direction, and from there to the next step, in nanoseconds.
    pub(super) hold: f64,
    pub(super) setup: f64,
}

/// Returns the shortest base period in which the computer can make the drive's pulses, in nanoseconds.
pub(super) fn shortest(latency: f64, pulse: Pulse, resets: bool) -> f64 {
    if resets {
        (latency + pulse.length + pulse.space + 5000.0).max(4.0 * pulse.length)
    } else {
        latency + pulse.length.max(pulse.space)
    }
}

/// Returns the pulses, or the edges of an encoder, of a joint at its velocity, in hertz.
pub(super) fn rate(joint: &Joint) -> f64 {
    joint.velocity * joint.scale()
}

/// Returns whether steps begin and end in one period.
pub(super) fn resets(answers: &Answers) -> bool {
    answers.kind != Motors::Servos
        && answers.driver == Driver::Parport
        && answers.pulse.length <= RESET_NS
}

/// Returns the shortest base period of the computer and the drives, in nanoseconds.
pub(super) fn least(answers: &Answers) -> f64 {
    shortest(answers.latency, answers.pulse, resets(answers)).max(SHORTEST_BASE_NS)
}

/// Returns the timing of the machine, or the joint that is too fast, with the velocity that it can have.
pub(super) fn timing(answers: &Answers) -> Result<Timing, (usize, f64)> {
    let (latency, pulse) = (answers.latency, answers.pulse);
    let (resets, shortest) = (resets(answers), least(answers));
    // A step needs one period if the port ends it, and two otherwise; an edge of an encoder two, so that none is missed.
    let periods = if resets { 1.0 } else { 2.0 };
    let fastest = answers.joint.iter().map(rate).enumerate();
    let (joint, rate) =
        fastest.fold((0, 0.0), |most, this| if this.1 > most.1 { this } else { most });
    let wanted = 1e9 / (periods * rate);
    if wanted < shortest {
        let possible =
            answers.joint.get(joint).map_or(0.0, |j| 1e9 / (periods * shortest * j.scale()));
        return Err((joint, possible));
    }
    let base = wanted.min(answers.longest).floor();
    // Where steps come in at most half of the periods, each ends before the next begins.
    let space = u32::from(!resets && rate * base > 0.5e9);
    Ok(Timing {
        base,
        shortest,
        resets,
        space,
        hold: pulse.hold + latency,
        setup: pulse.setup + latency,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The printer's document: jitter 11732 ns, "Min Base Period 26,732 ns", "Max step rate 37,408 Hz".
    #[test]
    fn the_shortest_period_is_that_of_the_document() {
        let of_the_port = shortest(11_732.0, Pulse::default(), true);
        assert_eq!((of_the_port, (1e9 / of_the_port).floor()), (26_732.0, 37_408.0));
        assert_eq!(shortest(11_732.0, Pulse::default(), false), 16_732.0);
        // Four steps' length bounds it where the jitter is small.
        assert_eq!(
            shortest(0.0, Pulse { length: 5000.0, space: 1000.0, ..Pulse::default() }, true),
            20_000.0
        );
    }
}
