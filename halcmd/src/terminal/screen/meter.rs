//! A value in large characters.

use super::{
    Key, Look as Looks, Screen,
    digits::{HEIGHT, big},
    pick::{Pick, Picked},
};
use crate::{
    Error, show,
    show::watch::{Look, Of, Seen, about_seconds, look, wait},
};
use hal_protocol::{Link, Value};
use ratatui::{
    Frame,
    layout::{Constraint, Layout},
    text::{Line, Span},
};

/// Interval between two readings of the value, in milliseconds.
const STEP_MS: u32 = 50;

/// The current view.
enum View {
    Meter(Meter),
    Pick(Pick),
}

/// A value with the minimum and maximum seen so far.
struct Meter {
    name: String,
    of: Of,
    now: Look,
    range: Option<(f64, f64)>,
    looks: Looks,
}

/// Shows a value until the user leaves. Without a name, the user chooses one first.
pub(crate) fn meter(link: &mut dyn Link, name: Option<String>) -> Result<(), Error> {
    let (view, looks) = first(link, name)?;
    let mut screen = Screen::new()?;
    match run(link, view, looks, &mut screen) {
        Err(e) if !screen.is_left() => Err(e),
        // The user left while the machine did not answer.
        Ok(()) | Err(_) => Ok(()),
    }
}

/// Returns the view to begin with.
fn first(link: &mut dyn Link, name: Option<String>) -> Result<(View, Looks), Error> {
    let looks = Looks::new();
    let view = match name {
        None => View::Pick(pick(link, looks)?),
        Some(name) => {
            let found = look(link, core::slice::from_ref(&name))?;
            // If several names begin with it, the user chooses.
            match found.seen.as_slice() {
                [only] => View::Meter(Meter::new(only.name.clone(), only.of, looks)),
                [first, ..] if first.name == name => View::Meter(Meter::new(name, first.of, looks)),
                _ => View::Pick(Pick::new(found.seen, looks)),
            }
        }
    };
    Ok((view, looks))
}

fn run(
    link: &mut dyn Link,
    mut view: View,
    looks: Looks,
    screen: &mut Screen,
) -> Result<(), Error> {
    let mut last = None;
    loop {
        if let View::Meter(meter) = &mut view {
            meter.take(look(&mut screen.leaving(link), core::slice::from_ref(&meter.name))?);
        }
        screen.draw(|frame| match &mut view {
            View::Meter(meter) => meter.draw(frame),
            View::Pick(pick) => pick.draw(frame),
        })?;
        while let Some(key) = screen.key() {
            let next = match (&mut view, key) {
                (_, Key::Quit) | (View::Meter(_), Key::Escape | Key::Letter('q')) => {
                    return Ok(());
                }
                (View::Pick(pick), key) => match pick.press(key) {
                    Picked::Not => continue,
                    Picked::This(name, of) => Meter::new(name, of, looks),
                    Picked::None => match last.take() {
                        Some((name, of)) => Meter::new(name, of, looks),
                        None => return Ok(()),
                    },
                },
                (View::Meter(meter), Key::Letter('r')) => {
                    meter.range = None;
                    continue;
                }
                (View::Meter(meter), Key::Left | Key::Right | Key::Letter('n' | 'p')) => {
                    let back = matches!(key, Key::Left | Key::Letter('p'));
                    let (name, of) = neighbour(&mut screen.leaving(link), meter, back)?;
                    Meter::new(name, of, looks)
                }
                (View::Meter(meter), Key::Enter | Key::Tab | Key::Letter('/' | 's')) => {
                    last = Some((meter.name.clone(), meter.of));
                    view = View::Pick(pick(&mut screen.leaving(link), looks)?);
                    continue;
                }
                (View::Meter(_), _) => continue,
            };
            view = View::Meter(next);
        }
        if !wait(&mut screen.leaving(link), STEP_MS)? {
            return Ok(());
        }
    }
}

