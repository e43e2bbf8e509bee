//! Realtime. The function: it shows the state of the devices, and decides what a lost one means.
//!
//! While a device is lost, nothing of it is held. What was held when it came back has no effect until it was let go.

use crate::{
    bus::{HeldState, KEY_WORDS},
    described::WheelKind,
    pins::{AxisPins, DevicePins, WheelPins},
    reader::{DeviceRecord, UNKNOWN},
};
use hal_component::{
    Clock, Gives, Hardware, Messages, Period, SeqReader, StillWatch, Takes, Touch, Update, divisor,
    to_s32,
};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Time without a step of the worker after which all devices are lost, in nanoseconds.
pub(crate) const DEAD_NS: i64 = 250_000_000;
/// Position beyond which an axis is on one side, as in LinuxCNC.
const SIDE: f64 = 0.01;
/// Part of its range in which an axis that came back is at its centre.
const NEAR: i64 = 32;

/// The function, or the background task.
#[derive(Debug, Touch)]
pub(crate) struct Show {
    pub(crate) devices: Vec<ShownDevice>,
    /// Number of steps of the worker.
    pub(crate) steps: Takes<AtomicU32>,
    pub(crate) clock: Clock,
    pub(crate) messages: Messages,
    #[state]
    pub(crate) worker: StillWatch,
    #[state]
    pub(crate) is_dead: bool,
}

/// Device with its pins.
#[derive(Debug, Touch)]
pub(crate) struct ShownDevice {
    pins: DevicePins,
    record: SeqReader<DeviceRecord>,
    /// Bits of the lights that are to be on.
    lights: Gives<AtomicU32>,
    hardware: Hardware,
    #[state]
    was: WasShown,
}

/// State of a device that was shown last.
#[derive(Debug)]
struct WasShown {
    /// Number of the opening that was seen last; 0 before the first.
    opened: u32,
    is_there: bool,
    /// Bits of the keys that have no effect until they are released.
    blocked: [u64; KEY_WORDS],
    axes: Vec<WasAxis>,
    wheels: Vec<WasWheel>,
}

/// Last counts of an axis, and whether it has no effect until it was at its centre.
#[derive(Clone, Copy, Debug)]
struct WasAxis {
    counts: i32,
    is_blocked: bool,
}

/// Sum of a wheel at its last reset, and whether a ring has no effect until it was at 0.
#[derive(Clone, Copy, Debug, Default)]
struct WasWheel {
    base: i32,
    is_blocked: bool,
}

impl Update for Show {
    fn update(&mut self, _: Period) {
        let still_ns = self.worker.still_ns(self.steps.load(Relaxed), self.clock.now_ns());
        let is_dead = still_ns > DEAD_NS;
        if is_dead && !self.is_dead {
            const TEXT: &str = "the worker of hal_input does not work: all buttons are FALSE, all axes at \
                                their centres";
            self.messages.error(TEXT, &[]);
        }
        self.is_dead = is_dead;
        for device in &mut self.devices {
            device.update(is_dead);
        }
    }
}

impl ShownDevice {
    /// Returns a device of which nothing was shown yet. What is held at `since` has no effect; without it, what is held in
    /// the first run.
    pub(crate) fn new(
        pins: DevicePins,
        record: SeqReader<DeviceRecord>,
        lights: Gives<AtomicU32>,
        hardware: Hardware,
        since: Option<&DeviceRecord>,
    ) -> Self {
        let begin = |axis: &AxisPins| WasAxis { counts: axis.centre(), is_blocked: false };
        let was = WasShown {
            opened: since.map_or(0, |record| record.opened),
            is_there: since.is_some(),
            blocked: since.map_or([0; KEY_WORDS], |record| record.keys),
            axes: pins.axes.iter().map(begin).collect(),
            wheels: vec![WasWheel::default(); pins.wheels.len()],
        };
        Self { pins, record, lights, hardware, was }
    }

