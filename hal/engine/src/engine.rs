//! An instance and its parts: the model, the runtime, what observes values, clients, and the log.

use crate::{
    ClockKind, Error, Options, ends, graph::Ix, graph::model::Model, messages::log::Log,
    observe::observers::Observers, observe::snapshot::Snapshots, realtime::resources::Realtime,
    realtime::runners::Scheduling, realtime::runtime::Runtime, realtime::worker::Workers,
    serve::clients::Clients, serve::server::Server,
};
use hal_protocol::{Failure, Offer, Patterns, TicketInfo};

/// The reason why [`Engine::serve`] returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// There are no threads (any more).
    NoThreads,
    /// A client requested the shutdown.
    Shutdown,
    /// A signal requested the shutdown.
    Signal,
    /// The requested time has passed.
    Time,
}

/// A running instance.
///
/// Each part has the fields that the files of its own room use; others call its methods.
#[derive(Debug)]
pub struct Engine {
    pub(crate) options: Options,
    pub(crate) clients: Clients,
    pub(crate) observers: Observers,
    pub(crate) log: Log,
    pub(crate) runtime: Runtime,
    pub(crate) workers: Workers,
    pub(crate) snapshots: Snapshots,
    /// True while the scripts with which the instance starts are in progress.
    pub(crate) is_starting: bool,
    /// In a dry run: the program's component that is being created.
    pub(crate) tried: Option<Ix>,
    /// The last field: everything else points into its values.
    pub(crate) model: Model,
}

impl Engine {
    /// Creates an instance and takes its socket.
    ///
    /// # Errors
    /// Another instance of this name is running, or the system refuses.
    pub fn new(options: Options) -> Result<Self, Failure> {
        let server = Server::open(&options.place)?;
        let mut engine = Self::without_socket(options)?;
        engine.clients.listen(server);
        engine.runtime.instance().attend();
        Ok(engine)
    }

    /// Creates an instance that no client can reach, for tests and benchmarks.
    ///
    /// # Errors
    /// The system refuses.
    pub fn without_socket(mut options: Options) -> Result<Self, Failure> {
        options.simulate |= options.clock == ClockKind::Virtual;
        let realtime = Realtime::find(&options)?;
        let fifo = realtime.scheduling == Scheduling::Fifo;
        Ok(Self {
            model: Model::new(options.path.clone(), fifo)?,
            runtime: Runtime::new(&options, realtime),
            clients: Clients::new(),
            observers: Observers::default(),
            log: Log::default(),
            workers: Workers::default(),
            snapshots: Snapshots::default(),
            is_starting: false,
            tried: None,
            options,
        })
    }

    /// Registers the components of a library that is linked into this program.
    pub fn add_static(&mut self, library: &'static hal_abi::Library) {
        self.model.loader().add_static(library);
    }

    /// Returns every component type that the plugins on the path offer, by name.
    pub fn catalogue(&mut self) -> Vec<Offer> {
        self.model.loader().catalogue(&Patterns::default())
    }

    /// Returns whether a signal or a client has asked the instance to end (a script then stops).
    #[must_use]
    pub fn is_ending(&self) -> bool {
        self.runtime.control().beat();
        self.clients.is_shutdown() || ends::is_asked()
    }

    /// Returns machine time in nanoseconds.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        self.runtime.now()
    }

    /// Returns the state of a command.
    pub(crate) fn result(&mut self, id: u64) -> Result<TicketInfo, Error> {
        self.clients.result(id, self.model.graph())
    }
}
