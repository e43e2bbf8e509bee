//! `two_ways`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

use hal_component::{Builder, Component, Error, In, Out, Period, Touch, Update};

/// Two functions, and what one hands to the other.
struct TwoWays;

impl Component for TwoWays {
    const NAME: &'static str = "two_ways";
    const DOC: &'static str = "Two functions, and what one hands to the other.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let raw: In<f64> = b.item("raw", "Pin `raw`; the C file does not say what it means.", 0.0)?;
        let shown: Out<f64> = b.item("shown", "Pin `shown`; the C file does not say what it means.", 0.0)?;
        b.function("read", "Takes the input.", Read { raw, held: 0.0 })?;
        b.function("write-out", "Gives it out.", WriteOut { shown })?;
        Ok(())
    }
}

/// Takes the input.
#[expect(dead_code, reason = "the C text is still to be translated")]
#[derive(Touch)]
struct Read {
    raw: In<f64>,
    #[state]
    held: f64,
}

impl Update for Read {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //      held = raw;
        //
        // What another function needs of this one's state goes through `Builder::shared`.
    }
}

/// Gives it out.
#[derive(Touch)]
struct WriteOut {
    shown: Out<f64>,
}

impl Update for WriteOut {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //      shown = held;
    }
}

hal_component::export!(TwoWays);
