//! `told_well`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

use hal_component::{Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update};

/// Texts of every form.
struct ToldWell;

impl Component for ToldWell {
    const NAME: &'static str = "told_well";
    const DOC: &'static str = "Texts of every form.\n\nWith *emphasis*, **strong** words, \\fBold\\fR roff, and `code`.\n\nFirst paragraph.\n\nSecond, with a list:\n\n* one\n* two, with `gain`";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        // The C file made 2 without being asked: scripts say count=2.
        let in_: In<f64> = b.item("in", "A quoted \"text\", with a backslash \\ and a tab in it.", 0.0)?;
        let out: Out<f64> = b.item("out", "Raw: \\fBnothing\\n is an escape.", 0.0)?;
        let ok: Out<bool> = b.item("ok", "Non-ASCII: 20 µm ≤ x, AAé", false)?;
        let gain: ParamRw<f64> = b.item("gain", "Of several lines, with \"quotes\" in it.", 2.0)?;
        b.function("", "Does it.", ToldWellFunction { in_, out, ok, gain })?;
        Ok(())
    }
}

/// Does it.
#[derive(Touch)]
struct ToldWellFunction {
    in_: In<f64>,
    out: Out<f64>,
    ok: Out<bool>,
    gain: ParamRw<f64>,
}

impl Update for ToldWellFunction {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //     out = in * gain;
        //     ok = 1;
    }
}

hal_component::export!(ToldWell);
