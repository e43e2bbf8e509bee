//! The remote operator: the page, the lease, and what the plugin `remote` does with the parts of [`hal_safety::lease`].

use crate::{model::Key, watch::Watch};
use hal_safety::{
    lease::{ABORT_NS, Desk, Job, Jog, Judge, OnLoss, Refused, Rules, START_NS, Words, Work},
    plant::{Act, Plant, Way},
};

/// Event of the operator, the page or the wiring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RemoteAct {
    Take,
    Give,
    /// Jogs while a button is held.
    Hold,
    /// Jogs by a distance.
    Step,
    /// The jog that was sent reaches motion.
    Arrives,
    Start,
    /// Starts a program that goes on without the lease.
    StartContinue,
    /// Starts a program that ends with the lease.
    StartAbort,
    /// Starts, and ends the hold of a program.
    StartReleased,
    Release,
    /// The link is cut.
    Cut,
    /// The link is back.
    Back,
    Forbid,
    Allow,
    /// A cycle passes.
    Wait,
}

impl RemoteAct {
    pub(crate) const ALL: [Self; 15] = [
        Self::Take,
        Self::Give,
        Self::Hold,
        Self::Step,
        Self::Arrives,
        Self::Start,
        Self::StartContinue,
        Self::StartAbort,
        Self::StartReleased,
        Self::Release,
        Self::Cut,
        Self::Back,
        Self::Forbid,
        Self::Allow,
        Self::Wait,
    ];
}

/// Age of a beat up to which a jog and the lease last, in cycles of a millisecond.
const JOG_MS: u32 = 1;
const LEASE_MS: u32 = 4;
/// Age that counts as any greater one.
const OLD: u32 = LEASE_MS + 2;
/// Machine time of every state, in milliseconds, to which it is moved after a step.
const NOW: u32 = 1_000_000;
/// Time that passes until everything has settled, in milliseconds.
const LONG: u32 = 5000;

/// The remote side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Remote {
    rules: Rules,
    pub(crate) words: Words,
    judge: Judge,
    desk: Desk,
    now: u32,
    /// True while the page answers.
    pub(crate) answers: bool,
    /// Beat at the pin.
    beat: u32,
    /// Value of `allow-motion`.
    pub(crate) allow: bool,
    /// Kind of the jog that is on its way to motion.
    pub(crate) sent: Jog,
    /// True if it has arrived in this step.
    pub(crate) has_arrived: bool,
    lost: bool,
}

impl Remote {
    pub(crate) fn new() -> Self {
        let words = Words { allowed: true, holds: true, ..Words::default() };
        let judge = Judge { taken: NOW - OLD, beat: NOW - OLD, allowed: true, ..Judge::default() };
        Self {
            rules: Rules { jog_ms: JOG_MS, lease_ms: LEASE_MS },
            words,
            judge,
            desk: Desk { last: 2, ends_next: ns(NOW), ..Desk::default() },
            now: NOW,
            answers: true,
            beat: NOW - OLD,
            allow: true,
            sent: Jog::None,
            has_arrived: false,
            lost: false,
        }
    }

    /// Takes a command; `None` if it has no meaning now.
    pub(crate) fn command(&mut self, act: RemoteAct, watch: &mut Watch) -> Option<()> {
        let given = self.words.number;
        let w = &mut self.words;
        match act {
            RemoteAct::Take => {
                let from = (given != 0).then_some(given);
                w.number = self.desk.take(given, from).ok()?;
                watch.quiet = 0;
            }
            RemoteAct::Give => {
                Desk::check(given, w.number).ok()?;
                w.number = 0;
                self.lose();
            }
            RemoteAct::Hold | RemoteAct::Step => {
                let kind = Desk::jog(given, act == RemoteAct::Hold, w).ok()?;
                if self.sent != Jog::None {
                    return None;
                }
                w.jog_lease = given;
                w.jog = if kind > w.jog { kind } else { w.jog };
                self.sent = kind;
            }
            RemoteAct::Arrives => {
                if self.sent == Jog::None {
                    return None;
                }
                // A jog by a distance replaces one that is held.
                watch.held_jog = core::mem::take(&mut self.sent) == Jog::Held;
                self.has_arrived = true;
            }
            RemoteAct::Start
            | RemoteAct::StartContinue
            | RemoteAct::StartAbort
            | RemoteAct::StartReleased => {
                let release = act == RemoteAct::StartReleased;
                let said = match act {
                    RemoteAct::StartContinue => Some(OnLoss::Continue),
                    RemoteAct::StartAbort => Some(OnLoss::Abort),
                    _ => None,
                };
                self.desk.on_loss = self.desk.start(given, release, said, w).ok()?;
                w.holds = self.desk.on_loss.holds();
                w.job = true;
                w.hold &= !release;
                self.desk.announced(ns(self.now));
                self.desk.started();
                watch.start(release, said);
            }
            RemoteAct::Release => {
                let released: Result<(), Refused> = self.desk.release(w.allowed);
                released.ok()?;
                w.hold = false;
                watch.release();
            }
            RemoteAct::Cut => self.answers = self.answers.then_some(false)?,
            RemoteAct::Back => self.answers = (!self.answers).then_some(true)?,
            RemoteAct::Forbid => self.allow = self.allow.then_some(false)?,
            RemoteAct::Allow => self.allow = (!self.allow).then_some(true)?,
            RemoteAct::Wait => {}
        }
        Some(())
    }

