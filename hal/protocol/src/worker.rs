//! Workers of components, as `show` and `status` list them.

use serde::{Deserialize, Serialize};

/// Progress of a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WorkerState {
    /// The worker waits for its next step.
    Idle,
    /// A step is in progress.
    Working,
    /// The worker panicked and is not run again.
    Failed,
}

impl WorkerState {
    /// Returns the name that `show` prints.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Working => "working",
            Self::Failed => "failed",
        }
    }
}

/// A worker of a component.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkerInfo {
    /// Name of the worker.
    pub name: String,
    /// Name of its component.
    pub owner_name: String,
    /// Period of its steps in nanoseconds of machine time.
    pub period: i64,
    /// Maximum number of items of a step.
    pub most: u32,
    /// Number of steps made.
    pub steps: u64,
    /// Number of items done.
    pub items: u64,
    /// Progress.
    pub state: WorkerState,
    /// Description.
    pub doc: String,
}
