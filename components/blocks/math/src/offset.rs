//! `offset`.
use hal_component::{
    Builder, Component, Decl, Error, In, Out, Period, Touch, Update,
    abi::{ItemSpec, component_flags},
};

const OFFSET: Decl<'static> = Decl::new("offset", "The offset, in units.");
const IN: Decl<'static> = Decl::new("in", "The number, in units.");
const OUT: Decl<'static> = Decl::new("out", "`in` + `offset`, in their unit.");
const FB_IN: Decl<'static> = Decl::new("fb-in", "Feedback that contains the offset, in units.");
const FB_OUT: Decl<'static> = Decl::new("fb-out", "`fb-in` - `offset`, in their unit.");

/// Offset that is added to the command and subtracted from the feedback.
pub(crate) struct Offset;

impl Component for Offset {
    const NAME: &'static str = "offset";
    const DOC: &'static str = "Adds an offset to a number, and subtracts it from the feedback.\n\n\
        Two functions: `update-output` for the command, `update-feedback` for the feedback.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt offset\n\
        loadrt threads name1=servo period1=1000000\n\
        addf offset.0.update-output servo\n\
        addf offset.0.update-feedback servo\n\
        start\n\
        setp offset.0.offset 2\n\
        setp offset.0.in 5\n\
        setp offset.0.fb-in 7\n\
        run 1ms\n\
        getp offset.0.out # -> 7\n\
        getp offset.0.fb-out # -> 5\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;
    const ITEMS: &'static [&'static ItemSpec] = &[
        &OFFSET.spec::<In<f64>>(0),
        &IN.spec::<In<f64>>(0),
        &OUT.spec::<Out<f64>>(0),
        &FB_IN.spec::<In<f64>>(0),
        &FB_OUT.spec::<Out<f64>>(0),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let offset: In<f64> = b.declare(OFFSET, 0.0)?;
        let output = Output { offset, from: b.declare(IN, 0.0)?, to: b.declare(OUT, 0.0)? };
        let feedback =
            Feedback { offset, from: b.declare(FB_IN, 0.0)?, to: b.declare(FB_OUT, 0.0)? };
        b.function("update-output", "Adds the offset.", output)?;
        b.function("update-feedback", "Subtracts the offset from the feedback.", feedback)
    }
}

#[derive(Touch)]
struct Output {
    offset: In<f64>,
    from: In<f64>,
    to: Out<f64>,
}

impl Update for Output {
    fn update(&mut self, _: Period) {
        self.to.set(self.from.get() + self.offset.get());
    }
}

#[derive(Touch)]
struct Feedback {
    offset: In<f64>,
    from: In<f64>,
    to: Out<f64>,
}

impl Update for Feedback {
    fn update(&mut self, _: Period) {
        self.to.set(self.from.get() - self.offset.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Offset;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Offset>(include_str!("../traces/offset.txt")), 40);
    }

    #[test]
    fn each_function_touches_its_own_half() {
        let mut bench = Bench::new();
        bench.load::<Offset>(&[]).unwrap();
        assert_eq!(
            bench.touches("offset.0.update-output"),
            ["offset.0.offset r", "offset.0.in r", "offset.0.out w"]
        );
        assert_eq!(
            bench.touches("offset.0.update-feedback"),
            ["offset.0.offset r", "offset.0.fb-in r", "offset.0.fb-out w"]
        );
    }
}
