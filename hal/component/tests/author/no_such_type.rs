use hal_component::{Component, In, Period, Update};

/// Has a pin of a type that no pin can carry.
#[derive(Component)]
struct Wrong {
    /// Input.
    in_: In<u8>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {}
}

fn main() {}
