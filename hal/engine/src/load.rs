//! `loadrt` and `unloadrt`: whole or not at all.

use crate::{
    Engine, Error,
    args::{Args, Declared, Instances},
    change::Change,
    code::Keep,
    create::Creating,
    graph::{Ix, Node},
    loader::Found,
    name::Name,
    sync::Arc,
};
use hal_abi::component_flags;
use hal_protocol::Lock;

impl Engine {
    /// `loadrt MODULE ARGS…`.
    pub(crate) fn load(&mut self, module: &str, words: &[String]) -> Result<(), Error> {
        self.unlocked(Lock::LOAD, "loading of programs")?;
        let name = Name::parse("component", module)?;
        if self.graph.components.contains_key(&name) {
            return Err(Error::ModuleExists { name: module.into() });
        }
        let found = self.loader.find(module)?;
        let mut declared = Vec::new();
        for i in 0..found.ty.args.len() {
            // SAFETY: a list of an open library's descriptor.
            let spec = unsafe { found.ty.args.get(i) }.and_then(|a| Declared::copy(&a));
            declared.push(spec.ok_or_else(|| Error::InitFailed {
                name: module.into(),
                why: "an argument is not well declared".into(),
                code: -22,
            })?);
        }
        let instances = if found.is_once() {
            Instances { rest: words.to_vec(), ..Instances::default() }
        } else {
            let mut instances =
                Instances::parse(words, found.ty.flags & component_flags::PERSONALITY != 0)?;
            // A type with its own `names=` or `num_chan=` keeps them.
            if declared.iter().any(|d| &*d.name == "names") {
                instances.names.clear();
                instances.rest = words.to_vec();
            }
            instances
        };
        let args = Args::parse(&declared, &instances.rest)?;
        let component = self.new_component(name, None, Some(words.join(" ")), true)?;
        let made = self.create(component, module, &found, &instances, args);
        if made.is_err() {
            self.remove_component(component);
            self.reap();
        }
        made
    }

    fn create(
        &mut self,
        component: Ix,
        module: &str,
        found: &Found,
        instances: &Instances,
        args: Args,
    ) -> Result<(), Error> {
        let id = self.graph.component(component).map_or(0, |c| c.id);
        let keep = Keep::new(id, self.shared.clone(), found.library.clone());
        let base = module.replace('_', "-");
        let once = found.is_once();
        let names: Vec<String> = if once {
            vec![base]
        } else if instances.names.is_empty() {
            (0..instances.count.unwrap_or(1)).map(|i| format!("{base}.{i}")).collect()
        } else {
            instances.names.clone()
        };
        let Some(create) = found.ty.create else { return Ok(()) };
        let mut creating = Creating::new(self, component, keep, args);
        for (i, prefix) in names.iter().enumerate() {
            let personality = instances.personality.get(i);
            let index = u32::try_from(i).unwrap_or(u32::MAX);
            let personality = personality.copied().unwrap_or(0);
            let host = creating.host(prefix, index, personality, found.private);
            // SAFETY: a component's code, called with a record that lives across the call.
            let status = unsafe { create(&raw const host) };
            let refused = creating.refused.take();
            if !status.is_ok() {
                let why = creating.failed.take();
                return Err(match (why, refused) {
                    (Some(why), _) => {
                        Error::InitFailed { name: module.into(), why: why.into(), code: status.0 }
                    }
                    (None, Some(e)) => e,
                    (None, None) => Error::InitFailed {
                        name: module.into(),
                        why: format!("it refused ({})", status.0).into(),
                        code: status.0,
                    },
                });
            }
            if let Some(e) = refused {
                return Err(e);
            }
        }
        creating.draw_edges();
        let (opens, threads) =
            (core::mem::take(&mut creating.opens), core::mem::take(&mut creating.threads));
        // A trial is dropped unopened.
        for open in opens.iter().filter(|_| self.trial.is_none()) {
            if let Err(e) = open.call(Args::default()) {
                let why = e.to_string().into();
                return Err(Error::OpenFailed { name: module.into(), why });
            }
        }
        for t in threads {
            self.begin_thread(t)?;
        }
        Ok(())
    }

