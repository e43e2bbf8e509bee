//! Accounts that remotes give of themselves: process data and parameters.
//!
//! A remote's memory has two lists of addresses, each with 0 at its end: records of the process data of the selected mode, in
//! their order, and records of parameters. Source: section "SSLBP" of Mesa's manuals (7I76, pages 24 to 40).

/// Memory of a remote.
pub(crate) trait Memory {
    /// Reads 1, 2 or 4 bytes, the lowest first.
    fn read(&mut self, at: u16, bytes: u8) -> Result<u32, BadRemote>;
}

/// Most records of a list.
const MAX_RECORDS: usize = 64;

/// Longest name.
const MAX_NAME: u16 = 32;

/// Most bits of process data in one direction: three registers.
pub(crate) const MAX_BITS: u32 = 96;

/// Kind of a record.
const DATA_RECORD: u32 = 0xA0;
const MODE_RECORD: u32 = 0xB0;

/// Form of a datum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    Padding,
    Bits,
    Unsigned,
    Signed,
    Stream,
    Boolean,
    Encoder,
    Float,
}

impl Form {
    /// Returns the form with this number, and whether its value outlasts power.
    const fn from_number(number: u32) -> Option<(Self, bool)> {
        Some(match number {
            // An encoder's low part has no pins, as in LinuxCNC.
            0x00 | 0x28 => (Self::Padding, false),
            0x01 => (Self::Bits, false),
            0x02 => (Self::Unsigned, false),
            0x03 => (Self::Signed, false),
            0x04 => (Self::Unsigned, true),
            0x05 => (Self::Signed, true),
            0x06 => (Self::Stream, false),
            0x07 => (Self::Boolean, false),
            0x08 | 0x18 => (Self::Encoder, false),
            0x10 => (Self::Float, false),
            _ => return None,
        })
    }

    /// Returns whether a datum of this form can have so many bits.
    const fn takes(self, bits: u8) -> bool {
        match self {
            Self::Padding | Self::Bits => bits as u32 <= MAX_BITS,
            Self::Unsigned | Self::Signed | Self::Boolean | Self::Stream => bits <= 32,
            Self::Encoder => 2 <= bits && bits <= 32,
            Self::Float => bits == 32,
        }
    }
}

/// Direction of a datum, as the controller sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    In,
    Out,
    Both,
}

/// Process data of a remote.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Element {
    /// Name of the pins.
    pub(crate) name: String,
    /// Name as the remote has it.
    pub(crate) label: String,
    pub(crate) form: Form,
    pub(crate) flow: Flow,
    pub(crate) bits: u8,
    pub(crate) min: f32,
    pub(crate) max: f32,
    pub(crate) unit: String,
}

/// Parameter of a remote.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setting {
    pub(crate) name: String,
    pub(crate) form: Form,
    pub(crate) bits: u8,
    /// Address of the value.
    pub(crate) at: u16,
    /// True if the value outlasts power.
    pub(crate) lasts: bool,
    pub(crate) unit: String,
}

/// Account of a remote.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Description {
    pub(crate) elements: Vec<Element>,
    pub(crate) settings: Vec<Setting>,
}

/// Error of a remote's account.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BadRemote {
    /// The remote does not answer a question about its memory.
    Silent(u16),
    /// The remote has no account.
    Nothing,
    /// A list has no end.
    Endless(u16),
    /// A record is of no known kind.
    Record { at: u16, kind: u32 },
    /// A datum has a form that is not known, a direction that is none, or a width that its form cannot have.
    Datum { at: u16 },
    /// A name is too long, or has letters that no pin can have.
    Name { at: u16 },
    /// More process data than the registers carry.
    Width,
}

