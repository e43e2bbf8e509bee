//! `message`.
use hal_component::{
    Arg, Builder, Component, Error, In, Messages, ParamRw, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
    lasting,
};

/// Message that a bit triggers.
pub(crate) struct Message;

impl Component for Message {
    const NAME: &'static str = "message";
    const DOC: &'static str = "Messages triggered by bits, such as a low oil level.\n\n\
        `messages=` has a text for each of `count=` or `names=`, separated by commas; more are not used. \
        The text is printed as an error of the instance, in `halcmd` and in the log, as soon as \
        the bit reaches the state that `edge` selects. LinuxCNC shows it in its user interface as \
        well. A text stays in memory when its component is unloaded, but only once, however often \
        it is loaded.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt message names=oil messages=\"Slideway oil low\"\n\
        loadrt threads name1=servo period1=1000000\n\
        addf oil servo\n\
        setp oil.edge 0\n\
        setp oil.trigger 1\n\
        start\n\
        run 1ms\n\
        getp oil.edge # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::texts(
        "messages",
        "A text for each instance, separated by commas, such as `hot,cold`; none may be missing.",
    )
    .required()];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let number = b.index() as usize;
        let Some(text) = b.arg_text_at("messages", number) else {
            return Err(Error::new(format!("messages= has no text number {}", number + 1)));
        };
        let run = Run {
            trigger: b.item("trigger", "Bit that causes the message.", false)?,
            force: b.item(
                "force",
                "A rising edge repeats the message while its condition holds.",
                false,
            )?,
            edge: b.item("edge", "State of `trigger` that causes the message.", true)?,
            text: lasting(text),
            messages: b.messages(),
            held: false,
            forced: false,
        };
        b.function("", "Prints the message when it is due.", run)
    }
}

#[derive(Touch)]
struct Run {
    trigger: In<bool>,
    force: In<bool>,
    edge: ParamRw<bool>,
    messages: Messages,
    #[state]
    text: &'static str,
    /// True if the bit triggered the message in the previous cycle.
    #[state]
    held: bool,
    #[state]
    forced: bool,
}

impl Update for Run {
    fn update(&mut self, _: Period) {
        let holds = self.trigger.get() == self.edge.get();
        let force = self.force.get();
        if holds && (!self.held || (force && !self.forced)) {
            self.messages.error(self.text, &[]);
        }
        self.held = holds;
        self.forced = force;
    }
}

#[cfg(test)]
mod tests {
    use super::Message;
    use hal_bench::Bench;

    #[test]
    fn each_time_it_is_due() {
        let mut bench = Bench::new();
        bench.load::<Message>(&["count=2", "messages=first,second {},third"]).unwrap();
        let mut all = Vec::new();
        for (pin, value, more) in [
            ("trigger", true, 1),
            ("trigger", true, 0),
            ("force", true, 1),
            ("force", true, 0),
            ("trigger", false, 0),
            ("force", false, 0),
            ("force", true, 0),
            ("edge", false, 1),
            ("force", false, 0),
            ("force", true, 1),
            ("trigger", true, 0),
            ("trigger", false, 1),
        ] {
            bench.set(&format!("message.1.{pin}"), value);
            bench.run("message.1", 1_000_000);
            let said = bench.said();
            assert_eq!(said.len(), more, "{pin} {value}");
            all.extend(said);
        }
        assert!(all.iter().all(|m| m == "second {}"));
    }

    #[test]
    fn refusals() {
        let mut bench = Bench::new();
        let said = bench.load::<Message>(&["count=2", "messages=one"]).unwrap_err();
        assert_eq!(said, "messages= has no text number 2");
    }
}
