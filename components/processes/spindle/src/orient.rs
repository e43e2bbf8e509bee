//! `orient`.
use hal_component::{Component, In, Out, Period, Update};

/// Finds where a spindle has to turn to, to stand at an angle, and tells when it stands there.
///
/// As `enable` rises the goal is chosen: a turn `n` and the angle, `n + angle / 360`, from where the
/// spindle is. The goal goes to a position loop, such as `pid`. `is-oriented` becomes TRUE when the
/// spindle stands there: for more than 100 runs in succession, and for 0.1 s at least, it is within
/// `tolerance` of the goal and moves by no more than a degree, that is, no faster than 10 degrees a
/// second. A spindle that passes the goal is
/// not oriented, however wide the tolerance. In a run in which that no longer holds, and while
/// `enable` is FALSE, `is-oriented` is FALSE. (That of LinuxCNC counts the runs near the goal, also
/// those of a spindle that turns past it again and again, and stays TRUE when the spindle leaves.)
///
/// # Preconditions
///
/// - The spindle stands before `enable` rises: the goal is the nearest from where it is then, and
///   one that turns has left it behind before a loop can hold it. `spindle.N.orient` of motmod rises
///   at once as `motion.spindle-orient` stops the spindle, so wait for standstill in between.
/// - `position` is that of the spindle itself, in turns, with enough lines: `tolerance` is more than
///   one count. It goes on counting past a whole turn, and its encoder is not reset meanwhile.
/// - While `enable` is TRUE the position loop alone moves the spindle, not its speed command.
/// - The function runs in the thread of the position loop and of motmod.
/// - Link `spindle.N.speed-in` with the measured speed: motmod then locks no spindle that turns,
///   whatever `is-oriented` says.
///
/// # Example
///
/// The whole wiring. A spindle at 300 turns a minute is to stop at 90 degrees. It stops
/// (`begin` waits for that), the loop turns it to the angle, and when it stands there motmod locks
/// it. The motor is simulated: `motor` ramps, and `encoder` sums up its turns.
///
/// ```hal
/// loadrt trivkins coordinates=X
/// loadrt motmod num_joints=1
/// loadrt orient
/// loadrt pid names=hold
/// loadrt mux2 names=wanted
/// loadrt limit2 names=motor
/// loadrt integ names=encoder
/// loadrt wcomp names=still
/// loadrt and2 names=stands
/// loadrt not names=over
/// loadrt flipflop names=begin
/// addf motion-command-handler servo-thread
/// addf motion-controller servo-thread
/// addf still servo-thread
/// addf stands servo-thread
/// addf over servo-thread
/// addf begin servo-thread
/// addf orient.0 servo-thread
/// addf hold.do-pid-calcs servo-thread
/// addf wanted servo-thread
/// addf motor servo-thread
/// addf encoder servo-thread
/// net asked spindle.0.orient => stands.in0 over.in
/// net standing still.out => stands.in1
/// net may-begin stands.out => begin.set
/// net is-over over.out => begin.reset
/// net orienting begin.out => orient.0.enable hold.enable wanted.sel
/// net angle spindle.0.orient-angle => orient.0.angle
/// net direction spindle.0.orient-mode => orient.0.mode
/// net goal orient.0.command => hold.command
/// net turns encoder.out => orient.0.position hold.feedback
/// net oriented orient.0.is-oriented => spindle.0.is-oriented
/// net speed-wanted spindle.0.speed-out-rps => wanted.in0
/// net speed-held hold.output => wanted.in1
/// net speed-both wanted.out => motor.in
/// net speed motor.out => encoder.in still.in spindle.0.speed-in
/// setp motor.maxv 20
/// setp still.min -0.01
/// setp still.max 0.01
/// setp hold.Pgain 8
/// setp hold.maxoutput 2
/// start
/// motion.configure joint=0 max-velocity=10
/// motion.enable --wait
/// motion.spindle speed=300 --wait
/// run 1s
/// getp spindle.0.speed-in # -> 5
/// motion.spindle-orient angle=90 --wait
/// run 1ms
/// getp spindle.0.locked # -> TRUE
/// getp spindle.0.orient # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Orient {
    /// Chooses the goal as it rises, and watches the error while it is TRUE. The spindle must stand
    /// as it rises.
    enable: In<bool>,
    /// Direction: 0 the shorter one, 1 towards higher positions, 2 towards lower ones; others
    /// leave the goal as it is.
    mode: In<i32>,
    /// Position of the spindle, in turns.
    position: In<f64>,
    /// Angle to stand at, in degrees, from 0 to less than 360.
    angle: In<f64>,
    /// The goal, in turns.
    command: Out<f64>,
    /// Distance of the spindle past the goal, in degrees.
    poserr: Out<f64>,
    /// TRUE while the spindle stands within `tolerance` of the goal, and has for more than 100 runs
    /// and 0.1 s; FALSE while not enabled.
    is_oriented: Out<bool>,
    /// Distance from the goal that is near enough, in degrees.
    #[hal(default = 0.5)]
    tolerance: In<f64>,
    #[state]
    was_enabled: bool,
    /// Position at which the spindle came to rest, in turns, and the number of runs and nanoseconds
    /// since then.
    #[state]
    rest: f64,
    #[state]
    runs: u32,
    #[state]
    ns: i64,
}

