//! `multiclick`.
use hal_component::{Component, In, Out, ParamRw, Period, Update};

/// Detector of single, double, triple and quadruple clicks of a button.
///
/// A click means that the button is down for at most `max-hold-ns`. Clicks that follow each other within `max-space-ns`
/// belong together. Each `-click` output gives a pulse as soon as there were that many clicks, each `-click-only`
/// output when no further click can follow. A press that is too long, or a fifth press, ends the sequence without a
/// further pulse.
///
/// # Example
///
/// ```hal
/// loadrt multiclick
/// loadrt threads name1=servo period1=1000000
/// addf multiclick.0 servo
/// start
/// setp multiclick.0.in 1
/// run 50ms
/// setp multiclick.0.in 0
/// run 50ms
/// setp multiclick.0.in 1
/// run 50ms
/// setp multiclick.0.in 0
/// run 50ms
/// getp multiclick.0.double-click # -> TRUE
/// run 250ms
/// getp multiclick.0.double-click # -> FALSE
/// getp multiclick.0.double-click-only # -> TRUE
/// getp multiclick.0.single-click-only # -> FALSE
/// ```
#[derive(Component)]
pub(crate) struct Multiclick {
    /// Button input.
    in_: In<bool>,
    /// Pulse after the first click.
    single_click: Out<bool>,
    /// Pulse after one click, when no further click can follow.
    single_click_only: Out<bool>,
    /// Pulse after the second click.
    double_click: Out<bool>,
    /// Pulse after two clicks, when no further click can follow.
    double_click_only: Out<bool>,
    /// Pulse after the third click.
    triple_click: Out<bool>,
    /// Pulse after three clicks, when no further click can follow.
    triple_click_only: Out<bool>,
    /// Pulse after the fourth click.
    quadruple_click: Out<bool>,
    /// Pulse after four clicks, when no further click can follow.
    quadruple_click_only: Out<bool>,
    /// State: 0 idle; odd while pressed, even after a release, 1 and 2 for the first click to 7 and 8 for the fourth; 9
    /// waits for the release of a press that does not count.
    state: Out<i32>,
    /// TRUE: the button is down while `in` is false.
    invert_input: ParamRw<bool>,
    /// Maximum duration of a click, in nanoseconds.
    #[hal(default = 250_000_000)]
    max_hold_ns: ParamRw<u32>,
    /// Maximum time from one click to the start of the next, in nanoseconds.
    #[hal(default = 250_000_000)]
    max_space_ns: ParamRw<u32>,
    /// Length of the pulses, in nanoseconds; with 0 a pulse does not end.
    #[hal(default = 100_000_000)]
    output_hold_ns: ParamRw<u32>,
    /// Time in the present state, in nanoseconds; it wraps after 4.29 s.
    #[state]
    time: u32,
    /// Maximum time in the present state, in nanoseconds.
    #[state]
    most: u32,
    /// Remaining time of each pulse, in nanoseconds.
    #[state]
    left: [i64; 8],
}

/// State in which the button is up and no sequence is active.
const IDLE: i32 = 0;
/// State after the fourth click.
const LAST: i32 = 8;
/// State of a press that does not count.
const TOO_MUCH: i32 = 9;

impl Update for Multiclick {
    fn update(&mut self, period: Period) {
        #[expect(clippy::cast_possible_truncation, reason = "the time wraps")]
        let passed = period.ns().cast_unsigned() as u32;
        self.time = self.time.wrapping_add(passed);
        let outputs = self.outputs().map(|(.., out)| out);
        for (left, out) in self.left.iter_mut().zip(outputs) {
            if *left > 0 {
                *left -= period.ns();
                if *left <= 0 {
                    out.set(false);
                }
            }
        }
        let down = self.in_.get() != self.invert_input.get();
        let state = self.state.get();
        let pressed = state % 2 == 1;
        if state == TOO_MUCH {
            if !down {
                self.enter(IDLE);
            }
        } else if pressed && !down {
            self.enter(state + 1);
            self.show(state + 1, false);
        } else if pressed && self.time > self.most {
            self.enter(TOO_MUCH);
        } else if !pressed && down {
            self.enter(if state == LAST { TOO_MUCH } else { state + 1 });
        } else if !pressed && state != IDLE && self.time > self.most {
            self.enter(IDLE);
            self.show(state, true);
        }
    }
}

