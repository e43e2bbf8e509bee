//! A list of values in which changes are marked.

use super::{Key, Look as Looks, Screen};
use crate::{
    Error,
    language::command::Watch,
    show,
    show::watch::{Look, Of, Seen, about_seconds, look, wait},
};
use hal_protocol::{Link, Value};
use ratatui::{
    Frame,
    layout::{Constraint, Layout},
    text::{Line, Span},
};
use std::collections::BTreeMap;

/// Time for which a changed value stays marked, in milliseconds.
const MARKED_MS: u32 = 1000;
/// Interval between two checks of the keyboard, in milliseconds.
const STEP_MS: u32 = 50;

struct Values<'a> {
    watch: &'a Watch,
    instance: &'a str,
    now: Look,
    /// Milliseconds since the last change of each marked value.
    changed: BTreeMap<(String, Of), u32>,
    top: usize,
    rows: usize,
    paused: bool,
    looks: Looks,
}

/// Shows values until the user leaves. Returns the last values.
pub(crate) fn watch(
    link: &mut dyn Link,
    watch: &Watch,
    first: Look,
    instance: &str,
) -> Result<Look, Error> {
    let mut screen = Screen::new()?;
    let mut view = Values {
        watch,
        instance,
        now: first,
        changed: BTreeMap::new(),
        top: 0,
        rows: 1,
        paused: false,
        looks: Looks::new(),
    };
    let mut looks = 1;
    loop {
        let mut left = watch.every_ms;
        while left > 0 {
            screen.draw(|frame| view.draw(frame))?;
            while let Some(key) = screen.key() {
                if !view.press(key) {
                    return Ok(view.now);
                }
            }
            let ms = left.min(STEP_MS);
            match wait(&mut screen.leaving(link), ms) {
                Ok(true) => {}
                Err(e) if !screen.is_left() => return Err(e),
                Ok(false) | Err(_) => return Ok(view.now),
            }
            left -= ms;
        }
        if view.paused {
            continue;
        }
        if watch.count.is_some_and(|count| looks >= count) {
            return Ok(view.now);
        }
        looks += 1;
        match look(&mut screen.leaving(link), &watch.patterns) {
            Ok(next) => view.take(next),
            Err(e) if !screen.is_left() => return Err(e),
            Err(_) => return Ok(view.now),
        }
    }
}

impl Values<'_> {
    fn take(&mut self, next: Look) {
        let every = self.watch.every_ms;
        self.changed.retain(|_, age| {
            *age = age.saturating_add(every);
            *age < MARKED_MS
        });
        let before: BTreeMap<(&str, Of), Value> =
            self.now.seen.iter().map(|s| ((s.name.as_str(), s.of), s.value)).collect();
        for seen in &next.seen {
            let old = before.get(&(seen.name.as_str(), seen.of));
            if old.is_some_and(|old| *old != seen.value) {
                self.changed.insert((seen.name.clone(), seen.of), 0);
            }
        }
        self.now = next;
    }

    /// Handles a key. Returns false to leave the view.
    fn press(&mut self, key: Key) -> bool {
        let page = self.rows.max(1);
        match key {
            Key::Quit | Key::Escape | Key::Letter('q') => return false,
            Key::Letter(' ' | 'p') => self.paused = !self.paused,
            Key::Up => self.top = self.top.saturating_sub(1),
            Key::Down => self.top += 1,
            Key::PageUp => self.top = self.top.saturating_sub(page),
            Key::PageDown => self.top += page,
            Key::Home => self.top = 0,
            Key::End => self.top = usize::MAX,
            _ => {}
        }
        true
    }

    fn draw(&mut self, frame: &mut Frame<'_>) {
        let parts = [Constraint::Length(2), Constraint::Min(1), Constraint::Length(1)];
        let [head, list, foot] = Layout::vertical(parts).areas(frame.area());
        self.rows = usize::from(list.height);
        let most = self.now.seen.len().saturating_sub(self.rows);
        self.top = self.top.min(most);

        let time = about_seconds(self.now.time);
        let mut title = vec![
            Span::styled(format!("instance {}", self.instance), self.looks.title),
            Span::raw(format!("   machine time {time}   every {} ms", self.watch.every_ms)),
        ];
        if self.paused {
            title.push(Span::styled("   paused", self.looks.changed));
        }
        frame.render_widget(Line::from(title), head);

        let width = self.now.seen.iter().map(|s| s.name.chars().count()).max().unwrap_or(0);
        let lines = self.now.seen.iter().skip(self.top).take(self.rows);
        for (seen, area) in lines.zip(list.rows()) {
            frame.render_widget(self.line(seen, width), area);
        }

        let count = self.now.seen.len();
        let range = if most > 0 {
            let last = (self.top + self.rows).min(count);
            format!("   {}-{last} of {count}", self.top + 1)
        } else {
            String::new()
        };
        let keys = format!(
            "q quit   space pause{}{range}",
            if most > 0 { "   arrows scroll" } else { "" }
        );
        frame.render_widget(Line::styled(keys, self.looks.dim), foot);
    }

    fn line(&self, seen: &Seen, width: usize) -> Line<'static> {
        let changed = self.changed.contains_key(&(seen.name.clone(), seen.of));
        let (mark, style) = if changed { ("*", self.looks.changed) } else { (" ", self.looks.dim) };
        let value = show::value(&seen.value);
        let link = seen
            .signal
            .as_ref()
            .zip(seen.direction)
            .map(|(signal, direction)| format!("  {} {signal}", show::from_pin(direction)));
        let mut spans = vec![
            Span::styled(mark, style),
            Span::raw(format!(" {:<width$}  ", seen.name)),
            Span::styled(
                format!("{value:>20}"),
                if changed { self.looks.changed } else { ratatui::style::Style::new() },
            ),
            Span::styled(
                format!("  {:<5} {:<5}", seen.of.name(), seen.value.ty().name()),
                self.looks.dim,
            ),
        ];
        spans.extend(link.map(|link| Span::styled(link, self.looks.dim)));
        Line::from(spans)
    }
}
