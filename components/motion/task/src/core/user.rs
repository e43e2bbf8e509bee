//! Commands of operators.

use super::{
    Asked, Core, EndedBy, MDI_LEN, MdiLine, Mode, Power, Ticket, file_name, overrides::Scale,
};
use crate::outside::{Order, Outside, Refusal};
use hal_component::{IoRequest, StopEpoch};
use hal_job::{dry_run::Target, world};
use std::path::{Path, PathBuf};

/// A command of an operator.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    Estop,
    EstopReset,
    On,
    Off,
    Mode(Mode),
    /// Homes a joint, or all.
    Home(Option<u32>),
    Open(PathBuf),
    Run,
    /// Runs the program if nothing has been stopped since there were so many stops.
    RunUnlessStopped(u32),
    /// Proposes a start in the middle of the program.
    RunFrom(Target),
    /// Proposes a start at the place where the last job broke off.
    Recover,
    /// Begins the start that was proposed with this token.
    Confirm(u32),
    Pause,
    Resume,
    Step,
    Abort,
    Mdi(Box<str>),
    /// A line of MDI from whatever mode, which then comes back.
    BriefMdi(Box<str>),
    OptionalStop(bool),
    BlockDelete(bool),
    FeedOverride(f64),
    RapidOverride(f64),
    SpindleOverride {
        spindle: u8,
        scale: f64,
    },
}

impl Command {
    /// Returns whether this is a stop.
    pub(crate) const fn is_stop(&self) -> bool {
        matches!(self, Self::Estop | Self::Off | Self::Abort | Self::Pause)
    }

    /// Refuses a command that begins motion or gives power, if a stop has come since it was given.
    fn is_in_time(&self, given: StopEpoch, now: StopEpoch) -> Result<(), String> {
        let is_late = match self {
            Self::EstopReset
            | Self::On
            | Self::Run
            | Self::RunUnlessStopped(_)
            | Self::Confirm(_) => given.is_stopped_by(now),
            Self::Home(_) | Self::Resume | Self::Step | Self::Mdi(_) | Self::BriefMdi(_) => {
                given.is_stopped_by(now) || given.is_paused_by(now)
            }
            Self::Estop
            | Self::Off
            | Self::Mode(_)
            | Self::Open(_)
            | Self::RunFrom(_)
            | Self::Recover
            | Self::Pause
            | Self::Abort
            | Self::OptionalStop(_)
            | Self::BlockDelete(_)
            | Self::FeedOverride(_)
            | Self::RapidOverride(_)
            | Self::SpindleOverride { .. } => false,
        };
        if is_late { Err(LATE.into()) } else { Ok(()) }
    }
}

/// Time at which a command is reported.
pub(super) enum Report {
    Now,
    Later,
}

const STOPPING: &str = "the machine is still coming to a stop";
const LATE: &str = "a stop has come meanwhile: give the command again";
pub(super) const FULL: &str = "motion takes no commands now";
const TOO_MANY: &str = "too many requests wait for iocontrol";
const IN_ESTOP: &str = "the machine is in e-stop: task.estop-reset comes first";

impl Core {
    /// Executes a command; its result is reported through the ticket.
    /// It was given in a stop epoch: after a stop since then, it begins nothing.
    pub(crate) fn command(
        &mut self,
        command: Command,
        given: StopEpoch,
        ticket: Ticket,
        out: &mut impl Outside,
    ) {
        let executed = command
            .is_in_time(given, out.epoch())
            .and_then(|()| self.execute_command(command, given, ticket, out));
        match executed {
            Ok(Report::Now) => out.finish(ticket, Ok(())),
            Ok(Report::Later) => {}
            Err(why) => out.finish(ticket, Err(why)),
        }
    }

