//! `raster`.
use crate::pixels::{Fault, Program, Reader};
use hal_component::{Component, In, Out, Period, Port, Update};

/// Laser power along a line of pixels.
///
/// A program writes a line to the port before the move, then sets `run` while the head moves along it. The line is
/// text, `OFFSET;BPP;PPU;COUNT;PIXELS`:
///
/// | field | meaning |
/// |---|---|
/// | `OFFSET` | start of the first pixel, in units from the position where `run` rose, a decimal number |
/// | `BPP` | bits per pixel: 4, 8, 12 or 16 |
/// | `PPU` | pixels per unit, not 0; if negative, the line runs toward lower positions |
/// | `COUNT` | number of pixels, 1 to 2147483647 |
/// | `PIXELS` | the pixels without separators, each of `BPP` / 4 hexadecimal digits |
///
/// Pixel value 0 is off, and `output` is then -1. The other values are spaced evenly from 1, which is 0 %, to the
/// highest, which is 100 %. Within a pixel, the output changes linearly from the previous pixel's power to this
/// pixel's. If either of the two is off, the output is this pixel's value for the whole pixel. A program may write
/// pixels while the line runs, as long as each arrives before the head reaches it.
///
/// `state`: 0 waits for a line, 1 reads its header, 2 has read the header, 3 runs, 4 fault. `fault-code`: 0 none, 1
/// invalid offset, 2 invalid bits per pixel, 3 invalid pixels per unit, 4 invalid count, 5 a pixel is not hexadecimal,
/// 6 a pixel is missing, 7 `run` without a line, 8 the position is not finite. A fault turns `output` off (-1) and
/// lasts until `reset` rises, which discards everything in the port.
///
/// LinuxCNC 2.9 has no such component, and that of 2.10 was not at hand: the names, types and initial values of the
/// pins are LinuxCNC's, but the text format of a line and the numbers of states and faults are ours.
///
/// # Example
///
/// ```hal
/// loadrt raster
/// loadrt threads name1=servo period1=1000000
/// addf raster.0 servo
/// start
/// setp raster.0.run 1
/// run 1ms
/// getp raster.0.fault-code # -> 7
/// getp raster.0.output # -> -1
/// setp raster.0.run 0
/// setp raster.0.reset 1
/// run 1ms
/// getp raster.0.fault # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Raster {
    /// Port to which a program writes its lines.
    program: In<Port>,
    /// On a rising edge, stops the line, clears the fault and discards everything in the port.
    reset: In<bool>,
    /// Runs the line while TRUE. On the falling edge, the rest of the line is discarded.
    run: In<bool>,
    /// Position of the head along the line, in units.
    position: In<f64>,
    /// True while a line runs.
    enabled: Out<bool>,
    /// Power: 0 to 100 %; -1 is off.
    #[hal(default = -1.0)]
    output: Out<f64>,
    /// True while there is a fault.
    fault: Out<bool>,
    /// Number of the fault.
    fault_code: Out<i32>,
    /// Number of the state.
    state: Out<i32>,
    /// Start of the first pixel, in units from the position where `run` rose.
    program_offset: Out<f64>,
    /// Bits per pixel.
    bpp: Out<i32>,
    /// Pixels per unit.
    ppu: Out<f64>,
    /// Number of pixels in the line.
    count: Out<i32>,
    /// Position of the head, in units from the position where `run` rose.
    program_position: Out<f64>,
    /// Position of the head in pixels from the start of the first pixel, with a fraction.
    bitmap_position: Out<f64>,
    /// Index of the pixel at the head, from 0; -1 before the first.
    #[hal(default = -1)]
    current_pixel_index: Out<i32>,
    /// Power of the pixel at the head, in percent; -1 is off.
    #[hal(default = -1.0)]
    current_pixel_value: Out<f64>,
    /// Power of the pixel before it, in percent; -1 is off.
    #[hal(default = -1.0)]
    previous_pixel_value: Out<f64>,
    /// Position of the head within the pixel, 0 to 1.
    fraction: Out<f64>,
    #[state]
    was_reset: bool,
    #[state]
    reader: Reader,
    /// Position where `run` rose, while a line runs.
    #[state]
    start: Option<f64>,
}

impl Update for Raster {
    fn update(&mut self, _: Period) {
        if self.reset.get() && !self.was_reset {
            self.program.get().clear();
            self.forget();
            self.fault.set(false);
            self.fault_code.set(0);
        }
        self.was_reset = self.reset.get();
        if self.fault.get() {
            return;
        }
        if let Err(fault) = self.go() {
            self.stop();
            self.fault.set(true);
            self.fault_code.set(fault as i32);
            self.state.set(4);
        }
    }
}

