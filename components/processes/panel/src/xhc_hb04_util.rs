//! `xhc_hb04_util`.
use hal_component::{Component, In, Out, Period, Update, to_s32};

/// Logic of a hand-held pendant such as the XHC-HB04: its start button and its displays.
///
/// The button starts a program if none runs, pauses a running one, or resumes a paused one; the chosen output stays
/// true until the button is released. There are also four low-pass filters for integers, and a division.
///
/// # Example
///
/// ```hal
/// loadrt xhc_hb04_util
/// loadrt threads name1=servo period1=1000000
/// addf xhc-hb04-util.0 servo
/// setp xhc-hb04-util.0.is-running 1
/// start
/// run 1ms
/// setp xhc-hb04-util.0.start-or-pause 1
/// run 1ms
/// getp xhc-hb04-util.0.pause # -> TRUE
/// ```
#[derive(Component)]
#[hal(name = "xhc_hb04_util")]
pub(crate) struct XhcHb04Util {
    /// Button for start and pause.
    start_or_pause: In<bool>,
    /// TRUE while a program is paused, from `halui.program.is-paused`.
    is_paused: In<bool>,
    /// TRUE while no program runs, from `halui.program.is-idle`.
    is_idle: In<bool>,
    /// TRUE while a program runs, from `halui.program.is-running`.
    is_running: In<bool>,
    /// Requests a pause, for `halui.program.pause`.
    pause: Out<bool>,
    /// Requests to resume, for `halui.program.resume`.
    resume: Out<bool>,
    /// Requests a start, for `halui.program.run`.
    run: Out<bool>,
    /// Input of a filter.
    #[hal(name = "in#", count = 4_u32)]
    in_: Vec<In<i32>>,
    /// Output of a filter: its value times `scale`, rounded to the nearest, halves down; -2147483648 if out of range.
    #[hal(name = "out#", count = 4_u32)]
    out: Vec<Out<i32>>,
    /// Scale of a filter: output units per input unit.
    #[hal(name = "scale#", count = 4_u32, default = 1.0)]
    scale: Vec<In<f64>>,
    /// Fraction of the difference that a filter follows in each cycle, 0 to 1; the sign is ignored, and a value beyond
    /// 1 counts as 1.
    #[hal(name = "coef#", count = 4_u32, default = 1.0)]
    coef: Vec<In<f64>>,
    /// Dividend, in any unit.
    divide_by_k_in: In<f64>,
    /// `divide-by-k-in` / `k`, in the quotient of their units; 1e99 if `k` is 0.
    divide_by_k_out: Out<f64>,
    /// Divisor, in any unit.
    #[hal(default = 1.0)]
    k: In<f64>,
    #[state]
    was_pressed: bool,
    #[state]
    filtered: [f64; 4],
}

impl Update for XhcHb04Util {
    fn update(&mut self, _: Period) {
        let pressed = self.start_or_pause.get();
        if pressed != self.was_pressed {
            let (idle, running) = (self.is_idle.get(), self.is_running.get());
            self.run.set(pressed && idle);
            self.pause.set(pressed && !idle && running);
            self.resume.set(pressed && !idle && !running && self.is_paused.get());
        }
        self.was_pressed = pressed;
        let pins = self.in_.iter().zip(&self.out).zip(self.scale.iter().zip(&self.coef));
        for (((in_, out), (scale, coef)), sum) in pins.zip(&mut self.filtered) {
            let coef = coef.get();
            let (coef, in_) = (libm::fabs(coef), f64::from(in_.get()));
            *sum = if coef <= 1.0 { *sum + (in_ - *sum) * coef } else { in_ };
            out.set(whole(*sum * scale.get()));
        }
        let k = self.k.get();
        self.divide_by_k_out.set(if k == 0.0 { 1e99 } else { self.divide_by_k_in.get() / k });
    }
}

/// Returns the nearest integer, with halves rounded down; out of range, the lowest integer.
fn whole(number: f64) -> i32 {
    to_s32(libm::ceil(number - 0.5))
}

#[cfg(test)]
mod tests {
    use super::XhcHb04Util;
    use hal_bench::trace::replay;

    #[test]
    fn button() {
        let rows = "load xhc_hb04_util
            run xhc-hb04-util.0
            in xhc-hb04-util.0.start-or-pause xhc-hb04-util.0.is-paused xhc-hb04-util.0.is-idle xhc-hb04-util.0.is-running
            out xhc-hb04-util.0.pause xhc-hb04-util.0.resume xhc-hb04-util.0.run
            0 0 1 0 | 0 0 0
            1 0 1 0 | 0 0 1
            1 0 0 1 | 0 0 1
            0 0 0 1 | 0 0 0
            1 0 0 1 | 1 0 0
            0 1 0 0 | 0 0 0
            1 1 0 0 | 0 1 0
            0 0 0 0 | 0 0 0
            1 0 0 0 | 0 0 0";
        assert_eq!(replay::<XhcHb04Util>(rows), 9);
    }

    #[test]
    fn filters() {
        let rows = "load xhc_hb04_util
            run xhc-hb04-util.0
            in xhc-hb04-util.0.in2 xhc-hb04-util.0.scale2 xhc-hb04-util.0.coef2 xhc-hb04-util.0.k
            set xhc-hb04-util.0.divide-by-k-in 10
            out xhc-hb04-util.0.out2 xhc-hb04-util.0.divide-by-k-out
            10 1 1 4 | 10 2.5
            -10 1.26 0.5 0 | 0 1e99
            . . . -2 | -6 -5
            5 0.5 1 . | 2 .
            -5 0.5 1 . | -3 .
            5 1e300 1 . | -2147483648 .";
        assert_eq!(replay::<XhcHb04Util>(rows), 6);
    }
}
