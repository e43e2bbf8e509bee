//! The core on a machine that notes what it is sent.

mod check;
mod entry;
mod fake;
mod functions;
mod job;
mod real;
mod recover;
mod refused;
mod restart;
mod rs274d;
mod spindle;
mod stop;
mod stopped_spindle;
mod stops;
mod table;
mod tool;
mod waits;
mod words;

use crate::{
    convert::Converter,
    core::{Core, Interpreting, Mode, Power, Rules, user::Command},
    outside::{
        FileAction, FileKind, Level, MotionState, Move, Order, Outside, Progress, Refusal, Shape,
        Ticket,
    },
};
use hal_component::{Estop, IoRequest, IoState, StopEpoch};
use hal_gcode::{Numbered, tool::ToolTable};
use hal_job::{
    Files, Machine, World, journal::Record, spindle::Spindle, user_programs::UserPrograms,
};
use std::{
    collections::{BTreeMap, VecDeque},
    path::{Path, PathBuf},
};

/// A machine on which each move takes the same time.
struct Fake {
    /// Functions in Python of the machine.
    functions: Option<hal_remap::Functions>,
    /// The worker waits for each step of a function.
    is_patient: bool,
    /// Number of times that the worker has waited for a function.
    looks: u32,
    now: f64,
    motion: MotionState,
    io: IoState,
    /// Orders and requests, as text.
    log: Vec<String>,
    /// Moves in progress, with the time of their end.
    moves: VecDeque<(u64, Move, f64)>,
    /// Seconds that a move takes.
    move_time: f64,
    paused: bool,
    ends: BTreeMap<u64, Progress>,
    next: u64,
    /// Requests to the changer, which wait for a person.
    changer: VecDeque<(u64, IoRequest)>,
    results: BTreeMap<u64, Result<(), String>>,
    messages: Vec<String>,
    /// Refusal of the next order.
    refuse: Option<Refusal>,
    program: Progress,
    saves: u32,
    /// X of G54 in the parameters that were saved last.
    saved: Option<f64>,
    tables: Vec<String>,
    /// Lines of the files of programs.
    lines: Vec<String>,
    /// Records of the tool in the spindle; `None` while the disk is full.
    spindles: Option<Vec<Spindle>>,
    /// Values of HAL, and the questions for them with their time.
    hal: BTreeMap<String, f64>,
    questions: BTreeMap<u64, (f64, String)>,
    journal: String,
    disk_is_full: bool,
    /// The parameter file cannot be written.
    is_unwritable: bool,
    /// Levels of the messages.
    levels: Vec<Level>,
}

impl Fake {
    fn new() -> Self {
        let estop = Estop { commanded: false, open: false };
        Self {
            functions: None,
            is_patient: true,
            looks: 0,
            now: 0.0,
            motion: MotionState {
                enabled: true,
                in_position: true,
                all_homed: true,
                at_speed: true,
                feed_override: 1.0,
                rapid_override: 1.0,
                spindle_override: [1.0; 8],
                epoch: StopEpoch { stops: 1, pauses: 0 },
                ..MotionState::default()
            },
            io: IoState {
                estop,
                mist: false,
                flood: false,
                lube: false,
                lube_level: true,
                tool: 0,
                pocket: 0,
                prepared: 0,
            },
            log: Vec::new(),
            moves: VecDeque::new(),
            move_time: 0.1,
            paused: false,
            ends: BTreeMap::new(),
            next: 0,
            changer: VecDeque::new(),
            results: BTreeMap::new(),
            messages: Vec::new(),
            refuse: None,
            program: Progress::Done,
            saves: 0,
            saved: None,
            tables: Vec::new(),
            lines: Vec::new(),
            spindles: Some(Vec::new()),
            hal: BTreeMap::new(),
            questions: BTreeMap::new(),
            journal: String::new(),
            disk_is_full: false,
            is_unwritable: false,
            levels: Vec::new(),
        }
    }

    /// Lets time pass: moves end, unless they are paused.
    fn pass(&mut self, seconds: f64) {
        self.now += seconds;
        self.motion.cycle += 1;
        if self.paused {
            for (_, _, end) in &mut self.moves {
                *end += seconds;
            }
        }
        while let Some((id, m, _)) = self.moves.pop_front_if(|(_, _, end)| *end <= self.now) {
            self.motion.pose = m.to;
            self.ends.insert(id, Progress::Done);
        }
        self.motion.queue = u32::try_from(self.moves.len()).unwrap();
        self.motion.in_position = self.moves.is_empty();
    }