/// Time at rest that is required: more than this number of runs, and at least this many
/// nanoseconds.
const RUNS: u32 = 100;
const NS: i64 = 100_000_000;

/// Largest movement of a spindle at rest, in turns: one degree.
const STILL: f64 = 1.0 / 360.0;

impl Orient {
    fn goal(&self) -> f64 {
        let position = self.position.get();
        let turns = self.angle.get() / 360.0;
        let part = turns - libm::trunc(turns);
        let mut turn = libm::trunc(position);
        let goal = |turn: f64| turn + part;
        // The fraction of a turn is between -1 and 1, so two steps are enough.
        for _ in 0..2 {
            let ahead = goal(turn) - position;
            turn += match self.mode.get() {
                0 if ahead > 0.5 => -1.0,
                0 if ahead <= -0.5 => 1.0,
                1 if ahead < 0.0 => 1.0,
                1 if ahead >= 1.0 => -1.0,
                2 if ahead > 0.0 => -1.0,
                2 if ahead <= -1.0 => 1.0,
                0..=2 => 0.0,
                _ => return self.command.get(),
            };
        }
        goal(turn)
    }
}

impl Orient {
    /// Returns whether the spindle has been at rest near the goal for long enough.
    fn stands(&mut self, error: f64, period: Period) -> bool {
        let position = self.position.get();
        // NaN is neither near nor at rest.
        let is_near = libm::fabs(error) < self.tolerance.get();
        let is_still = libm::fabs(position - self.rest) <= STILL;
        if !is_near {
            self.forget();
        } else if is_still {
            self.runs = self.runs.saturating_add(1);
            self.ns = self.ns.saturating_add(period.ns());
        } else {
            (self.rest, self.runs, self.ns) = (position, 1, 0);
        }
        self.runs > RUNS && self.ns >= NS
    }

    fn forget(&mut self) {
        (self.rest, self.runs, self.ns) = (f64::NAN, 0, 0);
    }
}

impl Update for Orient {
    fn update(&mut self, period: Period) {
        let enable = self.enable.get();
        if enable {
            if !self.was_enabled {
                self.command.set(self.goal());
                self.forget();
            }
            let error = (self.position.get() - self.command.get()) * 360.0;
            self.poserr.set(error);
            let stands = self.stands(error, period);
            self.is_oriented.set(stands);
        } else {
            self.is_oriented.set(false);
        }
        self.was_enabled = enable;
    }
}

