//! `halscope view`: traces in the terminal, with cursors and measurements.

mod paint;
mod state;
#[cfg(test)]
mod tests;
mod wave;

use super::{load, names};
use crate::{
    Stdio, Terminal,
    options::{Opt, options, usage},
    remote::pause,
    screen::{Look, Screen},
};
use state::{Asked, State};
use std::{path::Path, process::ExitCode};

/// How often the keyboard is looked at, in milliseconds.
const LOOK_MS: u32 = 20;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Id {
    Help,
}

const OPTIONS: &[Opt<Id>] =
    &[Opt { help: "print this", long: Some("help"), ..Opt::flag(Id::Help, 'h') }];

/// `halscope view FILE [CHANNEL...]`.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    let (given, rest) = options("halscope", OPTIONS, words).map_err(|e| e.to_string())?;
    if given.iter().any(|(id, _)| *id == Id::Help) {
        let head = "Usage: halscope view FILE [CHANNEL...]\n\noptions:\n";
        Stdio.out(&format!("{head}{}", usage(OPTIONS)));
        return Ok(ExitCode::SUCCESS);
    }
    let (file, patterns) =
        rest.split_first().ok_or("which file? halscope view FILE [CHANNEL...]")?;
    let trace = load(Path::new(file))?;
    let chosen = names::chosen(&trace, patterns, file)?;
    let mut state = State::new(trace, file.clone(), chosen);
    show(&mut state).map_err(|e| e.to_string())?;
    Ok(ExitCode::SUCCESS)
}

fn show(state: &mut State) -> Result<(), crate::Error> {
    let (mut screen, look) = (Screen::new()?, Look::new());
    loop {
        screen.draw(|frame| paint::paint(state, "", &look, frame))?;
        let mut pressed = false;
        while !pressed {
            while let Some(key) = screen.key() {
                pressed = true;
                if state.press(key) == Asked::Leave {
                    return Ok(());
                }
            }
            pause(LOOK_MS);
        }
    }
}
