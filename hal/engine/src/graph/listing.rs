//! Data for `show`, `list`, `save` and `status`.

use crate::{
    graph::model::Model,
    graph::{Graph, Ix, Node},
    load::args::Declared,
    sync::Ordering,
};
use hal_abi::Slot;
use hal_protocol::{
    AliasInfo, CommandInfo, ComponentInfo, FunctInfo, ItemInfo, Kind, Patterns, Reply, SignalInfo,
    StreamInfo, ThreadInfo, Type, Usage,
};

/// Numbers of what is loaded, for `status`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    /// Memory in use and memory reserved, in bytes.
    pub(crate) memory: (u64, u64),
    pub(crate) components: Usage,
    pub(crate) pins: Usage,
    pub(crate) params: Usage,
    pub(crate) aliases: Usage,
    pub(crate) signals: Usage,
    pub(crate) functs: Usage,
    pub(crate) threads: Usage,
}

impl Model {
    /// Returns the answer to `show KIND PATTERNS…`.
    pub(crate) fn list(&mut self, kind: Kind, patterns: &[String], ty: Option<Type>) -> Reply {
        let p = Patterns::new(patterns);
        match kind {
            Kind::Components => Reply::Components(self.components(&p)),
            Kind::Pins => Reply::Items(self.items(false, &p, ty)),
            Kind::Params => Reply::Items(self.items(true, &p, ty)),
            Kind::Signals => Reply::Signals(self.signals(&p, ty)),
            Kind::Functs => Reply::Functs(self.functs(&p)),
            Kind::Threads => Reply::Threads(self.threads(&p)),
            Kind::PinAliases => Reply::Aliases(self.aliases(false, &p)),
            Kind::ParamAliases => Reply::Aliases(self.aliases(true, &p)),
            Kind::Commands => Reply::Commands(self.commands(&p)),
            Kind::Streams => Reply::Streams(self.streams(&p)),
            // The parts that own them list them.
            Kind::Workers | Kind::Snapshots => Reply::Done,
            Kind::Offers => Reply::Offers(self.loader().catalogue(&p)),
        }
    }

    fn components(&self, p: &Patterns) -> Vec<ComponentInfo> {
        let newest_first = self.graph.components_by_age().into_iter().rev();
        newest_first
            .filter_map(|ix| self.component_info(ix))
            .filter(|c| p.matches(&c.name))
            .collect()
    }

    /// Returns the description of a component.
    pub(crate) fn component_info(&self, ix: Ix) -> Option<ComponentInfo> {
        let c = self.graph.component(ix)?;
        Some(ComponentInfo {
            id: c.id,
            name: c.name.as_str().to_owned(),
            realtime: c.realtime,
            pid: c.pid,
            state: c.state,
            args: c.args.clone(),
            foreign: c.foreign_info(),
        })
    }

    fn items(&self, param: bool, p: &Patterns, ty: Option<Type>) -> Vec<ItemInfo> {
        let mut out = Vec::new();
        for (name, ix) in &self.graph.item_names(param) {
            let Some(item) = self.graph.item(*ix) else { continue };
            let listed = if item.hidden() {
                p.spell(".sim", name.as_str())
            } else {
                p.matches(name.as_str())
            };
            if !listed || item.shown() != *name || ty.is_some_and(|t| t != item.ty) {
                continue;
            }
            let owner = self.graph.owner(*ix);
            out.push(ItemInfo {
                owner: owner.map_or(0, |c| c.id),
                owner_name: owner.map_or("", |c| c.name.as_str()).to_owned(),
                direction: item.direction,
                value: Graph::value(item.ty, item.bits()),
                name: name.as_str().to_owned(),
                original: item.alias().map(|_| item.name.as_str().to_owned()),
                signal: self
                    .graph
                    .signal_of(*ix)
                    .and_then(|s| self.graph.signal(s))
                    .map(|s| s.name.as_str().to_owned()),
                doc: self.graph.docs.text(item.doc).to_owned(),
            });
        }
        out
    }

    fn signals(&self, p: &Patterns, ty: Option<Type>) -> Vec<SignalInfo> {
        let mut out = Vec::new();
        for (name, ix) in &self.graph.signal_names() {
            let Some(s) = self.graph.signal(*ix) else { continue };
            if !p.matches(name.as_str()) || ty.is_some_and(|t| t != s.ty) {
                continue;
            }
            let mut pins: Vec<_> = self
                .graph
                .pins_of(*ix)
                .into_iter()
                .filter_map(|pin| self.graph.item(pin))
                .map(|pin| (pin.direction, pin.shown().as_str().to_owned()))
                .collect();
            pins.sort_by(|a, b| a.1.cmp(&b.1));
            let value = Graph::value(s.ty, s.bits());
            out.push(SignalInfo { value, name: name.as_str().to_owned(), pins });
        }
        out
    }

