//! `halcmd man`: the page of a component, from what its plugin says about itself.

mod markdown;
mod pager;
mod prose;
mod text;

use crate::{
    Bytes, Captured, Error, Outcome, Session, Style, Terminal, halrun::plan::plugin_path,
    hint::nearest,
};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{
    CommandInfo, Direction, FunctInfo, ItemInfo, Kind, Link, Offer, Place, Reply, Request, Type,
};
use prose::Doc;
use std::path::PathBuf;

/// What there is to say about a component.
#[derive(Clone, Debug)]
pub struct Page {
    /// What the plugin says; only the name of what is no plugin.
    pub offer: Offer,
    /// The `loadrt` lines that made what follows.
    pub loads: Vec<String>,
    /// Its pins and parameters, where like ones are one entry.
    pub items: Vec<Entry>,
    /// Its functions.
    pub functs: Vec<FunctInfo>,
    /// Its commands.
    pub commands: Vec<CommandInfo>,
    /// Why nothing of it could be made.
    pub refused: Option<String>,
}

/// Pins or parameters that differ by a number in their names alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The name of the first.
    pub first: String,
    /// The name of the last, if there are several.
    pub last: Option<String>,
    /// The type of all.
    pub ty: Type,
    /// The direction of all.
    pub direction: Direction,
    /// What they begin with; absent: nothing, or each with another value.
    pub default: Option<String>,
    /// What they mean.
    pub doc: String,
}

/// The script in the documentation of a component that shows it at work.
#[must_use]
pub fn example(doc: &str) -> Option<String> {
    Doc::of(doc).example
}

/// Every page of what the plugins in these folders offer, by name.
///
/// # Errors
/// There is no engine to be had.
pub fn pages(path: &[PathBuf]) -> Result<Vec<Page>, Error> {
    let offers = engine(path)?.catalogue();
    offers.into_iter().map(|offer| Page::made(offer, &[], path)).collect()
}

impl Page {
    /// The page of one component, loaded with these arguments, or else as its example loads it.
    ///
    /// # Errors
    /// There is no such component.
    pub fn of(name: &str, args: &[String], path: &[PathBuf]) -> Result<Self, Error> {
        let mut offers = engine(path)?.catalogue();
        if let Some(i) = offers.iter().position(|offer| offer.component == name) {
            return Self::made(offers.swap_remove(i), args, path);
        }
        let offer = Offer {
            component: name.to_owned(),
            library: String::new(),
            doc: String::new(),
            args: Vec::new(),
        };
        let is_file = |folder: &PathBuf| folder.join(format!("{name}.so")).is_file();
        if !name.contains('/') && path.iter().any(is_file) {
            return Self::made(offer, args, path);
        }
        let near = nearest(name, offers.iter().map(|offer| offer.component.as_str()));
        Err(Error::NoManual { word: name.into(), near })
    }

    fn made(offer: Offer, args: &[String], path: &[PathBuf]) -> Result<Self, Error> {
        let loads = loads(&offer, args);
        let mut engine = engine(path)?;
        let mut terminal = Captured::default();
        let mut session = Session::new(&mut engine, &mut terminal, Style::default(), "manual");
        session.begin_trial();
        let _: Outcome = session.file("manual", Bytes::new(loads.join("\n").into_bytes()));
        let attempt = session.end_trial();
        let refused = attempt.refusals.first().map(|refusal| refusal.error.whole());
        let name = &offer.component;
        let functs: Vec<FunctInfo> = match engine.call(all(Kind::Functs)) {
            Ok(Reply::Functs(list)) => list.into_iter().filter(|f| f.owner_name == *name).collect(),
            _ => Vec::new(),
        };
        let mut items = Vec::new();
        for kind in [Kind::Pins, Kind::Params] {
            if let Ok(Reply::Items(list)) = engine.call(all(kind)) {
                let own = list.into_iter().filter(|item| item.owner_name == *name);
                items.extend(gathered(own.filter(|item| !is_time(&item.name, &functs))));
            }
        }
        let commands = match engine.call(all(Kind::Commands)) {
            Ok(Reply::Commands(list)) => list,
            _ => Vec::new(),
        };
        engine.close();
        Ok(Self { offer, loads, items, functs, commands, refused })
    }
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
    Ok(Engine::trial(Options {
        place,
        clock: ClockKind::Virtual,
        hold: true,
        simulate: false,
        old_names: false,
        path: path.to_vec(),
    })?)
}

