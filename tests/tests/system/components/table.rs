//! The table of all components in `components/README.md`, and the page of each in `components/pages`, agree with the
//! plugins' own declarations and with the test results.
//!
//! `UPDATE_EXPECT=1 cargo test -p hal-tests --test system components::table` writes both. Cells come from the plugins, from
//! `tests/compat/pins`, `conformance.md` and `kinematics.md`, from the sources of the tests, and from `components/SPEED.md`;
//! a cell without a source fails the test, which then names the remedy.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_protocol::Offer;
use hal_tests::{
    counted::Sources,
    every, golden, pins,
    programs::{family, programs, root},
};
use halcmd::manual::man::{self, Page};
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    fs,
};

const BEGIN: &str = "<!-- table:begin -->";
const END: &str = "<!-- table:end -->";
const AGAIN: &str = "run `UPDATE_EXPECT=1 cargo test -p hal-tests --test system components::table`";
/// Text of a cell where LinuxCNC 2.9 has nothing to compare with.
const NO_PEER: &str = "no peer";

/// Components that are compared with LinuxCNC's in another way: the cells of their pins and cycles.
const ELSEWHERE: &[(&str, [&str; 2])] = &[
    ("hm2_eth", ["22 cards, `tests/mesa`", "6 machines, `tests/mesa`"]),
    ("hostmot2", ["0", "not judged"]),
];

/// Returns the cells of a component that is compared in another way.
fn elsewhere(component: &str) -> Option<[&'static str; 2]> {
    ELSEWHERE.iter().find(|row| row.0 == component).map(|row| row.1)
}

/// Returns one page for each component. A component with several names is listed under the name that LinuxCNC has, if
/// that is known, or under the first.
fn pages() -> Vec<Page> {
    let known: BTreeSet<String> = pins::names().into_iter().collect();
    let all = man::pages(&[programs().to_owned()]).unwrap();
    assert!(all.len() > 150, "only {} components found", all.len());
    let is_first = |page: &Page| {
        let name = &page.offer.component;
        let rank = |name: &String| (!known.contains(name), name.clone());
        page.also.iter().all(|other| rank(name) < rank(other))
    };
    all.into_iter().filter(is_first).collect()
}

/// Returns the cells of the rows of a Markdown file, keyed by the first cell.
fn rows(file: &str) -> BTreeMap<String, Vec<String>> {
    let text = fs::read_to_string(root().join(file)).unwrap_or_default();
    let cells =
        |line: &str| line.split('|').skip(1).map(|c| c.trim().to_owned()).collect::<Vec<String>>();
    let mut out = BTreeMap::new();
    for cells in text.lines().filter(|l| l.starts_with("| `")).map(cells) {
        let name = cells.first().and_then(|c| c.split('`').nth(1)).unwrap_or_default().to_owned();
        out.entry(name).or_insert(cells);
    }
    out
}

/// Returns a number with thousands separated by commas.
fn thousands(number: &str) -> String {
    let (head, tail) = number.split_at(number.len().saturating_sub(3));
    if head.is_empty() { tail.to_owned() } else { format!("{},{tail}", thousands(head)) }
}

/// Results from other tests.
struct Shown {
    judge: BTreeMap<String, Vec<String>>,
    kinematics: BTreeMap<String, Vec<String>>,
    speed: BTreeMap<String, Vec<String>>,
}

impl Shown {
    fn read() -> Self {
        Self {
            judge: rows("tests/compat/conformance.md"),
            kinematics: rows("tests/compat/kinematics.md"),
            speed: rows("components/SPEED.md"),
        }
    }

    /// Returns the number of pins that are LinuxCNC's.
    fn pins(&self, offer: &Offer) -> Result<String, String> {
        if let Some([pins, _]) = elsewhere(&offer.component) {
            return Ok(pins.to_owned());
        }
        let found = pins::beside(offer)?;
        if !found.faults.is_empty() {
            return Err(found.faults.join("; "));
        }
        let Some(oldest) = found.versions.first() else { return Ok(NO_PEER.to_owned()) };
        let version = if oldest == "2.9" { "" } else { " of 2.10" };
        let number = found.compared.len();
        Ok(match found.known.len() {
            0 => format!("{number}{version}"),
            n => format!("{number}{version}, {n} on purpose not"),
        })
    }

    /// Returns the number of cycles in which it agreed with LinuxCNC's.
    fn judge(&self, offer: &Offer) -> Result<String, String> {
        let name = &offer.component;
        if let Some([_, cycles]) = elsewhere(name) {
            return Ok(cycles.to_owned());
        }
        if let Some(row) = self.kinematics.get(name) {
            let places = row.get(2).and_then(|c| c.split(' ').next()).unwrap_or_default();
            return Ok(format!("{} places", thousands(places)));
        }
        let Some(row) = self.judge.get(name) else {
            return if pins::read(name).iter().any(|v| v.name == "2.9") {
                Err("has no row in tests/compat/conformance.md".to_owned())
            } else {
                Ok(NO_PEER.to_owned())
            };
        };
        let [_, _, _, cycles, result, ..] = row.as_slice() else {
            return Err("its row in tests/compat/conformance.md is not whole".to_owned());
        };
        let cycles = thousands(cycles);
        let short = result.split(';').next().unwrap_or_default();
        Ok(match short.split(' ').collect::<Vec<_>>().as_slice() {
            ["equal"] => cycles,
            ["equal", "within", ulps, ..] => format!("{cycles}, {ulps} ULPs"),
            ["equal", "but", "for", n, ..] => format!("{cycles}, {} known", n.trim_matches(',')),
            ["not", ..] => "not judged".to_owned(),
            _ => return Err(format!("tests/compat/conformance.md says: {short}")),
        })
    }

