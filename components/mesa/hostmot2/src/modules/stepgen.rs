//! Realtime. Step generators: the card makes the pulses, the driver gives it a rate in each period.

use crate::{
    follow::{self, Actual, Bounds, Chosen},
    link::{Kept, Outgoing},
    making::Making,
    module::{Cycle, Reads, Writes},
    numbers::{low, per_unit, whole},
    plan::{Place, ReadAnswer},
};
use core::sync::atomic::{
    AtomicI64,
    Ordering::{Acquire, Release},
};
use hal_component::{Error, Gives, In, Out, ParamRw, Takes, Touch, Uses, pins};
use hal_firmware::{Module, Tag, registers};

/// Parts of a count in the accumulator.
const PARTS: f64 = 65_536.0;

/// Longest time that a timing register holds, in periods of the clock.
const MOST_TICKS: f64 = 16_383.0;

pins! {
    /// Results of one step generator.
    struct Feedback {
        /// Steps so far.
        counts: Out<i32> = "counts", 0;
        /// Position of the pulses, in units, finer than a step.
        position: Out<f64> = "position-fb", 0.0;
        /// Speed of the pulses, in units per second.
        velocity: Out<f64> = "velocity-fb", 0.0;
    }
}

pins! {
    /// Commands to one step generator.
    struct Commands {
        /// Position to follow, in units, while `control-type` is FALSE. NaN keeps the last one.
        position: In<f64> = "position-cmd", 0.0;
        /// Speed to follow, in units per second, while `control-type` is TRUE. NaN counts as 0.
        velocity: In<f64> = "velocity-cmd", 0.0;
        /// TRUE to make pulses; FALSE stops them at once, whatever the limit of the acceleration is.
        enable: In<bool> = "enable", false;
        /// FALSE to follow a position, TRUE to follow a speed.
        control_type: In<bool> = "control-type", false;
        /// TRUE to hold counts and position at 0.
        position_reset: In<bool> = "position-reset", false;
        /// Steps per unit; 0 counts as 1.
        scale: ParamRw<f64> = "position-scale", 1.0;
        /// Limit of the speed, in units per second; 0 for what the pulses allow.
        maxvel: ParamRw<f64> = "maxvel", 0.0;
        /// Limit of the acceleration, in units per second squared; 0 for none.
        maxaccel: ParamRw<f64> = "maxaccel", 1.0;
    }
}

pins! {
    /// Parts of the speed of a step generator.
    struct Inner {
        /// Speed of the command, in units per second.
        command: Out<f64> = "dbg_ff_vel", 0.0;
        /// Speed of the pulses less that of the command, in units per second.
        error: Out<f64> = "dbg_vel_error", 0.0;
        /// Seconds until both speeds are equal.
        to_match: Out<f64> = "dbg_s_to_match", 0.0;
        /// Distance from the command at that time, in units.
        at_match: Out<f64> = "dbg_err_at_match", 0.0;
        /// Position of the pulses less the command of the period before, in units.
        behind: Out<f64> = "dbg_pos_minus_prev_cmd", 0.0;
        /// Value of the rate register.
        rate: Out<i32> = "dbg_step_rate", 0;
    }
}

/// Position of a generator's pulses in parts of a count.
type Counted = AtomicI64;

/// Half of a generator that reads.
#[derive(Touch)]
struct Counter {
    #[state]
    accumulator: Place,
    #[state]
    last: Option<u32>,
    feedback: Feedback,
    scale: ParamRw<f64>,
    reset: In<bool>,
    counted: Gives<Counted>,
}

impl Counter {
    fn read(&mut self, answer: ReadAnswer<'_>) {
        let now = answer.get(self.accumulator);
        // The accumulator goes round; between two answers it moves less than half of that.
        let moved = now.wrapping_sub(self.last.unwrap_or(now)).cast_signed();
        self.last = Some(now);
        let parts = self.counted.load(Acquire).wrapping_add(i64::from(moved)); // Pairs with this store.
        let parts = if self.reset.get() { 0 } else { parts };
        self.counted.store(parts, Release); // Pairs with Acquire in `write`.
        self.feedback.counts.set(low(parts >> 16));
        self.feedback.position.set(parts as f64 / PARTS / per_unit(self.scale));
    }
}

/// Timing of the pulses: a parameter in nanoseconds and its register.
struct Timing {
    ns: ParamRw<u32>,
    register: Kept,
}

impl Touch for Timing {
    fn touch(&self, uses: &mut Uses) {
        self.ns.touch(uses);
    }
}

