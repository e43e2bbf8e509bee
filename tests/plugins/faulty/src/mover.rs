//! `mover`.
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};

/// Offers the command that begins a motion, and none that ends it.
#[derive(Debug)]
pub(crate) struct Mover;

impl Component for Mover {
    const NAME: &'static str = "mover";
    const DOC: &'static str = "Offers the command that begins a motion, and none that ends it.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::text("begins", "Name of the command.").or("motion.jog")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let name = b.arg_text("begins").unwrap_or_default();
        b.command(&name, "Would begin a motion.", &[], |_| Ok(()))
    }
}
