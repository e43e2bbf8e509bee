//! `new_rows`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

use hal_component::{Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, abi::component_flags};

/// Arrays of the new types, sized by personality; parameters that are not there can still be used.
struct NewRows;

impl Component for NewRows {
    const NAME: &'static str = "new_rows";
    const DOC: &'static str = "Arrays of the new types, sized by personality; parameters that are not there can still be used.";
    const FLAGS: u32 = component_flags::PERSONALITY;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let personality = b.personality();
        let mut in_: Vec<In<f64>> = Vec::new();
        let n = personality + 1;
        if n > 4 {
            return Err(Error::new(format!("Pin in-#: Requested size {n} exceeds max size 4")));
        }
        for i in 0..n {
            in_.push(b.item(&format!("in-{i}"), "Pin `in-#`; the C file does not say what it means.", 0.0)?);
        }
        let mut out: Vec<Out<f64>> = Vec::new();
        let n = personality + 1;
        if n > 4 {
            return Err(Error::new(format!("Pin out-#: Requested size {n} exceeds max size 4")));
        }
        for i in 0..n {
            out.push(b.item(&format!("out-{i}"), "Pin `out-#`; the C file does not say what it means.", 0.0)?);
        }
        let mut on: Vec<Out<bool>> = Vec::new();
        for i in 0..3 {
            on.push(b.item(&format!("on-{i:02}"), "Pin `on-##`; the C file does not say what it means.", true)?);
        }
        let mut scale: Vec<ParamRw<u32>> = Vec::new();
        for i in 0..2 {
            scale.push(b.item(&format!("scale-{i}"), "Parameter `scale-#`; the C file does not say what it means.", 3)?);
        }
        let extra: Option<ParamRw<f64>> = if personality > 1 { Some(b.item("extra", "Parameter `extra`; the C file does not say what it means.", 9.0)?) } else { None };
        b.function("", "Arrays of the new types, sized by personality; parameters that are not there can still be used.", NewRowsFunction { in_, out, on, scale, extra })?;
        Ok(())
    }
}

/// Arrays of the new types, sized by personality; parameters that are not there can still be used.
#[derive(Touch)]
struct NewRowsFunction {
    in_: Vec<In<f64>>,
    out: Vec<Out<f64>>,
    on: Vec<Out<bool>>,
    scale: Vec<ParamRw<u32>>,
    extra: Option<ParamRw<f64>>,
}

impl Update for NewRowsFunction {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //     int i;
        //     for (i = 0; i < personality + 1; i++) out_set(i, in(i) * scale(0));
        //     on_set(2, in(0) > 1);
        //     extra_set(extra + 1);
    }
}

hal_component::export!(NewRows);
