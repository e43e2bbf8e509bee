//! `person`.
use hal_component::{Component, In, Out, Period, Update};

/// Has as many inputs as its personality.
#[derive(Component)]
#[hal(personality)]
pub(crate) struct Person {
    /// Input ##.
    #[hal(name = "in-##", count = b.personality())]
    inputs: Vec<In<bool>>,
    /// Number of true inputs.
    count: Out<u32>,
}

impl Update for Person {
    fn update(&mut self, _: Period) {
        let set = self.inputs.iter().filter(|i| i.get()).count();
        self.count.set(u32::try_from(set).unwrap_or(u32::MAX));
    }
}