    /// A person answers what the changer was asked.
    fn answer_changer(&mut self) {
        while let Some((id, request)) = self.changer.pop_front() {
            match request {
                IoRequest::Prepare { tool, .. } => self.io.prepared = tool,
                _ => (self.io.tool, self.io.prepared) = (self.io.prepared, 0),
            }
            self.ends.insert(id, Progress::Done);
        }
    }
}

/// A task on the fake machine.
struct Rig {
    core: Core,
    fake: Fake,
    tickets: u64,
    folder: PathBuf,
}

const TOOLS: &str = "T1 P1 Z10 D3\nT2 P2 Z20 D1\n";

impl Rig {
    /// A machine in millimetres with two tools, on, homed, and in mode auto, with this program open.
    fn new(program: &str) -> Self {
        Self::with(program, |_| {})
    }

    fn with(program: &str, change: impl FnOnce(&mut Rules)) -> Self {
        Self::on_machine(program, |_, rules| change(rules))
    }

    fn on_machine(program: &str, change: impl FnOnce(&mut Machine, &mut Rules)) -> Self {
        static NEXT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let n = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("hal-task-{}-{n}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut machine = Machine::read(&Files::default()).unwrap();
        machine.folders = vec![folder.clone()];
        machine.codes = UserPrograms::new(vec![folder.clone()], None);
        machine.tools = ToolTable::parse(TOOLS).0;
        let mut rules = Rules {
            needs_homing: true,
            at_speed_timeout: 5.0,
            has_top_speed: [false; 8],
            change_position: None,
            safe_height: None,
            has_full_codes: false,
        };
        machine.limits[2].1 = Some(80.0);
        machine.limits[8].1 = Some(0.0);
        change(&mut machine, &mut rules);
        let core =
            Core::new(World { machine, hal: BTreeMap::new(), functions: None }, rules).unwrap();
        let mut rig = Self { core, fake: Fake::new(), tickets: 0, folder };
        rig.step();
        let path = rig.folder.join("job.ngc");
        std::fs::write(&path, program).unwrap();
        rig.good(Command::Open(path));
        rig.good(Command::Mode(Mode::Auto));
        rig
    }

    fn send(&mut self, command: Command) -> Ticket {
        self.tickets += 1;
        let ticket = Ticket(self.tickets);
        let now = self.fake.motion.epoch;
        self.core.command(command, now, ticket, &mut self.fake);
        ticket
    }

    fn good(&mut self, command: Command) {
        let ticket = self.send(command);
        assert_eq!(self.result(ticket), Some(Ok(())));
    }

    fn refused(&mut self, command: Command) -> String {
        let ticket = self.send(command);
        self.result(ticket).unwrap().unwrap_err()
    }

    fn result(&self, ticket: Ticket) -> Option<Result<(), String>> {
        self.fake.results.get(&ticket.0).cloned()
    }

    fn step(&mut self) {
        self.core.step(&mut self.fake, 100);
    }

    /// Lets seconds pass, in steps of a hundredth.
    fn pass(&mut self, seconds: f64) {
        let end = self.fake.now + seconds - 0.005;
        while self.fake.now < end {
            self.fake.pass(0.01);
            self.step();
        }
    }

    /// Returns what was sent since the last look.
    fn sent(&mut self) -> Vec<String> {
        core::mem::take(&mut self.fake.log)
    }

    /// Runs the program to its end and returns what was sent.
    fn run(&mut self) -> Vec<String> {
        let ticket = self.send(Command::Run);
        self.ended(ticket)
    }

    /// Follows a program to its end, with a person at the changer, and returns what was sent.
    fn ended(&mut self, ticket: Ticket) -> Vec<String> {
        for _ in 0..400 {
            self.pass(0.1);
            self.fake.answer_changer();
            if let Some(result) = self.result(ticket) {
                assert_eq!(result, Ok(()));
                return self.sent();
            }
        }
        panic!("the program does not end: {:?}", self.fake.log);
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.folder).unwrap_or_default();
    }
}
