//! The states of the storage: SERVING, PREPARE, EJECT, PRESENT.

use crate::{
    bay::{Bay, Side},
    error::StorageError,
    gadget::{Gadget, NotEjected},
    image::{self, ImageFile},
    ledger::Ledger,
    name::{is_same, safe_name},
    plan::ImagePlan,
    prepare::{self, waiting_job},
};
use std::collections::VecDeque;

/// Largest job in bytes.
pub const MOST_BYTES: u64 = 16 << 20;
/// Largest number of jobs that wait.
pub const MOST_WAITING: usize = 64;
/// Time for which a busy host is asked to let go, in seconds.
pub const BUSY_TIME: u32 = 5;
/// Time between two attempts to present an image, in seconds.
const AGAIN: f64 = 1.0;

/// Rules of a storage.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Rules {
    /// Size of each image in bytes.
    pub size: u64,
    /// True if the image may be taken from a host that holds it.
    pub may_force: bool,
}

/// State of the storage.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Phase {
    /// The image is presented, and nothing else is done.
    Serving = 0,
    /// The other image is written.
    Preparing = 1,
    /// The other image is complete, and the host is to let go of this one.
    Ejecting = 2,
    /// No image is presented, and one is about to be.
    Presenting = 3,
}

/// Something that happened.
#[derive(Debug)]
pub enum StorageEvent {
    /// An image is presented.
    Presented(Side),
    /// A finished job is not on the new image.
    Deleted(String),
    /// The image was taken from a host that held it.
    Forced(Side),
    /// Something failed. The jobs that wait still wait.
    Failed(StorageError),
}

#[derive(Debug)]
enum Work {
    Serving,
    /// The number of steps that are done.
    Preparing(ImagePlan, usize),
    /// Time since which the host has been busy, and whether that was reported.
    Ejecting(ImagePlan, Option<f64>, bool),
    /// Time of the last failure.
    Presenting(Option<f64>),
}

/// Storage with two images. Times are in seconds from any origin and never decrease.
#[derive(Debug)]
pub struct Storage<B> {
    bay: B,
    rules: Rules,
    ledger: Ledger,
    waiting: Vec<String>,
    work: Work,
    /// True after a failure, until a user does something.
    is_paused: bool,
    events: VecDeque<StorageEvent>,
}

impl<B: Bay> Storage<B> {
    /// Opens a storage: the image that the state file names will be presented. Without a state file that is a new image A.
    ///
    /// # Errors
    /// The state file is wrong, the presented image has no file system, or something cannot be read or written.
    pub fn open(mut bay: B, rules: Rules) -> Result<Self, StorageError> {
        let state = bay.state().map_err(|e| StorageError::Keeping("the state file".into(), e))?;
        let ledger = match state {
            Some(bytes) => Ledger::parse(&bytes)?,
            None => {
                let fail = |e| StorageError::Image(Side::A, None, e);
                bay.blank(Side::A).map_err(fail)?;
                let disk = bay.image(Side::A).map_err(fail)?;
                image::format(disk).map_err(fail)?;
                bay.flush(Side::A).map_err(fail)?;
                let ledger = Ledger { presented: Side::A, jobs: Vec::new() };
                keep_state(&mut bay, &ledger)?;
                ledger
            }
        };
        let side = ledger.presented;
        bay.image(side).and_then(image::list).map_err(|e| StorageError::Image(side, None, e))?;
        let waiting = bay.waiting();
        let waiting = waiting.map_err(|e| StorageError::Keeping("waiting jobs".into(), e))?;
        let work = Work::Presenting(None);
        let events = VecDeque::new();
        Ok(Self { bay, rules, ledger, waiting, work, is_paused: false, events })
    }

