//! Realtime. Homing of one joint: it finds its switch and its encoder's index, or is homed in place.

use crate::{
    commands::config::{Encoder, HomeConfig},
    homing::error::HomingError,
    jogger::{By, TravelLimits},
    joint::Joint,
};

/// A search along the switch; the numbers are the values of `home-state` at its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Leg {
    /// Off the switch, if homing began on it.
    InitialBackoff = 4,
    /// Towards the switch.
    Search = 6,
    /// Off the switch again, before the slow approach.
    FinalBackoff = 9,
    /// Slowly onto the switch.
    Rise = 11,
    /// Slowly off the switch.
    Fall = 13,
}

impl Leg {
    const fn velocity(self, c: &HomeConfig) -> f64 {
        match self {
            Self::InitialBackoff | Self::FinalBackoff => -c.search_vel,
            Self::Search => c.search_vel,
            Self::Rise | Self::Fall => c.latch_vel,
        }
    }

    /// Returns the switch state that ends the search.
    const fn until(self) -> bool {
        matches!(self, Self::Search | Self::Rise)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Step {
    #[default]
    Idle,
    /// Waits until the joint is at rest.
    Start,
    /// Opens the lock.
    Unlock,
    /// Waits for the lock to open.
    Unlocking,
    /// Rests before a search.
    Before(Leg),
    On(Leg),
    /// Assigns the home offset to the current position.
    Here,
    /// Rests before searching for the index alone.
    BeforeIndex,
    OnIndex,
    /// Rests before the final move.
    BeforeFinal,
    Final,
    /// Closes the lock.
    Lock,
    /// Waits for the lock to close.
    Locking,
    /// Waits for a module to begin with the joint.
    Awaited,
    /// A module homes the joint.
    Module,
}

/// Time for a lock to open or close, in seconds.
const LOCK_TIME: f64 = 30.0;

/// Rest before each move, in seconds.
const REST: f64 = 0.1;

/// State of a joint's homing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Homing {
    step: Step,
    rest: f64,
    pub(crate) homed: bool,
    /// True while homing keeps the lock open.
    is_open: bool,
    /// Pending value of index-enable.
    index_enable: Option<bool>,
}

impl Homing {
    pub(crate) fn is_under_way(&self) -> bool {
        self.step != Step::Idle
    }

    /// Returns whether the joint is ready for its final move, on it, or has finished it.
    pub(crate) fn is_at_final_move(&self) -> bool {
        match self.step {
            Step::BeforeFinal => self.rest >= REST,
            step => matches!(step, Step::Final | Step::Lock | Step::Locking | Step::Idle),
        }
    }

    /// Returns the value of `home-state`.
    pub(crate) const fn code(&self) -> i32 {
        match self.step {
            Step::Idle => 0,
            Step::Start | Step::Awaited | Step::Module => 1,
            Step::Unlock => 2,
            Step::Unlocking => 3,
            Step::Before(leg) => leg as i32,
            Step::On(leg) => leg as i32 + 1,
            Step::Here => 15,
            Step::BeforeIndex => 16,
            Step::OnIndex => 18,
            Step::BeforeFinal => 20,
            Step::Final => 21,
            Step::Lock => 22,
            Step::Locking => 23,
        }
    }

    pub(crate) const fn begin(&mut self) {
        self.step = Step::Start;
        self.homed = false;
    }

    /// Aborts homing; a joint that was being homed becomes unhomed.
    pub(crate) fn abort(&mut self) {
        if self.step == Step::OnIndex {
            self.index_enable = Some(false);
        }
        self.is_open = false;
        self.step = Step::Idle;
    }

    /// Returns whether limit switches are those of homing: not while a module has yet to begin.
    pub(crate) fn has_limits(&self) -> bool {
        !matches!(self.step, Step::Idle | Step::Awaited)
    }

    /// Returns whether a module homes the joint.
    pub(crate) fn is_module_at_work(&self) -> bool {
        matches!(self.step, Step::Module | Step::OnIndex)
    }

    /// Waits for a module to begin.
    pub(crate) const fn await_module(&mut self) {
        self.step = Step::Awaited;
    }

