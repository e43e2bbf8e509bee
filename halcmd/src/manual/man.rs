//! `halcmd man`: the manual page of a component, made from the plugin's documentation.

mod gather;
mod grid;
mod markdown;
mod pager;
mod prose;
mod roff;
mod text;

use crate::{
    Bytes, Captured, Error, Outcome, Session, Style, Terminal, language::hint::nearest,
    programs::halrun::folders::plugin_path,
};
use gather::{Found, functions, gathered};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{
    CommandInfo, Direction, FunctInfo, ItemInfo, Kind, Link, Offer, Place, Reply, Request, Type,
};
use prose::Doc;
use std::path::PathBuf;

/// Content of the manual page of a component.
#[derive(Clone, Debug)]
pub struct Page {
    /// Information from the plugin; for a page without a plugin, only the name.
    pub offer: Offer,
    /// Other names of the component.
    pub also: Vec<String>,
    /// The `loadrt` lines that made the pins below. There are several if no single one makes all
    /// pins.
    pub loads: Vec<Vec<String>>,
    /// Pins and parameters. Similar ones are one entry.
    pub items: Vec<Entry>,
    /// Functions. Similar ones are one entry.
    pub functs: Vec<Function>,
    /// Commands of the component.
    pub commands: Vec<CommandInfo>,
    /// Reason why nothing of it could be loaded.
    pub refused: Option<String>,
}

/// Pins or parameters whose names differ only by a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Name of the first.
    pub first: String,
    /// Name of the last, if there are several.
    pub last: Option<String>,
    /// Common type.
    pub ty: Type,
    /// Common direction.
    pub direction: Direction,
    /// Initial value, or the list of the initial values.
    pub default: String,
    /// Description of the arguments with which they exist; empty if they exist with all tried
    /// arguments.
    pub with: String,
    /// Documentation.
    pub doc: String,
}

/// Functions whose names differ only by a number.
#[derive(Clone, Debug, PartialEq)]
pub struct Function {
    /// Name of the first.
    pub first: String,
    /// Name of the last, if there are several.
    pub last: Option<String>,
    /// True if they belong in a fast thread.
    pub fast: bool,
    /// Documentation.
    pub doc: String,
}

/// Returns the example script in a component's documentation.
#[must_use]
pub fn example(doc: &str) -> Option<String> {
    Doc::of(doc).example
}

/// Returns every page of the components in these plugin folders, by name.
///
/// # Errors
/// No engine can be created.
pub fn pages(path: &[PathBuf]) -> Result<Vec<Page>, Error> {
    let offers = engine(path)?.catalogue();
    let page = |offer: &Offer| Page::made(offer.clone(), also(offer, &offers), &[], path);
    offers.iter().map(page).collect()
}

impl Page {
    /// Returns the page of a component, loaded with these arguments, or without arguments as in its
    /// example.
    ///
    /// # Errors
    /// There is no such component.
    pub fn of(name: &str, args: &[String], path: &[PathBuf]) -> Result<Self, Error> {
        let mut offers = engine(path)?.catalogue();
        if let Some(i) = offers.iter().position(|offer| offer.component == name) {
            let offer = offers.swap_remove(i);
            let also = also(&offer, &offers);
            return Self::made(offer, also, args, path);
        }
        let offer = Offer {
            component: name.to_owned(),
            library: String::new(),
            doc: String::new(),
            args: Vec::new(),
        };
        let is_file = |folder: &PathBuf| folder.join(format!("{name}.so")).is_file();
        if !name.contains('/') && path.iter().any(is_file) {
            return Self::made(offer, Vec::new(), args, path);
        }
        let near = nearest(name, offers.iter().map(|offer| offer.component.as_str()));
        Err(Error::NoManual { word: name.into(), near })
    }

