//! `bin2gray` and `gray2bin`.
use hal_component::{Component, In, Out, Period, Update};

#[cfg(test)]
mod closed;

/// Conversion of a number to Gray code.
///
/// In Gray code, neighbouring numbers differ in one bit only.
///
/// # Example
///
/// ```hal
/// loadrt bin2gray
/// loadrt threads name1=servo period1=1000000
/// addf bin2gray.0 servo
/// start
/// setp bin2gray.0.in 3
/// run 1ms
/// getp bin2gray.0.out # -> 2
/// ```
#[derive(Component)]
#[hal(name = "bin2gray")]
pub(crate) struct Bin2gray {
    /// Input number.
    in_: In<u32>,
    /// Number in Gray code.
    out: Out<u32>,
}

impl Update for Bin2gray {
    fn update(&mut self, _: Period) {
        let n = self.in_.get();
        self.out.set(n ^ (n >> 1));
    }
}

/// Conversion of a number from Gray code.
///
/// # Example
///
/// ```hal
/// loadrt gray2bin
/// loadrt threads name1=servo period1=1000000
/// addf gray2bin.0 servo
/// start
/// setp gray2bin.0.in 2
/// run 1ms
/// getp gray2bin.0.out # -> 3
/// ```
#[derive(Component)]
#[hal(name = "gray2bin")]
pub(crate) struct Gray2bin {
    /// Number in Gray code.
    in_: In<u32>,
    /// Decoded number.
    out: Out<u32>,
}

impl Update for Gray2bin {
    fn update(&mut self, _: Period) {
        let mut n = self.in_.get();
        for shift in [1, 2, 4, 8, 16] {
            n ^= n >> shift;
        }
        self.out.set(n);
    }
}

#[cfg(test)]
mod tests {
    use super::{Bin2gray, Gray2bin};
    use hal_bench::trace::replay;

    #[test]
    fn as_recorded() {
        assert_eq!(replay::<Bin2gray>(include_str!("../traces/bin2gray.txt")), 51);
        assert_eq!(replay::<Gray2bin>(include_str!("../traces/gray2bin.txt")), 51);
    }
}
