//! `supply`.
use hal_component::{
    Arg, Builder, Component, Error, Io, Out, Period, Update,
    abi::{ArgSpec, component_flags},
    pins,
};

/// The most channels.
const MOST: i64 = 8;

/// Sources of a bit and a number.
pub(crate) struct Supply;

impl Component for Supply {
    const NAME: &'static str = "supply";
    const DOC: &'static str = "Sources of a bit and a number, to be set by hand.\n\n\
        `num_chan=2` makes `supply.0` and `supply.1`; 1 to 8. It is older than `setp` on pins and \
        than `sets`, which do the same, and is here for scripts that have it.\n\n\
        # Example\n\n\
        ```hal\n\
        loadrt supply\n\
        loadrt threads name1=servo period1=1000000\n\
        addf supply.0.update servo\n\
        setp supply.0.value 2.5\n\
        setp supply.0.d 1\n\
        start\n\
        run 1ms\n\
        getp supply.0.variable # -> 2.5\n\
        getp supply.0._q # -> FALSE\n\
        ```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::int("num_chan", "Number of channels, 1 to 8.").or("1")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let channels = b.arg_int("num_chan").unwrap_or(1);
        if !(1..=MOST).contains(&channels) {
            return Err(Error::new(format!("SUPPLY: ERROR: invalid num_chan: {channels}")));
        }
        for i in 0..channels {
            let pins = Channel::make(b, &format!("supply.{i}"))?;
            b.function(&format!("supply.{i}.update"), "Copies what was set to the outputs.", pins)?;
        }
        Ok(())
    }
}

pins! {
    /// The pins of a channel.
    struct Channel {
        /// The bit.
        q: Out<bool> = "q", false;
        /// The opposite of `q`.
        not_q: Out<bool> = "_q", true;
        /// The number.
        variable: Out<f64> = "variable", 0.0;
        /// The number with the other sign.
        minus: Out<f64> = "_variable", 0.0;
        /// What `q` shall be.
        d: Io<bool> = "d", false;
        /// What `variable` shall be.
        value: Io<f64> = "value", 0.0;
    }
}

impl Update for Channel {
    fn update(&mut self, _: Period) {
        self.q.set(self.d.get());
        self.not_q.set(!self.d.get());
        self.variable.set(self.value.get());
        self.minus.set(-self.value.get());
    }
}

#[cfg(test)]
mod tests {
    use super::Supply;
    use hal_component::{bench::Bench, trace::replay};

    #[test]
    fn copies() {
        let rows = "load supply num_chan=2
            run supply.1.update
            in supply.1.d supply.1.value
            out supply.1.q supply.1._q supply.1.variable supply.1._variable
            1 3 | 1 0 3 -3
            0 -2 | 0 1 -2 2";
        assert_eq!(replay::<Supply>(rows), 2);
    }

    #[test]
    fn refusals() {
        for n in ["0", "9", "-1"] {
            let said = Bench::new().load::<Supply>(&[&format!("num_chan={n}")]).unwrap_err();
            assert_eq!(said, format!("SUPPLY: ERROR: invalid num_chan: {n}"));
        }
    }
}
