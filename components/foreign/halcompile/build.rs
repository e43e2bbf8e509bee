//! Embeds the headers for C components in the program.

use std::{
    collections::BTreeSet,
    env,
    fmt::Write,
    fs, io,
    path::{Path, PathBuf},
};

fn main() -> io::Result<()> {
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let folder = here.join("../compat/include");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut found = Vec::new();
    headers(&folder, "", &mut found)?;
    found.sort();
    let mut text = String::from("pub(crate) const HEADERS: &[(&str, &str)] = &[\n");
    let mut texts = String::new();
    for (name, path) in found {
        texts += &fs::read_to_string(&path)?;
        writeln!(text, "({name:?}, include_str!({:?})),", path.display())
            .map_err(io::Error::other)?;
    }
    text.push_str("];\npub(crate) const OFFERED: &[&str] = &[\n");
    // Drivers of the kernel declare this variable themselves.
    for name in functions(&texts).into_iter().chain(["cpu_khz"]) {
        writeln!(text, "{name:?},").map_err(io::Error::other)?;
    }
    text.push_str("];\n");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    fs::write(out.join("headers.rs"), text)
}

/// Returns the names of the functions that headers declare with `extern`.
fn functions(texts: &str) -> BTreeSet<&str> {
    let declared = texts.split("extern ").skip(1).filter_map(|d| d.split(';').next());
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let names = declared.filter_map(|d| {
        let before = d.split_once('(')?.0.trim_end();
        let begin = before.rfind(|c| !is_part(c)).map_or(0, |at| at + 1);
        Some(&before[begin..])
    });
    names.filter(|n| !n.is_empty()).collect()
}

fn headers(folder: &Path, before: &str, found: &mut Vec<(String, PathBuf)>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            headers(&path, &format!("{before}{name}/"), found)?;
        } else if name.ends_with(".h") {
            found.push((format!("{before}{name}"), path));
        }
    }
    Ok(())
}
