//! `sim_axis_hardware`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Home and limit switches of eight joints.
pub(crate) struct SimAxisHardware;

const AXES: [&str; 8] = ["X", "X2", "Y", "Y2", "Z", "A", "U", "V"];

impl Component for SimAxisHardware {
    const NAME: &'static str = "sim_axis_hardware";
    const DOC: &'static str = "Simulated home and limit switches, pressed by the positions of a \
        machine's joints.\n\n\
        For each of X, X2, Y, Y2, Z, A, U and V there are switches on their own and in every way they \
        may be wired together; X2 and Y2 are the second motors of a gantry. \
        As in LinuxCNC, `Amaxsw-homesw-out`, `Aminsw-homesw-out` and `Abothsw-homesw-out` stay false.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt sim_axis_hardware\n\
        loadrt threads name1=servo period1=1000000\n\
        addf sim-axis-hardware.0.update servo\n\
        setp sim-axis-hardware.0.Xmaxsw-lower 9\n\
        setp sim-axis-hardware.0.Xmaxsw-upper 10\n\
        setp sim-axis-hardware.0.Xcurrent-pos 9.5\n\
        start\n\
        run 1ms\n\
        getp sim-axis-hardware.0.Xmaxsw-out # -> TRUE\n\
        getp sim-axis-hardware.0.limitsw-all # -> TRUE\n\
        getp sim-axis-hardware.0.Xhomesw-out # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let axes = AXES.iter().map(|axis| Axis::make_for(b, axis)).collect::<Result<_, _>>()?;
        let all = All {
            axes,
            limit_offset: b.item(
                "limit-offset",
                "Distance of the limit switches outside their inner ends, in units.",
                0.01,
            )?,
            homesw_all: b.item(
                "homesw-all",
                "True at the home switch of any joint, while one homes.",
                false,
            )?,
            limitsw_all: b.item(
                "limitsw-all",
                "True at a limit switch of any joint, while none homes.",
                false,
            )?,
            both_all: b.item(
                "limitsw-homesw-all",
                "True when either of these two is true.",
                false,
            )?,
        };
        b.function("update", "Determines which switches are pressed.", all)
    }
}

