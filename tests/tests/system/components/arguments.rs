//! Bad arguments of every component of every plugin library: each is refused with a sentence that names the component,
//! the argument and its legal values; no part of the load remains, threads continue, and a load with good arguments
//! works afterwards.
//!
//! `tests/arguments.md` lists all sentences for review; `UPDATE_EXPECT=1` writes it. Arguments that a component accepts
//! although they look wrong are listed with the reason in `tests/properties/NAME.toml`:
//!
//! ```toml
//! [[takes]]
//! words = ["personality=-1"]
//! why = "…"
//! ```
#![expect(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use hal_protocol::{ArgInfo, Bounds, Failure, Kind, Link, Offer, Request};
use hal_tests::{
    every::offers,
    foreign::Bench,
    golden,
    machine::{script, seen},
    programs::root,
    properties::case::Case,
    random::Random,
};
use std::{collections::BTreeMap, fmt::Write};

/// Texts that no integer argument accepts.
const NO_INTEGERS: &[&str] = &["x", "", "1.5", "1e3", "0x", "99999999999999999999"];
/// Numbers that are too small or too large for a size or a count.
const FAR: &[&str] = &["-1", "1000000000", "-9223372036854775808"];
/// Number of components from which a shared sentence is listed only once.
const SHARED: usize = 12;
/// Phrases that state the legal values where they are not a range.
const LEGAL: &[&str] = &[
    "are needed",
    "at most",
    "between",
    "can only take",
    "did you mean",
    "exclusive",
    "expected",
    "it takes",
    "must be",
    "none of",
    "one of",
    "out of",
    "such as",
];
/// Number of random changes to each text.
const CHANGES: usize = 40;

/// A load that must be refused.
#[derive(Clone, Debug)]
struct Bad {
    /// Name of the wrong argument.
    arg: String,
    words: Vec<String>,
    /// Text of the argument in the file.
    shown: String,
    /// True if the argument was changed at random and may be legal.
    chance: bool,
}

/// A component under test.
struct Trial<'o> {
    offer: &'o Offer,
    case: Case,
    /// Arguments that are legal.
    good: Vec<String>,
    bench: Bench,
    wrong: Vec<String>,
    refused: Vec<(String, String)>,
}