impl Raster {
    fn go(&mut self) -> Result<(), Fault> {
        let read = self.reader.head(self.program.get())?;
        if let Some(Program { offset, bpp, ppu, count }) = read {
            self.program_offset.set(offset);
            self.bpp.set(bpp);
            self.ppu.set(ppu);
            self.count.set(count);
        }
        match (self.run.get(), read.is_some()) {
            (true, true) => self.line(),
            (true, false) => Err(Fault::Without),
            (false, _) if self.start.is_some() => {
                self.program.get().clear();
                self.forget();
                Ok(())
            }
            (false, ready) => {
                self.state.set(if ready { 2 } else { i32::from(self.reader.begun()) });
                Ok(())
            }
        }
    }

    /// Updates the pins for the present position, and reads the pixels up to there.
    fn line(&mut self) -> Result<(), Fault> {
        let now = self.position.get();
        let start = *self.start.get_or_insert(now);
        if !(now - start).is_finite() {
            return Err(Fault::Nowhere);
        }
        self.state.set(3);
        self.enabled.set(true);
        self.program_position.set(now - start);
        let place = (now - start - self.program_offset.get()) * self.ppu.get();
        self.bitmap_position.set(place);
        if place < 0.0 || place.is_nan() {
            self.output.set(-1.0);
            return Ok(());
        }
        if place >= f64::from(self.count.get()) {
            self.fraction.set(0.0);
            self.output.set(-1.0);
            return Ok(());
        }
        while f64::from(self.current_pixel_index.get()) < libm::floor(place) {
            let pixel = self.reader.pixel(self.program.get())?;
            self.previous_pixel_value.set(self.current_pixel_value.get());
            self.current_pixel_value.set(pixel);
            self.current_pixel_index.set(self.current_pixel_index.get().wrapping_add(1));
        }
        // Pixels that were passed are not read again.
        let within = (place - f64::from(self.current_pixel_index.get())).max(0.0);
        self.fraction.set(within);
        let (from, to) = (self.previous_pixel_value.get(), self.current_pixel_value.get());
        let off = from < 0.0 || to < 0.0;
        self.output.set(if off { to } else { from + (to - from) * within });
        Ok(())
    }

    fn stop(&mut self) {
        self.start = None;
        self.reader = Reader::default();
        self.enabled.set(false);
        self.output.set(-1.0);
    }

