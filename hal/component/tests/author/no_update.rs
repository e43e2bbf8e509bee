use hal_component::{Component, Out};

/// Has no code.
#[derive(Component)]
struct Wrong {
    /// Output.
    out: Out<bool>,
}

fn main() {}