    fn execute_command(
        &mut self,
        command: Command,
        given: StopEpoch,
        ticket: Ticket,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        match command {
            Command::Estop => self.request(IoRequest::Estop, ticket, out),
            Command::EstopReset => {
                let id = out.request(IoRequest::EstopReset).ok_or(TOO_MANY)?;
                self.asked.push((Asked::Reset(id), ticket));
                Ok(Report::Later)
            }
            Command::On => self.switch_on(given, ticket, out),
            Command::Off => self.order(&Order::Disable, given, ticket, out),
            Command::Mode(mode) => {
                self.needs_no_job("the mode cannot change")?;
                self.mode = mode;
                self.mode_before = None;
                Ok(Report::Now)
            }
            Command::Home(joint) => {
                self.needs_on("homing")?;
                self.needs_mode(Mode::Manual, "homing")?;
                self.order(&Order::Home(joint), given, ticket, out)
            }
            Command::Open(path) => self.open(path),
            Command::RunUnlessStopped(stops) if stops != self.stops => Err(LATE.into()),
            Command::Run | Command::RunUnlessStopped(_) => self.run(ticket, given, false, out),
            Command::RunFrom(target) => self.run_from(target, ticket, out).map(|()| Report::Later),
            Command::Recover => self.recover(ticket, out).map(|()| Report::Later),
            Command::Confirm(token) => {
                self.confirm(token, ticket, given, out)?;
                self.is_job_from_afar = self.is_from_afar;
                Ok(Report::Later)
            }
            Command::Pause => self.pause(out),
            Command::Resume => self.resume(ticket, given, out),
            Command::Step => self.single_step(ticket, given, out),
            Command::Abort => {
                self.stops = self.stops.wrapping_add(1);
                if self.ending.is_none() {
                    self.note_end(EndedBy::Abort);
                    self.end_job(super::STOPPED, out);
                }
                Ok(Report::Now)
            }
            Command::Mdi(text) => self.mdi(text, given, ticket),
            Command::BriefMdi(text) => {
                if self.mode == Mode::Mdi {
                    return self.mdi(text, given, ticket);
                }
                self.needs_no_job("MDI is not possible")?;
                let before = core::mem::replace(&mut self.mode, Mode::Mdi);
                self.mode_before = Some(before);
                // A line that is refused leaves the mode as it was; so does the next step after one that is not.
                self.mdi(text, given, ticket).inspect_err(|_| self.restore_mode())
            }
            Command::OptionalStop(on) => {
                self.optional_stop = on;
                Ok(Report::Now)
            }
            Command::BlockDelete(on) => {
                self.interpreter.state.settings.block_delete = on;
                self.world.machine.settings.block_delete = on;
                // The lines of the check are others.
                self.checking.end_ahead();
                Ok(Report::Now)
            }
            Command::FeedOverride(scale) => {
                self.feed.scale = scale;
                accepted(self.send_scale(Scale::Feed, out)?)
            }
            Command::RapidOverride(scale) => {
                self.feed.rapid = scale;
                accepted(self.send_scale(Scale::Rapid, out)?)
            }
            Command::SpindleOverride { spindle, scale } => {
                let count = self.interpreter.state.modal.spindles.len();
                let slot = self.spindle_scale.get_mut(usize::from(spindle));
                let slot = slot.filter(|_| usize::from(spindle) < count);
                *slot.ok_or_else(|| format!("there is no spindle {spindle}"))? = scale;
                accepted(self.send_scale(Scale::Spindle(spindle), out)?)
            }
        }
    }

    /// Switches the machine on; behind a reset of the e-stop that is under way, once that has ended.
    pub(super) fn switch_on(
        &mut self,
        given: StopEpoch,
        ticket: Ticket,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        if !out.io().estop.is_released() {
            let resets = self.asked.iter().any(|(asked, _)| matches!(asked, Asked::Reset(_)));
            if !resets {
                return Err(IN_ESTOP.into());
            }
            self.on_after_reset.push((given, ticket));
            return Ok(Report::Later);
        }
        self.order(&Order::Enable, given, ticket, out)
    }

    fn request(
        &mut self,
        request: IoRequest,
        ticket: Ticket,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        let id = out.request(request).ok_or(TOO_MANY)?;
        self.asked.push((Asked::Io(id), ticket));
        Ok(Report::Later)
    }

    pub(super) fn order(
        &mut self,
        order: &Order,
        given: StopEpoch,
        ticket: Ticket,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        match out.order(order, given) {
            Ok(id) => {
                self.asked.push((Asked::Order(id), ticket));
                Ok(Report::Later)
            }
            Err(Refusal::Full) => Err(FULL.into()),
            Err(Refusal::Why(why)) => Err(why.into()),
        }
    }

    pub(super) fn needs_no_job(&self, what: &str) -> Result<(), String> {
        match (&self.job, &self.ending) {
            (None, None) if self.checking.is_before_start() => {
                Err(format!("{what} while a program is checked: task.abort ends the check"))
            }
            (None, None) => Ok(()),
            (_, Some(_)) => Err(STOPPING.into()),
            (Some(job), None) if job.is_program => Err(format!("{what} while a program runs")),
            (Some(_), None) => Err(format!("{what} while MDI runs")),
        }
    }

    fn needs_on(&self, what: &str) -> Result<(), String> {
        match self.power {
            Power::On => Ok(()),
            Power::Off => Err(format!("{what} needs a machine that is on: task.on comes first")),
            Power::Estop => Err(format!("{what} is not possible in e-stop")),
        }
    }

    fn needs_mode(&self, mode: Mode, what: &str) -> Result<(), String> {
        if self.mode == mode {
            return Ok(());
        }
        let (wanted, is) = (mode.name(), self.mode.name());
        Err(format!("{what} needs mode {wanted}, the mode is {is}: task.mode mode={wanted}"))
    }

