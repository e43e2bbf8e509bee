//! Remedies for refused lines from the other lines of the scripts, and one finding for lines that one cause refuses.

use crate::{
    language::hint::nearest,
    language::table,
    session::dry_run::{DryRun, MOTION},
};
use hal_protocol::{At, Code, Finding, Kind, Link, Related, Reply, Request};
use std::{collections::BTreeMap, path::Path};

/// Beginnings of names, and the components that make them under another name than their own.
const OTHERWISE: [(&str, &str); 4] = [
    ("ini", "inihal"),
    ("parport", "hal_parport"),
    ("speaker", "hal_speaker"),
    ("viagpio", "hal_viagpio"),
];

/// Lines of a machine, and the names that they make.
struct Lines {
    statements: Vec<(At, Vec<String>)>,
    /// Names of pins, parameters and functions, with the signal that a pin has.
    names: BTreeMap<String, Option<String>>,
    functs: Vec<String>,
    threads: Vec<String>,
}

/// Adds remedies to findings about refused lines, and combines those with one cause.
pub(super) fn improve(findings: &mut Vec<Finding>, dry_run: &mut DryRun) {
    settings(findings, dry_run);
    entries(findings, dry_run);
    if findings.is_empty() {
        return;
    }
    let lines = Lines::of(dry_run);
    for finding in findings.iter_mut() {
        lines.advise(finding);
    }
    lines.combine(findings);
    // A line that was refused is not missing.
    let refused: Vec<At> = findings
        .iter()
        .filter(|f| matches!(f.code, Code::NoSuchName | Code::WrongWords))
        .flat_map(|f| f.at.clone().into_iter().chain(f.related.iter().map(|r| r.at.clone())))
        .collect();
    let tried = |funct: &str| {
        lines.statements.iter().any(|(at, words)| {
            words.first().is_some_and(|w| w == "addf")
                && words.get(1).is_some_and(|w| w == funct)
                && refused.contains(at)
        })
    };
    let absent = |f: &Finding| {
        matches!(f.code, Code::NeverAdded | Code::NothingHandedOver) && tried(&f.subject)
    };
    findings.retain(|f| !absent(f));
}

/// Relates a finding about an INI entry and a channel to the line that sets the channel.
fn settings(findings: &mut [Finding], dry_run: &DryRun) {
    for finding in findings {
        let last = match finding.code {
            Code::JointTooFast | Code::EntriesDisagree => "position-scale",
            Code::StepgenSlower => "maxaccel",
            _ => continue,
        };
        let mut words = finding.text.split([' ', '\'', ',']).filter(|w| w.contains('.'));
        let channel =
            words.find_map(|w| w.starts_with("stepgen.").then(|| w.trim_end_matches(".maxaccel")));
        let Some(channel) = channel else { continue };
        let pin = format!("{channel}.{last}");
        let statements = &dry_run.result().statements;
        let mut sets = statements.iter().filter(|(_, w)| {
            w.first().is_some_and(|w| w == "setp") && w.get(1).is_some_and(|w| *w == pin)
        });
        if let Some((at, _)) = sets.next() {
            relate(finding, at, format!("'{pin}' is set here"));
        }
    }
}

/// Relates a finding on a line that uses INI entries to those entries.
fn entries(findings: &mut [Finding], dry_run: &DryRun) {
    let Some(ini) = dry_run.ini() else { return };
    let used = &dry_run.result().uses;
    for finding in findings {
        let near = finding.at.iter().chain(finding.related.iter().map(|r| &r.at));
        let near: Vec<At> = near.cloned().collect();
        for (_, names) in used.iter().filter(|(at, _)| near.contains(at)) {
            for (section, name) in names {
                let Some(entry) = ini.all(section, name).next() else { continue };
                let at = At::new(&entry.file, entry.line);
                if finding.code == Code::WrongWords && entry.value.trim().is_empty() {
                    finding.remedy = format!("[{section}]{name} is empty: give it a value");
                }
                if finding.at.as_ref() != Some(&at) && finding.related.iter().all(|r| r.at != at) {
                    let text = format!("[{section}]{name} = {}", entry.value);
                    relate(finding, &at, text);
                }
            }
        }
    }
}

