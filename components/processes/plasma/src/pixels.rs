//! Realtime. Parser of the pixel line that `raster` reads from its port.

use hal_component::Port;

/// Maximum number of bytes in a field of the header.
const MAX_LEN: usize = 32;

/// Faults of a line; the numbers are the values of `fault-code`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fault {
    Offset = 1,
    Bits = 2,
    PerUnit = 3,
    Count = 4,
    Pixel = 5,
    Missing = 6,
    Without = 7,
    Nowhere = 8,
}

/// Header of a line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Program {
    /// Position of the start of the first pixel, in units.
    pub(crate) offset: f64,
    /// Bits per pixel.
    pub(crate) bpp: i32,
    /// Pixels per unit.
    pub(crate) ppu: f64,
    /// Number of pixels.
    pub(crate) count: i32,
}

/// Parser state of one line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reader {
    program: Program,
    /// Number of header fields that are complete.
    fields: u8,
    text: [u8; MAX_LEN],
    len: usize,
}

impl Reader {
    /// Returns whether some of the header has been read.
    pub(crate) const fn begun(&self) -> bool {
        self.fields > 0 || self.len > 0
    }

    /// Continues to read the header. Returns the header once it is complete, and `None` while bytes are missing.
    pub(crate) fn head(&mut self, port: Port) -> Result<Option<Program>, Fault> {
        while self.fields < 4 {
            let mut byte = [0];
            if !port.read(&mut byte) {
                return Ok(None);
            }
            let [byte] = byte;
            if byte == b';' {
                self.field()?;
                self.fields += 1;
                self.len = 0;
            } else if let Some(place) = self.text.get_mut(self.len) {
                *place = byte;
                self.len += 1;
            } else {
                return Err(self.wrong());
            }
        }
        Ok(Some(self.program))
    }

    /// Returns the fault to report if the present field is invalid.
    const fn wrong(&self) -> Fault {
        match self.fields {
            0 => Fault::Offset,
            1 => Fault::Bits,
            2 => Fault::PerUnit,
            _ => Fault::Count,
        }
    }

    fn field(&mut self) -> Result<(), Fault> {
        let text = self.text.get(..self.len).unwrap_or_default();
        let text = core::str::from_utf8(text).map_err(|_| self.wrong())?;
        let number = || text.parse::<f64>().ok().filter(|n| n.is_finite());
        let whole = || text.parse::<i32>().ok();
        let read = match self.fields {
            0 => number().map(|n| self.program.offset = n),
            1 => whole().filter(|n| matches!(n, 4 | 8 | 12 | 16)).map(|n| self.program.bpp = n),
            2 => number().filter(|n| *n != 0.0).map(|n| self.program.ppu = n),
            _ => whole().filter(|n| *n >= 1).map(|n| self.program.count = n),
        };
        read.ok_or(self.wrong())
    }

    /// Reads the next pixel. Returns its power in percent, or -1 for off.
    pub(crate) fn pixel(&self, port: Port) -> Result<f64, Fault> {
        let mut value = 0_u32;
        for _ in 0..self.program.bpp / 4 {
            let mut byte = [0];
            if !port.read(&mut byte) {
                return Err(Fault::Missing);
            }
            let [byte] = byte;
            let digit = char::from(byte).to_digit(16).ok_or(Fault::Pixel)?;
            value = value << 4 | digit;
        }
        let highest = (1_u32 << self.program.bpp) - 1;
        if value == 0 {
            return Ok(-1.0);
        }
        Ok(f64::from(value - 1) * 100.0 / f64::from(highest - 1))
    }
}
