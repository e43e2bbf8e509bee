//! Logic gates, latches and lookup tables.
#![forbid(unsafe_code)]

mod and2;
mod bitwise;
mod enumerate;
mod estop_latch;
mod flipflop;
mod logic;
mod lut5;
mod maj3;
mod match8;
mod multiswitch;
mod not;
mod or2;
mod radiobutton;
mod safety_latch;
mod toggle;
mod tristate;
mod xor2;

hal_component::export!(
    and2::And2,
    bitwise::Bitwise,
    enumerate::Enum,
    estop_latch::EstopLatch,
    flipflop::Flipflop,
    logic::Logic,
    lut5::Lut5,
    maj3::Maj3,
    match8::Match8,
    multiswitch::Multiswitch,
    not::Not,
    or2::Or2,
    radiobutton::Radiobutton,
    safety_latch::SafetyLatch,
    toggle::Toggle,
    tristate::TristateBit,
    tristate::TristateFloat,
    xor2::Xor2,
);

#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
mod readme {}

#[cfg(test)]
mod tests {
    use super::{and2::And2, not::Not, or2::Or2, xor2::Xor2};
    use hal_bench::trace::replay;

    #[test]
    fn truth_tables_of_the_simple_gates() {
        let table = |name: &str, rows: &str| {
            format!(
                "load {name}\nrun {name}.0\nin {name}.0.in0 {name}.0.in1\nout {name}.0.out\n{rows}"
            )
        };
        assert_eq!(replay::<And2>(&table("and2", "0 0 | 0\n0 1 | 0\n1 0 | 0\n1 1 | 1")), 4);
        assert_eq!(replay::<Or2>(&table("or2", "0 0 | 0\n0 1 | 1\n1 0 | 1\n1 1 | 1")), 4);
        assert_eq!(replay::<Xor2>(&table("xor2", "0 0 | 0\n0 1 | 1\n1 0 | 1\n1 1 | 0")), 4);
        let not = "load not\nrun not.0\nin not.0.in\nout not.0.out\n0 | 1\n1 | 0";
        assert_eq!(replay::<Not>(not), 2);
    }
}
