//! `person`.
use hal_component::{Component, In, Out, Period, Update};

/// Has as many inputs as its personality says.
#[derive(Component)]
#[hal(personality)]
pub(crate) struct Person {
    /// One of the inputs.
    #[hal(name = "in-##", count = b.personality())]
    inputs: Vec<In<bool>>,
    /// How many of them are true.
    count: Out<u32>,
}

impl Update for Person {
    fn update(&mut self, _: Period) {
        let set = self.inputs.iter().filter(|i| i.get()).count();
        self.count.set(u32::try_from(set).unwrap_or(u32::MAX));
    }
}
