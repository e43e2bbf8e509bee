//! `threads`.
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};

/// Component that only creates threads.
pub(crate) struct Threads;

const FP: &str =
    "With 0, functions that compute with floating-point numbers cannot be added to it.";

impl Component for Threads {
    const NAME: &'static str = "threads";
    const DOC: &'static str = "Creates up to three realtime threads.\n\n\
        `name1=fast period1=100000 name2=slow period2=1000000` creates two, the first with the \
        highest priority. A thread is created when it has a name and a period above zero; no \
        period may be shorter than that of the thread before. They are removed when the component \
        is unloaded.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt threads name1=base period1=100000 name2=servo period2=1000000\n\
        loadrt threadtest\n\
        addf threadtest.0.increment base\n\
        start\n\
        run 950us\n\
        getp threadtest.0.count # -> 9\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("name1", "Name of the first thread.").or("thread1"),
        &Arg::int("period1", "Period of the first thread, 1000 to 1000000000000.")
            .unit("ns")
            .or("1000000"),
        &Arg::int("fp1", FP).or("1"),
        &Arg::text("name2", "Name of the second thread; none without it."),
        &Arg::int("period2", "Period of the second thread.").unit("ns").or("0"),
        &Arg::int("fp2", FP).or("1"),
        &Arg::text("name3", "Name of the third thread; none without it."),
        &Arg::int("period3", "Period of the third thread.").unit("ns").or("0"),
        &Arg::int("fp3", FP).or("1"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        for n in 1..=3 {
            let name = b.arg_text(&format!("name{n}")).unwrap_or_default();
            let period = b.arg_int(&format!("period{n}")).unwrap_or(0);
            if name.is_empty() || period <= 0 {
                continue;
            }
            if b.arg_int(&format!("fp{n}")) == Some(0) {
                b.integer_thread(&name, period)?;
            } else {
                b.thread(&name, period)?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Threads;
    use hal_bench::Bench;

    /// As measured on LinuxCNC 2.9.
    #[test]
    fn which_threads_are_created() {
        for (args, wanted) in [
            (&[][..], &[("thread1", 1_000_000)][..]),
            (&["name2=x"], &[("thread1", 1_000_000)]),
            (&["period2=2000000"], &[("thread1", 1_000_000)]),
            (&["name1=a", "period1=100"], &[("a", 100)]),
            (&["name1=a", "period1=0"], &[]),
            (&["name1=a", "period1=-5"], &[]),
            (&["name1=", "period1=1000000"], &[]),
            (&["period1=0", "name2=b", "period2=500000"], &[("b", 500_000)]),
            (&["name2=b", "period2=2000000"], &[("thread1", 1_000_000), ("b", 2_000_000)]),
            (
                &["name1=a", "name2=b", "period2=2000000", "name3=c", "period3=3500000", "fp1=0"],
                &[("a", 1_000_000), ("b", 2_000_000), ("c", 3_500_000)],
            ),
            (
                &["name3=c", "period3=3000000", "fp2=1", "fp3=0"],
                &[("thread1", 1_000_000), ("c", 3_000_000)],
            ),
        ] {
            let mut bench = Bench::new();
            bench.load::<Threads>(args).unwrap();
            let wanted: Vec<_> = wanted.iter().map(|(n, p)| ((*n).to_owned(), *p)).collect();
            assert_eq!(bench.threads(), wanted, "{args:?}");
            assert!(bench.names().is_empty() && bench.functs().is_empty());
        }
    }

    #[test]
    fn a_fourth_is_refused() {
        let refused = Bench::new().load::<Threads>(&["name4=x"]).unwrap_err();
        assert_eq!(refused, "Unknown parameter `name4=x'");
    }
}
