//! Mistakes of beginners: each message names its place and the remedy; the remedy, as it is printed, is applied, and the machine works.
#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "tests; each mistake with its remedy is shown"
)]

use hal_tests::{programs::root, scratch::Scratch};
use serde::Deserialize;
use std::{collections::BTreeMap, fs, sync::OnceLock};

/// Mistakes that must be there.
const LEAST: usize = 40;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mistakes {
    mistake: Vec<Mistake>,
}

/// A mistake, its message, and the way to its remedy: `tests/beginners/mistakes.toml` explains the keys.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Mistake {
    name: String,
    about: String,
    /// Part of the program that the remedy waits for.
    depends: Option<String>,
    #[serde(default)]
    files: BTreeMap<String, String>,
    /// File, text, other text.
    #[serde(default)]
    edit: Vec<[String; 3]>,
    before: Option<String>,
    run: String,
    then: Option<String>,
    behind: Option<String>,
    at: String,
    says: String,
    takes: String,
    /// Line to which the remedy is applied where it is not that of `at`.
    r#where: Option<String>,
    /// The remedy, where another one would work as well and be wrong.
    right: Option<String>,
    put: Put,
    /// Text in the line that the remedy replaces, or file that gets a line at its end.
    #[serde(default)]
    old: String,
    #[serde(default)]
    prefix: String,
    #[serde(default)]
    suffix: String,
}

/// Way in which a remedy is applied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Put {
    Replace,
    Line,
    Before,
    After,
    End,
    Type,
    Instead,
    Typed,
}

/// Returns the status of a command line and what it prints.
fn typed(scratch: &Scratch, line: &str) -> (Option<i32>, String) {
    let output =
        scratch.run(scratch.command(&[], "sh").arg("-c").arg(format!("exec 2>&1; {line}")));
    (output.status, output.stdout)
}

/// Returns what stands in the hole of a template.
fn taken<'a>(said: &'a str, takes: &str) -> Option<&'a str> {
    let (before, after) = takes.split_once("{}")?;
    said.match_indices(before).find_map(|(at, _)| {
        let line = said.get(at + before.len()..)?.split_inclusive('\n').next()?;
        let end = if after.is_empty() { line.trim_end().len() } else { line.find(after)? };
        line.get(..end)
    })
}

/// Returns the file and the line that the program prints.
fn place(at: &str) -> Option<(&str, usize)> {
    let mut parts = at.trim().trim_end_matches(':').split(':');
    let file = parts.next()?;
    let line = parts.next()?.parse().ok()?;
    (line > 0).then_some((file, line))
}

/// Returns the files of the machine.
fn machine() -> &'static BTreeMap<String, Vec<u8>> {
    static FILES: OnceLock<BTreeMap<String, Vec<u8>>> = OnceLock::new();
    FILES.get_or_init(|| {
        let scratch = Scratch::new("beginners");
        let setup = fs::read(root().join("tests/beginners/first.setup")).unwrap();
        scratch.write("first.setup", &setup);
        let (status, said) = typed(&scratch, "halsetup first.setup && mv first/* . && rmdir first");
        assert_eq!(status, Some(0), "{said}");
        let mut files = scratch.files();
        files.insert("first.setup".to_owned(), setup);
        files
    })
}

/// Makes the mistake, reads the remedy and applies it; returns the remedy.
fn judge(m: &Mistake) -> Result<String, String> {
    let scratch = Scratch::new("beginner");
    for (name, bytes) in machine() {
        scratch.write(name, bytes);
    }
    for (name, text) in &m.files {
        scratch.write(name, text);
    }
    for [name, old, new] in &m.edit {
        let text = scratch.read(name);
        assert!(text.contains(old.as_str()), "{}: {name} has no '{old}'", m.name);
        scratch.write(name, text.replacen(old.as_str(), new, 1));
    }
    let result = mended(m, &scratch);
    if let Some(behind) = &m.behind {
        typed(&scratch, behind);
    }
    result
}

