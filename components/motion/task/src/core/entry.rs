//! The entry of a start in the middle of a program: the steps from the machine's state to that of the line.
//!
//! Up to a safe height, the tool, its offset, spindles and coolant, over the place, outputs, and down at feed.

use super::rules::Rules;
use crate::{
    convert::{Action, Converter},
    outside::{Move, Order, PathEnd, Shape, Speed},
};
use hal_component::IoState;
use hal_gcode::{Call, State, axis::Axis, canon::Direction, state::FeedMode};
use hal_job::{
    Machine,
    dry_run::{Found, place_mm},
};

/// Feed down to the place if the program has none per minute, in millimetres per minute.
const FEED: f64 = 100.0;
/// Ends of travel beyond this, in millimetres, are none.
const ENDLESS: f64 = 1e6;
/// Index of Z.
const Z: usize = 2;
/// Index of W, the axis of a quill beside Z.
const W: usize = 8;

/// A step of the entry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct EntryStep {
    /// Kind: up, tool, offset, prepare, mode, spindle, coolant, over, output, down.
    pub(crate) kind: &'static str,
    /// Description for the operator.
    pub(crate) text: String,
    /// End of a move in machine units.
    pub(crate) to: Option<[f64; 9]>,
    pub(super) actions: Vec<Action>,
}

/// State of the machine before the entry.
pub(super) struct Before<'a> {
    pub(super) state: &'a State,
    pub(super) io: IoState,
    pub(super) pose: [f64; 9],
}

/// Returns the steps from the machine's state to that of a line.
///
/// # Errors
/// The machine has no safe height, or no upper limit of its quill, or a move of the entry is beyond its limits; all reasons.
pub(super) fn entry(
    before: &Before<'_>,
    found: &Found,
    machine: &Machine,
    rules: &Rules,
) -> Result<Vec<EntryStep>, String> {
    let mut plan = Plan {
        machine,
        line: found.begin.line,
        converter: Converter::new(&machine.settings, rules.change_position),
        at: before.pose,
        steps: Vec::new(),
    };
    let (state, now) = (&found.state, &before.state.modal);
    let target = place(machine, state, before.pose);
    let safe = plan.safe_height(rules, &target)?;
    let back = plan.quill_back()?;
    plan.converter.restart(state, before.pose);
    plan.mode(state, before.state);
    plan.up(safe, back);
    let tool = state.tool.number;
    let changes = before.io.tool != tool;
    if changes {
        plan.change(tool, state.modal.spindles.len());
        plan.up(safe, back);
    }
    let [k_from, k_to] = [before.state, state].map(|s| s.frame.unit.to(machine.settings.unit));
    let (old, new) = (before.state.frame.tool.scaled(k_from), state.frame.tool.scaled(k_to));
    if old != new {
        let offset = Axis::ALL.map(|a| new[a]);
        let text = format!("tool offset {}", plan.words(&offset));
        plan.add("offset", text, vec![Action::Path(Order::ToolOffset(offset))]);
    }
    if let Some(next) = state.selected.filter(|t| *t != tool) {
        plan.add("prepare", format!("tool {next} is prepared"), vec![Action::Prepare(next)]);
    }
    for (number, spindle) in (0u8..).zip(&state.modal.spindles) {
        let was = now.spindles.get(usize::from(number)).map(|s| s.direction);
        let direction = spindle.direction;
        if direction == Direction::Stopped && (changes || was == Some(Direction::Stopped)) {
            continue;
        }
        let call = Call::TurnSpindle { spindle: number, direction };
        let unit = if spindle.css { "surface speed" } else { "rpm" };
        let text = match direction {
            Direction::Stopped => format!("spindle {number} stops"),
            Direction::Clockwise => format!("spindle {number} clockwise, {} {unit}", spindle.speed),
            Direction::Counterclockwise => {
                format!("spindle {number} counterclockwise, {} {unit}", spindle.speed)
            }
        };
        plan.call("spindle", text, call);
    }
    plan.coolant(state);
    plan.travel("over", format!("over the place at Z{safe:.4}"), |at| {
        for (axis, (at, to)) in at.iter_mut().zip(target).enumerate() {
            *at = if axis == Z || axis == W { *at } else { to };
        }
    });
    plan.outputs(found);
    plan.down(&target, state);
    plan.check()?;
    Ok(plan.steps)
}

