//! Realtime. The half of the counters that reads: counts, latches and speeds.

use crate::{
    module::{Cycle, Reads},
    numbers::{low, per_unit},
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::{
    AtomicBool,
    Ordering::{Acquire, Release},
};
use hal_component::{In, Io, Messages, Out, ParamRw, Takes, Touch, pins};

/// Bits of the control register.
pub(super) mod bits {
    pub(in crate::modules) const INPUT_A: u32 = 1;
    pub(in crate::modules) const INPUT_B: u32 = 1 << 1;
    pub(in crate::modules) const INPUT_INDEX: u32 = 1 << 2;
    /// 1 for the rising edge of the index.
    pub(in crate::modules) const INDEX_RISES: u32 = 1 << 3;
    /// Latches the count at the index.
    pub(in crate::modules) const LATCH_ON_INDEX: u32 = 1 << 4;
    /// The card clears the bits that latch when it has.
    pub(in crate::modules) const JUST_ONCE: u32 = 1 << 6;
    pub(in crate::modules) const MASK_POLARITY: u32 = 1 << 8;
    pub(in crate::modules) const INDEX_MASK: u32 = 1 << 9;
    pub(in crate::modules) const STEP_AND_DIRECTION: u32 = 1 << 10;
    pub(in crate::modules) const FILTER: u32 = 1 << 11;
    pub(in crate::modules) const PROBE_RISES: u32 = 1 << 12;
    pub(in crate::modules) const LATCH_ON_PROBE: u32 = 1 << 13;
    pub(in crate::modules) const ERROR: u32 = 1 << 15;
}

pins! {
    /// Results of one counter.
    pub(crate) struct Feedback {
        /// Counts since the card was found.
        rawcounts: Out<i32> = "rawcounts", 0;
        /// Counts since `reset` or the index.
        count: Out<i32> = "count", 0;
        /// Position, in units: `count` over `scale`.
        position: Out<f64> = "position", 0.0, measured;
        /// Counts at the last edge of the probe input, before `reset` or the index.
        rawlatch: Out<i32> = "rawlatch", 0;
        /// Counts at the last edge of the probe input.
        count_latched: Out<i32> = "count-latched", 0;
        /// Position at the last edge of the probe input, in units.
        position_latched: Out<f64> = "position-latched", 0.0;
        /// Speed, in units per second, from the times of the counts.
        velocity: Out<f64> = "velocity", 0.0;
        /// Speed, in units per minute.
        velocity_rpm: Out<f64> = "velocity-rpm", 0.0;
        /// TRUE once A and B changed together, while `quad-error-enable` is TRUE.
        quad_error: Out<bool> = "quad-error", false;
        /// Level of input A behind the filter.
        input_a: Out<bool> = "input-a", false;
        /// Level of input B behind the filter.
        input_b: Out<bool> = "input-b", false;
        /// Level of the index input behind the filter.
        input_index: Out<bool> = "input-index", false;
    }
}

pins! {
    /// Commands to one counter.
    pub(crate) struct Commands {
        /// TRUE to hold count and position at 0.
        reset: In<bool> = "reset", false;
        /// TRUE to make count and position 0 at the next edge of the index; the driver sets it FALSE then.
        index_enable: Io<bool> = "index-enable", false;
        /// TRUE to report that A and B changed together; FALSE clears the report.
        quad_error_enable: In<bool> = "quad-error-enable", false;
        /// Counts per unit; 0 counts as 1.
        scale: ParamRw<f64> = "scale", 1.0;
        /// TRUE for the rising edge of the index, FALSE for the falling one.
        index_invert: ParamRw<bool> = "index-invert", false;
        /// TRUE if the index counts only with the mask input.
        index_mask: ParamRw<bool> = "index-mask", false;
        /// TRUE if the mask input must be FALSE.
        index_mask_invert: ParamRw<bool> = "index-mask-invert", false;
        /// FALSE for quadrature, TRUE for step on A and direction on B.
        counter_mode: ParamRw<bool> = "counter-mode", false;
        /// TRUE to take an edge after 15 equal samples, FALSE after 3.
        filter: ParamRw<bool> = "filter", true;
        /// Longest time without a count before the speed counts as 0, in seconds.
        vel_timeout: ParamRw<f64> = "vel-timeout", 0.5;
    }
}

pins! {
    /// Commands to the latch of a counter whose card has a probe input.
    pub(crate) struct Probe {
        /// TRUE to latch the count at the next edge of the probe input; the driver sets it FALSE then.
        latch_enable: Io<bool> = "latch-enable", false;
        /// TRUE for the rising edge of the probe input, FALSE for the falling one.
        latch_polarity: In<bool> = "latch-polarity", false;
    }
}

/// Latches that the writing half has armed.
#[derive(Debug, Default)]
pub(super) struct Armed {
    pub(super) index: AtomicBool,
    pub(super) probe: AtomicBool,
}

/// Half of a counter that reads.
#[derive(Touch)]
pub(super) struct Counter {
    #[state]
    pub(super) count: Place,
    #[state]
    pub(super) control: Place,
    pub(super) feedback: Feedback,
    pub(super) commands: Commands,
    pub(super) probe: Option<Probe>,
    pub(super) armed: Takes<Armed>,
    pub(super) messages: Messages,
    /// Message about a change of both lines at once.
    #[state]
    pub(super) wrong: &'static str,
    #[state]
    pub(super) state: Counting,
}

/// Counts of one counter so far.
#[derive(Default)]
pub(super) struct Counting {
    last: Option<u16>,
    raw: i64,
    zero: i64,
    latched: i64,
    /// Moment of the last count, in ticks of the time stamps.
    counted_at: i64,
    velocity: f64,
    is_wrong: bool,
}

/// Time stamps of the module in this cycle.
#[derive(Clone, Copy)]
struct Stamp {
    /// Ticks so far.
    now: i64,
    /// The card's counter of ticks, which goes round.
    register: u16,
    /// Seconds of a tick.
    tick: f64,
}

impl Counter {
    fn read(&mut self, answer: ReadAnswer<'_>, stamp: Stamp, fresh: bool) {
        let [count_low, count_high, at_low, at_high] = answer.get(self.count).to_le_bytes();
        let count = u16::from_le_bytes([count_low, count_high]);
        let at = u16::from_le_bytes([at_low, at_high]);
        let control = answer.get(self.control);
        let s = &mut self.state;
        let moved = i64::from(count.wrapping_sub(s.last.unwrap_or(count)).cast_signed());
        s.last = Some(count);
        s.raw = s.raw.wrapping_add(moved);
        let latched = |raw: i64| {
            let [_, _, low, high] = control.to_le_bytes();
            let back = count.wrapping_sub(u16::from_le_bytes([low, high])).cast_signed();
            raw.wrapping_sub(i64::from(back))
        };
        // A latch counts only if the card is known to have been armed: an answer of a card that missed the order looks as
        // if the edge had come.
        let done = |bit: u32, armed: &AtomicBool| {
            fresh && armed.load(Acquire) && control & bit == 0 // Pairs with Release in `write`.
        };
        if done(bits::LATCH_ON_INDEX, &self.armed.index) && self.commands.index_enable.get() {
            s.zero = latched(s.raw);
            self.commands.index_enable.set(false);
            self.armed.index.store(false, Release); // Pairs with Acquire in `write`.
        }
        if let Some(probe) = &self.probe
            && probe.latch_enable.get()
            && done(bits::LATCH_ON_PROBE, &self.armed.probe)
        {
            s.latched = latched(s.raw);
            probe.latch_enable.set(false);
            self.armed.probe.store(false, Release); // Pairs with Acquire in `write`.
        }
        if self.commands.reset.get() {
            s.zero = s.raw;
        }
        let scale = per_unit(self.commands.scale);
        s.follow(moved, at, stamp, self.commands.vel_timeout.get());
        let out = &self.feedback;
        out.rawcounts.set(low(s.raw));
        out.count.set(low(s.raw.wrapping_sub(s.zero)));
        out.position.set(s.raw.wrapping_sub(s.zero) as f64 / scale);
        out.rawlatch.set(low(s.latched));
        out.count_latched.set(low(s.latched.wrapping_sub(s.zero)));
        out.position_latched.set(s.latched.wrapping_sub(s.zero) as f64 / scale);
        out.velocity.set(s.velocity / scale);
        out.velocity_rpm.set(s.velocity / scale * 60.0);
        out.input_a.set(control & bits::INPUT_A != 0);
        out.input_b.set(control & bits::INPUT_B != 0);
        out.input_index.set(control & bits::INPUT_INDEX != 0);
        let is_wrong = self.commands.quad_error_enable.get() && control & bits::ERROR != 0;
        if is_wrong && !s.is_wrong {
            self.messages.error(self.wrong, &[]);
        }
        s.is_wrong = is_wrong;
        out.quad_error.set(is_wrong);
    }
}

/// Text of [`Counter::wrong`].
pub(super) const WRONG: &str = "A and B changed together: counts are lost (a frequency above \
    what the filter lets through, or a bad line)";

impl Counting {
    /// Follows the speed in counts per second. Between two counts it is at most what one count since the last would be.
    fn follow(&mut self, moved: i64, at: u16, stamp: Stamp, timeout: f64) {
        if moved != 0 {
            let ago = i64::from(stamp.register.wrapping_sub(at));
            let counted_at = stamp.now.wrapping_sub(ago);
            let ticks = counted_at.wrapping_sub(self.counted_at).max(1);
            self.velocity = moved as f64 / (ticks as f64 * stamp.tick);
            self.counted_at = counted_at;
            return;
        }
        let since = stamp.now.wrapping_sub(self.counted_at) as f64 * stamp.tick;
        if since > timeout || since.is_nan() || timeout.is_nan() {
            self.velocity = 0.0;
        } else if self.velocity.abs() * since > 1.0 {
            self.velocity = libm::copysign(1.0 / since, self.velocity);
        }
    }
}

/// Function half that reads.
#[derive(Touch)]
pub(super) struct Counters {
    pub(super) counters: Vec<Counter>,
    #[state]
    pub(super) stamp: Place,
    #[state]
    pub(super) register: Option<u16>,
    #[state]
    pub(super) now: i64,
    pub(super) tick: Takes<Tick>,
}

/// Seconds of a tick of the time stamps, as bits.
pub(super) type Tick = core::sync::atomic::AtomicU64;

impl Reads for Counters {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, fresh: bool) {
        let [low, high, _, _] = answer.get(self.stamp).to_le_bytes();
        let register = u16::from_le_bytes([low, high]);
        let passed = register.wrapping_sub(self.register.unwrap_or(register));
        self.register = Some(register);
        self.now = self.now.wrapping_add(i64::from(passed));
        let tick = f64::from_bits(self.tick.load(Acquire)); // Pairs with Release in `write`.
        let stamp = Stamp { now: self.now, register, tick };
        for counter in &mut self.counters {
            counter.read(answer, stamp, fresh);
        }
    }
}
