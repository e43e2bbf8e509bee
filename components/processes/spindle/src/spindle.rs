//! `spindle`.
use hal_component::{
    Arg, Builder, Component, Error, In, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
    pins,
};

/// Speed control of a spindle with gears.
pub(crate) struct Spindle;

impl Component for Spindle {
    const NAME: &'static str = "spindle";
    const DOC: &'static str = "Speed of a spindle with gears, with limits of speed and acceleration.\n\n\
        It is for drives with an input for each direction, such as inverters. `numgears=3` makes pins for \
        three gears, 1 to 16; with several instances, `numgears=3,2` for each of them. With an \
        encoder, the output is the measured speed plus `accel` or minus `decel`, limited by the \
        command; with `simulate-encoder` the speed itself changes by that amount per second. A \
        limit of 0 or less means no limit. The spindle stops before it turns the other way.\n\n\
        # Example\n\n\
        Without an encoder, 1000 turns per minute are reached after half a second.\n\n\
        ```hal\n\
        loadrt spindle\n\
        loadrt threads name1=servo period1=1000000\n\
        addf spindle.0 servo\n\
        setp spindle.0.simulate-encoder 1\n\
        setp spindle.0.accel.0 2000\n\
        setp spindle.0.scale.0 0.01\n\
        setp spindle.0.commanded-speed 1000\n\
        setp spindle.0.enable 1\n\
        start\n\
        run 250ms\n\
        getp spindle.0.spindle-rpm # -> 500\n\
        run 251ms\n\
        getp spindle.0.at-speed # -> TRUE\n\
        getp spindle.0.output # -> 10\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::ints("numgears", "Number of gears of each instance; 1 where the list is shorter.")
            .within(1.0, 16.0)];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let all = b.arg_ints("numgears");
        let n = usize::try_from(b.index()).ok().and_then(|i| all.get(i).copied()).unwrap_or(1);
        let pins = Pins::make(b, "")?;
        let gears = (0..n).map(|i| Gear::make_number(b, i, n)).collect::<Result<_, _>>()?;
        b.function("", "Sets the speed.", Run { pins, gears, was_at_speed: false })
    }
}

pins! {
    /// Pins of the spindle.
    struct Pins {
        /// Gear, from 0; a number above the last gear selects the last. While 0, the `select` pins select the gear.
        select_gear: In<u32> = "select-gear", 0;
        /// Commanded speed, in turns per minute; below 0 is backward.
        commanded_speed: In<f64> = "commanded-speed", 0.0;
        /// Measured speed, in turns per second.
        actual_speed: In<f64> = "actual-speed", 0.0;
        /// TRUE: there is no encoder, and the commanded speed is used as the measured one.
        simulate_encoder: In<bool> = "simulate-encoder", false;
        /// TRUE turns the spindle; FALSE slows it down to a stop.
        enable: In<bool> = "enable", false;
        /// Smoothing of `spindle-rpm-abs` at speed: fraction of the difference that it follows per second; 0: no
        /// smoothing.
        spindle_lpf: In<f64> = "spindle-lpf", 0.0;
        /// Present speed, in turns per minute; below 0 is backward.
        spindle_rpm: Out<f64> = "spindle-rpm", 0.0;
        /// Magnitude of the speed for a display, in turns per minute.
        spindle_rpm_abs: Out<f64> = "spindle-rpm-abs", 0.0;
        /// Output for the drive: magnitude of the speed, plus the gear's offset, times the gear's scale, in the drive's
        /// unit.
        output: Out<f64> = "output", 0.0;
        /// Selected gear.
        current_gear: Out<u32> = "current-gear", 0;
        /// True while the speed is within `speed-tolerance` of the commanded speed.
        at_speed: Out<bool> = "at-speed", false;
        /// Turns the drive forward; also while it slows down to 0 from forward.
        forward: Out<bool> = "forward", false;
        /// Turns the drive backward; not while it slows down to 0.
        reverse: Out<bool> = "reverse", false;
        /// Always false, as in LinuxCNC 2.9.
        brake: Out<bool> = "brake", false;
        /// True while the speed is at most `zero-tolerance`.
        zero_speed: Out<bool> = "zero-speed", false;
        /// True while the commanded speed is beyond a limit of the gear.
        limited: Out<bool> = "limited", false;
    }
}

