//! The view on the screen.

use super::{
    state::{Lane, State, Typed},
    wave,
};
use crate::{
    programs::halscope::figures::{figures, unit_of},
    terminal::screen::Look,
};
use hal_trace::{
    columns::columns,
    measure::{Measures, measure, number},
};
use ratatui::{
    Frame,
    layout::{Constraint, Layout, Rect},
    style::{Color, Style},
    text::{Line, Span},
};

/// Number of columns for names and values.
const NAMES: u16 = 26;
const HELP: &str = "\
 ← →         to and fro by a tenth          + -   zoom about the cursor, or the middle
 PgUp PgDn   by a window                    f     all of it
 Home End    to the beginning, the end      z     what is between the cursors
 ↑ ↓         select a channel               /     find a channel by a part of its name
 J K         move it down or up             [ ]   make a number lower or higher
 x u         hide it; show what is hidden   c     no cursors
 a b         cursor A, cursor B: the one that is set last moves with the keys below
 , . < >     by a column, by ten            n p   to the next edge of the channel, the one before
 m           to the next marker             g     to where something holds: xpos > 5
 w           write it to a file             q     leave
 of a machine that runs:                    r     stop, and run again
 s           one capture                    t     another trigger: xstep rises
 !           trigger now
";

/// Paints the view.
pub(super) fn paint(state: &mut State, status: &str, look: &Look, frame: &mut Frame<'_>) {
    let parts = [
        Constraint::Length(1),
        Constraint::Length(1),
        Constraint::Min(1),
        Constraint::Length(3),
        Constraint::Length(1),
    ];
    let [head, ruler, lanes, measures, foot] = Layout::vertical(parts).areas(frame.area());
    state.columns = usize::from(lanes.width.saturating_sub(NAMES)).max(1);
    frame.render_widget(title(state, status, look), head);
    if state.helps {
        for (line, row) in HELP.lines().zip(lanes.rows()) {
            frame.render_widget(Line::raw(line), row);
        }
        frame.render_widget(Line::styled("press any key to return", look.dim), foot);
        return;
    }
    frame.render_widget(rule(state, look), ruler);
    paint_lanes(state, look, frame, lanes);
    for (line, row) in readings(state, look).into_iter().zip(measures.rows()) {
        frame.render_widget(line, row);
    }
    frame.render_widget(bottom(state, look), foot);
}

fn title<'a>(state: &State, status: &str, look: &Look) -> Line<'a> {
    let zero = match state.zero {
        0 => String::new(),
        zero => format!(", 0 is at {}", state.span(zero)),
    };
    let range = format!("   {} to {}{zero}", state.time(state.from), state.time(state.to));
    let lost = match state.trace.lost() {
        0 => String::new(),
        lost => format!("   {lost} samples lost"),
    };
    Line::from(vec![
        Span::styled(state.title.clone(), look.title),
        Span::raw(range),
        Span::styled(lost, look.changed),
        Span::raw(format!("   {status}")),
    ])
}

/// Paints the time scale, with labels at round values.
fn rule<'a>(state: &State, look: &Look) -> Line<'a> {
    let mut text: Vec<char> = vec![' '; usize::from(NAMES) + state.columns];
    let base = state.trace.base();
    let after = |at: i64| at.saturating_sub(state.zero);
    let (from, width) = (base.seconds(after(state.from)), base.seconds(state.width()));
    // A label takes up to 14 columns.
    let most = (state.columns / 16).max(1) as f64;
    let step = round_step(width / most);
    let largest = after(state.to).saturating_abs().max(after(state.from).saturating_abs());
    let (factor, unit) = unit_of(base.seconds(largest), "s");
    let mut tick = (from / step).ceil();
    for _ in 0..state.columns {
        let at = (tick * step - from) / width * state.columns as f64;
        if !(0.0..state.columns as f64).contains(&at) {
            break;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a column")]
        let column = usize::from(NAMES) + at as usize;
        let label = format!("╵{} {unit}", figures(tick * step * factor));
        for (slot, c) in text.iter_mut().skip(column).zip(label.chars()) {
            *slot = c;
        }
        tick += 1.0;
    }
    Line::styled(text.into_iter().collect::<String>(), look.dim)
}

/// Returns the next larger number that is 1, 2 or 5 times a power of ten.
fn round_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|n| n * power);
    steps.into_iter().find(|s| *s >= least * 0.999_999).unwrap_or(least)
}

