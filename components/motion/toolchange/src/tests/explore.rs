//! Every state of the tool changer that requests, answers, stops and power cuts can reach.
//!
//! The state machine and the record of the tool in the spindle are the real ones. Around them are a device that answers
//! late, wrongly or not at all, and the tool that is really in the spindle. Only one thing about the device is assumed: while
//! it is asked to change the tool, it says so no earlier than it has.

use crate::changer::{Answers, Changer, End, Phase, Tool, UNKNOWN};
use hal_job::spindle::{Spindle, parse, print};
use std::{
    collections::{BTreeMap, BTreeSet, VecDeque},
    fmt::Write as _,
};

/// Tools of the exploration; 0 is none.
const TOOLS: [i32; 3] = [0, 1, 2];

/// The changer and everything that it meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct World {
    changer: Changer,
    estop: bool,
    prepared: bool,
    changed: bool,
    /// Tool that is really in the spindle.
    real: i32,
    /// The record on disk.
    disk: Spindle,
    /// A request waits for its result.
    waits: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Input {
    Prepare(i32),
    Change,
    /// The operator says truly which tool is in the spindle.
    SetTool,
    Abort,
    Estop,
    Reset,
    /// A cycle of the task.
    Cycle,
    /// The answer to a request rises or falls, asked for or not.
    Prepared(bool),
    /// As `Prepared`; if it rises during a request, the tool is in the spindle.
    Changed(bool),
    /// The device takes the tool out, or puts one in, before it answers or after the request was withdrawn.
    Moves(i32),
    PowerCut,
    /// The power is cut while the record is written that the input before would write; this number of bytes is on disk.
    CutInWrite(usize),
}

/// Columns of the table.
const COLUMNS: [&str; 9] = [
    "prepare",
    "change",
    "set-tool",
    "abort",
    "e-stop",
    "reset",
    "no answer",
    "tool-prepared",
    "tool-changed",
];

fn tool(number: i32) -> Tool {
    Tool { number, pocket: number, index: number }
}

impl World {
    fn new() -> Self {
        let disk = Spindle::Holds(0);
        let changer = Changer::new();
        Self { changer, estop: true, prepared: false, changed: false, real: 0, disk, waits: false }
    }

    fn answers(&self) -> Answers {
        Answers { prepared: self.prepared, changed: self.changed }
    }

    /// Starts again with what is on disk.
    fn restart(&mut self, text: &str) {
        let record = parse(text).unwrap_or(Spindle::Holds(UNKNOWN));
        (self.changer, self.estop, self.waits) = (Changer::new(), true, false);
        self.changer.set_tool(tool(record.tool())).unwrap();
        // The record is written at the start.
        self.disk = Spindle::Holds(record.tool());
    }

    /// Applies an input; `None` if it is not possible here. The result is that of a request.
    fn apply(&self, input: Input) -> Option<(Self, Result<(), &'static str>)> {
        let mut next = *self;
        let mut result = Ok(());
        let asked = self.changer.requests().1;
        match input {
            Input::Prepare(_) | Input::Change if self.estop => result = Err("e-stop"),
            Input::Prepare(number) => {
                result = next.changer.prepare(tool(number), self.answers());
                next.waits |= result.is_ok();
            }
            Input::Change => {
                let begun = next.changer.change(self.answers());
                next.waits |= begun == Ok(false);
                if begun == Ok(false) {
                    next.disk = self.disk.asked(self.changer.shown().number);
                }
                result = begun.map(|_| ());
            }
            Input::SetTool => {
                result = next.changer.set_tool(tool(self.real));
                if result.is_ok() && self.changer.phase == Phase::Idle {
                    next.disk = Spindle::Holds(self.real);
                }
            }
            Input::Abort | Input::Estop => {
                let withdrawn = next.changer.withdraw();
                assert_eq!(withdrawn, self.waits, "what waits is told");
                next.waits = false;
                next.estop |= input == Input::Estop;
            }
            Input::Reset => next.estop = false,
            Input::Cycle => {
                let end = next.changer.follow(self.answers());
                assert!(end.is_none() || self.waits, "a result without a request");
                next.waits &= end.is_none();
                match end {
                    Some(End::Changed) => {
                        let Spindle::Changing { to, .. } = self.disk else { panic!("{self:?}") };
                        let is = next.changer.spindle().number;
                        next.disk = Spindle::changed(to, is).unwrap_or(self.disk);
                    }
                    Some(End::Failed(why)) => result = Err(why),
                    Some(End::Prepared) | None => {}
                }
            }
            Input::Prepared(on) if on != self.prepared => next.prepared = on,
            Input::Changed(on) if on != self.changed => {
                next.changed = on;
                if on && asked {
                    next.real = self.changer.shown().number;
                }
            }
            Input::Moves(number) => {
                let is_unknown = self.changer.spindle().number == UNKNOWN;
                let moves = if asked { !self.changed } else { is_unknown };
                if !moves || number == self.real {
                    return None;
                }
                next.real = number;
            }
            Input::PowerCut => next.restart(&print(self.disk, self.disk)),
            Input::CutInWrite(bytes) => {
                let writes = [Input::Change, Input::Cycle].map(|input| self.apply(input));
                let disk =
                    writes.into_iter().flatten().map(|(w, _)| w.disk).find(|d| *d != self.disk)?;
                let text = print(self.disk, disk);
                next.restart(text.get(..bytes)?);
            }
            Input::Prepared(_) | Input::Changed(_) => return None,
        }
        Some((next, result))
    }

