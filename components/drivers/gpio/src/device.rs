//! Realtime. Requested lines, real or simulated, with the levels last written to them.

use crate::{
    chips::{self, Chips, Requested},
    config::GpioConfig,
    refused::Refused,
    request::{FoundLine, LineRequest, plan},
};
use core::sync::atomic::{
    AtomicI64, AtomicU32, AtomicU64,
    Ordering::{Acquire, Relaxed, Release},
};
use hal_component::{Builder, Error, lasting};
use port::{LinePins, Lines, Lost, SimulatedChip, SimulatedLine};
use std::sync::OnceLock;

/// Lines of a load.
pub(crate) struct Device {
    config: GpioConfig,
    /// Empty until the lines are opened.
    open: OnceLock<Vec<LineGroup>>,
}

/// Lines that are accessed together.
pub(crate) struct LineGroup {
    pub(crate) lines: Box<dyn Lines>,
    /// Bits of the inputs whose levels are read, and of the outputs.
    pub(crate) inputs: u64,
    pub(crate) outputs: u64,
    /// Place of each line in the list of all lines, by its bit.
    pub(crate) places: Vec<usize>,
    /// Number of the encoder whose edges these lines are.
    pub(crate) encoder: Option<usize>,
    /// Levels of the encoder's lines when they were requested.
    pub(crate) initial: u64,
    /// Levels last written.
    pub(crate) written: AtomicU64,
    /// Messages about a chip that does not answer, with its inputs and with its outputs.
    pub(crate) inputs_failed: ChipMessages,
    pub(crate) outputs_failed: ChipMessages,
}

/// Messages about a chip that does not answer; each names its lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChipMessages {
    /// Message about a chip that is gone.
    pub(crate) gone: &'static str,
    /// Message about another error, whose number stands in place of `{}`.
    pub(crate) other: &'static str,
}

/// Time of the last write, and functions that a chip did not answer; shared by all functions.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub(crate) at_ns: AtomicI64,
    /// A bit for each function.
    faults: AtomicU32,
}

impl Written {
    /// Records whether the chips have answered the function of this bit. Returns whether any function has a fault.
    pub(crate) fn note(&self, function: u32, is_fault: bool) -> bool {
        // Lone flags: nothing else is published with them.
        let before = if is_fault {
            self.faults.fetch_or(function, Relaxed)
        } else {
            self.faults.fetch_and(!function, Relaxed)
        };
        is_fault || before & !function != 0
    }
}

impl Device {
    pub(crate) const fn new(config: GpioConfig) -> Self {
        Self { config, open: OnceLock::new() }
    }

    pub(crate) const fn config(&self) -> &GpioConfig {
        &self.config
    }

    /// Returns the lines that are accessed together; none before the lines are opened.
    pub(crate) fn groups(&self) -> &[LineGroup] {
        self.open.get().map_or(&[], Vec::as_slice)
    }

    /// Makes simulated lines. Returns the pins that reading reads, and those that writing sets.
    pub(crate) fn simulate(
        &self,
        b: &mut Builder<'_>,
        prefix: &str,
    ) -> Result<[Vec<LinePins>; 2], Error> {
        let found: Vec<FoundLine> = (0..)
            .zip(&self.config.lines)
            .map(|(offset, line)| FoundLine { chip: 0, offset, setting: line.setting })
            .collect();
        let chip = SimulatedChip::new(b, &format!("{prefix}.sim"))?;
        let (mut groups, mut read, mut written) = (Vec::new(), Vec::new(), Vec::new());
        for request in plan(&found, &self.config.encoders) {
            let named = |index: &usize| {
                let line = self.config.lines.get(*index)?;
                Some(SimulatedLine {
                    name: line.name.as_str(),
                    is_output: line.setting.is_output,
                    is_active_low: line.setting.is_active_low,
                    debounce_ns: i64::from(line.setting.debounce_us) * 1000,
                })
            };
            let lines: Vec<SimulatedLine<'_>> = request.lines.iter().filter_map(named).collect();
            let lines = chip.lines(b, &lines)?;
            read.push(lines.read_from());
            written.push(lines.written());
            groups.push(self.group(request, Box::new(lines), groups.len(), "the simulated chip"));
        }
        drop(self.open.set(groups));
        Ok([read, written])
    }

