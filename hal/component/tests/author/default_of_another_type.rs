use hal_component::{Component, Out, ParamRw, Period, Update};

/// Begins with an integer where a float is wanted.
#[derive(Component)]
struct Wrong {
    /// Gain.
    #[hal(default = 1)]
    gain: ParamRw<f64>,
    /// Output.
    out: Out<f64>,
}

impl Update for Wrong {
    fn update(&mut self, _: Period) {
        self.out.set(self.gain.get());
    }
}

fn main() {}