    fn update(&mut self, is_dead: bool) {
        let record = self.record.get();
        let is_there = record.connected && !is_dead;
        let has_come = is_there && (!self.was.is_there || self.was.opened != record.opened);
        if has_come {
            self.block(&record);
        }
        self.was.is_there = is_there;
        self.pins.state.connected.set(is_there);
        self.pins.state.fault.set(!is_there);
        self.hardware.note(!is_there && self.pins.state.required.get());
        for (blocked, down) in self.was.blocked.iter_mut().zip(&record.keys) {
            *blocked &= down;
        }
        let none = HeldState::REST.keys;
        let keys = if is_there { &record.keys } else { &none };
        for key in &self.pins.keys {
            let (word, bit) = (usize::from(key.code / 64), key.code % 64);
            let of = |words: &[u64; KEY_WORDS]| words.get(word).is_some_and(|w| w >> bit & 1 != 0);
            let is_down = of(keys) && !of(&self.was.blocked);
            key.is_down.set(is_down);
            key.not.set(!is_down);
        }
        for (axis, was) in self.pins.axes.iter().zip(&mut self.was.axes) {
            let value = record.abs.get(usize::from(axis.code)).copied().filter(|_| is_there);
            axis.show(value, was);
        }
        for (wheel, was) in self.pins.wheels.iter().zip(&mut self.was.wheels) {
            let value = record.rel.get(usize::from(wheel.code)).copied().unwrap_or(0);
            wheel.show(value, is_there, was);
        }
        let mut lights = 0;
        for light in &self.pins.lights {
            let is_on = light.is_on.get() != light.invert.get();
            lights |= u32::from(is_on) << (light.code % 32);
        }
        self.lights.store(lights, Relaxed);
    }

    /// Blocks keys, axes and rings that are held as the device comes. Axes have their values from the first moment of a load.
    fn block(&mut self, record: &DeviceRecord) {
        let is_back = self.was.opened != 0;
        self.was.opened = record.opened;
        self.was.blocked = record.keys;
        self.was.axes.iter_mut().for_each(|axis| axis.is_blocked = is_back);
        self.was.wheels.iter_mut().for_each(|wheel| wheel.is_blocked = is_back);
    }
}

impl AxisPins {
    /// Returns the counts at the centre.
    fn centre(&self) -> i32 {
        to_s32(self.offset.get())
    }

    /// Shows a value of the device; none without it.
    fn show(&self, value: Option<i32>, was: &mut WasAxis) {
        let centre = self.centre();
        let counts = value.map_or(centre, |value| self.counts_of(value, centre, was));
        was.counts = counts;
        let position = (f64::from(counts) - self.offset.get()) / divisor(self.scale.get());
        // An offset that is NaN, or is too large, leaves the axis at its centre.
        let position = if counts == centre || !position.is_finite() { 0.0 } else { position };
        self.counts.set(counts);
        self.position.set(position);
        self.is_pos.set(SIDE < position);
        self.is_neg.set(position < -SIDE);
    }

    fn counts_of(&self, value: i32, centre: i32, was: &mut WasAxis) -> i32 {
        let flat = i64::from(self.flat.get().max(0));
        let width = i64::from(self.range.max) - i64::from(self.range.min);
        let away = (i64::from(value) - i64::from(centre)).abs();
        was.is_blocked &= away > flat.max(width / NEAR);
        let moved = (i64::from(value) - i64::from(was.counts)).abs();
        if was.is_blocked || away <= flat {
            centre
        } else if moved <= i64::from(self.fuzz.get()) {
            was.counts
        } else {
            value
        }
    }
}

impl WheelPins {
    fn show(&self, value: i32, is_there: bool, was: &mut WasWheel) {
        let is_reset = self.reset.get();
        let counts = if self.kind == WheelKind::Ring {
            was.is_blocked &= value != 0;
            let is_known = is_there && value != UNKNOWN;
            if is_reset || was.is_blocked || !is_known { 0 } else { value }
        } else {
            if is_reset {
                was.base = value;
            }
            value.wrapping_sub(was.base)
        };
        self.counts.set(counts);
        self.position.set(f64::from(counts) / divisor(self.scale.get()));
    }
}
