//! Realtime. Encoders and pulse counters from edges with the kernel's time.

use hal_component::{Io, Messages, Out, ParamRw, Period, Touch, pins};
use port::LineEdge;

pins! {
    /// Pins of an encoder.
    pub(crate) struct EncoderPins {
        /// Count, which neither index nor reset changes: four for each cycle of A and B, or one for each rising edge of
        /// the only line.
        rawcounts: Out<i32> = "rawcounts", 0, measured;
        /// Count since the last index or reset.
        counts: Out<i32> = "counts", 0, measured;
        /// Position, in units.
        position: Out<f64> = "position", 0.0, measured;
        /// Speed, in units per second, from the times of the edges.
        velocity: Out<f64> = "velocity", 0.0;
        /// Time between the last two rising edges of the first line, in seconds; 0 before the second one.
        period: Out<f64> = "period", 0.0;
        /// Counts per unit; a negative value reverses the direction. A value closer to 0 than 1e-20 is set to 1.
        position_scale: ParamRw<f64> = "position-scale", 1.0;
        /// Lowest speed that is estimated, in units per second: without a count for so long, the speed is 0. A value of
        /// 0 or less, or NaN, is set to 1.
        min_speed_estimate: ParamRw<f64> = "min-speed-estimate", 1.0;
        /// While true, the position is zero.
        reset: ParamRw<bool> = "reset", false;
        /// While true, waits for the index line to rise, which makes the position zero there and this false.
        index_enable: Io<bool> = "index-enable", false;
        /// Number of edges that were lost because the kernel's queue of 1024 was full; the count is then wrong.
        lost: Out<u32> = "lost", 0;
        /// Number of edges that repeat the level before them: noise, or an edge that the chip missed.
        repeated: Out<u32> = "repeated", 0;
    }
}

/// Bits of the lines, which are requested in this order.
const A: u8 = 0;
const B: u8 = 1;
const Z: u8 = 2;

/// Encoder of one to three lines.
#[derive(Touch)]
pub(crate) struct Encoder {
    pins: EncoderPins,
    messages: Messages,
    #[state]
    number: f64,
    /// True if it has a line B.
    #[state]
    is_quadrature: bool,
    /// Levels of the lines, by bit.
    #[state]
    levels: [bool; 3],
    /// Number of the last edge; the kernel's begin with 1.
    #[state]
    last_edge: u32,
    #[state]
    has_begun: bool,
    #[state]
    lost: u32,
    #[state]
    repeated: u32,
    #[state]
    raw: i32,
    /// Raw count at the last index or reset.
    #[state]
    zero: i32,
    /// Time of the last rising edge of A.
    #[state]
    rise_ns: Option<u64>,
    #[state]
    speed: Speed,
}

/// Counts and times from which the speed follows.
#[derive(Clone, Copy, Debug, Default)]
struct Speed {
    /// Time of the last count.
    at_ns: u64,
    /// Count and time at the end of the last run with counts; `None` at rest.
    before: Option<(i32, u64)>,
    /// Time since then, in nanoseconds.
    still_ns: i64,
    /// True if something was counted in this run.
    has_counted: bool,
    /// Counts per second.
    rate: f64,
}

impl Encoder {
    pub(crate) fn new(
        pins: EncoderPins,
        messages: Messages,
        number: usize,
        is_quadrature: bool,
    ) -> Self {
        Self {
            pins,
            messages,
            number: f64::from(u32::try_from(number).unwrap_or(u32::MAX)),
            is_quadrature,
            levels: [false; 3],
            last_edge: 0,
            has_begun: false,
            lost: 0,
            repeated: 0,
            raw: 0,
            zero: 0,
            rise_ns: None,
            speed: Speed::default(),
        }
    }

    /// Takes the levels that the lines had when they were requested, at the first call.
    pub(crate) fn begin(&mut self, levels: u64) {
        if !core::mem::replace(&mut self.has_begun, true) {
            self.levels = [A, B, Z].map(|bit| levels >> bit & 1 != 0);
        }
    }

