//! `homemod` and `tpmod`: modules that `motmod` includes.
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};

/// Defines a module that scripts can load and that does nothing.
macro_rules! included {
    ($(#[$of:meta])* $component:ident, $name:literal, $arg:literal, $what:literal, $others:literal, $shows:literal) => {
        $(#[$of])*
        pub(crate) struct $component;

        impl Component for $component {
            const NAME: &'static str = $name;
            const DOC: &'static str = concat!(
                $what,
                ", which `motmod` has in itself: a name that scripts may load before it.\n\n\
                 It has no pins and no functions, and nothing is missing without it. ",
                $others,
                "\n\n\
                 # Example\n\n```hal\nloadrt trivkins\nloadrt tpmod\nloadrt homemod\n\
                 loadrt motmod num_joints=1\ngetp ",
                $shows,
                " # -> FALSE\n```"
            );
            const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
            const ARGS: &'static [&'static ArgSpec] = &[&Arg::text(
                $arg,
                "Accepted for old scripts; nothing comes of it.",
            )];

            fn create(_: &mut Builder<'_>) -> Result<(), Error> {
                Ok(())
            }
        }
    };
}
included! {
    /// Homing, as a module name that can be loaded.
    Homemod, "homemod", "home_parms", "Homing",
    "A homing module of the user that is\nloaded in its place homes the joints.", "joint.0.homing"
}
included! {
    /// The trajectory planner, as a module name that can be loaded.
    Tpmod, "tpmod", "tp_parms", "The trajectory planner",
    "In LinuxCNC another planner can be\nloaded in its place; here it cannot.", "motion.coord-mode"
}

#[cfg(test)]
mod tests {
    use super::{Homemod, Tpmod};
    use hal_bench::Bench;

    #[test]
    fn names_alone() {
        let mut bench = Bench::new();
        bench.load::<Tpmod>(&[]).unwrap();
        bench.load::<Homemod>(&[]).unwrap();
        assert!(bench.names().is_empty() && bench.functs().is_empty());
        assert!(bench.load::<Homemod>(&["count=2"]).is_err());
    }
}
