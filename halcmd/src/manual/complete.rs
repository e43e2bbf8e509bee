//! Completion of the word being typed, for the prompt and for every shell.

mod files;
mod live;
pub(crate) mod scripts;
mod shell;

use crate::{
    language::lex::is_arrow,
    language::rows::rows,
    language::table::{self, Row},
    language::word::Word,
    manual::{explain, man},
};
use hal_protocol::{Link, Type};
use live::Live;

pub use scripts::script;
pub use shell::{COMPLETE_FILES, for_shell};

/// A possible word.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Candidate {
    /// The word.
    pub word: String,
    /// Description, in a line.
    pub about: String,
}

impl Candidate {
    pub(crate) fn new(word: impl Into<String>, about: impl Into<String>) -> Self {
        Self { word: word.into(), about: about.into() }
    }

    /// Returns whether the word continues, so that no space may follow it.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.word.ends_with(['=', '/'])
    }
}

/// Possible completions of a line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Completion {
    /// Byte offset of the word that is being typed.
    pub at: usize,
    /// Possible words, by name.
    pub candidates: Vec<Candidate>,
    /// True if the name of a file is possible too.
    pub files: bool,
}

/// Completes the last word of `line` with what the instance behind `link` has.
pub fn complete(line: &str, link: &mut dyn Link) -> Completion {
    let Some((before, at)) = split(line) else { return Completion::default() };
    let word = line.get(at..).unwrap_or_default();
    let mut found = words(&before, word, link);
    if found.files {
        found.candidates.extend(files::files(word));
        found.candidates.sort();
    }
    Completion { at, ..found }
}

/// Completes `word` after the words in `before`.
pub fn words(before: &[String], word: &str, link: &mut dyn Link) -> Completion {
    let mut offered = Offered { word, candidates: Vec::new(), files: false };
    let mut live = Live::new(link, word);
    match before.split_first() {
        None => first(&mut offered, &mut live),
        Some((name, rest)) => match table::find(name) {
            Some(row) => arguments(row, rest, &mut offered, &mut live),
            None => unlisted(name, rest, &mut offered, &mut live),
        },
    }
    offered.candidates.sort();
    offered.candidates.dedup_by(|a, b| a.word == b.word);
    Completion { at: 0, candidates: offered.candidates, files: offered.files }
}

/// Candidates found so far for the word being typed.
struct Offered<'a> {
    word: &'a str,
    candidates: Vec<Candidate>,
    files: bool,
}

impl Offered<'_> {
    /// Adds the candidates that begin with the word. Options are added only after a '-'.
    fn add(&mut self, candidates: impl IntoIterator<Item = Candidate>) {
        let fits = |c: &Candidate| {
            c.word.starts_with(self.word)
                && (self.word.starts_with('-') || !c.word.starts_with('-'))
        };
        self.candidates.extend(candidates.into_iter().filter(fits));
    }
}

/// Returns the words before the one being typed, and the offset of that one. Returns `None` within
/// a comment.
fn split(line: &str) -> Option<(Vec<String>, usize)> {
    let (mut words, mut at, mut quote) = (Vec::new(), None, None);
    for (i, c) in line.char_indices() {
        match quote {
            Some(q) if c == q => quote = None,
            None if c == '#' => return None,
            None if c.is_ascii_whitespace() => {
                if let Some(from) = at.take() {
                    words.push(line.get(from..i).unwrap_or_default().to_owned());
                }
                continue;
            }
            None if c == '"' || c == '\'' => quote = Some(c),
            _ => {}
        }
        at = at.or(Some(i));
    }
    Some((words, at.unwrap_or(line.len())))
}

/// Completes the first word: a command, a component's command, or an item to set.
fn first(offered: &mut Offered<'_>, live: &mut Live<'_>) {
    offered.add(rows().map(|row| Candidate::new(row.name, row.summary)));
    if !offered.word.is_empty() {
        offered.add(live.commands());
    }
    if offered.word.contains('.') {
        offered.add(live.settable_items());
    }
}

/// Completes after a first word that is not a command of the table.
fn unlisted(name: &str, rest: &[String], offered: &mut Offered<'_>, live: &mut Live<'_>) {
    match rest {
        [] if live.is_settable(name) => offered.add([Candidate::new("=", "set it")]),
        [equals] if equals == "=" => offered.add(live.values(name, false)),
        _ => offered.add(live.command_args(name, rest)),
    }
}

fn arguments(row: &Row, rest: &[String], offered: &mut Offered<'_>, live: &mut Live<'_>) {
    let arrows = matches!(row.name, "net" | "linkps" | "linksp");
    let rest: Vec<String> = rest.iter().filter(|w| !(arrows && is_arrow(w))).cloned().collect();
    let at = rest.len();
    let word = match (row.words.get(at), row.words.last()) {
        (Some(word), _) => word,
        (None, Some(last @ Word::Many(_))) => last,
        _ => return,
    };
    if at < row.args.1 {
        argument(row, word, &rest, offered, live);
    }
}

