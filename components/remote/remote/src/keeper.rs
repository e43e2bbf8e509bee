//! The task: it follows remote jogs and programs until their end.

use crate::{
    lease::{Lease, jog},
    pins::Pins,
};
use hal_component::{
    Clock, Error, Messages, MotionCommand, MotionEnd, MotionId, MotionRef, MotionRefusal,
    MotionToken, Period, Touch, Update, Uses, motion_kind, motion_source,
};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{Ordering::Relaxed, Ordering::SeqCst, fence},
};

/// Longest time from the command that starts a program to its start, in nanoseconds.
const START_NS: i64 = 2_000_000_000;
/// Longest time for which the answer to a tool change is TRUE, in nanoseconds: as long as a person presses a button.
const PRESS_NS: i64 = 200_000_000;
/// Time for which an abort lasts and then rests, in nanoseconds: the task acts on its edges.
const ABORT_NS: i64 = 100_000_000;

/// Progress of a program that was started under the lease.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Job {
    #[default]
    None,
    /// Commanded at this machine time, not begun yet.
    Commanded(i64),
    Runs,
}

/// Progress of a jog.
#[derive(Clone, Copy, Debug)]
enum Jog {
    /// The command is on its way.
    Sent(MotionId),
    /// Motion had taken it by this cycle.
    Taken(u64),
}

/// Work of motion; none in a machine without it.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    /// Something moves, or is about to.
    moves: bool,
    /// A program has it, or moves wait.
    waits: bool,
    homes: bool,
}

/// State of the lease that only commands and the task see.
#[derive(Debug)]
pub(crate) struct Keeper {
    pub(crate) lease: Arc<Lease>,
    /// Motion; a machine whose robot moves by its own controller has none.
    pub(crate) motion: Option<MotionRef>,
    pub(crate) holder: String,
    /// Number of the last lease.
    last: u32,
    pins: Pins,
    /// Machine time until which the answer to a tool change is TRUE.
    pressed_until: i64,
    clock: Clock,
    say: Messages,
    /// True if a lost lease aborts a program.
    aborts: bool,
    jogs: Vec<Jog>,
    job: Job,
    /// True after the lease of the job was lost: what begins later ends too.
    orphaned: bool,
    /// True while the abort of an orphaned job lasts, false while it rests.
    ends: bool,
    /// Machine time at which the abort changes.
    ends_next: i64,
}

impl Keeper {
    pub(crate) fn new(
        lease: Arc<Lease>,
        motion: Option<MotionRef>,
        pins: Pins,
        clock: Clock,
        say: Messages,
        aborts: bool,
    ) -> Self {
        let (holder, jogs) = (String::new(), Vec::new());
        Self {
            lease,
            motion,
            holder,
            last: 0,
            pins,
            pressed_until: 0,
            clock,
            say,
            aborts,
            jogs,
            job: Job::None,
            orphaned: false,
            ends: false,
            ends_next: 0,
        }
    }

    /// Begins a lease and returns its number. `from` is the lease that its holder hands over.
    pub(crate) fn take(&mut self, holder: &str, from: Option<u32>) -> Result<u32, Error> {
        let now = self.lease.number.load(Relaxed);
        if now != 0 && from != Some(now) {
            return Err(Error::new(format!("{} has the control lease", self.holder)));
        }
        if from.is_some_and(|from| from != now) {
            return Err(no_lease());
        }
        holder.clone_into(&mut self.holder);
        self.last = self.last.checked_add(1).unwrap_or(1);
        // The servo thread may have ended the lease that is handed over: then the new one is new all the same.
        self.lease.number.store(self.last, Relaxed);
        Ok(self.last)
    }

    /// Ends the lease, as if it were lost.
    pub(crate) fn give(&mut self, number: u32) -> Result<(), Error> {
        self.check(number)?;
        // A job that has ended since the last step is none that is lost.
        if let Some(work) = self.work() {
            self.follow_job(work);
        }
        if self.lease.number.compare_exchange(number, 0, Relaxed, Relaxed).is_ok() {
            fence(SeqCst); // As in `start`.
            self.lease.lost.store(true, Relaxed);
            if self.lease.holds && self.lease.job.load(Relaxed) {
                self.lease.hold.store(true, Relaxed);
            }
        }
        Ok(())
    }