impl core::fmt::Display for BadRemote {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Silent(at) => write!(f, "it does not answer a question about address {at:#06x}"),
            Self::Nothing => f.write_str("it says nothing about its process data"),
            Self::Endless(at) => {
                write!(f, "its list at address {at:#06x} has no end within {MAX_RECORDS} records")
            }
            Self::Record { at, kind } => {
                write!(f, "its record at address {at:#06x} is of kind {kind:#04x}, which is none")
            }
            Self::Datum { at } => write!(
                f,
                "its record at address {at:#06x} has a form, direction or width that is not known"
            ),
            Self::Name { at } => write!(
                f,
                "the name at address {at:#06x} is longer than {MAX_NAME} letters, or has letters that \
                 no pin can have"
            ),
            Self::Width => {
                write!(f, "it has more than {MAX_BITS} bits of process data in one direction")
            }
        }
    }
}

impl core::error::Error for BadRemote {}

impl Description {
    /// Reads the account: `data` and `parameters` are the addresses of the two lists, 0 for none.
    pub(crate) fn read(
        memory: &mut dyn Memory,
        data: u16,
        parameters: u16,
    ) -> Result<Self, BadRemote> {
        if data == 0 {
            return Err(BadRemote::Nothing);
        }
        let mut description = Self::default();
        for at in list(memory, data)? {
            let Some(record) = Record::read(memory, at)? else { continue };
            let (form, _) = record.form.ok_or(BadRemote::Datum { at })?;
            if !form.takes(record.bits) {
                return Err(BadRemote::Datum { at });
            }
            description.elements.push(Element {
                name: record.label.to_ascii_lowercase(),
                label: record.label,
                form,
                flow: record.flow.ok_or(BadRemote::Datum { at })?,
                bits: record.bits,
                min: record.min,
                max: record.max,
                unit: record.unit,
            });
        }
        if [Flow::In, Flow::Out].iter().any(|flow| description.bits(*flow) > MAX_BITS) {
            return Err(BadRemote::Width);
        }
        if parameters != 0 {
            for at in list(memory, parameters)? {
                description.settings.extend(Self::setting(memory, at)?);
            }
        }
        Ok(description)
    }

    /// Reads the record of a parameter; `None` for one that no pin can hold.
    fn setting(memory: &mut dyn Memory, at: u16) -> Result<Option<Setting>, BadRemote> {
        let Some(record) = Record::read(memory, at)? else { return Ok(None) };
        let Some((form, lasts)) = record.form else { return Ok(None) };
        let fits = matches!(form, Form::Unsigned | Form::Signed | Form::Float);
        Ok((fits && form.takes(record.bits)).then_some(Setting {
            name: record.label.to_ascii_lowercase(),
            form,
            bits: record.bits,
            at: record.value_at,
            lasts,
            unit: record.unit,
        }))
    }

    /// Takes the pins of data whose name an earlier one has: their bits are padding.
    pub(crate) fn forget_doubles(&mut self) {
        let mut names: Vec<String> = Vec::new();
        for element in self.elements.iter_mut().filter(|e| e.form != Form::Padding) {
            if names.contains(&element.name) {
                element.form = Form::Padding;
            } else {
                names.push(element.name.clone());
            }
        }
        self.settings.retain(|setting| {
            let is_new = !names.contains(&setting.name);
            names.push(setting.name.clone());
            is_new
        });
    }

    /// Returns the number of bits of process data in a direction.
    pub(crate) fn bits(&self, flow: Flow) -> u32 {
        let of = self.elements.iter().filter(|e| e.flow == flow || e.flow == Flow::Both);
        of.map(|element| u32::from(element.bits)).sum()
    }
}

/// Reads a list of addresses.
fn list(memory: &mut dyn Memory, at: u16) -> Result<Vec<u16>, BadRemote> {
    let mut records = Vec::new();
    let mut place = at;
    loop {
        let [low, high, ..] = memory.read(place, 2)?.to_le_bytes();
        match u16::from_le_bytes([low, high]) {
            0 => return Ok(records),
            _ if records.len() == MAX_RECORDS => return Err(BadRemote::Endless(at)),
            record => records.push(record),
        }
        place = place.wrapping_add(2);
    }
}

