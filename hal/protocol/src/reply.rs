//! Answers of the engine.

use crate::{
    AliasInfo, CommandInfo, ComponentInfo, Failure, Finding, FlightInfo, FunctInfo, ItemInfo,
    Offer, OrderInfo, PinPageInfo, SampleInfo, SampleState, SignalInfo, SnapshotInfo,
    SnapshotValues, StatusInfo, StreamInfo, ThreadInfo, TicketInfo, Value, WorkerInfo,
};
use serde::{Deserialize, Serialize};

/// An answer of the engine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply {
    /// Done.
    Done,
    /// The engine's side of [`crate::Request::Hello`].
    Hello {
        /// Protocol version of the engine, [`crate::LATEST`].
        protocol: u32,
        /// Name of the instance.
        instance: String,
        /// Release of the engine.
        version: String,
        /// The id of this client's component.
        id: u32,
    },
    /// All edits were applied, or could be applied (dry run).
    Applied {
        /// Number of stores at the cycle boundary.
        stores: u32,
        /// Number of threads that received new function lists.
        lists: u32,
    },
    /// An edit was refused, so none was applied.
    Refused {
        /// Index of the refused edit, from zero.
        edit: u32,
        /// Reason.
        failure: Failure,
    },
    /// A value with its type.
    Value(Value),
    /// Pin values in order of creation.
    Values {
        /// Machine time in nanoseconds.
        time: u64,
        /// Values of this client's pins.
        values: Vec<Value>,
    },
    /// Components.
    Components(Vec<ComponentInfo>),
    /// Pins or parameters.
    Items(Vec<ItemInfo>),
    /// Signals.
    Signals(Vec<SignalInfo>),
    /// Functions.
    Functs(Vec<FunctInfo>),
    /// Threads.
    Threads(Vec<ThreadInfo>),
    /// Aliases.
    Aliases(Vec<AliasInfo>),
    /// Commands.
    Commands(Vec<CommandInfo>),
    /// Shared rings.
    Streams(Vec<StreamInfo>),
    /// Workers.
    Workers(Vec<WorkerInfo>),
    /// Snapshots.
    Snapshots(Vec<SnapshotInfo>),
    /// The latest record of a snapshot.
    Snapshot(Box<SnapshotValues>),
    /// A snapshot's page to map.
    SnapshotPage(Box<SnapshotInfo>),
    /// A page of pin values to map.
    PinPage(PinPageInfo),
    /// Component types.
    Offers(Vec<Offer>),
    /// The state of the instance.
    Status(Box<StatusInfo>),
    /// Order of functions, and delays of values.
    Order(Box<OrderInfo>),
    /// Answer of a component's command.
    Answer(Answer),
    /// Progress of a command.
    Ticket(TicketInfo),
    /// A ring to attach to.
    Stream(StreamInfo),
    /// State of the flight recorder.
    Flight(FlightInfo),
    /// A sample that has begun.
    Sample(SampleInfo),
    /// State of a sample.
    SampleState(SampleState),
    /// Problems and oddities of the machine.
    Findings(Vec<Finding>),
}

/// Answer of a component's command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Answer {
    /// Lines of text for the user.
    pub lines: Vec<String>,
    /// Ticket number, if the command continues in machine time.
    pub ticket: Option<u64>,
    /// True if the caller must wait for the ticket even if the user did not ask for that, because
    /// the command can still fail in a way that the user has to see.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub awaited: bool,
}
