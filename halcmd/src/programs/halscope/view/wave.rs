//! A channel as lines of characters, with a character for each column.

use hal_trace::columns::Column;

/// Draws a bit in two lines.
pub(super) fn bit(columns: &[Option<Column>]) -> [String; 2] {
    let (mut above, mut below) = (String::new(), String::new());
    let mut was: Option<bool> = None;
    for column in columns {
        let (a, b) = match column {
            None => (' ', ' '),
            Some(c) => {
                let (first, last) = (c.first >= 0.5, c.last >= 0.5);
                // A change may lie between two columns.
                let before = was.unwrap_or(first);
                let changes = c.changes.max(usize::from(before != first));
                match (before, last, changes) {
                    (false, false, 0) => (' ', '─'),
                    (true, true, 0) => ('─', ' '),
                    (false, true, 1) => ('┌', '┘'),
                    (true, false, 1) => ('┐', '└'),
                    // A pulse within the column.
                    (false, false, 1 | 2) => ('╷', '┴'),
                    (true, true, 1 | 2) => ('┬', '╵'),
                    _ => ('▓', '▓'),
                }
            }
        };
        above.push(a);
        below.push(b);
        was = column.map(|c| c.last >= 0.5);
    }
    [above, below]
}

/// Bits of a braille character's dots: two columns of four, from the top.
const DOTS: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// Draws a number in `height` lines, with two columns of data in each character. The limits of the
/// scale are the lowest and the highest dots.
pub(super) fn number(columns: &[Option<Column>], scale: (f64, f64), height: usize) -> Vec<String> {
    let characters = columns.len().div_ceil(2);
    let mut cells = vec![vec![0_u8; characters]; height];
    let levels = height * 4;
    let level = |value: f64| {
        let share = (value - scale.0) / (scale.1 - scale.0);
        // All shown values lie within the scale. A scale of zero width has no fractions.
        let share = if share.is_finite() { share } else { 0.5 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 to the number of levels, which is small"
        )]
        let level = (share * (levels - 1) as f64).round() as usize;
        levels - 1 - level.min(levels - 1)
    };
    let mut was: Option<f64> = None;
    for (i, column) in columns.iter().enumerate() {
        if let Some(c) = column {
            // Starts where the last column ended.
            let low = was.map_or(c.min, |w| w.min(c.min));
            let high = was.map_or(c.max, |w| w.max(c.max));
            for dot in level(high)..=level(low) {
                let cell = cells.get_mut(dot / 4).and_then(|line| line.get_mut(i / 2));
                let bit = DOTS.get(i % 2).and_then(|d| d.get(dot % 4));
                if let (Some(cell), Some(bit)) = (cell, bit) {
                    *cell |= bit;
                }
            }
        }
        was = column.map(|c| c.last);
    }
    let braille = |cell: &u8| match cell {
        0 => ' ',
        dots => char::from_u32(0x2800 + u32::from(*dots)).unwrap_or(' '),
    };
    cells.iter().map(|line| line.iter().map(braille).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::{bit, number};
    use hal_protocol::Type;
    use hal_trace::{Trace, columns::columns};

    fn of(values: &[f64], ty: Type) -> Trace {
        let mut t = Trace::default();
        t.add("x", ty);
        for (i, v) in (0..).zip(values) {
            let bits = if ty == Type::Bit { u64::from(*v != 0.0) } else { v.to_bits() };
            t.push(i, &[bits]).unwrap();
        }
        t
    }

    #[test]
    fn a_bit_looks_as_on_a_scope() {
        let t = of(&[0., 0., 1., 1., 0., 0., 1., 0., 1., 1., 1., 0., 1., 1.], Type::Bit);
        // A column for each sample.
        let [above, below] = bit(&columns(&t, 0, 0, 14, 14));
        assert_eq!(above, "  ┌─┐ ┌┐┌──┐┌─");
        assert_eq!(below, "──┘ └─┘└┘  └┘ ");
        // Two samples in each column: a pulse shorter than a column becomes a spike.
        let [above, below] = bit(&columns(&t, 0, 0, 14, 7));
        assert_eq!((above.as_str(), below.as_str()), (" ┌┐╷┌┐┌", "─┘└┴┘└┘"));
        let [above, _] = bit(&columns(&t, 0, 0, 14, 2));
        assert_eq!(above, "▓▓");
        let [above, below] = bit(&columns(&t, 0, -2, 16, 9));
        assert_eq!((&above[..1], &below[..1]), (" ", " "), "nothing is known there");
    }

    #[test]
    fn a_number_reaches_from_its_least_to_its_greatest() {
        let t = of(&[0., 1., 2., 3., 4., 5., 6., 7.], Type::Float);
        let lines = number(&columns(&t, 0, 0, 8, 8), (0.0, 7.0), 2);
        assert_eq!(lines, ["  ⣠⠞", "⣠⠞⠁ "].map(str::to_owned));
        let flat = of(&[5.; 8], Type::Float);
        let lines = number(&columns(&flat, 0, 0, 8, 8), (5.0, 5.0), 1);
        assert_eq!(lines, ["⠒⠒⠒⠒"]);
        assert_eq!(number(&[None, None], (0.0, 1.0), 1), [" "]);
    }
}