impl Timing {
    /// Writes the time, rounded up to periods of the clock, of which a parameter keeps the length.
    fn write(&mut self, to: &mut Outgoing<'_>, clock: f64) -> f64 {
        let ticks = libm::ceil(f64::from(self.ns.get()) * clock * 1e-9 - 1e-6);
        let ticks = if ticks > MOST_TICKS { MOST_TICKS } else { ticks };
        let ns = libm::floor(ticks * 1e9 / clock + 0.5);
        let rounded = whole(ns, u32::MAX);
        if self.ns.get() != rounded {
            self.ns.set(rounded);
        }
        self.register.put(to, whole(ticks, u32::MAX));
        ns
    }
}

/// Half of a generator that writes.
#[derive(Touch)]
struct Generator {
    commands: Commands,
    velocity: Out<f64>,
    inner: Inner,
    /// Step length, step space, setup and hold of the direction.
    timings: [Timing; 4],
    step_type: ParamRw<u32>,
    table: [ParamRw<u32>; 4],
    counted: Takes<Counted>,
    #[state]
    mode: Kept,
    #[state]
    table_register: u16,
    #[state]
    table_length: Kept,
    #[state]
    table_written: Option<([u32; 4], u32)>,
    #[state]
    rate: u16,
    #[state]
    last_command: Option<f64>,
    #[state]
    speed: f64,
}

impl Generator {
    /// Returns the value of the rate register.
    fn rate(&mut self, to: &mut Outgoing<'_>, clock: f64, period: f64) -> i32 {
        let scale = per_unit(self.commands.scale);
        let [length, space, _, _] = self.timings.each_mut().map(|timing| timing.write(to, clock));
        self.put_form(to);
        let most = 1e9 / (length + space).max(1e9 / clock * 2.0) / scale.abs();
        let bounds = self.bounds(most);
        let wish = self.commands.position.get();
        let command = if wish.is_finite() { wish } else { self.last_command.unwrap_or(0.0) };
        let before = self.last_command.unwrap_or(command);
        self.last_command = Some(command);
        let position = self.counted.load(Acquire) as f64 / PARTS / scale; // Pairs with `read`.
        self.inner.behind.set(position - before);
        if !self.commands.enable.get() {
            self.show(Chosen::default());
            return 0;
        }
        let actual = Actual { position, speed: self.speed };
        let chosen = if self.commands.control_type.get() {
            let wish = self.commands.velocity.get();
            let wish = if wish.is_finite() { wish } else { 0.0 };
            Chosen {
                speed: follow::velocity(self.speed, wish, bounds, period),
                ..Chosen::default()
            }
        } else {
            follow::position(actual, [command, before], bounds, period)
        };
        self.show(chosen);
        rounded(chosen.speed * scale * 4_294_967_296.0 / clock)
    }

    /// Writes the form of the pulses, with its table.
    fn put_form(&mut self, to: &mut Outgoing<'_>) {
        let form = self.step_type.get();
        self.mode.put(to, form.min(3));
        if form < 3 {
            return;
        }
        let table = self.table.map(|words| words.get());
        let length = (form - 1).min(15);
        self.table_length.put(to, length);
        if self.table_written != Some((table, to.renewal())) {
            self.table_written = Some((table, to.renewal()));
            for byte in table.iter().flat_map(|word| word.to_le_bytes()) {
                // The card counts the bytes itself.
                to.put_again(self.table_register, u32::from(byte));
            }
        }
    }

    fn show(&mut self, chosen: Chosen) {
        self.speed = chosen.speed;
        self.velocity.set(chosen.speed);
        self.inner.command.set(chosen.command);
        self.inner.error.set(chosen.error);
        self.inner.to_match.set(chosen.to_match);
        self.inner.at_match.set(chosen.at_match);
    }

    /// Returns the limits; corrects negative ones.
    fn bounds(&self, most: f64) -> Bounds {
        let limit = |pin: ParamRw<f64>| {
            let value = pin.get();
            if value >= 0.0 {
                return value;
            }
            pin.set(0.0);
            0.0
        };
        let (speed, acceleration) = (limit(self.commands.maxvel), limit(self.commands.maxaccel));
        let speed = if speed > 0.0 && speed < most { speed } else { most };
        Bounds { speed, acceleration: if acceleration.is_finite() { acceleration } else { 0.0 } }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "the conversion saturates")]
fn rounded(rate: f64) -> i32 {
    rate as i32
}

/// Function half that reads.
#[derive(Touch)]
struct Counters {
    counters: Vec<Counter>,
}

impl Reads for Counters {
    fn read(&mut self, answer: ReadAnswer<'_>, _: Cycle, _: bool) {
        for counter in &mut self.counters {
            counter.read(answer);
        }
    }
}

