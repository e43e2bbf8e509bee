//! Realtime. The waypoints of `moveoff`.

/// The most joints.
pub(crate) const MOST: usize = 9;

/// How many waypoints there is room for, and how many in a test.
pub(crate) const ROOM: usize = 1000;
pub(crate) const TEST_ROOM: usize = 50;

/// The least of `epsilon`.
pub(crate) const EPSILON: f64 = 0.0001;

/// Where all joints' offsets are.
pub(crate) type Place = [f64; MOST];

/// The way that the offsets went, and where they go.
#[derive(Debug)]
pub(crate) struct Path {
    pub(crate) phase: Phase,
    pub(crate) waypoints: Box<[Place; ROOM]>,
    pub(crate) count: usize,
    /// When the last was noted, in nanoseconds, and where.
    pub(crate) noted: (i64, Place),
    pub(crate) target: Place,
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
            waypoints: Box::new([[0.0; MOST]; ROOM]),
            count: 0,
            noted: (0, [0.0; MOST]),
            target: [0.0; MOST],
            epsilon: EPSILON,
            seconds: 0.0,
            threshold: 0.0,
            room: ROOM,
            warned: false,
        }
    }
}

/// What is done with the offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Waits,
    Offsets,
    GoesBack,
}