/// Declares the pins of a joint once: name, direction, initial value, docs.
macro_rules! axis {
    ($($(#[doc = $doc:literal])+ $field:ident: $ty:ty = $end:literal, $initial:expr;)+) => {
        /// Pins of a joint.
        #[derive(Touch)]
        struct Axis {
            $($(#[doc = $doc])+ $field: $ty,)+
            /// True if an output that includes the home switch is linked.
            #[state]
            wired: bool,
        }
        impl Axis {
            fn make_for(b: &mut Builder<'_>, axis: &str) -> Result<Self, Error> {
                Ok(Self {
                    $($field: b.item(
                        &format!("{axis}{}", $end),
                        &hal_component::pin_doc(&[$($doc),+]),
                        $initial,
                    )?,)+
                    wired: axis != "A",
                })
            }
        }
    };
}

axis! {
    /// Position of the joint, in units, such as `joint.0.motor-pos-fb`.
    current_pos: In<f64> = "current-pos", 0.0;
    /// Centre of the home switch, in units.
    home_pos: In<f64> = "homesw-pos", 1.0;
    /// Outer end of the upper limit switch, in units; the switch is pressed below it.
    max_upper: In<f64> = "maxsw-upper", 0.0;
    /// Inner end of the upper limit switch, in units; the switch is pressed `limit-offset` above it.
    max_lower: In<f64> = "maxsw-lower", 0.0;
    /// Inner end of the lower limit switch, in units; the switch is pressed `limit-offset` below it.
    min_upper: In<f64> = "minsw-upper", 0.0;
    /// Outer end of the lower limit switch, in units; the switch is pressed above it.
    min_lower: In<f64> = "minsw-lower", 0.0;
    /// Width of the home switch, in units.
    home_hyst: In<f64> = "homesw-hyst", 0.025;
    /// TRUE while the joint homes: while any joint homes, shared inputs count only as home switches.
    homing: In<bool> = "homing", false;
    /// Home switch.
    home: Out<bool> = "homesw-out", false;
    /// Upper limit switch.
    max: Out<bool> = "maxsw-out", false;
    /// Lower limit switch.
    min: Out<bool> = "minsw-out", false;
    /// Both limit switches on one wire; false while a joint homes.
    both: Out<bool> = "bothsw-out", false;
    /// Upper limit switch and home switch on one wire.
    max_home: Out<bool> = "maxsw-homesw-out", false;
    /// Lower limit switch and home switch on one wire.
    min_home: Out<bool> = "minsw-homesw-out", false;
    /// All three switches on one wire; only the home switch while a joint homes.
    both_home: Out<bool> = "bothsw-homesw-out", false;
}

impl Axis {
    /// Returns whether the home switch is pressed, and whether a limit switch is.
    fn press(&self, offset: f64, homing: bool) -> (bool, bool) {
        let (at, home, half) =
            (self.current_pos.get(), self.home_pos.get(), self.home_hyst.get() / 2.0);
        // A comparison with NaN counts as pressed.
        let off = |low: bool, high: bool| !(low || high);
        let home = off(libm::fabs(at - home) > half, false);
        let max = off(at <= self.max_lower.get() + offset, at >= self.max_upper.get());
        let min = off(at <= self.min_lower.get(), at >= self.min_upper.get() - offset);
        let limit = !homing && (max || min);
        self.home.set(home);
        self.max.set(max);
        self.min.set(min);
        self.both.set(limit);
        if self.wired {
            self.max_home.set(max || home);
            self.min_home.set(min || home);
            self.both_home.set(limit || home);
        }
        (home, limit)
    }
}

#[derive(Touch)]
struct All {
    axes: Vec<Axis>,
    limit_offset: In<f64>,
    homesw_all: Out<bool>,
    limitsw_all: Out<bool>,
    both_all: Out<bool>,
}

impl Update for All {
    fn update(&mut self, _: Period) {
        let homing = self.axes.iter().any(|a| a.homing.get());
        let (mut home, mut limit) = (false, false);
        for axis in &self.axes {
            let (at_home, at_limit) = axis.press(self.limit_offset.get(), homing);
            home |= at_home;
            limit |= at_limit;
        }
        let home = home && homing;
        self.homesw_all.set(home);
        self.limitsw_all.set(limit);
        self.both_all.set(home || limit);
    }
}

#[cfg(test)]
mod tests {
    use super::SimAxisHardware;
    use hal_bench::trace::replay;

    #[test]
    fn switches_along_an_axis() {
        let rows = "load sim_axis_hardware
            set sim-axis-hardware.0.Y2maxsw-lower 9
            set sim-axis-hardware.0.Y2maxsw-upper 10
            set sim-axis-hardware.0.Y2minsw-lower -10
            set sim-axis-hardware.0.Y2minsw-upper -9
            run sim-axis-hardware.0.update
            in sim-axis-hardware.0.Y2current-pos sim-axis-hardware.0.Y2homing
            out sim-axis-hardware.0.Y2homesw-out sim-axis-hardware.0.Y2maxsw-out sim-axis-hardware.0.Y2minsw-out sim-axis-hardware.0.Y2bothsw-out sim-axis-hardware.0.Y2maxsw-homesw-out sim-axis-hardware.0.Y2minsw-homesw-out sim-axis-hardware.0.Y2bothsw-homesw-out sim-axis-hardware.0.homesw-all sim-axis-hardware.0.limitsw-all sim-axis-hardware.0.limitsw-homesw-all
            0 0 | 0 0 0 0 0 0 0 0 0 0
            0.9875 0 | 1 0 0 0 1 1 1 0 0 0
            1.0125 1 | 1 0 0 0 1 1 1 1 0 1
            1.013 1 | 0 0 0 0 0 0 0 0 0 0
            9.01 0 | 0 0 0 0 0 0 0 0 0 0
            9.5 0 | 0 1 0 1 1 0 1 0 1 1
            9.5 1 | 0 1 0 0 1 0 0 0 0 0
            10 0 | 0 0 0 0 0 0 0 0 0 0
            -9.5 0 | 0 0 1 1 0 1 1 0 1 1
            nan 0 | 1 1 1 1 1 1 1 0 1 1";
        assert_eq!(replay::<SimAxisHardware>(rows), 10);
    }
}
