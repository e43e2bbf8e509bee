//! `threadtest`.
use hal_component::{Builder, Component, Error, Out, Period, Touch, Update, abi::component_flags};

/// Counter of cycles.
#[derive(Touch)]
pub(crate) struct Threadtest {
    count: Out<u32>,
}

impl Component for Threadtest {
    const NAME: &'static str = "threadtest";
    const DOC: &'static str = "Counts the runs of a thread during one period of another.\n\n\
        `threadtest.0.increment` counts in a fast thread, and `threadtest.0.reset` restarts the \
        count in a slower one.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt threadtest\n\
        loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
        addf threadtest.0.reset servo\n\
        addf threadtest.0.increment base\n\
        start\n\
        run 1900us\n\
        getp threadtest.0.count # -> 9\n\
        ```";
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let count = b.item("count", "Runs since the last reset; it wraps at 32 bits.", 0)?;
        b.function("increment", "Counts.", Self { count })?;
        b.function("reset", "Resets the count.", Reset { count })
    }
}

impl Update for Threadtest {
    fn update(&mut self, _: Period) {
        self.count.set(self.count.get().wrapping_add(1));
    }
}

#[derive(Touch)]
struct Reset {
    count: Out<u32>,
}

impl Update for Reset {
    fn update(&mut self, _: Period) {
        self.count.set(0);
    }
}

#[cfg(test)]
mod tests {
    use super::Threadtest;
    use hal_bench::Bench;

    #[test]
    fn counts_and_begins_anew() {
        let mut bench = Bench::new();
        bench.load::<Threadtest>(&[]).unwrap();
        for n in 1..=3 {
            bench.run("threadtest.0.increment", 1000);
            assert_eq!(bench.get::<u32>("threadtest.0.count"), n);
        }
        bench.run("threadtest.0.reset", 1000);
        assert_eq!(bench.get::<u32>("threadtest.0.count"), 0);
        bench.set("threadtest.0.count", u32::MAX);
        bench.run("threadtest.0.increment", 1000);
        assert_eq!(bench.get::<u32>("threadtest.0.count"), 0);
    }
}
