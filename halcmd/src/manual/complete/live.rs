//! Words that only the instance knows: pins, signals, functions, and components to load.

use super::Candidate;
use hal_protocol::{
    ArgInfo, Direction, FunctInfo, ItemInfo, Kind, Link, Reply, Request, SignalInfo, ThreadInfo,
    Type, Value,
};
use std::collections::BTreeSet;

/// Lists items of an instance that begin with a word. Without an instance the lists are empty.
pub(super) struct Live<'a> {
    link: &'a mut dyn Link,
    word: &'a str,
}

/// Properties of a signal's pins that decide which further pin may join.
#[derive(Default)]
struct Ends {
    ty: Option<Type>,
    out: bool,
    io: bool,
    read: bool,
}

impl Ends {
    fn of(signal: &SignalInfo) -> Self {
        let mut ends = Self { ty: Some(signal.value.ty()), ..Self::default() };
        signal.pins.iter().for_each(|(direction, _)| ends.join(*direction));
        ends
    }

    fn join(&mut self, direction: Direction) {
        self.out |= direction == Direction::Out;
        self.io |= direction == Direction::Io;
        self.read |= direction != Direction::Out;
    }

    /// Returns whether a pin of this type and direction may join, by the engine's rules.
    fn take(&self, ty: Type, direction: Direction) -> bool {
        let port = ty == Type::Port;
        self.ty.is_none_or(|own| own == ty)
            && match direction {
                Direction::Out => !self.out && !self.io,
                Direction::Io => !self.out && !port,
                _ => !(port && self.read),
            }
    }
}

impl<'a> Live<'a> {
    pub(super) fn new(link: &'a mut dyn Link, word: &'a str) -> Self {
        Self { link, word }
    }

    fn list(&mut self, kind: Kind, pattern: &str) -> Reply {
        let request = Request::List { kind, patterns: vec![pattern.to_owned()], ty: None };
        self.link.call(request).unwrap_or(Reply::Done)
    }

    /// Lists items that begin with the word.
    fn begun(&mut self, kind: Kind) -> Reply {
        let word = self.word.to_owned();
        self.list(kind, &word)
    }

    pub(super) fn pins(&mut self, fits: impl Fn(&ItemInfo) -> bool) -> Vec<Candidate> {
        items(self.begun(Kind::Pins), fits)
    }

    pub(super) fn params(&mut self) -> Vec<Candidate> {
        items(self.begun(Kind::Params), |_| true)
    }

    pub(super) fn items(&mut self) -> Vec<Candidate> {
        [self.pins(|_| true), self.params()].concat()
    }

    pub(super) fn settable_items(&mut self) -> Vec<Candidate> {
        let params = items(self.begun(Kind::Params), settable);
        [self.pins(settable), params].concat()
    }

    pub(super) fn is_settable(&mut self, name: &str) -> bool {
        [Kind::Pins, Kind::Params].iter().any(|kind| match self.list(*kind, name) {
            Reply::Items(list) => list.iter().any(|item| is(item, name) && settable(item)),
            _ => false,
        })
    }

    pub(super) fn signals(&mut self, fits: impl Fn(&SignalInfo) -> bool) -> Vec<Candidate> {
        let Reply::Signals(list) = self.begun(Kind::Signals) else { return Vec::new() };
        let about = |s: &SignalInfo| format!("{} {}", s.value.ty().name(), s.value);
        list.iter().filter(|s| fits(s)).map(|s| Candidate::new(s.name.clone(), about(s))).collect()
    }

    pub(super) fn settable_signals(&mut self) -> Vec<Candidate> {
        self.signals(|signal| !Ends::of(signal).out)
    }

    /// Returns the pins that may join a signal together with `others`, which are on the same line.
    pub(super) fn pins_for(&mut self, signal: &str, others: &[String]) -> Vec<Candidate> {
        let found = match self.list(Kind::Signals, signal) {
            Reply::Signals(list) => list.into_iter().find(|s| s.name == signal),
            _ => None,
        };
        let mut ends = found.as_ref().map(Ends::of).unwrap_or_default();
        for other in others {
            if let Some(pin) = self.pin(other)
                && pin.signal.as_deref() != Some(signal)
            {
                ends.ty = ends.ty.or_else(|| Some(pin.value.ty()));
                ends.join(pin.direction);
            }
        }
        self.pins(|pin| {
            pin.signal.is_none()
                && ends.take(pin.value.ty(), pin.direction)
                && !others.iter().any(|other| is(pin, other))
        })
    }

