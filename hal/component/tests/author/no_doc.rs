use hal_component::{Component, Out, Period, Update};

/// Has a pin without documentation.
#[derive(Component)]
struct Wrong {
    out: Out<bool>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.out.set(true);
    }
}

fn main() {}
