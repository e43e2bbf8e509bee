//! `scope_rt`.
use hal_component::{
    Arg, Builder, Component, Error, Period, Touch, Update,
    abi::{ArgSpec, component_flags},
};

/// Sampling side of LinuxCNC's oscilloscope, as a name to load.
pub(crate) struct ScopeRt;

impl Component for ScopeRt {
    const NAME: &'static str = "scope_rt";
    const DOC: &'static str = "\
The sampling side of LinuxCNC's oscilloscope: a name that scripts may load, and nothing more.

`halscope` samples any thread by itself here. `scope.sample` is there to be added to a thread as
scripts do; it touches no pin and samples nothing, and nothing is missing without it.

# Example

```hal
loadrt scope_rt num_samples=16000
loadrt threads name1=servo period1=1000000
loadrt threadtest
addf threadtest.0.increment servo
addf scope.sample servo
start
run 3ms
getp threadtest.0.count # -> 3
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::int(
        "num_samples",
        "Accepted for old scripts; halscope takes as many samples as requested.",
    )];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        b.function("scope.sample", "Nothing: halscope samples by itself.", Sample {})
    }
}

/// Function that samples nothing.
#[derive(Touch)]
struct Sample {}

impl Update for Sample {
    fn update(&mut self, _: Period) {}
}

#[cfg(test)]
mod tests {
    use super::ScopeRt;
    use hal_bench::Bench;

    #[test]
    fn a_function_that_touches_nothing() {
        let mut bench = Bench::new();
        bench.load::<ScopeRt>(&["num_samples=4000"]).unwrap();
        assert_eq!(bench.functs(), ["scope.sample"]);
        assert!(bench.touches("scope.sample").is_empty() && bench.names().is_empty());
        bench.run("scope.sample", 1_000_000);
    }
}
