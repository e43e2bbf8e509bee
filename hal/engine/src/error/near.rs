//! The existing name that is nearest to an unknown one.

/// Returns the candidate nearest to `word`, if one is near enough: a quarter of the characters and one more may differ.
pub(crate) fn nearest<'n>(
    word: &str,
    names: impl IntoIterator<Item = &'n str>,
) -> Option<Box<str>> {
    // At least one character of the word remains, also of a short one.
    let most = (1 + word.len() / 4).min(word.len().saturating_sub(1));
    hal_protocol::nearest(word, most, names)
}