    /// Returns the duration of a call.
    fn time(&self, page: &Page) -> Result<String, String> {
        if page.functs.is_empty() {
            return Ok("no function".to_owned());
        }
        // The benchmark runs each component alone.
        if every::needs_motion(&page.offer.component) {
            return Ok("not measured alone".to_owned());
        }
        let row = self.speed.get(&page.offer.component);
        let cell = row.and_then(|row| row.get(2)).filter(|cell| !cell.is_empty());
        cell.cloned().ok_or_else(|| "has no row in components/SPEED.md".to_owned())
    }

    fn row(&self, page: &Page, sources: &Sources, is_alone: bool) -> Result<String, String> {
        let offer = &page.offer;
        let name = &offer.component;
        let summary = offer.doc.lines().next().unwrap_or_default().trim();
        if summary.is_empty() {
            return Err("it has no documentation".to_owned());
        }
        let names: Vec<&str> = [name].into_iter().chain(&page.also).map(String::as_str).collect();
        let counted = sources.count(&names, is_alone);
        let tests = match (counted.tests, counted.rows) {
            (0, 0) => return Err("no test in its library tells of it: write one".to_owned()),
            (tests, 0) => tests.to_string(),
            (tests, rows) => format!("{tests}, {} rows", thousands(&rows.to_string())),
        };
        let mut cells = vec![
            format!("[`{name}`](pages/{name}.md)"),
            summary.to_owned(),
            self.pins(offer)?,
            self.judge(offer)?,
            tests,
        ];
        if !self.speed.is_empty() {
            cells.push(self.time(page)?);
        }
        match cells.iter().position(|c| c.trim().is_empty()) {
            Some(at) => Err(format!("cell {} is empty", at + 1)),
            None => Ok(format!("| {} |", cells.join(" | "))),
        }
    }
}

/// Returns a library's description in its manifest.
fn description(library: &str) -> String {
    let file = family(library).join("Cargo.toml");
    let text = fs::read_to_string(file).unwrap();
    let line = text.lines().find_map(|l| l.strip_prefix("description = \"")).unwrap();
    line.trim_end_matches('"').to_owned()
}

fn table(pages: &[Page]) -> String {
    let shown = Shown::read();
    let mut libraries: BTreeMap<&str, Vec<&Page>> = BTreeMap::new();
    for page in pages {
        libraries.entry(page.offer.library.as_str()).or_default().push(page);
    }
    let (time, rule) = if shown.speed.is_empty() { ("", "") } else { (" ns |", "---|") };
    let head = format!(
        "\n| component | what it is | pins | cycles | tests |{time}\n|---|---|---|---|---|{rule}\n"
    );
    let (mut families, mut alone) =
        (String::new(), format!("\n### Alone in their libraries\n{head}"));
    let mut wrong = Vec::new();
    for (library, pages) in libraries {
        let sources = Sources::of(library);
        let is_alone = pages.len() == 1;
        if !is_alone {
            write!(families, "\n### {library}\n\n{}.\n{head}", description(library)).unwrap();
        }
        for page in pages {
            let to = if is_alone { &mut alone } else { &mut families };
            match shown.row(page, &sources, is_alone) {
                Ok(row) => writeln!(to, "{row}").unwrap(),
                Err(why) => wrong.push(format!("{}: {why}", page.offer.component)),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    format!("\n{families}{alone}\n")
}

#[test]
fn the_table_of_components_is_true() {
    golden::check_part(&root().join("components/README.md"), BEGIN, END, &table(&pages()));
}

/// Pins of simulated hardware are no part of a machine: they are listed only if a pattern names them, and `check` wants no wire
/// to them.
#[test]
fn simulated_pins_do_not_show() {
    let shown: BTreeSet<String> = pages()
        .into_iter()
        .filter(|page| page.items.iter().any(|e| e.first.contains(".sim.")))
        .map(|page| page.offer.component)
        .collect();
    // A camera and a robot whose simulation is also a demonstration.
    assert_eq!(shown.into_iter().collect::<Vec<_>>(), ["align", "robot"]);
}

#[test]
fn the_page_of_each_component_is_true() {
    let folder = root().join("components/pages");
    let update = golden::is_update();
    // The book is made of the pages: the programs are built before the pages go.
    let pages = pages();
    if update {
        drop(fs::remove_dir_all(&folder));
        fs::create_dir_all(&folder).unwrap();
    }
    let mut names = BTreeSet::new();
    for page in pages {
        let file = format!("{}.md", page.offer.component);
        assert!(page.refused.is_none(), "{file}: {}", page.refused.unwrap_or_default());
        let items = page.items.iter().map(|e| (&e.first, &e.doc));
        let silent = items.chain(page.functs.iter().map(|f| (&f.first, &f.doc)));
        let silent: Vec<_> = silent.filter(|(_, doc)| doc.is_empty()).collect();
        assert!(silent.is_empty(), "{file}: say what they are: {silent:?}");
        let text = page.markdown();
        if update {
            fs::write(folder.join(&file), text).unwrap();
        } else {
            let old = fs::read_to_string(folder.join(&file)).unwrap_or_default();
            assert_eq!(old, text, "{file}: {AGAIN}");
        }
        names.insert(file);
    }
    let is_there = |entry: fs::DirEntry| entry.file_name().into_string().unwrap();
    let files: BTreeSet<String> =
        fs::read_dir(&folder).unwrap().map(|e| is_there(e.unwrap())).collect();
    assert_eq!(files, names, "{AGAIN}");
}