impl Multiclick {
    fn enter(&mut self, state: i32) {
        self.state.set(state);
        let most = if state % 2 == 1 { self.max_hold_ns } else { self.max_space_ns };
        (self.time, self.most) = (0, most.get());
    }

    /// Returns each output with its state, and whether it waits until no further click can follow.
    const fn outputs(&self) -> [(i32, bool, Out<bool>); 8] {
        [
            (2, false, self.single_click),
            (4, false, self.double_click),
            (6, false, self.triple_click),
            (8, false, self.quadruple_click),
            (2, true, self.single_click_only),
            (4, true, self.double_click_only),
            (6, true, self.triple_click_only),
            (8, true, self.quadruple_click_only),
        ]
    }

    /// Starts the pulse of one output.
    fn show(&mut self, state: i32, is_all: bool) {
        let hold = i64::from(self.output_hold_ns.get());
        for ((when, only, out), left) in self.outputs().into_iter().zip(&mut self.left) {
            if (when, only) == (state, is_all) {
                out.set(true);
                *left = hold;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Multiclick;
    use hal_bench::trace::replay;

    const PINS: &str = "load multiclick
        set multiclick.0.max-hold-ns 3000000
        set multiclick.0.max-space-ns 3000000
        set multiclick.0.output-hold-ns 2000000
        run multiclick.0
        in multiclick.0.in
        out multiclick.0.state multiclick.0.single-click multiclick.0.single-click-only multiclick.0.double-click multiclick.0.double-click-only\n";

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Multiclick>(include_str!("../traces/multiclick.txt")), 14);
    }

    #[test]
    fn one_click() {
        let rows = "1 | 1 0 0 0 0\n1 | 1 0 0 0 0\n0 | 2 1 0 0 0\n0 | 2 1 0 0 0\n0 | 2 0 0 0 0\n\
            0 | 2 0 0 0 0\n0 | 0 0 1 0 0\n0 | 0 0 1 0 0\n0 | 0 0 0 0 0";
        assert_eq!(replay::<Multiclick>(&format!("{PINS}{rows}")), 9);
    }

    #[test]
    fn two_clicks_end_the_pulse_of_the_first() {
        let rows = "1 | 1 0 0 0 0\n0 | 2 1 0 0 0\n1 | 3 1 0 0 0\n0 | 4 0 0 1 0\n0 | 4 0 0 1 0\n\
            0 | 4 0 0 0 0\n0 | 4 0 0 0 0\n0 | 0 0 0 0 1";
        assert_eq!(replay::<Multiclick>(&format!("{PINS}{rows}")), 8);
    }

    #[test]
    fn held_too_long_is_no_click() {
        let rows = "1 | 1 0 0 0 0\n1 | 1 0 0 0 0\n1 | 1 0 0 0 0\n1 | 1 0 0 0 0\n1 | 9 0 0 0 0\n\
            1 | 9 0 0 0 0\n0 | 0 0 0 0 0";
        assert_eq!(replay::<Multiclick>(&format!("{PINS}{rows}")), 7);
    }

    #[test]
    fn a_fifth_press_does_not_count() {
        let mut rows = String::new();
        for n in [1, 3, 5, 7] {
            rows += &format!("1 | {n} . . . .\n0 | {} . . . .\n", n + 1);
        }
        rows += "expect multiclick.0.quadruple-click 1\n1 | 9 . . . .\n0 | 0 . . . .\n";
        assert_eq!(replay::<Multiclick>(&format!("{PINS}{rows}")), 10);
    }
}