    pub(super) fn signals_for(&mut self, pin: &str) -> Vec<Candidate> {
        let Some(pin) = self.pin(pin) else { return Vec::new() };
        self.signals(|signal| Ends::of(signal).take(pin.value.ty(), pin.direction))
    }

    fn pin(&mut self, name: &str) -> Option<ItemInfo> {
        match self.list(Kind::Pins, name) {
            Reply::Items(list) => list.into_iter().find(|pin| is(pin, name)),
            _ => None,
        }
    }

    /// Returns values for an item or signal: both values of a bit, or the present value of another
    /// type.
    pub(super) fn values(&mut self, name: &str, signal: bool) -> Vec<Candidate> {
        let name = name.to_owned();
        let request = if signal { Request::GetSignal { name } } else { Request::Get { name } };
        match self.link.call(request) {
            Ok(Reply::Value(Value::Bit(_))) => bits(""),
            Ok(Reply::Value(value)) if value.ty() != Type::Port => {
                vec![Candidate::new(value.to_string(), "its present value")]
            }
            _ => Vec::new(),
        }
    }

    pub(super) fn functs(&mut self, fits: impl Fn(&FunctInfo) -> bool) -> Vec<Candidate> {
        let Reply::Functs(list) = self.begun(Kind::Functs) else { return Vec::new() };
        let about = |f: &FunctInfo| format!("of {}", f.owner_name);
        list.iter().filter(|f| fits(f)).map(|f| Candidate::new(f.name.clone(), about(f))).collect()
    }

    pub(super) fn threads(&mut self, fits: impl Fn(&ThreadInfo) -> bool) -> Vec<Candidate> {
        let Reply::Threads(list) = self.begun(Kind::Threads) else { return Vec::new() };
        let about = |t: &ThreadInfo| format!("every {} ns", t.period);
        list.iter().filter(|t| fits(t)).map(|t| Candidate::new(t.name.clone(), about(t))).collect()
    }

    /// Returns components of plugins or of programs, without those that users do not unload by
    /// name.
    pub(super) fn components(&mut self, realtime: bool) -> Vec<Candidate> {
        let Reply::Components(list) = self.begun(Kind::Components) else { return Vec::new() };
        let own = |name: &str| name.starts_with("__") || name.starts_with("halcmd");
        let of_kind = list.into_iter().filter(|c| c.realtime == realtime && !own(&c.name));
        of_kind.map(|c| Candidate::new(c.name, c.args.unwrap_or_default())).collect()
    }

    pub(super) fn aliases(&mut self, param: bool) -> Vec<Candidate> {
        let kind = if param { Kind::ParamAliases } else { Kind::PinAliases };
        let Reply::Aliases(list) = self.begun(kind) else { return Vec::new() };
        list.into_iter().map(|a| Candidate::new(a.alias, a.original)).collect()
    }

    /// Returns items of a kind of `show` or `list`; after `all`, items of all kinds.
    pub(super) fn of_kind(&mut self, kind: &str) -> Vec<Candidate> {
        let kinds = crate::language::table::KINDS;
        match kind {
            "all" => [self.items(), self.signals(|_| true)].concat(),
            "alias" => [self.aliases(false), self.aliases(true)].concat(),
            _ => match kinds.iter().find(|(name, _)| *name == kind).map(|(_, kind)| *kind) {
                Some(Kind::Components) => [self.components(true), self.components(false)].concat(),
                Some(Kind::Pins) => self.pins(|_| true),
                Some(Kind::Params) => self.params(),
                Some(Kind::Signals) => self.signals(|_| true),
                Some(Kind::Functs) => self.functs(|_| true),
                Some(Kind::Threads) => self.threads(|_| true),
                Some(Kind::Workers) => match self.begun(Kind::Workers) {
                    Reply::Workers(list) => list
                        .into_iter()
                        .map(|w| Candidate::new(w.name, first_line(&w.doc)))
                        .collect(),
                    _ => Vec::new(),
                },
                Some(Kind::Snapshots) => match self.begun(Kind::Snapshots) {
                    Reply::Snapshots(list) => list
                        .into_iter()
                        .map(|s| Candidate::new(s.name, first_line(&s.doc)))
                        .collect(),
                    _ => Vec::new(),
                },
                _ => Vec::new(),
            },
        }
    }

    pub(super) fn modules(&mut self) -> Vec<Candidate> {
        let loaded: BTreeSet<String> = match self.list(Kind::Components, "") {
            Reply::Components(list) => list.into_iter().map(|c| c.name).collect(),
            _ => BTreeSet::new(),
        };
        let Reply::Offers(list) = self.begun(Kind::Offers) else { return Vec::new() };
        let free = list.into_iter().filter(|offer| !loaded.contains(&offer.component));
        free.map(|o| Candidate::new(o.component, first_line(&o.doc))).collect()
    }

