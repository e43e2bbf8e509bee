//! Configuration of one motor of `bldc`: the letters of its part of `cfg=`.
use hal_component::Error;

/// Letters with their bits and meanings.
const LETTERS: [(char, u32, &str); 11] = [
    ('n', 0, "no feedback"),
    ('h', 0x1, "Hall sensors"),
    ('a', 0x2, "absolute encoder"),
    ('q', 0x4, "incremental encoder"),
    ('i', 0x8, "index"),
    ('f', 0x10, "Fanuc's Gray code"),
    ('B', 0x100, "bits out"),
    ('6', 0x200, "six outputs"),
    ('H', 0x400, "Hall codes out"),
    ('F', 0x800, "Fanuc's Gray code out"),
    ('T', 0x1000, "trapezoidal"),
];

/// Source of the rotor angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Feedback {
    /// No feedback: the rotor turns at `frequency`.
    None,
    /// Hall sensors alone.
    Hall,
    /// Counts with a known zero.
    Counts,
    /// Counts, after the motor was aligned to zero.
    Align,
    /// Hall sensors until their first change, then counts.
    HallThenCounts,
    /// Counts, after the motor was turned to the index.
    Index,
    /// Hall sensors until the index, then counts.
    HallThenIndex,
    /// Four bits of Gray code.
    Gray,
}

/// Type of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Drive {
    Values,
    Bits,
    SixValues,
    SixBits,
    Hall,
    Gray,
}

/// Parsed part of `cfg=`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Letters {
    bits: u32,
    pub(crate) feedback: Feedback,
    pub(crate) drive: Drive,
}

impl Letters {
    /// Parses a text such as `qhB6`.
    pub(crate) fn read(text: &str) -> Result<Self, Error> {
        let refused = |why: String| Error::new(format!("cfg={text}: {why}"));
        let mut bits = 0;
        for letter in text.chars() {
            let known = LETTERS.iter().find(|(l, ..)| *l == letter);
            let Some((_, bit, _)) = known else {
                let legal: Vec<String> =
                    LETTERS.iter().map(|(l, _, means)| format!("{l} {means}")).collect();
                let legal = legal.join(", ");
                return Err(refused(format!("'{letter}' is no letter of it; these are: {legal}")));
            };
            bits |= bit;
        }
        if text.is_empty() {
            return Err(refused("a motor needs a letter, such as n for no feedback".to_owned()));
        }
        let has = |letter: char| LETTERS.iter().any(|(l, bit, _)| *l == letter && bits & bit != 0);
        let feedback = match (has('h'), has('a'), has('q'), has('i'), has('f')) {
            (_, true, true, ..) => Err("a and q are two encoders on one motor"),
            (true, .., true) | (_, true, .., true) | (_, _, true, _, true) | (.., true, true) => {
                Err("f goes with no other feedback")
            }
            (false, false, false, true, false) => Err("i needs q; an index alone drives no motor"),
            (_, true, ..) => Ok(Feedback::Counts),
            (.., true) => Ok(Feedback::Gray),
            (true, _, true, true, _) => Ok(Feedback::HallThenIndex),
            (true, _, true, false, _) => Ok(Feedback::HallThenCounts),
            (true, ..) => Ok(Feedback::Hall),
            (_, _, true, true, _) => Ok(Feedback::Index),
            (_, _, true, false, _) => Ok(Feedback::Align),
            (false, false, false, false, false) => Ok(Feedback::None),
        };
        let feedback = feedback.map_err(|why| refused(why.to_owned()))?;
        let drive = match (has('H'), has('F'), has('B'), has('6')) {
            (true, true, b, six) if b || six => {
                return Err(refused("H and F together go with neither B nor 6".to_owned()));
            }
            (true, ..) => Drive::Hall,
            (_, true, ..) => Drive::Gray,
            (_, _, true, true) => Drive::SixBits,
            (_, _, true, false) => Drive::Bits,
            (_, _, false, true) => Drive::SixValues,
            (false, false, false, false) => Drive::Values,
        };
        Ok(Self { bits, feedback, drive })
    }

    /// Returns whether any of these letters is present.
    pub(crate) fn any(self, letters: &str) -> bool {
        LETTERS.iter().any(|(l, bit, _)| letters.contains(*l) && self.bits & bit != 0)
    }

    /// Returns whether a pin starts the motor's alignment.
    pub(crate) fn aligns(self) -> bool {
        self.any("q") && !self.any("h")
    }

    /// Returns the value of `in-type`.
    pub(crate) const fn in_type(self) -> i32 {
        match self.feedback {
            Feedback::None => 0,
            Feedback::Hall => 1,
            Feedback::Counts => 2,
            Feedback::Align => 4,
            Feedback::HallThenCounts => 5,
            Feedback::Index => 12,
            Feedback::HallThenIndex => 13,
            Feedback::Gray => 16,
        }
    }

    /// Returns the values of `in-type` and `out-type` for all letters, even those that others override.
    pub(crate) const fn given(self) -> (i32, i32) {
        ((self.bits & 0x1f).cast_signed(), (self.bits & 0xf00).cast_signed())
    }

    /// Returns the value of `out-type`.
    pub(crate) const fn out_type(self) -> i32 {
        match self.drive {
            Drive::Values => 0,
            Drive::Bits => 0x100,
            Drive::SixValues => 0x200,
            Drive::SixBits => 0x300,
            Drive::Hall => 0x400,
            Drive::Gray => 0x800,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Drive, Feedback, Letters};

    #[test]
    fn feedback_and_drive() {
        for (text, in_type, out_type) in [
            ("n", 0, 0),
            ("h", 1, 0),
            ("hi", 1, 0),
            ("a", 2, 0),
            ("ha", 2, 0),
            ("ihaT", 2, 0),
            ("q", 4, 0),
            ("qh", 5, 0),
            ("iq", 12, 0),
            ("hqi", 13, 0),
            ("f", 16, 0),
            ("nB", 0, 0x100),
            ("n6", 0, 0x200),
            ("6nB", 0, 0x300),
            ("B6T", 0, 0x300),
            ("aH", 2, 0x400),
            ("aHB", 2, 0x400),
            ("aHF", 2, 0x400),
            ("aF6", 2, 0x800),
        ] {
            let letters = Letters::read(text).unwrap();
            assert_eq!((letters.in_type(), letters.out_type()), (in_type, out_type), "{text}");
        }
        let letters = Letters::read("qB6T").unwrap();
        assert_eq!((letters.feedback, letters.drive), (Feedback::Align, Drive::SixBits));
        assert!(letters.aligns() && letters.any("xT") && !letters.any("hH"));
    }

    #[test]
    fn refusals() {
        for (text, why) in [
            (
                "qx",
                "'x' is no letter of it; these are: n no feedback, h Hall sensors, a absolute encoder",
            ),
            ("t", "'t' is no letter"),
            ("q 6", "' ' is no letter"),
            ("", "a motor needs a letter"),
            ("aq", "a and q are two encoders"),
            ("haqi", "a and q are two encoders"),
            ("i", "i needs q"),
            ("if", "f goes with no other"),
            ("hf", "f goes with no other"),
            ("af", "f goes with no other"),
            ("qf", "f goes with no other"),
            ("nBHF", "H and F together"),
        ] {
            let said = Letters::read(text).unwrap_err();
            let said = said.text().unwrap().to_owned();
            assert!(said.starts_with(&format!("cfg={text}: {why}")), "{said}");
        }
    }
}
