//! Pins of LinuxCNC's components, recorded in `tests/compat/pins/NAME.txt`, compared with the pins of ours.
//!
//! A file has a section for each version of LinuxCNC in which the component was measured: the arguments that it
//! accepts, and for each `loadrt` line its functions, and its pins and parameters with type, direction and first value.

use crate::{
    conformance::case::{Case, named},
    foreign::{Bench, installed},
    programs::root,
};
use hal_protocol::{Direction, Kind, Link, Offer, Reply, Request, Type, Value};
use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write,
    path::PathBuf,
};

/// Returns the folder of these files.
pub fn folder() -> PathBuf {
    root().join("tests/compat/pins")
}

/// Recorded version of a component.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Version {
    /// Version of LinuxCNC.
    pub name: String,
    /// Arguments that `loadrt` accepts.
    pub args: BTreeSet<String>,
    /// Result of each load.
    pub loads: Vec<Loaded>,
}

/// Result of one load.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Loaded {
    /// Arguments of the load.
    pub args: String,
    /// Names of the functions.
    pub functs: BTreeSet<String>,
    /// Pins and parameters, by name.
    pub items: BTreeMap<String, Item>,
}

/// A pin or parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Direction of the item.
    pub direction: Direction,
    /// First value, which also gives the type.
    pub first: Value,
}

/// Returns the names of all components that have a file.
pub fn names() -> Vec<String> {
    let files = std::fs::read_dir(folder()).unwrap().map(|f| f.unwrap().file_name());
    let name = |f: std::ffi::OsString| {
        let file = f.into_string().unwrap();
        file.strip_suffix(".txt").unwrap_or_else(|| panic!("{file} is not of a component")).into()
    };
    let mut names: Vec<String> = files.map(name).collect();
    names.sort();
    names
}

/// Returns the recorded versions of a LinuxCNC component, oldest first; empty if there is no record.
pub fn read(component: &str) -> Vec<Version> {
    match std::fs::read_to_string(folder().join(format!("{component}.txt"))) {
        Ok(text) => parse(&text),
        Err(_) => Vec::new(),
    }
}

/// Parses the text of such a file.
pub fn parse(text: &str) -> Vec<Version> {
    let mut all: Vec<Version> = Vec::new();
    for line in text.lines().filter(|l| !l.is_empty()) {
        let words: Vec<&str> = line.split(' ').collect();
        match (&*words, all.last_mut()) {
            (["LinuxCNC", name @ ..], _) => {
                all.push(Version { name: name.concat(), ..Version::default() });
            }
            (["arguments", names @ ..], Some(v)) => {
                v.args = names.iter().map(|n| (*n).to_owned()).collect();
            }
            (["loadrt", _, args @ ..], Some(v)) => {
                v.loads.push(Loaded { args: args.join(" "), ..Loaded::default() });
            }
            (["funct", name], Some(Version { loads, .. })) => {
                loads.last_mut().unwrap().functs.insert((*name).to_owned());
            }
            ([ty, direction, first, name], Some(Version { loads, .. })) => {
                let item = item(ty, direction, first).unwrap_or_else(|| panic!("{line}"));
                loads.last_mut().unwrap().items.insert((*name).to_owned(), item);
            }
            _ => panic!("{line}: what is this?"),
        }
    }
    all
}

fn item(ty: &str, direction: &str, first: &str) -> Option<Item> {
    let all = [Direction::In, Direction::Out, Direction::Io, Direction::Ro, Direction::Rw];
    let first = match Type::parse(ty)? {
        // No text sets a port: its first value is a port without a buffer.
        Type::Port => Value::Port(0),
        ty => Value::parse(ty, first).ok()?,
    };
    Some(Item { direction: all.into_iter().find(|d| d.name() == direction)?, first })
}

