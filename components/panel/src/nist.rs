//! `toggle2nist` and `momentary2nist`.
use hal_component::{Component, In, Out, Period, Update};

/// A steady bit of one that bounces.
#[derive(Clone, Copy, Debug, Default)]
struct Steady {
    is: bool,
    for_runs: u32,
}

impl Steady {
    /// Another value counts when it was seen in `runs` runs in a row. Whether it has just changed.
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

/// A request to switch on or off, until it is obeyed or has lasted too long.
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

/// A toggle switch for a device with inputs for on and off.
///
/// Whenever the switch is moved, the device is asked to become what it is not. LinuxCNC 2.9 has
/// neither `debounce` nor `max-pulse-length`: as there it is with a `debounce` of 0 or 1 and with pulses
/// that are long enough.
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
    /// The switch.
    in_: In<bool>,
    /// Whether the device is on.
    is_on: In<bool>,
    /// In how many runs in a row the switch must be seen moved; 0 as 1.
    #[hal(default = 2)]
    debounce: In<u32>,
    /// For how many runs `on` and `off` stay true at most.
    #[hal(default = 100)]
    max_pulse_length: In<u32>,
    /// Asks the device to switch on, until it is on.
    on: Out<bool>,
    /// Asks the device to switch off, until it is off.
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

/// A push button for a device with inputs for on and off.
///
/// Whenever the button is pressed, the device is asked to become what it is not. LinuxCNC 2.9 does not
/// have it.
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
    /// The button.
    in_: In<bool>,
    /// Whether the device is on.
    is_on: In<bool>,
    /// In how many runs in a row the button must be seen changed; 0 as 1.
    #[hal(default = 2)]
    debounce: In<u32>,
    /// For how many runs `on` and `off` stay true at most.
    #[hal(default = 100)]
    max_pulse_length: In<u32>,
    /// Asks the device to switch on, until it is on.
    on: Out<bool>,
    /// Asks the device to switch off, until it is off.
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
    use hal_component::trace::replay;

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