    /// Notes that a module homes the joint, and whether the index has come that it waits for.
    pub(crate) const fn work_by_module(&mut self, is_at_index: bool) {
        self.step = if is_at_index { Step::OnIndex } else { Step::Module };
    }

    /// Notes that no module homes the joint.
    pub(crate) const fn leave_module(&mut self) {
        self.step = Step::Idle;
    }

    /// Opens the lock, or lets it close, as a module wants it.
    pub(crate) const fn open_lock(&mut self, is_open: bool) {
        self.is_open = is_open;
    }

    /// Returns whether homing moves the joint, or is about to, so that its lock must be open.
    pub(crate) const fn needs_open_lock(&self) -> bool {
        self.is_open
    }

    /// Returns whether the awaited index has arrived, so that the position may have jumped.
    pub(crate) fn is_at_index(&self, index_enable: bool) -> bool {
        self.step == Step::OnIndex && !index_enable
    }

    /// Returns the pending value of index-enable, and clears it.
    pub(crate) const fn take_index_enable(&mut self) -> Option<bool> {
        self.index_enable.take()
    }

    fn advance(&mut self, step: Step) {
        self.step = step;
        self.rest = 0.0;
    }
}

/// Returns the first step of a joint at rest.
fn first(c: &HomeConfig, is_on: bool) -> Step {
    if matches!(c.encoder, Encoder::Absolute | Encoder::AbsoluteStill) {
        Step::Here
    } else if c.search_vel != 0.0 {
        Step::Before(if is_on { Leg::InitialBackoff } else { Leg::Search })
    } else if c.latch_vel != 0.0 {
        Step::BeforeIndex
    } else {
        Step::Here
    }
}

/// Runs one cycle of homing. `may_finish`: the joints that make their final move together are ready.
pub(crate) fn cycle(joint: &mut Joint, dt: f64, may_finish: bool) -> Result<(), HomingError> {
    let c = joint.config.home;
    let is_on = joint.inputs.at_home;
    match joint.homing.step {
        Step::Idle | Step::Awaited | Step::Module => {}
        Step::Start => {
            if !joint.free.tp.active {
                if c.is_shared && is_on {
                    return Err(HomingError::Shared);
                }
                let next = if c.is_locking { Step::Unlock } else { first(&c, is_on) };
                joint.homing.advance(next);
            }
        }
        Step::Unlock => {
            joint.homing.is_open = true;
            joint.homing.advance(Step::Unlocking);
        }
        Step::Unlocking => {
            if joint.lock.is_open {
                joint.homing.advance(first(&c, is_on));
            } else {
                wait_for_lock(joint, dt).ok_or(HomingError::NotOpen)?;
            }
        }
        Step::Before(leg) => {
            if has_rested(joint, dt) {
                if is_on == leg.until() {
                    return Err(if is_on { HomingError::Closed } else { HomingError::Open });
                }
                start_search(joint, leg.velocity(&c));
                joint.homing.advance(Step::On(leg));
            }
        }
        Step::On(leg) => {
            if is_on != leg.until() {
                return check_search(joint);
            }
            reached(joint, leg);
        }
        Step::Here => {
            match c.encoder {
                Encoder::Resets | Encoder::Goes => joint.rename(c.offset),
                Encoder::Absolute | Encoder::AbsoluteStill => joint.offset(c.offset),
            }
            joint.homing.advance(Step::BeforeFinal);
        }
        Step::BeforeIndex => {
            if has_rested(joint, dt) {
                start_search(joint, c.latch_vel);
                search_index(joint);
            }
        }
        Step::OnIndex => {
            if !joint.homing.is_at_index(joint.inputs.index_enable) {
                return check_search(joint);
            }
            if c.encoder == Encoder::Goes {
                joint.rename(c.offset);
            } else {
                joint.offset(c.offset);
            }
            joint.free.brake();
            joint.homing.advance(Step::BeforeFinal);
        }
        Step::BeforeFinal => {
            if has_rested(joint, dt) && may_finish {
                if c.encoder != Encoder::AbsoluteStill {
                    final_move(joint);
                }
                joint.homing.advance(Step::Final);
            }
        }
        Step::Final => {
            if !joint.free.tp.active {
                if c.is_locking {
                    joint.homing.advance(Step::Lock);
                } else {
                    finish(joint);
                }
            } else if is_at_limit(joint) {
                return Err(HomingError::Limit);
            }
        }
        Step::Lock => {
            joint.homing.is_open = false;
            joint.homing.advance(Step::Locking);
        }
        Step::Locking => {
            if joint.lock.is_open {
                wait_for_lock(joint, dt).ok_or(HomingError::NotClosed)?;
            } else {
                finish(joint);
            }
        }
    }
    Ok(())
}

fn finish(joint: &mut Joint) {
    joint.homing.homed = true;
    joint.homing.advance(Step::Idle);
}

/// Counts the time in which the lock has not answered; returns `None` once it is too long.
fn wait_for_lock(joint: &mut Joint, dt: f64) -> Option<()> {
    joint.homing.rest += dt;
    (joint.homing.rest <= LOCK_TIME).then_some(())
}

/// Handles the switch reaching the state that ends the search.
fn reached(joint: &mut Joint, leg: Leg) {
    let c = joint.config.home;
    let next = match leg {
        Leg::InitialBackoff => Leg::Search,
        Leg::Search => {
            // Accurate enough for the remaining moves.
            joint.rename(c.offset);
            if c.search_vel * c.latch_vel > 0.0 { Leg::FinalBackoff } else { Leg::Fall }
        }
        Leg::FinalBackoff => Leg::Rise,
        Leg::Rise | Leg::Fall if c.use_index => return search_index(joint),
        Leg::Rise | Leg::Fall => {
            joint.rename(c.offset);
            joint.free.brake();
            return joint.homing.advance(Step::BeforeFinal);
        }
    };
    joint.free.brake();
    joint.homing.advance(Step::Before(next));
}

fn search_index(joint: &mut Joint) {
    joint.homing.index_enable = Some(true);
    // Ignores an index pulse that arrives before it is armed.
    joint.inputs.index_enable = true;
    joint.homing.advance(Step::OnIndex);
}

/// Returns whether the joint has been at rest for long enough.
fn has_rested(joint: &mut Joint, dt: f64) -> bool {
    if joint.free.tp.active {
        return false;
    }
    joint.homing.rest += dt;
    joint.homing.rest >= REST
}

/// Returns whether a joint is at a limit switch that counts during homing.
pub(crate) const fn is_at_limit(joint: &Joint) -> bool {
    (joint.inputs.at_max || joint.inputs.at_min) && !joint.config.home.ignore_limits
}

/// Checks for events that end a search.
fn check_search(joint: &Joint) -> Result<(), HomingError> {
    if is_at_limit(joint) {
        Err(HomingError::Limit)
    } else if joint.free.tp.active {
        Ok(())
    } else {
        Err(HomingError::End)
    }
}

/// Starts a search with this velocity, over twice the distance between the limits, wherever they are.
fn start_search(joint: &mut Joint, velocity: f64) {
    let distance = 2.0 * (joint.config.max_limit - joint.config.min_limit);
    let distance = if velocity > 0.0 { distance } else { -distance };
    move_to(joint, joint.free.tp.pos + distance, velocity.abs());
}

fn final_move(joint: &mut Joint) {
    let c = joint.config;
    let speed = if c.home.final_vel > 0.0 { c.home.final_vel } else { c.move_velocity() };
    move_to(joint, c.home.place, speed);
}

/// Moves to a target. HOME and the switch may lie beyond the limits, which apply only once the joint is homed.
pub(crate) fn move_to(joint: &mut Joint, target: f64, speed: f64) {
    let limits = TravelLimits {
        min: f64::NEG_INFINITY,
        max: f64::INFINITY,
        max_vel: joint.config.move_velocity(),
        max_acc: joint.config.move_acceleration(),
        max_jerk: joint.config.move_jerk(),
    };
    joint.free.set_target(target, speed, &limits, By::Homing, None);
}
