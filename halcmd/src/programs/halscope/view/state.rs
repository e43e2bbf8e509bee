//! State of a view, and the effect of keys on it.

use crate::{
    language::hint::nearest,
    programs::halscope::{
        figures::{figures, unit_of},
        names::Chosen,
    },
    terminal::screen::Key,
};
use hal_protocol::Type;
use hal_trace::{Trace, save};
use std::path::Path;

/// A channel as it is shown.
#[derive(Clone, Debug)]
pub(super) struct Lane {
    pub(super) chosen: Chosen,
    pub(super) is_bit: bool,
    /// Height in lines of the terminal.
    pub(super) height: usize,
}

/// Text that the user is typing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Typing {
    pub(super) what: Typed,
    pub(super) text: String,
}

/// Purpose of a typed text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Typed {
    /// Part of a channel's name.
    Name,
    /// Condition to go to.
    When,
    /// Trigger condition of a machine.
    Trigger,
    /// File to write.
    File,
}

/// State of a view.
#[derive(Debug)]
pub(super) struct State {
    pub(super) trace: Trace,
    pub(super) title: String,
    pub(super) lanes: Vec<Lane>,
    hidden: Vec<Lane>,
    /// The window in ticks. `to` is exclusive.
    pub(super) from: i64,
    pub(super) to: i64,
    pub(super) selected: usize,
    /// First lane that is drawn.
    pub(super) top: usize,
    /// Cursors A and B, and the number of the one that keys move.
    pub(super) cursors: [Option<i64>; 2],
    pub(super) active: usize,
    pub(super) typing: Option<Typing>,
    /// Message that is shown until the next key.
    pub(super) said: String,
    pub(super) helps: bool,
    /// Origin of displayed times: a trigger, or the beginning of machine time.
    pub(super) zero: i64,
    /// Number of columns of the drawing when it was last painted.
    pub(super) columns: usize,
}

/// Request that a key makes to the owner of the view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    Nothing,
    Leave,
    /// A letter that the view itself does not use.
    Other(char),
    /// The user typed a trigger.
    Trigger(String),
}

/// Default height of a lane of numbers, and its limits.
const HEIGHT: usize = 4;
const HEIGHTS: core::ops::RangeInclusive<usize> = 2..=12;

impl State {
    /// Makes a view of a whole trace.
    pub(super) fn new(trace: Trace, title: String, chosen: Vec<Chosen>) -> Self {
        let lane = |chosen: Chosen| {
            let ty = trace.channels().get(chosen.channel).map(hal_trace::Channel::ty);
            let is_bit = ty == Some(Type::Bit);
            Lane { chosen, is_bit, height: if is_bit { 2 } else { HEIGHT } }
        };
        let lanes = chosen.into_iter().map(lane).collect();
        let mut state = Self {
            trace,
            title,
            lanes,
            hidden: Vec::new(),
            from: 0,
            to: 1,
            selected: 0,
            top: 0,
            cursors: [None, None],
            active: 0,
            typing: None,
            said: String::new(),
            helps: false,
            zero: 0,
            columns: 80,
        };
        state.count_from_trigger();
        state.fit();
        state
    }

    fn count_from_trigger(&mut self) {
        let trigger = self.trace.markers().iter().find(|m| m.text.starts_with("trigger"));
        self.zero = trigger.map_or(0, |m| m.at);
    }

    /// Replaces the trace by another one of the same channels. The window and the cursors keep
    /// their positions relative to the beginning.
    pub(super) fn replace(&mut self, trace: Trace) {
        let (was_empty, was) = (self.trace.is_empty(), self.ends().0);
        self.trace = trace;
        self.count_from_trigger();
        let by = self.ends().0.saturating_sub(was);
        if was_empty {
            return self.fit();
        }
        self.from = self.from.saturating_add(by);
        self.to = self.to.saturating_add(by);
        for cursor in self.cursors.iter_mut().flatten() {
            *cursor = cursor.saturating_add(by);
        }
    }

    /// Returns the first and the last time.
    pub(super) fn ends(&self) -> (i64, i64) {
        let times = self.trace.times();
        times.first().zip(times.last()).unwrap_or((0, 1))
    }

