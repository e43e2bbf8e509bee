//! Plays of the world: what happens at the card's terminals, by cycles of the controller.
//!
//! | line | meaning |
//! |---|---|
//! | `CYCLE input PIN LEVEL` | puts a level on a pin |
//! | `CYCLE field N LEVEL` | switches an input of the field on or off |
//! | `CYCLE turn ENCODER COUNTS` | turns an encoder by so many counts per cycle from then on |
//! | `CYCLE index ENCODER COUNTS` | gives an encoder an index per so many counts |
//! | `CYCLE muxed-turn ENCODER COUNTS`, `CYCLE muxed-index ENCODER COUNTS` | the same for encoders that share lines |
//! | `CYCLE probe ENCODER LEVEL` | sets the probe line of an encoder |
//! | `CYCLE remote PORT.CHANNEL NAME VALUE` | sets process data of a remote, as bits |
//! | `CYCLE cut PORT.CHANNEL LEVEL` | cuts the cable of a remote, or joins it |
//! | `CYCLE lose read`, `CYCLE lose answer`, `CYCLE lose write` | loses the cycle's packet of reads, its answer, or its packet of writes |
//!
//! A cycle is a packet that reads the levels of the I/O pins. What stands at cycle N happens before the Nth of them.

use hal_card::Card;

/// Play with the cycles that are over.
#[derive(Default)]
pub(crate) struct Play {
    scenes: Vec<(u64, Scene)>,
    turns: Vec<(Shaft, i64)>,
    cycle: u64,
    losses: Vec<Loss>,
}

/// Packet of a cycle that is lost.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Loss {
    Read,
    Answer,
    Write,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Shaft {
    Own(usize),
    Muxed(usize),
}

enum Scene {
    Input(usize, bool),
    Field(u8, bool),
    Turn(Shaft, i64),
    Index(Shaft, u32),
    Probe(usize, bool),
    Remote(usize, usize, Box<str>, u64),
    Cut(usize, usize, bool),
    Lose(Loss),
}

/// Error of a line that is no scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BadScene {
    /// Line, from 1.
    pub(crate) line: usize,
}

impl core::fmt::Display for BadScene {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "line {}: not a scene, such as '20 turn 0 25'", self.line)
    }
}

impl Play {
    /// Reads a play.
    pub(crate) fn parse(text: &str) -> Result<Self, BadScene> {
        let mut scenes = Vec::new();
        for (at, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default();
            let words: Vec<&str> = line.split_whitespace().collect();
            if !words.is_empty() {
                scenes.push(scene(&words).ok_or(BadScene { line: at + 1 })?);
            }
        }
        scenes.sort_by_key(|scene| scene.0);
        Ok(Self { scenes, turns: Vec::new(), cycle: 0, losses: Vec::new() })
    }

    /// Plays what comes before the next cycle, and returns its number.
    pub(crate) fn next_cycle(&mut self, card: &mut Card) -> u64 {
        self.cycle += 1;
        self.losses.clear();
        let due = self.scenes.partition_point(|scene| scene.0 <= self.cycle);
        for (_, scene) in self.scenes.drain(..due) {
            match scene {
                Scene::Input(pin, level) => card.set_input(pin, level),
                Scene::Field(input, is_on) => card.set_field_input(input, is_on),
                Scene::Turn(encoder, counts) => {
                    self.turns.retain(|turn| turn.0 != encoder);
                    self.turns.push((encoder, counts));
                }
                Scene::Index(Shaft::Own(encoder), counts) => card.set_index(encoder, counts),
                Scene::Index(Shaft::Muxed(encoder), counts) => {
                    card.set_muxed_index(encoder, counts);
                }
                Scene::Lose(loss) => self.losses.push(loss),
                Scene::Probe(encoder, level) => card.set_probe(encoder, level),
                Scene::Remote(port, channel, name, value) => {
                    let remote = card.remote_mut(port, channel);
                    if !remote.is_some_and(|remote| remote.set(&name, value)) {
                        crate::say(&format!("no remote {port}.{channel} with {name}"));
                    }
                }
                Scene::Cut(port, channel, is_cut) => card.cut(port, channel, is_cut),
            }
        }
        for (encoder, counts) in &self.turns {
            match *encoder {
                Shaft::Own(encoder) => card.turn(encoder, *counts),
                Shaft::Muxed(encoder) => card.turn_muxed(encoder, *counts),
            }
        }
        self.cycle
    }

    /// Returns whether a packet of this cycle is lost.
    pub(crate) fn loses(&self, loss: Loss) -> bool {
        self.losses.contains(&loss)
    }
}

fn scene(words: &[&str]) -> Option<(u64, Scene)> {
    let (cycle, words) = words.split_first()?;
    let level = |word: &str| match word {
        "0" => Some(false),
        "1" => Some(true),
        _ => None,
    };
    let place = |word: &str| {
        let (port, channel) = word.split_once('.')?;
        Some((port.parse().ok()?, channel.parse().ok()?))
    };
    let scene = match words {
        ["input", pin, at] => Scene::Input(pin.parse().ok()?, level(at)?),
        ["field", input, at] => Scene::Field(input.parse().ok()?, level(at)?),
        ["turn", n, counts] => Scene::Turn(Shaft::Own(n.parse().ok()?), counts.parse().ok()?),
        ["index", n, counts] => Scene::Index(Shaft::Own(n.parse().ok()?), counts.parse().ok()?),
        ["muxed-turn", n, counts] => {
            Scene::Turn(Shaft::Muxed(n.parse().ok()?), counts.parse().ok()?)
        }
        ["muxed-index", n, counts] => {
            Scene::Index(Shaft::Muxed(n.parse().ok()?), counts.parse().ok()?)
        }
        ["lose", "read"] => Scene::Lose(Loss::Read),
        ["lose", "answer"] => Scene::Lose(Loss::Answer),
        ["lose", "write"] => Scene::Lose(Loss::Write),
        ["probe", encoder, at] => Scene::Probe(encoder.parse().ok()?, level(at)?),
        ["remote", at, name, value] => {
            let (port, channel) = place(at)?;
            Scene::Remote(port, channel, (*name).into(), value.parse().ok()?)
        }
        ["cut", at, cut] => {
            let (port, channel) = place(at)?;
            Scene::Cut(port, channel, level(cut)?)
        }
        _ => return None,
    };
    Some((cycle.parse().ok()?, scene))
}
