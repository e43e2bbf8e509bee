//! The task: it follows remote jogs and programs until their end.

use crate::{
    lease::{Lease, Loss},
    numbers,
    pins::Pins,
};
use hal_component::{
    Clock, Error, Messages, MotionCommand, MotionEnd, MotionId, MotionRef, MotionRefusal,
    MotionStatus, MotionToken, Period, StopEpoch, Touch, Update, Uses, motion_kind, motion_source,
};
use hal_safety::{
    Ends, Epoch,
    lease::{Desk, Jog as Kind, Refused, Work},
};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{Ordering::Relaxed, Ordering::SeqCst, fence},
};

/// Longest time for which the answer to a tool change is TRUE, in nanoseconds: as long as a person presses a button.
const PRESS_NS: i64 = 200_000_000;

/// Progress of a jog.
#[derive(Clone, Copy, Debug)]
enum Jog {
    /// The command is on its way.
    Sent(MotionId),
    /// Motion had taken it by this cycle.
    Taken(u64),
}

/// State of the lease that only commands and the task see.
#[derive(Debug)]
pub(crate) struct Keeper {
    pub(crate) lease: Arc<Lease>,
    /// Motion; a machine whose robot moves by its own controller has none.
    pub(crate) motion: Option<MotionRef>,
    pub(crate) holder: String,
    /// Decisions on leases and jobs.
    desk: Desk,
    pins: Pins,
    /// Machine time until which the answer to a tool change is TRUE.
    pressed_until: i64,
    clock: Clock,
    say: Messages,
    jogs: Vec<Jog>,
}

impl Keeper {
    pub(crate) fn new(
        lease: Arc<Lease>,
        motion: Option<MotionRef>,
        pins: Pins,
        clock: Clock,
        say: Messages,
        preset: Loss,
    ) -> Self {
        let (holder, jogs) = (String::new(), Vec::new());
        let desk = Desk { last: numbers::last(clock), ..Desk::new(preset) };
        let mut keeper =
            Self { lease, motion, holder, desk, pins, pressed_until: 0, clock, say, jogs };
        keeper.set_loss(preset);
        keeper
    }

    /// Sets the effect of a lost lease on the program in progress, or on the next one.
    fn set_loss(&mut self, loss: Loss) {
        self.desk.on_loss = loss;
        self.lease.holds.store(loss.holds(), Relaxed);
    }

