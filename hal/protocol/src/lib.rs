//! Requests and replies between the Ferrule engine and its clients, and the client.
//!
//! On the socket each message is one line of JSON, answered in order. Floats that are not finite
//! and 64-bit integers are strings. The same types serve inside one process: whoever can answer
//! requests is a [`Link`].
#![expect(unsafe_code, reason = "maps rings that the engine hands over, asks who is at a socket")]

mod at;
mod client;
mod code;
mod failure;
mod finding;
mod flight;
mod folder;
mod info;
mod kind;
mod message;
mod order;
mod pattern;
mod place;
mod reply;
mod sample;
mod samples;
mod stream;
mod value;
mod wire;

pub use at::At;
pub use client::{Client, NOT_RUNNING};
pub use code::Code;
pub use failure::Failure;
pub use finding::{Finding, Level, Related};
pub use flight::{FlightInfo, FlightSpec, KeptInfo, KeptState};
pub use folder::{Folder, FolderError, peer};
pub use info::{
    AliasInfo, ArgInfo, CommandInfo, ComponentInfo, ComponentState, FaultInfo, ForeignInfo,
    ForeignPart, FunctInfo, ItemInfo, Offer, RealtimeInfo, SignalInfo, StatusInfo, StreamInfo,
    ThreadInfo, TicketInfo, Usage,
};
pub use kind::{Direction, Kind, Lock};
pub use message::{Edit, LATEST, LONGEST, Request};
pub use order::{
    AddedInfo, DelayInfo, HopInfo, LateInfo, LoopInfo, MoveInfo, OrderInfo, PathInfo, ThreadOrder,
    WayInfo,
};
pub use pattern::Patterns;
pub use place::{Place, valid_instance};
pub use reply::{Answer, Reply};
pub use sample::{ChannelInfo, MOST_CHANNELS, SampleInfo, SampleSpec, SampleState};
pub use samples::{Samples, Stamp};
pub use stream::Stream;
pub use value::{Type, Value, ValueError};
pub use wire::{WireReply, WireRequest};

/// Something that answers requests: the engine in this process, or a connection to one.
pub trait Link {
    /// Carries out one request.
    ///
    /// # Errors
    /// Why it was refused, in the user's words.
    fn call(&mut self, request: Request) -> Result<Reply, Failure>;

    /// What is asked from here on stands at this place of a script: the engine keeps it with what
    /// it makes, so that findings can name it.
    fn at(&mut self, file: &str, line: u32) {
        // Whoever has no use for it forgets it.
        let _: (&str, u32) = (file, line);
    }

    /// Whether the engine is in this process: the programs that a script starts are then the
    /// engine's children.
    fn is_local(&self) -> bool {
        false
    }

    /// Whether the engine has been asked to end: a script then stops, whatever its lines are.
    fn is_ending(&self) -> bool {
        false
    }
}
