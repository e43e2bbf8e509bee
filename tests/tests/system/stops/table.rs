//! The page with all cells: `tests/stops/table.md`.

use super::{
    cell::Outcome,
    data::{Control, Motion},
    judge::Measured,
};
use std::{collections::BTreeMap, fmt::Write as _};

/// Outcomes by machine, control and kind of motion.
#[derive(Default)]
pub(super) struct Table {
    cells: BTreeMap<(String, usize, Motion), Outcome>,
    units: BTreeMap<String, String>,
}

impl Table {
    pub(super) fn add(
        &mut self,
        machine: (&str, &str),
        control: usize,
        motion: Motion,
        outcome: Outcome,
    ) {
        let (name, unit) = machine;
        self.units.insert(name.to_owned(), unit.to_owned());
        self.cells.insert((name.to_owned(), control, motion), outcome);
    }

    /// Returns the number of cells: good ones, those in which the motion goes on, those that cannot be, and bad ones.
    pub(super) fn counts(&self) -> [usize; 4] {
        let mut counts = [0; 4];
        for outcome in self.cells.values() {
            counts[match outcome {
                Outcome::Good(_) => 0,
                Outcome::GoesOn => 1,
                Outcome::Cannot(_) => 2,
                Outcome::Bad(_) => 3,
            }] += 1;
        }
        counts
    }

    /// Returns a line for each cell that is not as its rule says.
    pub(super) fn bad(&self, controls: &[Control]) -> Vec<String> {
        let bad = |((machine, control, motion), outcome): (&(String, usize, Motion), &Outcome)| {
            let Outcome::Bad(why) = outcome else { return None };
            Some(format!("{machine}, {}, {}: {why}", controls[*control].name, motion.name()))
        };
        self.cells.iter().filter_map(bad).collect()
    }

    /// Returns the page.
    pub(super) fn page(&self, controls: &[Control]) -> String {
        let [good, on, cannot, bad] = self.counts();
        let mut text = format!(
            "# Stops\n\n\
             Written by `UPDATE_EXPECT=1 cargo test -p hal-tests --test system stops::the_whole -- --ignored`, from the machines of\n\
             `configs/` on the virtual clock. [`rules.toml`](rules.toml) has the rules, [`machines.toml`](machines.toml) the machines.\n\n\
             {} cells: {good} stops, {on} in which the control is no stop of that motion, {cannot} that cannot be, {bad} that are not as\n\
             their rules say. A cell has the cycles of the servo thread from the stop to its effect (motion is disabled, or braking\n\
             begins) and to rest, and the way to rest.\n",
            good + on + cannot + bad
        );
        let mut notes: Vec<&str> = Vec::new();
        for (machine, unit) in &self.units {
            writeln!(text, "\n## {machine}\n\n| control | jog | line | program | homing |\n|---|---|---|---|---|").unwrap();
            for (n, control) in controls.iter().enumerate() {
                write!(text, "| {} |", control.name).unwrap();
                for motion in Motion::ALL {
                    let outcome = self.cells.get(&(machine.clone(), n, motion));
                    let shown = match outcome {
                        None => String::new(),
                        Some(Outcome::Good(m)) => measured(m, unit),
                        Some(Outcome::GoesOn) => "goes on".to_owned(),
                        Some(Outcome::Cannot(why)) => {
                            let known = notes.iter().position(|n| n == why);
                            let n = known.unwrap_or_else(|| {
                                notes.push(why);
                                notes.len() - 1
                            });
                            format!("– ({})", n + 1)
                        }
                        Some(Outcome::Bad(why)) => format!("**{why}**"),
                    };
                    write!(text, " {shown} |").unwrap();
                }
                text.push('\n');
            }
        }
        if !notes.is_empty() {
            text.push_str("\n## Cells that cannot be\n\n");
        }
        for (n, note) in notes.iter().enumerate() {
            writeln!(text, "{}. {note}", n + 1).unwrap();
        }
        text
    }
}

fn measured(m: &Measured, unit: &str) -> String {
    if m.rest <= m.effect {
        format!("{}, {:.3} {unit}", m.effect, m.way)
    } else {
        format!("{}, {}, {:.3} {unit}", m.effect, m.rest, m.way)
    }
}
