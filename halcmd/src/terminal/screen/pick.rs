//! Selection of a pin, signal or parameter by a part of its name.

use super::{Key, Look};
use crate::show::watch::{Of, Seen};
use ratatui::{
    Frame,
    layout::{Constraint, Layout},
    text::{Line, Span},
};

/// Items to choose from, and the state of the selection.
pub(super) struct Pick {
    all: Vec<Seen>,
    wanted: String,
    of: Option<Of>,
    at: usize,
    rows: usize,
    look: Look,
}

/// Result of a key.
pub(super) enum Picked {
    /// No selection yet.
    Not,
    /// The user chose this item.
    This(String, Of),
    /// The user left without choosing.
    None,
}

impl Pick {
    pub(super) fn new(all: Vec<Seen>, look: Look) -> Self {
        Self { all, wanted: String::new(), of: None, at: 0, rows: 1, look }
    }

    /// Returns the items whose names contain every word of the search.
    fn found(&self) -> Vec<&Seen> {
        let words: Vec<&str> = self.wanted.split(' ').collect();
        let fits = |s: &&Seen| {
            self.of.is_none_or(|of| of == s.of) && words.iter().all(|word| s.name.contains(word))
        };
        self.all.iter().filter(fits).collect()
    }

    pub(super) fn press(&mut self, key: Key) -> Picked {
        let last = self.found().len().saturating_sub(1);
        match key {
            Key::Escape => return Picked::None,
            Key::Enter => {
                if let Some(seen) = self.found().get(self.at) {
                    return Picked::This(seen.name.clone(), seen.of);
                }
            }
            Key::Tab => {
                self.of = match self.of {
                    None => Some(Of::Pin),
                    Some(Of::Pin) => Some(Of::Sig),
                    Some(Of::Sig) => Some(Of::Param),
                    Some(Of::Param) => None,
                };
                self.at = 0;
            }
            Key::Back => {
                self.wanted.pop();
                self.at = 0;
            }
            Key::Letter(c) => {
                self.wanted.push(c);
                self.at = 0;
            }
            Key::Up => self.at = self.at.saturating_sub(1),
            Key::Down => self.at = (self.at + 1).min(last),
            Key::PageUp => self.at = self.at.saturating_sub(self.rows),
            Key::PageDown => self.at = (self.at + self.rows).min(last),
            Key::Home => self.at = 0,
            Key::End => self.at = last,
            Key::Quit | Key::Left | Key::Right | Key::Other => {}
        }
        Picked::Not
    }

    pub(super) fn draw(&mut self, frame: &mut Frame<'_>) {
        let parts = [Constraint::Length(2), Constraint::Min(1), Constraint::Length(1)];
        let [head, list, foot] = Layout::vertical(parts).areas(frame.area());
        self.rows = usize::from(list.height).max(1);
        let kind = match self.of {
            None => "pins, signals and parameters",
            Some(Of::Pin) => "pins",
            Some(Of::Sig) => "signals",
            Some(Of::Param) => "parameters",
        };
        let title = Line::from(vec![
            Span::styled("search: ", self.look.title),
            Span::raw(self.wanted.clone()),
            Span::styled(" ", self.look.chosen),
        ]);
        frame.render_widget(title, head);

        let found = self.found();
        let top = (self.at + 1).saturating_sub(self.rows);
        let width = found.iter().map(|s| s.name.chars().count()).max().unwrap_or(0);
        let shown = found.iter().enumerate().skip(top).take(self.rows);
        for ((i, seen), area) in shown.zip(list.rows()) {
            let (of, ty) = (seen.of.name(), seen.value.ty().name());
            let name = Span::raw(format!(" {:<width$} ", seen.name));
            let name = if i == self.at { name.style(self.look.chosen) } else { name };
            let about = format!("  {of:<5}  {ty:<5}  {}", seen.doc.lines().next().unwrap_or(""));
            frame.render_widget(Line::from(vec![name, Span::styled(about, self.look.dim)]), area);
        }
        let keys = format!(
            "{} {kind}   enter choose   tab other kinds   esc back   ctrl-c quit",
            found.len()
        );
        frame.render_widget(Line::styled(keys, self.look.dim), foot);
    }
}

#[cfg(test)]
mod tests {
    use super::{Key, Look, Of, Pick, Picked, Seen};
    use hal_protocol::Value;

    fn pick() -> Pick {
        let seen = |name: &str, of| Seen {
            name: name.to_owned(),
            of,
            value: Value::Bit(false),
            direction: None,
            signal: None,
            doc: String::new(),
        };
        let all = vec![
            seen("stepgen.0.dirhold", Of::Param),
            seen("stepgen.0.step", Of::Pin),
            seen("stepgen.1.step", Of::Pin),
            seen("x-step", Of::Sig),
        ];
        Pick::new(all, Look::new())
    }

    fn chosen(keys: &[Key]) -> String {
        let mut pick = pick();
        for key in keys {
            match pick.press(*key) {
                Picked::Not => {}
                Picked::This(name, of) => return format!("{} {name}", of.name()),
                Picked::None => return "none".to_owned(),
            }
        }
        format!("{} left", pick.found().len())
    }

    #[test]
    fn names_are_searched_by_their_parts() {
        use Key::{Back, Down, End, Enter, Escape, Letter, Tab, Up};
        for (keys, want) in [
            (&[Enter][..], "param stepgen.0.dirhold"),
            (&[Letter('s'), Letter('t'), Letter('1')], "0 left"),
            (&[Letter('s'), Letter(' '), Letter('1'), Enter], "pin stepgen.1.step"),
            (&[Letter('q'), Back, End, Enter], "sig x-step"),
            (&[Tab, Down, Down, Down, Enter], "pin stepgen.1.step"),
            (&[Tab, Tab, Up, Enter], "sig x-step"),
            (&[Letter('?'), Enter], "0 left"),
            (&[Escape], "none"),
        ] {
            assert_eq!(chosen(keys), want, "{keys:?}");
        }
    }
}
