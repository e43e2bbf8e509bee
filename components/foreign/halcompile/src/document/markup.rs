//! Markup in doc texts: that of `AsciiDoc` and reST, and the fonts of manual pages.

/// Block of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Block {
    /// Paragraph, whose lines are filled.
    Paragraph(Vec<Run>),
    /// List item.
    Item(Vec<Run>),
    /// Literal text.
    Literal(String),
    /// Heading within a section.
    Heading(String),
    /// Name and its description.
    Term(Vec<Run>, Vec<Block>),
}

/// Text in one font.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Run {
    pub(crate) style: Style,
    pub(crate) text: String,
}

/// Font of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Style {
    Plain,
    Bold,
    Italic,
    Code,
}

/// Splits a text into paragraphs, lists and indented blocks.
pub(crate) fn blocks(text: &str) -> Vec<Block> {
    let mut out = Vec::new();
    let mut filled = String::new();
    let mut literal = String::new();
    let mut fenced = false;
    for line in text.trim_matches('\n').lines().chain([""]) {
        let line = line.trim_end();
        if matches!(line, "----" | "...." | "```") {
            fill(&mut filled, &mut out);
            fenced = !fenced;
            keep(&mut literal, &mut out);
        } else if fenced || (filled.is_empty() && line.starts_with([' ', '\t'])) {
            literal.push_str(line);
            literal.push('\n');
        } else if line.is_empty() {
            fill(&mut filled, &mut out);
            if !literal.is_empty() {
                literal.push('\n');
            }
        } else {
            keep(&mut literal, &mut out);
            line_of(line, &mut filled, &mut out);
        }
    }
    fill(&mut filled, &mut out);
    keep(&mut literal, &mut out);
    out
}

fn line_of(line: &str, filled: &mut String, out: &mut Vec<Block>) {
    let heading = line.trim_start_matches('=');
    if heading.len() < line.len() && heading.starts_with(' ') {
        fill(filled, out);
        out.push(Block::Heading(heading.trim().trim_end_matches('=').trim().to_owned()));
        return;
    }
    // A roff request: all but a few only separate paragraphs.
    if line.starts_with('.') && line.get(1..3).is_some_and(|r| r.chars().all(char::is_alphabetic)) {
        fill(filled, out);
        let (request, words) = line.split_once(' ').unwrap_or((line, ""));
        let words = words.trim().trim_matches('"');
        match request {
            ".SH" | ".SS" if !words.is_empty() => out.push(Block::Heading(words.to_owned())),
            ".B" => filled.push_str(&format!("\\fB{words}\\fR\n")),
            ".I" => filled.push_str(&format!("\\fI{words}\\fR\n")),
            _ => {}
        }
        return;
    }
    if let Some(item) = line.strip_prefix("* ").or_else(|| line.strip_prefix("- ")) {
        fill(filled, out);
        // The lines that follow continue the item.
        filled.push('\u{1}');
        filled.push_str(item.trim());
        filled.push('\n');
        return;
    }
    filled.push_str(line.trim());
    filled.push('\n');
}

fn fill(filled: &mut String, out: &mut Vec<Block>) {
    let text = core::mem::take(filled);
    match text.strip_prefix('\u{1}') {
        Some(item) => out.push(Block::Item(runs(item.trim()))),
        None if text.trim().is_empty() => {}
        None => out.push(Block::Paragraph(runs(text.trim()))),
    }
}

fn keep(literal: &mut String, out: &mut Vec<Block>) {
    let text = core::mem::take(literal);
    let text = text.trim_matches('\n');
    if !text.is_empty() {
        let indent = |l: &str| l.len() - l.trim_start().len();
        let least = text.lines().filter(|l| !l.trim().is_empty()).map(indent).min().unwrap_or(0);
        let lines: Vec<&str> = text.lines().map(|l| l.get(least..).unwrap_or_default()).collect();
        out.push(Block::Literal(lines.join("\n")));
    }
}

