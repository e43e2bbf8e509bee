//! `ferrule commission`: the first power-on of a machine, step by step, at a tenth of its speed and acceleration.
//!
//! No step begins before the one in front of it has passed. Every movement is an ordinary jog or homing within the limits of
//! an INI file of its own, whose speeds are a tenth; the e-stop ends a step at any moment, and nothing goes on by itself.

mod entries;
mod inputs;
mod machine;
mod motion;
mod person;
mod results;
mod spindle;
mod wires;

use crate::{failure::Failure, options::Commission};
use entries::{Change, Slow};
use hal_ini::Ini;
use machine::{Cause, SlowMachine};
use person::Person;
use results::Results;
use std::process::ExitCode;

/// Most repetitions of a step after a change of an entry.
const REPEATS: usize = 3;

/// End of a step that has not passed.
#[derive(Debug)]
pub(crate) enum Stopped {
    /// A fault, what mends it, and the entries that would.
    Fault { what: String, mend: String, change: Option<Box<Change>> },
    /// The machine went off.
    Off(Cause),
    /// The step was ended by the e-stop, by its time, or by a refusal.
    Aborted(String),
    /// The person wants no more, or the input has ended.
    Ended,
    /// The program cannot go on.
    Failed(Failure),
}

impl From<Failure> for Stopped {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

/// Returns a fault that no entry mends.
fn fault(what: impl Into<String>, mend: impl Into<String>) -> Stopped {
    Stopped::Fault { what: what.into(), mend: mend.into(), change: None }
}

/// A step: its name, what it is for, and how it is done. It returns what it has found to be good.
struct CommissionStep {
    name: &'static str,
    about: &'static str,
    run: fn(&mut SlowMachine, &mut Person) -> Result<String, Stopped>,
}

/// The steps, in their order.
const STEPS: &[CommissionStep] = &[
    CommissionStep {
        name: "estop",
        about: "the e-stop is pressed by hand, and seen",
        run: inputs::estop,
    },
    CommissionStep {
        name: "switches",
        about: "each limit and home switch, by hand",
        run: inputs::switches,
    },
    CommissionStep {
        name: "enable",
        about: "the drives are switched on and off",
        run: motion::enable,
    },
    CommissionStep {
        name: "direction",
        about: "each motor moves half a unit",
        run: motion::direction,
    },
    CommissionStep { name: "scale", about: "a way is measured", run: motion::scale },
    CommissionStep {
        name: "following",
        about: "each motor follows its command",
        run: motion::following,
    },
    CommissionStep { name: "homing", about: "each joint homes twice", run: motion::homing },
    CommissionStep { name: "spindle", about: "the spindle turns and stops", run: spindle::spindle },
];

/// Commissions a machine. The status is 0 when each step has passed.
pub(crate) fn commission(given: &Commission) -> Result<ExitCode, Failure> {
    if !given.machine.is_file() {
        return Err(Failure::NoMachine { path: given.machine.clone() });
    }
    let mut results = Results::read(&given.machine, given.again)?;
    let mut person = Person::new()?;
    hal_output::print(&format!(
        "Commissioning {}: keep a hand on the e-stop. 'stop' ends it at each question.\n\
         The machine is started with a copy of its INI file in which each speed and acceleration of joints, axes and\n\
         homing is a tenth, and little following error is permitted. The results are in {}.\n",
        given.machine.display(),
        results.path().display()
    ))?;
    let mut machine = None::<SlowMachine>;
    for step in STEPS {
        if let Some(before) = results.passed(step.name) {
            hal_output::print(&format!("{}: passed {before}\n", step.name))?;
            continue;
        }
        let mut repeats = 0;
        loop {
            let mut running = match machine.take() {
                Some(machine) => machine,
                None => SlowMachine::start(given, &slow(given)?, person.ending())?,
            };
            hal_output::print(&format!("\n{}: {}\n", step.name, step.about))?;
            let ended = (step.run)(&mut running, &mut person);
            let ended = ended.map_err(|stopped| running.explained(stopped));
            running.rest();
            match ended {
                Ok(good) => {
                    hal_output::print(&format!("{}: passed: {good}\n", step.name))?;
                    results.add(step.name, "passed", &good)?;
                    machine = Some(running);
                    break;
                }
                Err(Stopped::Aborted(why)) => {
                    results.add(step.name, "aborted", &why)?;
                    hal_output::print(&format!("{}: aborted: {why}\n", step.name))?;
                    machine = Some(running);
                    if !person.yes(&format!("{}: begin this step again? [y/n] ", step.name))? {
                        return end(machine);
                    }
                }
                Err(Stopped::Fault { what, mend, change }) => {
                    results.add(step.name, "fault", &what)?;
                    hal_output::print(&format!("{}: FAULT: {what}\n  do: {mend}\n", step.name))?;
                    running.stop()?;
                    repeats += 1;
                    let Some(change) = change.filter(|_| repeats <= REPEATS) else {
                        return Ok(ExitCode::FAILURE);
                    };
                    hal_output::print(&change.difference()?)?;
                    let question = format!("write this to {}? [y/n] ", change.path().display());
                    if !person.yes(&question)? {
                        return Ok(ExitCode::FAILURE);
                    }
                    change.write()?;
                    results.add(step.name, "changed", &change.summary())?;
                }
                Err(Stopped::Ended | Stopped::Off(_)) => {
                    hal_output::print("\nended: the same command goes on with this step\n")?;
                    return end(Some(running));
                }
                Err(Stopped::Failed(failure)) => {
                    // The failure is the one to report.
                    drop(running.stop());
                    return Err(failure);
                }
            }
        }
    }
    hal_output::print("\nEach step has passed: the machine may be run at its own speeds.\n")?;
    end(machine).map(|_| ExitCode::SUCCESS)
}

/// Ends the machine; the commissioning is not complete.
fn end(machine: Option<SlowMachine>) -> Result<ExitCode, Failure> {
    if let Some(machine) = machine {
        machine.stop()?;
    }
    Ok(ExitCode::FAILURE)
}

/// Reads the machine's entries, and returns those of the slow machine.
fn slow(given: &Commission) -> Result<Slow, Failure> {
    let ini = Ini::read(&given.machine)?;
    Slow::of(&given.machine, &ini)
}
