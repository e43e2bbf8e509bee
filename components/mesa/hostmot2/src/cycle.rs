//! Realtime. The functions of a card: one packet of reads and one of writes a cycle.

use crate::{
    link::{Link, Outcome, Renewals},
    making::Making,
    module::{Cycle, Reads, Writes},
    world::World,
};
use core::time::Duration;
use hal_component::{Hardware, Io, Messages, Out, ParamRo, ParamRw, Period, Touch, Update, pins};
use hal_lbp16::MAX_PACKET;
use std::sync::Arc;

/// Shortest wait for an answer.
const LEAST_WAIT: Duration = Duration::from_micros(100);

pins! {
    /// State of the way to the card.
    pub(crate) struct Health {
        /// TRUE in a cycle without an answer in time, or in which the card had missed a packet.
        error: Out<bool> = "packet-error", false;
        /// Level of errors: each adds `packet-error-increment`, each good cycle takes `packet-error-decrement`.
        level: Out<i32> = "packet-error-level", 0;
        /// TRUE once the level has reached `packet-error-limit`: the card is abandoned until `io_error` is set to FALSE.
        exceeded: Out<bool> = "packet-error-exceeded", false;
        /// Packets without a good answer so far.
        total: Io<u32> = "packet-error-total", 0;
        /// Time from a question to its answer, in nanoseconds; 0 on the virtual clock.
        round_trip: Out<u32> = "packet-round-trip", 0;
        /// Of this, time in which the thread waited, in nanoseconds.
        waited: Out<u32> = "packet-wait", 0;
        /// Added to the level by an error.
        increment: ParamRw<i32> = "packet-error-increment", 2;
        /// Taken from the level by a good cycle.
        decrement: ParamRo<i32> = "packet-error-decrement", 1;
        /// Level at which the card is abandoned.
        limit: ParamRw<i32> = "packet-error-limit", 10;
        /// Longest wait for an answer: up to 0 for 80 % of the period, below 100 in percent of it, else in nanoseconds.
        timeout: ParamRw<i32> = "packet-read-timeout", 80;
        /// TRUE once the card was abandoned. Setting it to FALSE begins again.
        io_error: ParamRw<bool> = "io_error", false;
    }
}

/// Function `read`.
#[derive(Touch)]
pub(crate) struct Read {
    #[state]
    pub(crate) link: Arc<Link>,
    pub(crate) health: Health,
    pub(crate) parts: Vec<Box<dyn Reads>>,
    /// Present around a simulated card.
    pub(crate) world: Option<World>,
    #[state]
    pub(crate) renewals: Renewals,
    pub(crate) messages: Messages,
    /// The card: failed while it is abandoned.
    pub(crate) hardware: Hardware,
    /// Messages, with the card's name.
    #[state]
    pub(crate) says: ReadSays,
    #[state]
    pub(crate) state: ReadState,
}

/// Messages of the function `read`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadSays {
    late: &'static str,
    missed: &'static str,
    failed: &'static str,
    given_up: &'static str,
}

impl ReadSays {
    /// Makes them for a card.
    pub(crate) fn of(making: &Making<'_, '_>) -> Self {
        let [late, missed, failed, given_up] =
            [LATE, MISSED, FAILED, GIVEN_UP].map(|text| making.says(text));
        Self { late, missed, failed, given_up }
    }
}

/// State of the function `read` between cycles.
#[derive(Debug, Default)]
pub(crate) struct ReadState {
    level: i32,
    /// True from the first answer on.
    began: bool,
    was_abandoned: bool,
    /// True while errors of this row have been reported.
    reported: bool,
}

const LATE: &str = "no answer in packet-read-timeout (receiving): its inputs keep their values";
const MISSED: &str =
    "the card had missed the last packet of writes (sending): all is written again";
const FAILED: &str =
    "the network reports error {} in place of an answer: its inputs keep their values";
const GIVEN_UP: &str = "packet-error-level has reached packet-error-limit: the card is abandoned \
(io_error), and its watchdog makes all its outputs inputs; when the cause is known, set io_error to 0 \
to begin again";

impl Update for Read {
    fn update(&mut self, period: Period) {
        if let Some(world) = &self.world {
            world.enter();
        }
        self.cycle(period);
        if let Some(world) = &self.world {
            world.show();
        }
    }
}

