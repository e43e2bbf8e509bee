//! Lines of an applied file that say what is so already: a machine's own file changes nothing.

use crate::Error;
use hal_protocol::{AliasInfo, ComponentInfo, Kind, Link, Reply, Request, SignalInfo, ThreadInfo};

/// Parts of the running machine with which lines are compared.
#[derive(Debug, Default)]
pub(crate) struct Already {
    components: Vec<ComponentInfo>,
    threads: Vec<ThreadInfo>,
    signals: Vec<SignalInfo>,
    aliases: Vec<AliasInfo>,
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
                Reply::Threads(list) => this.threads = list,
                Reply::Signals(list) => this.signals = list,
                Reply::Aliases(list) => this.aliases.extend(list),
                _ => return Err(Error::Unexpected),
            }
        }
        Ok(this)
    }

    /// Returns whether the machine is as the request would make it.
    pub(crate) fn holds(&self, request: &Request) -> bool {
        match request {
            Request::Load { module, args } => self.is_loaded(module, args),
            Request::LoadForeign { module, args, prefix } => {
                self.is_loaded(&format!("{prefix}{module}"), args)
            }
            Request::NewSignal { name, ty } => {
                self.signals.iter().any(|s| s.name == *name && s.value.ty() == *ty)
            }
            Request::AddFunct { funct, thread, position: -1, init: false } => {
                let thread = self.threads.iter().find(|t| t.name == *thread);
                thread.is_some_and(|t| t.functs.contains(funct))
            }
            Request::Alias { name, alias, .. } => {
                self.aliases.iter().any(|a| a.original == *name && a.alias == *alias)
            }
            _ => false,
        }
    }

    /// Returns whether a component was loaded with these arguments. A second load has a name such as `and2:1`.
    fn is_loaded(&self, name: &str, args: &[String]) -> bool {
        let args = args.join(" ");
        self.components.iter().any(|c| {
            let of = c.name.split_once(':').map_or(c.name.as_str(), |(module, _)| module);
            c.realtime && of == name && c.args.as_ref() == Some(&args)
        })
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