    /// Checks that a job may begin; the error has every reason.
    pub(super) fn may_begin(
        &self,
        mode: Mode,
        what: &str,
        out: &impl Outside,
    ) -> Result<(), String> {
        let homed = !self.rules.needs_homing || out.motion().all_homed;
        let not_homed = Err(format!("{what} needs homed joints: task.home joint=all"));
        let no_program = Err("no program is open: task.open file=… comes first".to_owned());
        let opened = mode != Mode::Auto || self.program.is_some();
        let tool = if mode == Mode::Auto { self.needs_known_tool() } else { Ok(()) };
        let reasons: Vec<String> = [
            self.needs_on(what),
            self.needs_mode(mode, what),
            if homed { Ok(()) } else { not_homed },
            if opened { Ok(()) } else { no_program },
            tool,
        ]
        .into_iter()
        .filter_map(Result::err)
        .collect();
        if reasons.is_empty() { Ok(()) } else { Err(reasons.join("; ")) }
    }

    fn open(&mut self, path: PathBuf) -> Result<Report, String> {
        self.needs_no_job("no program can be opened")?;
        // A file that cannot be read is refused here, not when it runs.
        match self.is_from_afar {
            true => drop(world::program_from_afar(&self.world.machine, &path)?),
            false => drop(world::program_of(&self.world.machine, &path)?),
        }
        self.program = Some(path);
        Ok(Report::Now)
    }

    pub(super) fn run(
        &mut self,
        ticket: Ticket,
        given: StopEpoch,
        stepping: bool,
        out: &mut impl Outside,
    ) -> Result<Report, String> {
        self.needs_no_job("a program cannot begin")?;
        self.may_begin(Mode::Auto, "a program", out)?;
        self.take_stopped_spindles(given, out);
        let path = self.program.clone().unwrap_or_default();
        self.check_before_start(path, ticket, given, stepping, out)?;
        self.is_job_from_afar = self.is_from_afar;
        Ok(Report::Later)
    }

    fn mdi(&mut self, text: Box<str>, given: StopEpoch, ticket: Ticket) -> Result<Report, String> {
        if self.ending.is_some() {
            return Err(STOPPING.into());
        }
        self.needs_on("MDI")?;
        self.needs_mode(Mode::Mdi, "MDI")?;
        if self.mdi.len() >= MDI_LEN {
            return Err(format!("{MDI_LEN} lines of MDI wait already"));
        }
        let is_from_afar = self.is_from_afar;
        self.mdi.push_back(MdiLine { text, given, ticket, is_from_afar });
        Ok(Report::Later)
    }

    /// Returns to the mode before a line of MDI, when no line is in execution or waits.
    pub(super) fn restore_mode(&mut self) {
        if !self.is_busy()
            && self.mdi.is_empty()
            && let Some(before) = self.mode_before.take()
        {
            self.mode = before;
        }
    }

    /// Returns whether single steps are in force.
    pub(crate) fn is_stepping(&self) -> bool {
        self.job.as_ref().is_some_and(|j| j.stepping.is_some())
    }

    /// Returns the number of lines of MDI that wait.
    pub(crate) fn mdi_len(&self) -> usize {
        self.mdi.len()
    }

    /// Returns the line of MDI in execution, or an empty text.
    pub(crate) fn mdi_line(&self) -> &str {
        let is_mdi = self.job.as_ref().is_some_and(|job| !job.is_program);
        if is_mdi { &self.mdi_text } else { "" }
    }

    /// Returns the name of a program in messages.
    pub(super) fn name_of(path: &Path) -> String {
        let text = path.to_string_lossy();
        if text.contains('/') { text.into_owned() } else { file_name(path) }
    }

    /// Begins the next line of MDI that waits.
    pub(super) fn begin_mdi(&mut self, out: &mut impl Outside) {
        if self.is_busy() {
            return;
        }
        let Some(line) = self.mdi.pop_front() else { return };
        let MdiLine { text, given, ticket, is_from_afar } = line;
        let late = out.epoch();
        if given.is_stopped_by(late) || given.is_paused_by(late) {
            return out.finish(ticket, Err(LATE.to_owned()));
        }
        if let Err(why) = self.may_begin(Mode::Mdi, "MDI", out) {
            return out.finish(ticket, Err(why));
        }
        self.take_over(out);
        self.interpreter.mdi(&text);
        self.mdi_text = text;
        self.is_job_from_afar = is_from_afar;
        self.begin_job(false, Some(ticket), given, false, out);
    }
}

fn accepted(accepted: bool) -> Result<Report, String> {
    if accepted { Ok(Report::Now) } else { Err(FULL.into()) }
}
