//! The content of a drawing: boxes with pins, signals between them, and threads.

use crate::Error;
use hal_protocol::{
    ComponentInfo, Direction, FunctInfo, ItemInfo, Kind, Patterns, Reply, Request, Type,
};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Selection of the things to draw.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Patterns for the names of signals, pins and components. Only matching signals are drawn;
    /// without patterns, all are.
    pub patterns: Vec<String>,
    /// True to include pins without a signal, and components that have only such pins.
    pub all: bool,
    /// True to include parameters.
    pub params: bool,
}

/// A machine to be drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Drawing {
    /// Title above the picture.
    pub title: String,
    /// The threads, fastest first.
    pub threads: Vec<Thread>,
    /// Components. A component with several instances has a box for each.
    pub boxes: Vec<Boxed>,
    /// Connections between pins.
    pub signals: Vec<Signal>,
}

/// A thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Thread {
    /// Name of the thread.
    pub name: String,
    /// Period in nanoseconds.
    pub period: u64,
}

/// The box of a component or of one of its instances.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Boxed {
    /// Name of the component or the instance.
    pub name: String,
    /// True for a userspace program, false for a plugin.
    pub program: bool,
    /// Functions that a thread runs, with the numbers of their threads.
    pub functs: Vec<(String, usize)>,
    /// Pins, grouped by the common beginning of their names.
    pub sections: Vec<Section>,
    /// Names and values of the parameters.
    pub params: Vec<(String, String)>,
}

/// Pins whose names have a common beginning.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Section {
    /// Common beginning of the names; empty if it is the name of the box.
    pub name: String,
    /// Input pins.
    pub left: Vec<Pin>,
    /// Output pins.
    pub right: Vec<Pin>,
}

/// A pin in a box.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Pin {
    /// Text beside the pin.
    pub label: String,
    /// Full name.
    pub name: String,
    /// Direction of the pin.
    pub direction: Direction,
    /// Type of the pin.
    pub ty: Type,
    /// Number of its signal.
    pub signal: Option<usize>,
}

/// A signal in the drawing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Signal {
    /// Name of the signal.
    pub name: String,
    /// Type of the signal.
    pub ty: Type,
}

impl Boxed {
    /// Returns the title of the box.
    #[must_use]
    pub fn title(&self) -> String {
        let program = if self.program { " (program)" } else { "" };
        format!("{}{program}", self.name)
    }

    /// Returns the numbers of the threads that run its functions, without duplicates.
    #[must_use]
    pub fn threads(&self) -> BTreeSet<usize> {
        self.functs.iter().map(|(_, thread)| *thread).collect()
    }

    /// Returns all pins, inputs and outputs.
    pub fn pins(&self) -> impl Iterator<Item = &Pin> {
        self.sections.iter().flat_map(|s| s.left.iter().chain(&s.right))
    }
}

impl Drawing {
    /// Requests the graph and sorts it into boxes.
    ///
    /// # Errors
    /// The engine refuses a request.
    pub fn of(
        title: &str,
        wanted: &Wanted,
        ask: &mut dyn FnMut(Request) -> Result<Reply, Error>,
    ) -> Result<Self, Error> {
        let mut list = |kind| ask(Request::List { kind, patterns: Vec::new(), ty: None });
        let Reply::Components(components) = list(Kind::Components)? else {
            return Err(Error::Unexpected);
        };
        let Reply::Items(pins) = list(Kind::Pins)? else { return Err(Error::Unexpected) };
        let Reply::Functs(functs) = list(Kind::Functs)? else { return Err(Error::Unexpected) };
        let Reply::Threads(threads) = list(Kind::Threads)? else { return Err(Error::Unexpected) };
        let params = match wanted.params.then(|| list(Kind::Params)).transpose()? {
            Some(Reply::Items(params)) => params,
            _ => Vec::new(),
        };
        let mut threads: Vec<_> = threads
            .into_iter()
            .map(|t| (u64::try_from(t.period).unwrap_or(0), t.name, t.functs))
            .collect();
        threads.sort_by(|a, b| (a.0, &a.1).cmp(&(b.0, &b.1)));
        let runs: BTreeMap<String, usize> = threads
            .iter()
            .enumerate()
            .flat_map(|(i, (_, _, functs))| functs.iter().map(move |f| (f.clone(), i)))
            .collect();
        let mut sorting = Sorting { drawing: Self::default(), numbers: BTreeMap::new() };
        sorting.drawing.title = title.to_owned();
        sorting.drawing.threads =
            threads.into_iter().map(|(period, name, _)| Thread { name, period }).collect();
        refuse_idle_patterns(&pins, wanted)?;
        let shown = shown(&pins, wanted);
        for component in components.iter().rev() {
            sorting.component(component, &pins, &functs, &params, &runs, &shown, wanted);
        }
        Ok(sorting.drawing)
    }
}

/// Returns the names of the signals that are drawn.
fn shown(pins: &[ItemInfo], wanted: &Wanted) -> BTreeSet<String> {
    let p = Patterns::new(&wanted.patterns);
    pins.iter().filter(|pin| is_meant(&p, pin)).filter_map(|pin| pin.signal.clone()).collect()
}

/// Returns whether patterns match a pin, its component or its signal.
fn is_meant(patterns: &Patterns, pin: &ItemInfo) -> bool {
    let signal = pin.signal.as_deref().unwrap_or_default();
    [&pin.name, &pin.owner_name, signal].iter().any(|name| patterns.matches(name))
}