    /// Makes the window show the whole trace.
    pub(super) fn fit(&mut self) {
        let (first, last) = self.ends();
        (self.from, self.to) = (first, last.saturating_add(1).max(first.saturating_add(1)));
    }

    pub(super) fn width(&self) -> i64 {
        self.to.saturating_sub(self.from).max(1)
    }

    /// Returns the selected lane.
    pub(super) fn lane(&self) -> Option<&Lane> {
        self.lanes.get(self.selected)
    }

    /// Writes a time, such as `1.5 ms`, relative to the trigger if there is one.
    pub(super) fn time(&self, ticks: i64) -> String {
        self.span(ticks.saturating_sub(self.zero))
    }

    /// Writes a duration.
    pub(super) fn span(&self, ticks: i64) -> String {
        let seconds = self.trace.base().seconds(ticks);
        let (factor, unit) = unit_of(seconds.abs(), "s");
        format!("{} {unit}", figures(seconds * factor))
    }

    /// Handles a key.
    pub(super) fn press(&mut self, key: Key) -> Asked {
        self.said.clear();
        if let Some(typing) = self.typing.take() {
            return self.typed(typing, key);
        }
        if self.helps {
            self.helps = false;
            return if key == Key::Quit { Asked::Leave } else { Asked::Nothing };
        }
        let tenth = (self.width() / 10).max(1);
        match key {
            Key::Quit | Key::Escape | Key::Letter('q') => return Asked::Leave,
            Key::Letter('?' | 'h') => self.helps = true,
            Key::Left => self.pan(-tenth),
            Key::Right => self.pan(tenth),
            Key::PageUp => self.pan(-self.width()),
            Key::PageDown => self.pan(self.width()),
            Key::Home => self.pan(self.ends().0.saturating_sub(self.from)),
            Key::End => self.pan(self.ends().1.saturating_add(1).saturating_sub(self.to)),
            Key::Letter('+' | '=') => self.zoom(true),
            Key::Letter('-') => self.zoom(false),
            Key::Letter('f') => self.fit(),
            Key::Letter('z') => self.between_cursors(),
            Key::Up => self.selected = self.selected.saturating_sub(1),
            Key::Down | Key::Tab => self.select_next(),
            Key::Letter('K') => self.move_lane(-1),
            Key::Letter('J') => self.move_lane(1),
            Key::Letter('[') => self.resize(-1),
            Key::Letter(']') => self.resize(1),
            Key::Letter('x') => self.hide(),
            Key::Letter('u') => self.lanes.append(&mut self.hidden),
            Key::Letter('a') => self.cursor(0),
            Key::Letter('b') => self.cursor(1),
            Key::Letter('c') => self.cursors = [None, None],
            Key::Letter(',') => self.step(-1),
            Key::Letter('.') => self.step(1),
            Key::Letter('<') => self.step(-10),
            Key::Letter('>') => self.step(10),
            Key::Letter('n') => self.edge(true),
            Key::Letter('p') => self.edge(false),
            Key::Letter('m') => self.marker(),
            Key::Letter('/') => self.ask(Typed::Name),
            Key::Letter('g') => self.ask(Typed::When),
            Key::Letter('w') => self.ask(Typed::File),
            Key::Letter(other) => return Asked::Other(other),
            _ => {}
        }
        Asked::Nothing
    }

    /// Starts text input.
    pub(super) fn ask(&mut self, what: Typed) {
        self.typing = Some(Typing { what, text: String::new() });
    }

    fn typed(&mut self, mut typing: Typing, key: Key) -> Asked {
        match key {
            Key::Quit => return Asked::Leave,
            Key::Escape => return Asked::Nothing,
            Key::Enter => match typing.what {
                Typed::Name => self.find(&typing.text),
                Typed::When => self.go(&typing.text),
                Typed::Trigger => return Asked::Trigger(typing.text),
                Typed::File => self.write(&typing.text),
            },
            Key::Back => drop(typing.text.pop()),
            Key::Letter(c) => typing.text.push(c),
            _ => {}
        }
        if key != Key::Enter {
            self.typing = Some(typing);
        }
        Asked::Nothing
    }

