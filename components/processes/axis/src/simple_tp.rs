//! `simple_tp`.
use crate::planner::Planner;
use hal_component::{Component, In, Out, Period, Update};

/// Moves a position to a target, with limits of speed and acceleration.
///
/// In each cycle, the speed is chosen so that the axis can still stop at the target: √(2·a·d + (a·t)²) - a·t, with the
/// distance d, the acceleration a and the period t. It is limited to `maxvel`, and changes by no more than a·t. Within
/// 0.001·a·t² of the target, the axis counts as there. While not enabled, it slows down and stops.
///
/// # Example
///
/// ```hal
/// loadrt simple_tp
/// loadrt threads name1=servo period1=1000000
/// addf simple-tp.0.update servo
/// setp simple-tp.0.maxvel 10
/// setp simple-tp.0.maxaccel 100
/// setp simple-tp.0.target-pos 5
/// setp simple-tp.0.enable 1
/// start
/// run 100ms
/// getp simple-tp.0.current-vel # -> 10
/// run 1s
/// getp simple-tp.0.current-pos # -> 5
/// getp simple-tp.0.active # -> FALSE
/// ```
#[derive(Component)]
#[hal(function = "update")]
pub(crate) struct SimpleTp {
    /// Target position, in units.
    target_pos: In<f64>,
    /// Maximum speed, in units per second; NaN counts as 0.
    maxvel: In<f64>,
    /// Maximum acceleration, in units per second squared; NaN stops the axis at once.
    maxaccel: In<f64>,
    /// TRUE moves to the target; FALSE slows the axis down to a stop.
    enable: In<bool>,
    /// Present position, in units.
    current_pos: Out<f64>,
    /// Present speed, in units per second.
    current_vel: Out<f64>,
    /// True while the axis moves or has not reached the target.
    active: Out<bool>,
}

impl Update for SimpleTp {
    fn update(&mut self, period: Period) {
        let mut axis = Planner { at: self.current_pos.get(), speed: self.current_vel.get() };
        let target = self.enable.get().then(|| self.target_pos.get());
        let active = axis.go(target, self.maxvel.get(), self.maxaccel.get(), period.secs());
        self.current_vel.set(axis.speed);
        self.active.set(active);
        self.current_pos.set(axis.at);
    }
}

#[cfg(test)]
mod tests {
    use super::SimpleTp;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn starts_and_stops() {
        let rows = "load simple_tp
            set simple-tp.0.maxvel 1
            set simple-tp.0.maxaccel 100
            within 1e-12
            run simple-tp.0.update
            in simple-tp.0.target-pos simple-tp.0.enable
            out simple-tp.0.current-pos simple-tp.0.current-vel simple-tp.0.active
            5 0 | 0 0 0
            5 1 | 0.0001 0.1 1
            . . | 0.0003 0.2 1
            . . | 0.0006 0.3 1
            . 0 | 0.0008 0.2 1
            . . | 0.0009 0.1 1
            . . | 0.0009 0 .
            -5 1 | 0.0008 -0.1 1";
        assert_eq!(replay::<SimpleTp>(rows), 8);
    }

    #[test]
    fn is_never_too_fast_and_arrives() {
        let mut bench = Bench::new();
        bench.load::<SimpleTp>(&[]).unwrap();
        bench.set("simple-tp.0.maxvel", 2.0);
        bench.set("simple-tp.0.maxaccel", 50.0);
        bench.set("simple-tp.0.target-pos", 1.0);
        bench.set("simple-tp.0.enable", true);
        let mut last = 0.0;
        for _ in 0..1000 {
            bench.run("simple-tp.0.update", 1_000_000);
            let now = bench.get::<f64>("simple-tp.0.current-vel");
            assert!(now <= 2.0 && (now - last).abs() <= 0.05 + 1e-12);
            last = now;
        }
        assert!((bench.get::<f64>("simple-tp.0.current-pos") - 1.0).abs() < 1e-7);
        assert!(!bench.get::<bool>("simple-tp.0.active"));
    }
}
