//! `doomed`.
use hal_component::{
    Arg, Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update,
    abi::{ArgSpec, component_flags, ty},
};

/// Declares one of everything, then fails to load.
#[derive(Debug)]
pub(crate) struct Doomed;

#[derive(Debug, Touch)]
struct Copy {
    from: In<f64>,
    to: Out<f64>,
}

impl Component for Doomed {
    const NAME: &'static str = "doomed";
    const DOC: &'static str = "Declares one of everything, then fails to load, as it is told to.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::text(
        "by",
        "What goes wrong: panic, error, mute, open, open-panic, or what is declared twice: pin, \
         param, funct, thread, command, stream; long: a name that is too long; none: nothing.",
    )
    .or("none")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let by = b.arg_text("by").unwrap_or_default();
        let pin: In<f64> = b.item("doomed.in", "One of everything: a pin.", 0.0)?;
        let _: ParamRw<u32> = b.item("doomed.param", "A parameter.", 0)?;
        let copy = Copy { from: pin, to: b.item("doomed.out", "Another pin.", 0.0)? };
        b.function("doomed.copy", "A function.", copy)?;
        let idle = Copy { from: pin, to: b.item("doomed.third", "A third pin.", 0.0)? };
        b.task("doomed.task", "A task.", 1_000_000, idle)?;
        b.command("doomed.say", "A command.", &[], |call| {
            call.reply("said");
            Ok(())
        })?;
        let _ring = b.stream_out("doomed.ring", 4, &[ty::FLOAT])?;
        b.on_stop(|| {})?;
        b.thread("doomed-thread", 1_000_000)?;
        let opens = by.starts_with("open");
        let panics = by.ends_with("panic");
        b.on_open(move |_| match (opens, panics) {
            (true, true) => panic!("told to panic when opened"),
            (true, false) => Err(Error::new("the device is not there")),
            (false, _) => Ok(()),
        })?;
        match by.as_str() {
            "panic" => panic!("told to panic in create"),
            "error" => Err(Error::new("cannot be, and says why")),
            "pin" => {
                let _: In<f64> = b.item("doomed.in", "", 0.0)?;
                Ok(())
            }
            _ => twice(b, &by),
        }
    }
}

/// Declares something that is there already.
fn twice(b: &mut Builder<'_>, by: &str) -> Result<(), Error> {
    let again = |b: &mut Builder<'_>, name: &str| {
        let pin: In<f64> = b.item("doomed.again-in", "", 0.0)?;
        let to = b.item("doomed.again-out", "", 0.0)?;
        b.function(name, "", Copy { from: pin, to })
    };
    match by {
        "param" => {
            let _: ParamRw<u32> = b.item("doomed.param", "", 0)?;
            Ok(())
        }
        "funct" => again(b, "doomed.copy"),
        "thread" => b.thread("doomed-thread", 1_000_000),
        "command" => b.command("doomed.say", "", &[], |_| Ok(())),
        "stream" => b.stream_out("doomed.ring", 4, &[ty::FLOAT]).map(drop),
        "long" => again(b, &"x".repeat(56)),
        _ => Ok(()),
    }
}

impl Update for Copy {
    fn update(&mut self, _: Period) {
        self.to.set(self.from.get());
    }
}
