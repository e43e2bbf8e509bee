//! A row of the table of explanations.

use hal_protocol::Code;

/// Explanation of a code. Tests run its two examples.
#[derive(Clone, Copy, Debug)]
pub struct Explanation {
    /// Code of the finding.
    pub code: Code,
    /// Meaning, in whole sentences.
    pub means: &'static str,
    /// Consequences.
    pub matters: &'static str,
    /// Remedy.
    pub remedy: &'static str,
    /// A script with the finding on the line that ends in `# <--`. Files begin with `--- NAME`; the
    /// first file is `m.hal`.
    pub wrong: &'static str,
    /// The corrected script, without errors and warnings.
    pub right: &'static str,
}