/// Record of a datum.
struct Record {
    label: String,
    form: Option<(Form, bool)>,
    flow: Option<Flow>,
    bits: u8,
    min: f32,
    max: f32,
    value_at: u16,
    unit: String,
}

impl Record {
    /// Reads a record; `None` for that of a mode.
    fn read(memory: &mut dyn Memory, at: u16) -> Result<Option<Self>, BadRemote> {
        let mut read = |offset: u16, bytes| memory.read(at.wrapping_add(offset), bytes);
        match read(0, 1)? & 0xFF {
            DATA_RECORD => {}
            MODE_RECORD => return Ok(None),
            kind => return Err(BadRemote::Record { at, kind }),
        }
        let [bits, ..] = read(1, 1)?.to_le_bytes();
        let form = Form::from_number(read(2, 1)? & 0xFF);
        let flow = match read(3, 1)? & 0xFF {
            0x00 => Some(Flow::In),
            0x40 => Some(Flow::Both),
            0x80 => Some(Flow::Out),
            _ => None,
        };
        let (min, max) = (f32::from_bits(read(4, 4)?), f32::from_bits(read(8, 4)?));
        let [low, high, ..] = read(12, 2)?.to_le_bytes();
        if bits == 0 {
            return Err(BadRemote::Datum { at });
        }
        let (unit, end) = text(memory, at.wrapping_add(14))?;
        let (label, _) = text(memory, end)?;
        let is_pin = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        // Padding needs no name.
        let padding = matches!(form, Some((Form::Padding, _)));
        if !padding && (label.is_empty() || !label.chars().all(is_pin)) {
            return Err(BadRemote::Name { at: end });
        }
        let value_at = u16::from_le_bytes([low, high]);
        Ok(Some(Self { label, form, flow, bits, min, max, value_at, unit }))
    }
}

