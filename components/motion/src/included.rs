//! `homemod` and `tpmod`: what `motmod` has in itself.
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};

const IGNORED: &str = "Accepted for old scripts; nothing comes of it.";

/// Homing, as a name to load.
pub(crate) struct Homemod;

impl Component for Homemod {
    const NAME: &'static str = "homemod";
    const DOC: &'static str = "\
Homing, which `motmod` has in itself: a name that scripts may load before it.

It has no pins and no functions, and nothing is missing without it. In LinuxCNC another homing can be
loaded in its place; here it cannot.

# Example

```hal
loadrt trivkins
loadrt tpmod
loadrt homemod
loadrt motmod num_joints=1
getp joint.0.homing # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::text("home_parms", IGNORED)];

    fn create(_: &mut Builder<'_>) -> Result<(), Error> {
        Ok(())
    }
}

/// The trajectory planner, as a name to load.
pub(crate) struct Tpmod;

impl Component for Tpmod {
    const NAME: &'static str = "tpmod";
    const DOC: &'static str = "\
The trajectory planner, which `motmod` has in itself: a name that scripts may load before it.

It has no pins and no functions, and nothing is missing without it. In LinuxCNC another planner can be
loaded in its place; here it cannot.

# Example

```hal
loadrt trivkins
loadrt tpmod
loadrt homemod
loadrt motmod num_joints=1
getp motion.coord-mode # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::text("tp_parms", IGNORED)];

    fn create(_: &mut Builder<'_>) -> Result<(), Error> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Homemod, Tpmod};
    use hal_component::bench::Bench;

    #[test]
    fn names_alone() {
        let mut bench = Bench::new();
        bench.load::<Tpmod>(&[]).unwrap();
        bench.load::<Homemod>(&[]).unwrap();
        assert!(bench.names().is_empty() && bench.functs().is_empty());
        assert!(bench.load::<Homemod>(&["count=2"]).is_err());
    }
}