    fn functs(&self, p: &Patterns) -> Vec<FunctInfo> {
        let named =
            self.graph.funct_names().into_iter().filter(|(name, _)| p.matches(name.as_str()));
        named
            .filter_map(|(name, ix)| {
                let f = self.graph.funct(ix)?;
                let owner = self.graph.owner(ix);
                Some(FunctInfo {
                    owner: owner.map_or(0, |c| c.id),
                    owner_name: owner.map_or("", |c| c.name.as_str()).to_owned(),
                    code: (f.code.run as *const ()).addr() as u64,
                    arg: f.code.state.addr() as u64,
                    users: u32::try_from(self.graph.threads_of(ix).len()).unwrap_or(u32::MAX),
                    name: name.as_str().to_owned(),
                    foreign: f.unknown,
                    doc: self.graph.docs.text(f.doc).to_owned(),
                    fast: f.fast,
                    fp: f.fp,
                })
            })
            .collect()
    }

    fn threads(&self, p: &Patterns) -> Vec<ThreadInfo> {
        let mut out = Vec::new();
        for ix in self.graph.threads_by_age().into_iter().rev() {
            let Some(node) = self.graph.thread(ix) else { continue };
            if !p.matches(node.name.as_str()) {
                continue;
            }
            let t = &node.thread;
            let read = |bits: u64| match hal_protocol::Value::from_bits(Type::S32, bits) {
                hal_protocol::Value::S32(ns) => ns,
                _ => 0,
            };
            // SAFETY: the slot belongs to the arena and lives as long as the thread.
            let time = unsafe { Slot::cell(t.account.time.0.as_ptr()) }.load();
            // SAFETY: the cell belongs to the arena and lives as long as the thread.
            let tmax = unsafe { t.account.tmax.0.as_ref() }.load();
            let guilty = t.guilty.load(Ordering::Relaxed);
            out.push(ThreadInfo {
                period: t.period_ns,
                name: node.name.as_str().to_owned(),
                fp: node.fp,
                functs: self
                    .graph
                    .runs(ix, false)
                    .into_iter()
                    .filter_map(|f| self.graph.funct(f))
                    .map(|f| f.name.as_str().to_owned())
                    .collect(),
                time: read(time),
                tmax: read(tmax),
                cycles: t.cycles.load(Ordering::Relaxed),
                overruns: t.overruns.load(Ordering::Relaxed),
                missed: t.missed.load(Ordering::Relaxed),
                overrun_by: (guilty != crate::realtime::thread::NOBODY)
                    .then(|| self.graph.funct_name(guilty)),
                latency_max: t.latest.load(Ordering::Relaxed),
                latency: t.latency.iter().map(|n| n.load(Ordering::Relaxed)).collect(),
            });
        }
        out
    }

    fn aliases(&self, param: bool, p: &Patterns) -> Vec<AliasInfo> {
        let mut out = Vec::new();
        for (name, ix) in &self.graph.item_names(param) {
            let Some(item) = self.graph.item(*ix) else { continue };
            if item.alias() == Some(*name) && p.matches(name.as_str()) {
                out.push(AliasInfo {
                    alias: name.as_str().to_owned(),
                    original: item.name.as_str().to_owned(),
                });
            }
        }
        out
    }

    fn commands(&self, p: &Patterns) -> Vec<CommandInfo> {
        let mut out = Vec::new();
        for (name, ix) in &self.graph.commands {
            let component = self.graph.component(*ix);
            let command = component.and_then(|c| c.commands.iter().find(|c| c.name == *name));
            let Some(command) = command.filter(|_| p.matches(name.as_str())) else { continue };
            out.push(CommandInfo {
                name: name.as_str().to_owned(),
                doc: command.doc.to_string(),
                args: command.args.iter().map(Declared::info).collect(),
            });
        }
        out
    }

    fn streams(&self, p: &Patterns) -> Vec<StreamInfo> {
        let named = self.rings.iter().filter(|(name, _)| p.matches(name.as_str()));
        named.map(|(name, ring)| ring.info(name.as_str())).collect()
    }

    /// Returns the numbers of what is loaded.
    pub(crate) fn sizes(&self) -> Sizes {
        let count = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let usage = |active: u32| Usage { active, recycled: 0 };
        let (free_slots, free_cells) = self.arena.recycled();
        let is_aliased = |node: &&Node| matches!(node, Node::Item(i) if i.alias().is_some());
        let aliases = self.graph.g.node_weights().filter(is_aliased).count();
        Sizes {
            memory: self.arena.usage(),
            components: usage(count(self.graph.components.len())),
            pins: Usage { active: self.counters.pins, recycled: count(free_slots) },
            params: usage(self.counters.params),
            aliases: usage(count(aliases)),
            signals: Usage {
                active: count(self.graph.signal_count()),
                recycled: count(free_cells),
            },
            functs: usage(count(self.graph.funct_count())),
            threads: usage(count(self.graph.threads.len())),
        }
    }
}
