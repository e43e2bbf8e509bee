//! Pins of a transaction.

use super::config::{Function, MbConfig, TransactionConfig};
use hal_component::{Builder, Error, In, Out, Touch};
use hal_modbus::{Call, Miss, ModbusAnswer, ModbusRequest, ModbusTable};

/// A register as pins.
#[derive(Debug, Touch)]
struct ReadWord {
    float: Out<f64>,
    int: Out<i32>,
    scale: In<f64>,
    offset: In<f64>,
}

/// A register that pins give.
#[derive(Debug, Touch)]
struct WriteWord {
    float: In<f64>,
    int: Option<In<i32>>,
    scale: In<f64>,
    offset: In<f64>,
}

/// Values of a transaction. One list has elements, the others are empty.
#[derive(Debug, Touch)]
pub(crate) struct ValuePins {
    read_bits: Vec<(Out<bool>, Option<Out<bool>>)>,
    read_words: Vec<ReadWord>,
    write_bits: Vec<In<bool>>,
    write_words: Vec<WriteWord>,
}

impl ValuePins {
    pub(crate) fn make(
        b: &mut Builder<'_>,
        config: &MbConfig,
        of: &TransactionConfig,
    ) -> Result<Self, Error> {
        let mut pins = Self {
            read_bits: Vec::new(),
            read_words: Vec::new(),
            write_bits: Vec::new(),
            write_words: Vec::new(),
        };
        let is_new = config.has_new_names;
        for (number, pin) in (u32::from(of.first)..).zip(&of.pins) {
            let base = format!("{}.{}.{pin}", config.prefix, of.name);
            let bit = if is_new { format!("{base}.bit") } else { base.clone() };
            match of.kind {
                Function::Read(table) if table.is_bits() => {
                    let doc = format!("Value of element {number}.");
                    let not = if is_new {
                        let doc = format!("The opposite of the value of element {number}.");
                        Some(b.item(&format!("{base}.bit-inv"), &doc, false)?)
                    } else {
                        None
                    };
                    pins.read_bits.push((b.item(&bit, &doc, false)?, not));
                }
                Function::Read(_) => {
                    let doc = format!(
                        "Value of register {number}, 0 to 65535, times scale, plus offset."
                    );
                    let float = b.item(&format!("{base}.float"), &doc, 0.0)?;
                    let doc = format!("Value of register {number}, 0 to 65535.");
                    let int = b.item(&format!("{base}.int"), &doc, 0)?;
                    let (scale, offset) = scale(b, &base)?;
                    pins.read_words.push(ReadWord { float, int, scale, offset });
                }
                Function::WriteCoil | Function::WriteCoils => {
                    pins.write_bits.push(b.item(
                        &bit,
                        &format!("Value for coil {number}."),
                        false,
                    )?);
                }
                Function::WriteRegister | Function::WriteRegisters => {
                    let doc = format!(
                        "Value for register {number}: times scale, plus offset, plus the pin int, without its fraction, limited to -32768 to 65535."
                    );
                    let name = if is_new { format!("{base}.float") } else { base.clone() };
                    let float = b.item(&name, &doc, 0.0)?;
                    let int = if is_new {
                        let doc =
                            format!("Value that is added to the float for register {number}.");
                        Some(b.item(&format!("{base}.int"), &doc, 0)?)
                    } else {
                        None
                    };
                    let (scale, offset) = scale(b, &base)?;
                    pins.write_words.push(WriteWord { float, int, scale, offset });
                }
            }
        }
        Ok(pins)
    }

    /// Returns the request with the values that the pins have now.
    pub(crate) fn request(&self, of: &TransactionConfig) -> ModbusRequest {
        let (first, on) = (of.first, || self.write_bits.iter().map(In::get).collect::<Vec<_>>());
        let values = || self.write_words.iter().map(WriteWord::get).collect::<Vec<_>>();
        let call = match of.kind {
            Function::Read(table) => {
                Call::Read { table, first, count: u16::try_from(of.pins.len()).unwrap_or(u16::MAX) }
            }
            Function::WriteCoil => {
                Call::WriteCoil { at: first, on: on().first().copied().unwrap_or_default() }
            }
            Function::WriteRegister => Call::WriteRegister {
                at: first,
                value: values().first().copied().unwrap_or_default(),
            },
            Function::WriteCoils => Call::WriteCoils { first, on: on() },
            Function::WriteRegisters => Call::WriteRegisters { first, values: values() },
        };
        ModbusRequest { unit: of.unit, call }
    }

    /// Shows an answer.
    pub(crate) fn show(&self, answer: &ModbusAnswer) {
        match answer {
            ModbusAnswer::Bits(bits) => {
                for ((pin, not), bit) in self.read_bits.iter().zip(bits) {
                    pin.set(*bit);
                    if let Some(not) = not {
                        not.set(!bit);
                    }
                }
            }
            ModbusAnswer::Words(words) => {
                for (pins, word) in self.read_words.iter().zip(words) {
                    pins.int.set(i32::from(*word));
                    pins.float.set(f64::from(*word) * pins.scale.get() + pins.offset.get());
                }
            }
            ModbusAnswer::Written | ModbusAnswer::Refused(_) => {}
        }
    }
}