    /// Returns the arguments of a component type that are not on the line yet.
    pub(super) fn module_args(&mut self, module: &str, given: &[String]) -> Vec<Candidate> {
        let Reply::Offers(list) = self.list(Kind::Offers, module) else { return Vec::new() };
        let Some(offer) = list.into_iter().find(|o| o.component == module) else {
            return Vec::new();
        };
        let instances = ["count=", "names="];
        let counted = instances.iter().any(|n| given.iter().any(|g| g.starts_with(n)));
        let alone =
            |a: &&ArgInfo| !(counted && instances.contains(&format!("{}=", a.name).as_str()));
        args(offer.args.iter().filter(alone), self.word, given)
    }

    pub(super) fn commands(&mut self) -> Vec<Candidate> {
        let Reply::Commands(list) = self.begun(Kind::Commands) else { return Vec::new() };
        list.into_iter().map(|c| Candidate::new(c.name, first_line(&c.doc))).collect()
    }

    /// Returns the arguments of a component's command that are not on the line yet.
    pub(super) fn command_args(&mut self, name: &str, given: &[String]) -> Vec<Candidate> {
        let Reply::Commands(list) = self.list(Kind::Commands, name) else { return Vec::new() };
        let Some(command) = list.into_iter().find(|c| c.name == name) else { return Vec::new() };
        let mut found = args(command.args.iter(), self.word, given);
        if !given.iter().any(|g| g == "--wait") {
            found.push(Candidate::new("--wait", "wait until the machine has done it"));
        }
        found
    }
}

/// Returns `NAME=` for each missing argument, or the values of the argument being typed.
fn args<'a>(
    declared: impl Iterator<Item = &'a ArgInfo>,
    word: &str,
    given: &[String],
) -> Vec<Candidate> {
    let mut found = Vec::new();
    for arg in declared {
        let name = format!("{}=", arg.name);
        if given.iter().any(|g| g.starts_with(&name)) {
            continue;
        }
        if word.starts_with(&name) {
            if arg.ty == "bit" {
                found.extend(bits(&name));
            }
            continue;
        }
        let default = arg.default.as_ref().map(|d| format!(" [{d}]")).unwrap_or_default();
        let range = arg.range();
        let range = if range.is_empty() { range } else { format!(" ({range})") };
        found.push(Candidate::new(name, format!("{}{range}{default}", first_line(&arg.doc))));
    }
    found
}

fn bits(before: &str) -> Vec<Candidate> {
    ["TRUE", "FALSE"].iter().map(|bit| Candidate::new(format!("{before}{bit}"), "")).collect()
}

fn items(reply: Reply, fits: impl Fn(&ItemInfo) -> bool) -> Vec<Candidate> {
    let Reply::Items(list) = reply else { return Vec::new() };
    let about = |i: &ItemInfo| {
        let (ty, direction) = (i.value.ty().name(), i.direction.name());
        format!("{ty} {direction}: {}", first_line(&i.doc)).trim_end_matches([':', ' ']).to_owned()
    };
    list.iter().filter(|i| fits(i)).map(|i| Candidate::new(i.name.clone(), about(i))).collect()
}

/// Returns whether the item is listed under this name, or has it as the name behind an alias.
fn is(item: &ItemInfo, name: &str) -> bool {
    item.name == name || item.original.as_deref() == Some(name)
}

/// Returns whether `setp` can set the item.
fn settable(item: &ItemInfo) -> bool {
    let direction = matches!(item.direction, Direction::In | Direction::Io | Direction::Rw);
    direction && item.signal.is_none() && item.value.ty() != Type::Port
}

pub(super) fn first_line(doc: &str) -> String {
    doc.lines().next().unwrap_or_default().to_owned()
}

/// Returns the programs beside this one and in PATH.
pub(super) fn programs() -> Vec<Candidate> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let beside = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.to_owned()));
    let mut found = BTreeSet::new();
    for folder in beside.into_iter().chain(std::env::split_paths(&path)) {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            if let (Ok(name), true) = (entry.file_name().into_string(), runs(&entry.path())) {
                found.insert(name);
            }
        }
    }
    found.into_iter().map(|name| Candidate::new(name, "")).collect()
}

fn runs(path: &std::path::Path) -> bool {
    rustix::fs::access(path, rustix::fs::Access::EXEC_OK).is_ok() && path.is_file()
}
