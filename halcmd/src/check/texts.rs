//! The texts of the checked files.

use std::collections::BTreeMap;

/// Lines of the files that can be read, by name. They are needed for lines with a caret, and for
/// allowances.
pub type Texts = BTreeMap<String, Vec<String>>;
