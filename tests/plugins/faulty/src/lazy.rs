//! `lazy`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Works in the background, and offers commands: both panic on request.
#[derive(Debug)]
pub(crate) struct Lazy;

#[derive(Debug, Touch)]
struct Work {
    go: In<bool>,
    times: Out<u32>,
    #[state]
    what: &'static str,
}

impl Component for Lazy {
    const NAME: &'static str = "lazy";
    const DOC: &'static str = "Works in the background, and offers commands.";
    const FLAGS: u32 = component_flags::ONCE;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let go: In<bool> = b.item("lazy.go", "Both panic at the next time.", false)?;
        let times = b.item("lazy.times", "How often it worked.", 0)?;
        b.task("lazy.work", "Works.", 10_000_000, Work { go, times, what: "at work" })?;
        let times = b.item("lazy.rests", "How often it rested.", 0)?;
        b.task("lazy.rest", "Rests.", 10_000_000, Work { go, times, what: "at rest" })?;
        b.command("lazy.panic", "Panics.", &[], |_| panic!("told to panic in a command"))?;
        b.command("lazy.refuse", "Refuses.", &[], |_| Err(Error::new("not now")))?;
        b.command("lazy.wait", "Never ends.", &[], |call| call.ticket().map(|_| ()))
    }
}

impl Update for Work {
    fn update(&mut self, _: Period) {
        assert!(!self.go.get(), "told to panic {}", self.what);
        self.times.set(self.times.get().wrapping_add(1));
    }
}
