//! Answers to stops, in words.

use crate::{
    engine::{Ending, Stopped},
    error::{Code, Error},
    server::Panel,
};
use hal_protocol::Stop;

/// E-stop of the machine.
const ESTOP: &str = "iocontrol.estop";
/// The command that is the e-stop of a machine without an interlock.
const OFF: &str = "motion.disable";

/// A stop that the machine has obeyed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Told {
    /// Sentences about what has been done.
    pub(crate) lines: Vec<String>,
    /// Tickets of the commands whose ends are still to come.
    pub(crate) tickets: Vec<u64>,
}

impl Panel {
    /// Stops the machine or a robot, and returns what was done.
    ///
    /// # Errors
    /// A part of it was refused: the text has both what was done and what was not.
    pub(crate) async fn stop(&self, ending: Ending) -> Result<Told, Error> {
        self.epochs.begin_stop();
        let stopped = self.engine.stop(ending).await;
        self.epochs.end_stop();
        let interlock = {
            let machine = self.machine.borrow();
            machine.motion.as_ref().and_then(|motion| motion.get("interlock")?.as_bool())
        };
        told(ending, &stopped?, interlock)
    }
}

/// Returns what a stop has done. `interlock` says whether motion reads the e-stop of iocontrol, where that is known.
///
/// # Errors
/// A part of it was refused: the text has both what was done and what was not.
fn told(ending: Ending, stopped: &Stopped, interlock: Option<bool>) -> Result<Told, Error> {
    let mut told = Told::default();
    let mut refused = Vec::new();
    for (name, end) in &stopped.0 {
        match end {
            Ok(answer) => {
                let words = words(ending, name, interlock);
                told.lines.extend(words.map(str::to_owned));
                told.tickets.extend(answer.ticket);
            }
            Err(why) => refused.push(format!("{name} was refused: {}", why.text)),
        }
    }
    if stopped.0.is_empty() {
        return Err(Error::new(Code::Refused, "nothing of this machine can be stopped so"));
    }
    if refused.is_empty() {
        return Ok(told);
    }
    let done = told.lines.into_iter();
    let text: Vec<_> = refused.into_iter().chain(done).collect();
    Err(Error::new(Code::Refused, text.join("; ")))
}

/// Returns what a command that a stop has sent has done.
fn words(ending: Ending, name: &str, interlock: Option<bool>) -> Option<&'static str> {
    let Ending::Machine(stop) = ending else {
        return Some(match name {
            "robot.pause" => "the robot rests behind the move under way",
            _ => "the robot stops",
        });
    };
    Some(match (stop, name) {
        (_, ESTOP) => "the machine is in e-stop",
        // The interlock has switched it off already.
        (Stop::Estop, OFF) if interlock == Some(true) => return None,
        (Stop::Estop, OFF) => "no e-stop interlock: motion was switched off",
        (Stop::Off, OFF) => "motion was switched off",
        (_, "motion.abort") => "motion brakes, and the rest of its path is gone",
        (_, "motion.pause") => "motion brakes, and its path rests until it is resumed",
        (_, "iocontrol.abort") => "coolant is off",
        (Stop::Pause, "robot.pause") => "the robot rests behind the move under way",
        (_, "robot.stop") => "the robot stops",
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    //! Words of stops.

    use super::{Code, Ending, Error, Stop, Stopped, told};
    use hal_protocol::Answer;

    fn check(stop: Stop, ends: &[(&str, bool)], interlock: Option<bool>, expected: &str) {
        let end = |is_ok: bool| {
            let answer = Answer { lines: Vec::new(), ticket: Some(7), awaited: false };
            if is_ok { Ok(answer) } else { Err(Error::new(Code::Refused, "it is full")) }
        };
        let ends = ends.iter().map(|(name, is_ok)| ((*name).to_owned(), end(*is_ok)));
        let said = match told(Ending::Machine(stop), &Stopped(ends.collect()), interlock) {
            Ok(told) => told.lines.join("; "),
            Err(why) => format!("refused: {}", why.text),
        };
        assert_eq!(said, expected, "{stop:?}");
    }

    #[test]
    fn a_stop_says_what_was_done_and_what_was_not() {
        let (io, off) = (("iocontrol.estop", true), ("motion.disable", true));
        check(Stop::Estop, &[io, off], Some(true), "the machine is in e-stop");
        let bare = "no e-stop interlock: motion was switched off";
        check(Stop::Estop, &[off], Some(false), bare);
        check(Stop::Estop, &[io, off], Some(false), &format!("the machine is in e-stop; {bare}"));
        check(
            Stop::Estop,
            &[("iocontrol.estop", false), off],
            Some(false),
            "refused: iocontrol.estop was refused: it is full; no e-stop interlock: motion was switched off",
        );
        check(Stop::Off, &[off], None, "motion was switched off");
        check(
            Stop::Abort,
            &[("motion.abort", true), ("iocontrol.abort", true)],
            None,
            "motion brakes, and the rest of its path is gone; coolant is off",
        );
        check(Stop::Pause, &[], None, "refused: nothing of this machine can be stopped so");
    }
}