fn argument(
    row: &Row,
    word: &Word,
    rest: &[String],
    offered: &mut Offered<'_>,
    live: &mut Live<'_>,
) {
    let first = rest.first().map(String::as_str).unwrap_or_default();
    let last = rest.last().map(String::as_str).unwrap_or_default();
    match word {
        Word::One(list) => offered.add(list.iter().map(|w| Candidate::new(*w, ""))),
        Word::Any(list) | Word::Many(list) => {
            list.iter().for_each(|word| argument(row, word, rest, offered, live));
        }
        Word::Free => {}
        Word::Module => offered.add(live.modules()),
        Word::Manual => offered.add(manual()),
        Word::Code => {
            offered.add(explain::rows().map(|row| Candidate::new(row.code.id(), row.means)));
        }
        Word::ModuleArg => offered.add(live.module_args(first, rest)),
        Word::Component => {
            offered.add(live.components(true));
            offered.add(live.components(false));
        }
        Word::RealtimeComponent => offered.add(live.components(true)),
        Word::ProgramComponent => offered.add(live.components(false)),
        Word::Program => program(rest, offered),
        Word::Pin => offered.add(live.pins(|_| true)),
        Word::LonePin => offered.add(live.pins(|pin| pin.signal.is_none())),
        Word::LinkedPin => offered.add(live.pins(|pin| pin.signal.is_some())),
        Word::PinForSignal => offered.add(live.pins_for(first, rest.get(1..).unwrap_or_default())),
        Word::Item => offered.add(live.items()),
        Word::SettableItem => offered.add(live.settable_items()),
        Word::ItemOfKind if first == "param" => offered.add(live.params()),
        Word::ItemOfKind => offered.add(live.pins(|_| true)),
        Word::AliasOfKind => offered.add(live.aliases(first == "param")),
        Word::Signal => offered.add(live.signals(|_| true)),
        Word::SettableSignal => offered.add(live.settable_signals()),
        Word::SignalForPin => offered.add(live.signals_for(first)),
        Word::Value => offered.add(live.values(last, row.name == "sets")),
        Word::FreeFunct => offered.add(live.functs(|funct| funct.users == 0)),
        Word::UsedFunct => offered.add(live.functs(|funct| funct.users > 0)),
        Word::Thread => offered.add(live.threads(|_| true)),
        Word::ThreadOfFunct => {
            offered.add(live.threads(|thread| thread.functs.iter().any(|f| f == first)));
        }
        Word::Type => offered.add(types()),
        Word::NameOfKind if last == "-t" => offered.add(types()),
        Word::Snapshot => offered.add(live.of_kind("snapshot")),
        Word::NameOfKind => offered.add(live.of_kind(first)),
        Word::Variable => {
            offered.add(live.items());
            offered.add(live.signals(|_| true));
        }
        Word::ComponentCommand => offered.add(live.commands()),
        Word::Topic => offered.add(rows().map(|row| Candidate::new(row.name, row.summary))),
        Word::File => offered.files = true,
    }
}

/// Returns every component type that has a manual page.
fn manual() -> Vec<Candidate> {
    let offers = man::offers().unwrap_or_default();
    offers.iter().map(|o| Candidate::new(o.component.as_str(), live::first_line(&o.doc))).collect()
}

/// Returns every type.
fn types() -> Vec<Candidate> {
    let all = [Type::Bit, Type::Float, Type::S32, Type::U32, Type::S64, Type::U64, Type::Port];
    all.iter().map(|ty| Candidate::new(ty.name(), "")).collect()
}

/// Completes a program of `loadusr`. The words after it are the program's own.
fn program(rest: &[String], offered: &mut Offered<'_>) {
    let named = |pair: &[String]| matches!(pair, [option, _] if option.ends_with('n'));
    let value = rest.last().is_some_and(|w| w.starts_with('-') && w.ends_with('n'));
    let given = rest.iter().enumerate().any(|(i, w)| {
        let of_option = i > 0 && rest.get(i - 1..=i).is_some_and(named);
        !w.starts_with('-') && !of_option
    });
    if value {
        return;
    }
    offered.files = true;
    if !given {
        let options = [
            ("-w", "wait until it ends"),
            ("-W", "wait until its component is ready"),
            ("-Wn", "wait until the component of this name is ready"),
            ("-i", "never mind how it ends"),
        ];
        offered.add(options.iter().map(|(w, about)| Candidate::new(*w, *about)));
        if !offered.word.is_empty() && !offered.word.contains('/') {
            offered.add(live::programs());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{complete, split};
    use hal_protocol::{Failure, Link, Reply, Request};

    /// A link without an instance.
    struct Nobody;

    impl Link for Nobody {
        fn call(&mut self, _: Request) -> Result<Reply, Failure> {
            Err(Failure::new(-111, "nobody"))
        }
    }

    #[test]
    fn lines_are_split_as_far_as_they_are_typed() {
        for (line, want) in [
            ("", Some((vec![], 0))),
            ("ne", Some((vec![], 0))),
            ("net ", Some((vec!["net"], 4))),
            ("  net  x y", Some((vec!["net", "x"], 9))),
            ("print \"a b\" c", Some((vec!["print", "\"a b\""], 12))),
            ("print \"a b", Some((vec!["print"], 6))),
            ("print \"a # b", Some((vec!["print"], 6))),
            ("net # x", None),
        ] {
            let want = want.map(|(w, at)| (w.into_iter().map(str::to_owned).collect(), at));
            assert_eq!(split(line), want, "{line:?}");
        }
    }

    #[test]
    fn without_an_instance_only_the_table_is_offered() {
        let offered = |line: &str| {
            let found = complete(line, &mut Nobody);
            let words: Vec<String> = found.candidates.into_iter().map(|c| c.word).collect();
            (found.at, words.join(" "), found.files)
        };
        for (line, want) in [
            ("unl", (0, "unlinkp unload unloadrt unloadusr unlock", false)),
            ("show th", (5, "thread", false)),
            ("net x ", (6, "", false)),
            ("a.b ", (4, "", false)),
            ("source src/manual/complete/f", (7, "src/manual/complete/files.rs", true)),
            ("save all src/terminal/scr", (9, "src/terminal/screen.rs src/terminal/screen/", true)),
            ("source /no/such/folder/", (7, "", true)),
            ("ü", (0, "", false)),
        ] {
            assert_eq!(offered(line), (want.0, want.1.to_owned(), want.2), "{line:?}");
        }
    }
}