fn paint_lanes(state: &mut State, look: &Look, frame: &mut Frame<'_>, area: Rect) {
    let rows = usize::from(area.height);
    // Keeps the selected lane in view. Lanes are separated by blank lines.
    let taken = |from: usize, to: usize| -> usize {
        let lanes = state.lanes.iter().take(to + 1).skip(from);
        lanes.map(|l| l.height + 1).sum::<usize>().saturating_sub(1)
    };
    let mut top = state.top.min(state.selected);
    while top < state.selected && taken(top, state.selected) > rows {
        top += 1;
    }
    state.top = top;
    let mut row = 0;
    for (i, lane) in state.lanes.iter().enumerate().skip(top) {
        let height = lane.height.min(rows.saturating_sub(row));
        if height == 0 {
            break;
        }
        let place = |line: usize| {
            let down = u16::try_from(row + line).unwrap_or(u16::MAX);
            Rect { y: area.y.saturating_add(down), height: 1, ..area }
        };
        for (line, wave) in drawn(state, lane).into_iter().enumerate().take(height) {
            let place = place(line);
            let name = beside(state, lane, line);
            let style = if line > 0 {
                look.dim
            } else if i == state.selected {
                look.chosen
            } else {
                Style::new()
            };
            let width = usize::from(NAMES) - 1;
            let name: String = format!("{name:<width$}").chars().take(width).collect();
            frame.render_widget(Line::styled(name, style), place);
            let wave_place = Rect {
                x: place.x.saturating_add(NAMES),
                width: place.width.saturating_sub(NAMES),
                ..place
            };
            frame.render_widget(Line::raw(wave), wave_place);
        }
        row += lane.height + 1;
        if row >= rows {
            break;
        }
    }
    paint_cursors(state, look, frame, area);
}

fn drawn(state: &State, lane: &Lane) -> Vec<String> {
    let of = |count| columns(&state.trace, lane.chosen.channel, state.from, state.to, count);
    if lane.is_bit {
        return wave::bit(&of(state.columns)).to_vec();
    }
    let half = of(state.columns * 2);
    let (low, high) = bounds(&half);
    wave::number(&half, (low, high), lane.height)
}

fn bounds(columns: &[Option<hal_trace::columns::Column>]) -> (f64, f64) {
    let known = || columns.iter().flatten();
    let low = known().map(|c| c.min).reduce(f64::min).unwrap_or(0.0);
    let high = known().map(|c| c.max).reduce(f64::max).unwrap_or(1.0);
    (low, high)
}

/// Returns the text beside a line of a lane: name, value at the active cursor, or range.
fn beside(state: &State, lane: &Lane, line: usize) -> String {
    let last = lane.height - 1;
    match line {
        0 => shortened(&lane.chosen.name),
        1 => {
            let at = state.cursors.get(state.active).copied().flatten();
            let at = at.unwrap_or_else(|| state.to.saturating_sub(1).min(state.ends().1));
            let value = state.trace.at(lane.chosen.channel, at);
            format!("  {}", value.map_or_else(|| "?".to_owned(), |v| v.to_string()))
        }
        n if n == last => {
            let of = columns(&state.trace, lane.chosen.channel, state.from, state.to, 64);
            let (low, high) = bounds(&of);
            format!("  {} to {}", figures(low), figures(high))
        }
        _ => String::new(),
    }
}

/// Shortens a long name. The end remains, because it distinguishes names.
fn shortened(name: &str) -> String {
    let width = usize::from(NAMES) - 1;
    let count = name.chars().count();
    if count <= width {
        return name.to_owned();
    }
    let end: String = name.chars().skip(count - width + 1).collect();
    format!("…{end}")
}

/// Paints the columns of cursors, markers and gaps behind the lanes.
fn paint_cursors(state: &State, look: &Look, frame: &mut Frame<'_>, area: Rect) {
    let column = |at: i64| {
        let within = (state.from..state.to).contains(&at);
        let part = i128::from(at.saturating_sub(state.from)) * state.columns as i128;
        let column = u16::try_from(part / i128::from(state.width())).ok();
        column.filter(|_| within).map(|c| area.x.saturating_add(NAMES).saturating_add(c))
    };
    let mut line = |at: i64, name: &str, style: Style, blank: bool| {
        let Some(x) = column(at).filter(|x| *x < area.right()) else { return };
        for y in area.top()..area.bottom() {
            let Some(cell) = frame.buffer_mut().cell_mut((x, y)) else { continue };
            if cell.symbol() == " " && blank {
                cell.set_symbol("┊");
            }
            cell.set_style(style);
        }
        if let Some(cell) = frame.buffer_mut().cell_mut((x, area.y.saturating_sub(1))) {
            cell.set_symbol(name);
            cell.set_style(style);
        }
    };
    for marker in state.trace.markers() {
        line(marker.at, "▾", look.changed, true);
    }
    for gap in state.trace.gaps() {
        if let Some(at) = state.trace.times().get(gap.sample) {
            line(at, "!", Style::new().fg(Color::Red), true);
        }
    }
    for (cursor, name) in state.cursors.iter().zip(["A", "B"]) {
        if let Some(at) = cursor {
            line(*at, name, look.chosen, true);
        }
    }
}

