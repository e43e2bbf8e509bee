//! `chatty`.
use hal_component::{
    Arg, Builder, Component, Error, In, Messages, Out, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Sends messages at every stage of its life.
#[derive(Debug)]
pub(crate) struct Chatty;

#[derive(Debug, Touch)]
struct Chat {
    times: In<u32>,
    said: Out<u32>,
    messages: Messages,
}

impl Component for Chatty {
    const NAME: &'static str = "chatty";
    const DOC: &'static str = "Says things at every turn of its life.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::text("fail", "What it says of its failure; none: it does not fail.")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let messages = b.messages();
        messages.error("being created", &[]);
        if let Some(why) = b.arg_text("fail") {
            return Err(Error::new(why));
        }
        b.on_open(move |_| {
            messages.error("being opened, {} of {}", &[1.0, 2.5]);
            Ok(())
        })?;
        b.on_stop(move || messages.error("being stopped", &[]))?;
        let chat = Chat {
            times: b.item("chatty.times", "How often it speaks in a cycle.", 0)?,
            said: b.item("chatty.said", "How often it spoke.", 0)?,
            messages,
        };
        b.function("chatty", "Speaks.", chat)
    }
}

impl Update for Chat {
    fn update(&mut self, _: Period) {
        for _ in 0..self.times.get() {
            let n = self.said.get().wrapping_add(1);
            self.said.set(n);
            self.messages.error("said {} times", &[f64::from(n)]);
        }
    }
}
