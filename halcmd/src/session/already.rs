//! Lines of an applied file that say what is so already: a machine's own file changes nothing.

use crate::Error;
use hal_protocol::{AliasInfo, ComponentInfo, Kind, Link, Reply, Request, SignalInfo, ThreadInfo};

/// Parts of the running machine with which lines are compared.
#[derive(Debug, Default)]
pub(crate) struct Already {
    components: Vec<ComponentInfo>,
    threads: Vec<Chain>,
    signals: Vec<SignalInfo>,
    aliases: Vec<AliasInfo>,
}

/// Functions of a thread, which the lines of a file meet in their order.
#[derive(Debug)]
struct Chain {
    thread: String,
    /// Functions after the last one that was met.
    rest: Vec<String>,
    /// True after a line that adds a function: it comes last, so that none of the others may follow.
    adds: bool,
}

impl Chain {
    /// Returns whether the thread has this function after those of the lines before.
    fn holds(&mut self, funct: &str) -> bool {
        let found = self.rest.iter().position(|f| f == funct).filter(|_| !self.adds);
        match found {
            Some(at) => drop(self.rest.drain(..=at)),
            None => self.adds = true,
        }
        found.is_some()
    }
}

impl Already {
    /// Asks for the parts that these requests may make again.
    pub(crate) fn ask<'r>(
        link: &mut dyn Link,
        requests: impl Iterator<Item = &'r Request> + Clone,
    ) -> Result<Self, Error> {
        let mut this = Self::default();
        for kind in
            [Kind::Components, Kind::Threads, Kind::Signals, Kind::PinAliases, Kind::ParamAliases]
        {
            let concerns = |request: &Request| {
                matches!(
                    (request, kind),
                    (Request::Load { .. } | Request::LoadForeign { .. }, Kind::Components)
                        | (Request::AddFunct { .. }, Kind::Threads)
                        | (Request::NewSignal { .. }, Kind::Signals)
                        | (Request::Alias { param: false, .. }, Kind::PinAliases)
                        | (Request::Alias { param: true, .. }, Kind::ParamAliases)
                )
            };
            if !requests.clone().any(concerns) {
                continue;
            }
            match link.call(Request::List { kind, patterns: Vec::new(), ty: None })? {
                Reply::Components(list) => this.components = list,
                Reply::Threads(list) => {
                    let chain =
                        |t: ThreadInfo| Chain { thread: t.name, rest: t.functs, adds: false };
                    this.threads = list.into_iter().map(chain).collect();
                }
                Reply::Signals(list) => this.signals = list,
                Reply::Aliases(list) => this.aliases.extend(list),
                _ => return Err(Error::Unexpected),
            }
        }
        Ok(this)
    }

    /// Returns whether the machine is as the request would make it. The requests come in their order; no component and
    /// no place in a thread stands for two of them.
    pub(crate) fn holds(&mut self, request: &Request) -> bool {
        match request {
            Request::Load { module, args } => self.takes(module, args, false),
            Request::LoadForeign { module, args, prefix } => {
                self.takes(&format!("{prefix}{module}"), args, true)
            }
            Request::NewSignal { name, ty } => {
                self.signals.iter().any(|s| s.name == *name && s.value.ty() == *ty)
            }
            Request::AddFunct { funct, thread, position, init: false } => {
                let Some(chain) = self.threads.iter_mut().find(|c| c.thread == *thread) else {
                    return false;
                };
                // A line with a place of its own adds.
                chain.adds |= *position != -1;
                chain.holds(funct)
            }
            Request::Alias { name, alias, .. } => {
                self.aliases.iter().any(|a| a.original == *name && a.alias == *alias)
            }
            _ => false,
        }
    }

    /// Returns whether a component was loaded with these arguments, and takes it. A second load has a name such as
    /// `and2:1`.
    fn takes(&mut self, name: &str, args: &[String], foreign: bool) -> bool {
        let args = args.join(" ");
        let found = self.components.iter().position(|c| {
            let of = c.name.split_once(':').map_or(c.name.as_str(), |(module, _)| module);
            let is_kind = c.realtime && c.foreign.is_some() == foreign;
            is_kind && of == name && c.args.as_ref() == Some(&args)
        });
        found.map(|at| self.components.swap_remove(at)).is_some()
    }
}

/// Returns whether a later line may make again what this request removes.
pub(crate) const fn removes(request: &Request) -> bool {
    matches!(
        request,
        Request::Unload { .. }
            | Request::DeleteSignal { .. }
            | Request::RemoveFunct { .. }
            | Request::Unalias { .. }
    )
}

#[cfg(test)]
mod tests {
    use super::{Already, Chain};
    use hal_protocol::{ComponentInfo, ComponentState, Request};

    /// Returns which lines of `addf` the thread with these functions holds.
    fn held(functs: &str, lines: &[(&str, i64)]) -> Vec<bool> {
        let rest = functs.split(' ').map(str::to_owned).collect();
        let threads = vec![Chain { thread: "t".into(), rest, adds: false }];
        let mut already = Already { threads, ..Already::default() };
        let add = |(funct, position): &(&str, i64)| Request::AddFunct {
            funct: (*funct).into(),
            thread: "t".into(),
            position: *position,
            init: false,
        };
        lines.iter().map(|line| already.holds(&add(line))).collect()
    }

    #[test]
    fn functions_are_held_only_in_their_order() {
        for (lines, expected) in [
            (&[("a", -1), ("b", -1), ("c", -1)][..], &[true, true, true][..]),
            (&[("a", -1), ("c", -1), ("new", -1)], &[true, true, false]),
            (&[("b", -1), ("a", -1)], &[true, false]),
            (&[("a", -1), ("a", -1)], &[true, false]),
            (&[("a", -1), ("new", -1), ("b", -1)], &[true, false, false]),
            (&[("new", 1), ("a", -1)], &[false, false]),
        ] {
            assert_eq!(held("a b c", lines), expected, "{lines:?}");
        }
    }

    #[test]
    fn a_component_stands_for_one_line_of_its_kind() {
        let component = ComponentInfo {
            id: 1,
            name: "and2".into(),
            realtime: true,
            pid: None,
            state: ComponentState::Ready,
            args: Some("count=2".into()),
            foreign: None,
        };
        let mut already = Already { components: vec![component], ..Already::default() };
        let args = vec!["count=2".to_owned()];
        let foreign = Request::LoadForeign {
            module: "and2".into(),
            args: args.clone(),
            prefix: String::new(),
        };
        let load = Request::Load { module: "and2".into(), args };
        assert!(!already.holds(&foreign), "a plugin is no component in C");
        assert!(already.holds(&load));
        assert!(!already.holds(&load), "the second line loads a second one");
    }
}