impl WriteWord {
    /// Returns the value of the register.
    #[expect(clippy::cast_possible_truncation, reason = "limited before")]
    fn get(&self) -> u16 {
        let float = self.float.get() * self.scale.get() + self.offset.get();
        let sum = float + f64::from(self.int.as_ref().map_or(0, In::get));
        let limited = match sum {
            _ if sum.is_nan() => 0.0,
            _ if sum < -32768.0 => -32768.0,
            _ if 65535.0 < sum => 65535.0,
            _ => sum,
        };
        // Negative numbers have their usual form of 16 bits.
        let [low, high, ..] = (limited.trunc() as i32).to_le_bytes();
        u16::from_le_bytes([low, high])
    }
}

fn scale(b: &mut Builder<'_>, base: &str) -> Result<(In<f64>, In<f64>), Error> {
    Ok((
        b.item(&format!("{base}.scale"), "Ratio of float to register.", 1.0)?,
        b.item(
            &format!("{base}.offset"),
            "Number that is added to the scaled value, in the unit of the float.",
            0.0,
        )?,
    ))
}

/// Pins that tell how a transaction does.
#[derive(Debug, Touch)]
pub(crate) struct HealthPins {
    pub(crate) num_errors: Out<u32>,
    pub(crate) answers: Out<u32>,
    pub(crate) errors: [Out<u32>; Miss::KINDS],
    pub(crate) refused: Out<u32>,
    pub(crate) since: Out<f64>,
    pub(crate) fault: Out<bool>,
}

impl HealthPins {
    pub(crate) fn make(b: &mut Builder<'_>, base: &str) -> Result<Self, Error> {
        let name = |pin| format!("{base}.{pin}");
        Ok(Self {
            num_errors: b.item(&name("num_errors"), "Number of requests without the answer that was wanted.", 0)?,
            answers: b.item(&name("answers"), "Number of answers.", 0)?,
            errors: [
                b.item(&name("errors-silent"), "Number of requests without an answer.", 0)?,
                b.item(&name("errors-other"), "Number of requests that another device answered.", 0)?,
                b.item(&name("errors-wrong"), "Number of answers to something else.", 0)?,
                b.item(&name("errors-noise"), "Number of answers that were no frames.", 0)?,
            ],
            refused: b.item(&name("errors-refused"), "Number of requests that the device refused.", 0)?,
            since: b.item(&name("since-answer"), "Time since the last answer, in seconds.", 0.0)?,
            fault: b.item(
                &name("fault"),
                "TRUE while the device has not answered for 1 s, twice its time for an answer and two periods; values stay meanwhile.",
                false,
            )?,
        })
    }
}

/// Pins of the simulated device of a transaction.
#[derive(Debug, Touch)]
pub(crate) struct SimulatedValues {
    /// Values that are read.
    bits: Vec<In<bool>>,
    words: Vec<In<u32>>,
    /// Values that were written.
    coils: Vec<Out<bool>>,
    registers: Vec<Out<u32>>,
    silent: In<bool>,
}

impl SimulatedValues {
    pub(crate) fn make(
        b: &mut Builder<'_>,
        prefix: &str,
        of: &TransactionConfig,
    ) -> Result<Self, Error> {
        let base = format!("{prefix}.sim.{}", of.name);
        let doc = "TRUE: the simulated device of this transaction does not answer.";
        let mut pins = Self {
            bits: Vec::new(),
            words: Vec::new(),
            coils: Vec::new(),
            registers: Vec::new(),
            silent: b.simulated(&format!("{base}.silent"), doc, false)?,
        };
        for pin in &of.pins {
            let name = format!("{base}.{pin}");
            match of.kind {
                Function::Read(table) if table.is_bits() => {
                    pins.bits.push(b.simulated(&name, "Value in the simulated device.", false)?);
                }
                Function::Read(_) => {
                    pins.words.push(b.simulated(&name, "Value in the simulated device.", 0)?);
                }
                Function::WriteCoil | Function::WriteCoils => {
                    pins.coils.push(b.simulated(&name, "Value in the simulated device.", false)?);
                }
                Function::WriteRegister | Function::WriteRegisters => {
                    pins.registers.push(b.simulated(&name, "Value in the simulated device.", 0)?);
                }
            }
        }
        Ok(pins)
    }

    /// Returns whether the device is silent.
    pub(crate) fn is_silent(&self) -> bool {
        self.silent.get()
    }

    /// Exchanges values between pins and a device.
    pub(crate) fn exchange(&self, of: &TransactionConfig, slave: &mut hal_modbus_devices::Slave) {
        let first = usize::from(of.first);
        match of.kind {
            Function::Read(table) if table.is_bits() => {
                let to = if table == ModbusTable::Coils {
                    &mut slave.coils
                } else {
                    &mut slave.discretes
                };
                to.iter_mut().skip(first).zip(&self.bits).for_each(|(to, pin)| *to = pin.get());
            }
            Function::Read(table) => {
                let to = if table == ModbusTable::Holding {
                    &mut slave.holding
                } else {
                    &mut slave.inputs
                };
                let word = |pin: &In<u32>| u16::try_from(pin.get()).unwrap_or(u16::MAX);
                to.iter_mut().skip(first).zip(&self.words).for_each(|(to, pin)| *to = word(pin));
            }
            Function::WriteCoil | Function::WriteCoils => {
                let from = slave.coils.iter().skip(first);
                from.zip(&self.coils).for_each(|(from, pin)| pin.set(*from));
            }
            Function::WriteRegister | Function::WriteRegisters => {
                let from = slave.holding.iter().skip(first);
                from.zip(&self.registers).for_each(|(from, pin)| pin.set(u32::from(*from)));
            }
        }
    }
}
