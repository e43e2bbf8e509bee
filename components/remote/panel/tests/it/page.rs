//! The page's files: texts, scripts of others, size.
#![expect(clippy::unwrap_used, clippy::panic, clippy::print_stdout, reason = "tests; figures")]

use flate2::{Compression, write::GzEncoder};
use hal_golden::tools::Tool;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::Command,
};

/// Most bytes of the page, compressed file by file.
const MAX_BYTES: usize = 1_500_000;

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("page")
}

/// Returns all files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { all.extend(files(&path)) } else { all.push(path) }
    }
    all
}

/// Returns the rows of the table of texts: the key, and the texts in quotes.
fn texts() -> BTreeMap<String, Vec<String>> {
    let table = fs::read_to_string(page().join("src/texts.js")).unwrap();
    let (_, rows) = table.split_once("const TEXTS = {").unwrap();
    let (rows, _) = rows.split_once("\n};").unwrap();
    let row = |line: &str| {
        let (key, texts) = line.trim().split_once(": ").unwrap();
        let texts = serde_json::from_str(texts.trim_end_matches(','))
            .unwrap_or_else(|e| panic!("{line}: {e}"));
        (key.trim_matches('"').to_owned(), texts)
    };
    rows.lines().filter(|l| !l.trim().is_empty()).map(row).collect()
}

#[test]
fn each_text_is_there_in_each_language_and_is_used() {
    let texts = texts();
    for (key, row) in &texts {
        assert_eq!(row.len(), 2, "{key}: one text for English and one for Spanish");
        let places =
            |text: &str| (0..9).filter(|n| text.contains(&format!("{{{n}}}"))).collect::<Vec<_>>();
        assert!(
            row.iter().all(|t| !t.is_empty() && places(t) == places(&row[0])),
            "{key}: {row:?}"
        );
    }
    // Keys in the sources: arguments of `t`, other texts in quotes, and beginnings that a value completes.
    let (mut quoted, mut begun) = (BTreeSet::new(), BTreeSet::new());
    let own = files(&page().join("src")).into_iter().filter(|p| !p.ends_with("texts.js"));
    for path in own {
        let source = fs::read_to_string(&path).unwrap();
        quoted.extend(source.split('"').map(str::to_owned));
        for (at, _) in source.match_indices("t(\"") {
            let (key, _) = source[at + 3..].split_once('"').unwrap();
            let is_call = !source[..at].ends_with(|c: char| c.is_alphanumeric() || c == '.');
            assert!(!is_call || texts.contains_key(key), "{}: no text '{key}'", path.display());
        }
        for (at, _) in source.match_indices("t(`") {
            let (key, _) = source[at + 3..].split_once("${").unwrap();
            let is_call = !source[..at].ends_with(|c: char| c.is_alphanumeric() || c == '.');
            if is_call && !key.is_empty() {
                begun.insert(key.to_owned());
            }
        }
    }
    for key in texts.keys() {
        let is_used = quoted.contains(key) || begun.iter().any(|b| key.starts_with(b.as_str()));
        assert!(is_used, "nothing shows the text '{key}'");
    }
}

#[test]
fn scripts_of_others_are_those_that_are_listed() {
    let script = page().join("vendor/renew.sh");
    let checked = Command::new(script).arg("--check").output().unwrap();
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stdout));
    let sums = fs::read_to_string(page().join("vendor/SHA256SUMS")).unwrap();
    let listed: BTreeSet<_> =
        sums.lines().map(|l| l.split("  ").nth(1).unwrap().to_owned()).collect();
    let own = ["renew.sh", "vendor.json", "SHA256SUMS"];
    for path in files(&page().join("vendor")) {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(own.contains(&name) || listed.contains(name), "{name} has no hash");
    }
}

#[test]
fn the_page_is_small() {
    let size = |path: PathBuf| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
        encoder.write_all(&fs::read(path).unwrap()).unwrap();
        encoder.finish().unwrap().len()
    };
    let bytes: usize = files(&page()).into_iter().map(size).sum();
    println!("the page has {bytes} bytes, compressed");
    assert!(bytes < MAX_BYTES, "{bytes} bytes, compressed");
}

