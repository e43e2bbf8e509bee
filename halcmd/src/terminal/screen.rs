//! Views that use the whole terminal and restore it at the end.

mod digits;
mod meter;
mod pick;
mod values;

use crate::{Error, session::prompt, terminal::termination::Held};
use hal_protocol::{Failure, Link, Reply, Request};
use ratatui::{
    DefaultTerminal, Frame,
    crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers},
    style::{Color, Modifier, Style},
};
use std::{cell::RefCell, collections::VecDeque, time::Duration};

pub(crate) use meter::meter;
pub(crate) use values::watch;

/// Number of looks, 50 ms apart, for which a view waits for an answer before it heeds the keyboard.
const PATIENT_LOOKS: u32 = 5;
/// Maximum number of keys that are read at once.
const MAX_KEYS: usize = 256;

/// The terminal while a view uses it.
pub(crate) struct Screen {
    terminal: DefaultTerminal,
    held: Held,
    /// Keys that were read and not handled yet.
    pressed: RefCell<VecDeque<Key>>,
    /// Messages wait until the terminal is restored.
    _kept: prompt::Kept,
}

impl Screen {
    pub(crate) fn new() -> Result<Self, Error> {
        let (held, kept) = (Held::new(), prompt::Kept::new());
        let terminal = ratatui::try_init().map_err(|_| Error::NoScreen)?;
        Ok(Self { terminal, held, pressed: RefCell::default(), _kept: kept })
    }

    pub(crate) fn draw(&mut self, view: impl FnOnce(&mut Frame<'_>)) -> Result<(), Error> {
        self.terminal.draw(view).map(|_| ()).map_err(|_| Error::NoScreen)
    }

    /// Returns the pressed key, if any. Ctrl-C and a signal are [`Key::Quit`].
    pub(crate) fn key(&self) -> Option<Key> {
        let earlier = self.pressed.borrow_mut().pop_front();
        earlier.or_else(|| self.read())
    }

    /// Returns a link for requests that fail if the engine does not answer for a quarter of a
    /// second, as when it is stopped by SIGSTOP, and the user wants to leave.
    pub(crate) fn leaving<'s>(&'s self, link: &'s mut dyn Link) -> Leaving<'s> {
        Leaving { screen: self, link }
    }

    /// Returns whether the user has pressed a key that leaves a view.
    pub(crate) fn is_left(&self) -> bool {
        let mut pressed = self.pressed.borrow_mut();
        pressed.extend(core::iter::from_fn(|| self.read()).take(MAX_KEYS));
        pressed.iter().any(|key| matches!(key, Key::Quit | Key::Escape | Key::Letter('q')))
    }

    fn read(&self) -> Option<Key> {
        if self.held.has_come() {
            return Some(Key::Quit);
        }
        // If the terminal is gone, the view ends.
        match event::poll(Duration::ZERO).and_then(|any| any.then(event::read).transpose()) {
            Ok(Some(Event::Key(key))) if key.kind != KeyEventKind::Release => Some(key.into()),
            Ok(_) => None,
            Err(_) => Some(Key::Quit),
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // If the terminal is gone, there is nothing to restore and no reader for an error.
        ratatui::try_restore().unwrap_or_default();
    }
}

/// A link whose requests the user can interrupt by leaving the view.
pub(crate) struct Leaving<'s> {
    screen: &'s Screen,
    link: &'s mut dyn Link,
}

impl Link for Leaving<'_> {
    fn call(&mut self, request: Request) -> Result<Reply, Failure> {
        let mut looks = 0_u32;
        self.link.call_while(request, &mut || {
            looks = looks.saturating_add(1);
            looks <= PATIENT_LOOKS || !self.screen.is_left()
        })
    }

    fn is_local(&self) -> bool {
        self.link.is_local()
    }

    fn is_ending(&self) -> bool {
        self.link.is_ending()
    }
}

/// A key that has a meaning in a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    Quit,
    Escape,
    Enter,
    Tab,
    Back,
    Up,
    Down,
    PageUp,
    PageDown,
    Home,
    End,
    Left,
    Right,
    Letter(char),
    Other,
}

impl From<KeyEvent> for Key {
    fn from(key: KeyEvent) -> Self {
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        match key.code {
            KeyCode::Char('c' | 'd') if control => Self::Quit,
            KeyCode::Char(_) if control => Self::Other,
            KeyCode::Char(c) => Self::Letter(c),
            KeyCode::Esc => Self::Escape,
            KeyCode::Enter => Self::Enter,
            KeyCode::Tab => Self::Tab,
            KeyCode::Backspace => Self::Back,
            KeyCode::Up => Self::Up,
            KeyCode::Down => Self::Down,
            KeyCode::PageUp => Self::PageUp,
            KeyCode::PageDown => Self::PageDown,
            KeyCode::Home => Self::Home,
            KeyCode::End => Self::End,
            KeyCode::Left => Self::Left,
            KeyCode::Right => Self::Right,
            _ => Self::Other,
        }
    }
}

/// Text styles, with colours only where they are wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    pub(crate) title: Style,
    pub(crate) changed: Style,
    pub(crate) dim: Style,
    pub(crate) chosen: Style,
}

impl Look {
    pub(crate) fn new() -> Self {
        let bold = Style::new().add_modifier(Modifier::BOLD);
        let plain = Self {
            title: bold,
            changed: bold,
            dim: Style::new().add_modifier(Modifier::DIM),
            chosen: Style::new().add_modifier(Modifier::REVERSED),
        };
        if hal_output::is_coloured(std::io::stdout()) {
            Self { changed: bold.fg(Color::Yellow), ..plain }
        } else {
            plain
        }
    }
}
