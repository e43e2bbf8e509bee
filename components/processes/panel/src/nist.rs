//! `toggle2nist` and `momentary2nist`.
use hal_component::{Component, In, Out, Period, Update};

/// Debounced bit.
#[derive(Clone, Copy, Debug, Default)]
struct Steady {
    is: bool,
    for_runs: u32,
}

impl Steady {
    /// Updates the bit, which changes after `runs` cycles in a row with another value. Returns whether it has just
    /// changed.
    fn follow(&mut self, bit: bool, runs: u32) -> bool {
        if bit == self.is {
            self.for_runs = 0;
            return false;
        }
        self.for_runs = self.for_runs.saturating_add(1);
        if self.for_runs < runs {
            return false;
        }
        self.for_runs = 0;
        self.is = bit;
        true
    }
}

/// Request to switch on or off, which lasts until the device obeys or the pulse is too long.
#[derive(Clone, Copy, Debug, Default)]
struct Request {
    on: bool,
    off: bool,
    runs: u32,
}

impl Request {
    fn ask(&mut self, is_on: bool) {
        *self = Self { on: !is_on, off: is_on, runs: 0 };
    }

    fn end(&mut self, is_on: bool, most: u32) {
        self.on &= !is_on;
        self.off &= is_on;
        self.runs = self.runs.saturating_add(1);
        if self.runs > most {
            *self = Self::default();
        }
    }
}

/// Toggle switch for a device with separate on and off inputs.
///
/// Whenever the switch is moved, the device is requested to change its state. LinuxCNC 2.9 has neither `debounce` nor
/// `max-pulse-length`: a `debounce` of 0 or 1 and a long `max-pulse-length` give its behaviour.
///
/// # Example
///
/// ```hal
/// loadrt toggle2nist
/// loadrt threads name1=servo period1=1000000
/// addf toggle2nist.0 servo
/// setp toggle2nist.0.in 1
/// start
/// run 2ms
/// getp toggle2nist.0.on # -> TRUE
/// setp toggle2nist.0.is-on 1
/// run 1ms
/// getp toggle2nist.0.on # -> FALSE
/// setp toggle2nist.0.in 0
/// run 2ms
/// getp toggle2nist.0.off # -> TRUE
/// ```
#[derive(Component)]
#[hal(name = "toggle2nist")]
pub(crate) struct Toggle2nist {
    /// Toggle switch.
    in_: In<bool>,
    /// TRUE while the device is on.
    is_on: In<bool>,
    /// Number of cycles in a row with the switch moved before it counts; 0 counts as 1.
    #[hal(default = 2)]
    debounce: In<u32>,
    /// Maximum number of cycles for which `on` and `off` stay true.
    #[hal(default = 100)]
    max_pulse_length: In<u32>,
    /// Requests the device to switch on, until it is on.
    on: Out<bool>,
    /// Requests the device to switch off, until it is off.
    off: Out<bool>,
    #[state]
    steady: Steady,
    #[state]
    request: Request,
}

impl Update for Toggle2nist {
    fn update(&mut self, _: Period) {
        let is_on = self.is_on.get();
        if self.steady.follow(self.in_.get(), self.debounce.get()) {
            self.request.ask(is_on);
        }
        self.request.end(is_on, self.max_pulse_length.get());
        self.on.set(self.request.on);
        self.off.set(self.request.off);
    }
}

/// Push button for a device with separate on and off inputs.
///
/// Whenever the button is pressed, the device is requested to change its state. LinuxCNC 2.9 does not have this
/// component.
///
/// # Example
///
/// ```hal
/// loadrt momentary2nist
/// loadrt threads name1=servo period1=1000000
/// addf momentary2nist.0 servo
/// setp momentary2nist.0.in 1
/// start
/// run 2ms
/// getp momentary2nist.0.on # -> TRUE
/// setp momentary2nist.0.is-on 1
/// setp momentary2nist.0.in 0
/// run 5ms
/// getp momentary2nist.0.off # -> FALSE
/// setp momentary2nist.0.in 1
/// run 2ms
/// getp momentary2nist.0.off # -> TRUE
/// ```
#[derive(Component)]
#[hal(name = "momentary2nist")]
pub(crate) struct Momentary2nist {
    /// Push button.
    in_: In<bool>,
    /// TRUE while the device is on.
    is_on: In<bool>,
    /// Number of cycles in a row with the button changed before it counts; 0 counts as 1.
    #[hal(default = 2)]
    debounce: In<u32>,
    /// Maximum number of cycles for which `on` and `off` stay true.
    #[hal(default = 100)]
    max_pulse_length: In<u32>,
    /// Requests the device to switch on, until it is on.
    on: Out<bool>,
    /// Requests the device to switch off, until it is off.
    off: Out<bool>,
    #[state]
    steady: Steady,
    #[state]
    request: Request,
}

impl Update for Momentary2nist {
    fn update(&mut self, _: Period) {
        let is_on = self.is_on.get();
        if self.steady.follow(self.in_.get(), self.debounce.get()) && self.steady.is {
            self.request.ask(is_on);
        }
        self.request.end(is_on, self.max_pulse_length.get());
        self.on.set(self.request.on);
        self.off.set(self.request.off);
    }
}

#[cfg(test)]
mod tests {
    use super::{Momentary2nist, Toggle2nist};
    use hal_bench::trace::replay;

    #[test]
    fn both_edges_of_a_switch() {
        let rows = "load toggle2nist
            set toggle2nist.0.debounce 0
            set toggle2nist.0.max-pulse-length 4
            run toggle2nist.0
            in toggle2nist.0.in toggle2nist.0.is-on
            out toggle2nist.0.on toggle2nist.0.off
            0 0 | 0 0
            1 0 | 1 0
            1 0 | 1 0
            1 1 | 0 0
            0 1 | 0 1
            1 1 | 0 1
            1 0 | 0 0
            0 0 | 1 0
            . . | 1 0
            . . | 1 0
            . . | 1 0
            . . | 0 0
            set toggle2nist.0.debounce 2
            1 0 | 0 0
            0 0 | 0 0
            1 0 | 0 0
            1 0 | 1 0";
        assert_eq!(replay::<Toggle2nist>(rows), 16);
    }

    #[test]
    fn one_edge_of_a_button() {
        let rows = "load momentary2nist
            run momentary2nist.0
            in momentary2nist.0.in momentary2nist.0.is-on
            out momentary2nist.0.on momentary2nist.0.off
            1 0 | 0 0
            . . | 1 0
            0 . | 1 0
            . 1 | 0 0
            1 . | 0 0
            . . | 0 1
            0 . | 0 1
            . 0 | 0 0";
        assert_eq!(replay::<Momentary2nist>(rows), 8);
    }
}