/// Returns the part of a name before its first dot.
fn first(name: &str) -> &str {
    name.split('.').next().unwrap_or_default()
}

/// Returns a name with each of its numbers replaced.
fn plain(name: &str) -> String {
    let part = |p: &str| if p.parse::<u32>().is_ok() { "#".to_owned() } else { p.to_owned() };
    name.split('.').map(part).collect::<Vec<_>>().join(".")
}

/// Adds a line that a finding involves.
fn relate(finding: &mut Finding, at: &At, text: String) {
    finding.related.push(Related { at: at.clone(), text });
}

/// Adds a remedy to those that the finding has.
fn add(finding: &mut Finding, text: &str) {
    if !finding.remedy.is_empty() {
        finding.remedy.push_str("; ");
    }
    finding.remedy.push_str(text);
}

impl Lines {
    fn of(dry_run: &mut DryRun) -> Self {
        let statements = dry_run.result().statements.clone();
        let list = |kind| Request::List { kind, patterns: Vec::new(), ty: None };
        let (mut names, mut all_functs) = (BTreeMap::new(), Vec::new());
        for kind in [Kind::Pins, Kind::Params] {
            names.extend(dry_run.items(kind).into_iter().map(|i| (i.name, i.signal)));
        }
        if let Ok(Reply::Functs(functs)) = dry_run.engine().call(list(Kind::Functs)) {
            all_functs.extend(functs.into_iter().map(|f| f.name));
        }
        names.extend(all_functs.iter().map(|f| (f.clone(), None)));
        let threads = match dry_run.engine().call(list(Kind::Threads)) {
            Ok(Reply::Threads(threads)) => threads.into_iter().map(|t| t.name).collect(),
            _ => Vec::new(),
        };
        Self { statements, names, functs: all_functs, threads }
    }

    /// Returns the words of the line at a position.
    fn words(&self, at: Option<&At>) -> &[String] {
        let line = self.statements.iter().find(|(place, _)| Some(place) == at);
        line.map_or(&[], |(_, words)| words)
    }

    /// Returns the lines that begin with this command.
    fn of_command<'a>(&'a self, command: &'a str) -> impl Iterator<Item = &'a (At, Vec<String>)> {
        self.statements.iter().filter(move |(_, w)| w.first().is_some_and(|w| w == command))
    }

    fn advise(&self, finding: &mut Finding) {
        let words = self.words(finding.at.as_ref());
        match finding.code {
            Code::NoSuchName => self.missing(finding),
            Code::WrongWords => {
                let row = words.first().and_then(|w| table::find(w));
                if let Some(row) = row {
                    add(finding, &format!("the command is: {} {}", row.name, row.usage));
                }
            }
            Code::BadValue | Code::MotionRefuses => {
                let comma = |w: &&String| {
                    w.split_once(',')
                        .is_some_and(|(a, b)| a.parse::<f64>().is_ok() && b.parse::<u64>().is_ok())
                };
                if let Some(word) = words.iter().find(comma) {
                    add(finding, &format!("with a decimal point: {}", word.replace(',', ".")));
                } else if finding.remedy.is_empty() && !finding.subject.is_empty() {
                    add(finding, &format!("correct {}", finding.subject));
                }
            }
            Code::NamedAsPin => {
                let pins = words.get(1..).unwrap_or_default().join(" ");
                add(finding, &format!("put a name before the pins: net SIGNAL {pins}"));
            }
            Code::AddedTwice => self.added_twice(finding),
            Code::LinkedTwice => {
                let kin = |(name, signal): &(&String, &Option<String>)| {
                    signal.is_none() && plain(name) == plain(&finding.subject)
                };
                let free: Vec<&str> =
                    self.names.iter().filter(kin).map(|(n, _)| n.as_str()).take(4).collect();
                if !free.is_empty() {
                    add(finding, &format!("not linked yet: {}", free.join(", ")));
                }
            }
            Code::NoHalfile | Code::NoPostgui | Code::NoFile => beside(finding),
            _ => {}
        }
    }

