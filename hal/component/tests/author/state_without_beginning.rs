use hal_component::{Component, Out, Period, Update};

enum Phase {
    First,
    Second,
}

/// Has state without an initial value.
#[derive(Component)]
struct Wrong {
    /// Output.
    out: Out<bool>,
    #[state]
    phase: Phase,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.phase = if self.out.get() { Phase::First } else { Phase::Second };
        self.out.set(matches!(self.phase, Phase::First));
    }
}

fn main() {}
