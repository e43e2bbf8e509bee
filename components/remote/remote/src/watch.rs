//! Realtime. The function in the servo thread: it judges the beats, and ends remote motion.

use crate::lease::Lease;
use hal_component::{Builder, Clock, Error, In, Out, Period, Touch, Update};
use hal_safety::lease::Judge;
use std::sync::{
    Arc,
    atomic::{Ordering::Relaxed, Ordering::SeqCst, fence},
};

/// Nanoseconds in a millisecond.
const MS: i64 = 1_000_000;

/// The function.
#[derive(Debug, Touch)]
pub(crate) struct Watch {
    beat: In<u32>,
    clients: In<u32>,
    allow_motion: In<bool>,
    pulse: Out<u32>,
    lease: Out<u32>,
    present: Out<bool>,
    heartbeat: Out<bool>,
    permit: Out<bool>,
    allowed: Out<bool>,
    jog_stop: Out<bool>,
    hold: Out<bool>,
    clock: Clock,
    #[state]
    shared: Arc<Lease>,
    #[state]
    judge: Judge,
}

impl Watch {
    pub(crate) fn make(b: &mut Builder<'_>, shared: Arc<Lease>) -> Result<Self, Error> {
        Ok(Self {
            beat: b.item(
                "remote.beat",
                "Number of a pulse that the operator's page has sent back.",
                0,
            )?,
            clients: b.item("remote.clients", "Number of clients of the panel.", 0)?,
            allow_motion: b.item(
                "remote.allow-motion",
                "FALSE ends remote motion, and refuses it.",
                true,
            )?,
            pulse: b.item(
                "remote.pulse",
                "Machine time in milliseconds, for the operator's page.",
                0,
            )?,
            lease: b.item("remote.lease", "Number of the lease; 0 without one.", 0)?,
            present: b.item("remote.present", "TRUE while somebody has the lease.", false)?,
            heartbeat: b.item("remote.heartbeat", "TRUE while beats keep the lease.", false)?,
            permit: b.item("remote.permit", "TRUE while a held jog is permitted.", false)?,
            allowed: b.item("remote.allowed", "TRUE while allow-motion is.", false)?,
            jog_stop: b.item(
                "remote.jog-stop",
                "Stops jogs by its rising edges; linked to motion.jog-stop.",
                false,
            )?,
            hold: b.item(
                "remote.hold",
                "TRUE while a program is held since the lease was lost; linked to \
                 motion.feed-inhibit.",
                false,
            )?,
            clock: b.clock(),
            shared,
            judge: Judge::default(),
        })
    }
}

impl Update for Watch {
    fn update(&mut self, _: Period) {
        let Self { shared, judge, .. } = self;
        let now = u32::try_from((self.clock.now_ns() / MS) & i64::from(u32::MAX)).unwrap_or(0);
        let allowed = self.allow_motion.get();
        let beats = [self.beat.get(), shared.beat.load(Relaxed)];
        let mut number = shared.number.load(Relaxed);
        let judged = judge.beats(now, beats, allowed, number, &shared.rules);
        if judged.ends {
            // A lease that was given or taken meanwhile is another one.
            if shared.number.compare_exchange(number, 0, Relaxed, Relaxed).is_ok() {
                fence(SeqCst); // As in `Keeper::start`.
                shared.lose();
            }
            number = 0;
        }
        let words = shared.words();
        if judge.forbids(allowed, number, words.job) {
            shared.lost.store(true, Relaxed);
        }
        if !allowed && words.loses() {
            shared.hold.store(true, Relaxed);
        }
        let permit = judged.permit;
        let stops = judge.jog_stop(words.jog, words.jog_lease, number, allowed, permit);
        self.jog_stop.set(stops);
        shared.permit.store(permit, Relaxed);
        shared.allowed.store(allowed, Relaxed);
        shared.pulse.store(now, Relaxed);
        self.pulse.set(now);
        self.lease.set(number);
        self.present.set(number != 0);
        self.heartbeat.set(number != 0 && judged.beats);
        self.permit.set(permit);
        self.allowed.set(allowed);
        self.hold.set(shared.hold.load(Relaxed));
    }
}