/// Function half that writes.
#[derive(Touch)]
struct Generators {
    generators: Vec<Generator>,
    #[state]
    clock: f64,
    #[state]
    master: Kept,
    timer: Option<(In<i32>, TimerRegister)>,
}

/// Register that selects the timer which latches the positions.
struct TimerRegister(Kept);

impl Touch for TimerRegister {
    fn touch(&self, _: &mut Uses) {}
}

impl Writes for Generators {
    fn write(&mut self, to: &mut Outgoing<'_>, cycle: Cycle) {
        self.master.put(to, u32::MAX);
        if let Some((timer, register)) = &mut self.timer {
            register.0.put(to, super::timer(*timer));
        }
        for generator in &mut self.generators {
            let rate = generator.rate(to, self.clock, cycle.period);
            generator.inner.rate.set(rate);
            to.put(generator.rate, rate.cast_unsigned());
        }
    }
}

/// Creates the pins of all step generators.
pub(crate) fn make(m: &mut Making<'_, '_>) -> Result<(), Error> {
    let Some((module, used)) = m.module(Tag::StepGenerator) else { return Ok(()) };
    let clock = m.clock(&module)?;
    let (mut counters, mut generators) = (Vec::new(), Vec::new());
    for instance in 0..used {
        let (counter, generator) = generator(m, &module, clock, instance)?;
        counters.push(counter);
        generators.push(generator);
    }
    let master = Kept::new(m.address(&module, registers::STEP_MASTER_RATE, 0)?);
    let timer = match m.timer(&module, registers::STEP_TIMER) {
        Some(at) => {
            let name = m.at("stepgen.timer-number");
            Some((m.b.item(&name, super::TIMER, -1)?, TimerRegister(Kept::new(at))))
        }
        None => None,
    };
    m.reads.push(Box::new(Counters { counters }));
    m.writes.push(Box::new(Generators { generators, clock, master, timer }));
    Ok(())
}

fn generator(
    m: &mut Making<'_, '_>,
    module: &Module,
    clock: f64,
    instance: u8,
) -> Result<(Counter, Generator), Error> {
    let name = m.at(&format!("stepgen.{instance:02}"));
    let feedback = Feedback::make(m.b, &name)?;
    let commands = Commands::make(m.b, &name)?;
    let inner = Inner::make(m.b, &name)?;
    let mut timing = |pin: &str, about: &str, register| -> Result<Timing, Error> {
        let register = Kept::new(m.address(module, register, instance)?);
        let about = format!(
            "{about}, in nanoseconds: rounded up to periods of the card's clock, at most 16383 of them"
        );
        let most = whole(MOST_TICKS * 1e9 / clock + 0.5, u32::MAX);
        Ok(Timing { ns: m.b.item(&format!("{name}.{pin}"), &about, most)?, register })
    };
    let timings = [
        timing("steplen", "Time that a step lasts", registers::STEP_LENGTH)?,
        timing("stepspace", "Least time between two steps", registers::STEP_SPACE)?,
        timing("dirsetup", "Time from a change of direction to a step", registers::STEP_SETUP)?,
        timing("dirhold", "Time from a step to a change of direction", registers::STEP_HOLD)?,
    ];
    let about = "Form of the pulses: 0 step and direction, 1 up and down, 2 quadrature, 3 and above a \
        table of that length";
    let step_type = m.b.item(&format!("{name}.step_type"), about, 0)?;
    let mut table = |n: u32| -> Result<ParamRw<u32>, Error> {
        let about = "Four bytes of the table of levels, for step_type 3 and above; bit 0 is the first I/O pin";
        m.b.item(&format!("{name}.table-data-{n}"), about, 0)
    };
    let table = [table(0)?, table(1)?, table(2)?, table(3)?];
    let (gives, takes) = m.b.shared(Counted::new(0));
    let counter = Counter {
        accumulator: m.read(module, registers::STEP_ACCUMULATOR, instance)?,
        last: None,
        scale: commands.scale,
        reset: commands.position_reset,
        counted: gives,
        feedback: feedback.clone(),
    };
    let generator = Generator {
        commands,
        velocity: feedback.velocity,
        inner,
        timings,
        step_type,
        table,
        counted: takes,
        mode: Kept::new(m.address(module, registers::STEP_MODE, instance)?),
        table_register: m.address(module, registers::STEP_TABLE_DATA, instance)?,
        table_length: Kept::new(m.address(module, registers::STEP_TABLE_LENGTH, instance)?),
        table_written: None,
        rate: m.address(module, registers::STEP_RATE, instance)?,
        last_command: None,
        speed: 0.0,
    };
    Ok((counter, generator))
}
