//! Macros that declare a kinematics component under each of its names.

/// Declares a type for each name: `names! { DOC, ARGS, create; /// About. Type = "name"; }`.
macro_rules! names {
    ($doc:expr, $args:expr, $create:path; $($(#[$about:meta])* $ty:ident = $name:literal;)*) => {$(
        $(#[$about])*
        #[derive(Debug)]
        pub struct $ty;

        impl hal_component::Component for $ty {
            const NAME: &'static str = $name;
            const DOC: &'static str = $doc;
            const FLAGS: u32 = hal_component::abi::component_flags::ONCE
                | hal_component::abi::component_flags::PARALLEL;
            const ARGS: &'static [&'static hal_component::abi::ArgSpec] = $args;
            fn create(b: &mut hal_component::Builder<'_>) -> Result<(), hal_component::Error> {
                $create(b)
            }
        }
    )*};
}
pub(crate) use names;

/// Builds the example of a component: loads it with `motmod` and this number of joints whose feedback follows at once,
/// sets its pins, homes the machine, and then runs the rest.
macro_rules! example {
    ($load:literal, $joints:tt, $set:expr, $rest:expr) => {
        concat!(
            "\n\n# Example\n\n```hal\nloadrt ",
            $load,
            "\nloadrt motmod num_joints=",
            $joints,
            "\naddf motion-command-handler servo-thread\naddf motion-controller servo-thread\n",
            $set,
            $crate::names::example!(@joints $joints),
            "start\nmotion.enable --wait\nmotion.home joint=all --wait\n",
            $rest,
            "getp motion.in-position # -> TRUE\n```"
        )
    };
    (@joints 3) => { $crate::names::example!(@list "0" "1" "2") };
    (@joints 4) => { $crate::names::example!(@list "0" "1" "2" "3") };
    (@joints 5) => { $crate::names::example!(@list "0" "1" "2" "3" "4") };
    (@joints 6) => { $crate::names::example!(@list "0" "1" "2" "3" "4" "5") };
    (@joints 9) => { $crate::names::example!(@list "0" "1" "2" "3" "4" "5" "6" "7" "8") };
    (@list $($n:literal)+) => {
        concat!($(
            "net motor-", $n, " joint.", $n, ".motor-pos-cmd => joint.", $n, ".motor-pos-fb\n",
            "motion.configure joint=", $n, " max-velocity=100 max-acceleration=1000 \
             min-limit=-1000 max-limit=1000 ferror=1 min-ferror=1\n",
        )+)
    };
}
pub(crate) use example;
