use hal_component::Component;

/// Is an enum.
#[derive(Component)]
enum Wrong {
    One,
}

fn main() {}
