//! What the engine answers.

use crate::{
    AliasInfo, CommandInfo, ComponentInfo, Failure, Finding, FlightInfo, FunctInfo, ItemInfo,
    Offer, OrderInfo, SampleInfo, SampleState, SignalInfo, StatusInfo, StreamInfo, ThreadInfo,
    TicketInfo, Value,
};
use serde::{Deserialize, Serialize};

/// What the engine answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply {
    /// Done.
    Done,
    /// Done, with sentences that a user who asked for them sees (`-v`), or warnings.
    Noted(Vec<String>),
    /// The engine's side of [`crate::Request::Hello`].
    Hello {
        /// Its [`crate::LATEST`].
        protocol: u32,
        /// The instance.
        instance: String,
        /// Its release.
        version: String,
        /// The id of this client's component.
        id: u32,
    },
    /// All edits are carried out, or could be.
    Applied {
        /// How many stores that took at the boundary.
        stores: u32,
        /// How many threads were given new lists of functions.
        lists: u32,
    },
    /// One edit is refused: none is carried out.
    Refused {
        /// Which one, from zero.
        edit: u32,
        /// Why.
        failure: Failure,
    },
    /// A value with its type.
    Value(Value),
    /// Values in order.
    Values {
        /// Machine time in nanoseconds.
        time: u64,
        /// Of this client's pins.
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
    /// Component types.
    Offers(Vec<Offer>),
    /// The state of the instance.
    Status(Box<StatusInfo>),
    /// The order of functions, and how long values wait.
    Order(Box<OrderInfo>),
    /// What a component's command answered.
    Answer(Answer),
    /// How far a command has come.
    Ticket(TicketInfo),
    /// A ring to attach to.
    Stream(StreamInfo),
    /// How the flight recorder is.
    Flight(FlightInfo),
    /// A sample that has begun.
    Sample(SampleInfo),
    /// How a sample is.
    SampleState(SampleState),
    /// What is wrong or odd.
    Findings(Vec<Finding>),
}

/// What a component's command answered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Answer {
    /// Lines for the user.
    pub lines: Vec<String>,
    /// Set when the command goes on in machine time.
    pub ticket: Option<u64>,
    /// Whether the caller is to wait for the ticket even if nobody asked it to: the command may
    /// yet fail in a way that nobody may miss.
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    pub awaited: bool,
}
