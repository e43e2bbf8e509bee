//! Realtime. Judges the velocity, acceleration and jerk of joints by finite differences.

/// Number of roundings that a position may have gone through, each of half a unit in the last place.
pub const ROUNDINGS: f64 = 8.0;

/// Limits of one joint; infinity means that there is no limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Highest speed, in units per second.
    pub velocity: f64,
    /// Highest acceleration, in units per second squared.
    pub acceleration: f64,
    /// Highest jerk, in units per second cubed.
    pub jerk: f64,
}

/// The largest ratio of a value to its limit, and the place where it occurred.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// Value divided by limit, after the allowance for rounding; above 1 is a violation.
    pub ratio: f64,
    /// Cycle number, from 0.
    pub cycle: u64,
    /// Joint number.
    pub joint: usize,
    /// Line of the program, as the caller gave it.
    pub line: u32,
}

/// The worst of each value so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Velocity, by first differences.
    pub velocity: Worst,
    /// Acceleration, by second differences.
    pub acceleration: Worst,
    /// Jerk, by third differences.
    pub jerk: Worst,
    /// Cycles in which at least one value exceeded its limit.
    pub violations: u64,
    /// Cycles judged.
    pub cycles: u64,
}

/// Judge of `J` joints. It assumes that the joints were at rest before the first position.
#[derive(Clone, Debug)]
pub struct Watchman<const J: usize> {
    /// Limits of the differences of one cycle: of first, second and third order.
    limits: [[f64; 3]; J],
    /// Differences up to which a limit is kept and the worst so far is no better: most of them, found without arithmetic.
    calm: [[f64; 3]; J],
    size: f64,
    past: [Past; J],
    report: Report,
    started: bool,
    is_calm: bool,
}

/// The last position of a joint, and the last differences.
#[derive(Clone, Copy, Debug)]
struct Past {
    position: f64,
    first: f64,
    second: f64,
    /// Number of these that are known, in this order.
    known: u8,
}

impl<const J: usize> Watchman<J> {
    /// Judge for a period in seconds. `size` is the largest coordinate, radius or length in the computation of the
    /// positions; larger positions count by themselves.
    pub fn new(limits: [Limits; J], period: f64, size: f64) -> Self {
        let limits = limits.map(|l| l.of_a_cycle(period));
        let past = [Past::at_rest(0.0); J];
        let calm = [[0.0; 3]; J];
        Self { limits, calm, size, past, report: Report::default(), started: false, is_calm: false }
    }

    /// Sets the position at which the joints are at rest, for example after a reset.
    pub fn rest_at(&mut self, positions: &[f64; J]) {
        for (past, position) in self.past.iter_mut().zip(positions) {
            *past = Past::at_rest(*position);
        }
        self.started = true;
    }

    /// Changes the limits from the next position on; `size` is as in [`Self::new`].
    pub fn set_limits(&mut self, limits: [Limits; J], period: f64, size: f64) {
        self.limits = limits.map(|l| l.of_a_cycle(period));
        self.size = size;
        self.find_calm();
    }

    fn find_calm(&mut self) {
        let Report { velocity, acceleration, jerk, .. } = &self.report;
        let ratios = [velocity.ratio, acceleration.ratio, jerk.ratio];
        for (calm, limits) in self.calm.iter_mut().zip(&self.limits) {
            for ((calm, limit), ratio) in calm.iter_mut().zip(limits).zip(ratios) {
                // Without a limit everything finite is calm; after a violation nothing is, so that each of them counts.
                *calm = if *limit == f64::INFINITY {
                    f64::MAX
                } else if ratio <= 1.0 {
                    limit * ratio
                } else {
                    0.0
                };
            }
        }
    }

    /// Begins again at the next positions, because their zero changed in motion. A velocity is judged from the second of
    /// them on, an acceleration from the third.
    pub fn restart(&mut self) {
        for past in &mut self.past {
            past.known = 0;
        }
    }

