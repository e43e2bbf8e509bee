//! Arguments of `loadrt` and of commands: text, checked against the plugin's declarations.

use crate::{Error, name::Name};
use hal_abi::{ArgSpec, ArgValue, Str, arg, arg_bounds};
use hal_protocol::{ArgInfo, Bounds};
use std::collections::{BTreeMap, BTreeSet};

/// Declaration of one argument, copied from its plugin.
#[derive(Clone, Debug)]
pub(crate) struct Declared {
    pub(crate) name: Box<str>,
    pub(crate) doc: Box<str>,
    pub(crate) default: Option<Box<str>>,
    unit: Box<str>,
    /// The declaration itself. Its strings live only as long as the library.
    spec: ArgSpec,
}

impl Declared {
    /// Copies a declaration; returns `None` if its strings are invalid.
    pub(crate) fn copy(spec: &ArgSpec) -> Option<Self> {
        let text = |s: Str| {
            // SAFETY: a declaration's strings are static in its library, which is open.
            unsafe { s.get() }
        };
        let default = text(spec.default)?;
        Some(Self {
            name: text(spec.name)?.into(),
            doc: text(spec.doc)?.into(),
            default: (!default.is_empty()).then(|| default.into()),
            unit: text(spec.unit)?.into(),
            spec: *spec,
        })
    }

    /// Returns the description, with the range of a number.
    pub(crate) fn about(&self) -> String {
        let (doc, range) = (self.doc.trim_end_matches('.'), self.info().range());
        if range.is_empty() { doc.to_owned() } else { format!("{doc} ({range})") }
    }

    /// Returns the range of a number.
    fn bounds(&self) -> Bounds {
        let has = |bit| self.spec.bounds & bit != 0;
        Bounds {
            low: has(arg_bounds::LOW).then_some(self.spec.low),
            high: has(arg_bounds::HIGH).then_some(self.spec.high),
            above: has(arg_bounds::ABOVE),
        }
    }

    /// Returns the name of the argument's type.
    pub(crate) const fn ty(&self) -> &'static str {
        match self.spec.kind {
            arg::INT => "int",
            arg::FLOAT => "float",
            arg::INTS => "ints",
            arg::TEXTS => "texts",
            arg::BIT => "bit",
            _ => "text",
        }
    }
}

impl Declared {
    /// Returns the declaration as clients see it.
    pub(crate) fn info(&self) -> ArgInfo {
        ArgInfo {
            name: self.name.to_string(),
            ty: self.ty().to_owned(),
            doc: self.doc.to_string(),
            required: self.spec.required != 0,
            default: self.default.as_ref().map(ToString::to_string),
            bounds: self.bounds(),
            unit: self.unit.to_string(),
        }
    }
}

#[derive(Clone, Debug)]
enum ArgumentValue {
    Int(i64),
    Float(f64),
    Text(Box<str>),
    Ints(Box<[i64]>),
    Texts(Box<[Box<str>]>),
}

/// Checked arguments.
#[derive(Debug, Default)]
pub(crate) struct Args {
    given: Vec<(Box<str>, ArgumentValue)>,
    /// The lists of strings as passed to the plugin, by index into `given`: made once for all
    /// instances.
    shown: BTreeMap<usize, Box<[Str]>>,
}