/// Refuses a pattern that draws nothing.
fn refuse_idle_patterns(pins: &[ItemInfo], wanted: &Wanted) -> Result<(), Error> {
    for pattern in &wanted.patterns {
        let p = Patterns::new(core::slice::from_ref(pattern));
        let mut meant = pins.iter().filter(|pin| is_meant(&p, pin)).peekable();
        let why = if meant.peek().is_none() {
            "no pin, signal or component has such a name"
        } else if !wanted.all && meant.all(|pin| pin.signal.is_none()) {
            "its pins have no signals; --all draws them"
        } else {
            continue;
        };
        return Err(Error::OptionValue {
            program: "graph",
            option: "the pattern".into(),
            value: pattern.as_str().into(),
            why: why.into(),
        });
    }
    Ok(())
}

struct Sorting {
    drawing: Drawing,
    numbers: BTreeMap<String, usize>,
}

impl Sorting {
    #[expect(clippy::too_many_arguments, reason = "each is one of the lists that were asked for")]
    fn component(
        &mut self,
        component: &ComponentInfo,
        pins: &[ItemInfo],
        functs: &[FunctInfo],
        params: &[ItemInfo],
        runs: &BTreeMap<String, usize>,
        shown: &BTreeSet<String>,
        wanted: &Wanted,
    ) {
        let p = Patterns::new(&wanted.patterns);
        let own = |item: &&ItemInfo| item.owner_name == component.name;
        let is_drawn = |pin: &&ItemInfo| match &pin.signal {
            Some(signal) => shown.contains(signal),
            None => wanted.all && !is_time(&pin.name) && p.matches(&pin.name),
        };
        let names: Vec<&str> = functs
            .iter()
            .filter(|f| f.owner_name == component.name)
            .map(|f| f.name.as_str())
            .collect();
        // If functions have the names of the instances they belong to, each instance has its own
        // box.
        let place = |name: &str| -> String {
            let begins = |f: &&&str| name.strip_prefix(**f).is_some_and(|r| r.starts_with('.'));
            let funct = names.iter().filter(begins).max_by_key(|f| f.len());
            funct.map_or_else(|| component.name.clone(), |f| (*f).to_owned())
        };
        let mut boxes: BTreeMap<Natural, Boxed> = BTreeMap::new();
        let new = |name: &str| Boxed {
            name: name.to_owned(),
            program: !component.realtime,
            ..Boxed::default()
        };
        for pin in pins.iter().filter(own).filter(is_drawn) {
            let name = place(&pin.name);
            let boxed = boxes.entry(Natural::of(&name)).or_insert_with(|| new(&name));
            let signal = pin.signal.as_ref().map(|name| self.signal(name, pin.value.ty()));
            boxed.add(pin, signal);
        }
        for param in params.iter().filter(own).filter(|p| !is_time(&p.name)) {
            let name = place(&param.name);
            let label = rest(&param.name, &name).to_owned();
            if wanted.all && p.matches(&param.name) {
                boxes.entry(Natural::of(&name)).or_insert_with(|| new(&name));
            }
            if let Some(boxed) = boxes.get_mut(&Natural::of(&name)) {
                boxed.params.push((label, param.value.to_string()));
            }
        }
        for (funct, thread) in names.iter().filter_map(|f| Some((*f, *runs.get(*f)?))) {
            // A function without a box of its own belongs to the component's box.
            let own = boxes.contains_key(&Natural::of(funct));
            let name = if own { funct } else { component.name.as_str() };
            if let Some(boxed) = boxes.get_mut(&Natural::of(name)) {
                boxed.functs.push((funct.to_owned(), thread));
            }
        }
        self.drawing.boxes.extend(boxes.into_values());
    }

    fn signal(&mut self, name: &str, ty: Type) -> usize {
        let next = self.drawing.signals.len();
        let number = *self.numbers.entry(name.to_owned()).or_insert(next);
        if number == next {
            self.drawing.signals.push(Signal { name: name.to_owned(), ty });
        }
        number
    }
}

impl Boxed {
    fn add(&mut self, pin: &ItemInfo, signal: Option<usize>) {
        let prefix = pin.name.rsplit_once('.').map_or("", |(prefix, _)| prefix);
        let heading = if prefix == self.name { "" } else { prefix };
        let at = self.sections.iter().position(|s| s.name == heading).unwrap_or_else(|| {
            self.sections.push(Section { name: heading.to_owned(), ..Section::default() });
            self.sections.sort_by_cached_key(|s| Natural::of(&s.name));
            self.sections.iter().position(|s| s.name == heading).unwrap_or(0)
        });
        let Some(section) = self.sections.get_mut(at) else { return };
        let made = Pin {
            label: rest(&pin.name, prefix).to_owned(),
            name: pin.name.clone(),
            direction: pin.direction,
            ty: pin.value.ty(),
            signal,
        };
        let side =
            if pin.direction == Direction::In { &mut section.left } else { &mut section.right };
        side.push(made);
    }
}

/// Returns the rest of a name after a prefix and a dot, or the whole name.
fn rest<'a>(name: &'a str, prefix: &str) -> &'a str {
    name.strip_prefix(prefix).and_then(|r| r.strip_prefix('.')).unwrap_or(name)
}

/// Returns whether this is one of the timing pins or parameters that every function and thread has.
fn is_time(name: &str) -> bool {
    [".time", ".tmax", ".tmax-increased", ".threadbeat"].iter().any(|t| name.ends_with(t))
}

/// A name with a sort order in which 2 comes before 10.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Natural(Vec<(u128, String)>, String);

impl Natural {
    fn of(name: &str) -> Self {
        let parts = name.split('.').map(|part| {
            let digits = part.len() < 30 && part.bytes().all(|b| b.is_ascii_digit());
            let number = part.parse().ok().filter(|_| digits);
            number.map_or((u128::MAX, part.to_owned()), |n| (n, String::new()))
        });
        Self(parts.collect(), name.to_owned())
    }
}
