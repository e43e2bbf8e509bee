//! Parameter files: lines of a number and a value.

use super::{COUNT, Numbered};

/// The parameters that a parameter file always has.
pub const REQUIRED: [(i32, i32); 12] = [
    (5161, 5169),
    (5181, 5189),
    (5210, 5219),
    (5220, 5230),
    (5241, 5250),
    (5261, 5270),
    (5281, 5290),
    (5301, 5310),
    (5321, 5330),
    (5341, 5350),
    (5361, 5370),
    (5381, 5390),
];

/// Something wrong in a parameter file; the rest was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finding {
    /// The line lacks a number and a value.
    Malformed {
        /// The line, from 1.
        line: u32,
    },
    /// The number is out of range.
    OutOfRange {
        /// The line, from 1.
        line: u32,
    },
    /// The number came before; the last value counts.
    Duplicate {
        /// The line, from 1.
        line: u32,
    },
    /// The last line has no end: the file may have been cut off.
    NoLineEnd,
}

/// A parameter file: the values and what was wrong with the rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterFile {
    /// The numbers with their values, in the order of the file.
    pub values: Vec<(i32, f64)>,
    /// The findings.
    pub findings: Vec<Finding>,
}

impl ParameterFile {
    /// Parses the text of a parameter file. Lines that cannot be read are reported.
    pub fn parse(text: &str) -> Self {
        let mut out = Self::default();
        for (line, text) in (1u32..).zip(text.lines()) {
            let text = text.split(['#', ';']).next().unwrap_or_default().trim();
            if text.is_empty() {
                continue;
            }
            let mut parts = text.split_whitespace();
            let number = parts.next().and_then(|p| p.parse::<i32>().ok());
            let value = parts.next().and_then(|p| p.parse::<f64>().ok()).filter(|v| v.is_finite());
            let (Some(number), Some(value)) = (number, value) else {
                out.findings.push(Finding::Malformed { line });
                continue;
            };
            if !(1..i32::try_from(COUNT).unwrap_or(0)).contains(&number) {
                out.findings.push(Finding::OutOfRange { line });
                continue;
            }
            if out.values.iter().any(|(n, _)| *n == number) {
                out.findings.push(Finding::Duplicate { line });
            }
            out.values.push((number, value));
        }
        if !text.is_empty() && !text.ends_with('\n') {
            out.findings.push(Finding::NoLineEnd);
        }
        out
    }

    /// Sets the parameters that the file has.
    pub fn apply(&self, to: &mut Numbered) {
        for (number, value) in &self.values {
            to.put(*number, *value);
        }
    }

    /// Returns the text of a file with the required parameters and those that this file has.
    pub fn save(&self, from: &Numbered) -> String {
        let mut numbers: Vec<i32> = REQUIRED.iter().flat_map(|(a, b)| *a..=*b).collect();
        numbers.extend(self.values.iter().map(|(n, _)| *n));
        numbers.sort_unstable();
        numbers.dedup();
        numbers.iter().map(|n| format!("{n}\t{:.6}\n", from.get(*n))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_be_read_is_read() {
        let file = ParameterFile::parse("5161 1.5\n5162 x\n9999 1\n# note\n5161 2\n5163 3");
        assert_eq!(file.values, [(5161, 1.5), (5161, 2.0), (5163, 3.0)]);
        let findings = [
            Finding::Malformed { line: 2 },
            Finding::OutOfRange { line: 3 },
            Finding::Duplicate { line: 5 },
            Finding::NoLineEnd,
        ];
        assert_eq!(file.findings, findings);
        let mut numbered = Numbered::default();
        file.apply(&mut numbered);
        let again = ParameterFile::parse(&file.save(&numbered));
        assert!(again.findings.is_empty());
        assert!(again.values.contains(&(5161, 2.0)) && again.values.contains(&(5390, 0.0)));
    }
}
