//! Realtime. The world around a simulated card as pins: what is connected to its terminals, and what a meter would read there.

mod plugged;
mod remotes;

use self::remotes::RemoteWorld;
use crate::{making::Making, simulated::SimulatedCard};
use hal_card::{Card, Rates};
use hal_component::{Error, In, Out, ParamRw, Touch, Uses};
use hal_firmware::Tag;
use std::sync::Arc;

/// Pins of the world around one card.
#[derive(Clone, Touch)]
pub(crate) struct World {
    #[state]
    card: Arc<SimulatedCard>,
    terminals: Vec<Terminal>,
    scanned: Vec<In<bool>>,
    encoders: Vec<Turning>,
    steps: Vec<Out<f64>>,
    emitted: Vec<Out<f64>>,
    duties: Vec<Out<f64>>,
    relays: Vec<Closed>,
    lights: Vec<Out<bool>>,
    remotes: Vec<RemoteWorld>,
    watchdog: Out<bool>,
    line: LinePins,
}

/// Level outside of one I/O pin, and level at it.
#[derive(Clone)]
struct Terminal {
    pin: usize,
    outside: Option<In<bool>>,
    level: Out<bool>,
    /// True for an input that is active at a low level.
    active_low: bool,
}

impl Touch for Terminal {
    fn touch(&self, uses: &mut Uses) {
        self.outside.touch(uses);
        self.level.touch(uses);
    }
}

/// Encoder on a counter's inputs.
#[derive(Clone)]
struct Turning {
    encoder: usize,
    is_muxed: bool,
    counts: In<i32>,
    position: In<f64>,
    scale: ParamRw<f64>,
    turn: In<u32>,
}

impl Touch for Turning {
    fn touch(&self, uses: &mut Uses) {
        self.counts.touch(uses);
        self.position.touch(uses);
        self.scale.touch(uses);
        self.turn.touch(uses);
    }
}

impl Turning {
    /// Returns the place in counts.
    fn place(&self) -> i64 {
        let place = libm::floor(self.position.get() * self.scale.get() + 0.5);
        // A position beyond 1e15 counts, or NaN, counts as 0.
        let place = if place.abs() < 1e15 { whole(place) } else { 0 };
        i64::from(self.counts.get()).wrapping_add(place)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "it is a whole number within the range")]
const fn whole(x: f64) -> i64 {
    x as i64
}

/// Relay with its number.
#[derive(Clone)]
struct Closed {
    relay: u8,
    closed: Out<bool>,
}

impl Touch for Closed {
    fn touch(&self, uses: &mut Uses) {
        self.closed.touch(uses);
    }
}

/// Faults of the line to the card.
#[derive(Clone, Touch)]
struct LinePins {
    plugged: In<bool>,
    lost: In<u32>,
    late: In<u32>,
    doubled: In<u32>,
    cut: In<u32>,
}

impl World {
    /// Gives the card what is outside of it, before it is asked.
    pub(crate) fn enter(&self) {
        // A card that another thread has is served by that thread.
        let _ = self.card.with(|inside| {
            let rates = Rates {
                lost: self.line.lost.get(),
                late: self.line.late.get(),
                doubled: self.line.doubled.get(),
                cut: self.line.cut.get(),
            };
            inside.set_line(rates, self.line.plugged.get());
            self.put_in(&mut inside.card);
        });
    }

    fn put_in(&self, card: &mut Card) {
        for terminal in &self.terminals {
            if let Some(outside) = terminal.outside {
                card.set_input(terminal.pin, outside.get() != terminal.active_low);
            }
        }
        for (input, level) in (0..).zip(&self.scanned) {
            card.set_field_input(input, level.get());
        }
        for remote in &self.remotes {
            remote.put_in(card);
        }
        for turning in &self.encoders {
            let (counts, turn) = (turning.place(), turning.turn.get());
            if turning.is_muxed {
                card.set_muxed_index(turning.encoder, turn);
                card.set_muxed_counts(turning.encoder, counts);
            } else {
                card.set_index(turning.encoder, turn);
                card.set_counts(turning.encoder, counts);
            }
        }
    }

