//! `xhc_hb04_util`.
use hal_component::{Component, In, Out, Period, Update, to_s32};

/// Logic of a hand-held panel such as the XHC-HB04: its start button and its displays.
///
/// The button starts an idle program, else pauses a running one, else resumes a paused one; what was
/// chosen stays until the button is released. Besides there are four low-pass filters for
/// integers and a division.
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
    /// The button for start and pause.
    start_or_pause: In<bool>,
    /// Whether a program is paused, from `halui.program.is-paused`.
    is_paused: In<bool>,
    /// Whether no program runs, from `halui.program.is-idle`.
    is_idle: In<bool>,
    /// Whether a program runs, from `halui.program.is-running`.
    is_running: In<bool>,
    /// Asks to pause, for `halui.program.pause`.
    pause: Out<bool>,
    /// Asks to go on, for `halui.program.resume`.
    resume: Out<bool>,
    /// Asks to start, for `halui.program.run`.
    run: Out<bool>,
    /// Input of a filter.
    #[hal(name = "in#", count = 4_u32)]
    in_: Vec<In<i32>>,
    /// Output of a filter: its number times its scale, rounded, halves down; out of range: the lowest.
    #[hal(name = "out#", count = 4_u32)]
    out: Vec<Out<i32>>,
    /// Scale of a filter: the unit of its output per that of its input.
    #[hal(name = "scale#", count = 4_u32, default = 1.0)]
    scale: Vec<In<f64>>,
    /// How much of the difference a filter follows in a run, 0 to 1, without its sign; beyond
    /// that it follows all.
    #[hal(name = "coef#", count = 4_u32, default = 1.0)]
    coef: Vec<In<f64>>,
    /// The number to divide, in any unit.
    divide_by_k_in: In<f64>,
    /// `divide-by-k-in` / `k`, in the unit of one per that of the other; 1e99 when `k` is 0.
    divide_by_k_out: Out<f64>,
    /// What to divide by, in any unit.
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

/// The nearest integer, the lower of two; out of range the lowest.
fn whole(number: f64) -> i32 {
    to_s32(libm::ceil(number - 0.5))
}

#[cfg(test)]
mod tests {
    use super::XhcHb04Util;
    use hal_component::trace::replay;

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
