//! Kinds of modules.

/// Kind of a module, by its number in descriptors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Tag {
    /// Interrupt of the host.
    Irq = 1,
    /// Watchdog, which makes all I/O pins inputs.
    Watchdog = 2,
    /// Ports of I/O pins.
    IoPort = 3,
    /// Quadrature counter.
    Encoder = 4,
    /// Step generator.
    StepGenerator = 5,
    /// Pulse-width modulation.
    Pwm = 6,
    /// SPI.
    Spi = 7,
    /// Absolute encoder with a synchronous serial interface.
    Ssi = 8,
    /// Transmitter of bytes.
    UartTransmitter = 9,
    /// Receiver of bytes.
    UartReceiver = 10,
    /// Memory that translates addresses.
    TranslationRam = 11,
    /// Quadrature counters that share lines.
    MuxedEncoder = 12,
    /// Lines that select the half of muxed encoders.
    MuxedEncoderSelect = 13,
    /// Buffered SPI.
    BufferedSpi = 14,
    /// Debugger of the firmware.
    Debug = 15,
    /// Pulse-width modulation of three phases.
    ThreePhasePwm = 18,
    /// Absolute encoder with a `BiSS` interface.
    Biss = 24,
    /// Absolute encoder of Fanuc.
    Fanuc = 25,
    /// Clock that follows the thread's reads.
    Dpll = 26,
    /// Transmitter of packets.
    PacketTransmitter = 27,
    /// Receiver of packets.
    PacketReceiver = 28,
    /// Scanned inputs.
    InputMux = 30,
    /// Inputs with filters.
    Inputs = 35,
    /// Pulses for model servos.
    RcPwm = 44,
    /// Outputs.
    Outputs = 45,
    /// Lights of the board.
    Led = 128,
    /// Resolver.
    Resolver = 192,
    /// Smart serial.
    SmartSerial = 193,
    /// Driver of twiddled bits.
    Twiddler = 194,
    /// Solid-state relays.
    Ssr = 195,
    /// Smart serial with a processor of its own.
    SmartSerialB = 198,
    /// Generator of single pulses.
    OneShot = 199,
    /// Period and duty of inputs.
    PeriodMeter = 200,
}

/// Tag, its short name as the driver's pins have it, and the names of its I/O pins from number 1 on.
type Row = (Tag, &'static str, &'static [&'static str]);

const ROWS: &[Row] = &[
    (Tag::Irq, "irq", &[]),
    (Tag::Watchdog, "watchdog", &[]),
    (Tag::IoPort, "ioport", &[]),
    (Tag::Encoder, "encoder", &["A", "B", "Index", "IndexMask", "Probe"]),
    (
        Tag::StepGenerator,
        "stepgen",
        &["Step/Table1", "Dir/Table2", "Table3", "Table4", "Table5", "Table6", "Table7", "Table8"],
    ),
    (Tag::Pwm, "pwmgen", &["PWM", "Dir", "Not-Enable"]),
    (Tag::Spi, "spi", &[]),
    (Tag::Ssi, "ssi", &["Clk", "Data", "ClkEn", "Data Available"]),
    (Tag::UartTransmitter, "uart-tx", &["TX", "TX Enable"]),
    (Tag::UartReceiver, "uart-rx", &["RX"]),
    (Tag::TranslationRam, "translation-ram", &[]),
    (Tag::MuxedEncoder, "encoder", &["Muxed A", "Muxed B", "Muxed Index", "Muxed IndexMask"]),
    (Tag::MuxedEncoderSelect, "encoder-select", &["Select"]),
    (Tag::BufferedSpi, "bspi", &["Frame", "Serial Out", "Clock", "Serial In"]),
    (Tag::Debug, "debug", &[]),
    (
        Tag::ThreePhasePwm,
        "3pwmgen",
        &["PWM A", "PWM B", "PWM C", "NPWM A", "NPWM B", "NPWM C", "Enable", "Fault"],
    ),
    (Tag::Biss, "biss", &["Clk", "Data", "ClkEn", "DataDir"]),
    (Tag::Fanuc, "fanuc", &["Rqst", "Data", "RqstEn"]),
    (Tag::Dpll, "dpll", &["Sync", "RefOut", "Timer1", "Timer2", "Timer3", "Timer4"]),
    (Tag::PacketTransmitter, "pktuart-tx", &["TX", "TX Enable"]),
    (Tag::PacketReceiver, "pktuart-rx", &["RX"]),
    (Tag::InputMux, "inmux", &["Addr0", "Addr1", "Addr2", "Addr3", "Addr4", "Data"]),
    (Tag::Inputs, "inm", &[]),
    (Tag::RcPwm, "rcpwmgen", &[]),
    (Tag::Outputs, "outm", &[]),
    (Tag::Led, "led", &[]),
    (Tag::Resolver, "resolver", &[]),
    (Tag::SmartSerial, "sserial", &[]),
    (Tag::Twiddler, "twiddler", &[]),
    (Tag::Ssr, "ssr", &[]),
    (Tag::SmartSerialB, "sserialb", &[]),
    (Tag::OneShot, "oneshot", &["Trigger1", "Trigger2", "Out1", "Out2"]),
    (Tag::PeriodMeter, "periodm", &[]),
];

impl Tag {
    /// Returns the kind with this number.
    #[must_use]
    pub const fn from_number(number: u8) -> Option<Self> {
        let mut at = 0;
        while at < ROWS.len() {
            #[expect(clippy::indexing_slicing, reason = "a constant function has no iterators")]
            let tag = ROWS[at].0;
            if tag as u8 == number {
                return Some(tag);
            }
            at += 1;
        }
        None
    }

    /// Returns the short name, as in the driver's pins: `stepgen`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().map_or("", |row| row.1)
    }

    /// Returns the name of the I/O pin with this number, such as `Dir`.
    #[must_use]
    pub fn pin(self, number: u8) -> Option<&'static str> {
        let at = usize::from(number).checked_sub(1)?;
        self.row()?.2.get(at).copied()
    }

    /// Returns all kinds.
    pub fn all() -> impl Iterator<Item = Self> {
        ROWS.iter().map(|row| row.0)
    }

    fn row(self) -> Option<&'static Row> {
        ROWS.iter().find(|row| row.0 == self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_one_row_and_a_name() {
        for tag in Tag::all() {
            assert_eq!(Tag::from_number(tag as u8), Some(tag));
            assert_eq!(ROWS.iter().filter(|row| row.0 == tag).count(), 1, "{tag:?}");
            assert!(!tag.name().is_empty(), "{tag:?}");
            assert_eq!(tag.pin(0), None);
        }
        assert_eq!(Tag::from_number(0), None);
        assert_eq!(Tag::StepGenerator.pin(1), Some("Step/Table1"));
        assert_eq!(Tag::StepGenerator.pin(9), None);
    }
}
