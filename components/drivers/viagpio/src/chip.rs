//! Realtime. Registers of the VX900 that hold the lines.

use port::{Access, Lost};

/// Vendor and device ID of the VX900's bus control and power management, from the first double word of its
/// configuration.
pub(crate) const IDENTITY: u32 = 0x8410_1106;

/// Configuration registers: the base of the power management registers, and the double words that hold the enable bits
/// in `Rx80`, `Rx95` and `Rx9B`.
pub(crate) const BASE: u8 = 0x88;
pub(crate) const RX80: u8 = 0x80;
pub(crate) const RX95: u8 = 0x94;
pub(crate) const RX9B: u8 = 0x98;

/// Configuration bits that make lines outputs: register, bits to clear, bits to set.
const ENABLES: [(u8, u32, u32); 3] = [
    (RX9B, 0, 0x0100_0000), // Rx9B[0] = 1: GPO12.
    (RX95, 0, 0x0000_0C00), // Rx95[3:2] = 11: GPIO1.
    (RX80, 0x0000_0040, 0), // Rx80[6] = 0: GPIO12.
];

/// The block of power management registers is aligned to its size. The lower bits of the base register are flags.
const BLOCK: u16 = 0xFF80;

/// Input registers, as offsets from the base.
pub(crate) const INPUTS: [u16; 2] = [0x48, 0x49];
/// Output registers, as offsets from the base.
pub(crate) const OUTPUTS: [u16; 3] = [0x4D, 0x4E, 0x4F];
/// Bits of the output registers that are lines.
pub(crate) const LINES: [u8; 3] = [0x10, 0x90, 0x04];

/// Reason why the chip cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// There is no PCI device at its location.
    NoDevice,
    /// The user may not read or write its configuration.
    Forbidden,
    /// Another chip is there.
    Other(u32),
    /// The firmware assigned no address to the registers.
    NoBase,
    /// The registers cannot be accessed.
    Lost(Lost),
}

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoDevice => {
                write!(
                    f,
                    "there is no PCI device 00:11.0: this driver is for boards with a VIA VX900"
                )
            }
            Self::Forbidden => {
                write!(f, "PCI device 00:11.0 may not be configured: run as root")
            }
            Self::Other(identity) => write!(
                f,
                "PCI device 00:11.0 is {:04x}:{:04x}, not the VIA VX900 (1106:8410); nothing was \
                 written to it",
                identity & 0xFFFF,
                identity >> 16
            ),
            Self::NoBase => write!(
                f,
                "the firmware gave the power management registers no address: look for ACPI in \
                 the board's setup"
            ),
            Self::Lost(why) => write!(f, "{why}: run as root, who may use I/O ports"),
        }?;
        write!(f, "; or run with --simulate")
    }
}

impl From<Lost> for Refused {
    fn from(why: Lost) -> Self {
        Self::Lost(why)
    }
}

/// Chip with enabled lines.
#[derive(Debug)]
pub(crate) struct Chip {
    base: u16,
    /// Initial values of the output register bits that are not lines.
    rest: [u8; 3],
}

impl Chip {
    /// Checks that this is the right chip, then reads the address and contents of its registers. Writes only then, and
    /// only the enable bits that are not set yet.
    pub(crate) fn bring_up(access: &dyn Access) -> Result<Self, Refused> {
        let identity = access.read_config(0)?;
        if identity != IDENTITY {
            return Err(Refused::Other(identity));
        }
        let [low, high, ..] = access.read_config(BASE)?.to_le_bytes();
        let base = u16::from_le_bytes([low, high]) & BLOCK;
        if base == 0 {
            return Err(Refused::NoBase);
        }
        let mut rest = [0; 3];
        for ((rest, register), lines) in rest.iter_mut().zip(OUTPUTS).zip(LINES) {
            *rest = access.read(base | register)? & !lines;
        }
        for (register, clear, set) in ENABLES {
            let found = access.read_config(register)?;
            let wanted = found & !clear | set;
            if wanted != found {
                access.write_config(register, wanted)?;
            }
        }
        Ok(Self { base, rest })
    }

