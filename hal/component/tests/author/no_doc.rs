use hal_component::{Component, Out, Period, Update};

/// Has a pin that nobody can understand.
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
