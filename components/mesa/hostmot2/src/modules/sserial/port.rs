//! Realtime. A running port: one step a cycle.
//!
//! | from | by | to |
//! |---|---|---|
//! | off | `run` is TRUE | stops, sends parameters, starts, runs |
//! | runs | too many faults | stops, then failed |
//! | runs, failed | `run` is FALSE | off |

use super::{
    data::{Word, low},
    parts::{Exchanged, PortPins, Remote, Seen},
    settings::RemoteSetting,
    talk::{Addresses, CHANNELS, EXCHANGE, START, START_SETUP, STOP_ALL},
};
use crate::{link::Outgoing, module::Cycle};
use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use hal_component::{Gives, Hardware, Messages, Out, Takes, Touch};

/// Longest time that a command may take, in seconds: remotes that have just got power answer late.
const LONGEST: f64 = 2.0;

/// Status of a channel: the remote's watchdog has bitten, and its outputs are off.
const BITTEN: u32 = 1 << 24;
/// Status of a channel: no remote answers, or not in time.
const SILENT: u32 = 0x4000 | 0x08;

/// Command under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PortStep {
    Stop,
    /// Stop after a fault.
    GiveUp,
    Start,
    Setup(usize),
    Order(usize, u8),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PortPhase {
    Off,
    Does(PortStep),
    Runs,
    Failed,
}

/// News since the last cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum News {
    /// No answer came.
    None,
    /// The card had not received the last packet of writes.
    Missed,
    /// The processor's command and data registers.
    Came { command: u32, faults: u32 },
}

/// Half of a port that writes.
#[derive(Touch)]
pub(crate) struct Port {
    pub(crate) pins: PortPins,
    pub(crate) remotes: Vec<Remote>,
    pub(crate) settings: Vec<RemoteSetting>,
    pub(crate) seen: Takes<Seen>,
    pub(crate) exchanged: Gives<Exchanged>,
    /// Failed while the port was stopped by faults.
    pub(crate) hardware: Hardware,
    pub(crate) messages: Messages,
    pub(crate) exchanges: Out<i32>,
    #[state]
    pub(crate) at: Addresses,
    /// Message about a command that has no end.
    #[state]
    pub(crate) unfinished: &'static str,
    #[state]
    pub(crate) state: PortState,
}

/// Memory of a port.
pub(crate) struct PortState {
    phase: PortPhase,
    answers: u32,
    missed: u32,
    /// Time that the command under way has taken.
    waited: f64,
    /// True once an answer has shown that the card has received the command.
    is_received: bool,
    /// True if an answer was missing before that: the command may be finished, or may never have come.
    is_unsure: bool,
    /// Number of the present start.
    start: u32,
    /// True if the last cycle had an exchange.
    exchanged: bool,
    level: u32,
    exchanges: i32,
}

impl PortState {
    pub(crate) const fn new() -> Self {
        Self {
            phase: PortPhase::Off,
            answers: 0,
            missed: 0,
            waited: 0.0,
            is_received: false,
            is_unsure: false,
            start: 0,
            exchanged: false,
            level: 0,
            exchanges: 0,
        }
    }
}

impl Port {
    /// Runs one cycle.
    pub(crate) fn write(&mut self, to: &mut Outgoing<'_>, cycle: Cycle) {
        let news = self.news();
        let before = core::mem::take(&mut self.state.exchanged);
        match self.state.phase {
            PortPhase::Off if self.pins.run.get() => self.begin(PortStep::Stop, to),
            PortPhase::Failed if !self.pins.run.get() => {
                self.hardware.note(false);
                self.begin(PortStep::Stop, to);
            }
            PortPhase::Off | PortPhase::Failed => {}
            PortPhase::Does(step) => self.follow(step, news, to, cycle),
            PortPhase::Runs if !self.pins.run.get() => self.begin(PortStep::Stop, to),
            PortPhase::Runs => self.exchange(news, before, to),
        }
        let start = if self.state.exchanged { self.state.start } else { 0 };
        self.exchanged.store(start, Release); // Pairs with Acquire in the half that reads.
        self.show();
    }

    fn show(&self) {
        self.pins.state.set(match self.state.phase {
            PortPhase::Off => 0,
            PortPhase::Does(PortStep::Stop | PortStep::GiveUp) => 1,
            PortPhase::Does(PortStep::Start) => 2,
            PortPhase::Runs => 3,
            PortPhase::Failed => 4,
            PortPhase::Does(PortStep::Setup(_) | PortStep::Order(..)) => 7,
        });
        self.pins.level.set(self.state.level);
        self.exchanges.set(self.state.exchanges);
    }