    /// Refuses a number that is not that of the lease.
    pub(crate) fn check(&self, number: u32) -> Result<(), Error> {
        if number != 0 && self.lease.number.load(Relaxed) == number {
            Ok(())
        } else {
            Err(no_lease())
        }
    }

    /// Sends a jog to motion.
    pub(crate) fn jog(&mut self, number: u32, command: MotionCommand) -> Result<(), Error> {
        self.check(number)?;
        self.check_allowed()?;
        let motion = self.motion.as_ref();
        let motion =
            motion.ok_or_else(|| Error::new("this machine has no motion that could jog"))?;
        let held = command.extent == 0;
        if held && !self.lease.permit.load(Relaxed) {
            return Err(Error::new(format!(
                "no beat younger than {} ms has arrived: a held jog needs a faster connection, or \
                 function remote is in no thread that runs",
                self.lease.jog_ms
            )));
        }
        let kind = if held { jog::HELD } else { jog::STEP };
        let of = self.lease.jog_lease.load(Relaxed);
        if self.lease.jog.load(Relaxed) != jog::NONE && of != number {
            return Err(Error::new("a jog of the lease before has not ended: wait until it has"));
        }
        // Before the jog is sent: the servo thread must know of it when it begins.
        self.lease.jog_lease.store(number, Relaxed);
        self.lease.jog.fetch_max(kind, Relaxed);
        let command = MotionCommand { source: motion_source::REMOTE, ..command };
        match motion.push(MotionToken::LOCAL, &command) {
            Ok(id) => {
                self.jogs.push(Jog::Sent(id));
                Ok(())
            }
            Err(why) => Err(Error::new(match why {
                MotionRefusal::Full => "motion takes no commands: its queue is full".to_owned(),
                MotionRefusal::NotOwner => "motion belongs to another".to_owned(),
                MotionRefusal::Refused(why) => why,
            })),
        }
    }

    /// Notes that a program, a line or homing is about to start under the lease.
    pub(crate) fn start(&mut self, number: u32, release: bool) -> Result<(), Error> {
        self.check(number)?;
        self.check_allowed()?;
        if self.orphaned && self.aborts {
            return Err(Error::new(
                "the job of a lost lease is being aborted: wait until it has ended",
            ));
        }
        if self.lease.hold.load(Relaxed) && !release {
            return Err(Error::new(
                "a program is held since the lease was lost: remote.release ends that",
            ));
        }
        let begins = self.job == Job::None;
        self.lease.job.store(true, Relaxed);
        // Either the servo thread sees the job when it ends the lease, or its end is seen here.
        fence(SeqCst);
        if let Err(why) = self.check(number) {
            if begins {
                self.lease.job.store(false, Relaxed);
            }
            return Err(why);
        }
        if begins {
            self.job = Job::Commanded(self.clock.now_ns());
        }
        if release {
            self.lease.hold.store(false, Relaxed);
            // A loss since then has set a hold that this may have ended.
            fence(SeqCst);
            if let Err(why) = self.check(number) {
                self.lease.hold.store(self.lease.holds, Relaxed);
                return Err(why);
            }
        }
        self.orphaned = false;
        Ok(())
    }

    /// Forgets a program that was announced and has not begun.
    pub(crate) fn refused(&mut self, number: u32) -> Result<(), Error> {
        self.check(number)?;
        if let Some(work) = self.work() {
            self.follow_job(work);
        }
        if matches!(self.job, Job::Commanded(_)) {
            self.job = Job::None;
            self.lease.job.store(false, Relaxed);
        }
        Ok(())
    }

    /// Presses the button that answers a tool change.
    pub(crate) fn tool_changed(&mut self, number: u32) -> Result<(), Error> {
        self.check(number)?;
        self.check_allowed()?;
        self.pressed_until = self.clock.now_ns() + PRESS_NS;
        self.pins.tool_changed.set(true);
        Ok(())
    }

    fn check_allowed(&self) -> Result<(), Error> {
        if self.lease.allowed.load(Relaxed) {
            return Ok(());
        }
        Err(Error::new("remote.allow-motion is FALSE: the machine permits no remote motion"))
    }