    /// Shows what a meter would read at the card.
    pub(crate) fn show(&self) {
        // As in `enter`.
        let _ = self.card.with(|inside| self.put_out(&inside.card));
    }

    fn put_out(&self, card: &Card) {
        for terminal in &self.terminals {
            terminal.level.set(card.level(terminal.pin));
        }
        for (n, steps) in self.steps.iter().enumerate() {
            steps.set(card.steps(n).unwrap_or(0.0));
        }
        for (n, emitted) in self.emitted.iter().enumerate() {
            emitted.set(card.emitted_steps(n).unwrap_or(0) as f64);
        }
        for (n, duty) in self.duties.iter().enumerate() {
            let enabled = card.is_pulse_enabled(n) && !card.watchdog_has_bitten();
            duty.set(if enabled { card.duty(n).unwrap_or(0.0) } else { 0.0 });
        }
        for relay in &self.relays {
            relay.closed.set(card.relay(relay.relay));
        }
        for (n, light) in (0..8).zip(&self.lights) {
            // The first light is the highest bit.
            light.set(card.light(7 - n));
        }
        for remote in &self.remotes {
            remote.put_out(card);
        }
        self.watchdog.set(card.watchdog_has_bitten());
    }
}

/// Creates the pins of the world around a simulated card.
pub(crate) fn make(m: &mut Making<'_, '_>, card: &Arc<SimulatedCard>) -> Result<World, Error> {
    let levels = card.with(|inside| {
        (0..m.card.pins.len()).map(|pin| inside.card.level(pin)).collect::<Vec<_>>()
    });
    let levels = levels.unwrap_or_default();
    let mut terminals = Vec::new();
    for (pin, level) in levels.into_iter().enumerate() {
        let own = m.card.pins.get(pin).copied();
        // An encoder's lines follow its counts.
        let is_turned = own.is_some_and(|own| {
            matches!(own.kind(), Some(Tag::Encoder | Tag::MuxedEncoder)) && own.number <= 3
        });
        let active_low = own.is_some_and(|own| own.kind() == Some(Tag::Inputs));
        let about = if active_low {
            "True while the input is active"
        } else {
            "Level that is connected to the I/O pin from outside"
        };
        let level = level && !active_low;
        let name = match own.filter(|_| active_low) {
            Some(own) => {
                let input = own.number.saturating_sub(1);
                m.at(&format!("sim.inm.{:02}.in-{input:02}", own.instance))
            }
            None => m.at(&format!("sim.in-{pin:03}")),
        };
        let outside = if is_turned { None } else { Some(m.b.simulated(&name, about, level)?) };
        let about = "Level that a meter reads at the I/O pin";
        let name = m.at(&format!("sim.out-{pin:03}"));
        let level = m.b.simulated(&name, about, level)?;
        terminals.push(Terminal { pin, outside, level, active_low });
    }
    let world = World {
        card: Arc::clone(card),
        terminals,
        scanned: scanned(m)?,
        encoders: encoders(m)?,
        steps: outputs(
            m,
            Tag::StepGenerator,
            "stepgen",
            "steps",
            "Steps of the generator, with their fraction",
        )?,
        emitted: outputs(
            m,
            Tag::StepGenerator,
            "stepgen",
            "emitted",
            "Steps that have left the card: none while its I/O pins are inputs",
        )?,
        duties: outputs(
            m,
            Tag::Pwm,
            "pwmgen",
            "duty",
            "Duty at the output, -1 to 1; 0 while it is disabled",
        )?,
        relays: relays(m)?,
        lights: lights(m)?,
        remotes: plugged::make(m)?,
        watchdog: {
            let name = m.at("sim.watchdog-bitten");
            m.b.simulated(&name, "True once the watchdog has bitten", false)?
        },
        line: line(m)?,
    };
    Ok(world)
}

