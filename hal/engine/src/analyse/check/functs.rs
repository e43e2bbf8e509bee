//! Checks of functions that no thread or the wrong thread runs, and of threads without functions.

use super::{Look, finding, protection::is_driver};
use crate::graph::{Edge, Ix};
use hal_protocol::{Code, Direction, Level, Type};
use petgraph::{
    Direction::{Incoming, Outgoing},
    visit::EdgeRef,
};

impl Look<'_> {
    pub(super) fn functs(&mut self) {
        for (_, funct) in self.graph.funct_names() {
            if self.graph.funct(funct).is_none_or(|f| f.unknown) {
                continue;
            }
            if self.graph.is_in_use(funct) {
                self.fast_in_slow(funct);
                self.slow_outputs(funct);
                self.slow_between(funct);
                self.slow_in_fast(funct);
            } else if !self.never_added(funct) {
                self.nothing_handed_over(funct);
            }
        }
    }

    /// Reports a function that no thread runs, if its pins are in use and no other function does
    /// its work for them. Returns whether it did.
    fn never_added(&mut self, funct: Ix) -> bool {
        let (reads, writes) = self.touched(funct);
        let runs = |f: &Ix| self.graph.is_in_use(*f);
        let lost = |item: Ix, others: Vec<Ix>| self.is_used(item) && !others.iter().any(runs);
        let idle = writes
            .iter()
            .find(|item| lost(**item, self.writers(**item)))
            .or_else(|| reads.iter().find(|item| lost(**item, self.readers(**item))));
        let Some(item) = idle.copied() else { return false };
        let name = self.funct_name(funct);
        let (used, at) = match self.linked_at(item) {
            Some(at) => ("linked", Some(at)),
            None if self.graph.signal_of(item).is_some() => ("linked", None),
            None => ("set", self.set_at(item)),
        };
        let pin = self.shown(item);
        let is_fast = self.graph.funct(funct).is_some_and(|f| f.fast);
        let fast = is_fast || self.is_among_fast(funct);
        let thread = self.thread_for(fast).unwrap_or("THREAD");
        let text = format!("no thread runs '{name}', and '{pin}' is {used}");
        let at = at.or_else(|| self.loaded_at(funct));
        let loaded = self.loaded_at(funct);
        self.add(
            finding(Code::NeverAdded, name, text)
                .at(loaded)
                .remedy(format!("addf {name} {thread}"))
                .related(at, format!("'{pin}' is {used} here")),
        );
        true
    }

    /// Reports a function that no thread runs, if a function that runs takes its hidden state from
    /// it alone.
    fn nothing_handed_over(&mut self, funct: Ix) {
        let takers = self.handed_over(funct, Outgoing);
        let runs = |f: &Ix| self.graph.is_in_use(*f);
        let waits = |t: &Ix| runs(t) && !self.handed_over(*t, Incoming).iter().any(runs);
        let Some(taker) = takers.iter().find(|t| waits(t)) else { return };
        let (name, waiting) = (self.funct_name(funct), self.funct_name(*taker));
        let thread = self.graph.threads_of(*taker).first().copied();
        let at = thread.and_then(|t| self.added_at(t, *taker));
        let thread = thread.map_or("THREAD", |t| self.thread_name(t));
        let text = format!(
            "no thread runs '{name}', from which '{waiting}' in {thread} takes what it works on"
        );
        let loaded = self.loaded_at(funct);
        self.add(
            finding(Code::NothingHandedOver, name, text)
                .at(loaded)
                .remedy(format!("addf {name} {thread}"))
                .related(at, format!("'{waiting}' is added here")),
        );
    }

    /// Returns the functions to or from which a function hands over hidden state.
    fn handed_over(&self, funct: Ix, way: petgraph::Direction) -> Vec<Ix> {
        let edges = self.graph.g.edges_directed(funct, way);
        let edges = edges.filter(|e| *e.weight() == Edge::HandsOver);
        edges.map(|e| if way == Outgoing { e.target() } else { e.source() }).collect()
    }

    /// Returns the name of the fastest or the slowest thread.
    fn thread_for(&self, fast: bool) -> Option<&str> {
        let threads = self.graph.threads_by_age();
        let by = |t: &&Ix| self.period(**t);
        let found =
            if fast { threads.iter().min_by_key(by) } else { threads.iter().max_by_key(by) };
        found.map(|t| self.thread_name(*t))
    }

    fn fast_in_slow(&mut self, funct: Ix) {
        if self.graph.funct(funct).is_none_or(|f| !f.fast) {
            return;
        }
        let threads = self.graph.threads_by_age();
        let Some(fastest) = threads.iter().copied().min_by_key(|t| self.period(*t)) else { return };
        for thread in self.graph.threads_of(funct) {
            if self.period(thread) <= self.period(fastest) {
                continue;
            }
            let (name, slow) = (self.funct_name(funct), self.thread_name(thread));
            let fast = self.thread_name(fastest);
            let text = format!(
                "'{name}' belongs in a fast thread, and runs in {slow} every {} ns; {fast} has {} \
                 ns",
                self.period(thread),
                self.period(fastest)
            );
            let at = self.added_at(thread, funct);
            self.add(
                finding(Code::FastInSlow, name, text).at(at).remedy(format!("addf {name} {fast}")),
            );
        }
    }

    /// Reports a driver's function that writes, in a slow thread, bits that a faster thread computes.
    fn slow_outputs(&mut self, funct: Ix) {
        let owner = self.graph.owner_of(funct).and_then(|ix| self.graph.component(ix));
        let threads = self.graph.threads_of(funct);
        let (true, Some(thread)) = (owner.is_some_and(is_driver), threads.first()) else { return };
        let own = self.period(*thread);
        let (reads, _) = self.touched(funct);
        for pin in reads {
            let Some(item) = self.graph.item(pin) else { continue };
            let Some(signal) = self.graph.signal_of(pin) else { continue };
            if item.direction != Direction::In || item.ty != Type::Bit {
                continue;
            }
            let writers = self.ends(signal).0;
            let functs = writers.iter().flat_map(|w| self.writers(*w));
            let faster =
                functs.flat_map(|f| self.graph.threads_of(f)).find(|t| self.period(*t) < own);
            let Some(faster) = faster else { continue };
            let (name, slow, fast) =
                (self.funct_name(funct), self.thread_name(*thread), self.thread_name(faster));
            let text = format!(
                "'{name}' runs in {slow}, and '{}' gets signal '{}' from the faster {fast}: pulses \
                 are lost",
                self.shown(pin),
                self.signal_name(signal)
            );
            let at = self.added_at(*thread, funct);
            self.add(
                finding(Code::FastInSlow, name, text).at(at).remedy(format!("addf {name} {fast}")),
            );
            return;
        }
    }

    /// Reports a function of bits alone that passes pulses on in a slow thread, from and to functions of a faster one.
    fn slow_between(&mut self, funct: Ix) {
        let owner = self.graph.owner_of(funct).and_then(|ix| self.graph.component(ix));
        let Some(thread) = self.graph.threads_of(funct).first().copied() else { return };
        let (reads, writes) = self.touched(funct);
        let is_number = |ix: &Ix| self.graph.item(*ix).is_some_and(|i| i.ty != Type::Bit);
        if owner.is_none_or(is_driver) || reads.iter().chain(&writes).any(is_number) {
            return;
        }
        let own = self.period(thread);
        let makes_pulses = |f: Ix| self.graph.funct(f).is_some_and(|f| f.fast);
        let before = self.bits_from(funct, own).into_iter().find(|f| makes_pulses(*f));
        let after = self.bits_to(funct).into_iter().find(|(_, t)| self.period(*t) < own);
        let (Some(before), Some((after, faster))) = (before, after) else { return };
        let (name, slow, fast) =
            (self.funct_name(funct), self.thread_name(thread), self.thread_name(faster));
        let text = format!(
            "'{name}' runs in {slow}, between '{}' and '{}' in the faster {fast}: pulses are lost",
            self.funct_name(before),
            self.funct_name(after)
        );
        let at = self.added_at(thread, funct);
        self.add(
            finding(Code::FastInSlow, name, text).at(at).remedy(format!("addf {name} {fast}")),
        );
    }

    /// Returns whether a function that no thread runs passes bits on from a faster thread, to the same one or to a
    /// device.
    fn is_among_fast(&self, funct: Ix) -> bool {
        let threads = self.graph.threads_by_age();
        let Some(slowest) = threads.iter().map(|t| self.period(*t)).max() else { return false };
        let after = self.bits_to(funct);
        let is_after = after.is_empty() || after.iter().any(|(_, t)| self.period(*t) < slowest);
        is_after && !self.bits_from(funct, slowest).is_empty()
    }

    /// Returns the functions from which a function reads bits, except those of drivers, that run more often than with a
    /// period.
    fn bits_from(&self, funct: Ix, period: i64) -> Vec<Ix> {
        let signals = self.touched(funct).0.into_iter().filter_map(|pin| self.bits_of(pin));
        let writers = signals.flat_map(|signal| self.ends(signal).0);
        let functs = writers.flat_map(|pin| self.writers(pin)).filter(|f| {
            let owner = self.graph.owner_of(*f).and_then(|ix| self.graph.component(ix));
            owner.is_some_and(|o| !is_driver(o))
                && self.graph.threads_of(*f).iter().any(|t| self.period(*t) < period)
        });
        functs.collect()
    }

    /// Returns the functions that read bits of a function, with their threads.
    fn bits_to(&self, funct: Ix) -> Vec<(Ix, Ix)> {
        let signals = self.touched(funct).1.into_iter().filter_map(|pin| self.bits_of(pin));
        let readers = signals.flat_map(|signal| self.ends(signal).1);
        let functs = readers.flat_map(|pin| self.readers(pin));
        functs.flat_map(|f| self.graph.threads_of(f).into_iter().map(move |t| (f, t))).collect()
    }

    /// Returns the signal of a pin of type bit.
    fn bits_of(&self, pin: Ix) -> Option<Ix> {
        let item = self.graph.item(pin).filter(|item| item.ty == Type::Bit)?;
        (item.direction != Direction::Rw).then(|| self.graph.signal_of(pin)).flatten()
    }

    /// Reports a function that computes with floats and runs in the same thread as its component's
    /// fast function.
    fn slow_in_fast(&mut self, funct: Ix) {
        let Some(f) = self.graph.funct(funct).filter(|f| !f.fast) else { return };
        let Some(owner) = self.graph.owner_of(funct) else { return };
        let (reads, writes) = self.touched(funct);
        let floats = |ix: &Ix| self.graph.item(*ix).is_some_and(|i| i.ty == Type::Float);
        let motion = f.name.as_str().starts_with("motion-");
        if !motion && !reads.iter().chain(&writes).any(floats) {
            return;
        }
        let siblings = self.graph.owned(owner);
        let fast: Vec<Ix> = siblings
            .into_iter()
            .filter(|ix| self.graph.funct(*ix).is_some_and(|f| f.fast))
            .flat_map(|ix| self.graph.threads_of(ix))
            .collect();
        let threads = self.graph.threads_by_age();
        let Some(slowest) = threads.iter().copied().max_by_key(|t| self.period(*t)) else { return };
        for thread in self.graph.threads_of(funct) {
            if !motion && !fast.contains(&thread) || self.period(thread) >= self.period(slowest) {
                continue;
            }
            let name = f.name.as_str();
            let (here, there) = (self.thread_name(thread), self.thread_name(slowest));
            let text =
                format!("'{name}' computes with numbers, and runs in the fast thread {here}");
            let at = self.added_at(thread, funct);
            self.add(
                finding(Code::SlowInFast, name, text).at(at).remedy(format!("addf {name} {there}")),
            );
        }
    }

    pub(super) fn threads(&mut self) {
        let threads = self.graph.threads_by_age();
        let mut busy = Vec::new();
        for thread in &threads {
            let runs = [self.graph.runs(*thread, false), self.graph.runs(*thread, true)].concat();
            if !runs.is_empty() {
                busy.push(*thread);
                continue;
            }
            let name = self.thread_name(*thread);
            let at = self.loaded_at(*thread);
            self.add(
                finding(Code::EmptyThread, name, format!("thread '{name}' has nothing to run"))
                    .at(at)
                    .remedy(format!("addf FUNCT {name}, or make no such thread")),
            );
        }
        let Some(first) = busy.first().filter(|_| !self.runs) else { return };
        let name = self.thread_name(*first);
        let at = self.graph.runs(*first, false).first().and_then(|f| self.added_at(*first, *f));
        let mut found =
            finding(Code::NeverStarted, name, "the threads are never started".to_owned())
                .at(at)
                .remedy("start, as the last line");
        // Threads of `motmod` belong to a machine that its INI file starts.
        if self.loaded_by(*first) == "threads" {
            found.level = Level::Warning;
        }
        self.add(found);
    }
}