    /// Counts an edge.
    pub(crate) fn edge(&mut self, edge: &LineEdge) {
        let missing = edge.number.wrapping_sub(self.last_edge.wrapping_add(1));
        if missing != 0 {
            self.lost = self.lost.wrapping_add(missing);
            self.messages.error(LOST, &[f64::from(missing), self.number]);
        }
        self.last_edge = edge.number;
        let before = quadrant(self.levels);
        let Some(level) = self.levels.get_mut(usize::from(edge.bit)) else { return };
        if *level == edge.is_rising {
            self.repeated = self.repeated.wrapping_add(1);
            return;
        }
        *level = edge.is_rising;
        match edge.bit {
            A | B if self.is_quadrature => {
                let ahead = quadrant(self.levels).wrapping_sub(before) & 3 == 1;
                self.count(if ahead { 1 } else { -1 }, edge.at_ns);
            }
            A if edge.is_rising => self.count(1, edge.at_ns),
            Z if edge.is_rising && self.pins.index_enable.get() => {
                self.zero = self.raw;
                self.pins.index_enable.set(false);
            }
            _ => {}
        }
        if edge.bit == A && edge.is_rising {
            if let Some(before) = self.rise_ns {
                self.pins.period.set(edge.at_ns.wrapping_sub(before) as f64 * 1e-9);
            }
            self.rise_ns = Some(edge.at_ns);
        }
    }

    fn count(&mut self, step: i32, at_ns: u64) {
        self.raw = self.raw.wrapping_add(step);
        self.speed.at_ns = at_ns;
        self.speed.has_counted = true;
    }

    /// Sets the pins after the edges of a run.
    pub(crate) fn tell(&mut self, period: Period) {
        let pins = &self.pins;
        if pins.position_scale.get().abs() < 1e-20 || pins.position_scale.get().is_nan() {
            pins.position_scale.set(1.0);
        }
        let slowest = pins.min_speed_estimate.get();
        if slowest.is_nan() || slowest <= 0.0 {
            pins.min_speed_estimate.set(1.0);
        }
        if pins.reset.get() {
            self.zero = self.raw;
        }
        let scale = pins.position_scale.get();
        let slowest = pins.min_speed_estimate.get() * scale.abs();
        self.speed.run(self.raw, period.ns(), slowest);
        let counts = self.raw.wrapping_sub(self.zero);
        pins.rawcounts.set(self.raw);
        pins.counts.set(counts);
        pins.position.set(f64::from(counts) / scale);
        pins.velocity.set(self.speed.rate / scale);
        pins.lost.set(self.lost);
        pins.repeated.set(self.repeated);
    }
}

impl Speed {
    /// Computes the rate at the end of a run; below `slowest` counts per second it is 0.
    fn run(&mut self, raw: i32, period_ns: i64, slowest: f64) {
        if core::mem::take(&mut self.has_counted) {
            if let Some((before, at_ns)) = self.before {
                let lasted = self.at_ns.wrapping_sub(at_ns) as f64 * 1e-9;
                if lasted > 0.0 {
                    self.rate = f64::from(raw.wrapping_sub(before)) / lasted;
                }
            }
            self.before = Some((raw, self.at_ns));
            self.still_ns = 0;
            return;
        }
        self.still_ns = self.still_ns.saturating_add(period_ns.max(0));
        // The next count comes now at the earliest.
        let most = 1e9 / self.still_ns as f64;
        if most < slowest {
            (self.rate, self.before) = (0.0, None);
        } else if self.rate.abs() > most {
            self.rate = most.copysign(self.rate);
        }
    }
}

/// Returns the quarter of the cycle: A leads B forward.
const fn quadrant([a, b, _]: [bool; 3]) -> u8 {
    match (a, b) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    }
}

const LOST: &str = "{} edges of hal_gpio.encoder.{} were lost: more came between two reads than the kernel keeps; \
                    its position is wrong until the next index";