    /// Checks everything that must hold in every state.
    fn check(&self) {
        let (prepare, change) = self.changer.requests();
        assert!(!(prepare && change), "both requests: {self:?}");
        assert!(!self.estop || !prepare && !change, "a request in e-stop: {self:?}");
        assert_eq!(self.waits, self.changer.phase != Phase::Idle, "a result: {self:?}");
        let believed = self.changer.spindle().number;
        if !change {
            assert!(believed == UNKNOWN || believed == self.real, "a wrong tool: {self:?}");
        } else {
            assert_eq!(self.disk.tool(), UNKNOWN, "asked before it is written: {self:?}");
        }
        let kept = self.disk.tool();
        assert!(kept == UNKNOWN || kept == self.real, "a wrong tool on disk: {self:?}");
    }

    /// Returns the row of the table.
    fn row(&self) -> String {
        let phase = match self.changer.phase {
            Phase::Idle => "idle",
            Phase::WaitToPrepare(_) => "wait to prepare",
            Phase::Preparing => "preparing",
            Phase::WaitToChange(_) => "wait to change",
            Phase::Changing => "changing",
        };
        let ready = if self.changer.is_prepared { ", prepared" } else { "" };
        let unknown = if self.changer.spindle().number == UNKNOWN { ", unknown" } else { "" };
        let estop = if self.estop { ", e-stop" } else { "" };
        format!("{phase}{ready}{unknown}{estop}")
    }

    /// Returns the column of an input here, if it is a column of its own.
    fn column(&self, input: Input) -> Option<usize> {
        Some(match input {
            Input::Prepare(_) => 0,
            Input::Change => 1,
            Input::SetTool => 2,
            Input::Abort => 3,
            Input::Estop => 4,
            Input::Reset => 5,
            Input::Cycle => match (self.prepared, self.changed) {
                (false, false) => 6,
                (true, false) => 7,
                (false, true) => 8,
                (true, true) => return None,
            },
            _ => return None,
        })
    }
}

fn inputs() -> Vec<Input> {
    let mut all = vec![
        Input::Change,
        Input::SetTool,
        Input::Abort,
        Input::Estop,
        Input::Reset,
        Input::Cycle,
        Input::PowerCut,
    ];
    all.extend(TOOLS.map(Input::Prepare));
    all.extend(TOOLS.map(Input::Moves));
    for on in [true, false] {
        all.extend([Input::Prepared(on), Input::Changed(on)]);
    }
    // The longest file has two changes.
    all.extend((0..60).map(Input::CutInWrite));
    all
}

#[test]
fn no_reachable_state_believes_in_a_wrong_tool() {
    let inputs = inputs();
    let mut seen = BTreeSet::from([World::new()]);
    let mut open = VecDeque::from([World::new()]);
    let mut transitions = 0u64;
    let mut table: BTreeMap<String, [BTreeSet<String>; COLUMNS.len()]> = BTreeMap::new();
    while let Some(world) = open.pop_front() {
        world.check();
        for input in &inputs {
            let Some((next, result)) = world.apply(*input) else { continue };
            transitions += 1;
            if let Some(column) = world.column(*input) {
                let end = match (result, next.row() == world.row()) {
                    (Err(_), true) => "refused".to_owned(),
                    (Err(_), false) => format!("fails: {}", next.row()),
                    (Ok(()), true) => "·".to_owned(),
                    (Ok(()), false) => next.row(),
                };
                table.entry(world.row()).or_default()[column].insert(end);
            }
            if seen.insert(next) {
                open.push_back(next);
            }
        }
    }
    let mut text = format!(
        "# States of the tool changer\n\nWritten by `UPDATE_EXPECT=1 cargo test -p toolchange explore`.\n\n\
         {} states and {transitions} transitions are reachable with the tools 0, 1 and 2, answers at any time, and a power cut \
         at any time and at every byte of a record; `src/tests/explore.rs` checks each. The table joins states that differ only in \
         tools and in answers that nobody waits for. `·`: nothing changes; several ends depend on the tools.\n\n\
         prepared: a tool is prepared. unknown: it is unknown which tool is in the spindle.\n\n| state | {} |\n|---|{}\n",
        seen.len(),
        COLUMNS.join(" | "),
        "---|".repeat(COLUMNS.len()),
    );
    for (row, ends) in &table {
        let ends = ends.iter().map(|e| e.iter().cloned().collect::<Vec<_>>().join(" *or* "));
        writeln!(text, "| {row} | {} |", ends.collect::<Vec<_>>().join(" | ")).unwrap();
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/states.md");
    hal_golden::check(path.as_ref(), &text);
}
