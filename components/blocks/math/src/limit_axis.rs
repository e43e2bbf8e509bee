//! `limit_axis`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Maximum number of ranges.
const MAX: i64 = 10;
/// Default number of ranges.
const DEFAULT: i64 = 2;

/// Limits that depend on a position.
#[derive(Touch)]
pub(crate) struct LimitAxis {
    feedback: In<f64>,
    ranges: Vec<Range>,
    min_output: Out<f64>,
    max_output: Out<f64>,
    no_range: Out<bool>,
    current: Out<u32>,
    /// True if an earlier cycle chose the current range.
    #[state]
    chosen: bool,
}

/// Limits, and the range in which they apply.
#[derive(Touch)]
struct Range {
    min_range: In<f64>,
    max_range: In<f64>,
    min_limit: In<f64>,
    max_limit: In<f64>,
    enable: In<bool>,
    sticky: In<bool>,
    error_range: Out<bool>,
    error_limit: Out<bool>,
}

impl Component for LimitAxis {
    const NAME: &'static str = "limit_axis";
    const DOC: &'static str = "Limits of an axis that depend on the position of another.\n\n\
        Each range has an interval of `fb` and limits. The first range that is enabled, has its \
        values in order and contains `fb` sets the output limits. A sticky range, once selected, \
        keeps its limits until it is no longer sticky, is disabled, or is invalid. If no range \
        applies, the outputs keep their values and `error-no-range` is true.\n\n\
        `personality=` is the number of ranges, 1 to 10; 2 without it.\n\n\
        # Example\n\n\
        ```hal\n\
        # Below 100 the slide may move to 500, from there on only to 200.\n\
        loadrt limit_axis personality=2\n\
        loadrt threads name1=servo period1=1000000\n\
        addf limit-axis.0 servo\n\
        start\n\
        setp limit-axis.0.max-range-00 100\n\
        setp limit-axis.0.max-limit-00 500\n\
        setp limit-axis.0.enable-00 1\n\
        setp limit-axis.0.min-range-01 100\n\
        setp limit-axis.0.max-range-01 300\n\
        setp limit-axis.0.max-limit-01 200\n\
        setp limit-axis.0.enable-01 1\n\
        setp limit-axis.0.fb 50\n\
        run 1ms\n\
        getp limit-axis.0.max-output # -> 500\n\
        setp limit-axis.0.fb 150\n\
        run 1ms\n\
        getp limit-axis.0.current-range # -> 1\n\
        getp limit-axis.0.max-output # -> 200\n\
        setp limit-axis.0.fb 400\n\
        run 1ms\n\
        getp limit-axis.0.error-no-range # -> TRUE\n\
        ```";
    const FLAGS: u32 = component_flags::PERSONALITY | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let n = b.size("Pin enable-##", DEFAULT, MAX)?;
        let feedback = b.item("fb", "Position that selects the range, in units.", 0.0)?;
        let mut ranges = Vec::new();
        for i in 0..n {
            let mut pin = |pin: &str, doc: &str| b.item(&format!("{pin}-{i:02}"), doc, 0.0);
            let min_range = pin("min-range", "Lowest `fb` of this range, in units.")?;
            let max_range = pin("max-range", "Highest `fb` of this range, in units.")?;
            let min_limit = pin("min-limit", "Lower limit in this range, in units.")?;
            let max_limit = pin("max-limit", "Upper limit in this range, in units.")?;
            let enable = b.item(&format!("enable-{i:02}"), "True enables this range.", false)?;
            let doc = "True keeps the limits of this range when `fb` leaves it.";
            let sticky = b.item(&format!("sticky-{i:02}"), doc, false)?;
            let doc = "True while the bounds of this range are in the wrong order.";
            let error_range = b.item(&format!("error-range-{i:02}"), doc, true)?;
            let doc = "True while the limits of this range are in the wrong order.";
            let error_limit = b.item(&format!("error-limit-{i:02}"), doc, true)?;
            ranges.push(Range {
                min_range,
                max_range,
                min_limit,
                max_limit,
                enable,
                sticky,
                error_range,
                error_limit,
            });
        }
        let min_output = b.item("min-output", "The lower limit, in units.", 0.0)?;
        let max_output = b.item("max-output", "The upper limit, in units.", 0.0)?;
        let doc = "True while no range applies.";
        let no_range = b.item("error-no-range", doc, false)?;
        let current = b.item("current-range", "Number of the range that applies.", 0)?;
        let run =
            Self { feedback, ranges, min_output, max_output, no_range, current, chosen: false };
        b.function("", "Selects the limits.", run)
    }
}

