//! INI files: a machine's data.

use crate::Error;
use nom::{
    IResult, Parser,
    bytes::complete::take_while,
    character::complete::{char, satisfy, space0},
    combinator::{all_consuming, recognize, rest},
    sequence::{delimited, separated_pair},
};
use std::path::{Path, PathBuf};

/// How deeply files may include each other.
pub const MAX_DEPTH: u32 = 16;

/// One `NAME = value`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its section.
    pub section: String,
    /// Its name.
    pub name: String,
    /// Its value, escapes decoded.
    pub value: String,
    /// The file it stands in.
    pub file: String,
    /// The line it stands on (the last one, when it is continued).
    pub line: u32,
}

impl Entry {
    fn is(&self, section: &str, name: &str) -> bool {
        self.name == name && (section.is_empty() || self.section == section)
    }
}

/// An INI file with what it includes. Nothing is looked up in a file with an error in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ini {
    entries: Vec<Entry>,
    sections: Vec<(String, String)>,
    warnings: Vec<String>,
    broken: Option<Error>,
}

impl Ini {
    /// Reads a file for a script. With a line of it wrong, nothing is found in it, and
    /// [`Self::broken`] says why.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn open(path: &Path) -> Result<Self, Error> {
        match Self::read(path) {
            Err(error @ Error::IniSyntax { .. }) => {
                Ok(Self { broken: Some(error), ..Self::default() })
            }
            other => other,
        }
    }

    /// What is wrong with it.
    #[must_use]
    pub const fn broken(&self) -> Option<&Error> {
        self.broken.as_ref()
    }

    /// The entry nearest to `[SECTION]NAME`, and whether that one was probably meant: of this name
    /// in another section, or of nearly this name in this section.
    #[must_use]
    pub fn nearest(&self, section: &str, name: &str) -> Option<(String, bool)> {
        let apart =
            |a: &str, b: &str| strsim::damerau_levenshtein(&a.to_lowercase(), &b.to_lowercase());
        let rank = |e: &Entry| {
            let (far, whole) = (apart(name, &e.name), apart(section, &e.section));
            let meant = far == 0 || far + whole <= 2 || (whole == 0 && far <= 1 + name.len() / 3);
            (!meant, far + whole)
        };
        let (best, (far, _)) =
            self.entries.iter().map(|e| (e, rank(e))).min_by_key(|(_, rank)| *rank)?;
        Some((format!("[{}]{}", best.section, best.name), !far))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or a line of it, or of one it includes, is wrong.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let mut ini = Self::default();
        ini.add_file(path, 0)?;
        Ok(ini)
    }

    /// Reads a text; `name` is its file's, for messages and for what it includes.
    ///
    /// # Errors
    /// A line is wrong.
    pub fn parse(name: &str, text: &[u8]) -> Result<Self, Error> {
        let mut ini = Self::default();
        ini.add(Path::new(name), text, 0)?;
        Ok(ini)
    }

    /// The first value of this name in the section; in any section when that is empty.
    #[must_use]
    pub fn get(&self, section: &str, name: &str) -> Option<&str> {
        self.entries.iter().find(|e| e.is(section, name)).map(|e| e.value.as_str())
    }

    /// Gives the first entry of this name in the section another value; whether there is one.
    pub fn change(&mut self, section: &str, name: &str, value: &str) -> bool {
        let entry = self.entries.iter_mut().find(|e| e.is(section, name));
        entry.map(|e| value.clone_into(&mut e.value)).is_some()
    }

    /// Every entry of this name in the section, in order.
    pub fn all<'a>(&'a self, section: &str, name: &str) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(move |e| e.is(section, name))
    }

    /// Every entry of a section, in order.
    pub fn section<'a>(&'a self, section: &str) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(move |e| e.section == section)
    }

    /// Every entry, in order.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.entries.iter()
    }

    /// Whether there is a section of this name.
    #[must_use]
    pub fn has_section(&self, name: &str) -> bool {
        self.sections.iter().any(|(s, _)| s == name)
    }

    /// Every `[SECTION]NAME`, in order.
    pub fn names(&self) -> impl Iterator<Item = String> {
        self.entries.iter().map(|e| format!("[{}]{}", e.section, e.name))
    }

    /// What is odd about it but not wrong, as `file:line: text`.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Whether it is of the kind that knew axes but no joints: pins then have their old names.
    #[must_use]
    pub fn is_old(&self) -> bool {
        let numbered = |prefix: &str| {
            self.sections.iter().any(|(s, _)| {
                s.strip_prefix(prefix)
                    .is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
            })
        };
        numbered("AXIS_") && !numbered("JOINT_")
    }

    fn add_file(&mut self, path: &Path, depth: u32) -> Result<(), Error> {
        let shown = path.display().to_string();
        let text = std::fs::read(path)
            .map_err(|e| Error::IniFile { path: shown.as_str().into(), why: plain(&e) })?;
        self.add(path, &text, depth)
    }

    fn add(&mut self, path: &Path, text: &[u8], depth: u32) -> Result<(), Error> {
        let file = path.display().to_string();
        let wrong = |line: u32, why: &str| {
            let path = file.as_str().into();
            Error::IniSyntax { path, line, why: why.into() }
        };
        let mut section: Option<String> = None;
        for (line, text) in joined(text) {
            let text = text.ok_or_else(|| wrong(line, "this is not UTF-8"))?;
            let text = text.trim_matches(|c: char| c.is_ascii_whitespace());
            if let Some(name) = text.strip_prefix("#INCLUDE") {
                if depth >= MAX_DEPTH {
                    return Err(wrong(line, "files include each other too deeply (16 at most)"));
                }
                let name = name.trim();
                if name.is_empty() {
                    return Err(wrong(line, "#INCLUDE needs the name of a file"));
                }
                self.add_file(&beside(path, name), depth + 1).map_err(|error| match error {
                    Error::IniFile { path, why } => {
                        wrong(line, &format!("#INCLUDE: could not open INI file '{path}': {why}"))
                    }
                    other => other,
                })?;
            } else if text.is_empty() || text.starts_with(['#', ';']) {
            } else if text.starts_with('[') {
                let (_, name) = header(text)
                    .map_err(|_| wrong(line, "a section is [NAME]: letters, digits and _"))?;
                self.begin(&file, line, name);
                section = Some(name.to_owned());
            } else {
                let (_, (name, value)) = entry(text).map_err(|_| {
                    wrong(line, "expected NAME = value, with letters, digits and _ in the name")
                })?;
                let section = section
                    .clone()
                    .ok_or_else(|| wrong(line, "this entry stands before the first [SECTION]"))?;
                let value = decoded(value).ok_or_else(|| wrong(line, "no such character"))?;
                let name = name.to_owned();
                self.entries.push(Entry { section, name, value, file: file.clone(), line });
            }
        }
        Ok(())
    }

    fn begin(&mut self, file: &str, line: u32, name: &str) {
        if self.sections.iter().any(|(s, f)| s == name && f == file) {
            self.warnings.push(format!(
                "{file}:{line}: Warning: section [{name}] is repeated; its entries are added to \
                 the first"
            ));
        }
        self.sections.push((name.to_owned(), file.to_owned()));
    }
}

