//! The worker: the core between motion, iocontrol, files and users.

mod files;
mod machine;

use crate::{
    command_record::Letters,
    core::{Core, Mode, user::Command},
    outside::Outside as _,
    pins::Pins,
    status::{Report, TaskStatus, operator_view},
};
use hal_component::{
    Builder, IoControlRef, MotionRef, OperatorRef, OperatorRequest, Snapshot, StopEpoch,
    TicketHandle, Touch, Uses, Work,
};
use hal_gcode::parameters::file::ParameterFile;
use hal_job::{places::Output, user_programs::UserPrograms};
use hal_remap::Functions;
use machine::Machine;
use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Circumstances in which a command was given.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    /// Stop epoch.
    pub(crate) epoch: StopEpoch,
    /// By people elsewhere.
    pub(crate) is_from_afar: bool,
}

/// State that commands and the worker share.
#[derive(Default)]
pub(crate) struct SharedState {
    /// Commands, each with how it was given.
    pub(crate) inbox: VecDeque<(Command, Given, TicketHandle)>,
    /// The core of a machine whose files have been read.
    pub(crate) opened: Option<(Box<Core>, Files)>,
    pub(crate) report: Report,
}

/// The files of a machine that the task writes or guards, and the folders of user programs.
#[derive(Debug, Default)]
pub(crate) struct Files {
    pub(crate) parameters: Option<(PathBuf, ParameterFile)>,
    pub(crate) table: Option<PathBuf>,
    /// The record of the tool in the spindle.
    pub(crate) spindle: Option<PathBuf>,
    pub(crate) journal: Option<PathBuf>,
    pub(crate) codes: UserPrograms,
    /// The folder of the files that programs write.
    pub(crate) output: Option<Output>,
    /// Files that the INI file consists of or names.
    pub(crate) named: Vec<PathBuf>,
    pub(crate) letters: Letters,
    /// Functions in Python.
    pub(crate) functions: Option<Functions>,
}

impl Files {
    /// Returns the files that the task itself writes, and those that the INI file names.
    fn of_the_machine(&self) -> Vec<&Path> {
        let parameters = self.parameters.as_ref().map(|(path, _)| path);
        let written =
            [parameters, self.table.as_ref(), self.spindle.as_ref(), self.journal.as_ref()];
        written.into_iter().flatten().chain(&self.named).map(PathBuf::as_path).collect()
    }
}

/// State that the commands and the worker share.
#[derive(Clone, Default)]
pub(crate) struct Shared(Arc<Mutex<SharedState>>);

impl Shared {
    pub(crate) fn lock(&self) -> MutexGuard<'_, SharedState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The worker.
pub(crate) struct Worker {
    shared: Shared,
    core: Option<Box<Core>>,
    world: Machine,
    pins: Pins,
    snapshot: Snapshot<TaskStatus>,
}

impl Worker {
    pub(crate) fn new(
        shared: Shared,
        motion: MotionRef,
        io: IoControlRef,
        operator: Option<OperatorRef>,
        b: &Builder<'_>,
        pins: Pins,
        snapshot: Snapshot<TaskStatus>,
    ) -> Self {
        let world = Machine::new(motion, io, operator, b.clock(), b.messages(), b.values());
        Self { shared, core: None, world, pins, snapshot }
    }
}

impl Touch for Worker {
    fn touch(&self, uses: &mut Uses) {
        self.world.motion.touch(uses);
        self.world.io.touch(uses);
        self.pins.touch(uses);
        self.world.operator.iter().for_each(|operator| operator.touch(uses));
    }
}

impl Work for Worker {
    fn work(&mut self, items: u32) -> u32 {
        let (opened, commands) = {
            let mut shared_state = self.shared.lock();
            let opened = shared_state.opened.take();
            if opened.is_none() && self.core.is_none() {
                return 0;
            }
            (opened, core::mem::take(&mut shared_state.inbox))
        };
        if let Some((core, files)) = opened {
            self.world.open(&core, files);
            self.core = Some(core);
        }
        let Some(mut core) = self.core.take() else { return 0 };
        self.world.refresh();
        // A stop among the commands raises the epoch; those after it were given after it.
        let mut renewed = None;
        for (command, Given { epoch: arrived, is_from_afar }, handle) in commands {
            let ticket = self.world.ticket(handle);
            let since = renewed.filter(|(before, _)| *before == arrived);
            let given = since.map_or(arrived, |(_, now)| now);
            let is_stop = command.is_stop();
            core.is_from_afar = is_from_afar;
            core.command(command, given, ticket, &mut self.world);
            core.is_from_afar = false;
            if is_stop {
                renewed = Some((arrived, self.world.epoch()));
            }
        }
        if let Some(operator) = self.world.operator.clone() {
            while let Some((request, given)) = operator.take() {
                let ticket = self.world.button();
                let given = given.unwrap_or_else(|| self.world.epoch());
                core.command(Command::from(request), given, ticket, &mut self.world);
            }
        }
        if self.pins.aborts() {
            let ticket = self.world.button();
            let now = self.world.epoch();
            core.command(Command::Abort, now, ticket, &mut self.world);
        }
        self.world.claim(&core);
        let done = core.step(&mut self.world, items);
        self.world.claim(&core);
        self.pins.show(core.has_work());
        let (io, now) = (self.world.io.state(), self.world.now());
        let report = Report::of(&core, &self.world.status, &io, now);
        if let Some(operator) = &self.world.operator {
            operator.show(&operator_view(&core, &self.world.io.state()));
        }
        let mut shared_state = self.shared.lock();
        if let Some(status) = report.status
            && shared_state.report.status != report.status
        {
            self.snapshot.set(&status);
        }
        shared_state.report = report;
        drop(shared_state);
        self.core = Some(core);
        done
    }
}

impl From<OperatorRequest> for Command {
    fn from(request: OperatorRequest) -> Self {
        match request {
            OperatorRequest::Mode(0) => Self::Mode(Mode::Manual),
            OperatorRequest::Mode(1) => Self::Mode(Mode::Auto),
            OperatorRequest::Mode(_) => Self::Mode(Mode::Mdi),
            OperatorRequest::Run => Self::Run,
            OperatorRequest::Pause => Self::Pause,
            OperatorRequest::Resume => Self::Resume,
            OperatorRequest::Step => Self::Step,
            OperatorRequest::Stop => Self::Abort,
            OperatorRequest::OptionalStop(on) => Self::OptionalStop(on),
            OperatorRequest::BlockDelete(on) => Self::BlockDelete(on),
            OperatorRequest::Mdi(line) => Self::BriefMdi(line.into()),
        }
    }
}