impl Trial<'_> {
    fn new(offer: &Offer) -> Trial<'_> {
        let case = Case::of(offer).unwrap();
        let ways = case.ways(offer).unwrap();
        let good = ways[0].split(' ').filter(|w| !w.is_empty()).map(str::to_owned).collect();
        let mut bench = Bench::new(&[]);
        // None of these is under test.
        if case.threads.is_empty() && offer.component != "threads" {
            script(&mut bench, "loadrt threads name1=t period1=1000000");
        }
        let other = if offer.component == "lut5" { "maj3" } else { "lut5" };
        script(&mut bench, &format!("loadrt {other} names=other\nstart"));
        for line in &case.before {
            script(&mut bench, line);
        }
        Trial { offer, case, good, bench, wrong: Vec::new(), refused: Vec::new() }
    }

    fn load(&mut self, words: &[String]) -> Result<(), Failure> {
        let module = self.offer.component.clone();
        self.bench.call(Request::Load { module, args: words.to_vec() }).map(drop)
    }

    /// Tests one load.
    fn refuse(&mut self, bad: &Bad) {
        let name = self.offer.component.clone();
        let before = seen(&mut self.bench);
        let is_known = |t: &Self| t.case.takes.iter().any(|t| t.words.contains(&bad.shown));
        let Err(said) = self.load(&bad.words) else {
            if !bad.chance && !is_known(self) {
                self.wrong.push(format!("{name} takes {}", bad.shown));
            }
            script(&mut self.bench, &format!("unloadrt {name}"));
            return;
        };
        if is_known(self) {
            self.wrong.push(format!("{name} refuses {}: take it out of its file", bad.shown));
        }
        let sentence = match &said.hint {
            Some(hint) => format!("{}; {hint}", said.text),
            None => said.text.clone(),
        };
        let arg = self.offer.args.iter().find(|a| a.name == bad.arg);
        let is_legal = match arg.map(ArgInfo::range).filter(|range| !range.is_empty()) {
            Some(range) if said.text.contains("out of range") => {
                sentence.contains(&format!("expected {range}"))
            }
            _ => is_legal(&sentence),
        };
        if !names(&said.text, &name) || !names(&sentence, &bad.arg) || !is_legal {
            self.wrong.push(format!("{name} {}: {sentence}", bad.shown));
        }
        if seen(&mut self.bench) != before {
            self.wrong.push(format!("{name} {}: something is left", bad.shown));
        }
        if !bad.chance {
            self.refused.push((bad.shown.clone(), sentence));
        }
    }

    /// Tests all bad arguments in turn, and then a good load.
    fn run(&mut self) {
        for bad in self.bad() {
            self.refuse(&bad);
        }
        self.taken();
        script(&mut self.bench, "newsig moved bit\ndelsig moved");
        self.bench.call(Request::Run { ns: 3_000_000 }).unwrap();
        if let Err(failure) = self.load(&self.good.clone()) {
            let name = &self.offer.component;
            self.wrong.push(format!("{name} {}: {failure}", self.good.join(" ")));
        }
    }

    /// Tests a load whose first pin exists already.
    fn taken(&mut self) {
        let name = self.offer.component.clone();
        if !self.offer.args.iter().any(|a| a.name == "names") {
            return;
        }
        let mut words: Vec<String> = self.good.clone();
        words.retain(|w| !w.starts_with("count=") && !w.starts_with("num_chan="));
        words.push("names=same".to_owned());
        if self.load(&words).is_err() {
            return;
        }
        let pins = self.bench.items(Kind::Pins, "same*");
        script(&mut self.bench, &format!("unloadrt {name}"));
        let Some(pin) = pins.first() else { return };
        let other = self.bench.items(Kind::Pins, "other.*").remove(0).name;
        script(&mut self.bench, &format!("alias pin {other} {}", pin.name));
        let shown = "names=same, which is taken".to_owned();
        self.refuse(&Bad { arg: "names".to_owned(), words, shown, chance: false });
        script(&mut self.bench, &format!("unalias pin {other}"));
    }

    /// Returns the loads to test.
    fn bad(&self) -> Vec<Bad> {
        let mut out = Vec::new();
        for a in &self.offer.args {
            let mut add = |arg: &str, value: &str| {
                out.push(self.with(arg, &format!("{arg}={value}"), false));
            };
            let Bounds { low, high, above } = a.bounds;
            let below = low.map(|low| if above { low } else { low - 1.0 });
            for outside in below.into_iter().chain(high.map(|high| high + 1.0)) {
                add(&a.name, &outside.to_string());
            }
            match &*a.ty {
                "int" => NO_INTEGERS.iter().chain(FAR).for_each(|v| add(&a.name, v)),
                "ints" => {
                    NO_INTEGERS.iter().chain(FAR).for_each(|v| add(&a.name, v));
                    add(&a.name, "1,x");
                    add(&a.name, "1,,1");
                }
                "float" => ["x", "", "1e999", "nan", "-inf"].iter().for_each(|v| add(&a.name, v)),
                "bit" => ["x", "", "7"].iter().for_each(|v| add(&a.name, v)),
                "texts" if a.name == "names" => {
                    for v in ["a,", "a,,b", "a,a", "a b", "a\tb"] {
                        add("names", v);
                    }
                    add("names", &"n".repeat(54));
                    add("names", &"n".repeat(56));
                }
                _ => {
                    // An empty list is that of the default.
                    let empty = (a.ty != "texts" || a.default.is_none()).then_some("");
                    for v in empty.into_iter().chain(["%", "?,?", "\u{e9}"]) {
                        add(&a.name, v);
                    }
                    add(&a.name, &"x".repeat(300));
                }
            }
            if a.required {
                let begins = format!("{}=", a.name);
                let words = self.good.iter().filter(|w| !w.starts_with(&begins));
                let (words, arg) = (words.cloned().collect(), a.name.clone());
                out.push(Bad { arg, words, shown: format!("no {}=", a.name), chance: false });
            }
        }
        let has = |name: &str| self.offer.args.iter().any(|a| a.name == name);
        for count in ["count", "num_chan"] {
            if has(count) && has("names") {
                let mut both = self.with("names", "names=a,b", false);
                both.words.push(format!("{count}=2"));
                both.shown = format!("names=a,b {count}=2");
                out.push(both);
            }
        }
        out.push(self.with("colour", "colour=red", false));
        out.push(self.with("colour", "colour", false));
        self.chance(&mut out);
        out
    }

    /// Adds legal texts with random changes.
    fn chance(&self, out: &mut Vec<Bad>) {
        let letters: Vec<char> = "abdefiopsuvx01259_,;.-\u{e9} ".chars().collect();
        let mut random = Random::new(self.offer.component.bytes().map(u64::from).sum());
        for way in self.case.ways(self.offer).unwrap() {
            for word in way.split(' ').filter(|w| w.contains('=')) {
                let (arg, value) = word.split_once('=').unwrap();
                for _ in 0..CHANGES {
                    let mut text: Vec<char> = value.chars().collect();
                    let at = random.index(text.len());
                    match random.below(3) {
                        0 => text[at] = random.pick(&letters),
                        1 => text.insert(at, random.pick(&letters)),
                        _ => drop(text.remove(at)),
                    }
                    let text: String = text.into_iter().collect();
                    let mut bad = self.with(arg, &format!("{arg}={text}"), true);
                    bad.words = way.split(' ').map(str::to_owned).collect();
                    let place = bad.words.iter().position(|w| w == word).unwrap();
                    bad.words[place] = format!("{arg}={text}");
                    out.push(bad);
                }
            }
        }
    }

    /// Returns the good arguments with one replaced.
    fn with(&self, arg: &str, word: &str, chance: bool) -> Bad {
        let begins = format!("{arg}=");
        let excludes = |w: &String| {
            w.starts_with(&begins)
                || arg == "names" && (w.starts_with("count=") || w.starts_with("num_chan="))
                || (arg == "count" || arg == "num_chan") && w.starts_with("names=")
        };
        let mut words: Vec<String> = self.good.iter().filter(|w| !excludes(w)).cloned().collect();
        words.push(word.to_owned());
        let short = if word.len() > 60 {
            format!("{arg}= with {} characters", word.len() - begins.len())
        } else {
            word.replace('\t', "<TAB>")
        };
        Bad { arg: arg.to_owned(), words, shown: short, chance }
    }
}

