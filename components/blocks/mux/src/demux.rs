//! `demux`.
use hal_component::{
    Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of outputs, which is also the default.
const MAX: i64 = 32;
/// Number of selector bits.
const BITS: u32 = 5;

/// Demultiplexer to bits.
#[derive(Touch)]
pub(crate) struct Demux {
    bits: Vec<In<bool>>,
    number: In<u32>,
    outputs: Vec<Out<bool>>,
    bargraph: ParamRw<bool>,
}

impl Component for Demux {
    const NAME: &'static str = "demux";
    const DOC: &'static str = "Sets one of up to 32 bits by number, or all bits up to it.\n\n\
        `personality=` is the number of outputs; 32 without it. The selector bits, worth 1 to 16, and \
        `sel-u32` together are the number; the last output also stands for all higher numbers,\n\
         and numbers of 2^31 and more choose none.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt demux personality=4\n\
        loadrt threads name1=servo period1=1000000\n\
        addf demux.0 servo\n\
        start\n\
        setp demux.0.sel-u32 2\n\
        run 1ms\n\
        getp demux.0.out-02 # -> TRUE\n\
        getp demux.0.out-01 # -> FALSE\n\
        setp demux.0.bargraph 1\n\
        run 1ms\n\
        getp demux.0.out-01 # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin out-##", MAX, MAX)?;
        let mut bits = Vec::new();
        for i in 0..BITS {
            let doc = format!("Selector worth {}.", 1 << i);
            bits.push(b.item(&format!("sel-bit-{i:02}"), &doc, false)?);
        }
        let number = b.item("sel-u32", "Selector; added to the bits.", 0)?;
        let mut outputs = Vec::new();
        for i in 0..n {
            outputs.push(b.item(
                &format!("out-{i:02}"),
                "True while this output is selected; see `bargraph`.",
                false,
            )?);
        }
        let bar = "True sets all outputs below the selected one, instead of that one.";
        let bargraph = b.item("bargraph", bar, false)?;
        b.function("", "Chooses.", Self { bits, number, outputs, bargraph })
    }
}

impl Update for Demux {
    fn update(&mut self, _: Period) {
        let bits = self.bits.iter().enumerate();
        let bits = bits.fold(0_u32, |n, (i, bit)| n | u32::from(bit.get()) << i);
        let chosen = self.number.get().wrapping_add(bits);
        let last = self.outputs.len().saturating_sub(1);
        let chosen = usize::try_from(chosen.cast_signed()).ok().map(|n| n.min(last));
        let bar = self.bargraph.get();
        for (i, out) in self.outputs.iter().enumerate() {
            out.set(if bar { chosen.is_some_and(|n| i < n) } else { chosen == Some(i) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Demux;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Demux>(include_str!("../traces/demux.txt")), 182);
    }

    #[test]
    fn no_more_than_32() {
        let refused = Bench::new().load::<Demux>(&["personality=33"]).unwrap_err();
        assert!(refused.starts_with(
            "Pin out-##: Requested size 33 exceeds max size 32: personality= is 1 to "
        ));
    }
}
