//! Checks of step pulses: the rate that threads can generate, and the reset that ports need.

use super::{Look, finding, protection::is_driver};
use crate::graph::Ix;
use hal_protocol::{Code, Direction};

/// Function that generates the pulses.
const MAKER: &str = "stepgen.make-pulses";

/// Pulse settings of one channel.
struct Pulses {
    /// Name of the channel, such as `stepgen.0`.
    channel: String,
    /// Period of the thread that generates the pulses, in nanoseconds.
    period: f64,
    /// Pulse length and pulse spacing as set, in nanoseconds.
    len: f64,
    space: f64,
    /// Steps per unit, without sign.
    scale: f64,
    /// Requested maximum speed in steps per second. Zero if no limit is set.
    wish: f64,
}

impl Pulses {
    /// Rounds a time up to whole periods, as the channel does.
    fn rounded(&self, ns: f64) -> f64 {
        (ns / self.period).ceil() * self.period
    }

    /// Returns the maximum step rate in steps per second.
    fn most(&self) -> f64 {
        1e9 / (self.rounded(self.len.max(1.0)) + self.rounded(self.space))
    }
}

impl Look<'_> {
    pub(super) fn steps(&mut self) {
        self.ports();
        let Ok(maker) = self.graph.find_funct(MAKER) else { return };
        let Some(thread) = self.graph.threads_of(maker).first().copied() else { return };
        for n in 0..16 {
            let Some(p) = self.pulses(&format!("stepgen.{n}"), thread) else { continue };
            self.too_fast(&p);
            self.double_step(&p, thread);
        }
    }

    fn pulses(&self, channel: &str, thread: Ix) -> Option<Pulses> {
        let of = |name: &str| self.number_of(&format!("{channel}.{name}"));
        let scale = of("position-scale")?.abs();
        Some(Pulses {
            channel: channel.to_owned(),
            period: self.period(thread) as f64,
            len: of("steplen")?,
            space: of("stepspace").unwrap_or(0.0),
            scale,
            wish: of("maxvel")? * scale,
        })
    }

    fn too_fast(&mut self, p: &Pulses) {
        if p.wish.is_nan() || p.wish <= p.most() {
            return;
        }
        let (name, most) = (format!("{}.maxvel", p.channel), p.most());
        let text = format!(
            "'{name}' asks {} for {} steps/s; in periods of {} ns it makes {} at most",
            p.channel,
            short(p.wish),
            short(p.period),
            short(most)
        );
        let periods = (p.rounded(p.len.max(1.0)) + p.rounded(p.space)) / p.period;
        let at = |tail: &str| {
            let (ix, _) = self.item(&format!("{}.{tail}", p.channel))?;
            self.set_at(ix)
        };
        let (own, scale) = (at("maxvel"), at("position-scale"));
        self.add(
            finding(Code::StepsTooFast, &name, text)
                .at(own)
                .remedy(format!(
                    "at most {} units/s here, or a base period of at most {} ns",
                    short(most / p.scale),
                    short((1e9 / p.wish / periods).floor())
                ))
                .related(scale, format!("{} steps per unit", short(p.scale))),
        );
    }

    /// Reports a channel without a gap between pulses, if the port does not reset its step pin.
    fn double_step(&mut self, p: &Pulses, thread: Ix) {
        let Some((space, _)) = self.item(&format!("{}.stepspace", p.channel)) else { return };
        if p.space != 0.0 {
            return;
        }
        let step = ["step", "up"].iter().find_map(|s| self.item(&format!("{}.{s}", p.channel)));
        let Some(signal) = step.and_then(|(ix, _)| self.graph.signal_of(ix)) else { return };
        let (_, readers) = self.ends(signal);
        for pin in readers {
            let owner = self.graph.owner(pin);
            if !owner.is_some_and(is_driver) {
                continue;
            }
            let name = self.graph.item(pin).map_or("", |i| i.name.as_str());
            // The name of a line may have dots: hal_gpio.gpiochip0.17-out.
            let ports = name.rmatch_indices('.').filter_map(|(at, _)| name.get(..at));
            let resets = ports
                .map(|port| format!("{port}.reset"))
                .find_map(|reset| self.graph.funct_named(&reset).map(|ix| (ix, reset)));
            let at = self.set_at(space).or_else(|| self.loaded_at(space));
            let marked = self.number_of(&format!("{name}-reset"));
            match (resets, marked) {
                (Some((reset, reset_name)), Some(marked)) => {
                    let runs = self.graph.threads_of(reset).contains(&thread);
                    if runs && marked == 0.0 {
                        self.unmarked(p, name, pin);
                    } else if !runs && marked == 0.0 {
                        self.no_reset(p, at, Some(reset_name), name);
                    }
                }
                _ => self.no_reset(p, at, None, name),
            }
        }
    }

    fn unmarked(&mut self, p: &Pulses, pin: &str, ix: Ix) {
        let text = format!(
            "{} makes double steps (stepspace 0), and '{pin}-reset' is FALSE: its pulses merge",
            p.channel
        );
        let at = self.linked_at(ix);
        self.add(
            finding(Code::ResetUnmarked, pin, text)
                .at(at)
                .remedy(format!("setp {pin}-reset 1, or setp {}.stepspace 1", p.channel)),
        );
    }

    fn no_reset(
        &mut self,
        p: &Pulses,
        at: Option<hal_protocol::At>,
        reset: Option<String>,
        pin: &str,
    ) {
        // Up to this rate there is a gap between pulses: each step then takes at least twice the
        // pulse length.
        let apart = 1e9 / (2.0 * p.rounded(p.len.max(1.0)));
        let code = if p.wish > apart { Code::StepsMerge } else { Code::DoubleStep };
        let text = format!(
            "{} makes double steps (stepspace 0), and nothing resets '{pin}': above {} steps/s its \
             pulses merge",
            p.channel,
            short(apart)
        );
        let fix = reset.map_or_else(String::new, |r| {
            format!("addf {r} after the port's write and setp {pin}-reset 1, or ")
        });
        let name = format!("{}.stepspace", p.channel);
        self.add(
            finding(code, &name, text)
                .at(at)
                .remedy(format!("{fix}setp {}.stepspace 1", p.channel)),
        );
    }

    /// Reports ports with pins marked for reset whose reset function does not run, or runs too
    /// late.
    fn ports(&mut self) {
        for (_, reset) in self.graph.funct_names() {
            let Some(port) = self.funct_name(reset).strip_suffix(".reset") else { continue };
            let Some(owner) = self.graph.owner_of(reset) else { continue };
            if !self.graph.component(owner).is_some_and(is_driver) {
                continue;
            }
            let marked: Vec<Ix> = self
                .items
                .iter()
                .filter(|(_, i)| i.name.as_str().starts_with(port) && i.direction == Direction::Rw)
                .filter(|(ix, i)| {
                    i.name.as_str().ends_with("-out-reset") && self.number(*ix) == Some(1.0)
                })
                .map(|(ix, _)| *ix)
                .collect();
            let threads = self.graph.threads_of(reset);
            // The second name is that of `hal_gpio`.
            let mut times = ["reset-time", "reset_ns"].iter();
            let time = times.find_map(|name| self.item(&format!("{port}.{name}")));
            let (Some(first), Some(time)) = (marked.first().copied(), time) else { continue };
            let at = self.set_at(first).or_else(|| self.loaded_at(first));
            let name = self.funct_name(reset);
            if threads.is_empty() {
                let text = format!("'{}' is set, and no thread runs '{name}'", self.shown(first));
                self.add(
                    finding(Code::ResetNotRun, name, text)
                        .at(at)
                        .remedy(format!("addf {name} THREAD, after {port}.write")),
                );
                continue;
            }
            let ns = self.number(time.0).unwrap_or(0.0);
            let quarter = threads.iter().map(|t| self.period(*t)).min().unwrap_or(0) as f64 / 4.0;
            if ns <= quarter {
                continue;
            }
            let time_name = time.1.shown().as_str();
            let text = format!(
                "'{time_name}' is {} ns, more than a quarter of the period: it becomes {}",
                short(ns),
                short(quarter)
            );
            let at = self.set_at(time.0);
            self.add(
                finding(Code::ResetLate, time_name, text)
                    .at(at)
                    .remedy("set less, or make the base period longer"),
            );
        }
    }
}

/// Formats a number without needless digits.
fn short(x: f64) -> String {
    if x.abs() >= 100.0 { format!("{x:.0}") } else { format!("{}", (x * 1000.0).round() / 1000.0) }
}