/// Lines with those that end in `\` joined to the next, and the number of each one's last.
fn joined(text: &[u8]) -> Vec<(u32, Option<String>)> {
    let mut out = Vec::new();
    let mut pending: Vec<u8> = Vec::new();
    let mut number = 0;
    for line in text.split(|b| *b == b'\n') {
        number += 1;
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(start) = line.strip_suffix(b"\\") {
            pending.extend_from_slice(start);
        } else {
            pending.extend_from_slice(line);
            out.push((number, String::from_utf8(core::mem::take(&mut pending)).ok()));
        }
    }
    if !pending.is_empty() {
        out.push((number, String::from_utf8(pending).ok()));
    }
    out
}

fn header(text: &str) -> IResult<&str, &str> {
    let comment =
        recognize((space0, nom::combinator::opt((satisfy(|c| c == '#' || c == ';'), rest))));
    let (left, (name, _)) =
        all_consuming((delimited((char('['), space0), identifier, (space0, char(']'))), comment))
            .parse(text)?;
    Ok((left, name))
}

fn entry(text: &str) -> IResult<&str, (&str, &str)> {
    separated_pair(identifier, (space0, char('='), space0), rest).parse(text)
}

/// Letters, digits and `_`; older files also have `-` and `.` after the first.
fn identifier(text: &str) -> IResult<&str, &str> {
    recognize((
        satisfy(|c| c.is_ascii_alphabetic() || c == '_'),
        take_while(|c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.')),
    ))
    .parse(text)
}

/// Decodes `\t \x41 \101 \u00e9` and their like; a `\` before anything else stays.
fn decoded(value: &str) -> Option<String> {
    let mut out = String::new();
    let mut rest = value;
    while let Some((before, after)) = rest.split_once('\\') {
        out.push_str(before);
        let (left, c) = match escape(after) {
            Ok((left, code)) => (left, char::from_u32(code)?),
            Err(_) => (after, '\\'),
        };
        out.push(c);
        rest = left;
    }
    out.push_str(rest);
    Some(out)
}

fn escape(text: &str) -> IResult<&str, u32> {
    let (rest, c) = nom::character::complete::anychar(text)?;
    let simple = |code: u32| Ok((rest, code));
    match c {
        'a' => simple(7),
        'b' => simple(8),
        'f' => simple(12),
        'n' => simple(10),
        'r' => simple(13),
        't' => simple(9),
        'v' => simple(11),
        '\\' => simple(92),
        'x' => number(rest, 16, 1, 2),
        'u' => number(rest, 16, 4, 4),
        'U' => number(rest, 16, 8, 8),
        _ => number(text, 8, 1, 3),
    }
}

fn number(text: &str, radix: u32, least: usize, most: usize) -> IResult<&str, u32> {
    let (rest, digits) =
        nom::bytes::complete::take_while_m_n(least, most, |c: char| c.is_digit(radix))
            .parse(text)?;
    // At most eight digits: it always fits.
    Ok((rest, u32::from_str_radix(digits, radix).unwrap_or(u32::MAX)))
}

fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().map_or_else(|| PathBuf::from(name), |folder| folder.join(name))
}