    fn news(&mut self) -> News {
        let answers = self.seen.answers.load(Acquire); // Pairs with Release in the half that reads.
        let missed = self.seen.missed.load(Relaxed); // Published with `answers`.
        let was_missed = core::mem::replace(&mut self.state.missed, missed) != missed;
        if core::mem::replace(&mut self.state.answers, answers) == answers {
            return News::None;
        }
        if was_missed {
            return News::Missed;
        }
        let command = self.seen.command.load(Relaxed); // Published with `answers`.
        self.pins.command.set(command);
        News::Came { command, faults: self.seen.data.load(Relaxed) } // Published with `answers`.
    }

    /// Returns the channels of all remotes, one bit each.
    fn mask(&self) -> u32 {
        self.remotes.iter().fold(0, |mask, remote| mask | 1 << remote.channel)
    }

    fn begin(&mut self, step: PortStep, to: &mut Outgoing<'_>) {
        self.state.phase = PortPhase::Does(step);
        self.state.waited = 0.0;
        self.send(step, to);
    }

    /// Writes the registers of a step.
    fn send(&mut self, step: PortStep, to: &mut Outgoing<'_>) {
        (self.state.is_received, self.state.is_unsure) = (false, false);
        let at = self.at;
        let command = match step {
            PortStep::Stop | PortStep::GiveUp => STOP_ALL,
            PortStep::Start => {
                for remote in &self.remotes {
                    put(to, &at.status, remote.channel, u32::from(remote.mode) << 24);
                }
                START | self.mask()
            }
            PortStep::Setup(nth) => {
                let channel = self.settings.get(nth).map_or(0, |setting| setting.channel);
                let remote = self.remotes.iter().find(|remote| remote.channel == channel);
                let mode = remote.map_or(0, |remote| remote.mode);
                put(to, &at.status, channel, u32::from(mode) << 24);
                START_SETUP | 1 << channel
            }
            PortStep::Order(nth, number) => {
                let Some(setting) = self.settings.get_mut(nth) else { return };
                let Some((order, argument)) = setting.order(number) else { return };
                let [user, ..] = &at.user;
                put(to, &at.status, setting.channel, order);
                put(to, user, setting.channel, argument);
                EXCHANGE | 1 << setting.channel
            }
        };
        to.put(at.command, command);
    }

    /// Waits for the end of a step, and goes on to the next one.
    fn follow(&mut self, step: PortStep, news: News, to: &mut Outgoing<'_>, cycle: Cycle) {
        self.state.waited += cycle.period;
        match news {
            News::Missed => self.send(step, to),
            News::Came { command: 0, .. } if self.state.is_unsure => self.send(step, to),
            News::Came { command: 0, faults } => self.finish(step, faults, to),
            News::Came { command, .. } if self.state.waited > LONGEST => {
                // The failure that it follows was reported.
                if step == PortStep::GiveUp {
                    self.state.phase = PortPhase::Failed;
                } else {
                    self.messages.error(self.unfinished, &[f64::from(command)]);
                    self.fail(to);
                }
            }
            News::None => self.state.is_unsure = !self.state.is_received,
            News::Came { .. } => self.state.is_received = true,
        }
    }

    fn finish(&mut self, step: PortStep, faults: u32, to: &mut Outgoing<'_>) {
        match step {
            PortStep::GiveUp => self.state.phase = PortPhase::Failed,
            PortStep::Stop => match self.settings.iter().position(RemoteSetting::is_new) {
                Some(nth) => self.begin(PortStep::Setup(nth), to),
                None if self.pins.run.get() => self.begin(PortStep::Start, to),
                None => self.state.phase = PortPhase::Off,
            },
            PortStep::Start if faults & self.mask() != 0 => {
                self.report(faults);
                self.fail(to);
            }
            PortStep::Start => {
                self.state.start = self.state.start.wrapping_add(1).max(1);
                self.state.level = 0;
                self.report(0);
                self.state.phase = PortPhase::Runs;
                self.put_data(to, true);
            }
            PortStep::Setup(nth) => self.next_order(nth, None, faults, to),
            PortStep::Order(nth, number) => self.next_order(nth, Some(number), faults, to),
        }
    }

