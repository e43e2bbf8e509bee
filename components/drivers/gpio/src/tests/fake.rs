//! Chips in memory, which refuse as a kernel does.

use crate::{
    chips::{ChipFacts, Chips, LineFacts, OpenChip},
    config,
    gpio::declare,
    label::Label,
    request::LineRequest,
};
use hal_bench::Bench;
use hal_component::{Arg, Builder, Component, Error, abi};
use port::{LineEdge, Lines, Lost, RecordedLines};
use std::{
    cell::RefCell,
    sync::{Arc, Mutex},
};

/// Chip whose lines remember what was written to them.
#[derive(Clone, Default)]
pub(super) struct FakeChip {
    pub(super) label: &'static str,
    /// Name and consumer of each line; a line with a consumer is held.
    pub(super) lines: Vec<(&'static str, Option<&'static str>)>,
    /// Errors of opening the chip, of asking it, and of requesting lines.
    pub(super) open: Option<Lost>,
    pub(super) facts: Option<Lost>,
    pub(super) request: Option<Lost>,
    /// Consumer of all lines from the request on, as if another program had been faster.
    pub(super) faster: Option<&'static str>,
}

/// Chips of a computer, and the lines that were requested.
#[derive(Clone, Default)]
pub(super) struct FakeChips {
    pub(super) numbers: Option<Lost>,
    pub(super) chips: Vec<(u32, FakeChip)>,
    pub(super) requested: Arc<Mutex<Vec<FakeLines>>>,
    /// Levels of all lines when they are requested.
    pub(super) initial: Arc<Mutex<u64>>,
}

pub(super) type FakeLines = (LineRequest, Arc<RecordedLines<Memory>>);

/// Lines in memory: edges that wait, levels of inputs, and an error of every access.
#[derive(Debug, Default)]
pub(super) struct Memory {
    pub(super) levels: Mutex<u64>,
    pub(super) waiting: Mutex<Vec<LineEdge>>,
    pub(super) lost: Mutex<Option<Lost>>,
}

impl Memory {
    fn answer(&self) -> Result<(), Lost> {
        self.lost.lock().unwrap().map_or(Ok(()), Err)
    }
}

impl Lines for Memory {
    fn read(&self, mask: u64) -> Result<u64, Lost> {
        self.answer()?;
        Ok(*self.levels.lock().unwrap() & mask)
    }
    fn write(&self, _: u64, _: u64) -> Result<(), Lost> {
        self.answer()
    }
    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost> {
        self.answer()?;
        let mut waiting = self.waiting.lock().unwrap();
        let count = waiting.len().min(room.len());
        room[..count].copy_from_slice(&waiting[..count]);
        waiting.drain(..count);
        Ok(count)
    }
}

impl Chips for FakeChips {
    fn numbers(&self) -> Result<Vec<u32>, Lost> {
        self.numbers.map_or_else(|| Ok(self.chips.iter().map(|(n, _)| *n).collect()), Err)
    }
    fn open(&self, number: u32) -> Result<Box<dyn OpenChip>, Lost> {
        let chip = &self.chips.iter().find(|(n, _)| *n == number).unwrap().1;
        if let Some(lost) = chip.open {
            return Err(lost);
        }
        let held = RefCell::new(chip.lines.iter().map(|(_, consumer)| *consumer).collect());
        Ok(Box::new(Opened { chip: chip.clone(), held, all: self.clone() }))
    }
}

struct Opened {
    chip: FakeChip,
    held: RefCell<Vec<Option<&'static str>>>,
    all: FakeChips,
}

impl OpenChip for Opened {
    fn facts(&self) -> Result<ChipFacts, Lost> {
        let lines = u32::try_from(self.chip.lines.len()).unwrap();
        self.chip.facts.map_or(Ok(ChipFacts { label: Label::cut(self.chip.label), lines }), Err)
    }
    fn line(&self, offset: u32) -> Result<LineFacts, Lost> {
        let index = usize::try_from(offset).unwrap();
        let (name, consumer) = (self.chip.lines[index].0, self.held.borrow()[index]);
        let label = Label::cut(consumer.unwrap_or_default());
        Ok(LineFacts { name: Label::cut(name), consumer: label, is_held: consumer.is_some() })
    }
    fn request(&self, request: &LineRequest) -> Result<Box<dyn Lines>, Lost> {
        if self.chip.faster.is_some() {
            self.held.borrow_mut().fill(self.chip.faster);
        }
        if let Some(lost) = self.chip.request {
            return Err(lost);
        }
        let levels = Mutex::new(*self.all.initial.lock().unwrap());
        let lines = Arc::new(RecordedLines::new(Memory { levels, ..Memory::default() }));
        self.all.requested.lock().unwrap().push((request.clone(), lines.clone()));
        Ok(Box::new(lines))
    }
}

thread_local! {
    static CHIPS: RefCell<FakeChips> = RefCell::default();
}

/// `hal_gpio` on the chips of this thread.
enum FakeGpio {}

const NAMES: [&str; 6] = ["inputs", "outputs", "reset", "encoders", "pullup", "opendrain"];
const LISTS: [&abi::ArgSpec; 6] = [
    &Arg::texts("inputs", "Inputs."),
    &Arg::texts("outputs", "Outputs."),
    &Arg::texts("reset", "Outputs that are reset."),
    &Arg::texts("encoders", "Encoders."),
    &Arg::texts("pullup", "Lines with a resistor."),
    &Arg::texts("opendrain", "Outputs that drive low alone."),
];

impl Component for FakeGpio {
    const NAME: &'static str = "hal_gpio";
    const DOC: &'static str = "The driver on fake chips.";
    const FLAGS: u32 = abi::component_flags::ONCE;
    const ARGS: &'static [&'static abi::ArgSpec] = &LISTS;
    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let texts = |arg| if NAMES.contains(&arg) { b.arg_texts(arg) } else { Vec::new() };
        let config = config::parse(texts).map_err(|why| Error::new(why.to_string()))?;
        declare(b, "hal_gpio", config, true, CHIPS.take())
    }
}

/// Loads the driver on fake chips.
pub(super) fn load(bench: &mut Bench, chips: &FakeChips, args: &[&str]) -> Result<(), String> {
    CHIPS.set(chips.clone());
    bench.load::<FakeGpio>(args)
}

/// Returns chips of which the first has lines of these names.
pub(super) fn named(names: &[&'static str]) -> FakeChips {
    let lines = names.iter().map(|name| (*name, None)).collect();
    FakeChips {
        chips: vec![(0, FakeChip { lines, ..FakeChip::default() })],
        ..FakeChips::default()
    }
}