#[test]
fn nothing_comes_from_elsewhere() {
    for path in files(&page()) {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        let is_own = !path.starts_with(page().join("vendor"));
        if !is_own || !["js", "html", "css"].contains(&extension) {
            continue;
        }
        for foreign in ["http://", "https://", "//cdn", " style=\"", "innerHTML", "eval("] {
            assert!(!text.contains(foreign), "{} has '{foreign}'", path.display());
        }
    }
}

/// Runs a script of `tests/page/` with Node, if it is there.
fn run_script(name: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/page").join(name);
    if !Tool::of("node").is_installed() {
        return;
    }
    let done = Command::new("node").arg(script).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn a_jog_goes_on_only_while_it_is_held() {
    run_script("held.mjs");
}

#[test]
fn lines_of_probing_messages_and_paths_over_the_picture() {
    run_script("lines.mjs");
}

#[test]
fn lines_that_the_page_draws_itself() {
    run_script("raster.mjs");
}

#[test]
fn a_robot_behind_its_own_controller() {
    run_script("robot.mjs");
}

#[test]
fn holds_in_words_and_states_without_a_task() {
    run_script("holds.mjs");
}

#[test]
fn stock_that_tools_cut() {
    run_script("stock.mjs");
}

#[test]
fn stock_that_tilted_tools_cut() {
    run_script("tilted.mjs");
}

#[test]
fn stock_that_tools_cut_while_they_turn() {
    run_script("turning.mjs");
}

/// Returns the texts in quotes that follow one of these beginnings in the page's sources.
fn quoted_after(beginnings: &[&str]) -> BTreeSet<String> {
    let sources: Vec<_> =
        files(&page().join("src")).iter().map(|p| fs::read_to_string(p).unwrap()).collect();
    let mut found = BTreeSet::new();
    for (source, beginning) in sources.iter().flat_map(|s| beginnings.iter().map(move |b| (s, b))) {
        for (at, _) in source.match_indices(beginning) {
            let rest = &source[at + beginning.len()..];
            let (text, _) = rest.split_once(['"', '`', '$', '?']).unwrap();
            found.insert(text.to_owned());
        }
    }
    found
}

fn source(path: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

#[test]
fn the_page_asks_for_nothing_that_is_not_served() {
    let rows = source("src/commands.rs");
    let commands = quoted_after(&["run(\"", "command(\"", "ctx.stop(\""]);
    assert!(["jog", "jog-stop", "mdi", "estop"].iter().all(|c| commands.contains(*c)));
    for name in &commands {
        assert!(
            rows.contains(&format!("row(\"{name}\""))
                || rows.contains(&format!("        \"{name}\",\n")),
            "there is no command '{name}'"
        );
    }
    let (routes, kinds) = (source("src/http/mod.rs"), source("src/http/lists.rs"));
    let paths = quoted_after(&[
        "getJson(\"/",
        "request(\"GET\", \"/",
        "request(\"POST\", \"/",
        "request(\"PUT\", \"/",
        "request(\"DELETE\", \"/",
        "listPath(\"",
    ]);
    assert!(["info", "tools", "pins"].iter().all(|p| paths.contains(*p)));
    for path in &paths {
        let is_route = routes.contains(&format!(".route(\"/{path}\""));
        assert!(is_route || kinds.contains(&format!("(\"{path}\"")), "there is no path /{path}");
    }
    let written = quoted_after(&["request(\"PUT\", \"/", "request(\"PUT\", `/"]);
    assert!(written.is_empty(), "only programs are stored: {written:?}");
    let messages = source("src/socket/message.rs");
    for ty in quoted_after(&["post({ type: \"", "ask({ type: \"", "stringify({ type: \""]) {
        let variant = format!("{}{} {{", ty[..1].to_uppercase(), &ty[1..]);
        assert!(messages.contains(&variant), "there is no message '{ty}'");
    }
}
