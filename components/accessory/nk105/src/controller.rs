//! Realtime. One cycle of the controller: keys, mode, motion.

use crate::{
    job::JobStep,
    motion::Motion,
    panel::{Panel, ScreenRow},
};
use hal_handheld::{KeySet, st7920::ROWS};

/// Speed of rapids and of fast jogs, in mm/s.
pub const FAST: f64 = 50.0;
/// Speed of slow jogs, in mm/s.
pub const SLOW: f64 = 5.0;
/// Length of a jog in the mode of steps, in millimetres.
pub const STEP: f64 = 0.1;
/// Largest number of steps of a job in one cycle.
const STEPS: usize = 64;

/// Mode of the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Mode {
    /// Nothing moves.
    Idle,
    /// Keys move the machine.
    Jog,
    /// A job runs.
    Run,
    /// A job is held.
    Hold,
}

impl Mode {
    const fn text(self) -> &'static str {
        match self {
            Self::Idle => "IDLE",
            Self::Jog => "JOG ",
            Self::Run => "RUN ",
            Self::Hold => "HOLD",
        }
    }
}

/// Reason why a job does not run on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum JobStop {
    /// No medium is presented.
    NoMedium,
    /// The medium or the file cannot be read.
    Unreadable,
    /// A line of the program is wrong, or not known.
    Line(u32),
    /// The place of a line is beyond the travel.
    Travel(u32),
}

impl JobStop {
    /// Returns its text on the display.
    fn row(self) -> ScreenRow {
        match self {
            Self::NoMedium => ScreenRow::of("NO MEDIUM"),
            Self::Unreadable => ScreenRow::of("BAD FILE"),
            Self::Line(line) => ScreenRow::of("ERR LINE ").and_number(line.into(), 0),
            Self::Travel(line) => ScreenRow::of("LIMIT LINE ").and_number(line.into(), 0),
        }
    }
}

/// Next step of an open job.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Next {
    /// Not known yet.
    Later,
    /// A step.
    Step(JobStep),
    /// The job has ended.
    End,
    /// The job cannot go on.
    Failed(JobStop),
}

/// USB medium as the controller sees it. No function waits.
pub trait Medium {
    /// Returns the number of files; `None` if no medium is presented.
    fn files(&mut self) -> Option<u32>;

    /// Returns the name of a file, from 0.
    fn name(&mut self, index: u32) -> ScreenRow;

    /// Opens a file as a job, whose zero is this place.
    fn open(&mut self, index: u32, origin: [f64; 3]);

    /// Takes the next step of the open job.
    fn next(&mut self) -> Next;

    /// Closes the job.
    fn close(&mut self);
}

/// Simulated closed controller.
#[derive(Clone, Copy, Debug)]
pub struct Controller {
    pub(crate) motion: Motion,
    pub(crate) origin: [f64; 3],
    pub(crate) mode: Mode,
    pressed: KeySet,
    /// Keys that jog: they went down while they could, and are down still.
    pub(crate) jogging: KeySet,
    pub(crate) is_linked: bool,
    pub(crate) is_step: bool,
    pub(crate) is_fast: bool,
    pub(crate) has_spindle: bool,
    pub(crate) percent: u32,
    tool: i32,
    feed: f64,
    rest: f64,
    pub(crate) entry: ScreenRow,
    pub(crate) message: ScreenRow,
    /// File that the menu shows.
    pub(crate) menu: Option<u32>,
    panel: Panel,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            motion: Motion::default(),
            origin: [0.0; 3],
            mode: Mode::Idle,
            pressed: KeySet::NONE,
            jogging: KeySet::NONE,
            is_linked: false,
            is_step: false,
            is_fast: true,
            has_spindle: false,
            percent: 100,
            tool: 1,
            feed: FAST,
            rest: 0.0,
            entry: ScreenRow::default(),
            message: ScreenRow::default(),
            menu: None,
            panel: Panel::default(),
        }
    }
}

impl Controller {
    /// Returns the place of the machine in machine coordinates, in millimetres.
    #[must_use]
    pub const fn place(&self) -> [f64; 3] {
        self.motion.place
    }

    /// Returns the mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// Returns whether the spindle turns.
    #[must_use]
    pub const fn has_spindle(&self) -> bool {
        self.has_spindle
    }

    /// Returns whether the controller holds the medium: from the begin of a job to its end.
    #[must_use]
    pub const fn holds_medium(&self) -> bool {
        matches!(self.mode, Mode::Run | Mode::Hold)
    }

