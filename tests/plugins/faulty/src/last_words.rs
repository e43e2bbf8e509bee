//! `last_words`.
use hal_component::{Builder, Component, Error, In, Period, Touch, Update};
use std::{
    io::Write,
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering::Relaxed},
    },
};

/// Reports its input when the machine stops, and the value that it had while the machine ran.
#[derive(Debug)]
pub(crate) struct LastWords;

#[derive(Debug, Touch)]
struct Look {
    input: In<u32>,
    #[state]
    seen: Arc<AtomicU32>,
}

impl Component for LastWords {
    const NAME: &'static str = "last_words";
    const DOC: &'static str = "Says at the end what its input was, and what it is.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let input: In<u32> = b.item("in", "Looked at.", 0)?;
        let seen = Arc::new(AtomicU32::new(0));
        let was = seen.clone();
        b.on_stop(move || {
            let text = format!("last words: it was {} and is {}\n", was.load(Relaxed), input.get());
            drop(std::io::stderr().write_all(text.as_bytes()));
        })?;
        b.function("", "Looks.", Look { input, seen })
    }
}

impl Update for Look {
    fn update(&mut self, _: Period) {
        self.seen.store(self.input.get(), Relaxed);
    }
}
