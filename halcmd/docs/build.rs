//! Makes the pages of the manual from `halcmd/book`, and compresses them into the library.

#[path = "build/book.rs"]
mod book;
#[path = "build/page.rs"]
mod page;

use flate2::{Compression, write::GzEncoder};
use std::{
    env, fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
};

fn main() -> io::Result<()> {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let book = book::Book::read(Path::new("../book"))?;
    for file in
        ["build", "page"].iter().map(Path::new).chain(book.read.iter().map(PathBuf::as_path))
    {
        println!("cargo::rerun-if-changed={}", file.display());
    }
    let mut chapters = "&[\n".to_owned();
    for (n, chapter) in book.chapters.iter().enumerate() {
        fs::write(out.join(format!("chapter-{n}.gz")), gzipped(chapter.text.as_bytes())?)?;
        chapters += &format!(
            "Chapter {{ file: {:?}, title: {:?}, part: {:?}, gzipped: include_bytes!(concat!(env!(\"OUT_DIR\"), \"/chapter-{n}.gz\")) }},\n",
            chapter.file, chapter.title, chapter.part
        );
    }
    fs::write(out.join("chapters.rs"), chapters + "]\n")?;
    let mut files = page::pages(&book)?;
    files.sort();
    let mut table = "&[\n".to_owned();
    for (n, (name, bytes)) in files.iter().enumerate() {
        fs::write(out.join(format!("{n}.gz")), gzipped(bytes)?)?;
        table += &format!("({name:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{n}.gz\"))),\n");
    }
    fs::write(out.join("files.rs"), table + "]\n")
}

fn gzipped(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes)?;
    encoder.finish()
}