    /// Sends the next command for a parameter; after the last one, and if the remote takes none, the port is stopped again.
    fn next_order(&mut self, nth: usize, done: Option<u8>, faults: u32, to: &mut Outgoing<'_>) {
        let Some(setting) = self.settings.get_mut(nth) else {
            return self.begin(PortStep::Stop, to);
        };
        let (channel, next) = (setting.channel, done.map_or(0, |number| number + 1));
        let refused = faults >> channel & 1 == 1;
        // The value counts as sent also if the remote refuses it, so that it is not sent again and again.
        let order = setting.order(next);
        if !refused && order.is_some() {
            return self.begin(PortStep::Order(nth, next), to);
        }
        setting.done();
        let remote = self.remotes.iter().find(|remote| remote.channel == channel);
        if let Some(remote) = remote.filter(|_| refused) {
            self.messages.warn(remote.texts.setting, &[]);
        }
        self.begin(PortStep::Stop, to);
    }

    /// Judges the last exchange, and begins the next one.
    fn exchange(&mut self, news: News, before: bool, to: &mut Outgoing<'_>) {
        match news {
            // The last exchange may not be finished, and a command must not disturb it.
            News::None => self.put_data(to, false),
            News::Missed => self.put_data(to, true),
            News::Came { command: 0, faults } => {
                let faults = if before { faults & self.mask() } else { 0 };
                self.report(faults);
                if self.count(faults != 0) {
                    self.fail(to);
                } else {
                    self.put_data(to, true);
                }
            }
            News::Came { command, .. } => {
                if self.count(true) {
                    self.messages.error(self.unfinished, &[f64::from(command)]);
                    self.fail(to);
                } else {
                    self.put_data(to, false);
                }
            }
        }
    }

    /// Counts a cycle with or without faults. Returns whether there are too many.
    fn count(&mut self, failed: bool) -> bool {
        let added = if failed { self.pins.increment.get() } else { 0 };
        let raised = self.state.level.saturating_add(added);
        self.state.level = raised.saturating_sub(self.pins.decrement.get());
        failed && added > 0 && raised >= self.pins.limit.get()
    }

    /// Shows and reports which remotes failed in the last exchange.
    fn report(&mut self, faults: u32) {
        self.pins.failing.set(faults);
        for remote in &mut self.remotes {
            let failed = faults >> remote.channel & 1 == 1;
            remote.fault.set(failed);
            if failed && !core::mem::replace(&mut remote.reported, true) {
                let status = self.seen.status.get(remote.channel);
                let status = status.map_or(0, |status| status.load(Relaxed)); // Published with `answers`.
                let text = if status & BITTEN != 0 {
                    remote.texts.bitten
                } else if status & SILENT != 0 {
                    remote.texts.silent
                } else {
                    remote.texts.fault
                };
                self.messages.warn(text, &[f64::from(status)]);
            }
            remote.reported &= failed;
        }
    }

    /// Stops the port because of faults, and notes that hardware has failed.
    fn fail(&mut self, to: &mut Outgoing<'_>) {
        self.hardware.note(true);
        let failing = self.pins.failing.get();
        for remote in self.remotes.iter().filter(|remote| failing >> remote.channel & 1 == 1) {
            self.messages.error(remote.texts.stopped, &[]);
        }
        self.begin(PortStep::GiveUp, to);
    }

    /// Writes the process data, and begins an exchange.
    fn put_data(&mut self, to: &mut Outgoing<'_>, exchanges: bool) {
        let mut words: [Word; CHANNELS] = [0; CHANNELS];
        for remote in &self.remotes {
            if let Some(word) = words.get_mut(remote.channel) {
                for given in &remote.given {
                    given.give(word);
                }
            }
        }
        // Neighbouring registers go into one command.
        for (n, user) in self.at.user.iter().enumerate() {
            for remote in self.remotes.iter().filter(|remote| n < remote.registers) {
                let word = words.get(remote.channel).copied().unwrap_or(0);
                put(to, user, remote.channel, low(word >> (n * 32)));
            }
        }
        if exchanges {
            to.put(self.at.command, EXCHANGE | self.mask());
            self.state.exchanged = true;
            self.state.exchanges = self.state.exchanges.wrapping_add(1);
        }
    }
}

/// Writes the register of a channel.
fn put(to: &mut Outgoing<'_>, at: &[u16; CHANNELS], channel: usize, value: u32) {
    if let Some(address) = at.get(channel) {
        to.put(*address, value);
    }
}
