//! `histobins`.
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Number of bins.
const BINS: i32 = 200;
/// Initial value of the minimum; its negative is that of the maximum.
const LARGE: f64 = 1e99;

/// Histogram of a value.
#[derive(Touch)]
pub(crate) struct Histobins {
    source: Source,
    nbins: In<u32>,
    binsize: In<f64>,
    minvalue: In<f64>,
    index: In<i32>,
    reset: In<bool>,
    method: In<bool>,
    check: Out<i32>,
    input_error: Out<bool>,
    binvalue: Out<f64>,
    pextra: Out<f64>,
    nextra: Out<f64>,
    input_min: Out<f64>,
    input_max: Out<f64>,
    nsamples: Out<u32>,
    variance: Out<f64>,
    mean: Out<f64>,
    #[state]
    bins: Vec<f64>,
    /// Settings of the present histogram: number and size of the bins, and the lowest value.
    #[state]
    with: Option<(u32, f64, f64)>,
    /// Sum of the squared deviations from the mean.
    #[state]
    squares: f64,
    /// Sums for the other method: of all values, and of their squares.
    #[state]
    sums: (f64, f64),
}

/// Value from one of four inputs.
#[derive(Touch)]
struct Source {
    pintype: In<u32>,
    float: In<f64>,
    s32: In<i32>,
    u32: In<u32>,
    bit: In<bool>,
}

impl Source {
    fn value(&self) -> f64 {
        match self.pintype.get() {
            1 => f64::from(self.s32.get()),
            2 => f64::from(self.u32.get()),
            3 => f64::from(u8::from(self.bit.get())),
            _ => self.float.get(),
        }
    }
}

impl Component for Histobins {
    const NAME: &'static str = "histobins";
    const DOC: &'static str = "A histogram of a value, with mean and variance.\n\n\
        Each run counts the value in one of `nbins` bins, the first of which begins at `minvalue`. \
        A program reads them one at a time: it sets `index`, waits until `check` is equal, and reads \
        `binvalue`. The first run, and a run after a change of `nbins`, `binsize` or `minvalue`, \
        restarts the histogram: it counts as a sample, but with the value 0 for the mean, and in \
        no bin.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt histobins\n\
        loadrt threads name1=servo period1=1000000\n\
        addf histobins.0 servo\n\
        start\n\
        setp histobins.0.input 2.5\n\
        setp histobins.0.index 2\n\
        run 11ms\n\
        getp histobins.0.check # -> 2\n\
        getp histobins.0.binvalue # -> 10\n\
        getp histobins.0.input-max # -> 2.5\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let doc = "Input to evaluate: 0 `input`, 1 `input-s32`, 2 `input-u32`, 3 `input-bit`; any \
            other number: `input`.";
        let pintype = b.item("pintype", doc, 0)?;
        let doc = "The value, in any unit; NaN is skipped.";
        let float = b.item("input", doc, 0.0)?;
        let s32 = b.item("input-s32", "The value, if `pintype` is 1.", 0)?;
        let u32 = b.item("input-u32", "The value, if `pintype` is 2.", 0)?;
        let bit = b.item("input-bit", "The value, if `pintype` is 3: 0 or 1.", false)?;
        let nbins = b.item("nbins", "Number of bins to use, 1 to `availablebins`.", 20)?;
        let binsize = b.item("binsize", "Width of a bin, in units.", 1.0)?;
        let minvalue = b.item("minvalue", "Lower end of the first bin, in units.", 0.0)?;
        let index = b.item("index", "Bin to read, from 0.", 0)?;
        let doc = "While true, every run restarts the histogram.";
        let reset = b.item("reset", doc, false)?;
        let doc = "True computes mean and variance from the sums of all values and of their \
            squares; false updates them with each value, which is more accurate.";
        let method = b.item("method", doc, false)?;
        let doc = "Bin to which `binvalue` belongs: `index` at the last run.";
        let check = b.item("check", doc, 0)?;
        let doc = "True while `nbins` is invalid; nothing is counted then.";
        let input_error = b.item("input-error", doc, false)?;
        let mut pin = |name: &str, doc: &str| b.item(name, doc, 0.0);
        let binvalue = pin("binvalue", "Number of values in this bin; -1 for an unused bin.")?;
        let pextra = pin("pextra", "Number of values above the last bin.")?;
        let nextra = pin("nextra", "Number of values below the first bin.")?;
        let input_min = pin("input-min", "The lowest value, in units.")?;
        let input_max = pin("input-max", "The highest value, in units.")?;
        let nsamples = b.item("nsamples", "Number of values.", 0)?;
        let mut pin = |name: &str, doc: &str| b.item(name, doc, 0.0);
        let variance = pin("variance", "Variance of the values, in units squared.")?;
        let mean = pin("mean", "Mean of the values, in units.")?;
        let _: Out<i32> = b.item("availablebins", "Number of available bins.", BINS)?;
        let run = Self {
            source: Source { pintype, float, s32, u32, bit },
            nbins,
            binsize,
            minvalue,
            index,
            reset,
            method,
            check,
            input_error,
            binvalue,
            pextra,
            nextra,
            input_min,
            input_max,
            nsamples,
            variance,
            mean,
            bins: (0..BINS).map(|_| 0.0).collect(),
            with: None,
            squares: 0.0,
            sums: (0.0, 0.0),
        };
        b.function("", "Counts.", run)
    }
}

