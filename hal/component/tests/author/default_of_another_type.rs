use hal_component::{Component, Out, ParamRw, Period, Update};

/// Has an integer default for a float.
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
