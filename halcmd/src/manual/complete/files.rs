//! Completion of file names for the prompt. Shells complete file names themselves.

use super::Candidate;
use std::path::Path;

/// Returns files and folders whose names begin with `word`. Hidden ones need a '.' in `word`.
pub(super) fn files(word: &str) -> Vec<Candidate> {
    let cut = word.rfind('/').map_or(0, |at| at + 1);
    let (folder, begun) = word.split_at(cut);
    let path = hal_ini::beside(Path::new("."), folder);
    let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
    let names = entries.filter_map(|e| Some((e.file_name().into_string().ok()?, e.path())));
    let fits = |name: &str| {
        let shown = begun.starts_with('.') || !name.starts_with('.');
        // A word of the HAL language contains no spaces.
        shown && name.starts_with(begun) && !name.contains([' ', '\t', '#', '"', '\''])
    };
    names
        .filter(|(name, _)| fits(name))
        .map(|(name, path)| {
            let end = if path.is_dir() { "/" } else { "" };
            Candidate::new(format!("{folder}{name}{end}"), "")
        })
        .collect()
}
