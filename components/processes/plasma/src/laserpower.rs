//! `laserpower`.
use hal_component::{Component, In, Out, Period, Update};

/// Laser power in proportion to speed, constant along a path or changing along each move.
///
/// `power` is `command-power` times `vel-scale`, the ratio of actual to requested speed, so that the laser burns no
/// deeper in corners, where the machine is slow. While the machine moves, `power` is limited to `min-power` and
/// `max-power`; if `min-power` is the higher one, `max-power` wins. While not enabled, and while the machine is at rest
/// (`cur-velocity` is 0, below 0 or NaN), `power` is 0, also with a `min-power` above 0: a laser that stays in place, as
/// at a feed hold, burns a hole. In vector mode, `command-power` is `vector-power`. In raster mode, it changes linearly
/// with distance, from its value when `raster-power` changed to `raster-power` at the end of the move. If the computed
/// power is NaN, `min-power` is used.
///
/// Only LinuxCNC 2.10 has this component. Its pins are known here, but not its arithmetic: this computation is our own
/// and may differ.
///
/// # Example
///
/// ```hal
/// loadrt laserpower
/// loadrt threads name1=servo period1=1000000
/// addf laserpower.0 servo
/// setp laserpower.0.enabled 1
/// setp laserpower.0.max-power 100
/// setp laserpower.0.vector-power 80
/// setp laserpower.0.req-velocity 20
/// setp laserpower.0.cur-velocity 5
/// start
/// run 1ms
/// getp laserpower.0.power # -> 20
/// setp laserpower.0.raster-mode 1
/// setp laserpower.0.cur-velocity 20
/// setp laserpower.0.distance-to-go 4
/// run 1ms
/// getp laserpower.0.power # -> 80
/// setp laserpower.0.distance-to-go 3
/// run 1ms
/// getp laserpower.0.power # -> 60
/// ```
#[derive(Component)]
pub(crate) struct Laserpower {
    /// TRUE allows power; while FALSE, `power` is 0.
    enabled: In<bool>,
    /// TRUE: the power changes along each move (raster mode); FALSE: it is constant (vector mode).
    raster_mode: In<bool>,
    /// Power at the end of the move in raster mode, in the laser's unit, such as percent.
    raster_power: In<f64>,
    /// Power in vector mode, in the laser's unit.
    vector_power: In<f64>,
    /// Minimum power while enabled and in motion, in the laser's unit.
    min_power: In<f64>,
    /// Maximum power, in the laser's unit; a value below 0 counts as 0.
    max_power: In<f64>,
    /// Actual speed, in units per second; from `motion.current-vel`. Unless it is above 0, `power` is 0.
    cur_velocity: In<f64>,
    /// Requested speed, in units per second; from `motion.requested-vel`. At 0, `vel-scale` is 0.
    req_velocity: In<f64>,
    /// Distance to the end of the move, in units; from `motion.distance-to-go`.
    distance_to_go: In<f64>,
    /// Ratio of actual to requested speed, 0 to 1.
    vel_scale: Out<f64>,
    /// Power at the requested speed, before `vel-scale` and the limits, in the laser's unit.
    command_power: Out<f64>,
    /// Power for the laser, in the laser's unit.
    power: Out<f64>,
    /// Value of `command-power` when `raster-power` last changed, in the laser's unit.
    start_power: Out<f64>,
    /// Value of `distance-to-go` when `raster-power` last changed, in units.
    start_distance: Out<f64>,
    /// Power at the end of the present change, in raster mode.
    #[state]
    goal: Option<f64>,
}

impl Update for Laserpower {
    fn update(&mut self, _: Period) {
        let command = if self.raster_mode.get() {
            self.along_the_move()
        } else {
            self.goal = None;
            self.vector_power.get()
        };
        self.command_power.set(command);
        let scale = part(self.cur_velocity.get(), self.req_velocity.get());
        self.vel_scale.set(scale);
        let most = above_0(self.max_power.get());
        let mut power = command * scale;
        if power < self.min_power.get() || power.is_nan() {
            power = self.min_power.get();
        }
        if power > most {
            power = most;
        }
        // NaN fails the comparison.
        let burns = self.enabled.get() && self.cur_velocity.get() > 0.0;
        self.power.set(if burns { above_0(power) } else { 0.0 });
    }
}

impl Laserpower {
    fn along_the_move(&mut self) -> f64 {
        let goal = self.raster_power.get();
        if self.goal != Some(goal) {
            self.goal = Some(goal);
            self.start_power.set(self.command_power.get());
            self.start_distance.set(self.distance_to_go.get());
        }
        let start = self.start_power.get();
        goal + (start - goal) * part(self.distance_to_go.get(), self.start_distance.get())
    }
}

/// Returns the ratio of `something` to `whole`, limited to 0 to 1; 0 if `whole` is not above 0.
fn part(something: f64, whole: f64) -> f64 {
    let part = above_0(something) / above_0(whole);
    if whole > 0.0 && part >= 1.0 {
        1.0
    } else if whole > 0.0 {
        above_0(part)
    } else {
        0.0
    }
}

/// Returns the number, or 0 if it is not above 0 (or is NaN).
fn above_0(number: f64) -> f64 {
    if number > 0.0 { number } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::Laserpower;
    use hal_bench::trace::replay;

    #[test]
    fn in_proportion_to_speed() {
        let rows = "load laserpower names=l
            set l.enabled 1
            set l.max-power 100
            run l
            in l.vector-power l.cur-velocity l.req-velocity l.min-power l.max-power
            out l.vel-scale l.power
            80 20 20 0 100 | 1 80
            80 5 20 0 100 | 0.25 20
            80 30 20 0 100 | 1 80
            80 -5 20 0 100 | 0 0
            80 5 20 30 100 | 0.25 30
            80 5 20 30 10 | 0.25 10
            80 5 20 30 -1 | 0.25 0
            80 0 0 0 100 | 0 0
            80 5 0 0 100 | 0 0
            80 5 -1 0 100 | 0 0
            nan 20 20 0 100 | 1 0
            inf 20 20 0 100 | 1 100
            80 nan 20 10 100 | 0 0
            80 0 20 10 100 | 0 0
            80 -5 20 10 100 | 0 0
            80 1e-9 20 10 100 | 5e-11 10
            80 5 0 10 100 | 0 10
            80 20 20 nan 100 | 1 80
            80 20 20 0 nan | 1 0
            set l.enabled 0
            80 20 20 10 100 | 1 0";
        assert_eq!(replay::<Laserpower>(rows), 20);
    }

    #[test]
    fn changes_along_a_move() {
        let rows = "load laserpower names=l
            set l.enabled 1
            set l.max-power 100
            set l.cur-velocity 1
            set l.req-velocity 1
            run l
            in l.raster-mode l.raster-power l.distance-to-go
            out l.start-power l.start-distance l.command-power l.power
            1 0 8 | 0 8 0 0
            1 40 8 | 0 8 0 0
            1 40 6 | 0 8 10 10
            1 40 0 | 0 8 40 40
            1 20 4 | 40 4 40 40
            1 20 2 | 40 4 30 30
            1 20 9 | 40 4 40 40
            1 20 nan | 40 4 20 20
            1 60 0 | 20 0 60 60
            0 60 3 | 20 0 0 0
            1 60 3 | 0 3 0 0";
        assert_eq!(replay::<Laserpower>(rows), 11);
    }
}
