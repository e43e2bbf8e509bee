//! Realtime. The states of a magazine, and its motor.

use super::pocket::Pocket;
use hal_component::{Builder, Error, In, Io, Out, ParamRo, Period, Touch, Update};

/// State of a magazine; the numbers are the values of the pin `state`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Idle = 0,
    Turning = 2,
    Pulling = 3,
    Slowing = 5,
    BackOn = 6,
    BackOff = 7,
    Onto = 8,
    There = 9,
    Seeking = 10,
    Homing = 11,
    Jogging = 20,
}

impl State {
    /// Returns whether pockets pass the spindle.
    const fn turns(self) -> bool {
        matches!(self, Self::Turning | Self::Jogging | Self::Seeking | Self::Homing)
    }
}

/// A magazine with its motor.
#[derive(Touch)]
pub(super) struct Magazine {
    pocket: Pocket,
    pocket_number: In<i32>,
    enable: In<bool>,
    active: Out<bool>,
    ready: Out<bool>,
    rev_pulse: In<f64>,
    fwd_dc: In<f64>,
    rev_dc: In<f64>,
    hold_dc: In<f64>,
    align_dc: In<f64>,
    decel_time: In<f64>,
    index_enable: Io<bool>,
    jog_fwd: In<bool>,
    jog_rev: In<bool>,
    motor_fwd: Out<bool>,
    motor_rev: Out<bool>,
    motor_vel: Out<f64>,
    counts_target: Out<f64>,
    state_out: ParamRo<i32>,
    homing: ParamRo<bool>,
    timer: ParamRo<f64>,
    motor_dir: ParamRo<i32>,
    target: ParamRo<i32>,
    #[state]
    state: State,
    /// True if the magazine turns both ways.
    #[state]
    both: bool,
}

impl Magazine {
    pub(super) fn new(
        b: &mut Builder<'_>,
        name: &str,
        pocket: Pocket,
        both: bool,
    ) -> Result<Self, Error> {
        let n = |pin: &str| format!("{name}.{pin}");
        Ok(Self {
            pocket,
            pocket_number: b.item(
                &n("pocket-number"),
                "The pocket to turn to, from 1; beyond the last it goes round, below 1 it is 1. \
                 Taken as `enable` rises.",
                0,
            )?,
            enable: b.item(
                &n("enable"),
                "Begins a change. When it falls during a turn, the motor stops; not so while \
                 looking for home, pulling back or aligning.",
                false,
            )?,
            active: b.item(&n("active"), "A change or jog is under way.", false)?,
            ready: b.item(
                &n("ready"),
                "The magazine is where the last change wanted it; FALSE as soon as a turn begins.",
                false,
            )?,
            rev_pulse: b.item(
                &n("rev-pulse"),
                "How long it is pulled back against its stop, in seconds; 0 or less: not at all.",
                0.0,
            )?,
            fwd_dc: b.item(&n("fwd-dc"), "`motor-vel` forwards, in its unit.", 0.0)?,
            rev_dc: b.item(
                &n("rev-dc"),
                "`motor-vel` in reverse, in its unit, with its sign.",
                0.0,
            )?,
            hold_dc: b.item(
                &n("hold-dc"),
                "`motor-vel` at rest, in its unit, to hold it against its stop.",
                0.0,
            )?,
            align_dc: b.item(
                &n("align-dc"),
                "`motor-vel` of the alignment, in its unit, backwards with the other sign; 0: no \
                 alignment.",
                0.0,
            )?,
            decel_time: b.item(
                &n("decel-time"),
                "How long it takes to come to rest before the alignment, in seconds.",
                0.0,
            )?,
            index_enable: b.item(
                &n("index-enable"),
                "Set when looking for home; an encoder clears it at its index, which is home with \
                 `encoding=counts`.",
                false,
            )?,
            jog_fwd: b.item(
                &n("jog-fwd"),
                "Turns to the next pocket; once, until it falls. Debounce it.",
                false,
            )?,
            jog_rev: b.item(
                &n("jog-rev"),
                "Turns to the pocket before; not with `dir=1`. Debounce it.",
                false,
            )?,
            motor_fwd: b.item(&n("motor-fwd"), "The motor is to run forwards.", false)?,
            motor_rev: b.item(&n("motor-rev"), "The motor is to run in reverse.", false)?,
            motor_vel: b.item(
                &n("motor-vel"),
                "Speed or duty cycle of the motor, in the unit of its drive: one of the `-dc` pins.",
                0.0,
            )?,
            counts_target: b.item(
                &n("counts-target"),
                "With `encoding=counts`, `counts` at the middle of `target`, by the way that it turns, for a \
                 position loop. (LinuxCNC 2.9 does not have it.)",
                0.0,
            )?,
            state_out: b.item(&n("state"), "What it does, as a number.", 0)?,
            homing: b.item(&n("homing"), "It looks for home.", false)?,
            timer: b.item(
                &n("timer"),
                "Time left to pull back or to come to rest, in seconds.",
                0.0,
            )?,
            motor_dir: b.item(
                &n("motor-dir"),
                "1: turns forwards, -1: in reverse, 0: idle.",
                0,
            )?,
            target: b.item(
                &n("target"),
                "The pocket that it turns to. (LinuxCNC 2.9 does not have it.)",
                0,
            )?,
            state: State::Idle,
            both,
        })
    }

