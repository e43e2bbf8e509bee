use hal_component::{Component, Out, Period, Update};

/// Uses an attribute that does not exist.
#[derive(Component)]
struct Wrong {
    /// Output.
    #[hal(initial = true)]
    out: Out<bool>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.out.set(true);
    }
}

fn main() {}
