//! Compresses the page's files into the program.

use flate2::{Compression, write::GzEncoder};
use std::{
    env, fs,
    io::{self, Write as _},
    path::{Path, PathBuf},
};

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=page");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    let mut files = Vec::new();
    list(Path::new("page"), &mut files)?;
    files.sort();
    let mut table = "&[\n".to_owned();
    for (n, path) in files.iter().enumerate() {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&fs::read(path)?)?;
        fs::write(out.join(format!("{n}.gz")), encoder.finish()?)?;
        let name = path.strip_prefix("page").unwrap_or(path).display().to_string();
        table += &format!("({name:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{n}.gz\"))),\n");
    }
    fs::write(out.join("page.rs"), table + "]\n")
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            list(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}