    fn lose(&mut self) {
        self.lost = true;
        self.words.hold |= self.words.loses();
    }

    /// Runs the function in the servo thread; returns whether `jog-stop` rises.
    pub(crate) fn cycle(&mut self, act: Act, watch: &mut Watch) -> bool {
        self.now += if act == Act::Settle { LONG } else { 1 };
        if self.answers {
            // A pulse takes a millisecond to the page and back.
            self.beat = self.now - 1;
        }
        watch.quiet = if self.answers {
            0
        } else {
            (watch.quiet + if act == Act::Settle { OLD } else { 1 }).min(OLD)
        };
        let w = &mut self.words;
        let beats = [self.beat, NOW - OLD];
        let judged = self.judge.beats(self.now, beats, self.allow, w.number, &self.rules);
        if judged.ends {
            w.number = 0;
            self.lose();
        }
        let w = &mut self.words;
        if self.judge.forbids(self.allow, w.number, w.job) {
            self.lost = true;
        }
        w.hold |= !self.allow && w.loses();
        w.permit = judged.permit && w.number != 0;
        w.allowed = self.allow;
        let was = self.judge.stops;
        let stops = self.judge.jog_stop(w.jog, w.jog_lease, w.number, self.allow, w.permit);
        stops && !was
    }

    /// Runs the task; returns whether it aborts motion.
    pub(crate) fn keep(&mut self, plant: &Plant) -> bool {
        let program = plant.claimed || plant.way != Way::None;
        let work = Work {
            moves: program || plant.moves(),
            waits: program,
            homes: plant.homes,
            job: program,
        };
        if self.sent == Jog::None && plant.jog == hal_safety::plant::PlantMotion::Rests {
            self.words.jog = Jog::None;
        }
        if core::mem::take(&mut self.lost) {
            self.desk.lost();
        }
        let aborts = self.desk.end_orphan(ns(self.now), work);
        if self.desk.follow(ns(self.now), work) {
            (self.words.job, self.words.hold) = (false, false);
            self.words.holds = self.desk.on_loss.holds();
        }
        aborts
    }

    /// Moves the state to the time [`NOW`] and the lease to a fixed number, so that states that differ in nothing else are one.
    pub(crate) fn normalise(&mut self) {
        let now = core::mem::replace(&mut self.now, NOW);
        let place = |at: u32| NOW - (now - at).min(OLD);
        self.beat = place(self.beat);
        self.judge.beat = place(self.judge.beat);
        self.judge.taken = place(self.judge.taken);
        if self.judge.beats || self.words.number == 0 {
            // Nothing looks at it until the next lease.
            self.judge.taken = NOW - OLD;
        }
        self.judge.beats &= self.words.number != 0;
        let last = core::mem::replace(&mut self.desk.last, 2);
        let number = |n: u32| if n == 0 { 0 } else { 1 + u32::from(n == last) };
        self.words.number = number(self.words.number);
        self.judge.lease = number(self.judge.lease);
        self.words.jog_lease = number(self.words.jog_lease);
        if self.words.jog == Jog::None {
            self.words.jog_lease = 0;
        }
        self.desk.job = match self.desk.job {
            Job::Commanded(at) if ns(now) - at <= START_NS => Job::Commanded(ns(NOW)),
            Job::Commanded(_) => Job::Commanded(ns(NOW) - START_NS - 1),
            job => job,
        };
        let is_due = self.desk.ends_next <= ns(now);
        self.desk.ends_next = if is_due { ns(NOW) } else { ns(NOW) + ABORT_NS };
    }

    pub(crate) fn put(&self, key: &mut Key) {
        let w = &self.words;
        let age = |at: u32| NOW - at;
        key.put(3, w.number);
        key.put(3, w.jog_lease);
        key.put(3, w.jog as u32);
        key.put(3, self.sent as u32);
        key.put(3, self.judge.lease);
        key.put(OLD + 1, age(self.judge.taken));
        key.put(OLD + 1, age(self.judge.beat));
        key.put(OLD + 1, age(self.beat));
        let job = match self.desk.job {
            Job::None => 0,
            Job::Commanded(at) => 1 + u32::from(at == ns(NOW)),
            Job::Runs => 3,
        };
        key.put(4, job);
        key.put(3, self.desk.on_loss as u32);
        let bits = [
            w.permit,
            w.allowed,
            w.job,
            w.hold,
            self.judge.beats,
            self.judge.allowed,
            self.judge.stops,
            self.desk.orphaned,
            self.desk.ends,
            self.desk.ends_next == ns(NOW),
            self.answers,
            self.allow,
        ];
        bits.into_iter().for_each(|bit| key.put(2, bit.into()));
    }

    /// Returns the longest time without an answer in which a lease lasts, in cycles.
    pub(crate) const fn lease_lasts() -> u32 {
        LEASE_MS + 1
    }

    /// Returns the longest time without an answer in which a held jog lasts, in cycles.
    pub(crate) const fn jog_lasts() -> u32 {
        JOG_MS - 1
    }

    /// Number of cycles without an answer that count as any greater one.
    pub(crate) const QUIET: u32 = OLD;
}

const fn ns(ms: u32) -> i64 {
    ms as i64 * 1_000_000
}
