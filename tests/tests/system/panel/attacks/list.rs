//! The list of attacks, `tests/rights/attacks.toml`: who tries what, which test holds it, and the fault with which it succeeds.

use hal_golden::check;
use hal_tests::{programs::root, user::is_root};
use serde::Deserialize;
use std::{collections::BTreeMap, fmt::Write as _, fs, path::PathBuf};

/// Attackers, as the names of attacks begin, and the least number of attacks of each.
const WHO: &[(&str, usize)] = &[
    ("operator", 8),
    ("viewer", 8),
    ("another user", 8),
    ("web page", 8),
    ("file", 8),
    ("integrator", 1),
];
/// Begin of the line with which a test says that an attack had success.
pub(super) const BREACH: &str = "breach: ";

/// An attack.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Attack {
    /// Attacker, and what they try, as the test says it.
    pub(super) name: String,
    pub(super) fault: String,
    /// True for an attack that is tried where the tests may be several users.
    #[serde(default)]
    pub(super) users: bool,
}

/// Attacks of a test.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Held {
    /// Path of the test in this program, or in the crate of the package.
    pub(super) test: String,
    /// Package of a test that is one attack, and fails where it has success.
    pub(super) package: Option<String>,
    pub(super) attack: Vec<Attack>,
}

/// A change of one place.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Edit {
    pub(super) file: String,
    /// Text that the file has once.
    pub(super) text: String,
    pub(super) becomes: String,
}

/// A fault: the changes that make it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Fault {
    pub(super) name: String,
    /// Faults of one number are planted together: none of them makes an attack of another succeed.
    pub(super) batch: u32,
    pub(super) edit: Vec<Edit>,
}

impl Fault {
    /// Returns a number that changes with the fault.
    fn digest(&self) -> String {
        let texts = self.edit.iter().flat_map(|e| [&e.file, &e.text, &e.becomes]);
        // FNV-1a, with an end behind each text.
        let bytes = texts.flat_map(|text| text.bytes().chain([0]));
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        format!("{hash:016x}")
    }
}

/// The list.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct List {
    pub(super) held: Vec<Held>,
    pub(super) fault: Vec<Fault>,
}

/// Returns the path of a file beside the list.
pub(super) fn beside(name: &str) -> PathBuf {
    root().join("tests/rights").join(name)
}

impl List {
    pub(super) fn read() -> Self {
        let text = fs::read_to_string(beside("attacks.toml")).unwrap();
        toml::from_str(&text).unwrap_or_else(|e| panic!("attacks.toml: {e}"))
    }

    pub(super) fn attacks(&self) -> impl Iterator<Item = (&Held, &Attack)> {
        self.held.iter().flat_map(|held| held.attack.iter().map(move |attack| (held, attack)))
    }

    fn fault(&self, name: &str) -> &Fault {
        let fault = self.fault.iter().find(|fault| fault.name == name);
        fault.unwrap_or_else(|| panic!("attacks.toml: no fault is named {name}"))
    }

    /// Returns the line of the record of an attack that was seen to succeed with its fault.
    pub(super) fn seen(&self, attack: &Attack) -> String {
        format!("{} | {}", self.fault(&attack.fault).digest(), attack.name)
    }
}

/// Attacks that a test tries.
#[derive(Debug, Default)]
pub(crate) struct Tries {
    tried: Vec<String>,
    breaches: Vec<String>,
}

impl Tries {
    /// Notes an attack, and what was said; one that has success is a breach. Returns whether it is one.
    pub(crate) fn note(&mut self, attack: &str, has_success: bool, said: &str) -> bool {
        self.tried.push(attack.to_owned());
        if has_success {
            self.breaches.push(format!("{BREACH}{attack}: {said}"));
        }
        has_success
    }

    /// Ends the test of this path in the list.
    ///
    /// # Panics
    /// An attack had success, one of the list was not tried, or one is not in the list.
    pub(crate) fn finish(self, test: &str) {
        let Self { mut tried, breaches } = self;
        assert!(
            breaches.is_empty(),
            "of {}, {} had success:\n{}",
            tried.len(),
            breaches.len(),
            breaches.join("\n")
        );
        let list = List::read();
        let held = list.held.iter().find(|held| held.test == test);
        let held = held.unwrap_or_else(|| panic!("attacks.toml has no test {test}"));
        let can_be = held.attack.iter().filter(|attack| !attack.users || is_root());
        let mut wanted: Vec<_> = can_be.map(|attack| attack.name.clone()).collect();
        wanted.sort_unstable();
        tried.sort_unstable();
        assert_eq!(tried, wanted, "the attacks that {test} tries, and those of attacks.toml");
    }
}

#[test]
fn every_attack_has_a_fault_that_was_seen_to_let_it_succeed() {
    let list = List::read();
    let seen = fs::read_to_string(beside("attacks.seen")).unwrap_or_default();
    let (mut wrong, mut counts) = (String::new(), BTreeMap::new());
    let mut table = "\
# Attacks

Who tries what, the test that holds it, and the fault with which it succeeds. Written by the test `panel::attacks::list` from
`attacks.toml`, which has the text of each fault. `seen`: the test was seen to fail by this attack with the fault in the tree, by

```
cargo test -p hal-tests --test system panel::attacks::planted -- --ignored --nocapture
```

which writes `attacks.seen`. A fault that changes must be seen again, with all of its batch; without the file all are.

| attack | test | fault | seen |
|---|---|---|---|
"
    .to_owned();
    for (held, attack) in list.attacks() {
        let who = attack.name.split_once(": ").map_or("", |(who, _)| who);
        *counts.entry(who).or_insert(0) += 1;
        let line = list.seen(attack);
        let is_seen = seen.lines().any(|known| known == line);
        if !is_seen {
            writeln!(wrong, "{}: not seen to succeed with its fault", attack.name).unwrap();
        }
        let is_seen = if is_seen { "yes" } else { "no" };
        let (name, fault) = (&attack.name, &attack.fault);
        let package = held.package.as_ref().map_or(String::new(), |name| format!("{name}: "));
        writeln!(table, "| {name} | `{package}{}` | {fault} | {is_seen} |", held.test).unwrap();
    }
    for (who, least) in WHO {
        let count = counts.remove(who).unwrap_or(0);
        writeln!(table, "{}{who}: {count} attacks.", if *who == WHO[0].0 { "\n" } else { "" })
            .unwrap();
        if count < *least {
            writeln!(wrong, "{who}: {count} attacks, must be {least} or more").unwrap();
        }
    }
    assert!(counts.is_empty(), "attacks by others than the list knows: {counts:?}");
    for fault in &list.fault {
        let is_used = list.attacks().any(|(_, attack)| attack.fault == fault.name);
        if !is_used {
            writeln!(wrong, "{}: a fault without an attack", fault.name).unwrap();
        }
        for edit in &fault.edit {
            let text = fs::read_to_string(root().join(&edit.file)).unwrap_or_default();
            let count = text.matches(&edit.text).count();
            if count != 1 || edit.text == edit.becomes {
                let (name, file, text) = (&fault.name, &edit.file, &edit.text);
                writeln!(wrong, "{name}: {file} has {count} times, must have once: {text}")
                    .unwrap();
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    check(&beside("attacks.md"), &table);
}
