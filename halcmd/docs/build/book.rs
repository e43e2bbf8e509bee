//! The book as mdBook reads it: the list of chapters in `src/SUMMARY.md`, and lines that include a part of another file.

use std::{
    fs,
    io::{Error, Result},
    path::{Path, PathBuf},
};

/// Book with the files that it was read from.
pub(crate) struct Book {
    pub(crate) title: String,
    pub(crate) chapters: Vec<Chapter>,
    pub(crate) pictures: Vec<(String, Vec<u8>)>,
    pub(crate) read: Vec<PathBuf>,
}

/// Chapter with its includes in place.
pub(crate) struct Chapter {
    /// Name of its file in `src`.
    pub(crate) file: String,
    pub(crate) title: String,
    /// Heading of the list of chapters that it stands below; empty above the first.
    pub(crate) part: String,
    pub(crate) text: String,
}

impl Book {
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let src = folder.join("src");
        let mut read = vec![folder.join("book.toml"), src.join("SUMMARY.md"), src.join("pictures")];
        let toml = text(&folder.join("book.toml"))?;
        let title = toml.lines().find_map(|l| l.strip_prefix("title = ")).unwrap_or_default();
        let mut chapters = Vec::new();
        let mut part = String::new();
        for line in text(&src.join("SUMMARY.md"))?.lines() {
            if let Some(heading) = line.strip_prefix("# ") {
                part = if heading == "Summary" { String::new() } else { heading.to_owned() };
            }
            let Some((title, file)) = line
                .split_once('[')
                .and_then(|(_, rest)| rest.split_once("]("))
                .and_then(|(title, rest)| Some((title, rest.split_once(')')?.0)))
            else {
                continue;
            };
            read.push(src.join(file));
            let text = included(&src, &text(&src.join(file))?, &mut read)?;
            let (file, title, part) = (file.to_owned(), title.to_owned(), part.clone());
            chapters.push(Chapter { file, title, part, text });
        }
        let mut pictures = Vec::new();
        for entry in fs::read_dir(src.join("pictures"))? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            pictures.push((format!("pictures/{name}"), fs::read(&path)?));
            read.push(path);
        }
        Ok(Self { title: title.trim_matches('"').to_owned(), chapters, pictures, read })
    }
}

fn text(path: &Path) -> Result<String> {
    fs::read_to_string(path).map_err(|e| Error::other(format!("{}: {e}", path.display())))
}

/// Replaces each `{{#include FILE}}` and `{{#include FILE:ANCHOR}}` by the file, or by its part between the lines with
/// `ANCHOR: name` and `ANCHOR_END: name`.
fn included(src: &Path, chapter: &str, read: &mut Vec<PathBuf>) -> Result<String> {
    let mut out = String::new();
    for line in chapter.lines() {
        let Some(asked) = line.strip_prefix("{{#include ").and_then(|l| l.strip_suffix("}}"))
        else {
            out += line;
            out.push('\n');
            continue;
        };
        let (file, anchor) = asked.split_once(':').map_or((asked, None), |(f, a)| (f, Some(a)));
        let path = src.join(file);
        let whole = text(&path)?;
        let Some(anchor) = anchor else {
            out += &whole;
            read.push(path);
            continue;
        };
        let is = |line: &str, key: &str| {
            line.split_once(key).is_some_and(|(_, rest)| {
                rest.trim_end_matches("-->").trim_end_matches("*/").trim() == anchor
            })
        };
        let lines = whole.lines().skip_while(|l| !is(l, "ANCHOR: ")).skip(1);
        let part: Vec<&str> = lines.take_while(|l| !is(l, "ANCHOR_END: ")).collect();
        if part.is_empty() || !whole.lines().any(|l| is(l, "ANCHOR_END: ")) {
            return Err(Error::other(format!("{file}: there is no part '{anchor}'")));
        }
        for line in part.iter().filter(|l| !l.contains("ANCHOR")) {
            out += line;
            out.push('\n');
        }
        read.push(path);
    }
    Ok(out)
}
