//! Output of `halgcode check`.

use super::{Check, Clock, Finding};
use crate::{Stdio, Terminal, terminal::print_error};
use hal_gcode::{Error, Interpreter, axis::Axis, program::numbered_line};
use hal_job::world::World;
use std::fmt::Write as _;

/// Largest number of moves that the planner refuses, or that the axes cannot follow, and that are shown.
const MAX_REFUSED: u64 = 10;

impl Check<'_> {
    /// Writes the move that the planner refuses, as motion would. Each is an error; only the first ones are shown.
    pub(super) fn refusal(&mut self, it: &Interpreter, error: &hal_trajectory::Error) {
        self.errors += 1;
        self.refused += 1;
        if self.refused > MAX_REFUSED {
            return;
        }
        let file = it.state.levels.last().map(|l| l.file.clone()).unwrap_or_default();
        let text = error.to_string();
        // "line 7: what is wrong"
        let (line, reason) = text.split_once(": ").unwrap_or(("line 0", &text));
        let line = line.strip_prefix("line ").unwrap_or("0");
        self.text.push_str(&format!("{file}:{line}: error: motion refuses this move: {reason}\n"));
    }

    /// Writes what the axes cannot follow.
    pub(super) fn found(&mut self, file: &str, found: Option<Finding>) {
        if let Some(Finding { line, text }) = found {
            self.errors += 1;
            self.unfollowed += 1;
            if self.unfollowed <= MAX_REFUSED {
                self.text.push_str(&format!("{file}:{line}: error: {text}\n"));
            }
        }
    }

    /// Writes the error of a line, with the line and a caret for a person.
    pub(super) fn error(&mut self, error: &Error, world: &World) {
        let message = error.to_string();
        let place = error.place.to_string();
        let rest =
            message.strip_prefix(&place).and_then(|r| r.strip_prefix(": ")).unwrap_or(&message);
        self.text.push_str(&format!("{place}: error: {rest}\n"));
        if !Stdio.is_person() {
            return;
        }
        use hal_gcode::Environment;
        let Some(text) = world.open(&error.place.file) else { return };
        let longest = world.machine.settings.limits.line_length;
        let line = numbered_line(&text, error.place.line.into(), longest);
        let Some(line) = line else { return };
        let line: String =
            String::from_utf8_lossy(&line).chars().filter(|c| !c.is_control()).take(200).collect();
        self.text.push_str(&format!("    {line}\n"));
        if let Some(column) =
            usize::try_from(error.place.column).ok().and_then(|c| c.checked_sub(1))
        {
            self.text.push_str(&format!("    {}^\n", " ".repeat(column.min(200))));
        }
    }

    /// Writes the limits that moves go beyond; each is an error.
    pub(super) fn limits(&mut self, file: &str) {
        for ((index, side), b) in &self.beyond {
            let Some(axis) = Axis::ALL.get(*index) else { continue };
            let file = if b.file.is_empty() { file } else { &b.file };
            self.text.push_str(&format!(
                "{file}:{}: error: {} ({} moves, this line first)\n",
                b.line,
                self.world.machine.excess((*axis, *side, b.limit), b.farthest),
                b.moves
            ));
            self.errors += 1;
        }
    }

    /// Compares the height at which the program crosses the part with that of a start in the middle, which the task chooses.
    fn clearance(&self) -> String {
        let machine = &self.world.machine;
        let (Some(lowest), Some(ini)) = (self.crossing, &machine.ini) else { return String::new() };
        if !machine.settings.axes.has(Axis::Z) {
            return String::new();
        }
        let given = ini.get("TASK", "SAFE_HEIGHT").and_then(|text| text.trim().parse::<f64>().ok());
        let given = given.map(|height| height * machine.settings.unit.millimetres());
        let top = machine.limits.get(usize::from(Axis::Z.index())).and_then(|(_, high)| *high);
        // The task takes a larger one for none.
        let top = top.filter(|high| *high < 1e6);
        let entry = match (given, top) {
            (Some(height), _) => format!("at Z {height:.3} mm ([TASK]SAFE_HEIGHT)"),
            (None, Some(top)) => format!("at Z {top:.3} mm (the upper end of Z)"),
            (None, None) => "nowhere: it needs [TASK]SAFE_HEIGHT".to_owned(),
        };
        let is_below = given.or(top).is_some_and(|height| height < lowest);
        let below = if is_below { ", below all of them" } else { "" };
        format!(
            "  rapid moves cross at Z {lowest:.3} mm and above, a start in the middle {entry}{below}\n"
        )
    }

    pub(super) fn summary(&mut self, file: &str) {
        let mut out = format!("{file}: {} errors\n", self.errors);
        for (name, extents) in [("moves", self.all), ("cuts", self.cut)] {
            if extents.any {
                out.push_str(&format!("  {name:<6}"));
                for axis in Axis::ALL {
                    let (low, high) = (extents.low[axis], extents.high[axis]);
                    if low != 0.0 || high != 0.0 {
                        let letter = axis.letter().to_ascii_uppercase();
                        let unit = if axis.is_rotary() { "°" } else { " mm" };
                        out.push_str(&format!("  {letter} {low:.3} to {high:.3}{unit}"));
                    }
                }
                out.push('\n');
            }
        }
        for (number, used) in self.tools.iter().filter(|(n, u)| **n != 0 || u.way > 0.0) {
            let tool = self.world.machine.tools.find(*number);
            let k = self.world.machine.settings.unit.millimetres();
            let (diameter, remark) = tool.map_or((0.0, ""), |t| (t.diameter * k, &*t.remark));
            let mut line =
                format!("  tool {number}: from line {}, cuts {:.1} mm", used.line, used.way);
            if diameter != 0.0 {
                line.push_str(&format!(", diameter {diameter:.3} mm"));
            }
            if !remark.is_empty() {
                line.push_str(&format!(", {remark}"));
            }
            out.push_str(&line);
            out.push('\n');
        }
        out.push_str(&self.clearance());
        let seconds = self.minutes * 60.0;
        let added = writeln!(out, "  time at feed {seconds:.1} s, rapid way {:.1} mm", self.rapid);
        added.unwrap_or_else(|e| print_error(&e.to_string()));
        if let Some((seconds, deviation)) = self.clock.take().map(Clock::result) {
            out.push_str(&format!(
                "  time on the machine {seconds:.1} s, without tool changes and waits\n"
            ));
            out.push_str(&match deviation.line {
                0 => "  the planned path is the programmed one\n".to_owned(),
                line => format!(
                    "  the planned path is off by {} mm at most, after line {line}\n",
                    rounded(deviation.distance)
                ),
            });
        }
        self.text.push_str(&out);
    }
}

/// Returns a distance with three significant places, rounded up.
fn rounded(distance: f64) -> String {
    let places = (2.0 - distance.abs().max(1e-9).log10().floor()).max(0.0);
    let scale = 10f64.powf(places);
    let up = (distance * scale).ceil() / scale;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 11")]
    let places = places as usize;
    format!("{up:.places$}")
}