fn pick(link: &mut dyn Link, looks: Looks) -> Result<Pick, Error> {
    Ok(Pick::new(look(link, &[String::new()])?.seen, looks))
}

/// Returns the next or previous item by name.
fn neighbour(link: &mut dyn Link, meter: &Meter, back: bool) -> Result<(String, Of), Error> {
    let all = look(link, &[String::new()])?.seen;
    let here = (meter.name.as_str(), meter.of);
    let next = if back {
        all.iter().rev().find(|s| (s.name.as_str(), s.of) < here)
    } else {
        all.iter().find(|s| (s.name.as_str(), s.of) > here)
    };
    Ok(next.map_or_else(|| (meter.name.clone(), meter.of), |s| (s.name.clone(), s.of)))
}

impl Meter {
    const fn new(name: String, of: Of, looks: Looks) -> Self {
        Self { name, of, now: Look { time: 0, seen: Vec::new() }, range: None, looks }
    }

    fn seen(&self) -> Option<&Seen> {
        self.now.seen.iter().find(|s| s.name == self.name && s.of == self.of)
    }

    fn take(&mut self, now: Look) {
        self.now = now;
        if let Some(value) = self.seen().and_then(|s| number(&s.value)) {
            let (least, most) = self.range.unwrap_or((value, value));
            self.range = Some((least.min(value), most.max(value)));
        }
    }

    fn draw(&self, frame: &mut Frame<'_>) {
        let tall = u16::try_from(HEIGHT).unwrap_or(1);
        let parts = [
            Constraint::Length(2),
            Constraint::Length(tall + 1),
            Constraint::Min(1),
            Constraint::Length(1),
        ];
        let [head, value, about, foot] = Layout::vertical(parts).areas(frame.area());
        let time = format!("   machine time {}", about_seconds(self.now.time));
        let title = vec![
            Span::styled(self.name.clone(), self.looks.title),
            Span::styled(time, self.looks.dim),
        ];
        frame.render_widget(Line::from(title), head);
        let keys = "q quit   s search   left/right others   r reset least and most";
        frame.render_widget(Line::styled(keys, self.looks.dim), foot);

        let Some(seen) = self.seen() else {
            frame.render_widget(Line::raw("it no longer exists"), value);
            return;
        };
        let text = seen.value.to_string();
        match big(&text, usize::from(value.width)) {
            Some(lines) => {
                for (line, area) in lines.iter().zip(value.rows()) {
                    frame.render_widget(Line::raw(line.as_str()), area);
                }
            }
            None => frame.render_widget(Line::styled(text, self.looks.title), value),
        }
        for (line, area) in self.about(seen).into_iter().zip(about.rows()) {
            frame.render_widget(line, area);
        }
    }

    fn about(&self, seen: &Seen) -> Vec<Line<'static>> {
        let direction = seen.direction.map(|d| format!(" {}", d.name())).unwrap_or_default();
        let link = seen.signal.as_ref().zip(seen.direction);
        let link = link.map(|(s, d)| format!(" {} {s}", show::from_pin(d))).unwrap_or_default();
        let mut lines = vec![Line::raw(format!(
            "{} {}{direction}{link}",
            seen.of.name(),
            seen.value.ty().name()
        ))];
        if let Some((least, most)) = self.range {
            lines.push(Line::raw(format!(
                "least {}   most {}",
                Value::Float(least),
                Value::Float(most)
            )));
        }
        lines.push(Line::raw(""));
        lines.extend(seen.doc.lines().map(|l| Line::styled(l.to_owned(), self.looks.dim)));
        lines
    }
}

/// Returns the number of a value that has a minimum and a maximum.
fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(v) if !v.is_nan() => Some(*v),
        Value::S32(v) => Some(f64::from(*v)),
        Value::U32(v) => Some(f64::from(*v)),
        Value::S64(v) => Some(*v as f64),
        Value::U64(v) => Some(*v as f64),
        _ => None,
    }
}