/// What the system said, without its number.
pub(crate) fn plain(error: &std::io::Error) -> Box<str> {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, want: &str) {
        let shown = match Ini::parse("m.ini", text.as_bytes()) {
            Ok(ini) => ini
                .entries
                .iter()
                .map(|e| format!("[{}]{}={:?}@{}\n", e.section, e.name, e.value, e.line))
                .collect::<String>(),
            Err(e) => format!("! {}", e.whole()),
        };
        assert_eq!(shown, want, "{text:?}");
    }

    #[test]
    fn sections_and_entries() {
        for (text, want) in [
            ("[A]\nX = 1\n[B]\nX=2", "[A]X=\"1\"@2\n[B]X=\"2\"@4\n"),
            ("[A]\n  X  =  some text  \n", "[A]X=\"some text\"@2\n"),
            ("[A]\r\nX = 1\r\n", "[A]X=\"1\"@2\n"),
            ("# c\n; c\n[A] # c\nX = 1 # kept\n", "[A]X=\"1 # kept\"@4\n"),
            ("[A]\nX = a\nX = b\n", "[A]X=\"a\"@2\n[A]X=\"b\"@3\n"),
            ("[A]\nX =\n", "[A]X=\"\"@2\n"),
            ("[A]\nX = .25\nY = 5mm .5mm\n", "[A]X=\".25\"@2\n[A]Y=\"5mm .5mm\"@3\n"),
            ("[A]\nX = a=b\n", "[A]X=\"a=b\"@2\n"),
            ("[A]\nX = one \\\n   two\nY = 1\n", "[A]X=\"one    two\"@3\n[A]Y=\"1\"@4\n"),
            ("[A]\nX-Y.Z = 1\n", "[A]X-Y.Z=\"1\"@2\n"),
            ("", ""),
        ] {
            check(text, want);
        }
    }

    #[test]
    fn escapes() {
        for (value, want) in [
            ("a\\tb\\x41", "a\tbA"),
            ("\\101\\\\\\n", "A\\\n"),
            ("\\u00e9\\U0001F600", "é😀"),
            ("c:\\qdir", "c:\\qdir"),
            ("\\xzz", "\\xzz"),
        ] {
            let ini = Ini::parse("m", format!("[A]\nX = {value}\n").as_bytes()).unwrap();
            assert_eq!(ini.get("A", "X"), Some(want), "{value}");
        }
    }

    #[test]
    fn what_is_wrong_names_its_line() {
        for (text, want) in [
            ("X = 1\n", "! m.ini:1: this entry stands before the first [SECTION]"),
            ("[A\n", "! m.ini:1: a section is [NAME]: letters, digits and _"),
            (
                "[A]\n\nnonsense\n",
                "! m.ini:3: expected NAME = value, with letters, digits and _ in the name",
            ),
            (
                "[A]\n9X = 1\n",
                "! m.ini:2: expected NAME = value, with letters, digits and _ in the name",
            ),
            ("[A]\nX = \\uD800\n", "! m.ini:2: no such character"),
            (
                "#INCLUDE /nowhere/x\n",
                "! m.ini:1: #INCLUDE: could not open INI file '/nowhere/x': No such file or directory",
            ),
            ("[A]\n#INCLUDE \n", "! m.ini:2: #INCLUDE needs the name of a file"),
        ] {
            check(text, want);
        }
        let bad = Ini::parse("m.ini", b"[A]\nX = \xff\n").unwrap_err();
        assert_eq!(bad.to_string(), "m.ini:2: this is not UTF-8");
    }

    #[test]
    fn look_ups() {
        let text = b"[A]\nX = 1\n[B]\nX = 2\nY = 3\n[A]\nX = 4\n";
        let ini = Ini::parse("m", text).unwrap();
        assert_eq!(ini.get("A", "X"), Some("1"));
        assert_eq!(ini.get("", "Y"), Some("3"));
        assert_eq!(ini.get("a", "X"), None);
        let all: Vec<_> = ini.all("A", "X").map(|e| e.value.as_str()).collect();
        assert_eq!(all, ["1", "4"]);
        let warning = "m:6: Warning: section [A] is repeated; its entries are added to the first";
        assert_eq!(ini.warnings(), [warning]);
    }

    #[test]
    fn the_old_kind_has_numbered_axes_and_no_joints() {
        for (text, old) in [
            ("[AXIS_0]\n", true),
            ("[AXIS_X]\n[JOINT_0]\n", false),
            ("[AXIS_0]\n[JOINT_0]\n", false),
            ("[AXIS_]\n", false),
            ("", false),
        ] {
            assert_eq!(Ini::parse("m", text.as_bytes()).unwrap().is_old(), old, "{text}");
        }
    }

    #[test]
    fn a_file_with_an_error_has_nothing() {
        let path = std::env::temp_dir().join(format!("ferrule-broken-{}.ini", std::process::id()));
        std::fs::write(&path, "[A]\nX = 1\n[B\n").unwrap();
        let broken = Ini::open(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(broken.get("A", "X"), None);
        let why = broken.broken().unwrap().to_string();
        assert!(why.ends_with(".ini:3: a section is [NAME]: letters, digits and _"), "{why}");
        assert!(Ini::open(&path).is_err(), "a file that is not there");
    }

    #[test]
    fn the_nearest_entry() {
        let ini =
            Ini::parse("m", b"[TRAJ]\nAXES = 3\n[JOINT_0]\nSCALE = 1\nMAX_LIMIT = 2\n").unwrap();
        for (section, name, want) in [
            ("JOINT_0", "SCALES", Some(("[JOINT_0]SCALE", true))),
            ("JOINT_1", "SCALE", Some(("[JOINT_0]SCALE", true))),
            ("AXIS_0", "SCALE", Some(("[JOINT_0]SCALE", true))),
            ("traj", "axes", Some(("[TRAJ]AXES", true))),
            ("JOINT_0", "MAXLIMIT", Some(("[JOINT_0]MAX_LIMIT", true))),
            ("HAL", "TWOPASS", Some(("[TRAJ]AXES", false))),
        ] {
            let near = ini.nearest(section, name);
            assert_eq!(near, want.map(|(n, m)| (n.to_owned(), m)), "[{section}]{name}");
        }
        assert_eq!(Ini::default().nearest("A", "B"), None);
    }

    #[test]
    fn files_include_each_other() {
        let folder = std::env::temp_dir().join(format!("ferrule-ini-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("sub")).unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        write("a.ini", "[A]\nX = 1\n#INCLUDE sub/b.ini\n[A]\nZ = 3\n");
        write("sub/b.ini", "[B]\nY = 2\n#INCLUDE c.ini\n");
        write("sub/c.ini", "[C]\nW = 4\n");
        write("loop.ini", "#INCLUDE loop.ini\n");
        for n in 0..18 {
            write(&format!("d{n}.ini"), &format!("[D]\nD = {n}\n#INCLUDE d{}.ini\n", n + 1));
        }
        write("d18.ini", "");
        // The last of 16 that are included, and one too many.
        let deep = Ini::read(&folder.join("d2.ini")).unwrap();
        let deeper = Ini::read(&folder.join("d1.ini")).unwrap_err().to_string();
        let ini = Ini::read(&folder.join("a.ini")).unwrap();
        let names: Vec<_> = ini.names().collect();
        let endless = Ini::read(&folder.join("loop.ini")).unwrap_err().to_string();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(names, ["[A]X", "[B]Y", "[C]W", "[A]Z"]);
        assert_eq!(deep.all("D", "D").count(), 16);
        assert!(deeper.ends_with("files include each other too deeply (16 at most)"), "{deeper}");
        assert!(endless.ends_with("loop.ini:1: files include each other too deeply (16 at most)"));
    }
}
