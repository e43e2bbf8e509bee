//! `thcud`.
use crate::height::{Correction, Height, is_at_speed};
use hal_component::{
    Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, abi::component_flags, pins,
};

/// Torch height control by up and down inputs.
pub(crate) struct Thcud;

impl Component for Thcud {
    const NAME: &'static str = "thcud";
    const DOC: &'static str = "Torch height control by two switches, up and down.\n\n\
        While enabled, with the torch on, the arc there and the speed reached, Z is raised or \
        lowered by `correction-vel` per run. With the torch off, as much of the offset is taken \
        back as Z rises, first from zero. While not enabled, Z goes through. The offset is kept in \
        single precision, as in LinuxCNC.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt thcud\n\
        loadrt threads name1=servo period1=1000000\n\
        addf thcud servo\n\
        setp thcud.correction-vel 0.01\n\
        setp thcud.requested-vel 50\n\
        setp thcud.current-vel 50\n\
        setp thcud.arc-ok 1\n\
        setp thcud.torch-on 1\n\
        setp thcud.torch-up 1\n\
        setp thcud.enable 1\n\
        start\n\
        run 3ms\n\
        getp thcud.z-pos-out # -> 0.03\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let run = Run { pins: Pins::make(b, "thcud")?, height: Height::default() };
        b.function("thcud", "Corrects the height.", run)
    }
}

pins! {
    /// Pins and parameters.
    struct Pins {
        /// TRUE raises Z.
        torch_up: In<bool> = "torch-up", false;
        /// TRUE lowers Z.
        torch_down: In<bool> = "torch-down", false;
        /// Actual speed, in units per second.
        current_vel: In<f64> = "current-vel", 0.0;
        /// Speed that the program requests, in units per second.
        requested_vel: In<f64> = "requested-vel", 0.0;
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
        /// Always 0, as in LinuxCNC; the offset is `z-pos-out` minus `z-fb-out`.
        cur_offset: Out<f64> = "cur-offset", 0.0;
        /// True if the speed is above 0 and within `velocity-tol` of the requested speed.
        vel_status: Out<bool> = "vel-status", false;
        /// True if the offset was reduced in the last cycle with the torch off.
        removing_offset: Out<bool> = "removing-offset", false;
        /// Correction of Z in one cycle, in machine units. (A parameter in LinuxCNC 2.9.)
        correction_vel: In<f64> = "correction-vel", 0.0;
        /// Largest shortfall from the requested speed that still counts as at speed, in percent.
        velocity_tol: ParamRw<f64> = "velocity-tol", 0.0;
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
        let z = p.z_pos_in.get();
        p.z_fb_out.set(z);
        if !p.enable.get() {
            p.z_pos_out.set(z);
            return;
        }
        let fast = is_at_speed(p.requested_vel.get(), p.current_vel.get(), p.velocity_tol.get());
        p.vel_status.set(fast);
        let correction = Correction {
            lowers: p.torch_down.get(),
            raises: p.torch_up.get(),
            by: p.correction_vel.get(),
        };
        let burns = p.arc_ok.get() && fast;
        if let Some(removed) = self.height.control(p.torch_on.get(), burns, z, &correction) {
            p.removing_offset.set(removed);
        }
        p.z_pos_out.set(z + f64::from(self.height.offset));
    }
}

#[cfg(test)]
mod tests {
    use super::Thcud;
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert!(replay::<Thcud>(include_str!("../traces/thcud.txt")) > 100);
    }
}
