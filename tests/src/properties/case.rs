//! Description of one component for the properties test: `tests/properties/NAME.toml`, parsed and checked.

use crate::{
    conformance::case::{self as judge, Input, named},
    every,
    programs::root,
};
use hal_protocol::Offer;
use serde::Deserialize;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Returns the folder of these files.
pub fn folder() -> PathBuf {
    root().join("tests/properties")
}

/// Contents of a file. `tests/tests/system/components/properties.rs` documents the defaults of omitted entries.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Case {
    /// Other component whose file also applies.
    pub like: Option<String>,
    /// Arguments of `loadrt`, each a configuration of its own, in addition to those of the judge and of `every`.
    pub loads: Vec<String>,
    /// Lines of a script that run before the load.
    pub before: Vec<String>,
    /// Lines of a script that run after the load.
    pub after: Vec<String>,
    /// Threads that these lines create and that then hold the component's functions.
    pub threads: Vec<String>,
    /// Sane ranges of inputs.
    pub inputs: Vec<Input>,
    /// Outputs with a documented limit.
    pub bounds: Vec<Bound>,
    /// Outputs that may be NaN or infinite while all inputs are finite.
    pub open: Vec<Open>,
    /// Outputs that stay NaN or infinite after the inputs are finite again.
    pub stays: Vec<Stays>,
    /// Arguments that look wrong and are accepted; see `tests/tests/system/components/arguments.rs`.
    pub takes: Vec<Takes>,
}

/// An output within limits. `#` in the names stands for the same text everywhere.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// Name of the output.
    pub pin: String,
    /// Lower limit: the product of these numbers and items.
    #[serde(default)]
    pub low: Vec<String>,
    /// Upper limit: the product of these numbers and items; without `low`, its negative is the lower limit.
    #[serde(default)]
    pub high: Vec<String>,
    /// Maximum rate of change, in units per second; an item named here is set only once.
    pub rate: Option<String>,
    /// Item that disables the limit while it is 0.
    pub unless: Option<String>,
    /// Item that disables the limit permanently once it is true.
    pub off: Option<String>,
}

/// Outputs that may be NaN or infinite while all inputs are finite.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Open {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
}

/// Outputs that stay NaN or infinite until a reset.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stays {
    /// Names or glob patterns.
    pub pins: Vec<String>,
    /// Reason.
    pub why: String,
    /// Steps of the reset, in order: inputs, as glob patterns, and the values to set. Empty if only a new load resets
    /// the outputs.
    pub reset: Vec<BTreeMap<String, String>>,
}

/// Arguments that look wrong and are accepted.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Takes {
    /// Argument, for example `num_chan=0`.
    pub words: Vec<String>,
    /// Reason.
    pub why: String,
}

impl Case {
    /// Reads the case of a component, or of its library; most components have none.
    ///
    /// # Errors
    /// The file cannot be read, or is wrong.
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

    /// Returns the argument lists of `loadrt` to test, including those of the judge.
    ///
    /// # Errors
    /// A file of the judge is wrong.
    pub fn ways(&self, offer: &Offer) -> Result<Vec<String>, String> {
        let judged = judge::Case::of(&offer.component)?.loads;
        let others = every::ways(&offer.component).iter().map(|w| (*w).to_owned()).collect();
        let mut ways = Vec::new();
        // Both lists imply the load without arguments.
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

    /// Returns the row of an output that may be NaN or infinite.
    pub fn open(&self, name: &str) -> Option<&Open> {
        self.open.iter().find(|o| named(&o.pins, name))
    }

    /// Returns the row of an output that stays NaN or infinite.
    pub fn stays(&self, name: &str) -> Option<&Stays> {
        self.stays.iter().find(|s| named(&s.pins, name))
    }

    /// Returns whether a limit on a rate of change depends on this item.
    pub fn is_rate(&self, name: &str) -> bool {
        let rates = self.bounds.iter().filter_map(|b| b.rate.as_deref());
        rates.into_iter().any(|r| filled(r, name).is_some())
    }
}

/// Returns the text that `#` stands for, if the name matches the form.
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