/// Returns whether a word occurs in a sentence as a whole word.
fn names(sentence: &str, word: &str) -> bool {
    sentence.split(|c: char| !c.is_alphanumeric() && !"_-".contains(c)).any(|w| w == word)
}

/// Returns whether a sentence states the legal values of an argument.
fn is_legal(sentence: &str) -> bool {
    let range = |(at, _): (usize, &str)| {
        let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
        digit(sentence[..at].chars().next_back())
            && sentence[at + 4..].starts_with(|c: char| c.is_ascii_digit() || c == '-')
    };
    sentence.match_indices(" to ").any(range) || LEGAL.iter().any(|legal| sentence.contains(legal))
}

/// Returns a sentence without the parts specific to one component.
fn common(sentence: &str, component: &str) -> String {
    let mut out = sentence.replacen(&format!("{component}: "), "NAME: ", 1);
    if let Some((before, rest)) = out.split_once("'same.")
        && let Some((_, after)) = rest.split_once('\'')
    {
        out = format!("{before}'same.PIN'{after}");
    } else if let Some((before, rest)) = out.split_once(".")
        && let Some((_, after)) = rest.split_once('\'')
        && before.ends_with("nnnn")
    {
        out = format!("{before}.PIN'{after}");
    }
    out
}

/// Returns the rows of the file; values with the same sentence share a row.
fn rows(all: &[(String, String)]) -> String {
    let mut kinds: Vec<(String, Vec<&str>)> = Vec::new();
    for (shown, sentence) in all {
        let mut said = sentence.clone();
        if let Some((arg, value)) = shown.split_once('=').filter(|(_, v)| !v.contains('=')) {
            said = said.replace(&format!("`{value}'"), "`VALUE'");
            said = said.replace(&format!("`{arg}={value}'"), &format!("`{arg}=VALUE'"));
        }
        said = said.replace(&"x".repeat(300), "xxx...").replace(&"n".repeat(50), "nnn...");
        match kinds.iter_mut().find(|k| k.0 == said) {
            Some((_, words)) if words.contains(&&**shown) => (),
            Some((_, words)) => words.push(shown),
            None => kinds.push((said, vec![shown])),
        }
    }
    let mut out = String::new();
    for (said, words) in kinds {
        writeln!(out, "{}\n    {said}", words.join(" | ").replace(&"n".repeat(50), "nnn..."))
            .unwrap();
    }
    out
}

/// Returns the file: first the sentences that many components share.
fn written(all: &[(String, Vec<(String, String)>)]) -> String {
    let mut shared: BTreeMap<(String, String), usize> = BTreeMap::new();
    for (name, rows) in all {
        for (shown, sentence) in rows {
            *shared.entry((shown.clone(), common(sentence, name))).or_default() += 1;
        }
    }
    shared.retain(|_, n| *n >= SHARED);
    let first: Vec<_> = shared.keys().cloned().collect();
    let mut text = format!(
        "# Bad arguments, and what is said of them\n\n\
         Every component that a plugin library offers is loaded with each of these, and nothing is\n\
         left of it. Written and checked by `tests/tests/system/components/arguments.rs`.\n\n\
         ## What many have in common\n\n```text\n{}```\n",
        rows(&first)
    );
    for (name, said) in all {
        let is_own =
            |row: &&(String, String)| !shared.contains_key(&(row.0.clone(), common(&row.1, name)));
        let own: Vec<_> = said.iter().filter(is_own).cloned().collect();
        if !own.is_empty() {
            write!(text, "\n## {name}\n\n```text\n{}```\n", rows(&own)).unwrap();
        }
    }
    text
}

#[test]
fn every_bad_argument_is_refused_and_nothing_is_left() {
    let only = std::env::var("ARGUMENTS").ok();
    let offers = offers();
    let (mut wrong, mut all) = (Vec::new(), Vec::new());
    for offer in offers.iter().filter(|o| only.as_ref().is_none_or(|n| *n == o.component)) {
        let mut trial = Trial::new(offer);
        trial.run();
        trial.bench.engine.close();
        wrong.append(&mut trial.wrong);
        all.push((offer.component.clone(), trial.refused));
    }
    assert!(wrong.is_empty(), "{} are wrong:\n{}", wrong.len(), wrong.join("\n"));
    if only.is_some() {
        return;
    }
    let path = root().join("tests/arguments.md");
    let new = written(&all);
    golden::check(&path, &new);
}
