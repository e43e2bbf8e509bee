//! `orient`.
use hal_component::{Component, In, Out, Period, Update};

/// Where a spindle has to turn to, to stand at an angle.
///
/// As `enable` rises the goal is chosen: a turn `n` and the angle, `n + angle / 360`, from where the
/// spindle stands. The goal goes to a position loop, such as `pid`.
///
/// # Example
///
/// A spindle stands at 1.3 turns; 90 degrees are nearest at 1.25.
///
/// ```hal
/// loadrt orient
/// loadrt threads name1=servo period1=1000000
/// addf orient.0 servo
/// setp orient.0.position 1.3
/// setp orient.0.angle 90
/// setp orient.0.enable 1
/// start
/// run 1ms
/// getp orient.0.command # -> 1.25
/// setp orient.0.position 1.2499
/// run 1ms
/// getp orient.0.is-oriented # -> TRUE
/// ```
#[derive(Component)]
pub(crate) struct Orient {
    /// Chooses the goal as it rises, and watches the error while it is true.
    enable: In<bool>,
    /// Which way: 0 the shorter one, 1 towards higher positions, 2 towards lower ones; others
    /// leave the goal as it is.
    mode: In<i32>,
    /// Where the spindle is, in turns.
    position: In<f64>,
    /// Where it shall stand, in degrees, from 0 to less than 360.
    angle: In<f64>,
    /// The goal, in turns.
    command: Out<f64>,
    /// How far the spindle is past the goal, in degrees.
    poserr: Out<f64>,
    /// True while the error is less than `tolerance`; it stays as it is while not enabled.
    is_oriented: Out<bool>,
    /// How near is near enough, in degrees.
    #[hal(default = 0.5)]
    tolerance: In<f64>,
    #[state]
    was_enabled: bool,
}

impl Orient {
    fn goal(&self) -> f64 {
        let position = self.position.get();
        let turns = self.angle.get() / 360.0;
        let part = turns - libm::trunc(turns);
        let mut turn = libm::trunc(position);
        let goal = |turn: f64| turn + part;
        // The part of a turn is between -1 and 1, so that two steps lead to the turn.
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

impl Update for Orient {
    fn update(&mut self, _: Period) {
        let enable = self.enable.get();
        if enable {
            if !self.was_enabled {
                self.command.set(self.goal());
            }
            let error = (self.position.get() - self.command.get()) * 360.0;
            self.poserr.set(error);
            self.is_oriented.set(libm::fabs(error) < self.tolerance.get());
        }
        self.was_enabled = enable;
    }
}

#[cfg(test)]
mod tests {
    use super::Orient;
    use hal_component::trace::replay;

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
            1 . 1.251 . | 1.25 0.36 1
            0 . 9 . | 1.25 0.36 1
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
}
