use hal_component::{Component, Out};

/// Has fields without names, so its pins would have none.
#[derive(Component)]
struct Wrong(Out<bool>);

fn main() {}
