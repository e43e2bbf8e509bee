//! `foreign`.
use hal_component::{
    Builder, Component, Decl, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Uses names that do not begin with its own name.
#[derive(Debug)]
pub(crate) struct Foreign;

#[derive(Debug, Touch)]
struct Move {
    enable: In<bool>,
    position: Out<f64>,
}

impl Component for Foreign {
    const NAME: &'static str = "foreign";
    const DOC: &'static str = "Uses names that do not begin with its own.";
    const FLAGS: u32 = component_flags::ONCE;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let decl = Decl::new("joint.0.motor-pos-cmd", "Where the motor is to be.");
        let position = b.declare(decl.old("axis.0.motor-pos-cmd"), 0.0)?;
        let enable = b.item("machine.enable", "Moves while true.", false)?;
        b.function("motion-controller", "Moves.", Move { enable, position })
    }
}

impl Update for Move {
    fn update(&mut self, period: Period) {
        if self.enable.get() {
            self.position.set(self.position.get() + period.secs());
        }
    }
}
