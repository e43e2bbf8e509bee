//! `output_buffer`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of bits.
const MAX: i64 = 10;
/// Default number of bits.
const DEFAULT: i64 = 1;

/// Bits that can be switched off.
#[derive(Touch)]
pub(crate) struct OutputBuffer {
    bits: Vec<(In<bool>, Out<bool>)>,
    enable: In<bool>,
    off_level: In<bool>,
}

impl Component for OutputBuffer {
    const NAME: &'static str = "output_buffer";
    const DOC: &'static str = "Passes bits while enabled; otherwise sets the outputs to a \
        level.\n\n\
        `personality=` is how many bits, 1 to 10; 1 without it.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt output_buffer personality=2\n\
        loadrt threads name1=servo period1=1000000\n\
        addf output-buffer.0 servo\n\
        start\n\
        setp output-buffer.0.in-1 1\n\
        run 1ms\n\
        getp output-buffer.0.out-1 # -> FALSE\n\
        setp output-buffer.0.enable 1\n\
        run 1ms\n\
        getp output-buffer.0.out-0 # -> FALSE\n\
        getp output-buffer.0.out-1 # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin in-#", DEFAULT, MAX)?;
        let mut bits = Vec::new();
        for i in 0..n {
            let input = b.item(&format!("in-{i}"), "Bit to pass.", false)?;
            let doc = "The bit while enabled, otherwise `off-level`.";
            bits.push((input, b.item(&format!("out-{i}"), doc, false)?));
        }
        let enable = b.item("enable", "True passes the bits.", false)?;
        let doc = "Level of all outputs while not enabled.";
        let off_level = b.item("off-level", doc, false)?;
        b.function("", "Passes the bits.", Self { bits, enable, off_level })
    }
}

impl Update for OutputBuffer {
    fn update(&mut self, _: Period) {
        let (enabled, off) = (self.enable.get(), self.off_level.get());
        for (input, output) in &self.bits {
            output.set(if enabled { input.get() } else { off });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::OutputBuffer;
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn through_or_off() {
        let rows = replay::<OutputBuffer>(
            "load output_buffer personality=2
             run output-buffer.0
             in output-buffer.0.in-0 output-buffer.0.in-1 output-buffer.0.enable output-buffer.0.off-level
             out output-buffer.0.out-0 output-buffer.0.out-1
             1 0 0 0 | 0 0
             1 0 0 1 | 1 1
             1 0 1 1 | 1 0
             0 1 1 0 | 0 1",
        );
        assert_eq!(rows, 4);
        let refused = Bench::new().load::<OutputBuffer>(&["personality=11"]).unwrap_err();
        assert!(
            refused.starts_with(
                "Pin in-#: Requested size 11 exceeds max size 10: personality= is 1 to "
            )
        );
    }
}
