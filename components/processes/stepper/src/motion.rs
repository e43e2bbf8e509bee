//! Realtime. Speed and acceleration computed from steps.
//!
//! Steps come at multiples of a thread's period, so a single interval is inaccurate: at 100 µs, 12 mm/s with a fine
//! screw can appear as up to 17.5 mm/s. The speed is therefore a mean, and the acceleration a least-squares fit.

/// Time of a step, and the position halfway through it, in steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Event {
    pub(crate) ns: i64,
    pub(crate) at: f64,
}

/// Time over which the speed is averaged, in nanoseconds.
pub(crate) const SPAN_NS: i64 = 20_000_000;
/// Minimum time between steps that are used for the acceleration, in nanoseconds.
const APART_NS: i64 = 500_000;

/// Mean speed over the last 20 ms, or over the last step if that took longer. The motor counts as at rest before its
/// first step.
#[derive(Clone, Debug)]
pub(crate) struct Speed {
    /// Earlier steps, the newest last; from `first` on, all but the first are within the time span.
    ring: [Event; 64],
    first: usize,
    len: usize,
}

impl Speed {
    pub(crate) const fn new() -> Self {
        Self { ring: [Event { ns: 0, at: 0.0 }; 64], first: 0, len: 0 }
    }

    pub(crate) const fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds a step. Returns the speed in steps per second.
    pub(crate) fn step(&mut self, now: Event) -> f64 {
        while self.len > 1 && self.get(1).is_some_and(|e| now.ns - e.ns >= SPAN_NS) {
            self.first = (self.first + 1) % self.ring.len();
            self.len -= 1;
        }
        let speed = self.get(0).map_or(0.0, |old| rate(old, now));
        let newest = self.len.checked_sub(1).and_then(|last| self.get(last));
        if newest.is_none_or(|e| now.ns - e.ns >= APART_NS) && self.len < self.ring.len() {
            let end = (self.first + self.len) % self.ring.len();
            if let Some(place) = self.ring.get_mut(end) {
                *place = now;
                self.len += 1;
            }
        }
        speed
    }

    fn get(&self, n: usize) -> Option<Event> {
        let place = (self.first + n) % self.ring.len();
        self.ring.get(place).copied().filter(|_| n < self.len)
    }
}

fn rate(old: Event, now: Event) -> f64 {
    let ns = now.ns - old.ns;
    (now.at - old.at) * 1e9 / if ns < SPAN_NS { SPAN_NS } else { ns } as f64
}

/// Acceleration from a parabola fitted to the steps of one ramp. A step off the parabola begins another ramp.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ramp {
    first: Event,
    last_ns: i64,
    /// Sums of the powers of time, from 0 to 4.
    time: [f64; 5],
    /// Sums of the position times the powers of time, from 0 to 2.
    position: [f64; 3],
    /// Coefficients of the parabola.
    fit: Option<[f64; 3]>,
}

impl Ramp {
    /// Minimum number of steps of a ramp.
    const LEAST: f64 = 8.0;
    /// Minimum duration of a ramp, in seconds.
    const SHORTEST: f64 = 0.03;
    /// Minimum relative change of speed over a ramp.
    const CLEAR: f64 = 0.25;
    /// Maximum duration of a ramp, in seconds; then another begins.
    const MAX_SECS: f64 = 4.0;
    /// Largest distance of a step from the parabola, in steps.
    const OFF: f64 = 1.0;

    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Adds a step. Returns the acceleration in steps per second squared, once it can be determined.
    pub(crate) fn step(&mut self, now: Event) -> Option<f64> {
        let [count, ..] = self.time;
        if count > 0.0 && now.ns - self.last_ns < APART_NS {
            return self.acceleration();
        }
        let t = self.since(now.ns);
        let off = self.fit.map(|[a, b, c]| (a + t * (b + t * c) + self.first.at - now.at).abs());
        if count == 0.0 || t > Self::MAX_SECS || off.is_some_and(|off| off > Self::OFF) {
            self.clear();
            self.first = now;
        }
        self.add(now);
        self.fit = self.solve();
        self.acceleration()
    }

    fn since(&self, ns: i64) -> f64 {
        (ns - self.first.ns) as f64 * 1e-9
    }

    fn add(&mut self, now: Event) {
        let (t, x) = (self.since(now.ns), now.at - self.first.at);
        let mut power = 1.0;
        let mut sums = self.position.iter_mut();
        for time in &mut self.time {
            *time += power;
            if let Some(sum) = sums.next() {
                *sum += power * x;
            }
            power *= t;
        }
        self.last_ns = now.ns;
    }

    fn acceleration(&self) -> Option<f64> {
        let [count, ..] = self.time;
        let [_, begin, c] = self.fit?;
        let t = self.since(self.last_ns);
        let (change, end) = (2.0 * c * t, begin + 2.0 * c * t);
        let top = if end.abs() > begin.abs() { end.abs() } else { begin.abs() };
        let clear = change.abs() >= Self::CLEAR * top;
        (count >= Self::LEAST && t >= Self::SHORTEST && clear).then_some(2.0 * c)
    }

    /// Solves the normal equations of the least-squares fit by elimination.
    fn solve(&self) -> Option<[f64; 3]> {
        let [s0, s1, s2, s3, s4] = self.time;
        let [x0, x1, x2] = self.position;
        if s0 < 4.0 {
            return None;
        }
        let (k1, k2) = (s1 / s0, s2 / s0);
        let (b11, b12, y1) = (s2 - k1 * s1, s3 - k1 * s2, x1 - k1 * x0);
        let (b22, y2) = (s4 - k2 * s2, x2 - k2 * x0);
        let k = b12 / b11;
        let c = (y2 - k * y1) / (b22 - k * b12);
        let b = (y1 - b12 * c) / b11;
        let a = (x0 - s1 * b - s2 * c) / s0;
        (a.is_finite() && b.is_finite() && c.is_finite()).then_some([a, b, c])
    }
}