#[cfg(test)]
mod tests {
    use super::Orient;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Orient>(include_str!("../traces/orient.txt")), 240);
    }

    #[test]
    fn goals() {
        let rows = "load orient
            within 1e-9
            run orient.0
            in orient.0.enable orient.0.mode orient.0.position orient.0.angle
            out orient.0.command orient.0.poserr orient.0.is-oriented
            1 0 1.3 90 | 1.25 18 0
            1 . 1.251 . | 1.25 0.36 0
            0 . 9 . | 1.25 0.36 0
            1 0 -1.3 90 | -1.75 162 0
            0 . . . | . . .
            1 1 -1.3 90 | -0.75 -198 0
            0 . . . | . . .
            1 2 -1.3 90 | -1.75 162 0
            0 . . . | . . .
            1 1 5.1 270 | 5.75 -234 0
            0 . . . | . . .
            1 2 5.1 270 | 4.75 126 0
            0 . . . | . . .
            1 0 5.1 270 | 4.75 126 0
            0 . . . | . . .
            1 7 6 0 | 4.75 450 0";
        assert_eq!(replay::<Orient>(rows), 16);
    }

    /// Returns an orient whose goal is at 0.25 turns.
    fn bench(tolerance: f64) -> Bench {
        let mut bench = Bench::new();
        bench.load::<Orient>(&[]).unwrap();
        bench.set("orient.0.angle", 90.0);
        bench.set("orient.0.tolerance", tolerance);
        bench.set("orient.0.enable", true);
        bench
    }

    /// Runs one cycle with the spindle at `position`.
    fn at(bench: &Bench, position: f64, period: i64) -> bool {
        bench.set("orient.0.position", position);
        bench.run("orient.0", period);
        bench.get("orient.0.is-oriented")
    }

    /// From 3000 rpm down to 1 rpm, through a narrow and a wide tolerance.
    #[test]
    fn a_turning_spindle_is_not_oriented() {
        for rpm in [3000.0, 300.0, -300.0, 60.0, 10.0, -3.0, 2.0] {
            for tolerance in [0.5, 5.0, 90.0, 1e6, f64::INFINITY] {
                for period in [25_000, 1_000_000, 4_000_000] {
                    let bench = bench(tolerance);
                    let step = rpm / 60.0 * period as f64 * 1e-9;
                    let mut position = 0.25 - 0.1 * f64::signum(rpm);
                    for _ in 0..50_000 {
                        position += step;
                        let told = format!("{rpm} rpm, {tolerance} degrees at {position}");
                        assert!(!at(&bench, position, period), "{told}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_spindle_that_stands_is_oriented_after_more_than_a_hundred_runs() {
        for (period, runs) in [(1_000_000, 101), (4_000_000, 101), (50_000, 2001)] {
            for place in [0.25, 0.2512, 0.2488] {
                let bench = bench(0.5);
                // The spindle approaches, and passes the goal once.
                for n in 0..500 {
                    assert!(!at(&bench, f64::from(n) * 0.001, period));
                }
                let first = (1..).find(|_| at(&bench, place, period)).unwrap();
                assert_eq!(first, runs);
                // The spindle stays at the goal, plus or minus one count.
                for n in 0..1000 {
                    assert!(at(&bench, place + f64::from(n % 2) * 1e-4, period));
                }
                // After a disturbance, counting starts again.
                assert!(!at(&bench, 0.26, period));
                let again = (1..).find(|_| at(&bench, place, period)).unwrap();
                assert_eq!(again, runs);
                // Without enable it is not oriented, and a new goal takes time to reach.
                bench.set("orient.0.enable", false);
                assert!(!at(&bench, place, period));
                bench.set("orient.0.enable", true);
                let anew = (1..).find(|_| at(&bench, place, period)).unwrap();
                assert_eq!(anew, runs);
            }
        }
    }

    #[test]
    fn beside_the_goal_or_nowhere_it_is_not_oriented() {
        for place in [0.2515, 0.2485, 1.25, f64::NAN, f64::INFINITY] {
            let bench = bench(0.5);
            bench.set("orient.0.position", 0.25);
            bench.run("orient.0", 1_000_000);
            assert!((0..1000).all(|_| !at(&bench, place, 1_000_000)), "{place}");
        }
        for tolerance in [0.0, -1.0, f64::NAN] {
            let bench = bench(tolerance);
            assert!((0..1000).all(|_| !at(&bench, 0.25, 1_000_000)), "{tolerance}");
        }
    }
}
