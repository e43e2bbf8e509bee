//! Everything outside the core: motion, iocontrol, files, users' programs and messages.

mod owner;

use super::{
    Files,
    files::{Bounds, ProgramFiles, written},
};
use crate::{
    command_record::record,
    core::{Core, Interpreting, is_stop},
    error::UserProgramError,
    journal_file::JournalFile,
    outside::{FileAction, Level, MotionState, Order, Outside, Progress, Refusal, Rights, Ticket},
    programs::UserProgram,
};
use hal_component::{
    Clock, HalValues, IoControlRef, IoRequest, IoState, Messages, MotionCommand, MotionEnd,
    MotionId, MotionRef, MotionRefusal, MotionToken, OperatorRef, StopEpoch, Texts, TicketHandle,
};
use hal_gcode::{Environment, Numbered, State, tool::ToolTable};
use hal_job::{
    journal::Record,
    spindle::{self, Spindle},
};
use std::{
    collections::{BTreeMap, VecDeque},
    path::Path,
    time::Duration,
};

/// Number of orders and of requests that are known after their end.
const MAX_KNOWN: usize = 2048;
/// Number of different messages of programs that the log shows.
const MAX_MESSAGES: usize = 4096;
/// Number of different errors, which programs cannot use up with their messages.
const MAX_REASONS: usize = 65_536;
/// Time for which the worker waits for a function, and then looks at the machine again.
const FUNCTION_WAIT: Duration = Duration::from_millis(2);
const NOT_OWNER: &str = "motion belongs to another controller";

/// Everything outside the core.
pub(super) struct Machine {
    pub(super) motion: MotionRef,
    pub(super) operator: Option<OperatorRef>,
    token: Option<MotionToken>,
    /// The token's claim is in force.
    claimed: bool,
    pub(super) io: IoControlRef,
    clock: Clock,
    messages: Messages,
    values: HalValues,
    /// Messages of programs, and errors.
    messages_kept: Texts,
    reasons: Texts,
    files: Files,
    saved: String,
    journal: JournalFile,
    /// Machine time of the begin of the last step of a function.
    step_began: i64,
    /// The last message.
    said: &'static str,
    program: UserProgram,
    program_files: ProgramFiles,
    /// Orders and requests in progress, with the numbers that the core has.
    orders: BTreeMap<u64, MotionId>,
    results: BTreeMap<u64, Progress>,
    tickets: BTreeMap<u64, TicketHandle>,
    /// Last requests of the operator, whose refusals are messages.
    buttons: VecDeque<u64>,
    next: u64,
    pub(super) status: MotionState,
}

impl Machine {
    pub(super) fn new(
        motion: MotionRef,
        io: IoControlRef,
        operator: Option<OperatorRef>,
        clock: Clock,
        messages: Messages,
        values: HalValues,
    ) -> Self {
        Self {
            motion,
            operator,
            token: None,
            claimed: false,
            io,
            clock,
            messages,
            values,
            messages_kept: Texts::new(MAX_MESSAGES),
            reasons: Texts::new(MAX_REASONS),
            files: Files::default(),
            saved: String::new(),
            journal: JournalFile::default(),
            step_began: 0,
            said: "",
            program: UserProgram::default(),
            program_files: ProgramFiles::default(),
            orders: BTreeMap::new(),
            results: BTreeMap::new(),
            tickets: BTreeMap::new(),
            buttons: VecDeque::new(),
            next: 0,
            status: MotionState::default(),
        }
    }

    /// Takes the files of a machine, and tells what is wrong with them.
    pub(super) fn open(&mut self, core: &Core, files: Files) {
        let machine = &core.world.machine;
        for remark in &machine.remarks {
            self.say(Level::Info, remark);
        }
        let tool = core.held.record.tool();
        if tool != 0 {
            let pocket = machine.tools.find(tool).map_or(tool, |t| t.pocket);
            self.request(IoRequest::SetTool { tool, pocket });
        }
        self.journal = JournalFile::new(files.journal.clone());
        self.files = files;
        let file = self.files.parameters.as_ref();
        if file.is_some_and(|(path, _)| !path.exists()) {
            // Programs with a page of offsets read the file from the start. The end of a job reports a failure.
            drop(self.save_parameters(&core.interpreter.state.numbered));
        }
    }

