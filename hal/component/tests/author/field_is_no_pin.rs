use hal_component::{Component, Out, Period, Update};

/// Has a field that is neither a pin nor state.
#[derive(Component)]
struct Wrong {
    /// Output.
    out: Out<bool>,
    /// Number of runs.
    runs: u64,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.runs += 1;
        self.out.set(true);
    }
}

fn main() {}