impl Range {
    /// Returns whether the range may be chosen.
    fn counts(&self) -> bool {
        let in_order = |low: In<f64>, high: In<f64>| low.get() < high.get();
        let (range, limit) =
            (in_order(self.min_range, self.max_range), in_order(self.min_limit, self.max_limit));
        self.error_range.set(!range);
        self.error_limit.set(!limit);
        range && limit && self.enable.get()
    }

    fn holds(&self, x: f64) -> bool {
        self.min_range.get() <= x && x <= self.max_range.get()
    }
}

impl Update for LimitAxis {
    fn update(&mut self, _: Period) {
        let x = self.feedback.get();
        let current = self.current.get();
        let (mut found, mut stays) = (None, None);
        for (i, range) in (0..).zip(&self.ranges) {
            if !range.counts() {
                continue;
            }
            if self.chosen && i == current && range.sticky.get() {
                stays = Some((i, range));
            } else if found.is_none() && range.holds(x) {
                found = Some((i, range));
            }
        }
        let found = stays.or(found);
        self.chosen = found.is_some();
        self.no_range.set(found.is_none());
        if let Some((i, range)) = found {
            self.current.set(i);
            self.min_output.set(range.min_limit.get());
            self.max_output.set(range.max_limit.get());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::LimitAxis;
    use hal_bench::{Bench, trace::replay};

    const TWO: &str = "load limit_axis
         set limit-axis.0.min-range-00 0
         set limit-axis.0.max-range-00 10
         set limit-axis.0.min-limit-00 -1
         set limit-axis.0.max-limit-00 1
         set limit-axis.0.enable-00 1
         set limit-axis.0.min-range-01 5
         set limit-axis.0.max-range-01 20
         set limit-axis.0.min-limit-01 -2
         set limit-axis.0.max-limit-01 2
         set limit-axis.0.enable-01 1
         run limit-axis.0
         in limit-axis.0.fb
         out limit-axis.0.current-range limit-axis.0.min-output limit-axis.0.max-output limit-axis.0.error-no-range\n";

    #[test]
    fn the_first_that_holds() {
        let rows = replay::<LimitAxis>(&format!(
            "{TWO}
             0 | 0 -1 1 0
             7 | 0 -1 1 0
             11 | 1 -2 2 0
             21 | 1 -2 2 1
             nan | 1 -2 2 1
             10 | 0 -1 1 0"
        ));
        assert_eq!(rows, 6);
    }

    #[test]
    fn what_is_sticky_stays() {
        let rows = replay::<LimitAxis>(&format!(
            "{TWO}
             set limit-axis.0.sticky-01 1
             7 | 0 -1 1 0
             15 | 1 -2 2 0
             3 | 1 -2 2 0
             99 | 1 -2 2 0
             set limit-axis.0.sticky-01 0
             3 | 0 -1 1 0"
        ));
        assert_eq!(rows, 5);
    }

    #[test]
    fn what_is_not_in_order_does_not_count() {
        let rows = replay::<LimitAxis>(&format!(
            "{TWO}
             set limit-axis.0.max-limit-00 -1
             7 | 1 -2 2 0
             expect limit-axis.0.error-limit-00 1
             expect limit-axis.0.error-range-00 0
             set limit-axis.0.max-range-01 nan
             7 | 1 -2 2 1
             expect limit-axis.0.error-range-01 1"
        ));
        assert_eq!(rows, 2);
        let refused = Bench::new().load::<LimitAxis>(&["personality=11"]).unwrap_err();
        assert!(refused.starts_with(
            "Pin enable-##: Requested size 11 exceeds max size 10: personality= is 1 to "
        ));
    }
}