/// Paints the cursors, and the measurements of the selected channel.
fn readings<'a>(state: &State, look: &Look) -> Vec<Line<'a>> {
    let mut cursors = String::new();
    for (cursor, name) in state.cursors.iter().zip(["A", "B"]) {
        if let Some(at) = cursor {
            cursors.push_str(&format!("{name} {}   ", state.time(*at)));
        }
    }
    let [a, b] = state.cursors;
    if let Some((a, b)) = a.zip(b) {
        let apart = b.saturating_sub(a);
        cursors.push_str(&format!("B-A {}", state.span(apart)));
        let seconds = state.trace.base().seconds(apart).abs();
        if seconds > 0.0 {
            let (factor, unit) = unit_of(1.0 / seconds, "Hz");
            cursors.push_str(&format!(" ({} {unit})", figures(factor / seconds)));
        }
    }
    let Some(lane) = state.lane() else { return vec![Line::raw(cursors)] };
    let channel = lane.chosen.channel;
    let (from, to, where_) = match a.zip(b).filter(|(a, b)| a != b) {
        Some((a, b)) => (a.min(b), a.max(b), "from A to B"),
        None => (state.from, state.to, "in view"),
    };
    let m = measure(&state.trace, channel, from, to);
    let mut second = vec![Span::styled(format!("{} {where_}: ", lane.chosen.name), look.title)];
    second.push(Span::raw(said(&m, lane.is_bit)));
    let value = |at: Option<i64>| state.trace.at(channel, at?);
    let mut third = String::new();
    for (at, name) in [(a, "A"), (b, "B")] {
        if let Some(v) = value(at) {
            third.push_str(&format!("at {name} {v}   "));
        }
    }
    let numbers = (value(a).and_then(number), value(b).and_then(number));
    if let (Some(x), Some(y), false) = (numbers.0, numbers.1, lane.is_bit) {
        third.push_str(&format!("difference {}", figures(y - x)));
    }
    vec![Line::raw(cursors), Line::from(second), Line::raw(third)]
}

fn said(m: &Measures, is_bit: bool) -> String {
    let mut parts = Vec::new();
    if let Some(f) = m.frequency {
        let (factor, unit) = unit_of(f, "Hz");
        parts.push(format!("{} {unit}", figures(f * factor)));
    }
    if let Some(duty) = m.duty.filter(|_| is_bit) {
        parts.push(format!("high {} %", figures(duty * 100.0)));
    }
    for (name, spread) in [("period", m.period), ("high for", m.high), ("low for", m.low)] {
        let Some(s) = spread.filter(|_| is_bit) else { continue };
        let (factor, unit) = unit_of(s.mean, "s");
        let [min, mean, max] = [s.min, s.mean, s.max].map(|t| figures(t * factor));
        let text = if min == max { mean } else { format!("{min} to {max}, mean {mean}") };
        parts.push(format!("{name} {text} {unit}"));
    }
    if let (Some(min), Some(max), Some(mean), false) = (m.min, m.max, m.mean, is_bit) {
        parts.push(format!("{} to {}, mean {}", figures(min), figures(max), figures(mean)));
    }
    if is_bit {
        parts.push(format!("{} rises, {} falls", m.rises, m.falls));
    } else {
        parts.push(format!("{} changes", m.changes));
    }
    parts.join(", ")
}

fn bottom<'a>(state: &State, look: &Look) -> Line<'a> {
    if let Some(typing) = &state.typing {
        let what = match typing.what {
            Typed::Name => "find",
            Typed::When => "go to where",
            Typed::Trigger => "trigger when",
            Typed::File => "write to",
        };
        return Line::raw(format!("{what}: {}▏", typing.text));
    }
    if !state.said.is_empty() {
        return Line::styled(state.said.clone(), look.changed);
    }
    let keys = "← → + - f  ↑ ↓ /  a b n p , .  z  m  ? help  q leave";
    Line::styled(keys.to_owned(), look.dim)
}