    /// Begins a lease and returns its number. `from` is the lease that its holder hands over.
    pub(crate) fn take(&mut self, holder: &str, from: Option<u32>) -> Result<u32, Error> {
        let now = self.lease.number.load(Relaxed);
        let number = self.desk.take(now, from).map_err(|why| self.error(why))?;
        numbers::note(self.clock, number);
        holder.clone_into(&mut self.holder);
        // The servo thread may have ended the lease that is handed over: then the new one is new all the same.
        self.lease.number.store(number, Relaxed);
        Ok(number)
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
            self.lease.lose();
        }
        Ok(())
    }

    /// Refuses a number that is not that of the lease.
    pub(crate) fn check(&self, number: u32) -> Result<(), Error> {
        Desk::check(number, self.lease.number.load(Relaxed)).map_err(|why| self.error(why))
    }

    /// Refuses an order that was given before a stop; what resumes also one from before a pause.
    pub(crate) fn check_epoch(&self, given: Option<u64>, resumes: bool) -> Result<(), Error> {
        let now = self.motion.as_ref().map(MotionRef::epoch);
        let Some((given, now)) = given.and_then(StopEpoch::of).zip(now) else { return Ok(()) };
        let epoch = |of: StopEpoch| Epoch { stops: of.stops, pauses: of.pauses };
        let ends = if resumes { Ends::Pauses } else { Ends::Stops };
        if epoch(given).is_too_old(ends, epoch(now)) {
            return Err(Error::new(hal_safety::Refused::Stale.text()));
        }
        Ok(())
    }

    /// Sends a jog to motion.
    pub(crate) fn jog(&mut self, number: u32, command: &MotionCommand) -> Result<(), Error> {
        self.check(number)?;
        let motion = self.motion.as_ref();
        let motion =
            motion.ok_or_else(|| Error::new("this machine has no motion that could jog"))?;
        let is_held = command.extent == 0;
        let kind =
            Desk::jog(number, is_held, &self.lease.words()).map_err(|why| self.error(why))?;
        // Before the jog is sent: the servo thread must know of it when it begins.
        self.lease.jog_lease.store(number, Relaxed);
        self.lease.jog.fetch_max(kind as u32, Relaxed);
        let command = MotionCommand { source: motion_source::REMOTE, ..*command };
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

    /// Notes that a program, a line or homing is about to start under the lease, or to go on. Returns what a lost lease does to it:
    /// what is given here, else what its start said.
    pub(crate) fn start(
        &mut self,
        number: u32,
        release: bool,
        on_loss: Option<Loss>,
    ) -> Result<Loss, Error> {
        let (words, before) = (self.lease.words(), self.desk);
        let loss = self.desk.start(number, release, on_loss, &words);
        let loss = loss.map_err(|why| self.error(why))?;
        // Before the job is known, so that it is never judged by that of another.
        self.set_loss(loss);
        self.lease.job.store(true, Relaxed);
        // Either the servo thread sees the job when it ends the lease, or its end is seen here.
        fence(SeqCst);
        if let Err(why) = self.check(number) {
            self.lease.job.store(before.has_job(), Relaxed);
            self.set_loss(before.on_loss);
            return Err(why);
        }
        self.desk.announced(self.clock.now_ns());
        if release {
            self.lease.hold.store(false, Relaxed);
            // A loss since then has set a hold that this may have ended.
            fence(SeqCst);
            if let Err(why) = self.check(number) {
                self.lease.hold.store(self.lease.holds.load(Relaxed), Relaxed);
                return Err(why);
            }
        }
        self.desk.started();
        Ok(loss)
    }

    /// Forgets a program that was announced and has not begun.
    pub(crate) fn refused(&mut self, number: u32) -> Result<(), Error> {
        self.check(number)?;
        if let Some(work) = self.work() {
            self.follow_job(work);
        }
        if self.desk.refuse() {
            self.lease.job.store(false, Relaxed);
        }
        Ok(())
    }

    /// Presses the button that answers a tool change.
    pub(crate) fn tool_changed(&mut self, number: u32) -> Result<(), Error> {
        self.check(number)?;
        if !self.lease.allowed.load(Relaxed) {
            return Err(self.error(Refused::Forbidden));
        }
        self.pressed_until = self.clock.now_ns() + PRESS_NS;
        self.pins.tool_changed.set(true);
        Ok(())
    }

    /// Ends a hold.
    pub(crate) fn release(&mut self) -> Result<(), Error> {
        let released = self.desk.release(self.lease.allowed.load(Relaxed));
        released.map_err(|why| self.error(why))?;
        self.lease.hold.store(false, Relaxed);
        Ok(())
    }

    /// Returns a refusal in the operator's words.
    fn error(&self, why: Refused) -> Error {
        Error::new(match why {
            Refused::Taken => format!("{} has the control lease", self.holder),
            Refused::NoBeat => format!(
                "no beat younger than {} ms has arrived: a held jog needs a faster connection, or \
                 function remote is in no thread that runs",
                self.lease.rules.jog_ms
            ),
            why => why.text().to_owned(),
        })
    }

    fn send(&self, kind: u32) {
        let Some(motion) = &self.motion else { return };
        if motion.push(MotionToken::LOCAL, &MotionCommand::new(kind)).is_err() {
            self.say.error("motion takes no commands: a lost lease does not abort", &[]);
        }
    }

    /// Returns what motion does; `None` before its first cycle.
    fn work(&self) -> Option<Work> {
        let job = self.pins.job.get();
        let Some(motion) = &self.motion else { return Some(Work { job, ..Work::default() }) };
        Some(work_of(&motion.status()?, job))
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
            self.desk.lost();
        }
        self.end_orphan(work);
        self.follow_job(work);
        if self.clock.now_ns() >= self.pressed_until || !self.pins.tool_change.get() {
            self.pins.tool_changed.set(false);
        }
    }

    /// Ends a job without a lease.
    fn end_orphan(&mut self, work: Work) {
        if self.desk.end_orphan(self.clock.now_ns(), work) {
            self.send(motion_kind::ABORT);
        }
        // The task ends the job where nothing moves, as in a pause.
        self.pins.abort.set(self.desk.ends && self.desk.on_loss == Loss::Abort);
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
            self.lease.jog.store(Kind::None as u32, Relaxed);
        }
    }

    fn follow_job(&mut self, work: Work) {
        if self.desk.follow(self.clock.now_ns(), work) {
            self.lease.job.store(false, Relaxed);
            // Nothing is left that it could hold.
            self.lease.hold.store(false, Relaxed);
            self.set_loss(self.desk.on_loss);
        }
    }

    /// Returns what a lost lease does to the program in progress, or to the next one.
    pub(crate) const fn on_loss(&self) -> Loss {
        self.desk.on_loss
    }
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

/// Returns what motion does, by its record.
pub(crate) const fn work_of(status: &MotionStatus, job: bool) -> Work {
    let waits = status.claimed || status.queue != 0;
    let moves = waits || status.homing || !status.in_position;
    Work { moves, waits, homes: status.homing, job }
}
