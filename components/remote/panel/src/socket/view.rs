//! Status as a client has been sent it.

use crate::{
    commands::LOSSES,
    holds::holds,
    server::Panel,
    session::Role,
    status::{Machine, changes},
};
use serde_json::{Map, Value as Json, json};
use std::sync::{Arc, atomic::Ordering::Relaxed};

/// Status that a client has.
#[derive(Debug, Default)]
pub(super) struct View {
    machine: Arc<Machine>,
    panel: Option<Map<String, Json>>,
}

impl View {
    /// Returns the message with what has changed since the last call, if anything has.
    pub(super) fn changes(&mut self, panel: &Panel, client: u64, role: Role) -> Option<Json> {
        let machine = panel.machine.borrow().clone();
        let own = own(panel, &machine, client, role);
        let parts = [
            ("motion", changes(self.machine.motion.as_ref(), machine.motion.as_ref())),
            ("task", changes(self.machine.task.as_ref(), machine.task.as_ref())),
            ("panel", changes(self.panel.as_ref(), Some(&own))),
        ];
        let parts = parts.into_iter().filter_map(|(name, part)| Some((name.to_owned(), part?)));
        let mut message: Map<String, Json> = parts.collect();
        (self.machine, self.panel) = (machine, Some(own));
        if message.is_empty() {
            return None;
        }
        message.insert("type".to_owned(), "status".into());
        Some(message.into())
    }
}

/// Returns the state of the panel, as a client sees it.
fn own(panel: &Panel, machine: &Machine, client: u64, role: Role) -> Map<String, Json> {
    let (clients, holder) = panel.clients.view();
    let heart = &panel.heart;
    let lease = holder.map(|holder| {
        json!({ "user": holder.user, "client": holder.client, "yours": holder.client == client })
    });
    let is_lost = heart.hold.load(Relaxed);
    let orders = panel.engine.orders();
    let (pulse, beat) = (heart.pulse.load(Relaxed), heart.beat.load(Relaxed));
    let parts = [
        ("engine", json!(machine.engine)),
        ("lease", json!(lease)),
        ("clients", json!(clients)),
        ("allow_motion", json!(heart.allowed.load(Relaxed))),
        ("beating", json!(heart.permit.load(Relaxed))),
        ("job_held", json!(is_lost)),
        ("holds", json!(holds(machine, is_lost))),
        ("on_loss", json!(LOSSES.get(panel.on_loss.load(Relaxed)))),
        ("has_task", json!(orders.has_task())),
        ("can_reset", json!(orders.request("task.estop-reset", Vec::new()).is_ok())),
        ("outdated", json!(panel.engine.outdated())),
        ("role", json!(role)),
    ];
    let parts = parts.into_iter().map(|(name, part)| (name.to_owned(), part));
    let mut own: Map<String, Json> = parts.collect();
    if lease_is_yours(&own) {
        let age = f64::from(pulse.wrapping_sub(beat).min(9999)) * 1e-3;
        // Coarse, so that it does not change in each message.
        own.insert("round_trip".to_owned(), json!((age * 20.0).round() / 20.0));
    }
    own
}

fn lease_is_yours(own: &Map<String, Json>) -> bool {
    own.get("lease").and_then(|lease| lease.get("yours")) == Some(&Json::Bool(true))
}
