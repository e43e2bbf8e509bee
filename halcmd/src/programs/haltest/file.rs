//! The form of a test's TOML text. Nothing in it has been checked yet.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::{Spanned, Value};

/// A string and its position in the file.
pub(super) type Text = Spanned<String>;
/// Names of pins, signals and parameters, each with a value.
pub(super) type Values = BTreeMap<Text, Spanned<Value>>;

/// A test, or the common part of several tests.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct File {
    pub(super) about: Option<String>,
    pub(super) machine: Option<Text>,
    pub(super) begin: Option<Text>,
    pub(super) profile: Option<Text>,
    pub(super) arguments: Vec<Text>,
    pub(super) environment: BTreeMap<String, String>,
    pub(super) settings: Values,
    pub(super) replace: BTreeMap<Text, String>,
    pub(super) lines: Option<Text>,
    pub(super) limit: Option<Text>,
    pub(super) refused: Option<Text>,
    pub(super) exit: Option<Spanned<u8>>,
    pub(super) step: Vec<Spanned<Step>>,
    pub(super) expect: Vec<Spanned<Expect>>,
    pub(super) snapshot: Vec<Spanned<Snapshot>>,
}

/// An action or a check at one time.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct Step {
    pub(super) at: Option<Text>,
    pub(super) mark: Option<Text>,
    // The action: exactly one of these keys.
    pub(super) r#do: Option<Text>,
    pub(super) run: Option<Text>,
    pub(super) wait: Option<Text>,
    pub(super) set: Option<Values>,
    pub(super) ramp: Option<BTreeMap<Text, Spanned<Ramp>>>,
    pub(super) force: Option<Values>,
    pub(super) stuck: Option<Vec<Text>>,
    pub(super) unlink: Option<Vec<Text>>,
    pub(super) drop: Option<BTreeMap<Text, Spanned<u32>>>,
    pub(super) release: Option<Vec<Text>>,
    pub(super) expect: Option<Values>,
    // Keys that belong to some of the actions.
    pub(super) fails: Option<Text>,
    pub(super) prints: Option<Text>,
    pub(super) within: Option<Text>,
    pub(super) tolerance: Option<Spanned<f64>>,
}

/// A value that changes linearly.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Ramp {
    pub(super) from: Option<Spanned<f64>>,
    pub(super) to: Spanned<f64>,
    pub(super) over: Text,
}

/// A requirement on the whole run or on a part of it.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct Expect {
    pub(super) about: Option<String>,
    pub(super) from: Option<Text>,
    pub(super) to: Option<Text>,
    // The kind of requirement: exactly one of these keys.
    pub(super) value: Option<Text>,
    pub(super) always: Option<Text>,
    pub(super) never: Option<Text>,
    pub(super) happens: Option<Text>,
    pub(super) order: Option<Vec<Text>>,
    pub(super) between: Option<Vec<Text>>,
    pub(super) pulses: Option<Text>,
    pub(super) motor: Option<Motor>,
    pub(super) message: Option<Text>,
    pub(super) no_message: Option<Text>,
    // Keys that belong to some of the kinds.
    pub(super) at: Option<Text>,
    pub(super) is: Option<Spanned<Value>>,
    pub(super) least: Option<Spanned<Value>>,
    pub(super) most: Option<Spanned<Value>>,
    pub(super) tolerance: Option<Spanned<f64>>,
    pub(super) r#while: Option<Text>,
    pub(super) times: Option<Spanned<u64>>,
    pub(super) count: Option<Spanned<u64>>,
    pub(super) frequency: Option<Spanned<f64>>,
    pub(super) high: Option<Spanned<Width>>,
    pub(super) low: Option<Spanned<Width>>,
}

/// Bounds of a duration.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub(super) struct Width {
    pub(super) least: Option<Text>,
    pub(super) most: Option<Text>,
}

/// The step and direction lines of a stepper motor.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Motor {
    pub(super) step: Text,
    pub(super) direction: Text,
}

/// A waveform that is kept in a file beside the test.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Snapshot {
    pub(super) name: Text,
    pub(super) channels: Vec<Text>,
    pub(super) from: Option<Text>,
    pub(super) to: Option<Text>,
}