    /// Adds the line at which a function was added first.
    fn added_twice(&self, finding: &mut Finding) {
        let Some(funct) = self.words(finding.at.as_ref()).get(1).cloned() else { return };
        let mut all = self.of_command("addf").filter(|(_, w)| w.get(1) == Some(&funct));
        let Some((at, words)) = all.next().filter(|(at, _)| Some(at) != finding.at.as_ref()) else {
            return;
        };
        let thread = words.get(2).map_or("", String::as_str);
        add(finding, &format!("it is added to {thread} at {at}: take one of the two lines out"));
        relate(finding, at, format!("'{funct}' is added here"));
    }

    /// Adds the origin of a name that does not exist.
    fn missing(&self, finding: &mut Finding) {
        let name = finding.subject.clone();
        let head = first(&name);
        if finding.kind == Some(Kind::Threads) {
            if nearest(&name, self.threads.iter().map(String::as_str)).is_none() {
                if !self.threads.is_empty() {
                    add(finding, &format!("there are: {}", self.threads.join(", ")));
                }
                let make = if MOTION.contains(&head) {
                    "loadrt motmod makes it".to_owned()
                } else {
                    format!("loadrt threads name1={name} period1=NANOSECONDS makes it")
                };
                add(finding, &make);
            }
            return;
        }
        if finding.kind == Some(Kind::Signals) {
            return;
        }
        if self.names.contains_key(&name) {
            self.too_early(finding, head);
            return;
        }
        let kin: Vec<&str> = self
            .names
            .keys()
            .filter(|n| plain(n) == plain(&name))
            .map(String::as_str)
            .take(8)
            .collect();
        if !kin.is_empty() {
            add(finding, &format!("there are: {}", kin.join(", ")));
        }
        // The name of a component or an instance alone is no function's name.
        let below = format!("{name}.");
        let own = self
            .functs
            .iter()
            .filter(|f| finding.kind == Some(Kind::Functs) && f.starts_with(&below));
        let own: Vec<&str> = own.map(String::as_str).take(8).collect();
        if !own.is_empty() {
            add(finding, &format!("its functions are: {}", own.join(", ")));
            return;
        }
        if let Some((at, words)) = self.loads(&name, head) {
            let list = words.get(2).and_then(|w| w.split_once('='));
            let (line, key) = (words.join(" "), list.map_or("count", |(key, _)| key));
            let or = if finding.remedy.is_empty() { "" } else { "or " };
            add(finding, &format!("{or}one more in {key}= of '{line}' ({at})"));
            relate(finding, at, format!("{key}= is here"));
            return;
        }
        if !kin.is_empty() || self.is_known(head) {
            return;
        }
        let make = if MOTION.contains(&head) {
            "loadrt motmod makes it".to_owned()
        } else if let Some((_, module)) = OTHERWISE.iter().find(|(begin, _)| *begin == head) {
            format!("loadrt {module} makes it")
        } else {
            format!("loadrt {} makes it, or loadrt COMPONENT names={head}", head.replace('-', "_"))
        };
        add(finding, &make);
    }

    /// Returns whether a component has names that begin like this.
    fn is_known(&self, head: &str) -> bool {
        self.names.keys().any(|n| first(n) == head)
    }

