//! Checks that an e-stop stops the machine, by following its signals.

use super::{Look, finding, protection::is_driver};
use crate::graph::{Edge, Ix};
use hal_protocol::{Code, Direction};
use petgraph::{Direction::Outgoing, visit::EdgeRef};
use std::collections::BTreeSet;

/// Pin with which iocontrol commands the e-stop chain.
const OUT: &str = "iocontrol.0.user-enable-out";
/// Pin by which the e-stop chain answers.
const IN: &str = "iocontrol.0.emc-enable-in";
/// Input that disables motion.
const MOTION: &str = "motion.enable";
/// Service that stops motion in e-stop regardless of the wiring.
const INTERLOCK: &str = "interlock";

impl Look<'_> {
    pub(super) fn estop(&mut self) {
        self.estop_returns();
        self.estop_stops_motion();
    }

    /// Reports an e-stop chain that does not follow the command.
    fn estop_returns(&mut self) {
        let (Some((out, _)), Some((answer, item))) = (self.item(OUT), self.item(IN)) else {
            return;
        };
        // An input that is never TRUE has its own finding.
        let never = self.is_idle(answer) && item.bits() & 0xff == 0;
        if never || self.led_to(&[out]).contains(&answer) {
            return;
        }
        let fed = match self.graph.signal_of(answer) {
            Some(signal) => format!("signal '{}'", self.signal_name(signal)),
            None => "no signal".to_owned(),
        };
        let text = format!(
            "'{OUT}' does not lead back to '{IN}', which has {fed}: the chain does not follow \
             iocontrol.estop"
        );
        let at = self.linked_at(out).or_else(|| self.linked_at(answer));
        let at = at.or_else(|| self.loaded_at(out));
        self.add(finding(Code::EstopNotReturned, OUT, text).at(at).remedy(format!(
            "let it open the chain: net SIGNAL {OUT} => {IN}, or through components, such as an \
             and2 before ok-in of an estop_latch"
        )));
    }

    /// Reports motion that continues in e-stop.
    fn estop_stops_motion(&mut self) {
        let Some((motion, _)) = self.item(MOTION) else { return };
        let Some(owner) = self.graph.owner_of(motion) else { return };
        let service = self.graph.service(INTERLOCK, None).map(|(by, _)| by);
        let edges = self.graph.g.edges_directed(owner, Outgoing);
        let mut needs = edges.filter(|e| *e.weight() == Edge::Needs);
        if needs.any(|e| Some(e.target()) == service) {
            return;
        }
        let (text, remedy) = match (self.item(OUT), self.item(IN)) {
            (Some((out, _)), Some((answer, _))) => {
                let of = |pin| self.graph.signal_of(pin);
                let is_deaf =
                    of(motion) == of(out) && of(answer).is_some_and(|s| of(out) != Some(s));
                let follows = self.led_to(&[out, answer]).contains(&motion);
                if follows && !is_deaf {
                    return;
                }
                let why = match service {
                    Some(_) => ", and motmod was loaded before its interlock",
                    None => "",
                };
                (
                    if follows {
                        format!(
                            "'{MOTION}' follows '{OUT}' alone: contacts that open '{IN}' do not \
                             stop motion{why}"
                        )
                    } else {
                        format!("'{MOTION}' does not follow the e-stop of iocontrol{why}")
                    },
                    format!(
                        "net the signal of '{IN}' to {MOTION} as well; or before motmod: \
                         loadrt iocontrol interlock=1"
                    ),
                )
            }
            _ if self.graph.signal_of(motion).is_some() => return,
            _ => (
                format!("nothing is linked to '{MOTION}': no e-stop stops motion"),
                format!(
                    "net the e-stop's signal to {MOTION}; or before motmod: loadrt iocontrol \
                     interlock=1"
                ),
            ),
        };
        let at = self.loaded_at(motion);
        self.add(finding(Code::EstopNotJoined, MOTION, text).at(at).remedy(remedy));
    }

    /// Returns the pins that are reached from these pins, through signals and through functions as
    /// far as these declare what they access. Undeclared accesses and wires outside the machine are
    /// assumed to lead everywhere they can.
    fn led_to(&self, from: &[Ix]) -> BTreeSet<Ix> {
        let mut reached = BTreeSet::new();
        let mut left: Vec<Ix> = from.to_vec();
        let mut done: BTreeSet<Ix> = left.iter().copied().collect();
        while let Some(source) = left.pop() {
            let Some(signal) = self.graph.signal_of(source) else { continue };
            let (_, readers) = self.ends(signal);
            for reader in readers {
                if reached.insert(reader) {
                    left.extend(self.passed_on(reader).into_iter().filter(|p| done.insert(*p)));
                }
            }
        }
        reached
    }

    /// Returns the pins whose values may change with this pin.
    fn passed_on(&self, pin: Ix) -> Vec<Ix> {
        let mut written = Vec::new();
        for funct in self.readers(pin) {
            written.extend(self.touched(funct).1);
            let edges = self.graph.g.edges_directed(funct, Outgoing);
            for taker in edges.filter(|e| *e.weight() == Edge::HandsOver).map(|e| e.target()) {
                written.extend(self.touched(taker).1);
            }
        }
        let owner = self.graph.owner_of(pin);
        let component = owner.and_then(|ix| self.graph.component(ix));
        let (Some(owner), Some(component)) = (owner, component) else { return written };
        if is_driver(component) {
            // An external wire may lead back to any input of the machine.
            let all = self.graph.components.values().copied();
            let drivers = all.filter(|ix| self.graph.component(*ix).is_some_and(is_driver));
            written.extend(drivers.flat_map(|ix| self.outputs_of(ix)));
        } else if component.foreign.is_some() || !component.realtime {
            written.extend(self.outputs_of(owner));
        }
        written
    }

    fn outputs_of(&self, component: Ix) -> Vec<Ix> {
        let mut pins = self.graph.owned(component);
        pins.retain(|ix| {
            let item = self.graph.item(*ix);
            item.is_some_and(|i| matches!(i.direction, Direction::Out | Direction::Io))
        });
        pins
    }
}
