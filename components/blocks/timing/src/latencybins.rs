//! `latencybins`.
use hal_component::{
    Builder, Clock, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};

/// Number of bins on each side.
const BINS: i32 = 1000;

/// Histogram of latencies.
#[derive(Touch)]
pub(crate) struct Latencybins {
    maxbinnumber: In<i32>,
    index: In<i32>,
    reset: In<bool>,
    nsbinsize: In<i32>,
    check: Out<i32>,
    latency: Out<i32>,
    latency_max: Out<i32>,
    latency_min: Out<i32>,
    pbinvalue: Out<i32>,
    nbinvalue: Out<i32>,
    pextra: Out<i32>,
    nextra: Out<i32>,
    variance: Out<i32>,
    clock: Clock,
    #[state]
    positive: Vec<i32>,
    #[state]
    negative: Vec<i32>,
    /// Time of the previous cycle, in nanoseconds.
    #[state]
    before: Option<i64>,
    #[state]
    runs: u32,
    #[state]
    mean: f64,
    /// Sum of the squared deviations from the mean.
    #[state]
    squares: f64,
}

impl Component for Latencybins {
    const NAME: &'static str = "latencybins";
    const DOC: &'static str = "Histogram of the latency of a thread.\n\n\
        Each run counts its latency, the time since the run before less the period, in one of \
        `availablebins` bins on each side, `nsbinsize` wide. A program reads them one at a time: it \
        sets `index`, waits until `check` is equal, and reads `pbinvalue` and `nbinvalue`. \
        Latencies nearer to 0 than a bin is wide are in bin 0 of the positive side.\n\n\
        # Example\n\n\
        ```hal\n\
        # Under the virtual clock no run is late.\n\
        loadrt latencybins\n\
        loadrt threads name1=servo period1=1000000\n\
        addf latencybins.0 servo\n\
        start\n\
        setp latencybins.0.nsbinsize 1000\n\
        run 101ms\n\
        getp latencybins.0.pbinvalue # -> 100\n\
        getp latencybins.0.latency-max # -> 0\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let doc =
            "Last bin to use on each side; runs beyond it are counted in `pextra` and `nextra`.";
        let maxbinnumber = b.item("maxbinnumber", doc, BINS)?;
        let index = b.item("index", "Bin to read, from 0.", 0)?;
        let doc = "While true, all counts are cleared and nothing is counted.";
        let reset = b.item("reset", doc, false)?;
        let doc = "Width of a bin, in nanoseconds; 0 clears all counts and counts nothing.";
        let nsbinsize = b.item("nsbinsize", doc, 0)?;
        let mut pin = |name: &str, doc: &str| b.item(name, doc, 0);
        let check = pin("check", "Bin to which the values belong: `index` at the last run.")?;
        let latency = pin("latency", "Latency of this run, in nanoseconds; negative if early.")?;
        let latency_max = pin("latency-max", "The latest run, in nanoseconds.")?;
        let latency_min = pin("latency-min", "The earliest run, in nanoseconds.")?;
        let doc = "Number of late runs in this bin; -1 for an unused bin.";
        let pbinvalue = pin("pbinvalue", doc)?;
        let doc = "Number of early runs in this bin; -1 for an unused bin.";
        let nbinvalue = pin("nbinvalue", doc)?;
        let pextra = pin("pextra", "Runs later than the last bin.")?;
        let nextra = pin("nextra", "Runs earlier than the last bin.")?;
        let doc = "Variance of the latency, in nanoseconds squared; it wraps at 32 bits.";
        let variance = pin("variance", doc)?;
        let doc = "Number of bins on each side, without bin 0.";
        let _: Out<i32> = b.item("availablebins", doc, BINS)?;
        let bins = || (0..=BINS).map(|_| 0).collect();
        let run = Self {
            maxbinnumber,
            index,
            reset,
            nsbinsize,
            check,
            latency,
            latency_max,
            latency_min,
            pbinvalue,
            nbinvalue,
            pextra,
            nextra,
            variance,
            clock: b.clock(),
            positive: bins(),
            negative: bins(),
            before: None,
            runs: 0,
            mean: 0.0,
            squares: 0.0,
        };
        b.function("", "Counts.", run)
    }
}

impl Update for Latencybins {
    fn update(&mut self, period: Period) {
        let now = self.clock.now_ns();
        let before = self.before.replace(now);
        let (index, size) = (self.index.get(), self.nsbinsize.get());
        self.check.set(index);
        match before {
            Some(before) if size != 0 && !self.reset.get() => {
                let late = now.wrapping_sub(before).wrapping_sub(period.ns());
                self.count(late, size);
            }
            _ => self.forget(),
        }
        let bin = usize::try_from(index).ok().filter(|_| index <= self.maxbinnumber.get());
        let value = |bins: &[i32]| bin.and_then(|i| bins.get(i)).copied().unwrap_or(-1);
        self.pbinvalue.set(value(&self.positive));
        self.nbinvalue.set(value(&self.negative));
    }
}

