//! Realtime. Waypoints of `moveoff`.

/// Maximum number of joints.
pub(crate) const MAX: usize = 9;

/// Number of waypoints that can be stored, normally and in tests.
pub(crate) const MAX_WAYPOINTS: usize = 1000;
pub(crate) const MAX_TEST_WAYPOINTS: usize = 50;

/// Minimum of `epsilon`.
pub(crate) const EPSILON: f64 = 0.0001;

/// Offsets of all joints.
pub(crate) type Offsets = [f64; MAX];

/// Recorded path of the offsets, and their target.
#[derive(Debug)]
pub(crate) struct Path {
    pub(crate) phase: Phase,
    pub(crate) waypoints: Box<[Offsets; MAX_WAYPOINTS]>,
    pub(crate) count: usize,
    /// Time of the last waypoint in nanoseconds, and its offsets.
    pub(crate) noted: (i64, Offsets),
    pub(crate) target: Offsets,
    pub(crate) epsilon: f64,
    pub(crate) seconds: f64,
    pub(crate) threshold: f64,
    pub(crate) room: usize,
    pub(crate) warned: bool,
}

impl Default for Path {
    fn default() -> Self {
        Self {
            phase: Phase::Waits,
            waypoints: Box::new([[0.0; MAX]; MAX_WAYPOINTS]),
            count: 0,
            noted: (0, [0.0; MAX]),
            target: [0.0; MAX],
            epsilon: EPSILON,
            seconds: 0.0,
            threshold: 0.0,
            room: MAX_WAYPOINTS,
            warned: false,
        }
    }
}

/// Activity of the offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Waits,
    Offsets,
    GoesBack,
}
