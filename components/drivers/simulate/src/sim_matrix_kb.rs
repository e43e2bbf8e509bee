//! `sim_matrix_kb`.
use hal_component::{Component, In, Out, Period, Update};

/// Keyboard of eight rows and columns that outputs codes, as a Mesa 7I73 does.
///
/// Each cycle reports one changed key, the lowest first: its number, row · 8 + column, plus 192 when it is pressed or
/// 128 when it is released. Without a change, the code is 64 while a key is held, else 0.
///
/// # Example
///
/// ```hal
/// loadrt sim_matrix_kb
/// loadrt threads name1=servo period1=1000000
/// addf sim-matrix-kb.0 servo
/// setp sim-matrix-kb.0.button.c01.r02 1
/// start
/// run 1ms
/// getp sim-matrix-kb.0.out # -> 209
/// run 1ms
/// getp sim-matrix-kb.0.out # -> 64
/// ```
#[derive(Component)]
#[hal(name = "sim_matrix_kb")]
pub(crate) struct SimMatrixKb {
    /// Present code.
    out: Out<u32>,
    /// Key of column 0, by row.
    #[hal(name = "button.c00.r##", count = 8_u32)]
    c0: Vec<In<bool>>,
    /// Key of column 1, by row.
    #[hal(name = "button.c01.r##", count = 8_u32)]
    c1: Vec<In<bool>>,
    /// Key of column 2, by row.
    #[hal(name = "button.c02.r##", count = 8_u32)]
    c2: Vec<In<bool>>,
    /// Key of column 3, by row.
    #[hal(name = "button.c03.r##", count = 8_u32)]
    c3: Vec<In<bool>>,
    /// Key of column 4, by row.
    #[hal(name = "button.c04.r##", count = 8_u32)]
    c4: Vec<In<bool>>,
    /// Key of column 5, by row.
    #[hal(name = "button.c05.r##", count = 8_u32)]
    c5: Vec<In<bool>>,
    /// Key of column 6, by row.
    #[hal(name = "button.c06.r##", count = 8_u32)]
    c6: Vec<In<bool>>,
    /// Key of column 7, by row.
    #[hal(name = "button.c07.r##", count = 8_u32)]
    c7: Vec<In<bool>>,
    /// Keys that were reported as pressed, one bit each.
    #[state]
    told: u64,
}

impl Update for SimMatrixKb {
    fn update(&mut self, _: Period) {
        let columns =
            [&self.c0, &self.c1, &self.c2, &self.c3, &self.c4, &self.c5, &self.c6, &self.c7];
        let mut held = 0_u64;
        for (c, column) in columns.iter().enumerate() {
            for (r, key) in column.iter().enumerate() {
                held |= u64::from(key.get()) << (8 * r + c);
            }
        }
        let changed = held ^ self.told;
        let code = changed.trailing_zeros();
        if changed == 0 {
            self.out.set(if self.told == 0 { 0 } else { 64 });
        } else {
            self.told ^= 1 << code;
            let pressed = held >> code & 1 == 1;
            self.out.set(code + if pressed { 192 } else { 128 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::SimMatrixKb;
    use hal_bench::trace::replay;

    #[test]
    fn keys_one_by_one() {
        let rows = "load sim_matrix_kb
            run sim-matrix-kb.0
            in sim-matrix-kb.0.button.c00.r00 sim-matrix-kb.0.button.c01.r02 sim-matrix-kb.0.button.c07.r07
            out sim-matrix-kb.0.out
            0 0 0 | 0
            1 1 1 | 192
            . . . | 209
            . . . | 255
            . . . | 64
            0 1 0 | 128
            0 0 0 | 145
            . . . | 191
            . . . | 0";
        assert_eq!(replay::<SimMatrixKb>(rows), 9);
    }
}