/// Reads a text up to its 0. Returns the text, and the address behind it.
fn text(memory: &mut dyn Memory, at: u16) -> Result<(String, u16), BadRemote> {
    let mut text = String::new();
    for offset in 0..=MAX_NAME {
        let place = at.wrapping_add(offset);
        let [byte, ..] = memory.read(place, 1)?.to_le_bytes();
        match byte {
            0 => return Ok((text, place.wrapping_add(1))),
            b' '..=b'~' => text.push(char::from(byte)),
            _ => return Err(BadRemote::Name { at }),
        }
    }
    Err(BadRemote::Name { at })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hal_bench::Random;

    /// Memory as a row of bytes, beyond which nothing answers.
    struct Bytes(Vec<u8>);

    impl Memory for Bytes {
        fn read(&mut self, at: u16, bytes: u8) -> Result<u32, BadRemote> {
            let byte = |n: u8| self.0.get(usize::from(at) + usize::from(n)).copied();
            (0..bytes).rev().try_fold(0, |all, n| {
                byte(n).map(|byte| all << 8 | u32::from(byte)).ok_or(BadRemote::Silent(at))
            })
        }
    }

    /// Returns a memory with one record of process data, as its parts.
    fn one(kind: u8, bits: u8, form: u8, flow: u8, name: &str) -> Bytes {
        let mut bytes = vec![0, 0, 0x10, 0, 0, 0];
        bytes.resize(16, 0);
        bytes.extend([kind, bits, form, flow]);
        bytes.extend(1.0_f32.to_le_bytes());
        bytes.extend(36.3_f32.to_le_bytes());
        bytes.extend([0x34, 0x12]);
        bytes.extend(b"Volts\0");
        bytes.extend(name.as_bytes());
        bytes.push(0);
        Bytes(bytes)
    }

    #[test]
    fn a_record_is_an_element_or_a_parameter() {
        let mut memory = one(0xA0, 8, 4, 0x40, "NVThing");
        let description = Description::read(&mut memory, 2, 2).unwrap();
        let [element] = &description.elements[..] else { panic!("{description:?}") };
        assert_eq!((element.name.as_str(), element.bits), ("nvthing", 8));
        assert_eq!((element.form, element.flow), (Form::Unsigned, Flow::Both));
        assert_eq!((element.min.to_bits(), element.max.to_bits()), (0x3F80_0000, 0x4211_3333));
        let [setting] = &description.settings[..] else { panic!("{description:?}") };
        assert_eq!((setting.at, setting.lasts, setting.unit.as_str()), (0x1234, true, "Volts"));
        assert_eq!((description.bits(Flow::In), description.bits(Flow::Out)), (8, 8));
        let mode = Description::read(&mut one(0xB0, 0, 1, 0, "Standard"), 2, 0).unwrap();
        assert_eq!(mode, Description::default());
    }

    #[test]
    fn nonsense_is_named() {
        let long = "x".repeat(33);
        let rows = [
            (one(0xA1, 8, 1, 0, "A"), 2, BadRemote::Record { at: 16, kind: 0xA1 }),
            (one(0xA0, 0, 1, 0, "A"), 2, BadRemote::Datum { at: 16 }),
            (one(0xA0, 8, 9, 0, "A"), 2, BadRemote::Datum { at: 16 }),
            (one(0xA0, 8, 1, 1, "A"), 2, BadRemote::Datum { at: 16 }),
            (one(0xA0, 33, 2, 0, "A"), 2, BadRemote::Datum { at: 16 }),
            (one(0xA0, 16, 16, 0, "A"), 2, BadRemote::Datum { at: 16 }),
            (one(0xA0, 8, 1, 0, ""), 2, BadRemote::Name { at: 36 }),
            (one(0xA0, 8, 1, 0, "a b"), 2, BadRemote::Name { at: 36 }),
            (one(0xA0, 8, 1, 0, &long), 2, BadRemote::Name { at: 36 }),
            (one(0xA0, 8, 1, 0, "A"), 0, BadRemote::Nothing),
            (one(0xA0, 8, 1, 0, "A"), 0xFFFE, BadRemote::Silent(0xFFFE)),
            (Bytes(vec![1; 400]), 2, BadRemote::Endless(2)),
        ];
        for (mut memory, at, bad) in rows {
            assert_eq!(Description::read(&mut memory, at, 0), Err(bad), "{bad}");
        }
        let mut wide = one(0xA0, 96, 1, 0, "A");
        wide.0.splice(2..6, [0x10, 0, 0x10, 0]);
        assert_eq!(Description::read(&mut wide, 2, 0), Err(BadRemote::Width));
    }

    /// Remotes of chance: most are refused; the rest is within the bounds.
    #[test]
    fn no_remote_panics_or_grows() {
        let mut random = Random::new(7);
        let mut good = 0;
        for round in 0..100_000 {
            // Every other one is a right remote with some wrong bytes.
            let mut memory = if round % 2 == 0 {
                let len = random.index(300) + 2;
                Bytes((0..len).map(|_| random.word().to_le_bytes()[0]).collect())
            } else {
                let mut memory = one(0xA0, 8, 1, 0, "Input");
                for _ in 0..3 {
                    let at = random.index(memory.0.len());
                    memory.0[at] = random.word().to_le_bytes()[0];
                }
                memory
            };
            let [a, b, ..] = random.word().to_le_bytes();
            let at = if round % 2 == 0 { u16::from(a) } else { 2 };
            let Ok(description) = Description::read(&mut memory, at, u16::from(b) & 2) else {
                continue;
            };
            good += 1;
            assert!(description.elements.len() <= MAX_RECORDS);
            assert!(description.settings.len() <= MAX_RECORDS);
            assert!(
                description.bits(Flow::In) <= MAX_BITS && description.bits(Flow::Out) <= MAX_BITS
            );
            for element in &description.elements {
                assert!(element.name.len() <= usize::from(MAX_NAME));
            }
        }
        assert!(good > 1000, "{good}");
    }
}