    /// Reads the input registers, once each.
    pub(crate) fn read(&self, access: &dyn Access) -> Result<[u8; 2], Lost> {
        let [low, high] = INPUTS.map(|register| access.read(self.base | register));
        Ok([low?, high?])
    }

    /// Writes the levels of the lines to the output registers: one write each, and no read.
    pub(crate) fn write(&self, access: &dyn Access, levels: [u8; 3]) -> Result<(), Lost> {
        let mut done = Ok(());
        for ((register, rest), levels) in OUTPUTS.into_iter().zip(self.rest).zip(levels) {
            done = done.and(access.write(self.base | register, rest | levels));
        }
        done
    }
}

#[cfg(test)]
mod tests {
    use super::{Chip, Refused};
    use port::{Access, Lost};
    use std::sync::Mutex;

    /// Simulated chip whose registers all hold `byte`; logs every access.
    struct Log {
        byte: u8,
        enabled: bool,
        identity: u32,
        done: Mutex<Vec<String>>,
    }

    impl Log {
        fn new(byte: u8, enabled: bool, identity: u32) -> Self {
            Self { byte, enabled, identity, done: Mutex::default() }
        }
        fn note(&self, text: String) {
            self.done.lock().unwrap().push(text);
        }
        fn taken(&self) -> Vec<String> {
            core::mem::take(&mut *self.done.lock().unwrap())
        }
    }

    impl Access for Log {
        fn read(&self, address: u16) -> Result<u8, Lost> {
            self.note(format!("{address:x}?"));
            Ok(self.byte)
        }
        fn write(&self, address: u16, value: u8) -> Result<(), Lost> {
            self.note(format!("{address:x}={value:02x}"));
            Ok(())
        }
        fn read_config(&self, register: u8) -> Result<u32, Lost> {
            self.note(format!("c{register:02x}?"));
            Ok(match (register, self.enabled) {
                (0, _) => self.identity,
                (0x88, _) => 0x0801,
                (0x94, true) => 0x0000_0C00,
                (0x98, true) => 0x0100_0000,
                (0x80, false) => 0x0000_0040,
                _ => 0,
            })
        }
        fn write_config(&self, register: u8, value: u32) -> Result<(), Lost> {
            self.note(format!("c{register:02x}={value:08x}"));
            Ok(())
        }
    }

    #[test]
    fn everything_is_looked_at_before_anything_is_written() {
        for (enabled, byte) in [(false, 0), (true, 0), (false, 0xFF)] {
            let log = Log::new(byte, enabled, super::IDENTITY);
            let chip = Chip::bring_up(&log).unwrap();
            let looks = ["c00?", "c88?", "84d?", "84e?", "84f?"];
            let enables: &[&str] = if enabled {
                &["c98?", "c94?", "c80?"]
            } else {
                &["c98?", "c98=01000000", "c94?", "c94=00000c00", "c80?", "c80=00000000"]
            };
            assert_eq!(log.taken(), [&looks[..], enables].concat());
            // Lines that the firmware left high are set by the driver; the neighbouring bits keep their values.
            chip.write(&log, [0; 3]).unwrap();
            let rest = if byte == 0 { ["00"; 3] } else { ["ef", "6f", "fb"] };
            let [a, b, c] = rest;
            assert_eq!(log.taken(), [format!("84d={a}"), format!("84e={b}"), format!("84f={c}")]);
            assert_eq!(chip.read(&log), Ok([byte; 2]));
            assert_eq!(log.taken(), ["848?", "849?"]);
        }
    }

    #[test]
    fn another_chip_is_asked_for_its_name_only() {
        let log = Log::new(0, false, 0x8409_1106);
        assert_eq!(Chip::bring_up(&log).unwrap_err(), Refused::Other(0x8409_1106));
        assert_eq!(log.taken(), ["c00?"]);
    }
}