    /// Reads motion's status and the results of iocontrol.
    pub(super) fn refresh(&mut self) {
        if let Some(s) = self.motion.status() {
            self.status = MotionState {
                cycle: s.cycle,
                enabled: s.enabled,
                in_position: s.in_position,
                all_homed: s.all_homed,
                velocity: s.velocity,
                queue: s.queue,
                pose: s.pose,
                probe_found: s.probe_found,
                probe_measured: s.probe_measured,
                digital_in: s.digital_in,
                analog_in: s.analog_in,
                at_speed: s.at_speed,
                feed_override: s.feed_override,
                rapid_override: s.rapid_override,
                spindle_override: s.spindle_override,
                epoch: StopEpoch::of(s.epoch).unwrap_or_default(),
                wait: s.wait,
                wait_number: s.wait_number,
                wait_since: s.wait_since_ns as f64 * 1e-9,
                wait_ends: s.wait_ends,
                spindles_stopped: s.spindles_stopped,
                spindles_inhibited: s.spindles_inhibited,
                travelled: s.travelled,
                to_go: s.distance_to_go,
            };
        }
        while let Some(result) = self.io.result() {
            if let Some(place) = self.results.get_mut(&result.id) {
                *place =
                    result.failure.map_or(Progress::Done, |why| Progress::Failed(why.to_owned()));
            }
        }
    }

    pub(super) fn ticket(&mut self, handle: TicketHandle) -> Ticket {
        self.next += 1;
        self.tickets.insert(self.next, handle);
        Ticket(self.next)
    }

    /// Returns a ticket for a request of the operator, who waits for nothing.
    pub(super) fn button(&mut self) -> Ticket {
        self.next += 1;
        if self.buttons.len() >= MAX_KNOWN {
            self.buttons.pop_front();
        }
        self.buttons.push_back(self.next);
        Ticket(self.next)
    }
}

impl Outside for Machine {
    fn now(&self) -> f64 {
        self.clock.now_ns() as f64 * 1e-9
    }

    fn motion(&self) -> MotionState {
        self.status
    }

    fn io(&self) -> IoState {
        self.io.state()
    }

    fn epoch(&self) -> StopEpoch {
        self.motion.epoch()
    }

    fn order(&mut self, order: &Order, given: StopEpoch) -> Result<u64, Refusal> {
        let Some(token) = self.token() else {
            return Err(Refusal::Why(NOT_OWNER.into()));
        };
        let record = MotionCommand { epoch: given.number(), ..record(order, self.files.letters) };
        match self.motion.push(token, &record) {
            Ok(id) => {
                self.next += 1;
                self.orders.insert(self.next, id);
                self.forget_orders();
                // At rest no longer, whatever the status of the last cycle says.
                self.status.in_position &= !matches!(order, Order::Move(_));
                Ok(self.next)
            }
            Err(MotionRefusal::Full) => Err(Refusal::Full),
            Err(MotionRefusal::NotOwner) => {
                self.lose_token();
                Err(Refusal::Why(NOT_OWNER.into()))
            }
            Err(MotionRefusal::Refused(why)) => Err(Refusal::Why(why.into())),
        }
    }

    fn ordered(&mut self, id: u64) -> Progress {
        let Some(motion) = self.orders.get(&id) else { return Progress::Done };
        let progress = match self.motion.poll(*motion) {
            MotionEnd::Pending => return Progress::Pending,
            MotionEnd::Done | MotionEnd::Forgotten => Progress::Done,
            MotionEnd::Failed(why) => Progress::Failed(why),
        };
        self.orders.remove(&id);
        progress
    }

    fn request(&mut self, request: IoRequest) -> Option<u64> {
        let id = self.io.request(request)?;
        self.results.insert(id, Progress::Pending);
        // The core waits for two requests at the most, and commands for as many as iocontrol takes.
        while self.results.len() > MAX_KNOWN {
            self.results.pop_first();
        }
        Some(id)
    }

    fn requested(&mut self, id: u64) -> Progress {
        match self.results.get(&id) {
            None => Progress::Done,
            Some(Progress::Pending) => Progress::Pending,
            Some(_) => self.results.remove(&id).unwrap_or(Progress::Done),
        }
    }