/// Returns a version as it is written to its file.
pub fn written(component: &str, version: &Version) -> String {
    let args: Vec<&str> = version.args.iter().map(String::as_str).collect();
    let mut out = format!("LinuxCNC {}\n", version.name);
    out.push_str(format!("arguments {}", args.join(" ")).trim_end());
    for load in &version.loads {
        write!(out, "\n\nloadrt {component} {}", load.args).unwrap();
        out.truncate(out.trim_end().len());
        for funct in &load.functs {
            write!(out, "\nfunct {funct}").unwrap();
        }
        for (name, i) in &load.items {
            let (ty, direction) = (i.first.ty().name(), i.direction.name());
            write!(out, "\n{ty} {direction} {} {name}", exact(i.first)).unwrap();
        }
    }
    out.push('\n');
    out
}

/// Returns a value with all its digits.
fn exact(value: Value) -> String {
    match value {
        Value::Float(f) => format!("{f:?}"),
        other => other.to_string(),
    }
}

/// Returns the argument lists with which LinuxCNC's component of the package is measured: those for the judge, those
/// that only concern its pins, and names given with `names=`.
///
/// # Errors
/// The description of the component is wrong.
pub fn lines(component: &str, args: &BTreeSet<String>) -> Result<Vec<String>, String> {
    let case = Case::of(component)?;
    let mut lines: Vec<String> = case.loads.iter().chain(&case.shapes).cloned().collect();
    if args.contains("names") && lines.iter().any(String::is_empty) {
        lines.push("names=one,two".to_owned());
    }
    Ok(lines)
}

/// Loads LinuxCNC's component once and returns the result.
///
/// # Errors
/// The component cannot be loaded, or its description is wrong.
pub fn measured(component: &str, args: &str) -> Result<Loaded, String> {
    let folder = installed().unwrap();
    let mut bench = Bench::new(&[&folder]);
    for module in &Case::of(component)?.before {
        bench.load_c("", module)?;
    }
    bench.load_c("", &format!("{component} {args}"))?;
    let mut load = loaded(&mut bench, component, args.to_owned());
    for item in load.items.values_mut() {
        // Uninitialized memory, different at each load: pentakins reads beyond its table.
        if matches!(item.first, Value::Float(f) if f.is_subnormal()) {
            item.first = Value::Float(0.0);
        }
    }
    Ok(load)
}

fn loaded(bench: &mut Bench, component: &str, args: String) -> Loaded {
    let mut items = bench.items(Kind::Pins, "");
    items.extend(bench.items(Kind::Params, ""));
    let mine = items.into_iter().filter(|i| i.owner_name == component);
    Loaded {
        args,
        functs: bench.functs(component).into_iter().map(|f| f.name).collect(),
        items: mine.map(|i| (i.name, Item { direction: i.direction, first: i.value })).collect(),
    }
}

/// Comparison of our component with LinuxCNC's.
#[derive(Debug, Default)]
pub struct Beside {
    /// Versions that were compared.
    pub versions: Vec<String>,
    /// Number of loads that were compared.
    pub loads: usize,
    /// Pins and parameters of the first instance that both have.
    pub compared: BTreeSet<String>,
    /// Items of the first instance that differ in a known way, with the reason.
    pub known: BTreeMap<String, String>,
    /// Unknown differences, and known differences that no longer hold.
    pub faults: Vec<String>,
}

/// Loads our component with the arguments of every LinuxCNC version, and compares the results.
///
/// # Errors
/// Our component cannot be loaded, or its description is wrong.
pub fn beside(offer: &Offer) -> Result<Beside, String> {
    let name = &offer.component;
    let case = Case::of(name)?;
    let mut out = Beside::default();
    let mut used = BTreeSet::new();
    for version in read(name) {
        let more: Vec<&String> =
            version.args.iter().filter(|a| offer.args.iter().all(|o| o.name != **a)).collect();
        if !more.is_empty() {
            out.faults.push(format!("it does not take {more:?}, which LinuxCNC's does"));
        }
        for theirs in &version.loads {
            let mut bench = Bench::new(&[]);
            for module in &case.before {
                // A separate module in LinuxCNC may be part of another one here.
                drop(load(&mut bench, module));
            }
            let line = format!("{name} {}", theirs.args);
            load(&mut bench, &line).map_err(|e| format!("loadrt {line}: {e}"))?;
            let ours = loaded(&mut bench, name, theirs.args.clone());
            bench.engine.close();
            let both = Both { ours: &ours, theirs, case: &case, exact: version.name == "2.9" };
            let mut found = Beside::default();
            both.compare(&mut found, &mut used);
            out.faults.append(&mut found.faults);
            if out.loads == 0 {
                (out.compared, out.known) = (found.compared, found.known);
            }
            out.loads += 1;
        }
        out.versions.push(version.name);
    }
    if !out.versions.is_empty() {
        let told = case.only.iter().chain(&case.kinds).map(|o| (&o.pins, &o.why));
        for (pins, why) in told.chain(case.defaults.iter().map(|d| (&d.pins, &d.why))) {
            if !used.contains(pins) {
                out.faults.push(format!("{pins:?} do not differ in this way: {why}"));
            }
        }
    }
    Ok(out)
}

