//! Realtime. Simulated registers whose bits are pins.

use crate::{Access, Lost};
use core::sync::atomic::{
    AtomicU8, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};
use hal_component::{Builder, Error, In, Io, Out, Touch, Uses};

/// Block of byte registers, and the PCI configuration of a device, in memory.
///
/// Registers behave as plain bytes until pins are added: [`Self::show`] makes written values visible, and
/// [`Self::drive`] lets pins determine the bits that are read. An address outside the block reads as 0xFF, as on an
/// empty bus, and ignores writes.
#[derive(Debug)]
pub struct Simulated {
    prefix: String,
    base: u16,
    bytes: Vec<AtomicU8>,
    shown: Vec<Shown>,
    driven: Vec<Driven>,
    config: Vec<(u8, Io<u32>)>,
    writes: Count,
    reads: Count,
}

/// Counter, and the pin that shows it.
#[derive(Debug)]
struct Count(AtomicU32, Out<u32>);

/// Pins that show the value written to one register.
#[derive(Clone, Debug)]
pub struct Shown {
    offset: u16,
    whole: Out<u32>,
    bits: Vec<(u8, Out<bool>)>,
}

/// Pins that determine the value read from one register.
#[derive(Clone, Debug)]
pub struct Driven {
    offset: u16,
    mask: u8,
    whole: Option<In<u32>>,
    bits: Vec<(u8, In<bool>)>,
}

impl Simulated {
    /// Makes `size` registers from address `base`, all zero; their pins are hidden and named `PREFIX.NAME`. Also makes
    /// `PREFIX.writes` and `PREFIX.reads`, which count register accesses.
    ///
    /// # Errors
    /// Same as [`Builder::item`].
    pub fn new(b: &mut Builder<'_>, prefix: &str, base: u16, size: u16) -> Result<Self, Error> {
        Ok(Self {
            prefix: prefix.to_owned(),
            base,
            bytes: (0..size).map(|_| AtomicU8::new(0)).collect(),
            shown: Vec::new(),
            driven: Vec::new(),
            config: Vec::new(),
            writes: Count::new(b, prefix, "writes")?,
            reads: Count::new(b, prefix, "reads")?,
        })
    }

    /// Makes the pin `NAME`, which shows the register at `offset` as last written, and a pin `NAME-BIT` for each bit of
    /// `mask`. The register's initial value is `reset`.
    ///
    /// # Errors
    /// Same as [`Builder::item`].
    pub fn show(
        &mut self,
        b: &mut Builder<'_>,
        name: &str,
        offset: u16,
        mask: u8,
        reset: u8,
    ) -> Result<(), Error> {
        if let Some(byte) = self.bytes.get(usize::from(offset)) {
            byte.store(reset, Relaxed); // No other thread yet.
        }
        let about = format!("Raw byte in register `{name}`, 0 to 255, as last written");
        let full = format!("{}.{name}", self.prefix);
        let whole = b.simulated(&full, &about, u32::from(reset))?;
        let mut bits = Vec::new();
        for (bit, one) in ones(mask) {
            let about = format!("Raw bit {bit} of register `{name}`, as last written");
            let full = format!("{full}-{bit}");
            bits.push((one, b.simulated(&full, &about, reset & one != 0)?));
        }
        self.shown.push(Shown { offset, whole, bits });
        Ok(())
    }

    /// Makes pins that determine the bits of `mask` in the register at `offset`: `NAME-BIT` for each bit, and `NAME`
    /// for the byte. A bit reads as 1 if either pin sets it.
    ///
    /// # Errors
    /// Same as [`Builder::item`].
    pub fn drive(
        &mut self,
        b: &mut Builder<'_>,
        name: &str,
        offset: u16,
        mask: u8,
    ) -> Result<(), Error> {
        let about = format!(
            "Raw byte that register `{name}` reads as, 0 to 255 (more is ignored), together \
             with its bit pins: a bit is 1 when either says so"
        );
        let full = format!("{}.{name}", self.prefix);
        let whole = b.simulated(&full, &about, 0)?;
        self.drive_bits(b, name, offset, mask)?;
        if let Some(last) = self.driven.last_mut() {
            last.whole = Some(whole);
            last.mask = 0xFF;
        }
        Ok(())
    }

    /// Makes the pins of [`Self::drive`] without the one for the byte: bits outside `mask` read as written.
    ///
    /// # Errors
    /// Same as [`Builder::item`].
    pub fn drive_bits(
        &mut self,
        b: &mut Builder<'_>,
        name: &str,
        offset: u16,
        mask: u8,
    ) -> Result<(), Error> {
        let mut bits = Vec::new();
        for (bit, one) in ones(mask) {
            let about = format!("Raw bit {bit} that register `{name}` reads as");
            let full = format!("{}.{name}-{bit}", self.prefix);
            bits.push((one, b.simulated(&full, &about, false)?));
        }
        self.driven.push(Driven { offset, mask, whole: None, bits });
        Ok(())
    }

