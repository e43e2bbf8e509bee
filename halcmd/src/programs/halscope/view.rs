//! `halscope view`: traces of a file or of a running machine in the terminal, with cursors and
//! measurements.

mod cursor;
mod paint;
mod state;
#[cfg(test)]
mod tests;
mod wave;

use super::{
    live::{Live, Polled},
    load, names,
    plan::{self, Plan},
};
use crate::{
    Stdio, Terminal,
    session::remote::pause,
    terminal::screen::{Key, Look, Screen},
    terminal::termination::leave_on_signals,
};
use hal_trace::{Format, Trace, trigger::Condition};
use state::{Asked, State, Typed};
use std::{path::Path, process::ExitCode};

/// Interval between two checks of the keyboard, in milliseconds.
const LOOK_MS: u32 = 20;

/// Runs `halscope view FILE [CHANNEL...]` or `halscope view [options] NAME...`.
pub(super) fn main(words: &[String]) -> Result<ExitCode, String> {
    // While the view has the terminal, a signal first closes the view.
    leave_on_signals(1);
    match words.split_first() {
        Some((file, patterns)) if Format::of(Path::new(file)).is_some() => {
            let trace = load(Path::new(file))?;
            let chosen = names::chosen(&trace, patterns, file)?;
            show_file(&mut State::new(trace, file.clone(), chosen))?;
        }
        _ => match Plan::for_view(words)? {
            plan::Asked::Help(text) => Stdio.out(&text)?,
            plan::Asked::Plan(plan) => show_machine(&plan)?,
        },
    }
    Ok(ExitCode::SUCCESS)
}

fn show_file(state: &mut State) -> Result<(), String> {
    let (mut screen, look) = (Screen::new().map_err(|e| e.to_string())?, Look::new());
    loop {
        screen.draw(|frame| paint::paint(state, "", &look, frame)).map_err(|e| e.to_string())?;
        let key = wait(&screen);
        match state.press(key) {
            Asked::Leave => return Ok(()),
            Asked::Other('r' | 's' | 't' | '!') => {
                state.said = "this is a file: there is nothing to trigger".to_owned();
            }
            _ => {}
        }
    }
}

/// Waits for the next key.
fn wait(screen: &Screen) -> Key {
    loop {
        match screen.key() {
            Some(key) => return key,
            None => pause(LOOK_MS),
        }
    }
}

/// State of the captures from a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Doing {
    Runs,
    Once,
    Stopped,
    Over(String),
}

fn show_machine(plan: &Plan) -> Result<(), String> {
    let mut live = Live::begin(plan)?;
    let mut blank = Trace::default();
    for (name, ty) in live.channels() {
        blank.add(name, *ty);
    }
    let chosen = names::chosen(&blank, &[], "the machine")?;
    let title = format!("instance {}", plan.instance.as_deref().unwrap_or("default"));
    let mut state = State::new(blank, title, chosen);
    let mut doing = Doing::Runs;
    let (mut screen, look) = (Screen::new().map_err(|e| e.to_string())?, Look::new());
    loop {
        // Samples are read even while nothing is captured, because a virtual clock waits for its
        // reader.
        if !matches!(doing, Doing::Over(_)) {
            match live.poll()? {
                Polled::Nothing => {}
                Polled::Over(rest, why) => {
                    rest.into_iter().for_each(|trace| state.replace(trace));
                    doing = Doing::Over(why);
                }
                Polled::Whole(trace) => {
                    state.replace(trace);
                    if doing == Doing::Once {
                        live.capture().trigger().disarm();
                        doing = Doing::Stopped;
                    }
                }
            }
        }
        let status = status(&doing, &mut live);
        screen
            .draw(|frame| paint::paint(&mut state, &status, &look, frame))
            .map_err(|e| e.to_string())?;
        let Some(key) = screen.key() else {
            pause(LOOK_MS);
            continue;
        };
        match state.press(key) {
            Asked::Nothing => {}
            Asked::Leave => break,
            Asked::Other(letter) => command(letter, &mut state, &mut live, &mut doing),
            Asked::Trigger(text) => match trigger(&mut live, &text) {
                Ok(()) => doing = Doing::Runs,
                Err(why) => state.said = why,
            },
        }
    }
    drop(screen);
    live.leave_at_once();
    match doing {
        Doing::Over(why) => Err(why),
        Doing::Runs | Doing::Once | Doing::Stopped => Ok(()),
    }
}

fn command(letter: char, state: &mut State, live: &mut Live, doing: &mut Doing) {
    if let Doing::Over(why) = doing {
        state.said.clone_from(why);
        return;
    }
    let capture = live.capture();
    match letter {
        'r' if *doing == Doing::Runs => {
            capture.trigger().disarm();
            *doing = Doing::Stopped;
        }
        'r' => {
            capture.arm();
            *doing = Doing::Runs;
        }
        's' => {
            capture.arm();
            *doing = Doing::Once;
        }
        '!' => {
            if *doing == Doing::Stopped {
                capture.arm();
                *doing = Doing::Once;
            }
            capture.trigger().force();
        }
        't' => state.ask(Typed::Trigger),
        _ => {}
    }
}

/// Sets another trigger. An empty text fires at once.
fn trigger(live: &mut Live, text: &str) -> Result<(), String> {
    let when = if text.trim().is_empty() {
        None
    } else {
        let said = |e: hal_trace::trigger::ConditionError| e.why().to_owned();
        let condition = Condition::parse(text).map_err(said)?;
        Some(condition.bind(live.channels()).map_err(said)?)
    };
    live.capture().arm_for(when);
    Ok(())
}

fn status(doing: &Doing, live: &mut Live) -> String {
    let when = live.capture().trigger().when().map(|w| w.text().to_owned());
    let when = when.map_or_else(|| "at once".to_owned(), |text| format!("when {text}"));
    match doing {
        Doing::Runs => format!("runs, triggers {when}"),
        Doing::Once => format!("waits, triggers {when}"),
        Doing::Stopped => "stopped".to_owned(),
        Doing::Over(why) => format!("over: {why}"),
    }
}