fn load(bench: &mut Bench, line: &str) -> Result<Reply, String> {
    let mut words = line.split(' ').filter(|w| !w.is_empty()).map(str::to_owned);
    let module = words.next().unwrap();
    bench.call(Request::Load { module, args: words.collect() }).map_err(|e| e.to_string())
}

/// The same load on both sides.
struct Both<'a> {
    ours: &'a Loaded,
    theirs: &'a Loaded,
    case: &'a Case,
    /// True if first values are recorded with all their digits, not with six.
    exact: bool,
}

impl Both<'_> {
    fn compare(&self, out: &mut Beside, used: &mut BTreeSet<Vec<String>>) {
        let (ours, theirs, case) = (self.ours, self.theirs, self.case);
        let line = &theirs.args;
        if ours.functs != theirs.functs {
            let said = format!("functions {:?}, theirs {:?}", ours.functs, theirs.functs);
            out.faults.push(format!("`{line}`: {said}"));
        }
        let all: BTreeSet<&String> = ours.items.keys().chain(theirs.items.keys()).collect();
        for name in all {
            let (our, their) = match (ours.items.get(name), theirs.items.get(name)) {
                (Some(our), Some(their)) => (our, their),
                (our, _) => {
                    let only = case.only.iter().find(|o| named(&o.pins, name));
                    let side = if our.is_some() { "ours" } else { "theirs" };
                    match only {
                        Some(only) => {
                            used.insert(only.pins.clone());
                            out.known.insert(name.clone(), only.why.clone());
                        }
                        None => out.faults.push(format!("`{line}`: only {side} has {name}")),
                    }
                    continue;
                }
            };
            out.compared.insert(name.clone());
            if (our.direction, our.first.ty()) != (their.direction, their.first.ty()) {
                let kind = case.kinds.iter().find(|k| named(&k.pins, name));
                match kind.filter(|_| our.first.ty() == their.first.ty()) {
                    Some(kind) => {
                        used.insert(kind.pins.clone());
                        out.known.insert(name.clone(), kind.why.clone());
                    }
                    None => out.faults.push(format!(
                        "`{line}`: {name} is {} {}, theirs {} {}",
                        our.first.ty().name(),
                        our.direction.name(),
                        their.first.ty().name(),
                        their.direction.name()
                    )),
                }
            } else if !self.same(our.first, their.first) {
                let (our, their) = (exact(our.first), exact(their.first));
                let known = case.defaults.iter().find(|d| named(&d.pins, name));
                match known.filter(|d| (&d.ours, &d.theirs) == (&our, &their)) {
                    Some(known) => {
                        used.insert(known.pins.clone());
                        out.known.insert(name.clone(), known.why.clone());
                    }
                    None => out
                        .faults
                        .push(format!("`{line}`: {name} begins with {our}, theirs with {their}")),
                }
            }
        }
    }

    fn same(&self, ours: Value, theirs: Value) -> bool {
        match (ours, theirs) {
            (Value::Float(a), Value::Float(b)) if !self.exact => (a - b).abs() <= 5e-6 * b.abs(),
            _ => ours == theirs,
        }
    }
}
