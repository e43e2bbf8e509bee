//! Realtime. `axistest`.
use crate::trips::{Jog, Trips, runs};
use hal_component::{Builder, Component, Error, In, Touch, abi::component_flags};

/// Moves an axis back and forth, or jogs it, to find out how fast it can move.
pub(crate) struct Axistest;

impl Component for Axistest {
    const NAME: &'static str = "axistest";
    const DOC: &'static str = concat!(
        "Moves an axis back and forth, or jogs it, to find its highest speed.\n\n\
         The commanded position jumps from end to end: the speed of a move is what the driver \
         of the motor allows. It is `steptest` without an acceleration.\n\n",
        runs!(),
        "Otherwise `position-cmd` is ahead of `position-fb` by 10 in the direction of a jog; without \
         one it follows `position-fb`.\n\n\
         # Example\n\n\
         ```hal\n\
         loadrt axistest\n\
         loadrt threads name1=servo period1=1000000\n\
         addf axistest.0.update servo\n\
         setp axistest.0.amplitude 2\n\
         setp axistest.0.run 1\n\
         start\n\
         run 1ms\n\
         getp axistest.0.position-cmd # -> -2\n\
         setp axistest.0.position-fb -2\n\
         run 2ms\n\
         getp axistest.0.position-cmd # -> 2\n\
         ```"
    );
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let ahead = Ahead {
            maxvel: b.item(
                "maxvel",
                "Highest speed, in units per second; for the component that follows the command.",
                0.0,
            )?,
        };
        let trips = Trips::new(b, ahead)?;
        b.function("update", "Moves the axis back and forth.", trips)
    }
}

/// Jog with a constant lead of the command.
#[derive(Touch)]
struct Ahead {
    maxvel: In<f64>,
}

impl Jog for Ahead {
    fn ahead(&self, _: f64) -> f64 {
        10.0
    }

    fn still(&self, at: f64, _: f64, _: f64) -> f64 {
        at
    }
}

#[cfg(test)]
mod tests {
    use super::Axistest;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Axistest>(include_str!("../traces/axistest.txt")), 150);
    }

    #[test]
    fn a_start_at_no_place_is_given_up() {
        let rows = "load axistest
            run axistest.0.update
            in axistest.0.run axistest.0.position-fb
            out axistest.0.running axistest.0.position-cmd
            1 nan | 1 nan
            0 2 | 0 nan
            0 2 | 0 2
            1 2 | 1 2";
        assert_eq!(replay::<Axistest>(rows), 4);
    }

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
