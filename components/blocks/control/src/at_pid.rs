//! `at_pid`.
use crate::pid::Pid;
use hal_component::{
    Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};

/// Former name of `pid` with automatic tuning.
pub(crate) struct AtPid;

impl Component for AtPid {
    const NAME: &'static str = "at_pid";
    const DOC: &'static str = "Closed loop with automatic tuning: the old name of `pid`.\n\n\
        Since LinuxCNC 2.9, `pid` includes the tuning and `at_pid` no longer exists; this is for \
        scripts that use it. Pins and functions are those of `pid`, `pid.0` and so on, and only \
        one of the two can be loaded with numbers.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt at_pid num_chan=1\n\
        loadrt threads name1=servo period1=1000000\n\
        addf pid.0.do-pid-calcs servo\n\
        setp pid.0.Pgain 20\n\
        setp pid.0.error-previous-target 0\n\
        setp pid.0.command 1.5\n\
        setp pid.0.enable 1\n\
        start\n\
        run 1ms\n\
        getp pid.0.output # -> 30\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = Pid::ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        Pid::create(b)
    }
}

#[cfg(test)]
mod tests {
    use super::AtPid;
    use crate::pid::Pid;
    use hal_bench::Bench;

    #[test]
    fn is_pid() {
        let (mut old, mut new) = (Bench::new(), Bench::new());
        old.load::<AtPid>(&["names=x,y"]).unwrap();
        new.load::<Pid>(&["names=x,y"]).unwrap();
        assert_eq!(old.names(), new.names());
        assert_eq!(old.functs(), new.functs());
    }
}
