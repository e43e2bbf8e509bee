//! `boom`.
use hal_component::{Builder, Component, Error, In, Io, Out, ParamRw, Period, Touch, Update};

/// A driver that panics on request.
#[derive(Debug)]
pub(crate) struct Boom;

#[derive(Debug, Touch)]
struct Drive {
    go: In<bool>,
    how: ParamRw<u32>,
    line: Io<bool>,
    cycles: Out<u32>,
    #[state]
    _dies: Dies,
}

/// Payload of a panic that panics again when it is dropped.
struct Bomb;

impl Drop for Bomb {
    fn drop(&mut self) {
        panic!("dropped");
    }
}

/// Panics when it is dropped, if requested.
#[derive(Debug)]
struct Dies(In<bool>);

impl Drop for Dies {
    fn drop(&mut self) {
        assert!(!self.0.get(), "told to panic when dropped");
    }
}

impl Component for Boom {
    const NAME: &'static str = "boom";
    const DOC: &'static str = "A driver that panics when it is told to.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let line: Io<bool> = b.item("line", "The line it drives; safe is false.", false)?;
        let stops: Io<u32> = b.item("stops", "How often its stop action ran.", 0)?;
        let bad_stop: In<bool> = b.item("bad-stop", "Panics in its stop action.", false)?;
        let drive = Drive {
            go: b.item("go", "Panics in the next cycle.", false)?,
            how: b.item("how", "How: 0 text, 1 formatted, 2 no text, 3 worse, 4 long.", 0)?,
            line,
            cycles: b.item("cycles", "Cycles begun.", 0)?,
            _dies: Dies(b.item("bad-drop", "Panics when it is unloaded.", false)?),
        };
        b.on_stop(move || {
            stops.set(stops.get().wrapping_add(1));
            line.set(false);
            assert!(!bad_stop.get(), "told to panic when stopped");
        })?;
        b.function("", "Drives its line.", drive)
    }
}

impl Update for Drive {
    fn update(&mut self, _: Period) {
        self.cycles.set(self.cycles.get().wrapping_add(1));
        self.line.set(true);
        if self.go.get() {
            match self.how.get() {
                0 => panic!("told to"),
                1 => panic!("told to, in cycle {}", self.cycles.get()),
                2 => std::panic::panic_any(self.cycles.get()),
                3 => std::panic::panic_any(Bomb),
                _ => panic!("oh {}", "täterätä ".repeat(100)),
            }
        }
    }
}