    fn write(&mut self, path: &str) {
        self.said = match save(Path::new(path), &self.trace) {
            Ok(()) => format!("{path}: {} samples", self.trace.len()),
            Err(e) => e.to_string(),
        };
    }

    /// Selects the next channel whose name contains this text, including hidden channels.
    fn find(&mut self, part: &str) {
        let (before, after) = self.lanes.split_at((self.selected + 1).min(self.lanes.len()));
        let places = (before.len()..).zip(after).chain((0..).zip(before));
        let has = |lane: &Lane| {
            let names =
                self.trace.channels().get(lane.chosen.channel).map(hal_trace::Channel::names);
            names.unwrap_or_default().iter().any(|n| n.contains(part))
        };
        let mut found = places.filter(|(_, lane)| has(lane)).map(|(i, _)| i);
        if let Some(found) = found.next() {
            self.selected = found;
        } else if let Some(found) = self.hidden.iter().position(has) {
            self.lanes.push(self.hidden.remove(found));
            self.selected = self.lanes.len() - 1;
        } else {
            let names = self.trace.channels().iter().flat_map(hal_trace::Channel::names);
            let near = nearest(part, names.map(String::as_str));
            let near = near.map_or_else(String::new, |near| format!("; did you mean {near}?"));
            self.said = format!("there is no '{part}'{near}");
        }
    }

    pub(super) fn pan(&mut self, by: i64) {
        // At least half a window of the trace stays in view.
        let (first, last) = self.ends();
        let (width, half) = (self.width(), self.width() / 2);
        let least = first.saturating_sub(half);
        let most = last.saturating_sub(half).max(least);
        self.from = self.from.saturating_add(by).max(least).min(most);
        self.to = self.from.saturating_add(width);
    }

    fn zoom(&mut self, is_in: bool) {
        let width = self.width();
        let next = if is_in { (width / 2).max(1) } else { width.saturating_mul(2) };
        // The window is at most twice as long as the trace.
        let (first, last) = self.ends();
        let next = next.min(last.saturating_sub(first).saturating_add(1).saturating_mul(2));
        let seen = |at: &i64| self.from <= *at && *at < self.to;
        let still = self.cursors.get(self.active).copied().flatten().filter(seen);
        let still = still.unwrap_or_else(|| self.from.saturating_add(width / 2));
        // The fixed point keeps its relative position in the window.
        let part =
            i128::from(still.saturating_sub(self.from)) * i128::from(next) / i128::from(width);
        self.from = still.saturating_sub(i64::try_from(part).unwrap_or(0));
        self.to = self.from.saturating_add(next.max(1));
        self.pan(0);
    }

    fn between_cursors(&mut self) {
        let [Some(a), Some(b)] = self.cursors else {
            self.said = "z shows what is between cursors A and B: set them with a and b".to_owned();
            return;
        };
        if a == b {
            self.said = "cursors A and B stand at one time".to_owned();
            return;
        }
        let (from, to) = (a.min(b), a.max(b));
        let room = (to.saturating_sub(from) / 20).max(1);
        (self.from, self.to) = (from.saturating_sub(room), to.saturating_add(room));
    }

    fn select_next(&mut self) {
        self.selected = (self.selected + 1).min(self.lanes.len().saturating_sub(1));
    }

    fn move_lane(&mut self, by: isize) {
        let Some(other) = self.selected.checked_add_signed(by) else { return };
        if other < self.lanes.len() && self.selected < self.lanes.len() {
            self.lanes.swap(self.selected, other);
            self.selected = other;
        }
    }

    fn resize(&mut self, by: isize) {
        if let Some(lane) = self.lanes.get_mut(self.selected).filter(|l| !l.is_bit) {
            let height = lane.height.saturating_add_signed(by);
            lane.height = height.max(*HEIGHTS.start()).min(*HEIGHTS.end());
        }
    }

    fn hide(&mut self) {
        if self.selected < self.lanes.len() {
            self.hidden.push(self.lanes.remove(self.selected));
            self.selected = self.selected.min(self.lanes.len().saturating_sub(1));
        }
    }
}