impl Args {
    /// Checks words of the form `NAME=VALUE`; every `"` is removed, as users expect. `also` holds
    /// the names of arguments that the caller has already read.
    pub(crate) fn parse(
        declared: &[Declared],
        also: &[&str],
        words: &[String],
    ) -> Result<Self, Error> {
        let mut given: Vec<(Box<str>, ArgumentValue)> = Vec::new();
        for word in words {
            let word = word.replace('"', "");
            let (name, value) = word
                .split_once('=')
                .ok_or_else(|| Error::InvalidParameter { word: word.as_str().into() })?;
            let Some(d) = declared.iter().find(|d| &*d.name == name) else {
                let all: Vec<&str> =
                    declared.iter().map(|d| &*d.name).chain(also.iter().copied()).collect();
                let near = crate::error::near::nearest(name, all.iter().copied());
                let takes: Vec<String> = all.iter().map(|name| format!("{name}=")).collect();
                let takes = takes.join(" ").into();
                return Err(Error::UnknownParameter { word: word.as_str().into(), near, takes });
            };
            let value = read(d, value, &word)?;
            given.retain(|(n, _)| **n != *d.name);
            given.push((d.name.clone(), value));
        }
        for d in declared {
            if given.iter().any(|(n, _)| *n == d.name) {
                continue;
            }
            if d.spec.required != 0 {
                return Err(Error::MissingArgument { name: d.name.clone(), doc: d.about().into() });
            }
            if let Some(default) = &d.default {
                given.push((d.name.clone(), read(d, default, default)?));
            }
        }
        Ok(Self { given, shown: BTreeMap::new() })
    }

    /// Notes that people elsewhere have given the command. No word of a client has this name, because no declaration has.
    pub(crate) fn come_from_afar(&mut self) {
        self.given.push((hal_abi::FROM_AFAR.into(), ArgumentValue::Int(1)));
    }

    /// Returns an argument in the form of the binary interface.
    pub(crate) fn get(&mut self, name: &str) -> ArgValue {
        let none = ArgValue { size: hal_abi::size::<ArgValue>(), ..ArgValue::NONE };
        let at = self.given.iter().position(|(n, _)| &**n == name);
        let Some((at, (_, given))) = at.and_then(|at| Some((at, self.given.get(at)?))) else {
            return none;
        };
        let mut value = ArgValue { given: 1, ..none };
        match given {
            ArgumentValue::Int(i) => {
                value.int = *i;
                value.float = *i as f64;
            }
            ArgumentValue::Float(f) => value.float = *f,
            ArgumentValue::Text(t) => value.text = Str::borrow(t),
            ArgumentValue::Ints(list) => (value.ints, value.len) = (list.as_ptr(), list.len()),
            ArgumentValue::Texts(list) => {
                let show = || list.iter().map(|t| Str::borrow(t)).collect();
                let shown = self.shown.entry(at).or_insert_with(show);
                (value.texts, value.len) = (shown.as_ptr(), shown.len());
            }
        }
        value
    }
}

fn read(d: &Declared, value: &str, word: &str) -> Result<ArgumentValue, Error> {
    // An empty list means the default.
    let value = match &d.default {
        Some(default) if value.is_empty() && d.spec.kind == arg::TEXTS => default,
        _ => value,
    };
    let invalid = |text: &str, expects: &'static str| Error::InvalidArgument {
        value: text.into(),
        word: word.into(),
        expects,
        doc: d.about().into(),
    };
    let legal = |text: &str, number: f64| {
        if d.spec.allows(number) {
            return Ok(());
        }
        Err(Error::ArgumentRange {
            value: text.into(),
            word: word.into(),
            expects: format!("expected {}", d.info().range()).into(),
            doc: d.doc.trim_end_matches('.').into(),
        })
    };
    let items = || -> Result<Vec<&str>, Error> {
        // An empty list means that the argument is not given.
        if value.is_empty() && &*d.name == "names" {
            return Ok(Vec::new());
        }
        if value.is_empty() && d.spec.kind == arg::TEXTS {
            return Err(invalid(value, "expected texts separated by commas"));
        }
        let items: Vec<&str> = value.split(',').collect();
        let most = d.spec.most;
        if most > 0 && items.len() > most as usize {
            return Err(Error::TooManyItems { name: d.name.clone(), most });
        }
        Ok(items)
    };
    Ok(match d.spec.kind {
        arg::INT => {
            let expects = "expected an integer such as 10 or 0x1f";
            let number = integer(value).ok_or_else(|| invalid(value, expects))?;
            legal(value, number as f64)?;
            ArgumentValue::Int(number)
        }
        arg::BIT => match hal_protocol::Value::parse(hal_protocol::Type::Bit, value) {
            Ok(v) => ArgumentValue::Int(i64::from(v.bits() != 0)),
            Err(_) => return Err(invalid(value, hal_protocol::Type::Bit.expects())),
        },
        arg::FLOAT => match hal_protocol::Value::parse(hal_protocol::Type::Float, value) {
            Ok(hal_protocol::Value::Float(f)) => {
                legal(value, f)?;
                ArgumentValue::Float(f)
            }
            _ => return Err(invalid(value, hal_protocol::Type::Float.expects())),
        },
        arg::INTS => {
            let mut list = Vec::new();
            for item in items()? {
                let expects = "expected integers separated by commas, such as 0,0,2";
                let number = integer(item).ok_or_else(|| invalid(item, expects))?;
                legal(item, number as f64)?;
                list.push(number);
            }
            ArgumentValue::Ints(list.into())
        }
        arg::TEXTS if d.name.starts_with("names") => {
            let names = items()?;
            distinct(names.iter().copied())?;
            ArgumentValue::Texts(names.into_iter().map(Into::into).collect())
        }
        arg::TEXTS => ArgumentValue::Texts(items()?.into_iter().map(Into::into).collect()),
        _ => ArgumentValue::Text(value.into()),
    })
}

