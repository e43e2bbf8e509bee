//! Writer of pages in roff, for `man`.

use super::{
    Page,
    markup::{Block, Run, Style},
};

pub(super) fn write(page: &Page) -> String {
    let mut out = format!(
        ".\\\" Made by halcompile.\n.TH \"{}\" \"{}\" \"\" \"Ferrule\" \"HAL components\"\n.ad l\n",
        plain(&page.name.to_uppercase()),
        page.chapter
    );
    for (title, blocks) in &page.sections {
        out.push_str(&format!(".SH {title}\n"));
        all(blocks, &mut out, true);
    }
    out
}

/// Writes blocks; the first paragraph of a section or term needs no separator before it.
fn all(blocks: &[Block], out: &mut String, mut first: bool) {
    for block in blocks {
        match block {
            Block::Paragraph(runs) => {
                if !first {
                    out.push_str(".PP\n");
                }
                line(runs, out);
            }
            Block::Item(runs) => {
                out.push_str(".IP \\(bu 2\n");
                line(runs, out);
            }
            Block::Literal(text) => {
                out.push_str(".PP\n.RS 4\n.nf\n");
                for l in text.lines() {
                    out.push_str(&guarded(&plain(l)));
                    out.push('\n');
                }
                out.push_str(".fi\n.RE\n");
            }
            Block::Heading(text) => out.push_str(&format!(".SS {}\n", plain(text))),
            Block::Term(head, body) => {
                out.push_str(".TP\n");
                line(head, out);
                if let Some((Block::Paragraph(runs), rest)) = body.split_first() {
                    line(runs, out);
                    if !rest.is_empty() {
                        out.push_str(".RS\n");
                        all(rest, out, false);
                        out.push_str(".RE\n");
                    }
                } else {
                    all(body, out, true);
                }
            }
        }
        first = matches!(block, Block::Heading(_));
    }
}

fn line(runs: &[Run], out: &mut String) {
    let mut text = String::new();
    for run in runs {
        let font = match run.style {
            Style::Plain => None,
            Style::Bold | Style::Code => Some('B'),
            Style::Italic => Some('I'),
        };
        match font {
            Some(font) => text.push_str(&format!("\\f{font}{}\\fR", plain(&run.text))),
            None => text.push_str(&plain(&run.text)),
        }
    }
    out.push_str(&guarded(&text));
    out.push('\n');
}

/// Escapes a line that `man` would take for a request.
fn guarded(line: &str) -> String {
    if line.starts_with(['.', '\'']) { format!("\\&{line}") } else { line.to_owned() }
}

fn plain(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '\\' => out.push_str("\\e"),
            '-' => out.push_str("\\-"),
            '"' => out.push_str("\\(dq"),
            '\'' => out.push_str("\\(aq"),
            '`' => out.push_str("\\(ga"),
            '^' => out.push_str("\\(ha"),
            '~' => out.push_str("\\(ti"),
            // A tab would jump, and other control characters would break the page.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
