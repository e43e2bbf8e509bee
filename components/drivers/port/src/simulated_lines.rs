//! Realtime. Simulated lines, each of which is a pin.

use crate::{LineEdge, Lines, Lost};
use core::sync::atomic::{
    AtomicI64, AtomicU32, AtomicU64,
    Ordering::{Acquire, Relaxed, Release},
};
use hal_component::{Builder, Clock, Error, In, Out, Touch, Uses};

/// Largest number of lines that are requested together.
const MOST: usize = 64;

/// Pins that all lines of a driver share.
#[derive(Clone, Debug)]
pub struct SimulatedChip {
    prefix: String,
    vanished: In<bool>,
    clock: Clock,
}

/// Simulated line, as it is declared.
#[derive(Clone, Copy, Debug)]
pub struct SimulatedLine<'n> {
    /// Name of its pin.
    pub name: &'n str,
    /// True if the driver drives it, false if the pin does.
    pub is_output: bool,
    /// True if the line is active when it is low.
    pub is_active_low: bool,
    /// Nanoseconds for which a new level must last before it counts.
    pub debounce_ns: i64,
}

/// Lines in memory. The pin of a line is the level on its wire: TRUE is high, also for a line that is active low.
#[derive(Debug)]
pub struct SimulatedLines {
    chip: SimulatedChip,
    pins: LinePins,
    active_low: u64,
    debounce_ns: Vec<i64>,
    /// Levels that have lasted, as last read.
    settled: AtomicU64,
    /// Time since which a line has had another level than the settled one, or [`STEADY`].
    changed: Vec<AtomicI64>,
    /// Levels whose edges were taken.
    taken: AtomicU64,
    edges: AtomicU32,
}

/// Value of `changed` for a line that has its settled level.
const STEADY: i64 = i64::MIN;

/// Pins of simulated lines, for the functions that access them.
#[derive(Clone, Debug)]
pub struct LinePins {
    vanished: In<bool>,
    driven: Vec<(u8, In<bool>)>,
    shown: Vec<(u8, Out<bool>)>,
}

impl SimulatedChip {
    /// Makes `PREFIX.vanished`, which makes every access fail as if the chip had been removed.
    ///
    /// # Errors
    /// Same as [`Builder::item`].
    pub fn new(b: &mut Builder<'_>, prefix: &str) -> Result<Self, Error> {
        let name = format!("{prefix}.vanished");
        let about = "TRUE makes every access fail as if the chip had been removed";
        let vanished = b.simulated(&name, about, false)?;
        Ok(Self { prefix: prefix.to_owned(), vanished, clock: b.clock() })
    }

    /// Makes lines that are requested together, at most 64, with a pin `PREFIX.NAME` each.
    ///
    /// # Errors
    /// Same as [`Builder::item`], or there are too many lines.
    pub fn lines(
        &self,
        b: &mut Builder<'_>,
        lines: &[SimulatedLine<'_>],
    ) -> Result<SimulatedLines, Error> {
        if lines.len() > MOST {
            return Err(Error::new("at most 64 lines can be requested together"));
        }
        let mut pins = LinePins { vanished: self.vanished, driven: Vec::new(), shown: Vec::new() };
        let mut active_low = 0;
        for (bit, line) in (0..).zip(lines) {
            let name = format!("{}.{}", self.prefix, line.name);
            if line.is_output {
                let about = "Level on the wire that the driver drives: TRUE is high";
                // Requested outputs are inactive.
                let initial = line.is_active_low;
                pins.shown.push((bit, b.simulated(&name, about, initial)?));
            } else {
                let about = "Level on the wire that the driver reads: TRUE is high";
                pins.driven.push((bit, b.simulated(&name, about, false)?));
            }
            active_low |= if line.is_active_low { 1 << bit } else { 0 };
        }
        Ok(SimulatedLines {
            chip: self.clone(),
            pins,
            active_low,
            debounce_ns: lines.iter().map(|line| line.debounce_ns).collect(),
            // All wires begin low.
            settled: AtomicU64::new(active_low),
            changed: lines.iter().map(|_| AtomicI64::new(STEADY)).collect(),
            taken: AtomicU64::new(active_low),
            edges: AtomicU32::new(0),
        })
    }
}

impl SimulatedLines {
    /// Returns the pins that reading the lines reads.
    #[must_use]
    pub fn read_from(&self) -> LinePins {
        LinePins { shown: Vec::new(), ..self.pins.clone() }
    }

    /// Returns the pins that writing the lines sets.
    #[must_use]
    pub fn written(&self) -> LinePins {
        LinePins { driven: Vec::new(), ..self.pins.clone() }
    }

    fn answer(&self) -> Result<(), Lost> {
        if self.chip.vanished.get() { Err(Lost::GONE) } else { Ok(()) }
    }

    /// Returns the levels of the inputs that have lasted for their debounce times.
    fn settle(&self) -> u64 {
        let now = self.chip.clock.now_ns();
        let mut settled = self.settled.load(Acquire); // Pairs with the store below.
        for (bit, pin) in &self.pins.driven {
            let index = usize::from(*bit);
            let (Some(changed), Some(debounce)) =
                (self.changed.get(index), self.debounce_ns.get(index))
            else {
                continue;
            };
            let one = 1 << bit;
            let active = pin.get() != (self.active_low & one != 0);
            if active == (settled & one != 0) {
                changed.store(STEADY, Relaxed); // One function reads the lines.
                continue;
            }
            let since = match changed.load(Relaxed) {
                STEADY => now,
                since => since,
            };
            changed.store(since, Relaxed);
            if now.wrapping_sub(since) >= *debounce {
                settled ^= one;
                changed.store(STEADY, Relaxed);
            }
        }
        self.settled.store(settled, Release); // Pairs with the load above.
        settled
    }
}

impl Lines for SimulatedLines {
    fn read(&self, mask: u64) -> Result<u64, Lost> {
        self.answer()?;
        Ok(self.settle() & mask)
    }

    fn write(&self, levels: u64, mask: u64) -> Result<(), Lost> {
        self.answer()?;
        for (bit, pin) in &self.pins.shown {
            let one = 1 << bit;
            if mask & one != 0 {
                pin.set((levels ^ self.active_low) & one != 0);
            }
        }
        Ok(())
    }

    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost> {
        self.answer()?;
        let settled = self.settle();
        let mut taken = self.taken.load(Acquire); // Pairs with the store below.
        let at_ns = u64::try_from(self.chip.clock.now_ns()).unwrap_or(0);
        let (waiting, mut count) = (settled ^ taken, 0);
        let lines = self.pins.driven.iter().filter(|(bit, _)| waiting >> bit & 1 != 0);
        for ((bit, _), edge) in lines.zip(room) {
            taken ^= 1 << bit;
            let number = self.edges.fetch_add(1, Relaxed).wrapping_add(1);
            *edge = LineEdge { at_ns, number, bit: *bit, is_rising: settled >> bit & 1 != 0 };
            count += 1;
        }
        self.taken.store(taken, Release); // Pairs with the load above.
        Ok(count)
    }
}

impl Touch for LinePins {
    fn touch(&self, uses: &mut Uses) {
        self.vanished.touch(uses);
        self.driven.iter().for_each(|(_, pin)| pin.touch(uses));
        self.shown.iter().for_each(|(_, pin)| pin.touch(uses));
    }
}
