use hal_component::{Component, In, Period, Update};

/// Has a list of pins that share one name.
#[derive(Component)]
struct Wrong {
    /// Inputs.
    #[hal(name = "in", count = 4)]
    inputs: Vec<In<bool>>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {}
}

fn main() {}
