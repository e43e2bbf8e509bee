//! Chips of the computer: their lines by name, and requests of them.

use crate::{
    config::{EncoderLines, NamedLine, Place},
    label::{Label, nearest},
    refused::Refused,
    request::{FoundLine, LineRequest, plan},
};
use libc::{EACCES, EBUSY, ENODEV, ENOENT, ENOTTY, ENXIO, EPERM};
use port::{Lines, Lost};
use std::collections::BTreeMap;

/// GPIO chips of a computer.
pub(crate) trait Chips {
    /// Returns the numbers of the chips, ascending, each chip once.
    fn numbers(&self) -> Result<Vec<u32>, Lost>;

    /// Opens a chip.
    fn open(&self, number: u32) -> Result<Box<dyn OpenChip>, Lost>;
}

/// GPIO chip that is open.
pub(crate) trait OpenChip {
    /// Returns what the chip says of itself.
    fn facts(&self) -> Result<ChipFacts, Lost>;

    /// Returns what the chip says of a line.
    fn line(&self, offset: u32) -> Result<LineFacts, Lost>;

    /// Requests lines. Outputs are inactive from the first moment.
    fn request(&self, request: &LineRequest) -> Result<Box<dyn Lines>, Lost>;
}

/// Name and size of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChipFacts {
    pub(crate) label: Label,
    pub(crate) lines: u32,
}

/// Name and holder of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LineFacts {
    pub(crate) name: Label,
    /// Name that the holder gave itself; empty if there is none.
    pub(crate) consumer: Label,
    pub(crate) is_held: bool,
}

/// Largest number of lines of a chip that is looked at. The kernel's numbers stay far below.
const MOST_LOOKED_AT: u32 = 4096;

/// Beginnings of the labels of chips that drive the 40-pin header of a Raspberry Pi.
const HEADERS: [&str; 3] = ["pinctrl-bcm2835", "pinctrl-bcm2711", "pinctrl-rp1"];

/// Requested lines, with the request that they are of.
pub(crate) struct Requested {
    pub(crate) request: LineRequest,
    pub(crate) lines: Box<dyn Lines>,
}

/// Finds the lines, and requests them all; if one is refused, none stays requested.
pub(crate) fn open(
    chips: &dyn Chips,
    lines: &[NamedLine],
    encoders: &[EncoderLines],
) -> Result<Vec<Requested>, Refused> {
    let mut listed = Listed::new(chips)?;
    let mut found: Vec<FoundLine> = Vec::new();
    for line in lines {
        let (chip, offset) = listed.find(line)?;
        let same = found.iter().position(|f| (f.chip, f.offset) == (chip, offset));
        if let Some(other) = same.and_then(|at| lines.get(at)) {
            return Err(Refused::Same { names: [other.name, line.name], chip, offset });
        }
        found.push(FoundLine { chip, offset, setting: line.setting });
    }
    for EncoderLines { a, b, z } in encoders {
        for other in [b, z].into_iter().flatten() {
            let apart = found.get(*a).zip(found.get(*other)).is_some_and(|(a, o)| a.chip != o.chip);
            if let (true, Some(a), Some(other)) = (apart, lines.get(*a), lines.get(*other)) {
                return Err(Refused::Apart(a.name, other.name));
            }
        }
    }
    // All holders are looked for before the first line is requested.
    for (line, at) in lines.iter().zip(&found) {
        listed.held(line.name, at.chip, at.offset)?;
    }
    let requests = plan(&found, encoders).into_iter();
    requests.map(|request| listed.request(request, lines)).collect()
}

/// Chips with the names of their lines.
struct Listed {
    open: BTreeMap<u32, (Box<dyn OpenChip>, ChipFacts)>,
    /// Chips that could not be opened.
    refused: BTreeMap<u32, Refused>,
    /// Named lines, as chip and number.
    names: BTreeMap<Label, Vec<(u32, u32)>>,
}

impl Listed {
    fn new(chips: &dyn Chips) -> Result<Self, Refused> {
        let numbers = chips.numbers().map_err(|_| Refused::NoChips)?;
        if numbers.is_empty() {
            return Err(Refused::NoChips);
        }
        let mut listed =
            Self { open: BTreeMap::new(), refused: BTreeMap::new(), names: BTreeMap::new() };
        for number in numbers {
            if let Err(lost) = listed.add(chips, number) {
                listed.refused.insert(number, refusal(number, lost));
            }
        }
        Ok(listed)
    }