    fn ask_value(&mut self, name: &str) -> u64 {
        self.values.ask(name)
    }

    fn take_value(&mut self, question: u64) -> Option<Option<f64>> {
        self.values.answer(question)
    }

    fn begin_program(
        &mut self,
        code: u16,
        p: f64,
        q: f64,
        rights: Rights,
    ) -> Result<(), UserProgramError> {
        self.program.begin(&self.files.codes, code, [p, q], rights)
    }

    fn program(&mut self) -> Progress {
        self.program.progress()
    }

    fn end_program(&mut self) {
        self.program.end();
    }

    fn begin_function(&mut self, state: &State, env: &dyn Environment) -> Result<(), String> {
        self.step_began = self.clock.now_ns();
        let functions = self.files.functions.as_mut();
        let functions = functions.ok_or("the INI file has no section PYTHON")?;
        functions.begin(state, env)
    }

    fn function(&mut self) -> hal_remap::Progress {
        let Some(functions) = &mut self.files.functions else {
            return hal_remap::Progress::Failed("the INI file has no section PYTHON".to_owned());
        };
        let begun = self.clock.now_ns();
        loop {
            let (was_ready, progress) = (functions.is_ready(), functions.progress(FUNCTION_WAIT));
            if progress != hal_remap::Progress::Pending {
                return progress;
            }
            // The virtual clock stands still while the worker is at work: then a function takes no machine time.
            let now = self.clock.now_ns();
            // The import of the modules is no part of the step.
            if functions.is_ready() != was_ready {
                self.step_began = now;
            }
            if u128::from(now.abs_diff(self.step_began)) >= functions.timeout().as_nanos() {
                return hal_remap::Progress::Failed(functions.give_up());
            }
            if now != begun {
                return hal_remap::Progress::Pending;
            }
        }
    }

    fn end_functions(&mut self) {
        if let Some(functions) = self.files.functions.as_mut().filter(|f| f.is_busy()) {
            functions.end();
        }
    }

    fn say(&mut self, level: Level, text: &str) {
        match level {
            Level::Error => {
                self.said = self.reasons.keep(text);
                self.messages.error(self.said, &[]);
            }
            Level::Notice => {
                self.said = self.messages_kept.keep(text);
                self.messages.notice(self.said, &[]);
            }
            Level::Info => {
                self.said = self.messages_kept.keep(text);
                self.messages.info(self.said, &[]);
            }
        }
    }

    fn finish(&mut self, ticket: Ticket, result: Result<(), String>) {
        if let Some(n) = self.buttons.iter().position(|b| *b == ticket.0) {
            self.buttons.remove(n);
            // A job that has failed has said why.
            if let Err(why) = &result
                && self.said != self.reasons.keep(why)
            {
                self.say(if is_stop(why) { Level::Info } else { Level::Error }, why);
            }
        }
        let Some(handle) = self.tickets.remove(&ticket.0) else { return };
        match result {
            Ok(()) => handle.done(),
            Err(why) => handle.fail(self.reasons.keep(&why)),
        }
    }

    fn save_parameters(&mut self, numbered: &Numbered) -> Result<(), String> {
        let Some((path, file)) = &self.files.parameters else { return Ok(()) };
        let text = file.save(numbered);
        if text == self.saved {
            return Ok(());
        }
        written(path, &text)?;
        self.saved = text;
        Ok(())
    }

    fn journal(&mut self, record: &Record) -> Result<(), String> {
        self.journal.write(record)
    }

    fn read_journal(&self) -> Result<Vec<u8>, String> {
        self.journal.read()
    }

    fn file(&mut self, action: &FileAction, program: Option<&Path>) -> Result<(), String> {
        let own = self.files.of_the_machine();
        let output = self.files.output.as_ref();
        self.program_files.act(action, Bounds { output, program, own: &own })
    }

    fn save_tools(&mut self, tools: &ToolTable) -> Result<(), String> {
        self.files.table.as_ref().map_or(Ok(()), |path| written(path, &tools.print()))
    }

    fn save_spindle(&mut self, before: Spindle, now: Spindle) -> Result<(), String> {
        let path = self.files.spindle.as_ref();
        path.map_or(Ok(()), |path| written(path, &spindle::print(before, now)))
    }
}