impl Read {
    fn cycle(&mut self, period: Period) {
        if self.health.io_error.get() {
            self.link.pass();
            self.hardware.note(true);
            self.state.was_abandoned = true;
            return;
        }
        self.hardware.note(false);
        if core::mem::take(&mut self.state.was_abandoned) {
            self.begin_again();
        }
        let cycle = Cycle { period: period.secs() };
        let within = self.timeout(period);
        let mut answer = [0; MAX_PACKET];
        let link = Arc::clone(&self.link);
        match link.answer(&mut answer, within) {
            Outcome::Answered { answer, written, times } => {
                self.health.round_trip.set(times.round_trip);
                self.health.waited.set(times.waited);
                let began = core::mem::replace(&mut self.state.began, true);
                for part in &mut self.parts {
                    part.read(answer, cycle, written);
                }
                // What was missed before a new beginning is no new error.
                if written || !began {
                    self.good();
                } else {
                    self.bad(self.says.missed, &[]);
                }
            }
            Outcome::Late => self.bad(self.says.late, &[]),
            Outcome::Lost(lost) => self.bad(self.says.failed, &[f64::from(lost.0)]),
        }
    }

    fn timeout(&self, period: Period) -> Duration {
        let period = u64::try_from(period.ns()).unwrap_or(0);
        let within = match self.health.timeout.get() {
            ..=0 => period / 100 * 80,
            percent @ 1..=99 => period / 100 * u64::from(percent.unsigned_abs()),
            ns => u64::from(ns.unsigned_abs()),
        };
        Duration::from_nanos(within).max(LEAST_WAIT)
    }

    fn good(&mut self) {
        self.state.reported = false;
        self.health.error.set(false);
        let level = self.state.level.saturating_sub(self.health.decrement.get().max(0)).max(0);
        self.state.level = level;
        self.health.level.set(level);
    }

    fn bad(&mut self, text: &'static str, error: &[f64]) {
        // What was lost is not known: all is written again.
        self.renewals.renew();
        self.health.error.set(true);
        self.health.total.set(self.health.total.get().wrapping_add(1));
        if !core::mem::replace(&mut self.state.reported, true) {
            self.messages.warn(text, error);
        }
        let limit = self.health.limit.get();
        let level =
            self.state.level.saturating_add(self.health.increment.get().max(0)).min(limit.max(0));
        self.state.level = level;
        self.health.level.set(level);
        if level >= limit {
            self.health.exceeded.set(true);
            self.health.io_error.set(true);
            self.hardware.note(true);
            self.messages.error(self.says.given_up, &[]);
        }
    }

    fn begin_again(&mut self) {
        self.renewals.renew();
        self.state = ReadState::default();
        self.health.exceeded.set(false);
        self.health.level.set(0);
        self.health.error.set(false);
    }
}

/// Function `read-request`.
#[derive(Touch)]
pub(crate) struct EarlyQuestion {
    #[state]
    pub(crate) link: Arc<Link>,
    pub(crate) io_error: ParamRw<bool>,
}

impl Update for EarlyQuestion {
    fn update(&mut self, _: Period) {
        if !self.io_error.get() {
            // A way that fails is reported by `read`, which tries again.
            let _ = self.link.ask();
        }
    }
}

/// Function `write`.
#[derive(Touch)]
pub(crate) struct Write {
    #[state]
    pub(crate) link: Arc<Link>,
    pub(crate) io_error: ParamRw<bool>,
    pub(crate) parts: Vec<Box<dyn Writes>>,
    /// Present around a simulated card.
    pub(crate) world: Option<World>,
    pub(crate) messages: Messages,
    /// Message about a packet that the network does not take.
    #[state]
    pub(crate) unsent: &'static str,
    #[state]
    pub(crate) reported: bool,
}

impl Update for Write {
    fn update(&mut self, period: Period) {
        if self.io_error.get() {
            return;
        }
        let cycle = Cycle { period: period.secs() };
        let link = Arc::clone(&self.link);
        let mut to = link.begin();
        for part in &mut self.parts {
            part.write(&mut to, cycle);
        }
        match to.end() {
            Ok(()) => self.reported = false,
            Err(lost) if !core::mem::replace(&mut self.reported, true) => {
                self.messages.warn(self.unsent, &[f64::from(lost.0)]);
            }
            Err(_) => {}
        }
        if let Some(world) = &self.world {
            world.show();
        }
    }
}

/// Text of [`Write::unsent`].
pub(crate) const UNSENT: &str =
    "the network does not take the packet of writes (error {}); it is tried again";