    /// Returns to waiting for a line.
    fn forget(&mut self) {
        self.stop();
        self.state.set(0);
        self.program_offset.set(0.0);
        self.bpp.set(0);
        self.ppu.set(0.0);
        self.count.set(0);
        self.program_position.set(0.0);
        self.bitmap_position.set(0.0);
        self.current_pixel_index.set(-1);
        self.current_pixel_value.set(-1.0);
        self.previous_pixel_value.set(-1.0);
        self.fraction.set(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::Raster;
    use hal_bench::Bench;
    use hal_component::Port;

    fn with(line: &str) -> Bench {
        let mut b = Bench::new();
        b.load::<Raster>(&[]).unwrap();
        b.port("raster.0.program", 256);
        give(&b, line);
        b.run("raster.0", 1_000_000);
        b
    }

    fn give(b: &Bench, text: &str) {
        assert!(b.get::<Port>("raster.0.program").write(text.as_bytes()));
    }

    /// Runs the component at a position. Returns its power.
    fn at(b: &Bench, position: f64) -> f64 {
        b.set("raster.0.position", position);
        b.run("raster.0", 1_000_000);
        b.get("raster.0.output")
    }

    fn code(b: &Bench) -> i32 {
        assert_eq!(b.get::<bool>("raster.0.fault"), b.get::<i32>("raster.0.fault-code") != 0);
        b.get("raster.0.fault-code")
    }

    #[test]
    fn a_line() {
        let b = with("0.5;4;2;4;1F08");
        assert_eq!(b.get::<i32>("raster.0.state"), 2);
        assert_eq!(b.get::<f64>("raster.0.program-offset"), 0.5);
        assert_eq!((b.get::<i32>("raster.0.bpp"), b.get::<i32>("raster.0.count")), (4, 4));
        b.set("raster.0.run", true);
        // The start position does not matter; before the first pixel the output is off.
        assert_eq!(at(&b, 100.0), -1.0);
        assert!(b.get::<bool>("raster.0.enabled"));
        assert_eq!(at(&b, 100.4), -1.0);
        assert_eq!(b.get::<i32>("raster.0.current-pixel-index"), -1);
        // No ramp from off: the first pixel's own value, 0 %.
        assert_eq!(at(&b, 100.5), 0.0);
        assert_eq!(at(&b, 100.75), 0.0);
        // A ramp from 0 to 100 % within the second pixel.
        assert_eq!(at(&b, 101.125), 25.0);
        assert_eq!(b.get::<f64>("raster.0.bitmap-position"), 1.25);
        assert_eq!(b.get::<f64>("raster.0.fraction"), 0.25);
        assert_eq!(b.get::<f64>("raster.0.program-position"), 1.125);
        // A short way back: passed pixels are not read again.
        assert_eq!(at(&b, 100.9), 0.0);
        // The third pixel is off, so the fourth has no ramp.
        assert_eq!(at(&b, 101.75), -1.0);
        assert_eq!(at(&b, 102.25), 50.0);
        assert_eq!(b.get::<i32>("raster.0.current-pixel-index"), 3);
        // Past the last pixel.
        assert_eq!(at(&b, 102.5), -1.0);
        b.set("raster.0.run", false);
        b.run("raster.0", 1_000_000);
        assert_eq!((b.get::<i32>("raster.0.state"), code(&b)), (0, 0));
        assert!(!b.get::<bool>("raster.0.enabled"));
        // The next line: toward lower positions, 8 bits per pixel.
        give(&b, "0;8;-1;1;80");
        b.run("raster.0", 1_000_000);
        b.set("raster.0.run", true);
        at(&b, 7.0);
        assert_eq!(at(&b, 6.5), f64::from(0x7F) * 100.0 / 254.0);
    }

    /// The header arrives in pieces, and the pixels while the line runs.
    #[test]
    fn in_pieces() {
        let b = with("-1;");
        assert_eq!(b.get::<i32>("raster.0.state"), 1);
        for part in ["1", "2", ";1;", "2", ";"] {
            give(&b, part);
            b.run("raster.0", 1_000_000);
        }
        assert_eq!(b.get::<i32>("raster.0.state"), 2);
        assert_eq!(b.get::<i32>("raster.0.bpp"), 12);
        give(&b, "FFF");
        b.set("raster.0.run", true);
        at(&b, 0.0);
        assert_eq!(code(&b), 6, "the first pixel was passed, the second is missing");
    }

    #[test]
    fn faults() {
        for (line, fault) in [
            ("x;8;1;1;00", 1),
            ("nan;8;1;1;00", 1),
            ("1e999;8;1;1;00", 1),
            ("00000000000000000000000000000000000;", 1),
            ("0;7;1;1;00", 2),
            ("0;20;1;1;00", 2),
            ("0;8;0;1;00", 3),
            ("0;8;inf;1;00", 3),
            ("0;8;1;0;00", 4),
            ("0;8;1;99999999999;00", 4),
            ("0;8;1;1.5;00", 4),
        ] {
            let b = with(line);
            assert_eq!(code(&b), fault, "{line}");
            assert_eq!(b.get::<i32>("raster.0.state"), 4);
        }
        for (line, position, fault) in [
            ("0;8;1;2;0G", 0.5, 5),
            ("0;8;1;2;00", 1.5, 6),
            ("0;8;1;2;00", f64::NAN, 8),
            ("", 0.0, 7),
        ] {
            let b = with(line);
            b.set("raster.0.run", true);
            at(&b, 0.0);
            assert_eq!(at(&b, position), -1.0);
            assert_eq!(code(&b), fault, "{line}");
            assert!(!b.get::<bool>("raster.0.enabled"));
            // Only a rising edge of reset clears the fault.
            b.set("raster.0.run", false);
            at(&b, 0.0);
            assert_eq!(code(&b), fault);
            b.set("raster.0.reset", true);
            at(&b, 0.0);
            assert_eq!((code(&b), b.get::<i32>("raster.0.state")), (0, 0));
            assert_eq!(b.get::<Port>("raster.0.program").readable(), 0);
            give(&b, "2;16;1;1;0001");
            at(&b, 0.0);
            assert_eq!(b.get::<i32>("raster.0.state"), 2);
        }
    }

    /// No port connected.
    #[test]
    fn no_queue() {
        let mut b = Bench::new();
        b.load::<Raster>(&["names=x"]).unwrap();
        b.run("x", 1_000_000);
        assert_eq!((b.get::<i32>("x.state"), b.get::<f64>("x.output")), (0, -1.0));
    }
}