    fn made(
        offer: Offer,
        also: Vec<String>,
        args: &[String],
        path: &[PathBuf],
    ) -> Result<Self, Error> {
        let loads = loads(&offer, args);
        let mut page = Self {
            offer,
            also,
            loads,
            items: Vec::new(),
            functs: Vec::new(),
            commands: Vec::new(),
            refused: None,
        };
        let (mut pins, mut params, mut functs) = (Vec::new(), Vec::new(), Vec::new());
        for (i, lines) in page.loads.clone().iter().enumerate() {
            let mut engine = engine(path)?;
            let mut terminal = Captured::default();
            let mut session = Session::new(&mut engine, &mut terminal, Style::default(), "manual");
            session.begin_dry_run();
            let _: Outcome = session.file("manual", Bytes::new(lines.join("\n").into_bytes()));
            let result = session.end_dry_run();
            if let Some(refusal) = result.refusals.first() {
                page.refused.get_or_insert_with(|| refusal.error.whole());
            }
            let name = &page.offer.component;
            let own = of(&mut engine, name);
            if page.offer.doc.is_empty() {
                page.offer.doc = description(&mut engine, name);
            }
            let name = &page.offer.component;
            look(&mut engine, name, i, &own, [&mut pins, &mut params]);
            functs.extend(own);
            if let Ok(Reply::Commands(list)) = engine.call(all(Kind::Commands)) {
                page.commands = list;
            }
            engine.close();
        }
        functs.sort_by(|a, b| a.name.cmp(&b.name));
        functs.dedup_by(|a, b| a.name == b.name);
        page.functs = functions(functs);
        let args: Vec<Vec<String>> = page.loads.iter().map(|lines| arguments(lines)).collect();
        page.items = gathered(pins, &args);
        page.items.extend(gathered(params, &args));
        Ok(page)
    }
}

/// Returns the functions of a component.
fn of(engine: &mut Engine, name: &str) -> Vec<FunctInfo> {
    match engine.call(all(Kind::Functs)) {
        Ok(Reply::Functs(list)) => list.into_iter().filter(|f| f.owner_name == name).collect(),
        _ => Vec::new(),
    }
}

/// Returns the description in the file of a component in C.
fn description(engine: &mut Engine, name: &str) -> String {
    let found = engine.call(Request::Component { name: name.to_owned() });
    let Ok(Reply::Components(list)) = found else { return String::new() };
    list.into_iter().next().and_then(|c| c.foreign).map_or_else(String::new, |file| file.doc)
}

/// Returns the component types of the plugin path.
pub(crate) fn offers() -> Result<Vec<Offer>, Error> {
    Ok(engine(&plugin_path(&|name| std::env::var(name).ok()))?.catalogue())
}

/// Records the pins and parameters that load number `i` made.
fn look(
    engine: &mut Engine,
    name: &str,
    i: usize,
    functs: &[FunctInfo],
    [pins, params]: [&mut Vec<Found>; 2],
) {
    for (kind, list) in [(Kind::Pins, pins), (Kind::Params, params)] {
        let Ok(Reply::Items(items)) = engine.call(all(kind)) else { continue };
        let own = items.into_iter().filter(|item| item.owner_name == name);
        for item in own.filter(|item| !is_time(&item.name, functs)) {
            match list.iter_mut().find(|found| is_same(&found.item, &item)) {
                Some(found) => found.loads.push(i),
                None => list.push(Found { item, loads: vec![i] }),
            }
        }
    }
}

fn is_same(a: &ItemInfo, b: &ItemInfo) -> bool {
    let kind = |i: &ItemInfo| (i.value.ty(), i.direction);
    a.name == b.name && kind(a) == kind(b) && a.doc == b.doc
}

/// Returns the other names under which the same component is offered.
fn also(offer: &Offer, offers: &[Offer]) -> Vec<String> {
    let same = |o: &&Offer| (&o.library, &o.doc) == (&offer.library, &offer.doc);
    let names = offers.iter().filter(same).map(|o| &o.component);
    names.filter(|name| **name != offer.component).cloned().collect()
}

fn all(kind: Kind) -> Request {
    Request::List { kind, patterns: Vec::new(), ty: None }
}

fn engine(path: &[PathBuf]) -> Result<Engine, Error> {
    let place = Place::at(std::env::temp_dir(), "manual").map_err(|why| Error::OptionValue {
        program: "halcmd",
        option: "--instance".into(),
        value: "manual".into(),
        why: why.into(),
    })?;
    Ok(Engine::dry_run(Options {
        simulate: false,
        path: path.to_vec(),
        ..Options::simulated(place, ClockKind::Virtual)
    })?)
}

