//! Realtime. Origins of motion: two of them never move at once.

use crate::{
    commands::{
        command::{Request, SpindleChange},
        refusal::Refusal,
    },
    path::Parked,
    state::State,
};
use hal_component::MotionSource;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

const PROGRAM: Refusal = Refusal::new("a program is in progress: motion.abort ends it");
const LOCAL: Refusal = Refusal::new("a local source moves the machine: motion.abort ends that");
const REMOTE: Refusal = Refusal::new("a remote source moves the machine: motion.abort ends that");
const TAKEN: &str = "a local source ended remote motion";
const ENDED: Refusal =
    Refusal::new("remote motion was ended: give the command again when the machine is at rest");

/// Origin of the last motion, and the claim of the service's owner.
#[derive(Debug, Default)]
pub(crate) struct Origin {
    /// Origin of the last motion.
    pub(crate) source: MotionSource,
    /// Origin of the last jog beside a path that rests.
    pub(crate) beside: MotionSource,
    /// True while the owner of the service keeps other sources from beginning motion.
    pub(crate) claimed: Arc<AtomicBool>,
}

impl Origin {
    pub(crate) fn is_claimed(&self) -> bool {
        self.claimed.load(Ordering::Relaxed) // Commands that follow a claim come through a queue.
    }

    /// Ends the claim.
    pub(crate) fn free(&self) {
        self.claimed.store(false, Ordering::Relaxed);
    }
}

impl State {
    /// Refuses a request that begins motion while another source moves the machine. A local source ends remote motion.
    pub(crate) fn admit(&mut self, request: &Request, source: MotionSource) -> Result<(), Refusal> {
        let moves = match request {
            Request::Jog(_) | Request::Home(_) | Request::Move(_) | Request::PathOutput(_) => true,
            Request::Mode(_)
            | Request::Orient(..)
            | Request::Spindle(
                SpindleChange { speed: Some(_), .. } | SpindleChange { brake: Some(_), .. },
            ) => {
                let foreign = self.origin.is_claimed() && source != MotionSource::Task;
                return if foreign { Err(PROGRAM) } else { Ok(()) };
            }
            _ => false,
        };
        if !moves {
            return Ok(());
        }
        let is_jog = matches!(request, Request::Jog(_));
        match self.moving_source(is_jog).filter(|mover| *mover != source) {
            None => {}
            Some(MotionSource::Remote) if source == MotionSource::Local => {
                self.end_remote(is_jog);
                return Err(ENDED);
            }
            Some(MotionSource::Task) => return Err(PROGRAM),
            Some(MotionSource::Local) => return Err(LOCAL),
            Some(MotionSource::Remote) => return Err(REMOTE),
        }
        self.begin(source);
        Ok(())
    }

    /// Returns the source that keeps a jog wheel from moving, if there is one. Called only when a wheel has turned.
    pub(crate) fn blocks_wheel(&self) -> Option<MotionSource> {
        self.moving_source(true).filter(|mover| *mover != MotionSource::Local)
    }

    /// A wheel has turned: it begins local motion, or ends remote motion.
    pub(crate) fn take_wheel(&mut self, blocked_by: Option<MotionSource>) {
        match blocked_by {
            Some(MotionSource::Remote) => {
                self.end_remote(true);
                self.say.warn(TAKEN, &[]);
            }
            Some(MotionSource::Local | MotionSource::Task) => {}
            None => self.begin(MotionSource::Local),
        }
    }

    /// Returns the source that moves the machine, or that has claimed it. Beside a path that rests in a pause, another
    /// source may jog.
    fn moving_source(&self, is_jog: bool) -> Option<MotionSource> {
        if is_jog && self.rests_on_path() {
            return self.is_jogging().then_some(self.origin.beside);
        }
        if !self.is_idle() {
            return Some(self.origin.source);
        }
        self.origin.is_claimed().then_some(MotionSource::Task)
    }

    /// Returns the origin of what moves, or of what moved last.
    pub(crate) fn origin_in_progress(&self) -> MotionSource {
        if self.rests_on_path() && self.is_jogging() {
            self.origin.beside
        } else {
            self.origin.source
        }
    }

    /// Returns whether a path rests in a pause, with the axes on it or away from it.
    fn rests_on_path(&self) -> bool {
        self.path.can_park() || self.path.parked() != Parked::No
    }

    fn begin(&mut self, source: MotionSource) {
        if self.rests_on_path() {
            self.origin.beside = source;
        } else {
            self.origin.source = source;
        }
    }

    /// Ends remote motion. A jog beside a path that rests ends jogs alone, and leaves the path.
    fn end_remote(&mut self, is_jog: bool) {
        if !(is_jog && self.rests_on_path()) {
            self.path.abort_with(Refusal::new(TAKEN));
            self.end_homing(TAKEN);
        }
        self.stop_jogs(TAKEN);
    }
}
