//! Data of `status`.

use crate::{ClockKind, Engine, graph::listing::Sizes};
use hal_protocol::{Patterns, StatusInfo};

impl Engine {
    /// Returns the answer to `status`.
    pub(crate) fn status(&self) -> StatusInfo {
        let Sizes { memory, components, pins, params, aliases, signals, functs, threads } =
            self.model.sizes();
        let shared = self.runtime.shared();
        let mut status = StatusInfo {
            instance: self.options.place.name().to_owned(),
            pid: std::process::id().cast_signed(),
            lock: self.model.lock(),
            memory,
            components,
            pins,
            params,
            aliases,
            signals,
            functs,
            threads,
            clock: match self.options.clock {
                ClockKind::Real => "real".to_owned(),
                ClockKind::Virtual => "virtual".to_owned(),
            },
            time: u64::try_from(shared.now()).unwrap_or(0),
            scheduling: self.runtime.scheduling().to_owned(),
            realtime: self.runtime.properties(),
            gaps: self.runtime.gap_info(),
            simulated: self.options.simulate,
            starting: self.is_starting,
            running: self.runtime.is_running() && shared.fault.get().is_none(),
            fault: self.runtime.fault().cloned(),
            stuck: self.runtime.stuck_funct(),
            foreign: self.foreign_parts(),
            workers: self.workers.list(&Patterns::default()),
            recording: None,
            recording_stopped: None,
        };
        self.observers.fill(&mut status);
        status
    }
}
