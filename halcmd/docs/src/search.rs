//! Sections of the manual, and those that a search finds.

use crate::CHAPTERS;
use std::io;

/// Part of a chapter below a heading, up to the next one.
#[derive(Clone, Debug)]
pub struct Section {
    /// Title of the chapter.
    pub chapter: &'static str,
    /// Heading.
    pub title: String,
    /// Markdown below the heading, without the backslashes that keep a character from its meaning.
    pub text: String,
}

/// Returns all sections in their order.
///
/// # Errors
/// The program is damaged.
pub fn sections() -> io::Result<Vec<Section>> {
    let mut all: Vec<Section> = Vec::new();
    for chapter in CHAPTERS {
        let mut is_code = false;
        for line in chapter.text()?.lines() {
            is_code ^= line.starts_with("```");
            let heading = line.trim_start_matches('#');
            if !is_code && line.starts_with('#') && heading.starts_with(' ') {
                let (title, text) = (unescaped(heading.trim()), String::new());
                all.push(Section { chapter: chapter.title, title, text });
            } else if let Some(section) = all.last_mut().filter(|_| !line.starts_with("<!--")) {
                section.text += &if is_code { line.to_owned() } else { unescaped(line) };
                section.text.push('\n');
            }
        }
    }
    Ok(all)
}

/// Returns a line of Markdown without the backslashes before punctuation. In `code` a backslash is itself.
fn unescaped(line: &str) -> String {
    let (mut out, mut is_code) = (String::with_capacity(line.len()), false);
    let mut rest = line.chars().peekable();
    while let Some(c) = rest.next() {
        let escaped = rest.next_if(|next| c == '\\' && !is_code && next.is_ascii_punctuation());
        is_code ^= c == '`';
        out.push(escaped.unwrap_or(c));
    }
    out
}

/// Returns the sections that have every word, best first: those with more of the words in their heading, then those that repeat
/// them more often.
///
/// # Errors
/// The program is damaged.
pub fn search(words: &[String]) -> io::Result<Vec<Section>> {
    let words: Vec<String> =
        words.iter().flat_map(|w| w.split_whitespace()).map(str::to_lowercase).collect();
    let mut found: Vec<((usize, usize), Section)> = Vec::new();
    for section in sections()? {
        let title = section.title.to_lowercase();
        let chapter = section.chapter.to_lowercase();
        let text = section.text.to_lowercase();
        let has = |word: &String| {
            title.contains(word.as_str())
                || chapter.contains(word.as_str())
                || text.contains(word.as_str())
        };
        if words.iter().all(has) {
            let in_title = words.iter().filter(|w| title.contains(w.as_str())).count();
            let often = words.iter().map(|w| text.matches(w.as_str()).count()).sum();
            found.push(((in_title, often), section));
        }
    }
    found.sort_by_key(|(rank, _)| std::cmp::Reverse(*rank));
    Ok(found.into_iter().map(|(_, section)| section).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_counts_more_than_a_text() {
        let words = ["homing".to_owned()];
        let found = search(&words).unwrap();
        let first = found.iter().take_while(|s| s.title.to_lowercase().contains("homing")).count();
        assert!(first > 0 && found.len() > first, "{first} of {}", found.len());
        assert!(found.iter().skip(first).all(|s| !s.title.to_lowercase().contains("homing")));
    }

    #[test]
    fn a_section_is_read_in_a_terminal() {
        for (markdown, want) in [
            (r"the file of \[EMCIO]TOOL\_TABLE, \*once\*", "the file of [EMCIO]TOOL_TABLE, *once*"),
            (r"`a\_b` and `\[x]`, C:\new \", r"`a\_b` and `\[x]`, C:\new \"),
            (r"\`a\_b\` \\[", r"`a_b` \["),
            ("äöü", "äöü"),
        ] {
            assert_eq!(unescaped(markdown), want);
        }
        let found = search(&["[EMCIO]TOOL_TABLE".to_owned()]).unwrap();
        assert!(!found.is_empty());
        assert!(found.iter().all(|s| !s.text.contains("\\[")), "{found:?}");
    }

    #[test]
    fn every_word_is_there_in_any_case() {
        let words = ["PARALLEL".to_owned(), "port".to_owned()];
        let found = search(&words).unwrap();
        assert!(!found.is_empty());
        for section in found {
            let text =
                format!("{} {} {}", section.chapter, section.title, section.text).to_lowercase();
            assert!(text.contains("parallel") && text.contains("port"), "{}", section.title);
        }
        assert!(search(&["zzzz".to_owned()]).unwrap().is_empty());
    }
}