impl Update for Histobins {
    fn update(&mut self, _: Period) {
        let index = self.index.get();
        self.check.set(index);
        let n = self.nbins.get();
        let fits = usize::try_from(n).is_ok_and(|n| (1..=self.bins.len()).contains(&n));
        self.input_error.set(!fits);
        if !fits {
            return;
        }
        let x = self.source.value();
        let with = Some((n, self.binsize.get(), self.minvalue.get()));
        if self.reset.get() || self.with != with {
            self.with = with;
            self.begin(x);
        } else if !x.is_nan() {
            self.count(x);
        }
        let bin = u32::try_from(index).ok().filter(|i| *i < n);
        let value = bin.and_then(|i| self.bins.get(usize::try_from(i).ok()?));
        self.binvalue.set(value.copied().unwrap_or(-1.0));
    }
}

impl Histobins {
    fn begin(&mut self, x: f64) {
        self.bins.fill(0.0);
        (self.squares, self.sums) = (0.0, (0.0, 0.0));
        for pin in [self.pextra, self.nextra, self.variance, self.mean] {
            pin.set(0.0);
        }
        self.input_min.set(if x < LARGE { x } else { LARGE });
        self.input_max.set(if x > -LARGE { x } else { -LARGE });
        self.nsamples.set(1);
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    fn count(&mut self, x: f64) {
        if x < self.input_min.get() {
            self.input_min.set(x);
        }
        if x > self.input_max.get() {
            self.input_max.set(x);
        }
        let (min, size) = (self.minvalue.get(), self.binsize.get());
        let max = min + size * f64::from(self.nbins.get());
        let bin = ((x - min) / size) as usize;
        if x < min {
            self.nextra.set(self.nextra.get() + 1.0);
        } else if x > max {
            self.pextra.set(self.pextra.get() + 1.0);
        } else if let Some(n) = self.bins.get_mut(bin) {
            *n += 1.0;
        }
        self.nsamples.set(self.nsamples.get().wrapping_add(1));
        self.spread(x);
    }

    fn spread(&mut self, x: f64) {
        let n = f64::from(self.nsamples.get());
        if self.method.get() {
            self.sums.0 += x;
            self.sums.1 += x * x;
            let (sum, squares) = self.sums;
            self.mean.set(sum / n);
            self.variance.set((squares - sum * sum / n) / (n - 1.0));
        } else {
            let beside = x - self.mean.get();
            self.mean.set(self.mean.get() + beside / n);
            self.squares += beside * (x - self.mean.get());
            self.variance.set(self.squares / (n - 1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Histobins;
    use hal_bench::trace::replay;

    #[test]
    fn bins_and_what_is_beside_them() {
        let rows = replay::<Histobins>(
            "load histobins
             run histobins.0
             in histobins.0.input histobins.0.index
             out histobins.0.check histobins.0.binvalue histobins.0.pextra histobins.0.nextra histobins.0.nsamples
             2.5 2 | 2 0 0 0 1
             2.5 2 | 2 1 0 0 2
             2.9 2 | 2 2 0 0 3
             3 2 | 2 2 0 0 4
             -0.1 3 | 3 1 0 1 5
             20.1 3 | 3 1 1 1 6
             0 0 | 0 1 1 1 7
             nan 20 | 20 -1 1 1 7
             5 -1 | -1 -1 1 1 8
             set histobins.0.nbins 201
             5 3 | 3 -1 1 1 8
             expect histobins.0.input-error 1
             set histobins.0.nbins 20
             5 3 | 3 1 1 1 9",
        );
        assert_eq!(rows, 11);
    }

    #[test]
    fn mean_and_variance_both_ways() {
        for method in [0, 1] {
            let rows = replay::<Histobins>(&format!(
                "load histobins
                 set histobins.0.method {method}
                 within 1e-13
                 run histobins.0
                 in histobins.0.input
                 out histobins.0.mean histobins.0.variance histobins.0.input-min histobins.0.input-max
                 1 | 0 0 1 1
                 2 | 1 2 1 2
                 4 | 2 4 1 4
                 8 | 3.5 11.666666666666666 1 8
                 -3 | 2.2 17.2 -3 8
                 5.5 | 2.75 15.575 -3 8
                 set histobins.0.reset 1
                 7 | 0 0 7 7"
            ));
            assert_eq!(rows, 7);
        }
    }

    #[test]
    fn every_kind_of_value() {
        for (kind, pin, value) in [(1, "s32", "-7"), (2, "u32", "4294967295"), (3, "bit", "1")] {
            let rows = replay::<Histobins>(&format!(
                "load histobins\nset histobins.0.pintype {kind}\nset histobins.0.input-{pin} {value}\n\
                 run histobins.0\nin\nout histobins.0.input-max\n | {value}"
            ));
            assert_eq!(rows, 1);
        }
    }
}