/// Declares the pins of a gear once: name, initial value, docs.
macro_rules! gear {
    ($i:ident, $n:ident: $($(#[doc = $doc:literal])+ $field:ident: $ty:ty = $name:literal, $initial:expr;)+) => {
        /// Pins of each gear.
        #[derive(Touch)]
        struct Gear {
            $($(#[doc = $doc])+ $field: $ty,)+
        }
        impl Gear {
            fn make_number(b: &mut Builder<'_>, $i: i64, $n: i64) -> Result<Self, Error> {
                Ok(Self {
                    $($field: b.item(
                        &format!("{}.{}", $name, $i),
                        &hal_component::pin_doc(&[$($doc),+]),
                        $initial,
                    )?,)+
                })
            }
        }
    };
}

gear! { i, n:
    /// Drive units per turn per minute; a negative value reverses the sign.
    scale: In<f64> = "scale", 1.0;
    /// Minimum speed other than 0, in turns per minute; 0 or less: no minimum.
    min: In<f64> = "min", 0.0;
    /// Maximum speed, in turns per minute; 0 or less: no maximum.
    max: In<f64> = "max", 0.0;
    /// Acceleration, in turns per minute per second; with an encoder, lead of the output over the measured speed, in
    /// turns per minute. 0 or less: no limit.
    accel: In<f64> = "accel", 0.0;
    /// Deceleration, in the unit of `accel`.
    decel: In<f64> = "decel", 0.0;
    /// Largest deviation from the commanded speed that counts as at speed, in turns per minute; 0 or less: never at
    /// speed.
    speed_tolerance: In<f64> = "speed-tolerance", 20.0;
    /// Highest speed that counts as standstill, in turns per minute.
    zero_tolerance: In<f64> = "zero-tolerance", 20.0;
    /// Offset added to the output, in turns per minute.
    offset: In<f64> = "offset", 0.0;
    /// Selects this gear; if several are selected, the highest counts. The only gear is selected at first.
    select: In<bool> = "select", i == 0 && n == 1;
}

#[derive(Touch)]
struct Run {
    pins: Pins,
    gears: Vec<Gear>,
    #[state]
    was_at_speed: bool,
}

impl Run {
    fn gear(&self) -> usize {
        let last = self.gears.len() - 1;
        let asked = usize::try_from(self.pins.select_gear.get()).unwrap_or(last).min(last);
        if asked > 0 {
            return asked;
        }
        self.gears.iter().rposition(|g| g.select.get()).unwrap_or(0)
    }
}

impl Update for Run {
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    fn update(&mut self, period: Period) {
        let number = self.gear();
        let Some(g) = self.gears.get(number) else { return };
        let p = &self.pins;
        p.current_gear.set(number as u32);
        let simulated = p.simulate_encoder.get();
        if !simulated {
            p.spindle_rpm.set(p.actual_speed.get() * 60.0);
        }
        // From here on in single precision, as in LinuxCNC.
        let now = p.spindle_rpm.get() as f32;
        let size = f64::from(now.abs());
        let smooth = p.spindle_lpf.get();
        let shown = if self.was_at_speed && smooth > 0.0 {
            let before = p.spindle_rpm_abs.get();
            before + (size - before) * smooth * period.secs()
        } else {
            size
        };
        p.spindle_rpm_abs.set(shown);
        p.zero_speed.set(size <= g.zero_tolerance.get());

        let enable = p.enable.get();
        let commanded = if enable { p.commanded_speed.get() as f32 } else { 0.0 };
        let turned = (commanded > 0.0 && now < 0.0) || (commanded < 0.0 && now > 0.0);
        let off = (commanded - now).abs();
        let tolerance = g.speed_tolerance.get() as f32;
        let at_speed = !turned && tolerance > 0.0 && off <= tolerance;
        p.at_speed.set(at_speed);
        self.was_at_speed = at_speed;
        let (wanted, limited) = kept(commanded, g.min.get() as f32, g.max.get() as f32);
        p.limited.set(limited);

        let seconds = if simulated { period.secs() } else { 1.0 };
        let step = |rate: f64| (f64::from(rate as f32) * seconds) as f32;
        let (up, down) = (step(g.accel.get()), step(g.decel.get()));
        let next = if at_speed { wanted } else { towards(wanted, now, up, down) };
        if simulated {
            p.spindle_rpm.set(f64::from(next));
        }
        // While slowing down to 0, `forward` stays on until the end; `reverse` does not.
        let forward = commanded != 0.0 || p.forward.get();
        p.forward.set(next > 0.0 && forward);
        p.reverse.set(next < 0.0 && commanded != 0.0);
        p.output.set((f64::from(next.abs()) + g.offset.get()) * g.scale.get());
    }
}

/// Limits the magnitude of a speed. Returns whether it had to be changed.
fn kept(speed: f32, min: f32, max: f32) -> (f32, bool) {
    let size = speed.abs();
    let (mut kept, mut limited) = (size, false);
    if min > 0.0 && size < min && size > 0.0 {
        (kept, limited) = (min, true);
    }
    // If the limits are crossed, the maximum wins.
    if max > 0.0 && kept > max {
        (kept, limited) = (max, true);
    }
    (kept.copysign(speed), limited)
}

/// Returns the next speed toward the commanded one; to change direction, it first goes to 0.
fn towards(wanted: f32, now: f32, up: f32, down: f32) -> f32 {
    let turns = (wanted > 0.0 && now < 0.0) || (wanted < 0.0 && now > 0.0);
    let goal = if turns { 0.0 } else { wanted };
    let change = goal - now;
    let slower = goal.abs() < now.abs();
    let most = if slower { down } else { up };
    let change = if most > 0.0 && change.abs() > most { most.copysign(change) } else { change };
    now + change
}

#[cfg(test)]
mod tests {
    use super::Spindle;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert!(replay::<Spindle>(include_str!("../traces/spindle.txt")) > 1000);
    }

    #[test]
    fn refusals() {
        for n in ["0", "17"] {
            let said = Bench::new().load::<Spindle>(&[&format!("numgears={n}")]).unwrap_err();
            assert_eq!(said, format!("`{n}' out of range for parameter `numgears={n}'"));
        }
    }
}
