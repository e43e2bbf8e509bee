//! A manual page in the format of `man`, for the system's path.

use super::{
    Page,
    grid::grid,
    prose::Doc,
    text::{argument_title, funct_title, item_title, plain, summary, synopsis},
};
use crate::manual::escaped;
use hal_protocol::ArgInfo;

impl Page {
    /// Returns the page in the format of `man`, for section 9, as LinuxCNC has its components.
    #[must_use]
    pub fn roff(&self) -> String {
        let doc = Doc::of(&self.offer.doc);
        let name = &self.offer.component;
        let mut out =
            String::from(".\\\" Made by 'halcmd man --roff' from what the plugin says.\n");
        out.push_str(&format!(
            ".TH \"{}\" 9 \"\" Ferrule \"HAL component\"\n",
            name.to_uppercase()
        ));
        // One line, which `apropos` reads: name, dash, summary.
        section(&mut out, "NAME", &format!("{} \\- {}\n", escaped(name), escaped(&summary(&doc))));
        let mut load = format!(".B {}\n", escaped(&synopsis(name, &self.offer.args)));
        let library = &self.offer.library;
        if !library.is_empty() && library != name {
            load.push_str(&paragraph(&format!("It is in the library '{library}'.")));
        }
        if !self.also.is_empty() {
            load.push_str(&paragraph(&format!("It is also called {}.", self.also.join(", "))));
        }
        section(&mut out, "SYNOPSIS", &load);
        section(&mut out, "DESCRIPTION", &prose(&doc.paragraphs));
        section(&mut out, "ARGUMENTS", &self.offer.args.iter().map(argument).collect::<String>());
        let loaded = match &self.refused {
            Some(why) => paragraph(&format!("Nothing of it could be made: {why}.")),
            None => as_is(&self.loaded_lines()),
        };
        section(&mut out, "LOADED HERE AS", &loaded);
        for (title, are_pins) in [("PINS", true), ("PARAMETERS", false)] {
            let items = self.items.iter().filter(|e| e.direction.is_pin() == are_pins);
            let items: String = items.map(|e| entry(&item_title(e), &e.doc)).collect();
            section(&mut out, title, &items);
        }
        let functions: String =
            self.functs.iter().map(|f| entry(&funct_title(f), &f.doc)).collect();
        section(&mut out, "FUNCTIONS", &functions);
        let commands = self.commands.iter().map(|c| {
            let args: String = c.args.iter().map(argument).collect();
            let args = if args.is_empty() { args } else { format!(".RS\n{args}.RE\n") };
            entry(&c.name, &c.doc) + &args
        });
        section(&mut out, "COMMANDS", &commands.collect::<String>());
        let example = as_is(&doc.example.unwrap_or_default());
        section(&mut out, "EXAMPLE", &(prose(&doc.before) + &example));
        section(&mut out, "SEE ALSO", ".BR halcmd (1),\n.BR halrun (1)\n");
        out
    }
}

fn section(out: &mut String, title: &str, body: &str) {
    if !body.is_empty() {
        // A section begins a paragraph of its own.
        let body = body.strip_prefix(".PP\n").unwrap_or(body);
        out.push_str(&format!(".SH {title}\n{body}"));
    }
}

fn argument(arg: &ArgInfo) -> String {
    entry(&argument_title(arg), &arg.doc)
}

fn entry(title: &str, doc: &str) -> String {
    let doc: Vec<&str> = doc.split_whitespace().collect();
    let doc = escaped(&plain(&doc.join(" ")));
    let (name, rest) = title.split_once(' ').unwrap_or((title, ""));
    let gap = if rest.is_empty() { "" } else { " " };
    let body = if doc.is_empty() { String::new() } else { format!("{doc}\n") };
    format!(".TP\n\\fB{}\\fR{gap}{}\n{body}", escaped(name), escaped(rest))
}

fn paragraph(text: &str) -> String {
    format!(".PP\n{}\n", escaped(&plain(text)))
}

/// Returns lines that stay as they are.
fn as_is(lines: &str) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let lines: String = lines.lines().map(|line| format!("{}\n", escaped(line))).collect();
    format!(".PP\n.nf\n{lines}.fi\n")
}

fn prose(paragraphs: &[String]) -> String {
    let mut out = String::new();
    for block in paragraphs.chunk_by(|a, b| a.starts_with('|') && b.starts_with('|')) {
        let Some(first) = block.first() else { continue };
        if first.starts_with('|') {
            let rows: Vec<&str> = block.iter().map(String::as_str).collect();
            out.push_str(&as_is(&grid(&rows, 0)));
        } else if let Some(title) = first.strip_prefix('#') {
            out.push_str(&format!(
                ".SS {}\n",
                escaped(&plain(title.trim_start_matches('#').trim()))
            ));
        } else if let Some(item) = first.strip_prefix("- ").or_else(|| first.strip_prefix("* ")) {
            out.push_str(&format!(".IP \\(bu 2\n{}\n", escaped(&plain(item))));
        } else {
            out.push_str(&paragraph(first));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::manual::man::Page;
    use hal_protocol::Offer;

    #[test]
    fn lines_of_a_page_are_never_requests_of_the_formatter() {
        let doc = "A -3 .dB `gate`.\n\n.so /etc/passwd\n\n'quoted\n\n# Heading\n\n- one\n- two\n\n| a | b |\n|---|---|\n| .x | \\y |\n\n# Example\n\n```hal\nloadrt x\n```";
        let page = Page {
            offer: Offer {
                component: "x".to_owned(),
                library: "family".to_owned(),
                doc: doc.to_owned(),
                args: Vec::new(),
            },
            also: vec!["y".to_owned()],
            loads: vec![vec!["loadrt x".to_owned()]],
            items: Vec::new(),
            functs: Vec::new(),
            commands: Vec::new(),
            refused: None,
        };
        let text = page.roff();
        let requests = [".\\\"", ".TH", ".SH", ".SS", ".B ", ".PP", ".IP", ".nf", ".fi", ".BR"];
        for line in text.lines().filter(|l| l.starts_with(['.', '\''])) {
            assert!(requests.iter().any(|r| line.starts_with(r)), "{line}");
        }
        assert!(text.contains(".SH NAME\nx \\- A \\-3 .dB gate.\n"), "{text}");
        assert!(text.contains("\\&.so /etc/passwd\n"), "{text}");
        assert!(text.contains("\\&'quoted\n"), "{text}");
        assert!(text.contains(".IP \\(bu 2\none\n"), "{text}");
        assert!(text.contains("\\ey"), "{text}");
    }
}
