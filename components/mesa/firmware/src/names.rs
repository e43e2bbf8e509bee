//! Names of the pins that modules use, as the maker's listings have them.

use crate::{Pin, Tag};

/// Name of a module's pin, such as `RXData0` or `Step/Table1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinName {
    /// Letters of the name.
    pub stem: &'static str,
    /// Number behind the letters, if the module has several such pins.
    pub index: Option<u8>,
}

impl core::fmt::Display for PinName {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.stem)?;
        self.index.map_or(Ok(()), |index| write!(f, "{index}"))
    }
}

/// First number, true for outputs, number of such pins, letters.
type Range = (u8, bool, u8, &'static str);

/// Pins of each kind of module. Inputs and outputs are numbered apart from each other.
///
/// Source: Mesa's `IDROMConst.vhd`, published under the BSD licence with 3 clauses, and the listings of `mesaflash`.
const ROWS: &[(Tag, &[Range])] = &[
    (Tag::Encoder, ENCODER),
    (Tag::MuxedEncoder, ENCODER),
    (Tag::MuxedEncoderSelect, &[(1, true, 2, "MuxSel")]),
    (
        Tag::StepGenerator,
        &[
            (1, true, 1, "Step/Table1"),
            (2, true, 1, "Dir/Table2"),
            (3, true, 1, "Table3"),
            (4, true, 1, "Table4"),
            (5, true, 1, "Table5"),
            (6, true, 1, "Table6"),
            (7, true, 1, "Table7"),
            (8, true, 1, "Table8"),
            (9, false, 1, "Index"),
            (10, false, 1, "Probe"),
        ],
    ),
    (Tag::Pwm, &[(1, true, 1, "PWM"), (2, true, 1, "Dir"), (3, true, 1, "/Enable")]),
    (Tag::Dpll, &[(1, false, 1, "Sync"), (2, true, 1, "RefOut"), (3, true, 4, "Timer")]),
    (Tag::Ssr, &[(1, true, 31, "Out-"), (0x20, true, 1, "AC-Ref")]),
    (Tag::Outputs, &[(1, true, 32, "Output")]),
    (Tag::Inputs, &[(1, false, 32, "Input")]),
    (Tag::InputMux, &[(1, true, 5, "Addr"), (1, false, 1, "Data")]),
    (Tag::SmartSerial, SERIAL),
    (Tag::SmartSerialB, SERIAL),
    (Tag::PacketTransmitter, &[(1, true, 1, "TxData"), (2, true, 1, "TxEn")]),
    (Tag::PacketReceiver, &[(1, false, 1, "RxData")]),
];

const ENCODER: &[Range] = &[
    (1, false, 1, "Quad-A"),
    (2, false, 1, "Quad-B"),
    (3, false, 1, "Quad-IDX"),
    (4, false, 1, "Quad-IDXM"),
    (5, false, 1, "Quad-Probe"),
];

const SERIAL: &[Range] = &[
    (1, false, 15, "RXData"),
    (1, true, 15, "TXData"),
    (0x11, true, 15, "TXEn"),
    (0x21, true, 15, "NTXEn"),
];

impl Tag {
    /// Returns the name of the module's pin with this number.
    #[must_use]
    pub fn pin_name(self, number: u8, is_output: bool) -> Option<PinName> {
        let ranges = ROWS.iter().find(|row| row.0 == self)?.1;
        ranges.iter().find_map(|(first, output, count, stem)| {
            let at = number.checked_sub(*first)?;
            (*output == is_output && at < *count)
                .then_some(PinName { stem, index: (1 < *count).then_some(at) })
        })
    }

    /// Returns all pins that the module can have: number, whether it is an output, name.
    pub fn pin_names(self) -> impl Iterator<Item = (u8, bool, PinName)> {
        let ranges = ROWS.iter().find(|row| row.0 == self).map_or(&[][..], |row| row.1);
        ranges.iter().flat_map(move |(first, output, count, _)| {
            (*first..first.saturating_add(*count))
                .filter_map(move |number| Some((number, *output, self.pin_name(number, *output)?)))
        })
    }
}

impl Pin {
    /// Returns the name of the module's pin, if the module is known and has such a pin.
    #[must_use]
    pub fn name(&self) -> Option<PinName> {
        self.kind()?.pin_name(self.number, self.is_output)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::{collections::BTreeSet, string::ToString};

    #[test]
    fn names_lead_back_to_their_pins() {
        let mut seen = 0;
        for tag in Tag::all() {
            let mut names = BTreeSet::new();
            for (number, is_output, name) in tag.pin_names() {
                assert!(names.insert(name.to_string()), "{tag:?} {name}");
                assert_eq!(tag.pin_name(number, is_output), Some(name));
                seen += 1;
            }
        }
        assert!(240 < seen, "{seen}");
    }

    /// Descriptors from Mesa's published firmware.
    #[test]
    fn pins_have_the_listings_names() {
        let rows = [
            (0x0300_0581, "Step/Table1"),
            (0x0300_0582, "Dir/Table2"),
            (0x0300_C101, "RXData0"),
            (0x0300_C182, "TXData1"),
            (0x0300_C191, "TXEn0"),
            (0x0300_1E01, "Data"),
            (0x0300_1E85, "Addr4"),
            (0x0300_C3A0, "AC-Ref"),
            (0x0300_230B, "Input10"),
            (0x0300_0683, "/Enable"),
        ];
        for (word, name) in rows {
            assert_eq!(Pin::parse(word).name().map(|n| n.to_string()).as_deref(), Some(name));
        }
        assert_eq!(Pin::plain().name(), None);
        assert_eq!(Pin::parse(0x0300_C121).name(), None);
    }
}