    /// Ends a hold.
    pub(crate) fn release(&mut self) -> Result<(), Error> {
        if !self.lease.allowed.load(Relaxed) {
            return Err(Error::new("remote.allow-motion is FALSE: the hold lasts"));
        }
        self.lease.hold.store(false, Relaxed);
        self.orphaned &= self.aborts;
        Ok(())
    }

    fn send(&self, kind: u32) {
        let Some(motion) = &self.motion else { return };
        if motion.push(MotionToken::LOCAL, &MotionCommand::new(kind)).is_err() {
            self.say.error("motion takes no commands: a lost lease does not abort", &[]);
        }
    }

    /// Returns what motion does; `None` before its first cycle.
    fn work(&self) -> Option<Work> {
        let Some(motion) = &self.motion else { return Some(Work::default()) };
        let status = motion.status()?;
        let waits = status.claimed || status.queue != 0;
        let moves = waits || status.homing || !status.in_position;
        Some(Work { moves, waits, homes: status.homing })
    }

    fn step(&mut self) {
        let Some(work) = self.work() else { return };
        self.follow_jogs();
        if self.lease.lost.swap(false, Relaxed) {
            let text = if self.lease.allowed.load(Relaxed) {
                "the control lease has ended: remote jogs stop"
            } else {
                "remote.allow-motion is FALSE: remote jogs stop"
            };
            self.say.warn(text, &[]);
            if self.lease.hold.load(Relaxed) {
                self.say.warn("a program that was started remotely is held", &[]);
            }
            self.orphaned = self.job != Job::None;
        }
        self.end_orphan(work);
        self.follow_job(work);
        if self.clock.now_ns() >= self.pressed_until || !self.pins.tool_change.get() {
            self.pins.tool_changed.set(false);
        }
    }

    /// Ends a job without a lease. Homing and the job may begin later: they wait in queues, where an abort misses them.
    fn end_orphan(&mut self, work: Work) {
        let now = self.clock.now_ns();
        let works = self.pins.job.get() || work.waits;
        if !(self.orphaned && (work.homes || self.aborts && works)) {
            self.ends = false;
            self.ends_next = now;
        } else if self.ends_next <= now {
            self.ends = !self.ends;
            self.ends_next = now + ABORT_NS;
            if self.ends {
                self.send(motion_kind::ABORT);
            }
        }
        // The task ends the job where nothing moves, as in a pause.
        self.pins.abort.set(self.ends && self.aborts);
    }

    fn follow_jogs(&mut self) {
        let Some(motion) = &self.motion else { return };
        let Some(status) = motion.status() else { return };
        self.jogs.retain_mut(|jog| match *jog {
            Jog::Sent(id) => {
                if motion.poll(id) != MotionEnd::Pending {
                    *jog = Jog::Taken(status.cycle);
                }
                true
            }
            // The status of a whole cycle after the command shows whether it moves.
            Jog::Taken(cycle) => {
                status.cycle <= cycle + 1
                    || (status.jogging && status.source == motion_source::REMOTE)
            }
        });
        if self.jogs.is_empty() {
            self.lease.jog.store(jog::NONE, Relaxed);
        }
    }

    fn follow_job(&mut self, work: Work) {
        // A paused job has no claim on motion.
        let over = !work.moves && !self.pins.job.get();
        self.job = match self.job {
            Job::None => return,
            Job::Commanded(at) if over => {
                if self.clock.now_ns() - at <= START_NS {
                    return;
                }
                Job::None
            }
            Job::Runs if over => Job::None,
            Job::Commanded(_) | Job::Runs => Job::Runs,
        };
        if self.job == Job::None {
            self.lease.job.store(false, Relaxed);
            // Nothing is left that it could hold.
            self.lease.hold.store(false, Relaxed);
            self.orphaned = false;
        }
    }
}

fn no_lease() -> Error {
    Error::new("this is not the number of the control lease: it has ended, or another has it")
}

/// The task.
#[derive(Debug)]
pub(crate) struct Step(pub(crate) Arc<Mutex<Keeper>>);

impl Touch for Step {
    fn touch(&self, uses: &mut Uses) {
        let keeper = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        keeper.motion.touch(uses);
        keeper.pins.touch(uses);
    }
}

impl Update for Step {
    fn update(&mut self, _: Period) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).step();
    }
}
