use hal_component::{Builder, Component, Error, Out, Period, Update};

struct Counter {
    out: Out<u32>,
}

impl Update for Counter {
    fn update(&mut self, _: Period) {
        self.out.set(self.out.get().wrapping_add(1));
    }
}

struct Wrong;

impl Component for Wrong {
    const NAME: &'static str = "wrong";
    const DOC: &'static str = "Does not say what its function touches.";
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let out = b.item("out", "Runs so far.", 0)?;
        b.function("", "Counts.", Counter { out })
    }
}

fn main() {}
