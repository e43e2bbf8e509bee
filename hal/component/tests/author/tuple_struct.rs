use hal_component::{Component, Out};

/// Has fields without names, so that its pins would have none.
#[derive(Component)]
struct Wrong(Out<bool>);

fn main() {}