impl Latencybins {
    fn forget(&mut self) {
        self.positive.fill(0);
        self.negative.fill(0);
        (self.runs, self.mean, self.squares) = (0, 0.0, 0.0);
        for pin in [self.latency, self.pextra, self.nextra] {
            pin.set(0);
        }
        self.latency_max.set(i32::MIN);
        self.latency_min.set(i32::MAX);
    }

    fn count(&mut self, late: i64, size: i32) {
        let late = saturated(late);
        self.latency.set(late);
        self.latency_max.set(self.latency_max.get().max(late));
        self.latency_min.set(self.latency_min.get().min(late));
        let bin = i64::from(late) / i64::from(size);
        let used = bin.abs() <= i64::from(self.maxbinnumber.get());
        let (bins, extra) = if bin >= 0 {
            (&mut self.positive, self.pextra)
        } else {
            (&mut self.negative, self.nextra)
        };
        let place = usize::try_from(bin.unsigned_abs()).ok().filter(|_| used);
        match place.and_then(|i| bins.get_mut(i)) {
            Some(n) => *n = n.saturating_add(1),
            None => extra.set(extra.get().saturating_add(1)),
        }
        self.runs = self.runs.saturating_add(1);
        let late = f64::from(late);
        let beside = late - self.mean;
        self.mean += beside / f64::from(self.runs);
        self.squares += beside * (late - self.mean);
        if self.runs > 1 {
            self.variance.set(wrapped(self.squares / f64::from(self.runs - 1)));
        }
    }
}

fn saturated(ns: i64) -> i32 {
    i32::try_from(ns).unwrap_or(if ns < 0 { i32::MIN } else { i32::MAX })
}

#[expect(clippy::cast_possible_truncation, reason = "it wraps, as its pin tells")]
const fn wrapped(variance: f64) -> i32 {
    variance as i64 as i32
}

#[cfg(test)]
mod tests {
    use super::Latencybins;
    use hal_bench::Bench;

    fn ran(bench: &Bench, after: i64) {
        bench.pass(after);
        bench.run("latencybins.0", 1_000_000);
    }

    fn bins(bench: &Bench, index: i32) -> [i32; 2] {
        bench.set("latencybins.0.index", index);
        ran(bench, 1_000_000);
        assert_eq!(bench.get::<i32>("latencybins.0.check"), index);
        ["p", "n"].map(|side| bench.get(&format!("latencybins.0.{side}binvalue")))
    }

    #[test]
    fn late_and_early() {
        let mut bench = Bench::new();
        bench.load::<Latencybins>(&[]).unwrap();
        bench.set("latencybins.0.nsbinsize", 1000);
        bench.set("latencybins.0.maxbinnumber", 10);
        for late in [0, 2_500, -1_999, -2_000, -999, 11_000, -11_000, 10_999] {
            ran(&bench, 1_000_000 + late);
        }
        assert_eq!(bench.get::<i32>("latencybins.0.latency"), 10_999);
        assert_eq!(bench.get::<i32>("latencybins.0.latency-max"), 11_000);
        assert_eq!(bench.get::<i32>("latencybins.0.latency-min"), -11_000);
        assert_eq!(bins(&bench, 2), [1, 1]);
        assert_eq!(bins(&bench, 1), [0, 1]);
        // The one at -999, this cycle and the two before it.
        assert_eq!(bins(&bench, 0), [4, 0]);
        assert_eq!(bins(&bench, 10), [1, 0]);
        assert_eq!(bins(&bench, 11), [-1, -1]);
        assert_eq!(bins(&bench, -1), [-1, -1]);
        assert_eq!(bench.get::<i32>("latencybins.0.pextra"), 1);
        assert_eq!(bench.get::<i32>("latencybins.0.nextra"), 1);
    }

    #[test]
    fn variance_of_a_few() {
        let mut bench = Bench::new();
        bench.load::<Latencybins>(&[]).unwrap();
        bench.set("latencybins.0.nsbinsize", 10);
        for late in [0, 20, 40, 60] {
            ran(&bench, 1_000_000 + late);
        }
        assert_eq!(bench.get::<i32>("latencybins.0.variance"), 400);
        bench.set("latencybins.0.reset", true);
        ran(&bench, 1_000_000);
        assert_eq!(bench.get::<i32>("latencybins.0.latency-max"), i32::MIN);
    }
}
