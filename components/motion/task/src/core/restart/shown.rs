//! The texts that show a proposal to the operator.

use super::{EntryStep, Proposal, words};
use crate::codes;
use hal_gcode::{
    axis::{Axis, Position},
    canon::Direction,
};
use hal_job::{Machine, dry_run::Found, effects::Effects};
use serde_json::{Value, json};

/// The proposal as text and as JSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Shown {
    pub(crate) lines: Vec<String>,
    pub(crate) json: String,
}

impl Proposal {
    /// Returns the texts that show the proposal.
    pub(super) fn shown(&self, machine: &Machine) -> Shown {
        let Found { state, begin, calls, pass, more, effects } = &self.found;
        let (modal, frame) = (&state.modal, state.frame);
        let k = frame.unit.to(machine.settings.unit);
        let pose = |at: Position| words(machine, &Axis::ALL.map(|a| at.scaled(k)[a]));
        let more = if *more { " or more" } else { "" };
        let mut lines = vec![format!(
            "start token={} file={} line={} pass={} of={}{more}",
            self.token, begin.file, begin.line, pass.0, pass.1
        )];
        lines.extend(calls.iter().map(|call| format!("call from={}:{}", call.file, call.line)));
        let place = self.place_in_words();
        lines.push(format!("place {place}"));
        lines.push(format!("modal {} F{}", codes::text(state), modal.feed));
        let selected = state.selected.unwrap_or(state.tool.number);
        lines.push(format!("tool number={} selected={selected}", state.tool.number));
        let spindles: Vec<_> = modal.spindles.iter().map(|s| s.speed * sign(s.direction)).collect();
        for (number, speed) in spindles.iter().enumerate() {
            lines.push(format!("spindle number={number} speed={speed}"));
        }
        lines.push(format!("coolant mist={} flood={}", truth(modal.mist), truth(modal.flood)));
        lines.push(format!("position {}", words(machine, &self.place)));
        let (system, rotation) = (modal.system, frame.rotation);
        lines.push(format!("system number={system} rotation={rotation} {}", pose(frame.g5x)));
        lines.push(format!("g92 {}", pose(frame.g92)));
        lines.push(format!("tool-offset {}", pose(frame.tool)));
        let notes: Vec<String> = self.notes.iter().cloned().chain(missing(effects)).collect();
        lines.extend(notes.iter().map(|note| format!("note {note}")));
        let numbered = |steps: &[EntryStep]| -> Vec<String> {
            let row = |(n, step): (usize, &EntryStep)| {
                let to = step.to.map(|to| format!(": {}", words(machine, &to))).unwrap_or_default();
                format!("entry {} {}: {}{to}", n + 1, step.kind, step.text)
            };
            steps.iter().enumerate().map(row).collect()
        };
        match &self.entry {
            Ok(steps) => lines.extend(numbered(steps)),
            Err(why) => lines.push(format!("not-ready {why}")),
        }
        let steps: Vec<Value> = self
            .entry
            .iter()
            .flatten()
            .map(|step| json!({ "kind": step.kind, "text": step.text, "to": step.to }))
            .collect();
        let calls: Vec<Value> =
            calls.iter().map(|c| json!({ "file": c.file, "line": c.line })).collect();
        let offset = |at: Position| Axis::ALL.map(|a| at.scaled(k)[a]);
        let json = json!({
            "version": 1,
            "token": self.token,
            "file": begin.file,
            "line": begin.line,
            "pass": pass.0,
            "passes": pass.1,
            "may_have_more_passes": self.found.more,
            "calls": calls,
            "place": place,
            "codes": codes::text(state),
            "feed": modal.feed,
            "tool": state.tool.number,
            "selected": selected,
            "spindles": spindles,
            "mist": modal.mist,
            "flood": modal.flood,
            "position": self.place,
            "system": system,
            "rotation": rotation,
            "g5x_offset": offset(frame.g5x),
            "g92_offset": offset(frame.g92),
            "tool_offset": offset(frame.tool),
            "user_codes": effects.user_codes.known,
            "more_user_codes": effects.user_codes.more,
            "notes": notes,
            "entry": steps,
            "not_ready": self.entry.as_ref().err(),
        });
        Shown { lines, json: json.to_string() }
    }
}

impl Proposal {
    /// Returns the place for a person: line, pass, and the calls in progress, the innermost first.
    fn place_in_words(&self) -> String {
        let Found { state, begin, calls, pass, more, .. } = &self.found;
        let mut out = format!("{}:{}", begin.file, begin.line);
        let more = if *more { " or more" } else { "" };
        if pass.1 > 1 || !more.is_empty() {
            out.push_str(&format!(", pass {} of {}{more}", pass.0, pass.1));
        }
        let levels: Vec<_> = state.levels.iter().filter(|level| level.is_of_file()).collect();
        for (level, call) in levels.iter().skip(1).zip(calls).rev() {
            let name = if level.label.is_empty() { &level.file } else { &level.label };
            out.push_str(&format!(", in sub {name} called from {}:{}", call.file, call.line));
        }
        out
    }
}

/// Returns remarks about effects of the lines before the place that the entry does not make.
fn missing(effects: &Effects) -> Vec<String> {
    let codes = &effects.user_codes;
    let mut out: Vec<String> = codes
        .known
        .iter()
        .map(|(code, line)| format!("M{code} of line {line} is not run again"))
        .collect();
    if codes.more {
        out.push("more user codes before the line are not run again".to_owned());
    }
    let files = [("log", &effects.log), ("probe", &effects.probe)];
    for (kind, name) in files.into_iter().filter_map(|(kind, n)| n.as_ref().map(|n| (kind, n))) {
        out.push(format!("the {kind} file {name} is not open: nothing is written to it"));
    }
    out
}

fn sign(direction: Direction) -> f64 {
    match direction {
        Direction::Stopped => 0.0,
        Direction::Clockwise => 1.0,
        Direction::Counterclockwise => -1.0,
    }
}

fn truth(on: bool) -> &'static str {
    if on { "TRUE" } else { "FALSE" }
}