    fn go(&mut self, state: State) {
        self.state = state;
        self.state_out.set(state as i32);
    }

    /// Runs the motor in a direction.
    fn run(&self, dir: i32) {
        self.motor_dir.set(dir);
        self.motor_fwd.set(dir > 0);
        self.motor_rev.set(dir < 0);
        self.motor_vel.set(if dir > 0 { self.fwd_dc.get() } else { self.rev_dc.get() });
    }

    fn rest(&self, vel: f64) {
        self.motor_fwd.set(false);
        self.motor_rev.set(false);
        self.motor_vel.set(vel);
    }

    /// Starts the motor towards the wanted pocket; with both directions, along the shorter path.
    fn aim(&self) {
        let n = self.pocket.pockets();
        let way = i64::from(self.wanted()) - i64::from(self.pocket.position());
        let short = way.abs() * 2 <= i64::from(n);
        let dir = if !self.both || (way > 0) == short { 1 } else { -1 };
        self.lead(dir);
        self.run(dir);
    }

    /// Writes the target for a position loop.
    fn lead(&self, dir: i32) {
        if let Some(counts) = self.pocket.counts_at(self.target.get(), dir) {
            self.counts_target.set(counts);
        }
    }

    /// Returns the pocket that `pocket-number` means.
    fn wanted(&self) -> i32 {
        let target = self.pocket_number.get().max(1).wrapping_sub(1) % self.pocket.pockets();
        self.target.set(target.wrapping_add(1));
        self.target.get()
    }

    /// Handles the arrival at the target: pulls back, begins the alignment, or finishes.
    fn arrived(&mut self) {
        if self.rev_pulse.get() > 0.0 {
            self.motor_fwd.set(false);
            self.motor_rev.set(true);
            self.motor_vel.set(self.rev_dc.get());
            self.timer.set(self.rev_pulse.get());
            self.go(State::Pulling);
        } else if self.align_dc.get() != 0.0 {
            self.motor_vel.set(0.0);
            self.timer.set(self.decel_time.get());
            self.go(State::Slowing);
        } else {
            self.finish();
        }
    }

    fn finish(&mut self) {
        self.rest(self.hold_dc.get());
        self.active.set(false);
        if self.enable.get() {
            self.ready.set(true);
        }
        self.go(State::There);
    }

