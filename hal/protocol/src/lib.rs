//! Requests and replies between the Ferrule engine and its clients, and the client.
//!
//! On the socket each message is one line of JSON. The engine answers requests in order. Floats
//! that are not finite and 64-bit integers are sent as strings. The same types are used inside one
//! process: everything that can answer requests is a [`Link`].
#![expect(unsafe_code, reason = "maps rings that the engine hands over, asks who is at a socket")]

mod argument;
mod at;
mod at_end;
mod class;
mod client;
mod code;
mod failure;
mod finding;
mod flight;
mod folder;
mod info;
mod kind;
mod message;
mod near;
mod order;
mod orders;
mod pattern;
mod peer;
mod pins;
mod place;
mod reply;
mod sample;
mod samples;
mod snapshot;
mod stop;
mod stream;
mod value;
mod wire;
mod worker;

pub use argument::{ArgInfo, Bounds};
pub use at::At;
pub use at_end::{CommandLine, MAX_AT_END};

pub use client::{Client, INTERRUPTED, NOT_FROM_AFAR, NOT_RUNNING};
pub use code::Code;
pub use failure::Failure;
pub use finding::{Finding, Level, Related};
pub use flight::{FlightInfo, FlightSpec, KeptInfo, KeptState};
pub use folder::{Folder, FolderError};
pub use info::{
    AliasInfo, CommandInfo, ComponentInfo, ComponentState, FaultInfo, ForeignInfo, ForeignPart,
    FunctInfo, GapInfo, ItemInfo, Offer, RealtimeInfo, SignalInfo, StatusInfo, StoppedRecording,
    StreamInfo, ThreadInfo, TicketInfo, Usage,
};
pub use kind::{Direction, Kind, Lock};
pub use message::{
    ActionRequest, ByClass, Class, Edit, EditRequest, LATEST, MAX_LEN, OutsideRequest, OwnRequest,
    QueryRequest, Request, WaitRequest,
};
pub use near::nearest;
pub use order::{
    AddedInfo, DelayInfo, HopInfo, LateInfo, LoopInfo, MoveInfo, OrderInfo, PathInfo, ThreadOrder,
    WayInfo,
};
pub use orders::{Orders, Unlisted, Unserved};
pub use pattern::Patterns;
pub use peer::{peer, peer_process};
pub use pins::{MAX_PAGE_PINS, PinPage, PinPageInfo};
pub use place::{Place, valid_instance};
pub use reply::{Answer, Reply};
pub use sample::{ChannelInfo, MAX_CHANNELS, SampleInfo, SampleSpec, SampleState};
pub use samples::{Samples, Stamp};
pub use snapshot::{FieldInfo, Snapshot, SnapshotInfo, SnapshotValues};
pub use stop::{Missing, Stop, Stops};
pub use stream::Stream;
pub use value::{Type, Value, ValueError};
pub use wire::{WireReply, WireRequest};
pub use worker::{WorkerInfo, WorkerState};

/// Something that answers requests: the engine in this process, or a connection to one.
pub trait Link {
    /// Executes one request.
    ///
    /// # Errors
    /// The reason why the request failed, in the user's words.
    fn call(&mut self, request: Request) -> Result<Reply, Failure>;

    /// Executes one request. A link to another process fails once `wanted` returns false; it asks
    /// every 50 ms while there is no answer, and cannot be used afterwards.
    ///
    /// # Errors
    /// As [`Self::call`]; or the answer is not wanted any more.
    fn call_while(
        &mut self,
        request: Request,
        wanted: &mut dyn FnMut() -> bool,
    ) -> Result<Reply, Failure> {
        // A link that does not wait for another process always answers.
        let _: &mut dyn FnMut() -> bool = wanted;
        self.call(request)
    }

    /// Sets the script position for the requests that follow. The engine stores it with everything
    /// that these requests create, so that findings can name it.
    fn at(&mut self, file: &str, line: u32) {
        // A link that does not record positions ignores it.
        let _: (&str, u32) = (file, line);
    }

    /// Notes whether the scripts with which the instance starts are in progress. Only a link to an engine in this
    /// process does so.
    fn set_starting(&mut self, is_starting: bool) {
        let _: bool = is_starting;
    }

    /// Returns whether the engine is in this process. Programs that a script starts are then
    /// children of the engine's process.
    fn is_local(&self) -> bool {
        false
    }

    /// Returns whether the engine has been asked to end. A script then stops, whatever lines it
    /// still has.
    fn is_ending(&self) -> bool {
        false
    }
}
