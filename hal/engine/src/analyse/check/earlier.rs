//! Check of values that are others in LinuxCNC 2.9, for machines that come from there.

use super::{Look, finding};
use crate::load::earlier;
use hal_protocol::Code;

impl Look<'_> {
    /// Notes items that keep a first value which is another one in 2.9.
    pub(super) fn earlier(&mut self) {
        for (ix, item) in self.items().iter().copied() {
            let owner = self.graph.owner(ix);
            let Some(owner) = owner.filter(|c| c.foreign.is_none()) else { continue };
            let Some(value) = earlier::value(owner.name.as_str(), item.name.as_str()) else {
                continue;
            };
            let now = crate::graph::Graph::value(item.ty, item.bits());
            if now == value || !self.is_idle(ix) {
                continue;
            }
            let name = item.shown().as_str();
            let text = format!("'{name}' begins with {now}, in LinuxCNC 2.9 with {value}");
            let remedy = format!(
                "setp {name} to the value that is meant; for all values of 2.9: HAL_COMPAT=2.9, or \
                 COMPAT = 2.9 in section HAL"
            );
            let at = self.loaded_at(ix);
            self.add(finding(Code::EarlierValue, name, text).at(at).remedy(&remedy));
        }
    }
}
