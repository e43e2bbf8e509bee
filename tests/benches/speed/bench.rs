//! Library that drives and times components in their own thread.

use hal_component::{
    Arg, Builder, Component, Error, Out, ParamRw, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};
use hal_tests::random::Random;
use std::{
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
    time::Instant,
};

/// Number of values of each type to choose from.
pub(crate) const BANK: u8 = 16;

/// Maximum number of marks in a cycle.
pub(crate) const MARKS: usize = 64;

/// Random values in every cycle.
pub(crate) const CHANCE: u32 = 0;
/// Bits are true, numbers rise and fall.
pub(crate) const ALL_TRUE: u32 = 1;
/// Bits are false, except enables; numbers rise and fall.
pub(crate) const ENABLED: u32 = 2;

hal_component::export!(Drive, Mark, Nothing);

/// Source of values that change in every cycle.
#[derive(Component)]
pub(crate) struct Drive {
    /// Style of the changes.
    style: ParamRw<u32>,
    /// Bits.
    #[hal(name = "bit-##", count = BANK)]
    bit: Vec<Out<bool>>,
    /// Bits for enable inputs.
    #[hal(name = "enable-##", count = BANK)]
    enable: Vec<Out<bool>>,
    /// Numbers of different magnitudes.
    #[hal(name = "float-##", count = BANK)]
    float: Vec<Out<f64>>,
    /// Small numbers.
    #[hal(name = "s32-##", count = BANK)]
    s32: Vec<Out<i32>>,
    /// Small numbers.
    #[hal(name = "u32-##", count = BANK)]
    u32: Vec<Out<u32>>,
    /// Small numbers.
    #[hal(name = "s64-##", count = BANK)]
    s64: Vec<Out<i64>>,
    /// Small numbers.
    #[hal(name = "u64-##", count = BANK)]
    u64: Vec<Out<u64>>,
    #[state]
    chance: Chance,
    #[state]
    cycle: u64,
}

#[derive(Debug)]
struct Chance(Random);

impl Default for Chance {
    fn default() -> Self {
        Self(Random::new(6))
    }
}

/// Magnitudes of numbers, each for some of the bank.
const SIZES: [f64; 4] = [1.0, 0.1, 10.0, 1000.0];

impl Update for Drive {
    fn update(&mut self, _: Period) {
        let (style, r) = (self.style.get(), &mut self.chance.0);
        self.cycle = self.cycle.wrapping_add(1);
        let (ramp, steady) = ((self.cycle % 400) as f64 / 200.0 - 1.0, style != CHANCE);
        for i in 0..usize::from(BANK) {
            let by_chance = r.word();
            self.bit[i].set(if steady { style == ALL_TRUE } else { by_chance & 1 != 0 });
            self.enable[i].set(steady || by_chance & 2 != 0);
            let at = if steady { (ramp + i as f64 / 8.0) % 1.0 } else { r.unit() };
            self.float[i].set(at * SIZES[i % SIZES.len()]);
            let number = if steady { self.cycle / 100 + i as u64 } else { by_chance >> 8 };
            let (small, sign) = ((number % 16) as u32, if by_chance & 4 == 0 { 1 } else { -1 });
            self.u32[i].set(small);
            self.u64[i].set(u64::from(small));
            let signed = small.cast_signed() * if steady { 1 } else { sign };
            self.s32[i].set(signed);
            self.s64[i].set(signed.into());
        }
    }
}

static TOTAL: [AtomicU64; MARKS] = [const { AtomicU64::new(0) }; MARKS];
static LAST: AtomicU64 = AtomicU64::new(0);

/// Sums of the time since the previous mark.
pub(crate) enum Mark {}

impl Component for Mark {
    const NAME: &'static str = "mark";
    const DOC: &'static str = "Times what runs between two marks.";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::int("n", "How many.").required()];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = usize::try_from(b.arg_int("n").unwrap_or(0)).unwrap_or(0).min(MARKS);
        (0..n).try_for_each(|i| b.function(&format!("mark.{i}"), "Notes the time.", At { i }))
    }
}

#[derive(Touch)]
struct At {
    #[state]
    i: usize,
}

impl Update for At {
    fn update(&mut self, _: Period) {
        let now = now();
        let before = LAST.load(Relaxed);
        LAST.store(now, Relaxed);
        let total = TOTAL[self.i].load(Relaxed);
        TOTAL[self.i].store(total + now.saturating_sub(before), Relaxed);
    }
}

fn now() -> u64 {
    static ORIGIN: OnceLock<Instant> = OnceLock::new();
    u64::try_from(ORIGIN.get_or_init(Instant::now).elapsed().as_nanos()).unwrap()
}

/// Returns the sums, in nanoseconds, and resets them.
pub(crate) fn totals() -> Vec<u64> {
    TOTAL.iter().map(|t| t.swap(0, Relaxed)).collect()
}

/// A function that does nothing.
#[derive(Component)]
pub(crate) struct Nothing {}

impl Update for Nothing {
    fn update(&mut self, _: Period) {}
}
