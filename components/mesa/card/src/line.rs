//! A line with faults: which packets are lost, late, doubled or cut, by a seed.

/// Fate of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Arrives.
    Delivered,
    /// Never arrives.
    Lost,
    /// Arrives behind the next packet.
    Late,
    /// Arrives twice.
    Doubled,
    /// Arrives with so many of its bytes.
    Cut(usize),
}

impl Fate {
    /// Returns the lengths with which a packet of so many bytes arrives before the next one.
    pub fn arrivals(self, bytes: usize) -> impl Iterator<Item = usize> {
        let (bytes, times) = match self {
            Self::Lost | Self::Late => (0, 0),
            Self::Delivered => (bytes, 1),
            Self::Doubled => (bytes, 2),
            Self::Cut(bytes) => (bytes, 1),
        };
        core::iter::repeat_n(bytes, times)
    }
}

/// Faults of a line, in packets per million.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rates {
    /// Packets that are lost.
    pub lost: u32,
    /// Packets that are late.
    pub late: u32,
    /// Packets that are doubled.
    pub doubled: u32,
    /// Packets that are cut.
    pub cut: u32,
}

/// Line that treats packets by its rates. The same seed gives the same fates.
#[derive(Clone, Copy, Debug)]
pub struct FaultyLine {
    rates: Rates,
    seed: u64,
    is_broken: bool,
}

const MILLION: u64 = 1_000_000;

/// Bits that small seeds are mixed with: those of the golden ratio.
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

impl FaultyLine {
    /// Returns a line with these faults.
    #[must_use]
    pub const fn new(rates: Rates, seed: u64) -> Self {
        // The generator stands still at 0, so the one seed that would begin there begins elsewhere.
        let seed = match seed ^ SPREAD {
            0 => SPREAD,
            seed => seed,
        };
        Self { rates, seed, is_broken: false }
    }

    /// Cuts the cable, or joins it: a broken line loses everything.
    pub const fn break_cable(&mut self, is_broken: bool) {
        self.is_broken = is_broken;
    }

    /// Returns the fate of the next packet, which has so many bytes.
    pub fn carry(&mut self, bytes: usize) -> Fate {
        if self.is_broken {
            return Fate::Lost;
        }
        let Rates { lost, late, doubled, cut } = self.rates;
        let mut draw = self.random() % MILLION;
        for (rate, fate) in [(lost, Fate::Lost), (late, Fate::Late), (doubled, Fate::Doubled)] {
            if draw < u64::from(rate) {
                return fate;
            }
            draw -= u64::from(rate);
        }
        if draw < u64::from(cut) {
            let bytes = u64::try_from(bytes).unwrap_or(u64::MAX).max(1);
            return Fate::Cut(usize::try_from(self.random() % bytes).unwrap_or(0));
        }
        Fate::Delivered
    }

    const fn random(&mut self) -> u64 {
        self.seed ^= self.seed << 13;
        self.seed ^= self.seed >> 7;
        self.seed ^= self.seed << 17;
        self.seed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_kept_and_seeds_repeat() {
        let rates = Rates { lost: 10_000, late: 20_000, doubled: 30_000, cut: 40_000 };
        let fates = |seed| {
            let mut line = FaultyLine::new(rates, seed);
            let mut counts = [0_i32; 5];
            for _ in 0..1_000_000 {
                counts[match line.carry(100) {
                    Fate::Delivered => 0,
                    Fate::Lost => 1,
                    Fate::Late => 2,
                    Fate::Doubled => 3,
                    Fate::Cut(bytes) => {
                        assert!(bytes < 100);
                        4
                    }
                }] += 1;
            }
            counts
        };
        let counts = fates(7);
        for (count, due) in counts.into_iter().zip([900_000, 10_000, 20_000, 30_000, 40_000]) {
            assert!((count - due).abs() < 1_000, "{count} of {due}");
        }
        assert_eq!(fates(7), counts);
        assert_ne!(fates(8), counts);
        assert_ne!(fates(2), fates(3));
        // A generator that stood still would give one fate alone.
        assert!(fates(SPREAD).iter().all(|count| *count > 0));
        let mut broken = FaultyLine::new(Rates::default(), 1);
        assert_eq!(broken.carry(10), Fate::Delivered);
        broken.break_cable(true);
        assert_eq!(broken.carry(10), Fate::Lost);
    }
}
