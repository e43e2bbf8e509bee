//! `gated`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

use hal_component::{Builder, Component, Error, In, Out, ParamRo, ParamRw, Period, Touch, Update, abi::component_flags};

/// Pins and parameters that only some instances have.
struct Gated;

impl Component for Gated {
    const NAME: &'static str = "gated";
    const DOC: &'static str = "Pins and parameters that only some instances have.";
    const FLAGS: u32 = component_flags::PERSONALITY;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let personality = b.personality();
        let in_: In<f64> = b.item("in", "Pin `in`; the C file does not say what it means.", 0.0)?;
        let out: Out<f64> = b.item("out", "Pin `out`; the C file does not say what it means.", 0.0)?;
        let offset: Option<In<f64>> = if (personality & 1) != 0 { Some(b.item("offset", "Added.", 10.0)?) } else { None };
        let gain: Option<ParamRw<f64>> = if (personality & 2) != 0 { Some(b.item("gain", "Parameter `gain`; the C file does not say what it means.", 2.0)?) } else { None };
        let mut seen: Vec<ParamRo<i32>> = Vec::new();
        if (personality & 4) != 0 {
            for i in 0..2 {
                seen.push(b.item(&format!("seen-{i}"), "Parameter `seen-#`; the C file does not say what it means.", 7)?);
            }
        }
        b.function("", "Pins and parameters that only some instances have.", GatedFunction { in_, out, offset, gain, seen })?;
        Ok(())
    }
}

/// Pins and parameters that only some instances have.
#[derive(Touch)]
struct GatedFunction {
    in_: In<f64>,
    out: Out<f64>,
    offset: Option<In<f64>>,
    gain: Option<ParamRw<f64>>,
    seen: Vec<ParamRo<i32>>,
}

impl Update for GatedFunction {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //     double v = in;
        //     if (personality & 2) v *= gain;
        //     if (personality & 1) v += offset_;
        //     if (personality & 4) seen(1) = (int)v;
        //     out = v;
    }
}

hal_component::export!(Gated);
