//! What is told of one component to the properties: `tests/properties/NAME.toml`, read and checked.

use crate::{
    every,
    judge::case::{self as judge, Input, named},
    programs::root,
};
use hal_protocol::Offer;
use serde::Deserialize;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// The folder of these files.
pub fn folder() -> PathBuf {
    root().join("tests/properties")
}

/// One file. What is left out is as written in `tests/tests/properties.rs`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Case {
    /// The component whose file it is as well.
    pub like: Option<String>,
    /// Arguments of `loadrt`, each a configuration of its own, beside those of the judge
    /// and of `every`.
    pub loads: Vec<String>,
    /// Lines of a script before it is loaded.
    pub before: Vec<String>,
    /// Lines of a script after it is loaded.
    pub after: Vec<String>,
    /// Threads that these lines make, in which its functions then are.
    pub threads: Vec<String>,
    /// What sane inputs are.
    pub inputs: Vec<Input>,
    /// Outputs with a documented limit.
    pub bounds: Vec<Bound>,
    /// Outputs that may be no finite numbers while all inputs are.
    pub open: Vec<Open>,
    /// Outputs that stay no finite numbers when the inputs are again.
    pub stays: Vec<Stays>,
    /// Arguments that look wrong and are taken; see `tests/tests/arguments.rs`.
    pub takes: Vec<Takes>,
}

/// An output within limits. `#` in the names stands for the same text.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// The output.
    pub pin: String,
    /// No less than the product of these: numbers, and names of items.
    #[serde(default)]
    pub low: Vec<String>,
    /// No more than the product of these; without `low`, no less than that with the other sign.
    #[serde(default)]
    pub high: Vec<String>,
    /// No faster than this, in units per second; what is named is set once.
    pub rate: Option<String>,
    /// There is no limit while this item is 0.
    pub unless: Option<String>,
    /// There is no limit from where on this item is true.
    pub off: Option<String>,
}

/// Outputs that may be no finite numbers while all inputs are.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Open {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
}

/// Outputs that keep what was no number, until a reset.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stays {
    /// Names, or globs.
    pub pins: Vec<String>,
    /// Why.
    pub why: String,
    /// What clears it, one after the other: inputs, as globs, and what they are set to. Empty: only
    /// a new load does.
    pub reset: Vec<BTreeMap<String, String>>,
}

/// Arguments that look wrong and are taken.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Takes {
    /// Such as `num_chan=0`.
    pub words: Vec<String>,
    /// Why.
    pub why: String,
}

impl Case {
    /// The one of a component, or of its library; nothing is told of most.
    ///
    /// # Errors
    /// It cannot be read, or is wrong.
    pub fn of(offer: &Offer) -> Result<Self, String> {
        let file = |name: &str| folder().join(format!("{name}.toml"));
        let names = [offer.component.clone(), format!("lib-{}", offer.library)];
        let Some(name) = names.into_iter().find(|n| file(n).is_file()) else {
            return Ok(Self::default());
        };
        let wrong = |e| format!("tests/properties/{name}.toml: {e}");
        let case: Self = read(&file(&name)).map_err(wrong)?;
        match &case.like {
            Some(like) => read(&file(like)).map_err(wrong),
            None => Ok(case),
        }
    }

    /// The arguments of `loadrt` that are tried, the judge's among them.
    ///
    /// # Errors
    /// A file of the judge is wrong.
    pub fn ways(&self, offer: &Offer) -> Result<Vec<String>, String> {
        let judged = judge::Case::of(&offer.component)?.loads;
        let others = every::ways(&offer.component).iter().map(|w| (*w).to_owned()).collect();
        let mut ways = Vec::new();
        // Both take one without any for granted.
        let lists = [judged, others].into_iter().filter(|list: &Vec<String>| *list != [""]);
        for way in lists.flatten().chain(self.loads.iter().cloned()) {
            if !ways.contains(&way) {
                ways.push(way);
            }
        }
        if ways.is_empty() {
            ways.push(String::new());
        }
        Ok(ways)
    }

    /// The row of an output that may be no finite number.
    pub fn open(&self, name: &str) -> Option<&Open> {
        self.open.iter().find(|o| named(&o.pins, name))
    }

    /// The row of an output that keeps what was no number.
    pub fn stays(&self, name: &str) -> Option<&Stays> {
        self.stays.iter().find(|s| named(&s.pins, name))
    }

    /// Whether a limit of how fast something changes rests on this item.
    pub fn is_rate(&self, name: &str) -> bool {
        let rates = self.bounds.iter().filter_map(|b| b.rate.as_deref());
        rates.into_iter().any(|r| filled(r, name).is_some())
    }
}

/// What `#` stands for, if this name is of that form.
pub fn filled<'n>(form: &str, name: &'n str) -> Option<&'n str> {
    let Some((before, after)) = form.split_once('#') else {
        return (form == name).then_some("");
    };
    name.strip_prefix(before)?.strip_suffix(after)
}

fn read(path: &Path) -> Result<Case, String> {
    let text = std::fs::read_to_string(path).map_err(|e| e.to_string())?;
    toml::from_str(&text).map_err(|e| e.to_string())
}