/// Returns the place of a state in machine units. Axes that the machine does not have stay where they are.
pub(super) fn place(machine: &Machine, state: &State, pose: [f64; 9]) -> [f64; 9] {
    let at = place_mm(state).scaled(1.0 / machine.settings.unit.millimetres());
    let mut out = pose;
    for (place, axis) in out.iter_mut().zip(Axis::ALL) {
        if machine.settings.axes.has(axis) {
            *place = at[axis];
        }
    }
    out
}

/// The entry on its way.
struct Plan<'a> {
    machine: &'a Machine,
    line: u32,
    converter: Converter,
    at: [f64; 9],
    steps: Vec<EntryStep>,
}

impl Plan<'_> {
    /// Returns the height of moves over the part: the INI file's, or the upper end of Z's travel; never below the
    /// machine's place or the target's.
    fn safe_height(&self, rules: &Rules, target: &[f64; 9]) -> Result<f64, String> {
        let k = self.machine.settings.unit.millimetres();
        let top = self.machine.limits.get(Z).and_then(|(_, high)| *high);
        let top = top.filter(|high| *high < ENDLESS).map(|high| high / k);
        let height = rules.safe_height.or(top);
        if height.is_none() && self.machine.settings.axes.has(Axis::Z) {
            return Err(
                "no height is safe: Z has no upper limit, and the INI file no [TASK]SAFE_HEIGHT"
                    .into(),
            );
        }
        let heights = [self.at[Z], target[Z]].into_iter().chain(height);
        Ok(heights.fold(f64::NEG_INFINITY, f64::max))
    }

    /// Returns the upper end of the quill's travel, if the machine has a quill (W): elsewhere its tip is lower than Z says.
    fn quill_back(&self) -> Result<Option<f64>, String> {
        if !self.machine.settings.axes.has(Axis::W) {
            return Ok(None);
        }
        let k = self.machine.settings.unit.millimetres();
        let top = self.machine.limits.get(W).and_then(|(_, high)| *high);
        let top = top.filter(|high| *high < ENDLESS).map(|high| high / k);
        let why = "no height is safe: the quill W has no upper limit to which it is drawn back";
        top.map(Some).ok_or_else(|| why.to_owned())
    }

    fn add(&mut self, kind: &'static str, text: String, actions: Vec<Action>) {
        self.steps.push(EntryStep { kind, text, to: None, actions });
    }

    /// Adds the steps of a canonical call.
    fn call(&mut self, kind: &'static str, text: String, call: Call) {
        let mut actions = Vec::new();
        self.converter.convert(call, self.line, &mut actions);
        let moves = actions.iter().rev().find_map(|a| match a {
            Action::Path(Order::Move(m)) => Some(m.to),
            _ => None,
        });
        self.at = moves.unwrap_or(self.at);
        self.steps.push(EntryStep { kind, text, to: moves, actions });
    }

    /// Adds a straight move at this speed, unless the machine is there already.
    fn straight(&mut self, kind: &'static str, text: String, to: [f64; 9], speed: Speed) {
        if to == self.at {
            return;
        }
        self.at = to;
        let order = Move {
            to,
            shape: Shape::Line,
            speed,
            end: PathEnd::Stop,
            cam_tolerance: 0.0,
            pitch: None,
            line: self.line,
        };
        let actions = vec![Action::Path(Order::Move(order))];
        self.steps.push(EntryStep { kind, text, to: Some(to), actions });
    }

    fn travel(&mut self, kind: &'static str, text: String, change: impl FnOnce(&mut [f64; 9])) {
        let mut to = self.at;
        change(&mut to);
        self.straight(kind, text, to, Speed::Rapid);
    }

    /// Goes up to the safe height, and draws the quill all the way back.
    fn up(&mut self, safe: f64, back: Option<f64>) {
        let has_z = self.machine.settings.axes.has(Axis::Z);
        let z = has_z.then(|| format!("up to Z{safe:.4}"));
        let w = back.map(|back| format!("quill back to W{back:.4}"));
        let text: Vec<String> = z.into_iter().chain(w).collect();
        self.travel("up", text.join(", "), |at| {
            at[Z] = if has_z { safe.max(at[Z]) } else { at[Z] };
            at[W] = back.map_or(at[W], |back| back.max(at[W]));
        });
    }

    /// Changes the tool, with all spindles at rest, whatever they did before.
    fn change(&mut self, tool: i32, spindles: usize) {
        for spindle in (0u8..).take(spindles) {
            let call = Call::TurnSpindle { spindle, direction: Direction::Stopped };
            self.call("spindle", format!("spindle {spindle} stops"), call);
        }
        self.add("prepare", format!("tool {tool} is prepared"), vec![Action::Prepare(tool)]);
        self.call("tool", format!("tool {tool} into the spindle"), Call::ChangeTool(tool));
    }

    /// Brings overrides and feed hold to the state of the line.
    fn mode(&mut self, state: &State, before: &State) {
        let (new, old) = (&state.modal, &before.modal);
        let on = |on| if on { "on" } else { "off" };
        if new.feed_override != old.feed_override {
            let text = format!("feed override {}", on(new.feed_override));
            self.add("mode", text, vec![Action::FeedOverride(new.feed_override)]);
        }
        for ((spindle, new), old) in (0u8..).zip(&new.spindles).zip(&old.spindles) {
            if new.speed_override != old.speed_override {
                let text = format!("override of spindle {spindle} {}", on(new.speed_override));
                let action = Action::SpeedOverride { spindle, on: new.speed_override };
                self.add("mode", text, vec![action]);
            }
        }
        if new.adaptive_feed != old.adaptive_feed {
            let text = format!("adaptive feed {}", on(new.adaptive_feed));
            let order = Order::AdaptiveFeed(new.adaptive_feed);
            self.add("mode", text, vec![Action::Rest(order)]);
        }
        if new.feed_hold != old.feed_hold {
            let text = format!("feed hold {}", on(new.feed_hold));
            self.add("mode", text, vec![Action::Rest(Order::FeedHold(new.feed_hold))]);
        }
    }

    fn coolant(&mut self, state: &State) {
        let (mist, flood) = (state.modal.mist, state.modal.flood);
        let text = match (mist, flood) {
            (false, false) => "coolant off",
            (true, false) => "mist on",
            (false, true) => "flood on",
            (true, true) => "mist and flood on",
        };
        let action = Action::Coolant { mist: Some(mist), flood: Some(flood) };
        self.add("coolant", text.to_owned(), vec![action]);
    }

    fn outputs(&mut self, found: &Found) {
        for (index, on) in &found.effects.outputs.digital {
            let order = Order::Digital { index: *index, on: *on, with_motion: false };
            let text = format!("output {index} {}", if *on { "on" } else { "off" });
            self.add("output", text, vec![Action::Rest(order)]);
        }
        for (index, value) in &found.effects.outputs.analog {
            let order = Order::Analog { index: *index, value: *value, with_motion: false };
            let text = format!("analog output {index} at {value}");
            self.add("output", text, vec![Action::Rest(order)]);
        }
    }

    fn down(&mut self, target: &[f64; 9], state: &State) {
        let modal = &state.modal;
        let unit = self.machine.settings.unit;
        let own = modal.feed * state.frame.unit.to(unit);
        let has_feed = modal.feed_mode == FeedMode::PerMinute && own > 0.0;
        let feed = if has_feed { own } else { FEED / unit.millimetres() };
        let text = format!("down to Z{:.4} at feed {feed}", target[Z]);
        self.straight("down", text, *target, Speed::Feed(feed / 60.0));
    }

    /// Checks the ends of the moves against the machine's limits; between two of them the moves are straight.
    fn check(&self) -> Result<(), String> {
        let unit = self.machine.settings.unit.millimetres();
        let mut reasons = Vec::new();
        for step in &self.steps {
            let Some(to) = step.to else { continue };
            let mut place = hal_gcode::axis::Position::default();
            for (axis, value) in Axis::ALL.into_iter().zip(to) {
                place[axis] = if axis.is_rotary() { value } else { value * unit };
            }
            for limit in self.machine.beyond(place) {
                let why = self.machine.excess(limit, place[limit.0]);
                reasons.push(format!("the entry's move {}: {why}", step.kind));
            }
        }
        if reasons.is_empty() { Ok(()) } else { Err(reasons.join("; ")) }
    }

    /// Returns the words of the axes that a pose has.
    fn words(&self, pose: &[f64; 9]) -> String {
        words(self.machine, pose)
    }
}

/// Returns the words of the machine's axes at a pose.
pub(super) fn words(machine: &Machine, pose: &[f64; 9]) -> String {
    let axes = Axis::ALL.into_iter().zip(pose).filter(|(a, _)| machine.settings.axes.has(*a));
    let word =
        |(axis, value): (Axis, &f64)| format!("{}{value:.4}", axis.letter().to_ascii_uppercase());
    axes.map(word).collect::<Vec<_>>().join(" ")
}