    fn add(&mut self, chips: &dyn Chips, number: u32) -> Result<(), Lost> {
        let chip = chips.open(number)?;
        let facts = chip.facts()?;
        let mut names = Vec::new();
        for offset in 0..facts.lines.min(MOST_LOOKED_AT) {
            names.push((chip.line(offset)?.name, offset));
        }
        for (name, offset) in names.into_iter().filter(|(name, _)| !name.is_empty()) {
            self.names.entry(name).or_default().push((number, offset));
        }
        self.open.insert(number, (chip, facts));
        Ok(())
    }

    /// Returns chip and number of a line.
    fn find(&self, line: &NamedLine) -> Result<(u32, u32), Refused> {
        let name = line.name;
        match line.place {
            Place::At { chip, offset } => {
                let (_, facts) = self.chip(chip)?;
                if offset >= facts.lines {
                    return Err(Refused::Beyond { chip, offset, lines: facts.lines });
                }
                Ok((chip, offset))
            }
            Place::Header(offset) => {
                let is_header = |facts: &ChipFacts| {
                    HEADERS.iter().any(|header| facts.label.as_str().starts_with(header))
                };
                let found = self.open.iter().find(|(_, (_, facts))| is_header(facts));
                let none = || self.refused.values().next().copied().unwrap_or(Refused::NoHeader);
                let (chip, (_, facts)) = found.ok_or_else(none)?;
                if offset >= facts.lines {
                    return Err(Refused::Beyond { chip: *chip, offset, lines: facts.lines });
                }
                Ok((*chip, offset))
            }
            Place::Named => match self.names.get(&name).map(Vec::as_slice) {
                Some([one]) => Ok(*one),
                Some([one, other, ..]) => Err(Refused::Ambiguous { name, lines: [*one, *other] }),
                // The line may be on a chip that this user may not open.
                None | Some([]) => match self.refused.values().next() {
                    Some(refused) => Err(*refused),
                    None => Err(Refused::Unknown {
                        name,
                        near: nearest(name, self.names.keys().copied()),
                    }),
                },
            },
        }
    }

    fn chip(&self, number: u32) -> Result<&(Box<dyn OpenChip>, ChipFacts), Refused> {
        let why = || self.refused.get(&number).copied().unwrap_or(Refused::NoChip(number));
        self.open.get(&number).ok_or_else(why)
    }

    /// Refuses a line that somebody holds.
    fn held(&self, name: Label, chip: u32, offset: u32) -> Result<(), Refused> {
        let (open, _) = self.chip(chip)?;
        let facts = open.line(offset).map_err(|lost| refusal(chip, lost))?;
        if facts.is_held {
            return Err(Refused::Held { name, chip, offset, consumer: facts.consumer });
        }
        Ok(())
    }

    fn request(&mut self, request: LineRequest, lines: &[NamedLine]) -> Result<Requested, Refused> {
        let chip = request.chip;
        let (open, _) = self.chip(chip)?;
        match open.request(&request) {
            Ok(lines) => Ok(Requested { request, lines }),
            Err(lost @ Lost(EBUSY)) => {
                // Somebody took a line after it was looked at.
                for (index, offset) in request.lines.iter().zip(&request.offsets) {
                    let name = lines.get(*index).map_or(Label::NONE, |line| line.name);
                    self.held(name, chip, *offset)?;
                }
                Err(Refused::Broken(chip, lost))
            }
            Err(lost @ Lost(EPERM | ENOENT | ENXIO | EACCES | ENODEV | ENOTTY)) => {
                Err(refusal(chip, lost))
            }
            Err(lost) => Err(Refused::Unable {
                chip,
                lost,
                bias: request.mask(|s| s.bias != crate::config::Bias::AsIs) != 0,
                drive: request.mask(|s| s.drive != crate::config::Drive::Both) != 0,
            }),
        }
    }
}

const fn refusal(chip: u32, lost: Lost) -> Refused {
    match lost.0 {
        EPERM | EACCES => Refused::Forbidden(chip),
        ENOENT | ENXIO => Refused::NoChip(chip),
        ENOTTY => Refused::Old(chip),
        _ => Refused::Broken(chip, lost),
    }
}
