//! Realtime. The function in the servo thread: it judges the beats, and ends remote motion.

use crate::lease::{Lease, jog};
use hal_component::{Builder, Clock, Error, In, Out, Period, Touch, Update};
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
    judged: Judged,
}

/// Judgement of the beats.
#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    /// Number of the lease in the cycle before.
    lease: u32,
    /// Machine time at which this lease was first seen, in milliseconds.
    taken: u32,
    /// Beat in the cycle before.
    beat: u32,
    /// True once a beat has arrived under this lease.
    beats: bool,
    /// Value of `allow-motion` in the cycle before.
    allowed: bool,
    /// Value of `jog-stop` in the cycle before: motion acts on its edges.
    stops: bool,
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
            judged: Judged::default(),
        })
    }
}

impl Update for Watch {
    fn update(&mut self, _: Period) {
        let Self { shared, judged, .. } = self;
        let now = u32::try_from((self.clock.now_ns() / MS) & i64::from(u32::MAX)).unwrap_or(0);
        let allowed = self.allow_motion.get();
        // The younger one counts: a page answers by the pin, another program by the command.
        let beats = [self.beat.get(), shared.beat.load(Relaxed)];
        let beat = beats.into_iter().min_by_key(|beat| now.wrapping_sub(*beat)).unwrap_or(0);
        let mut number = shared.number.load(Relaxed);
        if number != judged.lease {
            *judged = Judged { lease: number, taken: now, beats: false, ..*judged };
        }
        if beat != judged.beat {
            judged.beat = beat;
            // A pulse of this lease's first millisecond, or an older one, may have left under the lease before.
            judged.beats |= beat.wrapping_sub(judged.taken).cast_signed() > 0;
        }
        // A number from the future has a great age.
        let age = now.wrapping_sub(beat);
        let beats = judged.beats && age <= shared.lease_ms;
        let permit = number != 0 && allowed && beats && age <= shared.jog_ms;
        let awaits_first = !judged.beats && now.wrapping_sub(judged.taken) <= shared.lease_ms;
        if number != 0 && !beats && !awaits_first {
            // A lease that was given or taken meanwhile is another one.
            if shared.number.compare_exchange(number, 0, Relaxed, Relaxed).is_ok() {
                fence(SeqCst); // As in `Keeper::start`.
                shared.lost.store(true, Relaxed);
                if shared.holds && shared.job.load(Relaxed) {
                    shared.hold.store(true, Relaxed);
                }
            }
            number = 0;
        }
        if judged.allowed && !allowed && (number != 0 || shared.job.load(Relaxed)) {
            shared.lost.store(true, Relaxed);
        }
        judged.allowed = allowed;
        if !allowed && shared.holds && shared.job.load(Relaxed) {
            shared.hold.store(true, Relaxed);
        }
        let lasts = number != 0 && number == shared.jog_lease.load(Relaxed) && allowed;
        let ends = match shared.jog.load(Relaxed) {
            jog::NONE => false,
            jog::STEP => !lasts,
            _ => !(lasts && permit),
        };
        // Edges again and again, because a jog may still be on its way to motion.
        judged.stops = ends && !judged.stops;
        self.jog_stop.set(judged.stops);
        shared.permit.store(permit, Relaxed);
        shared.allowed.store(allowed, Relaxed);
        shared.pulse.store(now, Relaxed);
        self.pulse.set(now);
        self.lease.set(number);
        self.present.set(number != 0);
        self.heartbeat.set(number != 0 && beats);
        self.permit.set(permit);
        self.allowed.set(allowed);
        self.hold.set(shared.hold.load(Relaxed));
    }
}
