//! Judgement of the jitter of a computer for software that makes steps.

/// Band of the largest jitter. The printer's document names three; what lies between them has words of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Band {
    /// Below 20 µs.
    VeryGood,
    /// From 20 to 30 µs: between very good and still good.
    Good,
    /// From 30 to 50 µs.
    StillGood,
    /// From 50 to 100 µs: between still good and not suitable.
    Doubtful,
    /// Above 100 µs.
    NotSuitable,
}

/// Bands with their upper limits in nanoseconds, their names for programs, and their words.
const BANDS: [(Band, i64, &str, &str); 5] = [
    (Band::VeryGood, 20_000, "very-good", "very good"),
    (Band::Good, 30_000, "good", "between very good and still good"),
    (Band::StillGood, 50_000, "still-good", "still good"),
    (Band::Doubtful, 100_000, "doubtful", "between still good and not suitable"),
    (Band::NotSuitable, i64::MAX, "not-suitable", "not suitable for steps made by software"),
];

impl Band {
    /// Returns the band of a jitter in nanoseconds.
    #[must_use]
    pub fn of(jitter_ns: i64) -> Self {
        let found = BANDS.iter().find(|(_, limit, ..)| jitter_ns <= *limit);
        found.map_or(Self::NotSuitable, |(band, ..)| *band)
    }

    fn row(self) -> (&'static str, &'static str) {
        let found = BANDS.iter().find(|(band, ..)| *band == self);
        found.map_or(("", ""), |(_, _, name, words)| (name, words))
    }

    /// Returns the name for programs, such as `still-good`.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.row().0
    }

    /// Returns the words for people.
    #[must_use]
    pub fn words(self) -> &'static str {
        self.row().1
    }
}

#[cfg(test)]
mod tests {
    use super::Band;

    #[test]
    fn each_jitter_has_the_band_of_the_document() {
        for (ns, words) in [
            (0, "very good"),
            (11_732, "very good"),
            (20_000, "very good"),
            (20_001, "between very good and still good"),
            (30_001, "still good"),
            (50_000, "still good"),
            (50_001, "between still good and not suitable"),
            (100_000, "between still good and not suitable"),
            (100_001, "not suitable for steps made by software"),
            (i64::MAX, "not suitable for steps made by software"),
        ] {
            assert_eq!(Band::of(ns).words(), words, "{ns}");
        }
        assert!(Band::of(1) < Band::of(60_000), "a smaller jitter is better");
    }
}
