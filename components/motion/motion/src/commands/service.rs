//! The service `motion`: commands of other plugins, read as the text commands are.

use crate::{
    commands::{call::Call, command::Request, interface::CommandInterface},
    path::QUEUE_LEN as PATH_LEN,
};
use hal_component::{
    Error, Motion, MotionCommand, MotionSource, MotionStatus, Sender, SnapshotReader, TicketHandle,
    Touch, Uses, motion_kind,
};
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// Moves that may reach the path between two records of the status.
const MARGIN: usize = 64;

/// Places of the queue to the realtime side that moves leave free, so that an abort finds one.
const RESERVED: usize = 32;

/// The motion controller for other plugins.
pub(crate) struct Service {
    pub(crate) interface: CommandInterface,
    /// The second queue, from the command handler to the controller.
    pub(crate) handled: Sender<crate::commands::command::Command>,
    pub(crate) status: SnapshotReader<MotionStatus>,
    pub(crate) claimed: Arc<AtomicBool>,
}

impl Motion for Service {
    fn push(
        &self,
        source: MotionSource,
        command: &MotionCommand,
        end: TicketHandle,
    ) -> Result<(), Error> {
        let call = Call::of(command)?;
        if command.kind == motion_kind::CONFIGURE {
            self.interface.configure(call)?;
            end.done();
            return Ok(());
        }
        let request = self.interface.request(command.kind, call)?;
        let given = call.epoch();
        if matches!(request, Request::Move(_) | Request::PathOutput(_)) && self.room() == 0 {
            return Err(full());
        }
        self.interface.send(request, source, given, end).map_err(|_| full())
    }

    /// Returns the number of moves that the queue to the path and the path itself have room for.
    fn room(&self) -> u32 {
        // The queues are read before the path, so that a move between them counts twice and is never missed.
        let queued = self.interface.to.waiting();
        let handled = self.handled.waiting();
        let Some(status) = self.status.get() else { return 0 };
        let depth = usize::try_from(status.queue).unwrap_or(PATH_LEN);
        let path = PATH_LEN.saturating_sub(MARGIN + depth + queued + handled);
        let queue = crate::QUEUE_LEN.saturating_sub(RESERVED + queued);
        u32::try_from(path.min(queue)).unwrap_or(0)
    }

    fn setting(&self, command: &MotionCommand) -> Result<f64, Error> {
        self.interface.setting(command)
    }

    fn claim(&self, on: bool) {
        // Relaxed: the command queue orders it before the commands that follow.
        self.claimed.store(on, Ordering::Relaxed);
    }

    fn status(&self) -> Option<MotionStatus> {
        self.status.get().filter(|s| s.cycle > 0)
    }

    fn epoch(&self) -> u64 {
        self.interface.line.epoch().number()
    }
}

impl Touch for Service {
    fn touch(&self, uses: &mut Uses) {
        self.interface.to.touch(uses);
    }
}

fn full() -> Error {
    Error::again("too many commands wait: is motion-command-handler in a running thread?")
}
