//! Checks of components that nothing uses, and of names that hide others.

use super::{Look, finding};
use crate::graph::Ix;
use hal_protocol::Code;

impl Look<'_> {
    pub(super) fn components(&mut self) {
        for component in self.graph.components_by_age() {
            self.unused(component);
            self.foreign(component);
        }
        for (ix, item) in self.items().iter().copied() {
            let Some(alias) = item.alias() else { continue };
            let param = !item.direction.is_pin();
            if self.graph.item_named(!param, alias.as_str()).is_none() {
                continue;
            }
            let (what, other) = if param { ("parameter", "pin") } else { ("pin", "parameter") };
            let text = format!(
                "'{alias}' is now {what} '{}' as well as a {other} of its own: 'setp' and 'getp' \
                 take the pin",
                item.name
            );
            let at = self.graph.sites.of_alias(ix);
            self.add(
                finding(Code::AliasShadows, alias.as_str(), text)
                    .at(at)
                    .remedy("choose a name that nothing has"),
            );
        }
    }

    fn foreign(&mut self, component: Ix) {
        let Some(c) = self.graph.component(component) else { return };
        let Some(f) = &c.foreign else { return };
        let name = c.name.as_str();
        let text = format!(
            "'{name}' is a {}: what its functions read and write is not known, and so neither is \
             their order",
            f.kind
        );
        let at = self.graph.sites.of(component);
        let remedy = "look at the order of its functions yourself";
        self.add(finding(Code::Foreign, name, text).at(at).remedy(remedy));
    }

    fn unused(&mut self, component: Ix) {
        let Some(c) = self.graph.component(component) else { return };
        let serves = !c.commands.is_empty() || !self.graph.users(component).is_empty();
        if !c.realtime || c.args.is_none() || serves {
            return;
        }
        let owned = self.graph.owned(component);
        let is_busy = |ix: Ix| {
            self.graph.component(ix).is_some()
                || self.graph.thread(ix).is_some()
                || self.graph.funct(ix).is_some_and(|f| f.unknown)
                || self.graph.is_in_use(ix) && self.graph.funct(ix).is_some()
                || self.graph.item(ix).is_some() && self.is_used(ix)
        };
        // What has nothing that could be used is there for others, as hostmot2 is for the drivers of its cards.
        if owned.is_empty() || owned.iter().any(|ix| is_busy(*ix)) {
            return;
        }
        let name = c.name.as_str();
        let at = self.graph.sites.of(component);
        self.add(
            finding(Code::Unused, name, format!("nothing uses component '{name}'"))
                .at(at)
                .remedy("link its pins and add its functions, or do not load it"),
        );
    }
}
