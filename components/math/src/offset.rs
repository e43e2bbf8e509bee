//! `offset`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Adds an offset on the way out and takes it off on the way back.
pub(crate) struct Offset;

impl Component for Offset {
    const NAME: &'static str = "offset";
    const DOC: &'static str = "Adds an offset to a number, and takes it off the feedback.\n\n\
        Two functions: `update-output` on the way out, `update-feedback` on the way back.";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let offset: In<f64> = b.item("offset", "The offset, in units.", 0.0)?;
        let output = Output {
            offset,
            from: b.item("in", "The number, in units.", 0.0)?,
            to: b.item("out", "`in` + `offset`.", 0.0)?,
        };
        let feedback = Feedback {
            offset,
            from: b.item("fb-in", "Feedback that contains the offset, in units.", 0.0)?,
            to: b.item("fb-out", "`fb-in` - `offset`.", 0.0)?,
        };
        b.function("update-output", "Adds the offset.", output)?;
        b.function("update-feedback", "Takes the offset off the feedback.", feedback)
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
    use hal_component::{bench::Bench, trace::replay};

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
