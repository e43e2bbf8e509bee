//! Checks of the order of functions, feedback loops and signals between threads, with the results
//! of `order`.

use super::{Look, finding, names};
use hal_protocol::{At, Code, HopInfo, LoopInfo, OrderInfo, ThreadOrder};
use std::collections::BTreeSet;

/// The function whose results motion works on in the same cycle.
const COMMANDS: &str = "motion-command-handler";
/// Last parts of the names of pins that command a motor.
const COMMANDED: &[&str] = &["motor-pos-cmd", "position-cmd"];
/// Last part of the name of the pin that tells where a motor is.
const FEEDBACK: &str = "motor-pos-fb";
/// Last parts of the names of functions that read where motors are.
const CAPTURES: &[&str] = &["capture-position", "capture_position", "read"];
/// Last part of the name of the function that computes a control loop, whose result is a command.
const LOOP: &str = "do-pid-calcs";

impl Look<'_> {
    pub(super) fn flow(&mut self, order: &OrderInfo) {
        for thread in &order.threads {
            for late in thread.late.iter().filter(|late| !late.remains) {
                self.late(thread, &late.hop);
            }
        }
        for feedback in order.loops.iter().filter(|l| !l.handshake && passes_signals(l)) {
            let Some(first) = feedback.way.hops.first() else { continue };
            let mut way: Vec<&str> = feedback.way.hops.iter().map(|h| h.from.as_str()).collect();
            way.push(&first.from);
            let text = format!(
                "a loop: {}; a value returns after {}",
                way.join(" → "),
                time(feedback.way.delay.most)
            );
            let at = added(order, &first.from);
            self.add(finding(Code::Feedback, &first.from, text).at(at).remedy(
                "nothing, if it is a control loop; its gains must bear the delay ('halcmd order' \
                 shows it hop by hop)",
            ));
        }
        let mut told = BTreeSet::new();
        for hop in &order.crossings {
            for name in &hop.by {
                if self.graph.signal_named(name).is_some() && told.insert(name.clone()) {
                    self.crossing(order, hop, name);
                }
            }
        }
    }

    /// Returns whether a value that passes from one function to the next moves a motor, or tells where it is.
    fn moves(&self, hop: &HopInfo) -> bool {
        if hop.by.is_empty() {
            return hop.from == COMMANDS;
        }
        let last = |name: &'_ str| name.rsplit('.').next().unwrap_or_default().to_owned();
        let from = last(&hop.from);
        let signals = hop.by.iter().filter_map(|name| self.graph.find_signal(name).ok());
        let mut pins = signals.flat_map(|signal| self.graph.pins_of(signal));
        pins.any(|pin| {
            let pin = last(self.graph.item(pin).map_or("", |item| item.name.as_str()));
            COMMANDED.contains(&pin.as_str())
                || pin == FEEDBACK && CAPTURES.contains(&from.as_str())
                || pin == "velocity-cmd" && from == LOOP
        })
    }

    fn late(&mut self, thread: &ThreadOrder, hop: &HopInfo) {
        let through = if hop.by.is_empty() {
            "what it hands over".to_owned()
        } else {
            names(hop.by.iter().map(String::as_str))
        };
        let text = format!(
            "'{}' runs before '{}' in {}, and has {through} of it a cycle ({}) late",
            hop.to,
            hop.from,
            thread.name,
            time(thread.period)
        );
        let code = if self.moves(hop) { Code::OrderLate } else { Code::OrderCosts };
        let place =
            |name: &str| thread.functs.iter().find(|f| f.name == name).and_then(|f| f.at.clone());
        self.add(
            finding(code, &hop.to, text)
                .at(place(&hop.to))
                .remedy(format!("add them in this order: {}", thread.better.join(", ")))
                .related(place(&hop.from), format!("'{}' is added here", hop.from)),
        );
    }

    fn crossing(&mut self, order: &OrderInfo, hop: &HopInfo, name: &str) {
        let from = order.threads.iter().find(|t| t.functs.iter().any(|f| f.name == hop.from));
        let from = from.map_or("", |t| t.name.as_str());
        let text = format!(
            "signal '{name}' goes from '{}' in {from} to '{}' in {}",
            hop.from, hop.to, hop.thread
        );
        let signal = self.graph.find_signal(name).ok();
        let at = signal.and_then(|ix| self.graph.sites.of(ix));
        self.add(
            finding(Code::Crossing, name, text)
                .at(at)
                .remedy(format!(
                    "nothing, if it may be up to {} old; what belongs together may be read in \
                     different cycles",
                    time(hop.delay.most)
                ))
                .related(added(order, &hop.to), format!("'{}' is added here", hop.to)),
        );
    }
}

/// Returns whether a loop leaves its component.
fn passes_signals(l: &LoopInfo) -> bool {
    l.way.hops.iter().any(|hop| !hop.by.is_empty())
}

/// Returns the position at which a function was added.
fn added(order: &OrderInfo, funct: &str) -> Option<At> {
    let mut functs = order.threads.iter().flat_map(|t| &t.functs);
    functs.find(|f| f.name == funct)?.at.clone()
}

/// Formats a time with a suitable unit.
fn time(ns: u64) -> String {
    match ns {
        0 => "0".to_owned(),
        n if n % 1_000_000 == 0 => format!("{} ms", n / 1_000_000),
        n if n % 1000 == 0 => format!("{} us", n / 1000),
        n => format!("{n} ns"),
    }
}
