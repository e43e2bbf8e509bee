//! `loadrt`: a component is created and opened.

use crate::{
    Engine, Error,
    args::{Args, Declared, Instances},
    code::Keep,
    create::Creating,
    graph::Ix,
    loader::Found,
    name::Name,
    undo::Undo,
};
use hal_abi::component_flags;
use hal_protocol::Lock;

impl Engine {
    /// `loadrt MODULE ARGS…`.
    pub(crate) fn load(&mut self, module: &str, words: &[String]) -> Result<(), Error> {
        self.unlocked(Lock::LOAD, "loading of programs")?;
        if let Some(found) = self.loader.find_only_foreign(module)? {
            return self.load_file(module, words, "", &found);
        }
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
        self.staged.undo_by(Undo::Made(component));
        self.create(component, module, &found, &instances, args)
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
        self.staged.begins.extend(threads);
        // A trial is dropped unopened.
        if self.staged.dry || self.trial.is_some() {
            return Ok(());
        }
        for open in &opens {
            if let Err(e) = open.call(Args::default()) {
                let why = e.to_string().into();
                return Err(Error::OpenFailed { name: module.into(), why });
            }
        }
        self.staged.undo_by(Undo::Opened(component));
        self.renew_stops();
        Ok(())
    }
}
