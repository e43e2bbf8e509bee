//! The existing name that is nearest to an unknown one.

/// Returns the candidate nearest to `word`, if one is near enough.
pub(crate) fn nearest<'n>(
    word: &str,
    names: impl IntoIterator<Item = &'n str>,
) -> Option<Box<str>> {
    // Limits the distance so that at least one character of the word remains.
    let far = (1 + word.len() / 4).min(word.len().saturating_sub(1));
    names
        .into_iter()
        .filter(|n| n.len().abs_diff(word.len()) <= far)
        .map(|n| (strsim::damerau_levenshtein(word, n), n))
        .filter(|(d, _)| *d <= far)
        .min()
        .map(|(_, n)| n.into())
}
