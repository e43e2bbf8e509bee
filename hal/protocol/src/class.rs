//! Classes of requests.

use crate::Request;

/// Class of a request: the part of an engine that handles it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Concerns the client itself: its greeting, its component, its streams and samples.
    Own,
    /// Is answered after a wait.
    Wait,
    /// Changes graph, values or locks, and can be reverted: a line of a script for `apply`.
    Edit,
    /// Changes nothing.
    Query,
    /// Acts on the machine, and cannot be reverted.
    Action,
    /// Acts on programs or files outside the engine. A dry run leaves it out.
    Outside,
}

impl Request {
    /// Returns the class of this request.
    #[must_use]
    pub const fn class(&self) -> Class {
        match self {
            Self::Hello { .. }
            | Self::Join { .. }
            | Self::NewPin { .. }
            | Self::Ready
            | Self::Unready
            | Self::Leave
            | Self::SharePins { .. }
            | Self::Sleep { .. }
            | Self::Poll { .. }
            | Self::Attach { .. }
            | Self::Sample(_)
            | Self::SampleState { .. }
            | Self::EndSample { .. }
            | Self::MapSnapshot { .. } => Class::Own,
            Self::Run { .. } | Self::Ticket { .. } | Self::Idle { .. } | Self::Await { .. } => {
                Class::Wait
            }
            Self::Load { .. }
            | Self::LoadForeign { .. }
            | Self::Unload { .. }
            | Self::UnloadAll
            | Self::NewSignal { .. }
            | Self::DeleteSignal { .. }
            | Self::Net { .. }
            | Self::Link { .. }
            | Self::Unlink { .. }
            | Self::Set { .. }
            | Self::SetSignal { .. }
            | Self::AddFunct { .. }
            | Self::RemoveFunct { .. }
            | Self::Start
            | Self::Alias { .. }
            | Self::Unalias { .. }
            | Self::SetLock { .. }
            | Self::ClearLock { .. } => Class::Edit,
            Self::Get { .. }
            | Self::GetSignal { .. }
            | Self::List { .. }
            | Self::Status
            | Self::Order
            | Self::Component { .. }
            | Self::FlightState
            | Self::Snapshot { .. }
            | Self::Check => Class::Query,
            Self::Apply { .. }
            | Self::Stop
            | Self::Timing { .. }
            | Self::MessageLevel { .. }
            | Self::Command { .. }
            | Self::Shutdown => Class::Action,
            Self::Adopt { .. }
            | Self::EndProgram { .. }
            | Self::Record { .. }
            | Self::EndRecord
            | Self::Flight(_)
            | Self::EndFlight
            | Self::SaveFlight { .. } => Class::Outside,
        }
    }
}