    /// Returns the display, whose bytes the caller sends.
    pub const fn panel(&mut self) -> &mut Panel {
        &mut self.panel
    }

    /// Runs a cycle. `keys` has the pressed keys; `None` while no frame arrives from the handheld.
    pub fn cycle(&mut self, seconds: f64, keys: Option<KeySet>, medium: &mut impl Medium) {
        let pressed = keys.unwrap_or_default();
        let new = pressed.without(self.pressed);
        self.pressed = pressed;
        self.jogging = self.jogging.within(pressed);
        self.link(keys.is_some());
        self.check_menu(medium);
        for key in new.numbers() {
            self.press(key, medium);
        }
        match self.mode {
            Mode::Idle | Mode::Jog => self.jog(seconds),
            Mode::Run => self.run(seconds, medium),
            Mode::Hold => {}
        }
        if self.mode != Mode::Run && self.mode != Mode::Hold {
            self.rest = 0.0;
        }
        if self.panel.is_due(seconds) {
            self.panel.show(self.rows(medium));
        }
    }

    /// Notes whether frames arrive. Without the handheld nobody could press STOP: a job is held.
    fn link(&mut self, is_linked: bool) {
        if self.is_linked && !is_linked {
            self.say("NO HANDHELD");
            if self.mode == Mode::Run {
                self.mode = Mode::Hold;
            }
        }
        self.is_linked = is_linked;
    }

    pub(crate) fn say(&mut self, text: &str) {
        self.message = ScreenRow::of(text);
    }

    /// Ends the job, if there is one, and all motion.
    pub(crate) fn stop(&mut self, medium: &mut impl Medium) {
        if self.holds_medium() {
            medium.close();
            self.has_spindle = false;
        }
        self.motion.stop();
        self.jogging = KeySet::NONE;
        self.rest = 0.0;
        self.mode = Mode::Idle;
    }

    fn run(&mut self, seconds: f64, medium: &mut impl Medium) {
        let mut left = seconds;
        for _ in 0..STEPS {
            if self.rest > 0.0 {
                if self.rest >= left {
                    self.rest -= left;
                    return;
                }
                left -= self.rest;
                self.rest = 0.0;
            }
            let factor = if self.feed == 0.0 { 1.0 } else { f64::from(self.percent) / 100.0 };
            left = self.motion.follow(left, factor);
            if self.motion.is_moving() {
                return;
            }
            match medium.next() {
                Next::Later => return,
                Next::Step(step) => self.step(step),
                Next::End => {
                    self.stop(medium);
                    self.say("DONE");
                    return;
                }
                Next::Failed(why) => {
                    self.stop(medium);
                    self.message = why.row();
                    return;
                }
            }
            if self.mode != Mode::Run {
                return;
            }
        }
    }

    fn step(&mut self, step: JobStep) {
        match step {
            JobStep::Line(to, feed) => {
                self.feed = feed;
                let speed = if feed == 0.0 || feed > FAST { FAST } else { feed };
                let [x, y, z] = self.origin;
                self.motion.go([to[0] + x, to[1] + y, to[2] + z], speed);
            }
            JobStep::Dwell(seconds) => self.rest = seconds,
            JobStep::Tool(number) => self.tool = number,
            JobStep::Spindle(on) => self.has_spindle = on,
            JobStep::Pause => self.mode = Mode::Hold,
        }
    }

    fn rows(&self, medium: &mut impl Medium) -> [ScreenRow; ROWS] {
        let status = [
            ScreenRow::of(self.mode.text()),
            ScreenRow::of("F").and_number(self.percent.into(), 0),
            ScreenRow::of("T").and_number(self.tool.into(), 3),
        ];
        let mut rows = [ScreenRow::default(); ROWS];
        let axes = ["X", "Y", "Z"].into_iter().zip(self.motion.place).zip(self.origin);
        for ((row, ((letter, place), origin)), status) in rows.iter_mut().zip(axes).zip(status) {
            let at = place - origin;
            // There is no -0.000.
            let at = if at.abs() < 0.0005 { 0.0 } else { at };
            *row = ScreenRow::of(letter).and_decimals(at, 3, 10).and(" ").and(status.text());
        }
        if let Some(last) = rows.last_mut() {
            *last = match self.menu {
                Some(index) => ScreenRow::of(">").and(medium.name(index).text()),
                None if !self.entry.is_empty() => self.entry,
                None => self.message,
            };
        }
        rows
    }
}