/// The lines of the example that load something, up to the one that loads the component.
fn loads(offer: &Offer, args: &[String]) -> Vec<String> {
    let name = &offer.component;
    let example = example(&offer.doc).unwrap_or_default();
    let mut lines = Vec::new();
    for line in example.lines().map(str::trim).filter(|l| l.starts_with("loadrt ")) {
        if line.split_whitespace().nth(1) == Some(name) {
            if args.is_empty() {
                lines.push(line.to_owned());
                return lines;
            }
            break;
        }
        lines.push(line.to_owned());
    }
    let words: Vec<&str> =
        ["loadrt", name].into_iter().chain(args.iter().map(String::as_str)).collect();
    if !example.lines().any(|l| l.split_whitespace().nth(1) == Some(name)) {
        lines.clear();
    }
    lines.push(words.join(" "));
    lines
}

/// Whether it is the time that one of its functions takes.
fn is_time(name: &str, functs: &[FunctInfo]) -> bool {
    let owner = [".time", ".tmax", ".tmax-increased"].iter().find_map(|e| name.strip_suffix(e));
    owner.is_some_and(|owner| functs.iter().any(|f| f.name == owner))
}

/// Like ones together, where the first of them stood.
fn gathered(items: impl Iterator<Item = ItemInfo>) -> Vec<Entry> {
    let mut out: Vec<(String, Entry)> = Vec::new();
    for item in items {
        let template: String = item
            .name
            .split_inclusive(|c: char| !c.is_ascii_digit())
            .map(|part| match part.trim_start_matches(|c: char| c.is_ascii_digit()) {
                rest if rest.len() == part.len() => part.to_owned(),
                rest => format!("#{rest}"),
            })
            .collect();
        let value = item.value.to_string();
        let is_nothing = matches!(value.as_str(), "0" | "FALSE" | "0x00000000");
        let default = Some(value).filter(|_| !is_nothing);
        let same = out.iter_mut().find(|(other, entry)| {
            *other == template
                && (entry.ty, entry.direction) == (item.value.ty(), item.direction)
                && entry.doc == item.doc
        });
        if let Some((_, entry)) = same {
            if entry.default != default {
                entry.default = None;
            }
            entry.last = Some(item.name);
        } else {
            let entry = Entry {
                first: item.name,
                last: None,
                ty: item.value.ty(),
                direction: item.direction,
                default,
                doc: item.doc,
            };
            out.push((template, entry));
        }
    }
    out.into_iter().map(|(_, entry)| entry).collect()
}

/// Runs `halcmd man NAME [ARGUMENTS]`: on a terminal through a pager.
///
/// # Errors
/// There is no such component.
pub fn main(words: &[String], terminal: &mut dyn Terminal) -> Result<u8, Error> {
    let Some((name, args)) = words.split_first() else { return Ok(1) };
    let page = Page::of(name, args, &plugin_path(&|name| std::env::var(name).ok()))?;
    let text = page.text();
    if !(terminal.is_screen() && pager::show(&text)) {
        terminal.out(&text);
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::{gathered, loads};
    use hal_protocol::{Direction, ItemInfo, Offer, Value};

    fn item(name: &str, value: Value, doc: &str) -> ItemInfo {
        ItemInfo {
            owner: 1,
            owner_name: "x".to_owned(),
            direction: Direction::In,
            value,
            name: name.to_owned(),
            original: None,
            signal: None,
            doc: doc.to_owned(),
        }
    }

    #[test]
    fn like_ones_are_one_entry() {
        let items = [
            item("x.0.in-00", Value::Bit(true), "Input."),
            item("x.0.in-01", Value::Bit(true), "Input."),
            item("x.0.out", Value::S32(0), "Output."),
            item("x.0.s32-0", Value::S32(5), "Number."),
            item("x.0.s32-1", Value::S32(6), "Number."),
        ];
        let found = gathered(items.into_iter());
        let shown: Vec<_> = found
            .iter()
            .map(|e| (e.first.as_str(), e.last.as_deref(), e.default.as_deref()))
            .collect();
        assert_eq!(
            shown,
            [
                ("x.0.in-00", Some("x.0.in-01"), Some("TRUE")),
                ("x.0.out", None, None),
                ("x.0.s32-0", Some("x.0.s32-1"), None),
            ]
        );
    }

    #[test]
    fn what_the_example_loads_is_loaded() {
        let doc = "It.\n\n# Example\n\n```hal\nloadrt y\nloadrt x cfg=3\nloadrt z\n```";
        let offer = Offer {
            component: "x".to_owned(),
            library: String::new(),
            doc: doc.to_owned(),
            args: Vec::new(),
        };
        assert_eq!(loads(&offer, &[]), ["loadrt y", "loadrt x cfg=3"]);
        assert_eq!(loads(&offer, &["cfg=9".to_owned()]), ["loadrt y", "loadrt x cfg=9"]);
        let bare = Offer { doc: "It.".to_owned(), ..offer };
        assert_eq!(loads(&bare, &[]), ["loadrt x"]);
    }
}
