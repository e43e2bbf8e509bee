//! Realtime. Patterns of three Hall sensors, and the rotor sectors that they indicate.

/// For each pattern, the sensor codes in the order in which a rotor passes them, one octal digit each, with the first
/// sensor as its highest bit. The first code drives from B to A, the next from C to A, C to B, A to B, A to C, and B to
/// C.
const PATTERNS: [u32; 48] = [
    0o013764, 0o102675, 0o023754, 0o132645, 0o231546, 0o320457, 0o201576, 0o310467, 0o015762,
    0o104673, 0o026751, 0o137640, 0o237540, 0o326451, 0o204573, 0o315462, 0o045732, 0o154623,
    0o046731, 0o157620, 0o267510, 0o376401, 0o264513, 0o375402, 0o457320, 0o546231, 0o467310,
    0o576201, 0o675102, 0o764013, 0o645132, 0o754023, 0o451326, 0o540237, 0o462315, 0o573204,
    0o673104, 0o762015, 0o640137, 0o751026, 0o401376, 0o510267, 0o402375, 0o513264, 0o623154,
    0o732045, 0o620157, 0o731046,
];

/// Highest pattern number.
pub(crate) const LAST: u32 = 47;

/// Returns the code of a pattern in a sector, 0 to 5; none beyond the last pattern.
pub(crate) fn code(pattern: u32, sector: usize) -> Option<u8> {
    let digits = *PATTERNS.get(usize::try_from(pattern).ok()?)?;
    let shift = 3 * 5_usize.checked_sub(sector)?;
    Some((digits >> shift & 7) as u8)
}

/// Returns the sector, 0 to 5, in which a pattern has a code.
pub(crate) fn sector(pattern: u32, wanted: u8) -> Option<usize> {
    (0..6).find(|&s| code(pattern, s) == Some(wanted))
}

/// Returns whether two sectors are neighbours.
pub(crate) const fn beside(a: usize, b: usize) -> bool {
    matches!((a + 6 - b) % 6, 1 | 5)
}

#[cfg(test)]
mod tests {
    use super::{LAST, beside, code, sector};

    /// From one sector to the next, one sensor changes; opposite sectors have opposite codes.
    #[test]
    fn patterns_are_plausible() {
        let mut all = Vec::new();
        for pattern in 0..=LAST {
            let codes: Vec<u8> = (0..6).map(|s| code(pattern, s).unwrap()).collect();
            for (s, c) in codes.iter().enumerate() {
                assert_eq!(sector(pattern, *c), Some(s));
                assert_eq!((c ^ codes[(s + 1) % 6]).count_ones(), 1, "{pattern}");
                assert_eq!(c ^ codes[(s + 3) % 6], codes[0] ^ codes[3], "{pattern}");
            }
            all.push(codes);
        }
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 48);
        assert_eq!((code(LAST + 1, 0), code(0, 6), sector(25, 0b111)), (None, None, None));
    }

    #[test]
    fn neighbours() {
        assert!(beside(0, 5) && beside(5, 0) && beside(2, 3));
        assert!(!beside(0, 0) && !beside(0, 2) && !beside(1, 4));
    }
}