    /// Forgets the worst of each value.
    pub fn forget(&mut self) {
        self.report = Report::default();
        self.is_calm = false;
        self.find_calm();
    }

    /// Judges the positions of one cycle; returns false if a limit is exceeded or a position is not finite.
    pub fn step(&mut self, positions: &[f64; J], line: u32) -> bool {
        if !self.started {
            self.rest_at(positions);
        }
        let cycle = self.report.cycles;
        let mut good = true;
        let mut is_calm = true;
        let joints = self.past.iter_mut().zip(positions).zip(&self.limits).zip(&self.calm);
        for (joint, (((past, position), limits), calm)) in joints.enumerate() {
            let at = |ratio: f64| Worst { ratio, cycle, joint, line };
            if !position.is_finite() {
                self.report.velocity.raise(at(f64::INFINITY));
                (good, is_calm) = (false, false);
                continue;
            }
            let before = past.position;
            let [first, second, third] = past.step(*position);
            let [v, a, j] = *calm;
            if first.abs() <= v && second.abs() <= a && third.abs() <= j {
                continue;
            }
            is_calm = false;
            let largest = self.size.max(position.abs()).max(before.abs());
            let error = ROUNDINGS * (f64::EPSILON / 2.0) * largest;
            let [v, a, j] = *limits;
            good &= self.report.velocity.judge(first, 2.0 * error, v, at);
            good &= self.report.acceleration.judge(second, 4.0 * error, a, at);
            good &= self.report.jerk.judge(third, 8.0 * error, j, at);
        }
        self.report.cycles = cycle.wrapping_add(1);
        self.is_calm = is_calm;
        if !is_calm {
            self.find_calm();
        }
        if !good {
            self.report.violations = self.report.violations.wrapping_add(1);
        }
        good
    }

    /// Returns true if the last positions are inside all limits, and left the worst of each value as it was.
    pub const fn is_calm(&self) -> bool {
        self.is_calm
    }

    /// Returns the worst of each value so far.
    pub const fn report(&self) -> &Report {
        &self.report
    }
}

impl Limits {
    /// Returns the limits of the differences of one cycle, for a period in seconds.
    fn of_a_cycle(self, h: f64) -> [f64; 3] {
        [self.velocity * h, self.acceleration * h * h, self.jerk * h * h * h]
    }
}

impl Past {
    /// Takes the next position; returns the differences of first, second and third order, 0 for those that are not known.
    #[inline]
    fn step(&mut self, position: f64) -> [f64; 3] {
        let known = self.known;
        let since = |order: u8, value: f64| if known >= order { value } else { 0.0 };
        let mut first = position - self.position;
        let mut second = first - self.first;
        let mut third = second - self.second;
        if known < 3 {
            first = since(1, first);
            second = since(2, first - self.first);
            third = since(3, second - self.second);
            self.known = known + 1;
        }
        (self.position, self.first, self.second) = (position, first, second);
        [first, second, third]
    }

    const fn at_rest(position: f64) -> Self {
        Self { position, first: 0.0, second: 0.0, known: 3 }
    }
}

impl Worst {
    /// Judges a difference; returns true if it is inside its limit. A limit of zero allows nothing but rounding.
    fn judge(&mut self, difference: f64, error: f64, limit: f64, at: impl Fn(f64) -> Self) -> bool {
        let value = difference.abs() - error;
        // Most values are below the worst so far, which needs no division to be seen.
        if value <= 0.0
            || limit == f64::INFINITY
            || value <= limit * self.ratio && self.ratio <= 1.0
        {
            return true;
        }
        let ratio = if limit > 0.0 { value / limit } else { f64::INFINITY };
        self.raise(at(ratio));
        ratio <= 1.0
    }

    /// Keeps the larger ratio.
    pub(crate) fn raise(&mut self, other: Self) {
        if other.ratio > self.ratio {
            *self = other;
        }
    }
}
