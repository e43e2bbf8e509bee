//! Realtime. `steptest`.
use crate::trips::{Jog, Trips, runs};
use hal_component::{Builder, Component, Error, In, Touch, abi::component_flags};

/// Moves an axis back and forth, or jogs it, to find its highest speed and acceleration.
#[derive(Debug)]
pub struct Steptest;

impl Component for Steptest {
    const NAME: &'static str = "steptest";
    const DOC: &'static str = concat!(
        "Moves an axis back and forth, or jogs it, to find its highest speed and acceleration.\n\n\
         The commanded position jumps from end to end: the speed and acceleration of a move are those \
         that the driver of the motor allows, such as `stepgen.N.maxvel` and \
         `stepgen.N.maxaccel`.\n\n",
        runs!(),
        "Otherwise `position-cmd` is ahead of `position-fb` by two periods at `maxvel` in the \
         direction of a jog; without one it follows `position-fb`, but for differences of less than a \
         thousandth of a period at `maxvel`.\n\n\
         # Example\n\n\
         ```hal\n\
         loadrt steptest\n\
         loadrt threads name1=servo period1=1000000\n\
         addf steptest.0 servo\n\
         net position steptest.0.position-cmd steptest.0.position-fb\n\
         start\n\
         setp steptest.0.maxvel 10\n\
         setp steptest.0.maxaccel 100\n\
         setp steptest.0.jog-plus 1\n\
         run 1s\n\
         setp steptest.0.jog-plus 0\n\
         run 1s\n\
         getp steptest.0.running # -> FALSE\n\
         getp steptest.0.position-cmd # -> 20\n\
         ```"
    );
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let by_speed = BySpeed {
            maxvel: b.item("maxvel", "Speed of a jog, in units per second.", 0.0)?,
            maxaccel: b.item(
                "maxaccel",
                "Acceleration of the test, in units per second squared; for the component that \
                follows the command.",
                0.0,
            )?,
        };
        let trips = Trips::new(b, by_speed)?;
        b.function("", "Moves the axis back and forth.", trips)
    }
}

/// Jog whose command is two periods ahead.
#[derive(Touch)]
struct BySpeed {
    maxvel: In<f64>,
    maxaccel: In<f64>,
}

impl Jog for BySpeed {
    fn ahead(&self, dt: f64) -> f64 {
        self.maxvel.get() * 2.0 * dt
    }

    fn still(&self, at: f64, target: f64, dt: f64) -> f64 {
        if (at - target).abs() > 0.001 * (self.maxvel.get() * dt) { at } else { target }
    }
}

#[cfg(test)]
mod tests {
    use super::Steptest;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Steptest>(include_str!("../traces/steptest.txt")), 150);
    }
}
