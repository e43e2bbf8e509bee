//! Realtime. `steptest`.

use hal_component::{Component, In, Out, ParamRo, ParamRw, Period, Update};

/// Moves an axis back and forth, or jogs it, to find the speed and acceleration it can bear.
///
/// The commanded position jumps from end to end: the speed and acceleration of a move are those
/// that whoever follows the command allows, such as `stepgen.N.maxvel` and `stepgen.N.maxaccel`.
///
/// While `run` is true the axis goes to `run-low`, then to `run-high`, and so on; it waits at each
/// end until `position-fb` is there and `pause` has passed. When `run` becomes false it returns to
/// `run-start`, and only there `running` ends. Otherwise `position-cmd` is ahead of `position-fb` by
/// two periods at `maxvel` in the direction of a jog; without one it follows `position-fb`, but for
/// differences of less than a thousandth of a period at `maxvel`.
///
/// # Example
///
/// ```hal
/// loadrt steptest
/// loadrt threads name1=servo period1=1000000
/// addf steptest.0 servo
/// net position steptest.0.position-cmd steptest.0.position-fb
/// start
/// setp steptest.0.maxvel 10
/// setp steptest.0.maxaccel 100
/// setp steptest.0.jog-plus 1
/// run 1s
/// setp steptest.0.jog-plus 0
/// run 1s
/// getp steptest.0.running # -> FALSE
/// getp steptest.0.position-cmd # -> 20
/// ```
#[derive(Component)]
pub struct Steptest {
    /// True jogs forward, while nothing runs.
    jog_plus: In<bool>,
    /// True jogs backward, while nothing runs; it goes before jog-plus.
    jog_minus: In<bool>,
    /// True moves back and forth around the present position.
    run: In<bool>,
    /// Speed of a jog, in units per second.
    maxvel: In<f64>,
    /// Acceleration of the test, in units per second squared; for whoever follows the command.
    maxaccel: In<f64>,
    /// Distance from the starting position to each end of a run, in units.
    amplitude: In<f64>,
    /// Sides of the starting position that a run visits: 1 above, 2 below, any other both. It
    /// counts when a run starts.
    dir: In<i32>,
    /// Wait at each end of a run, in seconds.
    pause: In<i32>,
    /// Position of the axis, in units.
    position_fb: In<f64>,
    /// Where the axis shall go, in units.
    position_cmd: Out<f64>,
    /// True from the start of a run until the axis is back at its start.
    running: Out<bool>,
    /// Always 0: the target of a run is position-cmd.
    run_target: Out<f64>,
    /// Where the last run started, in units.
    run_start: Out<f64>,
    /// Lower end of the last run, in units.
    run_low: Out<f64>,
    /// Upper end of the last run, in units.
    run_high: Out<f64>,
    /// How near the axis must be to an end to be there, in units.
    #[hal(default = 0.001)]
    epsilon: ParamRw<f64>,
    /// How long the axis has been at this end of a run, in seconds.
    elapsed: ParamRo<f64>,
    #[state]
    active: bool,
    #[state]
    arrived: bool,
    #[state]
    ends: [f64; 3],
    #[state]
    target: f64,
    #[state]
    waited: f64,
}

impl Update for Steptest {
    fn update(&mut self, period: Period) {
        let at = self.position_fb.get();
        match (self.active, self.run.get()) {
            (false, false) => self.jog(at, period.secs()),
            (false, true) => {
                self.start(at);
                self.move_on(at, period.secs());
            }
            (true, true) => self.move_on(at, period.secs()),
            (true, false) => self.go_back(at, period.secs()),
        }
        self.position_cmd.set(self.target);
        self.running.set(self.active);
        self.elapsed.set(self.waited);
    }
}

impl Steptest {
    fn jog(&mut self, at: f64, dt: f64) {
        let reach = self.maxvel.get() * dt;
        self.target = match (self.jog_minus.get(), self.jog_plus.get()) {
            (true, _) => at - 2.0 * reach,
            (false, true) => at + 2.0 * reach,
            (false, false) if (at - self.target).abs() > 0.001 * reach => at,
            (false, false) => self.target,
        };
    }

    fn start(&mut self, at: f64) {
        let far = self.amplitude.get();
        let dir = self.dir.get();
        let low = if dir == 1 { at } else { at - far };
        let high = if dir == 2 { at } else { at + far };
        self.active = true;
        self.arrived = false;
        self.ends = [low, at, high];
        self.target = low;
        self.run_low.set(low);
        self.run_start.set(at);
        self.run_high.set(high);
    }

    fn move_on(&mut self, at: f64, dt: f64) {
        let there = self.is_at(at, self.target);
        if !self.arrived {
            if there {
                self.arrived = true;
                self.waited = 0.0;
            }
            return;
        }
        self.waited += dt;
        if there && self.waited >= f64::from(self.pause.get()) {
            let [low, _, high] = self.ends;
            if self.target == low {
                self.target = high;
                self.arrived = false;
            } else if self.target == high {
                self.target = low;
                self.arrived = false;
            }
        }
    }

    fn go_back(&mut self, at: f64, dt: f64) {
        if self.arrived {
            self.waited += dt;
        }
        let [_, start, _] = self.ends;
        self.target = start;
        if self.is_at(at, start) {
            self.active = false;
        }
    }

    fn is_at(&self, at: f64, target: f64) -> bool {
        (at - target).abs() < self.epsilon.get()
    }
}
