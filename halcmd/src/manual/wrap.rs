//! Sentences and lines of text for a terminal.

/// Assumed width of a terminal in columns.
pub(crate) const WIDTH: usize = 78;

/// Makes a sentence: a capital letter at the beginning (unless the text begins with a quotation),
/// and a full stop at the end if there is none.
pub(crate) fn sentence(text: &str) -> String {
    let mut rest = text.chars();
    let first = rest.next().map(|c| c.to_ascii_uppercase());
    let stop = if text.ends_with(['.', '?']) { "" } else { "." };
    format!("{}{}{stop}", first.unwrap_or_default(), rest.as_str())
}

/// Wraps a text to the width of a terminal, indented by `by`.
pub(crate) fn wrapped(text: &str, by: usize) -> String {
    let mut out = " ".repeat(by);
    let mut at = by;
    for word in text.split(' ') {
        let length = word.chars().count();
        if at > by && at + 1 + length > WIDTH {
            out.push('\n');
            out.push_str(&" ".repeat(by));
            at = by;
        } else if at > by {
            out.push(' ');
            at += 1;
        }
        out.push_str(word);
        at += length;
    }
    out + "\n"
}