    /// `unloadrt NAME`.
    pub(crate) fn unload(&mut self, name: &str) -> Result<(), Error> {
        let ix = self
            .graph
            .components
            .get(name)
            .copied()
            .ok_or_else(|| Error::NotLoaded { name: name.into() })?;
        let Some(c) = self.graph.component(ix) else { return Ok(()) };
        if !c.realtime || name.starts_with("__") {
            return Err(Error::NotRealtime { name: name.into() });
        }
        if let Some(user) = self.graph.users(ix).first().and_then(|u| self.graph.component(*u)) {
            let user = user.name.as_str().into();
            return Err(Error::InUseBy { name: name.into(), user });
        }
        self.detach(ix)?;
        // What a stop action says is not a reason to keep the component.
        self.run_stops(&[ix]);
        self.remove_component(ix);
        self.reap();
        Ok(())
    }

    /// `unloadrt all`: newest first.
    pub(crate) fn unload_all(&mut self) -> Result<(), Error> {
        for ix in self.graph.components_by_age().into_iter().rev() {
            let Some(c) = self.graph.component(ix) else { continue };
            if c.realtime && !c.name.as_str().starts_with("__") {
                let name = c.name.clone();
                self.unload(name.as_str())?;
            }
        }
        Ok(())
    }

    /// Everything that a component made, and its threads' pseudo components.
    fn all_owned(&self, component: Ix) -> Vec<Ix> {
        let mut out = Vec::new();
        for ix in self.graph.owned(component) {
            if self.graph.component(ix).is_some() {
                out.extend(self.graph.owned(ix));
            }
            out.push(ix);
        }
        out
    }

    /// Takes a component out of running threads and signals. Nothing has changed when it fails.
    fn detach(&mut self, component: Ix) -> Result<(), Error> {
        let owned = self.all_owned(component);
        let functs: Vec<Ix> =
            owned.iter().copied().filter(|ix| self.graph.funct(*ix).is_some()).collect();
        let pins: Vec<Ix> = owned
            .iter()
            .copied()
            .filter(|ix| self.graph.item(*ix).is_some() && self.graph.signal_of(*ix).is_some())
            .collect();
        let mut threads: Vec<Ix> = functs.iter().flat_map(|f| self.graph.threads_of(*f)).collect();
        threads.sort_unstable();
        threads.dedup();
        let mut change = Change { stores: self.unlinking(&pins), lists: Vec::new() };
        for ix in threads {
            if let Some(t) = self.graph.thread(ix) {
                change.lists.push((t.thread.clone(), Arc::new(self.list_of(ix, &functs))));
            }
        }
        self.carry_out(change)?;
        self.forget_links(&pins);
        let own_threads: Vec<Ix> =
            owned.iter().copied().filter(|ix| self.graph.thread(*ix).is_some()).collect();
        if !own_threads.is_empty() {
            self.end_threads(&own_threads)?;
        }
        if !owned.is_empty() {
            self.stop_watching();
        }
        Ok(())
    }

    /// Removes a component and what it made from the graph; no thread uses it any more.
    pub(crate) fn remove_component(&mut self, component: Ix) {
        if self.graph.component(component).is_none() {
            return;
        }
        if let Err(e) = self.detach(component) {
            self.notice(e.to_string());
            return;
        }
        // What it said is static text in its library, which may close with it.
        self.hear();
        self.tasks.retain(|t| t.owner != component);
        self.rings.retain(|_, r| r.owner != component);
        let gone: Vec<u64> =
            self.tickets.iter().filter(|(_, p)| p.owner == component).map(|(id, _)| *id).collect();
        for id in gone {
            self.tickets.remove(&id);
            let why = "its component was unloaded".to_owned();
            self.finished.insert(id, hal_protocol::TicketInfo::Failed(why));
        }
        for ix in self.all_owned(component) {
            self.remove_node(ix);
        }
        self.remove_node(component);
    }

    fn remove_node(&mut self, ix: Ix) {
        self.graph.sites.forget(ix);
        match self.graph.g.remove_node(ix) {
            Some(Node::Item(item)) => {
                let param = !item.direction.is_pin();
                let slot = item.slot();
                let names = self.graph.names_mut(param);
                names.remove(&item.name);
                for other in [item.other, item.alias].into_iter().flatten() {
                    names.remove(&other);
                }
                if param {
                    self.counts.params -= 1;
                } else {
                    self.counts.pins -= 1;
                }
                if let Some(slot) = slot {
                    self.arena.give_slot(slot);
                }
            }
            Some(Node::Funct(f)) => {
                self.graph.functs.remove(&f.name);
                self.forgive(&f.name);
            }
            Some(Node::Thread(t)) => {
                self.graph.threads.remove(&t.name);
            }
            Some(Node::Component(c)) => {
                self.graph.components.remove(&c.name);
                for command in &c.commands {
                    self.graph.commands.remove(&command.name);
                }
            }
            Some(Node::Signal(_)) | None => {}
        }
    }
}
