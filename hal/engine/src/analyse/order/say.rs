//! Results of the analysis, with names.

use super::{By, Chain, Flow, Late, Study, Timed, Wait};
use crate::{
    Engine,
    graph::{Graph, Ix},
};
use hal_protocol::{
    AddedInfo, DelayInfo, HopInfo, LateInfo, LoopInfo, MoveInfo, OrderInfo, PathInfo, ThreadOrder,
    Type, WayInfo,
};

impl Engine {
    /// Returns the answer to `order`.
    #[must_use]
    pub fn order(&self) -> OrderInfo {
        let study = Study::of(self.model.graph());
        let (user, better) = (study.as_added(), study.as_better());
        let (late, later) = (study.late(), study.later());
        let say = Say { graph: self.model.graph(), study: &study, user, better, late, later };
        let (loops, paths) = (say.user.loops(), say.user.paths());
        OrderInfo {
            threads: (0..study.machine.threads.len()).filter_map(|t| say.thread(t)).collect(),
            paths: paths
                .list
                .iter()
                .map(|p| PathInfo {
                    from: say.funct(p.from),
                    to: say.funct(p.to),
                    quickest: say.way(&p.quickest),
                    slowest: (p.slowest.wait != p.quickest.wait).then(|| say.way(&p.slowest)),
                })
                .collect(),
            more_paths: paths.more,
            loops: loops.list.iter().map(|l| say.feedback(l)).collect(),
            more_loops: loops.more,
            crossings: study.crossings().into_iter().filter_map(|i| say.hop(i)).collect(),
        }
    }
}

/// An analysis, and the graph that has the names.
struct Say<'e> {
    graph: &'e Graph,
    study: &'e Study,
    user: Timed<'e>,
    better: Timed<'e>,
    late: Vec<Late>,
    later: Vec<usize>,
}

impl Say<'_> {
    fn thread(&self, t: usize) -> Option<ThreadOrder> {
        let thread = self.study.machine.threads.get(t)?;
        let is_here = |flow: usize| {
            let flow = self.study.machine.flows.get(flow);
            flow.is_some_and(|flow| self.study.machine.thread_of(flow.to) == t)
        };
        Some(ThreadOrder {
            name: self.thread_name(thread.ix),
            period: thread.period,
            functs: thread
                .order
                .iter()
                .filter_map(|i| {
                    let f = self.study.machine.functs.get(*i)?;
                    let at = f.edge.and_then(|edge| self.graph.sites.of_edge(edge));
                    Some(AddedInfo { name: self.funct(*i), at, unknown: f.unknown })
                })
                .collect(),
            better: self.study.better.get(t)?.iter().map(|i| self.funct(*i)).collect(),
            late: self
                .late
                .iter()
                .filter(|l| is_here(l.flow))
                .filter_map(|l| Some(LateInfo { hop: self.hop(l.flow)?, remains: l.remains }))
                .collect(),
            later: self
                .later
                .iter()
                .filter(|i| is_here(**i))
                .filter_map(|i| self.hop(*i))
                .collect(),
            moves: self
                .study
                .moves(t)
                .into_iter()
                .map(|m| MoveInfo { funct: self.funct(m.funct), position: m.position as u64 })
                .collect(),
        })
    }

    fn feedback(&self, chain: &Chain) -> LoopInfo {
        let mut flows = chain.flows.iter().filter_map(|i| self.study.machine.flows.get(*i));
        LoopInfo { way: self.way(chain), handshake: flows.all(|flow| !flow.is_one_way()) }
    }

    fn way(&self, chain: &Chain) -> WayInfo {
        WayInfo {
            hops: chain.flows.iter().filter_map(|i| self.hop(*i)).collect(),
            delay: delay(chain.wait),
            better: delay(self.better.along(&chain.flows)),
        }
    }

    fn hop(&self, i: usize) -> Option<HopInfo> {
        let flow = self.study.machine.flows.get(i)?;
        let to = self.study.machine.thread_of(flow.to);
        Some(HopInfo {
            from: self.funct(flow.from),
            to: self.funct(flow.to),
            thread: self.thread_name(self.study.machine.threads.get(to)?.ix),
            crosses: !self.study.machine.is_inside(flow),
            by: self.carriers(flow),
            delay: delay(self.user.wait(i)),
            better: delay(self.better.wait(i)),
        })
    }

    /// Returns the names of the carriers of a flow, numbers before bits.
    fn carriers(&self, flow: &Flow) -> Vec<String> {
        let graph = self.graph;
        let name = |by: &By| match by {
            By::Signal(ix) | By::Shared(ix) => graph.signal(*ix).map(|s| (s.ty, s.name.as_str())),
            By::Pin(ix) => graph.item(*ix).map(|i| (i.ty, i.shown().as_str())),
            By::Hidden => None,
        };
        let names = flow.by.iter().filter_map(name);
        let mut names: Vec<_> = names.map(|(ty, name)| (ty == Type::Bit, name)).collect();
        names.sort_unstable();
        names.into_iter().map(|(_, name)| name.to_owned()).collect()
    }

    fn funct(&self, i: usize) -> String {
        let ix = self.study.machine.functs.get(i).map(|f| f.ix);
        let funct = ix.and_then(|ix| self.graph.funct(ix));
        funct.map_or_else(String::new, |f| f.name.as_str().to_owned())
    }

    fn thread_name(&self, ix: Ix) -> String {
        let thread = self.graph.thread(ix);
        thread.map_or_else(String::new, |t| t.name.as_str().to_owned())
    }
}

const fn delay(wait: Wait) -> DelayInfo {
    DelayInfo { least: wait.least, most: wait.most }
}