    /// Returns the state.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        match self.work {
            Work::Serving => Phase::Serving,
            Work::Preparing(..) => Phase::Preparing,
            Work::Ejecting(..) => Phase::Ejecting,
            Work::Presenting(_) => Phase::Presenting,
        }
    }

    /// Returns the image that the host sees; `None` while it sees none.
    #[must_use]
    pub const fn presented(&self) -> Option<Side> {
        match self.work {
            Work::Presenting(_) => None,
            _ => Some(self.ledger.presented),
        }
    }

    /// Returns the names of the jobs that wait, sorted.
    #[must_use]
    pub fn waiting(&self) -> &[String] {
        &self.waiting
    }

    /// Returns the state file's contents.
    #[must_use]
    pub const fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    /// Returns whether a failure has stopped the work until [`retry`](Self::retry), or another job.
    #[must_use]
    pub const fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Takes what happened since the last call, in order.
    pub fn event(&mut self) -> Option<StorageEvent> {
        self.events.pop_front()
    }

    /// Puts a job in the queue, in the place of a waiting one of the same name. Returns the name under which it is stored.
    ///
    /// # Errors
    /// The name or the size is wrong, the queue is full, or the job cannot be kept.
    pub fn send(&mut self, name: &str, bytes: &[u8]) -> Result<String, StorageError> {
        let safe = safe_name(name).map_err(|why| StorageError::Name(name.into(), why))?;
        let len = bytes.len() as u64;
        if len == 0 {
            return Err(StorageError::Empty(safe.into()));
        }
        if len > MOST_BYTES {
            return Err(StorageError::Large(safe.into(), len, MOST_BYTES));
        }
        let known = self.waiting.iter().find(|other| is_same(other, &safe)).cloned();
        if known.is_none() && self.waiting.len() >= MOST_WAITING {
            return Err(StorageError::Waiting(MOST_WAITING));
        }
        let stored = known.clone().unwrap_or(safe);
        let kept = self.bay.keep(&stored, bytes);
        kept.map_err(|e| StorageError::Keeping(format!("job '{stored}'").into(), e))?;
        if known.is_none() {
            self.waiting.push(stored.clone());
            self.waiting.sort();
        }
        self.replan();
        self.is_paused = false;
        Ok(stored)
    }

    /// Takes a waiting job out of the queue.
    ///
    /// # Errors
    /// No job of this name waits, or it cannot be removed.
    pub fn cancel(&mut self, name: &str) -> Result<(), StorageError> {
        let at = self.waiting.iter().position(|other| is_same(other, name));
        let at = at.ok_or_else(|| StorageError::Unknown(name.into()))?;
        let stored = self.waiting.remove(at);
        self.replan();
        let gone = self.bay.forget(&stored);
        gone.map_err(|e| StorageError::Keeping(format!("job '{stored}'").into(), e))
    }

    /// Marks a job of the presented image as finished: it may be deleted when an image is full.
    ///
    /// # Errors
    /// There is no such job, or the state file cannot be written.
    pub fn finish(&mut self, name: &str) -> Result<(), StorageError> {
        let mut next = self.ledger.clone();
        let job = next.jobs.iter_mut().find(|job| is_same(&job.name, name));
        job.ok_or_else(|| StorageError::Unknown(name.into()))?.is_finished = true;
        keep_state(&mut self.bay, &next)?;
        self.ledger = next;
        // The next state file was made with the old mark.
        self.replan();
        Ok(())
    }

    /// Goes on after a failure.
    pub const fn retry(&mut self) {
        self.is_paused = false;
    }

    /// Begins the next image again: all jobs that wait take one swap.
    fn replan(&mut self) {
        if matches!(self.work, Work::Preparing(..) | Work::Ejecting(..)) {
            self.work = Work::Serving;
        }
    }

    fn failed(&mut self, why: StorageError) {
        self.events.push_back(StorageEvent::Failed(why));
        self.is_paused = true;
    }

    /// Does one step: at most one file of an image. `is_idle` says whether the controller runs no job. Returns whether there
    /// may be more to do at once.
    pub fn step(&mut self, gadget: &mut impl Gadget, now: f64, is_idle: bool) -> bool {
        match core::mem::replace(&mut self.work, Work::Serving) {
            Work::Serving => self.begin(),
            Work::Preparing(plan, done) => {
                match prepare::step(&mut self.bay, self.ledger.presented, &plan, done) {
                    Ok(true) => self.work = Work::Preparing(plan, done + 1),
                    Ok(false) => self.work = Work::Ejecting(plan, None, false),
                    Err(why) => self.failed(why),
                }
            }
            Work::Ejecting(plan, _, was_reported) if !is_idle => {
                self.work = Work::Ejecting(plan, None, was_reported);
                return false;
            }
            Work::Ejecting(plan, since, was_reported) => {
                return self.eject(gadget, now, plan, since, was_reported);
            }
            Work::Presenting(Some(failed)) if now - failed < AGAIN => {
                self.work = Work::Presenting(Some(failed));
                return false;
            }
            Work::Presenting(failed) => match gadget.present(self.ledger.presented) {
                Ok(()) => self.events.push_back(StorageEvent::Presented(self.ledger.presented)),
                Err(why) => {
                    if failed.is_none() {
                        let why = StorageError::Gadget(self.ledger.presented, why);
                        self.events.push_back(StorageEvent::Failed(why));
                    }
                    self.work = Work::Presenting(Some(now));
                }
            },
        }
        !matches!(self.work, Work::Serving)
    }

    fn begin(&mut self) {
        if self.is_paused || self.waiting.is_empty() {
            return;
        }
        match self.plan() {
            Ok(plan) => self.work = Work::Preparing(plan, 0),
            Err(why) => self.failed(why),
        }
    }

    fn plan(&mut self) -> Result<ImagePlan, StorageError> {
        let side = self.ledger.presented;
        let present = self.bay.image(side).and_then(image::list);
        let present = present.map_err(|e| StorageError::Image(side, None, e))?;
        let mut waiting = Vec::new();
        for name in self.waiting.clone() {
            waiting.push(ImageFile { len: waiting_job(&mut self.bay, &name)?.len() as u64, name });
        }
        ImagePlan::new(&self.ledger, &present, &waiting, self.rules.size)
    }

    /// Tries to take the image from the host.
    fn eject(
        &mut self,
        gadget: &mut impl Gadget,
        now: f64,
        plan: ImagePlan,
        since: Option<f64>,
        was_reported: bool,
    ) -> bool {
        let side = self.ledger.presented;
        match gadget.eject() {
            Ok(()) => self.swap(plan),
            Err(NotEjected::Failed(why)) => self.failed(StorageError::Gadget(side, why)),
            Err(NotEjected::Busy) => {
                let since = since.unwrap_or(now);
                let is_long = now - since >= f64::from(BUSY_TIME);
                if is_long && self.rules.may_force {
                    match gadget.force_eject() {
                        Ok(()) => {
                            self.events.push_back(StorageEvent::Forced(side));
                            self.swap(plan);
                        }
                        Err(why) => self.failed(StorageError::Gadget(side, why)),
                    }
                    return true;
                }
                if is_long && !was_reported {
                    self.events.push_back(StorageEvent::Failed(StorageError::Busy(BUSY_TIME)));
                }
                self.work = Work::Ejecting(plan, Some(since), was_reported || is_long);
                return false;
            }
        }
        true
    }

    /// Makes the other image the presented one, after this one is ejected.
    fn swap(&mut self, plan: ImagePlan) {
        self.work = Work::Presenting(None);
        let next = Ledger { presented: self.ledger.presented.other(), jobs: plan.jobs };
        if let Err(why) = keep_state(&mut self.bay, &next) {
            // The old image is presented again.
            self.failed(why);
            return;
        }
        self.ledger = next;
        self.events.extend(plan.deleted.into_iter().map(StorageEvent::Deleted));
        for name in plan.added {
            if let Err(why) = self.bay.forget(&name) {
                // The job is on the image; its copy is added once more at the next swap.
                let why = StorageError::Keeping(format!("job '{name}'").into(), why);
                self.events.push_back(StorageEvent::Failed(why));
            }
            self.waiting.retain(|other| *other != name);
        }
    }
}

fn keep_state(bay: &mut impl Bay, ledger: &Ledger) -> Result<(), StorageError> {
    let kept = bay.set_state(&ledger.bytes());
    kept.map_err(|e| StorageError::Keeping("the state file".into(), e))
}
