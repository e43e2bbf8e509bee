//! Joined `loadrt` lines of one component, for a start with two passes.

use crate::Error;
use hal_protocol::At;
use std::collections::BTreeSet;

/// Arguments whose values add up.
const COUNTS: [&str; 2] = ["count", "num_chan"];
/// Argument whose values are joined with commas.
const NAMES: &str = "names";
/// Argument whose values belong to those of `names`, in their order.
const PERSONALITY: &str = "personality";

/// The pass that is in progress, with what the first one met.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pass {
    /// The components of the first pass, in the order of their first lines.
    pub(crate) loads: Vec<JoinedLoad>,
    /// Words of the lines that the first pass has executed or will execute as a part of a joined line.
    pub(crate) met: BTreeSet<Vec<String>>,
    /// True in the second pass.
    pub(crate) is_second: bool,
}

/// The `loadrt` lines of one component.
#[derive(Clone, Debug)]
pub(crate) struct JoinedLoad {
    module: String,
    /// Name and value of each argument, and the place of its first line.
    args: Vec<(String, String, At)>,
    /// Place of the first line.
    pub(crate) at: At,
}

impl JoinedLoad {
    /// Adds the arguments of a line.
    fn join(&mut self, args: &[String], at: &At) -> Result<(), Error> {
        for arg in args {
            let (name, value) = arg.split_once('=').unwrap_or((arg.as_str(), ""));
            let value = value.trim_matches('"');
            let is_form = |name: &str| name == NAMES || COUNTS.contains(&name);
            let differs = |first: &(String, String, At)| Error::LoadsDiffer {
                module: self.module.as_str().into(),
                given: arg.as_str().into(),
                first: format!("{}={}", first.0, first.1).into(),
                at: first.2.to_string().into(),
            };
            if let Some(other) =
                self.args.iter().find(|a| is_form(name) && is_form(&a.0) && a.0 != name)
            {
                return Err(differs(other));
            }
            let Some(n) = self.args.iter().position(|a| a.0 == name) else {
                self.args.push((name.to_owned(), value.to_owned(), at.clone()));
                continue;
            };
            let Some(first) = self.args.get(n) else { continue };
            let joined = if name == NAMES || name == PERSONALITY {
                let taken = |word: &str| name == NAMES && first.1.split(',').any(|w| w == word);
                if value.split(',').any(taken) {
                    return Err(differs(first));
                }
                format!("{},{value}", first.1)
            } else if COUNTS.contains(&name) {
                let sum = |a: &str, b: &str| a.parse::<u32>().ok()?.checked_add(b.parse().ok()?);
                sum(&first.1, value).ok_or_else(|| differs(first))?.to_string()
            } else if first.1 == value {
                continue;
            } else {
                return Err(differs(first));
            };
            if let Some(first) = self.args.get_mut(n) {
                first.1 = joined;
            }
        }
        Ok(())
    }

    /// Returns the words of the joined line.
    pub(crate) fn words(&self) -> Vec<String> {
        let args = self.args.iter().map(|(name, value, _)| match value.contains(' ') {
            true => format!("{name}=\"{value}\""),
            false => format!("{name}={value}"),
        });
        ["loadrt".to_owned(), self.module.clone()].into_iter().chain(args).collect()
    }
}

impl Pass {
    /// Adds a line of a component.
    pub(crate) fn collect(&mut self, module: &str, args: &[String], at: &At) -> Result<(), Error> {
        let found = self.loads.iter_mut().find(|load| load.module == module);
        if let Some(load) = found {
            return load.join(args, at);
        }
        let mut load = JoinedLoad { module: module.to_owned(), args: Vec::new(), at: at.clone() };
        load.join(args, at)?;
        self.loads.push(load);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Pass;
    use hal_protocol::At;

    /// Returns the joined lines, or the error.
    fn joined(lines: &[&str]) -> String {
        let mut pass = Pass::default();
        for (n, line) in lines.iter().enumerate() {
            let words: Vec<String> = line.split(' ').map(str::to_owned).collect();
            let (module, args) = words.split_first().unwrap();
            let at = At::new("m.hal", u32::try_from(n).unwrap() + 1);
            if let Err(error) = pass.collect(module, args, &at) {
                return format!("{}: {}", n + 1, error.whole());
            }
        }
        let lines: Vec<String> = pass.loads.iter().map(|load| load.words().join(" ")).collect();
        lines.join("; ")
    }

    #[test]
    fn lines_of_a_component_become_one() {
        for (lines, want) in [
            (&["and2 names=a", "or2", "and2 names=b,c"][..], "loadrt and2 names=a,b,c; loadrt or2"),
            (&["or2 count=2", "or2 count=1"], "loadrt or2 count=3"),
            (&["encoder num_chan=2", "encoder num_chan=1"], "loadrt encoder num_chan=3"),
            (
                &["logic names=x personality=0x102", "logic names=y personality=0x103"],
                "loadrt logic names=x,y personality=0x102,0x103",
            ),
            (&["not", "not"], "loadrt not"),
            (&["motmod num_joints=3", "motmod num_joints=3"], "loadrt motmod num_joints=3"),
        ] {
            assert_eq!(joined(lines), want, "{lines:?}");
        }
    }

    #[test]
    fn lines_that_contradict_each_other_are_refused() {
        let remedy = "; with TWOPASS all loadrt lines of a component become one";
        for (lines, want) in [
            (
                &["pid names=p", "pid count=2"][..],
                "2: loadrt pid: 'count=2' cannot be joined with 'names=p' of m.hal:1",
            ),
            (
                &["stepgen step_type=0,0", "not", "stepgen step_type=2"],
                "3: loadrt stepgen: 'step_type=2' cannot be joined with 'step_type=0,0' of m.hal:1",
            ),
            (
                &["and2 names=a,b", "and2 names=c,b"],
                "2: loadrt and2: 'names=c,b' cannot be joined with 'names=a,b' of m.hal:1",
            ),
            (
                &["or2 count=4000000000", "or2 count=4000000000"],
                "2: loadrt or2: 'count=4000000000' cannot be joined with 'count=4000000000' of m.hal:1",
            ),
        ] {
            assert_eq!(joined(lines), format!("{want}{remedy}"), "{lines:?}");
        }
    }
}