/// Checks names of instances: each must be valid and must occur once.
fn distinct<'n>(names: impl Iterator<Item = &'n str>) -> Result<(), Error> {
    let (what, mut seen) = ("component instance", BTreeSet::new());
    for name in names {
        Name::parse(what, name)?;
        if !seen.insert(name) {
            return Err(Error::Duplicate { what, name: name.into() });
        }
    }
    Ok(())
}

/// Parses an integer in C's notation.
fn integer(text: &str) -> Option<i64> {
    match hal_protocol::Value::parse(hal_protocol::Type::S64, text) {
        Ok(hal_protocol::Value::S64(i)) => Some(i),
        _ => None,
    }
}

/// Limit on the number of instances: a larger number is a typing error that would take all memory.
const MAX_INSTANCES: u32 = 1_000_000;

/// Arguments of `loadrt` for components with instances, apart from the component's own arguments.
#[derive(Debug, Default)]
pub(crate) struct Instances {
    /// Number of instances.
    pub(crate) count: Option<u32>,
    /// Names of the instances.
    pub(crate) names: Vec<String>,
    /// Personality number of each instance; zero for instances beyond the list.
    pub(crate) personality: Vec<i64>,
    /// All other words.
    pub(crate) rest: Vec<String>,
}

impl Instances {
    /// Splits the words of a `loadrt` line.
    pub(crate) fn parse(words: &[String], personality: bool) -> Result<Self, Error> {
        let mut out = Self::default();
        let invalid = |value: &str, word: &str, expects| Error::InvalidArgument {
            value: value.into(),
            word: word.into(),
            expects,
            doc: "".into(),
        };
        for word in words {
            let plain = word.replace('"', "");
            match plain.split_once('=') {
                Some(("count", n)) => {
                    let count = integer(n).and_then(|n| u32::try_from(n).ok());
                    let count = count.filter(|n| *n <= MAX_INSTANCES);
                    let expects = "expected a number from 0 to 1000000";
                    let count = count.ok_or_else(|| invalid(n, &plain, expects))?;
                    // Zero means one instance, as without the argument.
                    out.count = Some(count).filter(|n| *n > 0);
                }
                Some(("names", "")) => {}
                Some(("names", list)) => {
                    out.names = list.split(',').map(str::to_owned).collect();
                    distinct(list.split(','))?;
                }
                Some(("personality", list)) if personality => {
                    for item in list.split(',') {
                        let expects = "expected integers separated by commas, such as 0,0,2";
                        let number = integer(item);
                        out.personality.push(number.ok_or_else(|| invalid(item, &plain, expects))?);
                    }
                }
                _ => out.rest.push(word.clone()),
            }
        }
        if out.count.is_some() && !out.names.is_empty() {
            return Err(Error::CountAndNames);
        }
        Ok(out)
    }
}
