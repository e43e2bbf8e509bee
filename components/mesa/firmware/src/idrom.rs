//! Identification of a firmware.

/// Identification of a firmware: sixteen registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identification {
    /// Layout: 2 or 3.
    pub layout: u32,
    /// Bytes from the identification to the first module descriptor.
    pub modules: u32,
    /// Bytes from the identification to the first pin descriptor.
    pub pins: u32,
    /// Name of the board, such as `MESA7I92`.
    pub board: [u8; 8],
    /// Size of the chip, in the maker's units.
    pub chip_size: u32,
    /// Legs of the chip.
    pub chip_pins: u32,
    /// Number of ports of I/O pins.
    pub ports: u32,
    /// Number of I/O pins.
    pub width: u32,
    /// I/O pins of a port, at most 32.
    pub port_width: u32,
    /// Slower clock of the modules, in hertz.
    pub clock_low: u32,
    /// Faster clock of the modules, in hertz.
    pub clock_high: u32,
    /// Bytes from an instance's register to that of the next instance, in two sizes.
    pub instance_strides: [u32; 2],
    /// Bytes from a register of an instance to its next register, in two sizes.
    pub register_strides: [u32; 2],
}

/// Error of an identification that cannot be one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadIdentification {
    /// The layout is neither 2 nor 3.
    Layout(u32),
    /// A port has no pins, or more than a register has bits.
    PortWidth(u32),
    /// The pins are not those of the ports.
    Width {
        /// Number of I/O pins.
        pins: u32,
        /// Number of ports.
        ports: u32,
        /// I/O pins of a port.
        port_width: u32,
    },
    /// A clock below 1 MHz.
    Clock(u32),
    /// More I/O pins than [`crate::MAX_PINS`].
    TooManyPins(u32),
    /// A table that begins within the identification or behind the last register.
    Offset(u32),
}

impl core::fmt::Display for BadIdentification {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Layout(layout) => {
                write!(f, "its identification has layout {layout}, where 2 and 3 are known")
            }
            Self::PortWidth(width) => {
                write!(f, "its ports have {width} pins each, where 1 to 32 are possible")
            }
            Self::Width { pins, ports, port_width } => {
                write!(f, "it has {pins} pins in {ports} ports of {port_width}")
            }
            Self::Clock(hz) => {
                write!(f, "it has a clock of {hz} Hz, where at least 1 MHz is known")
            }
            Self::TooManyPins(pins) => {
                write!(f, "it has {pins} I/O pins, where at most {} are known", crate::MAX_PINS)
            }
            Self::Offset(at) => {
                write!(f, "a table of its identification is at {at:#x}, where no table can be")
            }
        }
    }
}

impl core::error::Error for BadIdentification {}

impl Identification {
    /// Number of registers.
    pub const REGISTERS: usize = 16;

    /// Reads an identification from its registers.
    ///
    /// # Errors
    /// No firmware has such an identification.
    pub fn parse(words: &[u32; Self::REGISTERS]) -> Result<Self, BadIdentification> {
        let &[
            layout,
            modules,
            pins,
            name_low,
            name_high,
            chip_size,
            chip_pins,
            ports,
            width,
            port_width,
            clock_low,
            clock_high,
            instance_0,
            instance_1,
            register_0,
            register_1,
        ] = words;
        let ([a, b, c, d], [e, g, h, i]) = (name_low.to_le_bytes(), name_high.to_le_bytes());
        let it = Self {
            layout,
            modules,
            pins,
            board: [a, b, c, d, e, g, h, i],
            chip_size,
            chip_pins,
            ports,
            width,
            port_width,
            clock_low,
            clock_high,
            instance_strides: [instance_0, instance_1],
            register_strides: [register_0, register_1],
        };
        it.check()?;
        Ok(it)
    }

    fn check(&self) -> Result<(), BadIdentification> {
        if !(2..=3).contains(&self.layout) {
            return Err(BadIdentification::Layout(self.layout));
        }
        if !(1..=32).contains(&self.port_width) {
            return Err(BadIdentification::PortWidth(self.port_width));
        }
        if self.width as usize > crate::MAX_PINS {
            return Err(BadIdentification::TooManyPins(self.width));
        }
        if self.ports.checked_mul(self.port_width) != Some(self.width) {
            let (pins, ports, port_width) = (self.width, self.ports, self.port_width);
            return Err(BadIdentification::Width { pins, ports, port_width });
        }
        if let Some(hz) = [self.clock_low, self.clock_high].into_iter().find(|hz| *hz < 1_000_000) {
            return Err(BadIdentification::Clock(hz));
        }
        let is_table = |at: &u32| (0x40..0x8000).contains(at) && at.is_multiple_of(4);
        match [self.modules, self.pins].into_iter().find(|at| !is_table(at)) {
            Some(at) => Err(BadIdentification::Offset(at)),
            None => Ok(()),
        }
    }

    /// Returns the registers.
    #[must_use]
    pub fn to_words(&self) -> [u32; Self::REGISTERS] {
        let [a, b, c, d, e, g, h, i] = self.board;
        let [instance_0, instance_1] = self.instance_strides;
        let [register_0, register_1] = self.register_strides;
        [
            self.layout,
            self.modules,
            self.pins,
            u32::from_le_bytes([a, b, c, d]),
            u32::from_le_bytes([e, g, h, i]),
            self.chip_size,
            self.chip_pins,
            self.ports,
            self.width,
            self.port_width,
            self.clock_low,
            self.clock_high,
            instance_0,
            instance_1,
            register_0,
            register_1,
        ]
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Identification of a card.
    pub(crate) const GOOD: Identification = Identification {
        layout: 3,
        modules: 0x40,
        pins: 0x200,
        board: *b"MESA7I92",
        chip_size: 9,
        chip_pins: 144,
        ports: 2,
        width: 34,
        port_width: 17,
        clock_low: 100_000_000,
        clock_high: 200_000_000,
        instance_strides: [4, 64],
        register_strides: [256, 4],
    };

    #[test]
    fn an_identification_is_its_registers() {
        assert_eq!(Identification::parse(&GOOD.to_words()), Ok(GOOD));
    }

    #[test]
    fn what_no_firmware_says_is_refused() {
        let width = BadIdentification::Width { pins: 35, ports: 2, port_width: 17 };
        let rows = [
            (0, 4, BadIdentification::Layout(4)),
            (1, 0x3C, BadIdentification::Offset(0x3C)),
            (2, 0x8000, BadIdentification::Offset(0x8000)),
            (2, 0x202, BadIdentification::Offset(0x202)),
            (7, u32::MAX, BadIdentification::Width { pins: 34, ports: u32::MAX, port_width: 17 }),
            (8, 35, width),
            (8, 145, BadIdentification::TooManyPins(145)),
            (9, 0, BadIdentification::PortWidth(0)),
            (9, 33, BadIdentification::PortWidth(33)),
            (10, 0, BadIdentification::Clock(0)),
            (11, 999_999, BadIdentification::Clock(999_999)),
        ];
        for (at, value, fault) in rows {
            let mut words = GOOD.to_words();
            words[at] = value;
            assert_eq!(Identification::parse(&words), Err(fault), "{at} {value}");
        }
    }
}
