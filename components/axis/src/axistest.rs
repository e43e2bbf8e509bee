//! `axistest`.
use hal_component::{Component, In, Out, ParamRo, ParamRw, Period, Update};

/// How far a jog is ahead, in units.
const JOG: f64 = 10.0;

/// Moves an axis back and forth, or jogs it, to see how fast it can be.
///
/// The commanded position jumps from end to end: the speed of a move is what whoever follows the command
/// allows. It is `steptest` without an acceleration.
///
/// While `run` is true the axis goes to `run-low`, then to `run-high`, and so on; it waits at each
/// end until `position-fb` is there and `pause` has passed. When `run` becomes false it returns to
/// `run-start`, and only there `running` ends. Otherwise `position-cmd` is ahead of `position-fb` by
/// 10 in the direction of a jog; without one it follows `position-fb`.
///
/// # Example
///
/// ```hal
/// loadrt axistest
/// loadrt threads name1=servo period1=1000000
/// addf axistest.0.update servo
/// setp axistest.0.amplitude 2
/// setp axistest.0.run 1
/// start
/// run 1ms
/// getp axistest.0.position-cmd # -> -2
/// setp axistest.0.position-fb -2
/// run 2ms
/// getp axistest.0.position-cmd # -> 2
/// ```
#[derive(Component)]
#[hal(function = "update")]
pub(crate) struct Axistest {
    /// True jogs forward, while nothing runs.
    jog_plus: In<bool>,
    /// True jogs backward, while nothing runs; it goes before jog-plus.
    jog_minus: In<bool>,
    /// True moves back and forth around the present position.
    run: In<bool>,
    /// Highest speed; for whoever follows the command.
    maxvel: In<f64>,
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

impl Update for Axistest {
    fn update(&mut self, period: Period) {
        let at = self.position_fb.get();
        match (self.active, self.run.get()) {
            (false, false) => self.jog(at),
            (false, true) => {
                self.start(at);
                self.move_on(at, period.secs());
            }
            (true, true) => self.move_on(at, period.secs()),
            (true, false) => self.go_back(at, period.secs()),
        }
        self.position_cmd.set(self.target);
        self.running.set(self.active);
    }
}

impl Axistest {
    fn jog(&mut self, at: f64) {
        self.target = match (self.jog_minus.get(), self.jog_plus.get()) {
            (true, _) => at - JOG,
            (false, true) => at + JOG,
            (false, false) => at,
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
        self.elapsed.set(self.waited);
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
            self.elapsed.set(self.waited);
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

#[cfg(test)]
mod tests {
    use super::Axistest;
    use hal_component::trace::replay;

    #[test]
    fn jogs_and_runs() {
        let rows = "load axistest
            set axistest.0.amplitude 0.5
            run axistest.0.update
            in axistest.0.jog-plus axistest.0.jog-minus axistest.0.run axistest.0.position-fb
            out axistest.0.position-cmd axistest.0.running
            1 0 0 1 | 11 0
            1 1 0 1 | -9 0
            0 0 0 1 | 1 0
            0 0 1 1 | 0.5 1
            0 0 1 0.5 | 0.5 1
            . . . . | 1.5 1
            . . . 1.5 | 1.5 1
            . . . . | 0.5 1";
        assert_eq!(replay::<Axistest>(rows), 8);
    }
}