    /// Makes the pin `config-RR` for a double word of PCI configuration; double words without a pin read as zero.
    ///
    /// # Errors
    /// Same as [`Builder::item`].
    pub fn config(&mut self, b: &mut Builder<'_>, register: u8, reset: u32) -> Result<(), Error> {
        let register = register & !3;
        let full = format!("{}.config-{register:02x}", self.prefix);
        let about = format!("Double word 0x{register:02X} of the PCI configuration");
        let pin = b.simulated(&full, &about, reset)?;
        self.config.push((register, pin));
        Ok(())
    }

    /// Returns the pins that writing registers sets.
    #[must_use]
    pub fn written(&self) -> (Vec<Shown>, Out<u32>) {
        (self.shown.clone(), self.writes.1)
    }

    /// Returns the pins that reading registers reads and sets.
    #[must_use]
    pub fn read_from(&self) -> (Vec<Driven>, Out<u32>) {
        (self.driven.clone(), self.reads.1)
    }

    fn byte(&self, address: u16) -> Option<(u16, &AtomicU8)> {
        let offset = address.checked_sub(self.base)?;
        Some((offset, self.bytes.get(usize::from(offset))?))
    }

    fn register(&self, register: u8) -> Option<&Io<u32>> {
        // As on the bus, the low two bits of a register's number are not decoded.
        self.config.iter().find(|(r, _)| *r == register & !3).map(|(_, pin)| pin)
    }
}

impl Access for Simulated {
    fn read(&self, address: u16) -> Result<u8, Lost> {
        let Some((offset, byte)) = self.byte(address) else { return Ok(0xFF) };
        self.reads.grow();
        let stored = byte.load(Acquire); // Pairs with `write`.
        let driven = self.driven.iter().filter(|d| d.offset == offset);
        Ok(driven.fold(stored, |value, d| value & !d.mask | d.get()))
    }

    fn write(&self, address: u16, value: u8) -> Result<(), Lost> {
        let Some((offset, byte)) = self.byte(address) else { return Ok(()) };
        byte.store(value, Release); // Pairs with `read`.
        for shown in self.shown.iter().filter(|s| s.offset == offset) {
            shown.set(value);
        }
        self.writes.grow();
        Ok(())
    }

    fn read_config(&self, register: u8) -> Result<u32, Lost> {
        Ok(self.register(register).map_or(0, Io::get))
    }

    fn write_config(&self, register: u8, value: u32) -> Result<(), Lost> {
        if let Some(pin) = self.register(register) {
            pin.set(value);
        }
        Ok(())
    }
}

impl Count {
    fn new(b: &mut Builder<'_>, prefix: &str, name: &str) -> Result<Self, Error> {
        let about = format!("Number of register {name} since the load; wraps at 2^32");
        let full = format!("{prefix}.{name}");
        Ok(Self(AtomicU32::new(0), b.simulated(&full, &about, 0)?))
    }

    fn grow(&self) {
        self.1.set(self.0.fetch_add(1, Relaxed).wrapping_add(1));
    }
}

impl Shown {
    fn set(&self, value: u8) {
        self.whole.set(u32::from(value));
        for (one, pin) in &self.bits {
            pin.set(value & one != 0);
        }
    }
}

impl Driven {
    fn get(&self) -> u8 {
        let [whole, ..] = self.whole.map_or(0, |pin| pin.get()).to_le_bytes();
        let bits = self.bits.iter().filter(|(_, pin)| pin.get());
        bits.fold(whole, |value, (one, _)| value | one)
    }
}

impl Touch for Shown {
    fn touch(&self, uses: &mut Uses) {
        self.whole.touch(uses);
        self.bits.iter().for_each(|(_, pin)| pin.touch(uses));
    }
}

impl Touch for Driven {
    fn touch(&self, uses: &mut Uses) {
        self.whole.touch(uses);
        self.bits.iter().for_each(|(_, pin)| pin.touch(uses));
    }
}

/// Returns each set bit, as number and value.
fn ones(mask: u8) -> impl Iterator<Item = (u8, u8)> {
    (0..8).map(|bit| (bit, 1 << bit)).filter(move |(_, one)| mask & one != 0)
}

#[cfg(test)]
mod tests {
    use super::Simulated;
    use crate::Access;
    use hal_bench::Bench;
    use hal_component::{Builder, Component, Error, In, Out, Period, Touch, Update};

    /// Component that makes one access per cycle: the value read, and the value to write.
    #[derive(Touch)]
    struct Probe {
        #[state]
        file: Simulated,
        address: In<u32>,
        value: In<u32>,
        write: In<bool>,
        config: In<bool>,
        read: Out<u32>,
    }