fn scanned(m: &mut Making<'_, '_>) -> Result<Vec<In<bool>>, Error> {
    let Some((module, _)) = m.module(Tag::InputMux) else { return Ok(Vec::new()) };
    let width = (m.peek(&module, hal_firmware::registers::INMUX_CONTROL, 0)? & 0x1F) + 1;
    let about = "True while the scanned input is active";
    let pins = (0..width).map(|n| {
        let name = m.at(&format!("sim.inmux.00.in-{n:02}"));
        m.b.simulated(&name, about, false)
    });
    pins.collect()
}

fn encoders(m: &mut Making<'_, '_>) -> Result<Vec<Turning>, Error> {
    let mut encoders = Vec::new();
    for (tag, is_muxed) in [(Tag::Encoder, false), (Tag::MuxedEncoder, true)] {
        let used = m.module(tag).map_or(0, |(_, used)| used);
        for n in 0..usize::from(used) {
            let counts = m.at(&format!("sim.encoder.{n:02}.counts"));
            let position = m.at(&format!("sim.encoder.{n:02}.position"));
            let turn = m.at(&format!("sim.encoder.{n:02}.counts-per-index"));
            let Some(scale) = m.encoder_scales.get(n).copied() else { continue };
            encoders.push(Turning {
                encoder: n,
                is_muxed,
                counts: m.b.simulated(&counts, "Place of the encoder, in counts", 0)?,
                position: m.b.simulated(
                    &position,
                    "Place beyond the counts, in units of the scale",
                    0.0,
                )?,
                scale,
                turn: m.b.simulated(&turn, "Counts from one index to the next; 0 for none", 0)?,
            });
        }
    }
    Ok(encoders)
}

fn outputs(
    m: &mut Making<'_, '_>,
    tag: Tag,
    kind: &str,
    pin: &str,
    about: &str,
) -> Result<Vec<Out<f64>>, Error> {
    let used = m.module(tag).map_or(0, |(_, used)| used);
    let pins = (0..used).map(|n| {
        let name = m.at(&format!("sim.{kind}.{n:02}.{pin}"));
        m.b.simulated(&name, about, 0.0)
    });
    pins.collect()
}

fn relays(m: &mut Making<'_, '_>) -> Result<Vec<Closed>, Error> {
    if m.module(Tag::Ssr).is_none() {
        return Ok(Vec::new());
    }
    let mut relays = Vec::new();
    for relay in m.outputs(Tag::Ssr, 0, 31) {
        let name = m.at(&format!("sim.ssr.00.closed-{relay:02}"));
        let closed = m.b.simulated(&name, "True while the relay is closed", false)?;
        relays.push(Closed { relay, closed });
    }
    Ok(relays)
}

fn lights(m: &mut Making<'_, '_>) -> Result<Vec<Out<bool>>, Error> {
    let used = m.module(Tag::Led).map_or(0, |(_, used)| used);
    let pins = (1..=used).map(|n| {
        let name = m.at(&format!("sim.led.CR{n:02}"));
        m.b.simulated(&name, "True while the light is on", false)
    });
    pins.collect()
}

fn line(m: &mut Making<'_, '_>) -> Result<LinePins, Error> {
    let plugged = m.at("sim.line.plugged");
    let plugged = m.b.simulated(&plugged, "True while the cable is plugged in", true)?;
    let mut rate = |name: &str, what: &str| {
        let about = format!("Packets per million that {what}");
        let name = m.at(&format!("sim.line.{name}"));
        m.b.simulated(&name, &about, 0)
    };
    Ok(LinePins {
        plugged,
        lost: rate("lost", "are lost")?,
        late: rate("late", "come behind the next one")?,
        doubled: rate("doubled", "come twice")?,
        cut: rate("cut", "come without their end")?,
    })
}