    /// Returns the line that loads the module of a missing name: the one that lists its other
    /// channels or instances.
    fn loads(&self, name: &str, head: &str) -> Option<&(At, Vec<String>)> {
        let tail = name.strip_prefix(head).unwrap_or_default();
        let is_known = self.is_known(head);
        let lists_other = |words: &[String]| {
            let mut others = self.names.keys().filter_map(|n| n.strip_suffix(tail));
            !tail.is_empty() && others.any(|other| listed(words).any(|n| n == other))
        };
        self.of_command("loadrt").find(|(_, words)| {
            if is_known {
                return makes(words, head) || words.get(1).is_some_and(|module| module == head);
            }
            nearest(head, listed(words)).is_some() || lists_other(words)
        })
    }

    /// Adds that a later line makes the name.
    fn too_early(&self, finding: &mut Finding, head: &str) {
        let mut loads = self.of_command("loadrt").filter(|(at, words)| {
            let later = finding.at.as_ref().is_some_and(|f| f.file == at.file && f.line < at.line);
            later && (makes(words, head) || listed(words).any(|n| n == head))
        });
        let Some((at, words)) = loads.next() else { return };
        let module = words.get(1).map_or("", String::as_str);
        finding.remedy = format!("loadrt {module} makes it, at {at}: move that line up");
        relate(finding, at, "it is made here".to_owned());
    }

    /// Combines refused lines that need one missing component or thread, or that are too many: the first stays.
    fn combine(&self, findings: &mut Vec<Finding>) {
        let cause = |f: &Finding| -> Option<String> {
            if f.kind == Some(Kind::Components) {
                return Some("room for a component".to_owned());
            }
            if f.code != Code::NoSuchName {
                return None;
            }
            if f.kind == Some(Kind::Threads) {
                return Some(format!("thread '{}'", f.subject));
            }
            let head = first(&f.subject);
            let absent = f.kind != Some(Kind::Signals) && !self.is_known(head);
            absent.then(|| format!("'{head}'"))
        };
        let mut groups: BTreeMap<String, Vec<At>> = BTreeMap::new();
        for finding in findings.iter() {
            if let (Some(cause), Some(at)) = (cause(finding), &finding.at) {
                groups.entry(cause).or_default().push(at.clone());
            }
        }
        for places in groups.values_mut() {
            places.sort();
        }
        let mut told = Vec::new();
        findings.retain_mut(|finding| {
            let Some(cause) = cause(finding) else { return true };
            let Some(places) = groups.get(&cause) else { return true };
            if places.first() != finding.at.as_ref() {
                return false;
            }
            let more = places.len() - 1;
            if more > 0 && !told.contains(&cause) {
                let lines = if more == 1 { "line needs" } else { "lines need" };
                finding.text = format!("{}; {more} more {lines} {cause}", finding.text);
                told.push(cause);
            }
            true
        });
    }
}

/// Returns the names in the `names=` of a line.
fn listed(words: &[String]) -> impl Iterator<Item = &str> {
    words.iter().filter_map(|w| w.strip_prefix("names=")).flat_map(|list| list.split(','))
}

/// Returns whether the module that a line loads makes names that begin like this.
fn makes(words: &[String], head: &str) -> bool {
    let module = words.get(1).map_or("", String::as_str);
    let bare = module.strip_prefix("hal_").unwrap_or(module).replace('_', "-");
    bare == head || module == "motmod" && MOTION.contains(&head)
}

/// Adds the file that is probably meant: one with a similar name in the folder of the line.
fn beside(finding: &mut Finding) {
    let Some(at) = &finding.at else { return };
    let folder = Path::new(&at.file).parent().map(Path::to_path_buf).unwrap_or_default();
    let folder = if folder.as_os_str().is_empty() { ".".into() } else { folder };
    let Ok(files) = std::fs::read_dir(folder) else { return };
    let names: Vec<String> =
        files.flatten().take(1000).filter_map(|f| f.file_name().into_string().ok()).collect();
    let near = nearest(&finding.subject, names.iter().map(String::as_str));
    if let Some(near) = near.filter(|near| **near != *finding.subject) {
        finding.remedy = format!("did you mean '{near}'? {}", finding.remedy);
    }
}
