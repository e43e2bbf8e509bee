//! Realtime. The card's clock, which follows the thread's reads and latches positions at a stated time before them.

use crate::{
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Reads, Writes},
    numbers::whole,
    plan::{Place, ReadAnswer},
};
use hal_component::{Error, In, Out, Touch, pins};
use hal_firmware::{Tag, registers};

/// Parts of a period in a timer's register.
const PARTS: f64 = 65_536.0;

/// Rate that the divisor of the clock approaches from below.
const FINE: f64 = 1_073_741_824.0;

/// Parts of a period in the phase register.
const PHASE_PARTS: f64 = 4_294_967_296.0;

pins! {
    /// The clock's pins.
    struct Clock {
        /// Time of timer 1 from the read, in microseconds: negative before it.
        timer_1: In<f64> = "01.timer-us", 100.0;
        /// Time of timer 2 from the read, in microseconds: negative before it.
        timer_2: In<f64> = "02.timer-us", 100.0;
        /// Time of timer 3 from the read, in microseconds: negative before it.
        timer_3: In<f64> = "03.timer-us", 100.0;
        /// Time of timer 4 from the read, in microseconds: negative before it.
        timer_4: In<f64> = "04.timer-us", 100.0;
        /// Frequency of the clock, in thousands of hertz; 0 and below for that of the thread.
        base_freq: In<f64> = "base-freq-khz", -1.0;
        /// Phase of the last read, in microseconds.
        phase_error: Out<f64> = "phase-error-us", 0.0;
        /// Time constant of the filter, in the card's units; 0 to 65535.
        time_const: In<u32> = "time-const", 2000;
        /// Limit of the change of the clock, in the card's units; 0 for none, 0 to 2^24 - 1.
        plimit: In<u32> = "plimit", 0x0040_0000;
        /// Number of bits of the card's phase.
        ddsize: Out<u32> = "ddsize", 0;
        /// Divisor of the clock of the phase; 1 to 255.
        prescale: Out<u32> = "prescale", 1;
    }
}

/// Function half that reads.
#[derive(Touch)]
struct ClockPhase {
    base_freq: In<f64>,
    phase_error: Out<f64>,
    ddsize: Out<u32>,
    #[state]
    phase: Place,
    #[state]
    control: Place,
}

impl Reads for ClockPhase {
    fn read(&mut self, answer: ReadAnswer<'_>, cycle: Cycle, _: bool) {
        let [size, _, _, _] = answer.get(self.control).to_le_bytes();
        self.ddsize.set(u32::from(size));
        let periods = f64::from(answer.get(self.phase).cast_signed()) / PHASE_PARTS;
        self.phase_error.set(periods * 1000.0 / frequency(self.base_freq, cycle));
    }
}

/// Returns the frequency in kilohertz.
fn frequency(pin: In<f64>, cycle: Cycle) -> f64 {
    let khz = pin.get();
    if khz > 0.0 && khz.is_finite() { khz } else { 0.001 / cycle.period }
}

/// Function half that writes.
#[derive(Touch)]
struct Following {
    pins: Clock,
    #[state]
    hz: f64,
    #[state]
    base_rate: Kept,
    #[state]
    control_0: Kept,
    #[state]
    control_1: Kept,
    #[state]
    timers_12: Kept,
    #[state]
    timers_34: Kept,
}

impl Writes for Following {
    fn write(&mut self, to: &mut Outgoing<'_>, cycle: Cycle) {
        let p = &self.pins;
        let khz = frequency(p.base_freq, cycle);
        let size = match p.ddsize.get() {
            0 => 1,
            size => size.min(62),
        };
        let span = libm::scalbn(1.0, i32::try_from(size).unwrap_or(42));
        let rate = span * khz * 1000.0 / self.hz;
        // A divisor of the clock keeps the rate large and thereby fine.
        let prescale = whole(FINE / rate, 255).max(1);
        p.prescale.set(prescale);
        self.base_rate.put(to, whole(rate * f64::from(prescale), u32::MAX));
        self.control_0.put(to, prescale << 24 | p.plimit.get().min(0x00FF_FFFF));
        self.control_1.put(to, p.time_const.get().min(0xFFFF) << 16);
        let timer = |us: In<f64>| saturated_half(-us.get() * khz / 1000.0 * PARTS);
        self.timers_12.put(to, timer(p.timer_2) << 16 | timer(p.timer_1));
        self.timers_34.put(to, timer(p.timer_4) << 16 | timer(p.timer_3));
    }
}

/// Returns a signed number of 16 bits.
#[expect(clippy::cast_possible_truncation, reason = "the conversion saturates")]
fn saturated_half(x: f64) -> u32 {
    u32::from((x as i16).cast_unsigned())
}

/// Creates the pins of the clock.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, _)) = m.module(Tag::Dpll) else { return Ok(()) };
    let pins = Clock::make(m.b, &m.at("dpll"))?;
    let phase = ClockPhase {
        base_freq: pins.base_freq,
        phase_error: pins.phase_error,
        ddsize: pins.ddsize,
        // Reading this register is the moment that the clock follows.
        phase: m.read(&module, registers::DPLL_SYNC, 0)?,
        control: m.read(&module, registers::DPLL_CONTROL_1, 0)?,
    };
    let kept = |register| m.address(&module, register, 0).map(Kept::new);
    let following = Following {
        pins,
        hz: m.clock(&module)?,
        base_rate: kept(registers::DPLL_BASE_RATE)?,
        control_0: kept(registers::DPLL_CONTROL_0)?,
        control_1: kept(registers::DPLL_CONTROL_1)?,
        timers_12: kept(registers::DPLL_TIMERS_12)?,
        timers_34: kept(registers::DPLL_TIMERS_34)?,
    };
    m.reads.push(Box::new(phase));
    m.writes.push(Box::new(following));
    Ok(())
}
