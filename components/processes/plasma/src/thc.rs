//! `thc`.
use crate::height::{Correction, Height, is_at_speed};
use hal_component::{
    Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, abi::component_flags, pins,
};

/// Torch height control by arc voltage.
pub(crate) struct Thc;

impl Component for Thc {
    const NAME: &'static str = "thc";
    const DOC: &'static str = "Torch height control by the voltage of the arc.\n\n\
        While enabled, with the torch on, the arc there and the speed reached, Z is lowered or \
        raised by `correction-vel` per run until the voltage is near `volts-requested`. With the \
        torch off, as much of the offset is taken back as Z rises, first from zero. While not \
        enabled, Z goes through. The offset is kept in single precision, as in LinuxCNC.\n\n\
        # Example\n\n\
        95 V where 100 V are wanted: the torch is raised by 0.01 in each run.\n\n\
        ```hal\n\
        loadrt thc\n\
        loadrt threads name1=servo period1=1000000\n\
        addf thc servo\n\
        setp thc.vel-scale 0.01\n\
        setp thc.voltage-tol 1\n\
        setp thc.correction-vel 0.01\n\
        setp thc.encoder-vel 9500\n\
        setp thc.volts-requested 100\n\
        setp thc.requested-vel 50\n\
        setp thc.current-vel 50\n\
        setp thc.arc-ok 1\n\
        setp thc.torch-on 1\n\
        setp thc.enable 1\n\
        start\n\
        run 3ms\n\
        getp thc.volts # -> 95\n\
        getp thc.z-pos-out # -> 0.03\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let run = Run { pins: Pins::make(b, "thc")?, height: Height::default() };
        b.function("thc", "Measures, and corrects the height.", run)
    }
}

pins! {
    /// Pins and parameters.
    struct Pins {
        /// Frequency of the voltage card, from an encoder's `velocity`, in hertz.
        encoder_vel: In<f64> = "encoder-vel", 0.0;
        /// Actual speed, in units per second.
        current_vel: In<f64> = "current-vel", 0.0;
        /// Speed that the program requests, in units per second.
        requested_vel: In<f64> = "requested-vel", 0.0;
        /// Target arc voltage, in volts.
        volts_requested: In<f64> = "volts-requested", 0.0;
        /// Without effect; kept for scripts that set it.
        vel_tol: In<f64> = "vel-tol", 0.0;
        /// TRUE while the torch is on.
        torch_on: In<bool> = "torch-on", false;
        /// TRUE while there is an arc.
        arc_ok: In<bool> = "arc-ok", false;
        /// Enables height control.
        enable: In<bool> = "enable", false;
        /// Commanded Z position, in units.
        z_pos_in: In<f64> = "z-pos-in", 0.0;
        /// Z with the offset, in units, for the motor.
        z_pos_out: Out<f64> = "z-pos-out", 0.0;
        /// Z without the offset, in units, for the feedback of the axis.
        z_fb_out: Out<f64> = "z-fb-out", 0.0;
        /// Arc voltage, in volts; never below 0.
        volts: Out<f64> = "volts", 0.0;
        /// True if the speed is above 0 and within `velocity-tol` of the requested speed.
        vel_status: Out<bool> = "vel-status", false;
        /// Offset of Z before this cycle, in units.
        offset_value: Out<f64> = "offset-value", 0.0;
        /// Volts per hertz.
        vel_scale: ParamRw<f64> = "vel-scale", 0.0;
        /// Frequency at 0 V, in hertz.
        scale_offset: ParamRw<f64> = "scale-offset", 0.0;
        /// Largest shortfall from the requested speed that still counts as at speed, in percent.
        velocity_tol: ParamRw<f64> = "velocity-tol", 0.0;
        /// Largest deviation from the target voltage that is not corrected, in volts.
        voltage_tol: ParamRw<f64> = "voltage-tol", 0.0;
        /// Correction of Z in one cycle, in machine units.
        correction_vel: ParamRw<f64> = "correction-vel", 0.0;
    }
}

#[derive(Touch)]
struct Run {
    pins: Pins,
    #[state]
    height: Height,
}

impl Update for Run {
    fn update(&mut self, _: Period) {
        let p = &self.pins;
        let volts = (p.encoder_vel.get() - p.scale_offset.get()) * p.vel_scale.get();
        p.volts.set(if volts < 0.0 { 0.0 } else { volts });
        p.offset_value.set(f64::from(self.height.offset));
        let z = p.z_pos_in.get();
        p.z_fb_out.set(z);
        if !p.enable.get() {
            p.z_pos_out.set(z);
            return;
        }
        let fast = is_at_speed(p.requested_vel.get(), p.current_vel.get(), p.velocity_tol.get());
        p.vel_status.set(fast);
        let (volts, wanted) = (p.volts.get(), p.volts_requested.get());
        let tolerance = p.voltage_tol.get();
        // Within the tolerance, both corrections apply and cancel out.
        let correction = Correction {
            lowers: volts + tolerance > wanted,
            raises: volts - tolerance < wanted,
            by: p.correction_vel.get(),
        };
        self.height.control(p.torch_on.get(), p.arc_ok.get() && fast, z, &correction);
        p.z_pos_out.set(z + f64::from(self.height.offset));
    }
}

#[cfg(test)]
mod tests {
    use super::Thc;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert!(replay::<Thc>(include_str!("../traces/thc.txt")) > 100);
    }
}
