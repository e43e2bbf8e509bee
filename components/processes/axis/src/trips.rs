//! Realtime. Back-and-forth moves and jogs to test an axis, shared by `axistest` and `steptest`.
use hal_component::{Builder, Error, In, Out, ParamRo, ParamRw, Period, Touch, Update, pins};

/// Common description of a run.
macro_rules! runs {
    () => {
        "While `run` is true the axis goes to `run-low`, then to `run-high`, and so on; it waits at \
         each end until `position-fb` is there and `pause` has passed. When `run` becomes false it \
         returns to `run-start`, and only there `running` ends. "
    };
}
pub(crate) use runs;

pins! {
    /// Common pins of both.
    pub(crate) struct Pins {
        /// TRUE jogs forward, while no run is active.
        jog_plus: In<bool> = "jog-plus", false;
        /// TRUE jogs backward, while no run is active; overrides `jog-plus`.
        jog_minus: In<bool> = "jog-minus", false;
        /// TRUE moves back and forth around the present position.
        run: In<bool> = "run", false;
        /// Distance from the starting position to each end of a run, in units.
        amplitude: In<f64> = "amplitude", 0.0;
        /// Sides of the starting position that a run visits: 1 above, 2 below, any other value both. Read when a run
        /// starts.
        dir: In<i32> = "dir", 0;
        /// Wait at each end of a run, in seconds.
        pause: In<i32> = "pause", 0;
        /// Position of the axis, in units.
        position_fb: In<f64> = "position-fb", 0.0;
        /// Commanded position of the axis, in units.
        position_cmd: Out<f64> = "position-cmd", 0.0;
        /// True from the start of a run until the axis is back at its start.
        running: Out<bool> = "running", false;
        /// Always 0: the target of a run is `position-cmd`.
        run_target: Out<f64> = "run-target", 0.0;
        /// Starting position of the last run, in units.
        run_start: Out<f64> = "run-start", 0.0;
        /// Lower end of the last run, in units.
        run_low: Out<f64> = "run-low", 0.0;
        /// Upper end of the last run, in units.
        run_high: Out<f64> = "run-high", 0.0;
        /// Distance from an end below which the axis counts as there, in units.
        epsilon: ParamRw<f64> = "epsilon", 0.001;
        /// Time that the axis has been at this end of a run, in seconds.
        elapsed: ParamRo<f64> = "elapsed", 0.0;
    }
}

/// Command of a jog.
pub(crate) trait Jog: Touch + Send + 'static {
    /// Returns the lead of the jog's command over the axis, in units, for a period of `dt` seconds.
    fn ahead(&self, dt: f64) -> f64;

    /// Returns the command without a jog, for an axis at `at` that was sent to `target`.
    fn still(&self, at: f64, target: f64, dt: f64) -> f64;
}

/// Function of both components.
#[derive(Touch)]
pub(crate) struct Trips<J: Jog> {
    pins: Pins,
    jog: J,
    /// True from the start of a run until the axis is back.
    #[state]
    active: bool,
    /// True once the axis has been at this end.
    #[state]
    arrived: bool,
    /// Lower end, start and upper end of the run, in units.
    #[state]
    ends: [f64; 3],
    #[state]
    target: f64,
    #[state]
    waited: f64,
}

impl<J: Jog> Trips<J> {
    pub(crate) fn new(b: &mut Builder<'_>, jog: J) -> Result<Self, Error> {
        Ok(Self {
            pins: Pins::make(b, "")?,
            jog,
            active: false,
            arrived: false,
            ends: [0.0; 3],
            target: 0.0,
            waited: 0.0,
        })
    }
}

impl<J: Jog> Update for Trips<J> {
    fn update(&mut self, period: Period) {
        let at = self.pins.position_fb.get();
        match (self.active, self.pins.run.get()) {
            (false, false) => self.target = self.idle(at, period.secs()),
            (false, true) => {
                self.start(at);
                self.move_on(at, period.secs());
            }
            (true, true) => self.move_on(at, period.secs()),
            (true, false) => self.go_back(at, period.secs()),
        }
        self.pins.position_cmd.set(self.target);
        self.pins.running.set(self.active);
    }
}

impl<J: Jog> Trips<J> {
    /// Returns the command while no run is active.
    fn idle(&self, at: f64, dt: f64) -> f64 {
        match (self.pins.jog_minus.get(), self.pins.jog_plus.get()) {
            (true, _) => at - self.jog.ahead(dt),
            (false, true) => at + self.jog.ahead(dt),
            (false, false) => self.jog.still(at, self.target, dt),
        }
    }

    fn start(&mut self, at: f64) {
        let far = self.pins.amplitude.get();
        let dir = self.pins.dir.get();
        let low = if dir == 1 { at } else { at - far };
        let high = if dir == 2 { at } else { at + far };
        self.active = true;
        self.arrived = false;
        self.ends = [low, at, high];
        self.target = low;
        self.pins.run_low.set(low);
        self.pins.run_start.set(at);
        self.pins.run_high.set(high);
    }

    fn move_on(&mut self, at: f64, dt: f64) {
        let there = self.is_at(at, self.target);
        let [low, _, high] = self.ends;
        if !self.arrived {
            // `run` has no effect while the axis returns to the start.
            if there && (self.target == low || self.target == high) {
                self.arrived = true;
                self.waited = 0.0;
            }
            return;
        }
        self.wait(dt);
        if there && self.waited >= f64::from(self.pins.pause.get()) {
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
            self.wait(dt);
        }
        let [_, start, _] = self.ends;
        self.target = start;
        // A start that is not finite cannot be reached.
        if self.is_at(at, start) || !start.is_finite() {
            self.active = false;
        }
    }

    fn wait(&mut self, dt: f64) {
        self.waited += dt;
        self.pins.elapsed.set(self.waited);
    }

    fn is_at(&self, at: f64, target: f64) -> bool {
        (at - target).abs() < self.pins.epsilon.get()
    }
}