/// Returns the sequences of `loadrt` lines to try: the lines of the example up to the one that
/// loads the component, and the same lines with each `loadrt` line of the documentation's section
/// on pins.
fn loads(offer: &Offer, args: &[String]) -> Vec<Vec<String>> {
    let name = &offer.component;
    let doc = Doc::of(&offer.doc);
    let example = doc.example.unwrap_or_default();
    let loads_it = |l: &str| l.split_whitespace().nth(1) == Some(name);
    let lines = || example.lines().map(str::trim).filter(|l| l.starts_with("loadrt "));
    let before: Vec<String> = match lines().position(loads_it) {
        Some(at) => lines().take(at).map(str::to_owned).collect(),
        None => Vec::new(),
    };
    let mut own: Vec<String> = Vec::new();
    if args.is_empty() {
        own.extend(lines().find(|l| loads_it(l)).map(str::to_owned));
        own.extend(doc.pins);
    }
    if own.is_empty() {
        let words = ["loadrt", name].into_iter().chain(args.iter().map(String::as_str));
        own.push(words.collect::<Vec<_>>().join(" "));
    }
    own.into_iter().map(|line| [before.clone(), vec![line]].concat()).collect()
}

/// Returns the arguments of the last line.
fn arguments(lines: &[String]) -> Vec<String> {
    let words = lines.last().map(|l| l.split_whitespace().skip(2));
    words.into_iter().flatten().map(str::to_owned).collect()
}

/// Returns whether the name is a timing pin or parameter of one of the functions.
fn is_time(name: &str, functs: &[FunctInfo]) -> bool {
    let owner = [".time", ".tmax", ".tmax-increased"].iter().find_map(|e| name.strip_suffix(e));
    owner.is_some_and(|owner| functs.iter().any(|f| f.name == owner))
}

/// Word that asks for the page in the format of `man`.
const ROFF: &str = "--roff";

/// Runs `halcmd man [--roff] NAME [ARGUMENTS]`. On a terminal it uses a pager.
///
/// # Errors
/// There is no such component.
pub fn main(words: &[String], terminal: &mut dyn Terminal) -> Result<u8, Error> {
    let (is_roff, words) = match words.split_first() {
        Some((first, rest)) if first == ROFF => (true, rest),
        _ => (false, words),
    };
    let Some((name, args)) = words.split_first() else { return Ok(1) };
    let page = Page::of(name, args, &plugin_path(&|name| std::env::var(name).ok()))?;
    if is_roff {
        terminal.out(&page.roff())?;
        return Ok(0);
    }
    let text = page.text();
    if !(terminal.is_screen() && pager::show(&text)) {
        terminal.out(&text)?;
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::loads;
    use hal_protocol::Offer;

    #[test]
    fn what_the_example_loads_is_loaded() {
        let doc = "It.\n\n# Example\n\n```hal\nloadrt y\nloadrt x cfg=3\nloadrt z\n```";
        let offer = Offer {
            component: "x".to_owned(),
            library: String::new(),
            doc: doc.to_owned(),
            args: Vec::new(),
        };
        assert_eq!(loads(&offer, &[]), [["loadrt y", "loadrt x cfg=3"]]);
        assert_eq!(loads(&offer, &["cfg=9".to_owned()]), [["loadrt y", "loadrt x cfg=9"]]);
        let bare = Offer { doc: "It.".to_owned(), ..offer.clone() };
        assert_eq!(loads(&bare, &[]), [["loadrt x"]]);
        let doc = doc.replace("# Example", "# Pins\n\n```hal\nloadrt x cfg=4\n```\n\n# Example");
        let both = Offer { doc, ..offer };
        let wanted = [["loadrt y", "loadrt x cfg=3"], ["loadrt y", "loadrt x cfg=4"]];
        assert_eq!(loads(&both, &[]), wanted);
        assert_eq!(loads(&both, &["cfg=9".to_owned()]), [["loadrt y", "loadrt x cfg=9"]]);
    }
}