    fn idle(&mut self) {
        self.motor_dir.set(0);
        if self.jog_fwd.get() || (self.jog_rev.get() && self.both) {
            if self.pocket.is_lost() {
                self.go(State::Seeking);
                return;
            }
            self.active.set(true);
            let (dir, n) = (if self.jog_rev.get() { -1 } else { 1 }, self.pocket.pockets());
            // Both at once lead back to the current pocket.
            let by = i32::from(self.jog_fwd.get()) - i32::from(self.jog_rev.get());
            let target = self.pocket.position().wrapping_add(by);
            let target = if target < 1 {
                n
            } else if target > n {
                1
            } else {
                target
            };
            self.target.set(target);
            self.lead(dir);
            self.run(dir);
            self.go(State::Jogging);
            return;
        }
        self.motor_vel.set(self.hold_dc.get());
        if self.enable.get() {
            self.active.set(true);
            if self.pocket.is_lost() {
                self.go(State::Seeking);
                return;
            }
            self.ready.set(false);
            self.aim();
            self.go(State::Turning);
            self.turn();
        }
    }

    fn turn(&mut self) {
        if self.pocket.position() == self.wanted() || !self.enable.get() {
            self.arrived();
        }
    }

    fn jog(&mut self) {
        let aligns = self.align_dc.get() != 0.0;
        let marked = self.pocket.mark() || !aligns;
        if marked && self.pocket.position() == self.target.get() {
            self.rest(self.hold_dc.get());
            self.active.set(false);
            if !self.jog_fwd.get() && !self.jog_rev.get() {
                if aligns {
                    self.motor_vel.set(-self.align_dc.get());
                    self.timer.set(self.decel_time.get());
                    self.go(State::Slowing);
                } else {
                    self.go(State::Idle);
                }
            }
        }
    }

    /// Ends the search once home is found: stops the motor, and begins the alignment if there is one.
    fn home(&mut self) {
        if !self.pocket.is_home(self.index_enable.get()) {
            return;
        }
        self.pocket.found();
        self.homing.set(false);
        self.active.set(false);
        self.rest(0.0);
        if self.align_dc.get() != 0.0 {
            self.timer.set(self.decel_time.get());
            self.go(State::Slowing);
        } else {
            self.go(State::Idle);
        }
    }

    /// Counts the timer down by one cycle; returns whether time remains.
    fn waited(&self, period: Period) -> bool {
        self.timer.set(self.timer.get() - period.secs());
        self.timer.get() > 0.0
    }
}

impl Update for Magazine {
    fn update(&mut self, period: Period) {
        let dir = i32::from(self.motor_fwd.get()) - i32::from(self.motor_rev.get());
        self.pocket.look(dir, self.state.turns());
        let before = self.state;
        self.act(period);
        if before.turns() {
            self.pocket.note(matches!(before, State::Seeking | State::Homing));
        }
    }
}

impl Magazine {
    fn act(&mut self, period: Period) {
        match self.state {
            State::Idle => self.idle(),
            State::Turning => self.turn(),
            State::Pulling => {
                if !self.waited(period) {
                    self.finish();
                }
            }
            State::Slowing => {
                if !self.waited(period) {
                    self.motor_vel.set(-self.align_dc.get());
                    self.go(if self.motor_dir.get() < 0 { State::BackOff } else { State::BackOn });
                }
            }
            State::BackOn => {
                if self.pocket.mark() {
                    self.go(State::BackOff);
                }
            }
            State::BackOff => {
                if !self.pocket.mark() {
                    self.motor_vel.set(self.align_dc.get());
                    self.go(State::Onto);
                }
            }
            State::Onto => {
                if self.pocket.mark() {
                    self.finish();
                }
            }
            State::There => {
                if !self.enable.get() {
                    self.go(State::Idle);
                }
            }
            State::Seeking => {
                self.index_enable.set(true);
                self.run(1);
                self.homing.set(true);
                self.go(State::Homing);
                self.home();
            }
            State::Homing => self.home(),
            State::Jogging => self.jog(),
        }
    }
}
