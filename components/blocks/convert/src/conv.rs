//! Components `conv_A_B`.
use crate::narrow::Narrow;
use hal_component::{
    Builder, Component, Error, In, Out, ParamRw, Period, Touch, Update, Value, abi::component_flags,
};
use std::marker::PhantomData;

/// Conversion from one type to another.
pub(crate) struct Conv<A, B>(PhantomData<(A, B)>);

impl<A, B> Component for Conv<A, B>
where
    A: Value + Default + Narrow<B> + Send,
    B: Value + Default + Send,
{
    const NAME: &'static str = A::WORDS.0;
    const DOC: &'static str = A::WORDS.1;
    const FLAGS: u32 = component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let input = b.item("in", "Value to convert, in any unit.", A::default())?;
        let output = b.item("out", "Converted value, in the same unit.", B::default())?;
        let range = if A::CAN_FAIL {
            let clamp =
                "True limits a value that does not fit to the nearest one; otherwise it wraps.";
            let out = "With `clamp`, true if the value did not fit; without it, true once any \
                value has changed, even by losing its fraction.";
            Some(Range {
                clamp: b.item("clamp", clamp, false)?,
                out: b.item("out-of-range", out, false)?,
            })
        } else {
            None
        };
        b.function("", "Converts.", Run { input, output, range })
    }
}

#[derive(Touch)]
struct Range {
    clamp: ParamRw<bool>,
    out: Out<bool>,
}

#[derive(Touch)]
struct Run<A: Value, B: Value> {
    input: In<A>,
    output: Out<B>,
    range: Option<Range>,
}

impl<A, B> Update for Run<A, B>
where
    A: Value + Narrow<B> + Send,
    B: Value + Send,
{
    fn update(&mut self, _: Period) {
        let value = self.input.get();
        let Some(range) = &self.range else {
            self.output.set(value.plain().0);
            return;
        };
        if range.clamp.get() {
            let (nearest, is_out) = value.nearest();
            self.output.set(nearest);
            range.out.set(is_out);
        } else {
            let (plain, is_other) = value.plain();
            self.output.set(plain);
            if is_other {
                range.out.set(true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Conv;
    use hal_bench::{Bench, trace::replay};
    use hal_component::Component;

    macro_rules! recorded {
        ($($name:ident: $a:ty, $b:ty, $rows:literal;)*) => {$(
            #[test]
            fn $name() {
                let table = include_str!(concat!("../traces/", stringify!($name), ".txt"));
                assert_eq!(replay::<Conv<$a, $b>>(table), $rows);
            }
        )*};
    }
    recorded! {
        conv_bit_float: bool, f64, 6;
        conv_bit_s32: bool, i32, 6;
        conv_bit_u32: bool, u32, 6;
        conv_float_s32: f64, i32, 104;
        conv_float_u32: f64, u32, 104;
        conv_s32_bit: i32, bool, 28;
        conv_s32_float: i32, f64, 14;
        conv_s32_u32: i32, u32, 28;
        conv_u32_bit: u32, bool, 28;
        conv_u32_float: u32, f64, 14;
        conv_u32_s32: u32, i32, 28;
    }

    /// Conversions with 64 bits, which LinuxCNC 2.9 does not have; expected values computed by hand.
    #[test]
    fn sixty_four_bits() {
        fn check<C: Component>(name: &str, rows: &str) {
            assert_eq!(C::NAME, name);
            let prefix = format!("{}.0", name.replace('_', "-"));
            let table = rows.replace('$', &prefix);
            replay::<C>(&format!(
                "load {name}\nrun {prefix}\nin {prefix}.in\nout {prefix}.out\n{table}"
            ));
        }
        check::<Conv<bool, i64>>("conv_bit_s64", "0 | 0\n1 | 1");
        check::<Conv<bool, u64>>("conv_bit_u64", "0 | 0\n1 | 1");
        check::<Conv<f64, i64>>(
            "conv_float_s64",
            "1e18 | 1000000000000000000\n-2.9 | -2\nset $.clamp 1\n1e300 | 9223372036854775807",
        );
        check::<Conv<f64, u64>>(
            "conv_float_u64",
            "2.9 | 2\nset $.clamp 1\n-1 | 0\n1e300 | 18446744073709551615",
        );
        check::<Conv<i32, i64>>("conv_s32_s64", "-5 | -5\n-2147483648 | -2147483648");
        check::<Conv<i32, u64>>(
            "conv_s32_u64",
            "7 | 7\n-1 | 18446744073709551615\nset $.clamp 1\n-1 | 0\nexpect $.out-of-range 1",
        );
        check::<Conv<i64, bool>>(
            "conv_s64_bit",
            "0 | 0\n-3 | 1\n4294967296 | 1\nset $.clamp 1\n-3 | 0",
        );
        check::<Conv<i64, f64>>("conv_s64_float", "-7 | -7\n-9007199254740993 | -9007199254740992");
        check::<Conv<i64, i32>>(
            "conv_s64_s32",
            "4294967297 | 1\n-5 | -5\nexpect $.out-of-range 1\nset $.clamp 1\n\
             4294967297 | 2147483647\nexpect $.out-of-range 1\n-5 | -5\nexpect $.out-of-range 0",
        );
        check::<Conv<i64, u32>>(
            "conv_s64_u32",
            "4294967297 | 1\n-1 | 4294967295\nset $.clamp 1\n-1 | 0\n4294967296 | 4294967295",
        );
        check::<Conv<i64, u64>>("conv_s64_u64", "-1 | 18446744073709551615\nset $.clamp 1\n-1 | 0");
        check::<Conv<u32, i64>>("conv_u32_s64", "4294967295 | 4294967295");
        check::<Conv<u32, u64>>("conv_u32_u64", "4294967295 | 4294967295");
        check::<Conv<u64, bool>>("conv_u64_bit", "0 | 0\n7 | 1\nexpect $.out-of-range 1");
        check::<Conv<u64, f64>>("conv_u64_float", "7 | 7\n9007199254740993 | 9007199254740992");
        check::<Conv<u64, i32>>(
            "conv_u64_s32",
            "4294967297 | 1\nset $.clamp 1\n4294967297 | 2147483647",
        );
        check::<Conv<u64, i64>>(
            "conv_u64_s64",
            "18446744073709551615 | -1\nset $.clamp 1\n18446744073709551615 | 9223372036854775807",
        );
        check::<Conv<u64, u32>>(
            "conv_u64_u32",
            "4294967297 | 1\nset $.clamp 1\n4294967297 | 4294967295",
        );
    }

    #[test]
    fn only_what_can_fail_says_so() {
        let mut bench = Bench::new();
        bench.load::<Conv<i32, f64>>(&[]).unwrap();
        assert_eq!(bench.names(), ["conv-s32-float.0.in s32 IN", "conv-s32-float.0.out float OUT"]);
        let mut bench = Bench::new();
        bench.load::<Conv<f64, i32>>(&[]).unwrap();
        assert_eq!(bench.names().len(), 4);
    }
}
