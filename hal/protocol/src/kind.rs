//! Directions of pins, kinds of lists, and lock levels.

use serde::{Deserialize, Serialize};

/// Direction of a pin or parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// A pin that its component reads.
    In,
    /// A pin that its component writes.
    Out,
    /// A pin that its component and others write.
    Io,
    /// A parameter that its component reports.
    Ro,
    /// A parameter that the user sets.
    Rw,
}

impl Direction {
    /// Returns the name that `show` prints.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::In => "IN",
            Self::Out => "OUT",
            Self::Io => "I/O",
            Self::Ro => "RO",
            Self::Rw => "RW",
        }
    }

    /// Returns whether this is the direction of a pin.
    #[must_use]
    pub const fn is_pin(self) -> bool {
        matches!(self, Self::In | Self::Out | Self::Io)
    }
}

/// Subject of [`crate::Request::List`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Components, newest first.
    Components,
    /// Pins, by name.
    Pins,
    /// Parameters, by name.
    Params,
    /// Signals, by name.
    Signals,
    /// Functions, by name.
    Functs,
    /// Threads, slowest (last created) first.
    Threads,
    /// Aliases of pins, by alias.
    PinAliases,
    /// Aliases of parameters, by alias.
    ParamAliases,
    /// Commands of components, by name.
    Commands,
    /// Shared rings, by name.
    Streams,
    /// Workers, in order of loading.
    Workers,
    /// Snapshots, by name.
    Snapshots,
    /// Component types that could be loaded, by name.
    Offers,
}

/// Bits of the lock level. A set bit locks that kind of change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lock(pub u8);

impl Lock {
    /// Nothing is locked.
    pub const NONE: Self = Self(0);
    /// Loading of components.
    pub const LOAD: Self = Self(1);
    /// Signals, links, aliases and functions in threads.
    pub const CONFIG: Self = Self(2);
    /// Parameters.
    pub const PARAMS: Self = Self(4);
    /// Starting and stopping.
    pub const RUN: Self = Self(8);
    /// Loading and configuration.
    pub const TUNE: Self = Self(3);
    /// Everything.
    pub const ALL: Self = Self(255);
}
