//! Threads: G33, G33.1 and G76.

use crate::{
    canon::{Call, Direction},
    error::Problem,
    interpret::{Run, block::Block},
};

/// The most passes of G76.
const MAX_PASSES: u32 = 100_000;

/// A thread of G76.
struct Thread {
    start: crate::axis::Position,
    end: crate::axis::Position,
    pitch: f64,
    spindle: u8,
    /// The signed distance from the drive line to the thread's peak.
    peak: f64,
    /// The depth from the peak.
    depth: f64,
    /// 1 for inside threads, -1 for outside ones.
    inward: f64,
    /// The tangent of the infeed's angle.
    slope: f64,
    entry: bool,
    exit: bool,
    taper: f64,
}

impl Run<'_> {
    fn turning_spindle(&self, b: &Block, code: &'static str) -> Result<u8, Problem> {
        let spindle = self.spindle(b, code)?.unwrap_or(0);
        let state = self.state.modal.spindles.get(usize::from(spindle));
        match state.map(|s| s.direction) {
            None | Some(Direction::Stopped) => Err(Problem::SpindleOff { code }),
            Some(_) => Ok(spindle),
        }
    }

    fn sync(&mut self, pitch: f64, spindle: u8) -> Result<(), Problem> {
        self.emit(Call::StartSpeedFeedSync { pitch, velocity_mode: false, spindle })
    }

    pub(super) fn thread_pass(&mut self, b: &Block) -> Result<(), Problem> {
        self.without_compensation(330)?;
        let spindle = self.turning_spindle(b, "G33")?;
        let pitch = b.get(b'k').ok_or(Problem::ThreadNeedsK)?;
        let end = self.target(b)?;
        self.sync(pitch, spindle)?;
        self.feed(end)?;
        self.emit(Call::StopSpeedFeedSync)
    }

    pub(super) fn rigid_tap(&mut self, b: &Block) -> Result<(), Problem> {
        self.without_compensation(331)?;
        let spindle = self.turning_spindle(b, "G33.1")?;
        let pitch = b.get(b'k').ok_or(Problem::ThreadNeedsK)?;
        let end = self.target(b)?;
        let retract_scale = b.get(b'i').filter(|i| *i > 0.0).unwrap_or(1.0);
        self.sync(pitch, spindle)?;
        // The tap ends where it began.
        self.emit(Call::RigidTap { end, retract_scale })?;
        self.emit(Call::StopSpeedFeedSync)
    }

    pub(super) fn thread_cycle(&mut self, b: &Block) -> Result<(), Problem> {
        let odd = |detail| Err(Problem::G76Words { detail });
        self.without_compensation(760)?;
        let (Some(i), Some(j), Some(k)) = (b.get(b'i'), b.get(b'j'), b.get(b'k')) else {
            return odd("I J or K words missing with G76");
        };
        let Some(pitch) = b.get(b'p') else { return odd("P word missing with G76") };
        let half = if self.state.modal.diameter { 0.5 } else { 1.0 };
        let (i, j, k) = (i * half, j * half, k * half);
        let degression = b.get(b'r').unwrap_or(1.0);
        let spring = match b.integer(b'h')?.map_or(Ok(0), u32::try_from) {
            Ok(h) if h <= MAX_PASSES => h,
            _ => return odd("Negative H word used"),
        };
        let taper_mode = b.integer(b'l')?.unwrap_or(0);
        let taper = b.get(b'e').unwrap_or(0.0);
        if j <= 0.0 {
            return odd("In G76, J must be greater than 0");
        }
        if k < j {
            return odd("In G76, K must be greater than J");
        }
        if i == 0.0 {
            return odd("In G76, I must not be 0");
        }
        if degression < 1.0 {
            return odd("R must be at least 1 with G76");
        }
        if !(0..=3).contains(&taper_mode) {
            return odd("L must be 0, 1, 2 or 3 with G76");
        }
        if taper_mode != 0 && taper <= 0.0 {
            return odd("E must be positive with G76 L1, L2 or L3");
        }
        if b.has_any(b"yabcuvw") {
            return odd("Cannot use axes other than X and Z with G76");
        }
        let spindle = self.turning_spindle(b, "G76")?;
        let end = self.target(b)?;
        let thread = Thread {
            start: self.state.position,
            end,
            pitch,
            spindle,
            peak: i,
            depth: k,
            inward: if i > 0.0 { 1.0 } else { -1.0 },
            slope: libm::tan(b.get(b'q').unwrap_or(0.0).to_radians()),
            entry: taper_mode & 1 != 0,
            exit: taper_mode & 2 != 0,
            taper,
        };
        self.thread_passes(&thread, j, degression, spring)
    }

    fn thread_passes(
        &mut self,
        t: &Thread,
        first: f64,
        degression: f64,
        spring: u32,
    ) -> Result<(), Problem> {
        let mut pass = 1u32;
        let mut cut = first;
        while cut < t.depth {
            self.thread_cut(t, cut)?;
            pass += 1;
            if pass > MAX_PASSES {
                return Err(Problem::OutputTooLarge { limit: 100_000 });
            }
            cut = first * libm::pow(f64::from(pass), 1.0 / degression);
        }
        for _ in 0..=spring {
            self.thread_cut(t, t.depth)?;
        }
        self.rapid(t.end)
    }

    /// Makes one pass at the depth `cut` below the peak.
    fn thread_cut(&mut self, t: &Thread, cut: f64) -> Result<(), Problem> {
        let along = if t.end.z > t.start.z { 1.0 } else { -1.0 };
        let taper_pitch = t.pitch * libm::hypot(t.taper, t.depth) / t.taper;
        let safe = t.start.x - t.inward * (t.depth - cut);
        let peak = safe + t.peak;
        let bottom = peak + t.inward * t.depth;
        let first_z = t.start.z + along * cut * t.slope;
        let last_z = t.end.z - along * (t.depth - cut) * t.slope;
        let at = |x: f64, z: f64| crate::axis::Position { x, z, ..t.start };
        self.rapid(at(safe, first_z))?;
        if t.entry {
            self.emit(Call::FeedOverride(false))?;
            self.sync(taper_pitch, t.spindle)?;
            self.feed(at(peak, first_z))?;
            self.feed(at(bottom, first_z + along * t.taper))?;
        } else {
            self.rapid(at(bottom, first_z))?;
            self.emit(Call::FeedOverride(false))?;
        }
        self.sync(t.pitch, t.spindle)?;
        if t.exit {
            self.feed(at(bottom, last_z - along * t.taper))?;
            self.sync(taper_pitch, t.spindle)?;
            self.feed(at(peak, last_z))?;
        } else {
            self.feed(at(bottom, last_z))?;
        }
        self.emit(Call::StopSpeedFeedSync)?;
        self.rapid(at(safe, last_z))?;
        self.emit(Call::FeedOverride(true))
    }
}