    impl Update for Probe {
        fn update(&mut self, _: Period) {
            let (address, value) = (self.address.get(), self.value.get());
            let short = u16::try_from(address).unwrap();
            let register = u8::try_from(address & 0xFF).unwrap();
            match (self.write.get(), self.config.get()) {
                (true, true) => self.file.write_config(register, value).unwrap(),
                (true, false) => self.file.write(short, u8::try_from(value).unwrap()).unwrap(),
                (false, true) => self.read.set(self.file.read_config(register).unwrap()),
                (false, false) => self.read.set(u32::from(self.file.read(short).unwrap())),
            }
        }
    }

    impl Component for Probe {
        const NAME: &'static str = "probe";
        const DOC: &'static str = "Reads and writes registers.";
        fn create(b: &mut Builder<'_>) -> Result<(), Error> {
            let mut file = Simulated::new(b, "sim", 0x100, 4)?;
            file.show(b, "out", 1, 0b1000_0001, 0x7E)?;
            file.drive(b, "in", 2, 0b11)?;
            file.show(b, "both", 3, 0, 0)?;
            file.drive_bits(b, "both", 3, 0b1)?;
            file.config(b, 0x95, 0xA0)?;
            let probe = Self {
                file,
                address: b.item("address", "Address.", 0)?,
                value: b.item("value", "What to write.", 0)?,
                write: b.item("write", "Whether to write.", false)?,
                config: b.item("config", "Whether in configuration space.", false)?,
                read: b.item("read", "What was read.", 0)?,
            };
            b.function("", "One access.", probe)
        }
    }

    struct Table(Bench);

    impl Table {
        fn new() -> Self {
            let mut bench = Bench::new();
            bench.load::<Probe>(&[]).unwrap();
            Self(bench)
        }
        fn access(&self, write: Option<u32>, config: bool, address: u32) -> u32 {
            self.0.set("probe.0.address", address);
            self.0.set("probe.0.write", write.is_some());
            self.0.set("probe.0.value", write.unwrap_or(0));
            self.0.set("probe.0.config", config);
            self.0.run("probe.0", 1000);
            self.0.get("probe.0.read")
        }
        fn bits(&self, names: &[&str]) -> Vec<bool> {
            names.iter().map(|n| self.0.get(&format!("probe.0.sim.{n}"))).collect()
        }
        fn whole(&self, name: &str) -> u32 {
            self.0.get(&format!("probe.0.sim.{name}"))
        }
    }

    #[test]
    fn written_bytes_show() {
        let t = Table::new();
        assert_eq!(t.access(None, false, 0x101), 0x7E);
        assert_eq!((t.whole("out"), t.whole("writes")), (0x7E, 0));
        t.access(Some(0x80), false, 0x101);
        assert_eq!((t.whole("out"), t.whole("writes")), (0x80, 1));
        assert_eq!(t.bits(&["out-0", "out-7"]), [false, true]);
        assert_eq!(t.access(None, false, 0x101), 0x80);
        t.access(Some(1), false, 0x101);
        assert_eq!(t.bits(&["out-0", "out-7"]), [true, false]);
        t.access(Some(0x55), false, 0x100);
        assert_eq!((t.whole("out"), t.whole("writes")), (1, 3));
        assert_eq!(t.access(None, false, 0x100), 0x55);
        assert_eq!((t.whole("writes"), t.whole("reads")), (3, 3));
    }

    #[test]
    fn pins_say_what_is_read() {
        let t = Table::new();
        for (bits, byte, read) in [
            ([false, false], 0_u32, 0),
            ([true, false], 0, 1),
            ([false, true], 0x80, 0x82),
            ([true, true], 0x3FF, 0xFF),
        ] {
            t.0.set("probe.0.sim.in-0", bits[0]);
            t.0.set("probe.0.sim.in-1", bits[1]);
            t.0.set("probe.0.sim.in", byte);
            assert_eq!(t.access(None, false, 0x102), read);
        }
        t.access(Some(0xF1), false, 0x103);
        assert_eq!((t.whole("both"), t.access(None, false, 0x103)), (0xF1, 0xF0));
        t.0.set("probe.0.sim.both-0", true);
        assert_eq!(t.access(None, false, 0x103), 0xF1);
    }

    #[test]
    fn outside_the_block_is_nothing() {
        let t = Table::new();
        for address in [0, 0xFF, 0x104, 0xFFFF] {
            t.access(Some(0x12), false, address);
            assert_eq!(t.access(None, false, address), 0xFF, "{address:#x}");
        }
        assert_eq!((t.whole("writes"), t.whole("reads")), (0, 0));
    }

    #[test]
    fn configuration_ignores_the_low_bits() {
        let t = Table::new();
        for register in 0x94..0x98 {
            assert_eq!(t.access(None, true, register), 0xA0);
        }
        t.access(Some(0x0102_0304), true, 0x97);
        assert_eq!((t.whole("config-94"), t.access(None, true, 0x94)), (0x0102_0304, 0x0102_0304));
        t.access(Some(5), true, 0x98);
        assert_eq!((t.access(None, true, 0x98), t.access(None, true, 0x90)), (0, 0));
    }
}