/// Splits a text by font.
pub(crate) fn runs(text: &str) -> Vec<Run> {
    let mut out: Vec<Run> = Vec::new();
    let mut style = Style::Plain;
    let mut rest = text;
    let mut push = |style: Style, text: &str| {
        match out.last_mut() {
            Some(last) if last.style == style => last.text.push_str(text),
            _ if text.is_empty() => {}
            _ => out.push(Run { style, text: text.to_owned() }),
        };
    };
    let mut before = ' ';
    while let Some(c) = rest.chars().next() {
        if let Some((long, font)) = escape(rest) {
            match font {
                Ok(font) => style = font,
                Err(text) => push(style, text),
            }
            rest = rest.get(long..).unwrap_or_default();
            before = ' ';
            continue;
        }
        if let Some((mark, font)) = mark(rest).filter(|_| !before.is_alphanumeric())
            && let Some(inside) = inside(rest, mark)
        {
            push(font, inside);
            rest = rest.get(inside.len() + 2 * mark.len()..).unwrap_or_default();
            before = ' ';
            continue;
        }
        let (one, tail) = rest.split_at_checked(c.len_utf8()).unwrap_or_default();
        push(style, if c == '\n' { " " } else { one });
        before = c;
        rest = tail;
    }
    out
}

/// Parses `\fB` and other font escapes, and escaped characters of manual pages.
fn escape(text: &str) -> Option<(usize, Result<Style, &'static str>)> {
    const FONTS: &[(&str, Style)] = &[
        ("\\fB", Style::Bold),
        ("\\fI", Style::Italic),
        ("\\fR", Style::Plain),
        ("\\fP", Style::Plain),
        ("\\fC", Style::Code),
    ];
    const SIGNS: &[(&str, &str)] = &[
        ("\\-", "-"),
        ("\\&", ""),
        ("\\|", ""),
        ("\\(bu", "*"),
        ("\\(em", "--"),
        ("\\ ", " "),
        ("\\e", "\\"),
    ];
    let font = FONTS.iter().find(|(e, _)| text.starts_with(e)).map(|(e, s)| (e.len(), Ok(*s)));
    font.or_else(|| {
        SIGNS.iter().find(|(e, _)| text.starts_with(e)).map(|(e, s)| (e.len(), Err(*s)))
    })
}

/// Returns the mark that may begin text in another font.
fn mark(text: &str) -> Option<(&'static str, Style)> {
    const MARKS: &[(&str, Style)] = &[
        ("**", Style::Bold),
        ("``", Style::Code),
        ("*", Style::Bold),
        ("`", Style::Code),
        ("_", Style::Italic),
    ];
    MARKS.iter().find(|(m, _)| text.starts_with(m)).copied()
}

/// Returns the text up to the closing mark; it neither begins nor ends with a blank, nor spans a paragraph end.
fn inside<'a>(text: &'a str, mark: &str) -> Option<&'a str> {
    let rest = text.get(mark.len()..)?;
    let long = rest.find(mark)?;
    let inside = rest.get(..long)?;
    let after = rest.get(long + mark.len()..)?.chars().next();
    let fits = !inside.is_empty() && inside.trim() == inside && !inside.contains('\n');
    (fits && !after.is_some_and(char::is_alphanumeric)).then_some(inside)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(text: &str) -> String {
        let mark = |r: &Run| match r.style {
            Style::Plain => r.text.clone(),
            Style::Bold => format!("<b>{}</b>", r.text),
            Style::Italic => format!("<i>{}</i>", r.text),
            Style::Code => format!("<c>{}</c>", r.text),
        };
        runs(text).iter().map(mark).collect()
    }

    #[test]
    fn fonts() {
        assert_eq!(shown(r"a \fBb\fR c \fId\fP\-e"), "a <b>b</b> c <i>d</i>-e");
        assert_eq!(
            shown("**a** *b* `c` ``d`` _e_"),
            "<b>a</b> <b>b</b> <c>c</c> <c>d</c> <i>e</i>"
        );
        assert_eq!(shown("2 * 3 * 4, a_b_c, *open, x*y*z"), "2 * 3 * 4, a_b_c, *open, x*y*z");
    }

    #[test]
    fn parts() {
        let got = blocks(
            "One\ntwo.\n\n * literal\n   it is\n\n* item\n  goes on\n* next\n\n== Head\n.TP\nlast",
        );
        let text = |t: &str| vec![Run { style: Style::Plain, text: t.to_owned() }];
        let want = vec![
            Block::Paragraph(text("One two.")),
            Block::Literal("* literal\n  it is".to_owned()),
            Block::Item(text("item goes on")),
            Block::Item(text("next")),
            Block::Heading("Head".to_owned()),
            Block::Paragraph(text("last")),
        ];
        assert_eq!(got, want);
    }
}