fn mended(m: &Mistake, scratch: &Scratch) -> Result<String, String> {
    if let Some(before) = &m.before {
        let (status, said) = typed(scratch, before);
        assert_eq!(status, Some(0), "{}: {before}: {said}", m.name);
    }
    let (status, said) = typed(scratch, &m.run);
    let wrong = |why: &str, said: &str| Err(format!("{}: {why}\n$ {}\n{said}", m.name, m.run));
    if !said
        .lines()
        .any(|l| l.starts_with(m.at.as_str()) || l.trim_start().starts_with(m.at.as_str()))
    {
        return wrong(&format!("no line begins with the place '{}'", m.at), &said);
    }
    if !said.contains(m.says.as_str()) {
        return wrong(&format!("it does not say '{}'", m.says), &said);
    }
    if status == Some(0) {
        return wrong("the mistake is no error", &said);
    }
    // What stands before the place belongs to other findings.
    let from = said.find(m.at.as_str()).unwrap_or_default();
    let Some(remedy) = taken(said.get(from..).unwrap_or_default(), &m.takes) else {
        return wrong(&format!("it does not say how to mend it: '{}'", m.takes), &said);
    };
    if m.right.as_deref().is_some_and(|right| right != remedy) {
        return wrong(&format!("'{remedy}' is the wrong remedy"), &said);
    }
    let at = m.r#where.as_ref().unwrap_or(&m.at);
    let remedy = format!("{}{remedy}{}", m.prefix, m.suffix);
    let mut run = m.then.clone().unwrap_or_else(|| m.run.clone());
    match m.put {
        Put::Replace if place(at).is_none() => {
            let new = run.replacen(m.old.as_str(), &remedy, 1);
            assert_ne!(new, run, "{}: '{}' is not in the command", m.name, m.old);
            run = new;
        }
        Put::Type => {
            let (status, said) = typed(scratch, &remedy);
            if status != Some(0) {
                return wrong(&format!("the remedy '{remedy}' fails"), &said);
            }
        }
        Put::Typed => {
            let (status, said) = typed(scratch, &format!("halcmd {remedy}"));
            if status != Some(0) {
                return wrong(&format!("the remedy 'halcmd {remedy}' fails"), &said);
            }
        }
        Put::Instead => run.clone_from(&remedy),
        Put::End => {
            let text = scratch.read(&m.old);
            scratch.write(&m.old, format!("{text}{remedy}\n"));
        }
        Put::Replace | Put::Line | Put::Before | Put::After => {
            let (file, number) = place(at).unwrap();
            let text = scratch.read(file);
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            let n = number - 1;
            match m.put {
                Put::Replace => {
                    let line = lines.get_mut(n).unwrap();
                    let new = line.replacen(m.old.as_str(), &remedy, 1);
                    assert_ne!(new, *line, "{}: '{}' is not in the line", m.name, m.old);
                    *line = new;
                }
                Put::Line => lines.get_mut(n).unwrap().clone_from(&remedy),
                Put::Before => lines.insert(n, remedy.clone()),
                _ => lines.insert(n + 1, remedy.clone()),
            }
            scratch.write(file, lines.join("\n") + "\n");
        }
    }
    let (status, said) = typed(scratch, &run);
    if status != Some(0) || said.contains(m.says.as_str()) {
        return Err(format!(
            "{}: '{remedy}' does not mend it: {status:?}\n$ {run}\n{said}",
            m.name
        ));
    }
    Ok(remedy)
}

fn mistakes() -> Vec<Mistake> {
    let text = fs::read_to_string(root().join("tests/beginners/mistakes.toml")).unwrap();
    toml::from_str::<Mistakes>(&text).unwrap().mistake
}

#[test]
fn each_mistake_names_its_place_and_the_line_that_mends_it() {
    let wanted = std::env::var("CASE").unwrap_or_default();
    let all = mistakes();
    let (mut wrong, mut waiting) = (Vec::new(), Vec::new());
    for m in all.iter().filter(|m| m.name.contains(&wanted)) {
        match (judge(m), &m.depends) {
            (Ok(remedy), None) => println!("{}: {}: {remedy}", m.name, m.about),
            (Ok(_), Some(on)) => {
                wrong.push(format!("{}: works, and needs no '{on}' any more", m.name));
            }
            (Err(_), Some(on)) => waiting.push(format!("{}: waits for {on}", m.name)),
            (Err(why), None) => wrong.push(why),
        }
    }
    println!("{} mistakes; {} wait:\n{}", all.len(), waiting.len(), waiting.join("\n"));
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), all.len(), wrong.join("\n\n"));
    let mut names: Vec<&str> = all.iter().map(|m| m.name.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    assert!(
        names.len() == all.len() && all.len() - waiting.len() >= LEAST,
        "{} mistakes",
        all.len()
    );
}

#[test]
fn a_remedy_that_does_not_mend_is_found() {
    let mut all = mistakes();
    let m = all.iter_mut().find(|m| m.name == "command-typo").unwrap();
    assert_eq!(judge(m).as_deref(), Ok("loadrt"));
    // A remedy that is another word, a message that lacks it, a place that is another line, a mistake that is none.
    for change in [
        |m: &mut Mistake| "x".clone_into(&mut m.prefix),
        |m: &mut Mistake| "try {}".clone_into(&mut m.takes),
        |m: &mut Mistake| "m.hal:3:".clone_into(&mut m.at),
        |m: &mut Mistake| {
            m.files.insert("m.hal".to_owned(), "loadrt and2\n".to_owned());
        },
    ] {
        let mut other = mistakes().into_iter().find(|m| m.name == "command-typo").unwrap();
        change(&mut other);
        judge(&other).unwrap_err();
    }
}
