//! `ferrule docs`: the manual, in a browser, in a folder or in the terminal.

use crate::{failure::Failure, options::Docs, start};
use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Largest number of sections that are printed whole; the headings of the others follow.
const WHOLE: usize = 3;

pub(crate) fn docs(given: &Docs) -> Result<ExitCode, Failure> {
    if !given.subject.is_empty() {
        return found(&given.subject);
    }
    let folder = given.output.clone().or_else(own_folder);
    let Some(folder) = folder.filter(|_| given.output.is_some() || hal_output::is_person()) else {
        return chapters();
    };
    written(&folder)?;
    let first = folder.join("index.html");
    hal_output::print(&format!("The manual is {}\n", first.display()))?;
    if given.output.is_none() && !given.no_browser {
        let absolute = fs::canonicalize(&first).map_err(|e| Failure::file(&first, &e))?;
        start::open(&format!("file://{}", absolute.display()));
    }
    Ok(ExitCode::SUCCESS)
}

/// Returns the folder of the user in which the manual is kept.
fn own_folder() -> Option<PathBuf> {
    hal_output::state_file(concat!("manual-", env!("CARGO_PKG_VERSION")))
}

/// Writes the pages into a folder.
fn written(folder: &Path) -> Result<(), Failure> {
    for (name, gzipped) in hal_docs::FILES {
        let path = folder.join(name);
        let bytes = hal_docs::content(gzipped).map_err(|e| Failure::file(&path, &e))?;
        if let Some(above) = path.parent() {
            fs::create_dir_all(above).map_err(|e| Failure::file(above, &e))?;
        }
        hal_output::write(&path, &bytes).map_err(|e| Failure::file(&path, &e))?;
    }
    Ok(())
}

/// Lists the chapters.
fn chapters() -> Result<ExitCode, Failure> {
    let mut part = "";
    let mut text = String::new();
    for chapter in hal_docs::CHAPTERS {
        if chapter.part != part {
            part = chapter.part;
            text += &format!("\n{part}\n");
        }
        text += &format!("  {}\n", chapter.title);
    }
    text += "\n'ferrule docs WORD...' prints the sections with these words, 'ferrule docs -o FOLDER' writes the pages\n";
    hal_output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// Prints the sections that have the words.
fn found(words: &[String]) -> Result<ExitCode, Failure> {
    let sections = hal_docs::search(words).map_err(|e| Failure::file("the manual", &e))?;
    if sections.is_empty() {
        return Err(Failure::NotInManual { words: words.join(" ").into() });
    }
    let mut text = String::new();
    for section in sections.iter().take(WHOLE) {
        text += &format!("{} · {}\n\n{}\n\n", section.chapter, section.title, section.text.trim());
    }
    if sections.len() > WHOLE {
        text += "Also in:\n";
    }
    for section in sections.iter().skip(WHOLE) {
        text += &format!("  {} · {}\n", section.chapter, section.title);
    }
    hal_output::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
