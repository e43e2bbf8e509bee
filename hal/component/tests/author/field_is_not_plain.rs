use hal_component::Plain;

#[derive(Clone, Copy, Plain)]
struct Point {
    /// Name of the point.
    name: &'static str,
}

#[derive(Clone, Copy, Plain)]
struct Undescribed {
    position: f64,
}

fn main() {}