    /// Requests the lines from the kernel, unless they are simulated.
    pub(crate) fn open(&self, chips: &dyn Chips) -> Result<(), Refused> {
        if self.open.get().is_some() {
            return Ok(());
        }
        let requested = chips::open(chips, &self.config.lines, &self.config.encoders)?;
        let groups = (0..).zip(requested).map(|(number, Requested { request, lines })| {
            let chip = format!("gpiochip{}", request.chip);
            self.group(request, lines, number, &chip)
        });
        // A second opening keeps the first.
        drop(self.open.set(groups.collect()));
        Ok(())
    }

    /// Returns a group of lines, ready for use.
    fn group(
        &self,
        request: LineRequest,
        lines: Box<dyn Lines>,
        number: usize,
        chip: &str,
    ) -> LineGroup {
        // A chip that is gone already is reported by the first run.
        let edges = request.mask(|s| s.has_edges);
        let initial = if edges == 0 { 0 } else { lines.read(edges).unwrap_or(0) };
        LineGroup {
            initial,
            inputs: request.mask(|s| !s.is_output && !s.has_edges),
            outputs: request.mask(|s| s.is_output),
            written: AtomicU64::new(0),
            inputs_failed: self.messages(&request, chip, false),
            outputs_failed: self.messages(&request, chip, true),
            encoder: (number < self.config.encoders.len()).then_some(number),
            places: request.lines,
            lines,
        }
    }

    /// Returns the messages about a chip that does not answer, with its inputs or outputs. They live as long as the process,
    /// since messages do.
    fn messages(&self, request: &LineRequest, chip: &str, outputs: bool) -> ChipMessages {
        /// Number of lines that a message names.
        const NAMED: usize = 16;
        let lines = request.lines.iter().filter_map(|index| self.config.lines.get(*index));
        let names: Vec<&str> = lines
            .filter(|line| line.setting.is_output == outputs)
            .map(|line| line.name.as_str())
            .collect();
        let mut list = names.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
        if names.len() > NAMED {
            list.push_str(&format!(" and {} more", names.len() - NAMED));
        }
        // Braces mark pins and numbers in messages.
        let list = list.replace('{', "(").replace('}', ")");
        let (gone, other) = if outputs {
            (
                format!("nothing drives its outputs {list}"),
                format!("when writing its outputs {list}: it is tried again"),
            )
        } else if request.mask(|setting| setting.has_edges) != 0 {
            (
                format!("nothing counts the edges of {list}"),
                format!("when reading the edges of {list}: counts keep their values"),
            )
        } else {
            (
                format!("its inputs {list} keep their values"),
                format!("when reading its inputs {list}: they keep their values"),
            )
        };
        let gone = format!("{chip} is gone: {gone}; load the machine again when it is back");
        let other = format!("{chip}: error {{}} {other}");
        ChipMessages { gone: lasting(gone), other: lasting(other) }
    }

    /// Makes all outputs inactive. Every group is tried.
    pub(crate) fn rest(&self) -> Result<(), Lost> {
        let mut done = Ok(());
        for group in self.groups().iter().filter(|group| group.outputs != 0) {
            done = done.and(group.put(0));
        }
        done
    }
}

impl LineGroup {
    /// Writes the levels of all outputs.
    pub(crate) fn put(&self, levels: u64) -> Result<(), Lost> {
        self.written.store(levels, Release); // Pairs with `last`.
        self.lines.write(levels, self.outputs)
    }

    /// Returns the levels last written.
    pub(crate) fn last(&self) -> u64 {
        self.written.load(Acquire) // Pairs with `put`.
    }
}

impl Drop for Device {
    /// Makes the outputs inactive before the kernel releases them.
    fn drop(&mut self) {
        // A lost chip can no longer be reported. Simulated lines have nothing to rest.
        let _ = self.rest();
    }
}
