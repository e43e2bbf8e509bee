//! Writer of pages in `AsciiDoc`.

use super::{
    Page,
    markup::{Block, Run, Style},
};

pub(super) fn write(page: &Page) -> String {
    let mut out = format!("= {}({})\n:manmanual: HAL components\n", page.name, page.chapter);
    for (title, blocks) in &page.sections {
        out.push_str(&format!("\n== {title}\n\n"));
        for block in blocks {
            of(block, &mut out);
        }
    }
    out
}

fn of(block: &Block, out: &mut String) {
    match block {
        Block::Paragraph(runs) => out.push_str(&format!("{}\n\n", line(runs))),
        Block::Item(runs) => out.push_str(&format!("* {}\n", line(runs))),
        Block::Literal(text) => out.push_str(&format!("----\n{text}\n----\n\n")),
        Block::Heading(text) => out.push_str(&format!("=== {text}\n\n")),
        Block::Term(head, body) => {
            out.push_str(&format!("{}::\n", line(head)));
            if body.is_empty() {
                out.push_str("{empty}\n");
            }
            for (i, block) in body.iter().enumerate() {
                let mut text = String::new();
                of(block, &mut text);
                if i > 0 {
                    out.push_str("+\n");
                }
                out.push_str(text.trim_end());
                out.push('\n');
            }
            out.push('\n');
        }
    }
}

fn line(runs: &[Run]) -> String {
    let mut out = String::new();
    for run in runs {
        // Text with characters that are markup in AsciiDoc is passed through literally.
        let text = if run.text.contains(['*', '_', '`', '#', '+', '{', '<', '[', '\\']) {
            format!("pass:c[{}]", run.text.replace(']', "\\]"))
        } else {
            run.text.clone()
        };
        match run.style {
            Style::Plain => out.push_str(&text),
            Style::Bold => out.push_str(&format!("**{text}**")),
            Style::Italic => out.push_str(&format!("__{text}__")),
            Style::Code => out.push_str(&format!("``{text}``")),
        }
    }
    out
}
