//! `loadrt`: creates and opens a component, or refuses it with the reason.

pub(crate) mod args;
pub(crate) mod callback;
pub(crate) mod code;
pub(crate) mod create;
pub(crate) mod earlier;
pub(crate) mod elf;
pub(crate) mod foreign;
pub(crate) mod hardware;
pub(crate) mod loader;
pub(crate) mod offer;
pub(crate) mod opening;
pub(crate) mod plugin_file;
pub(crate) mod unload;

use crate::{
    Engine, Error,
    change::undo::Undo,
    ends::{self, Activity, Doing},
    error::loading::Loading,
    graph::Ix,
    load::args::{Args, Declared, Instances},
    load::code::LoadHandle,
    load::create::Creating,
    load::loader::Found,
    name::Name,
};
use hal_abi::{Status, component_flags};
use hal_protocol::Lock;

impl Engine {
    /// `loadrt MODULE ARGS…`.
    pub(crate) fn load(&mut self, module: &str, words: &[String]) -> Result<(), Error> {
        self.model.unlocked(Lock::LOAD, "loading of programs")?;
        let instance = self.runtime.instance().clone();
        let _within = instance.control.run(Doing::new(module, Activity::Load));
        let foreign = self.foreign_files();
        let simulated = self.options.simulate;
        if let Some(found) = self.model.loader().find_only_foreign(module, &foreign, simulated)? {
            return self.load_file(module, words, "", &found);
        }
        let name = Name::parse("component", module)?;
        let exists = self.model.graph().components.contains_key(&name);
        let refused_again = |again| Error::ModuleExists { name: module.into(), again };
        let found = self.model.loader().find(module);
        let found = found.map_err(|e| if exists { refused_again(false) } else { e })?;
        if exists && found.is_once() {
            return Err(refused_again(false));
        }
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
        let personality = found.ty.flags & component_flags::PERSONALITY != 0;
        let also: &[&str] = match (found.is_once(), personality) {
            (true, _) => &[],
            (false, false) => &["count", "names"],
            (false, true) => &["count", "names", "personality"],
        };
        let refused = |e| Loading::of(module, words, e);
        let instances = if found.is_once() {
            Instances { rest: words.to_vec(), ..Instances::default() }
        } else {
            let mut instances = Instances::parse(words, personality).map_err(refused)?;
            // A type that declares its own `names=` keeps it.
            if declared.iter().any(|d| &*d.name == "names") {
                instances.names.clear();
                instances.rest = words.to_vec();
            }
            instances
        };
        if exists && instances.names.is_empty() {
            return Err(refused_again(true));
        }
        let name = if exists { self.model.graph().further_load(module)? } else { name };
        let args = Args::parse(&declared, also, &instances.rest).map_err(refused)?;
        let component = self.model.new_component(name, None, Some(words.join(" ")), true)?;
        self.model.staged_mut().undo_by(Undo::Made(component));
        self.create(component, module, &found, &instances, args)
            .map_err(|e| own_error(module, &declared, words, e))
    }

    fn create(
        &mut self,
        component: Ix,
        module: &str,
        found: &Found,
        instances: &Instances,
        args: Args,
    ) -> Result<(), Error> {
        let id = self.model.graph().component(component).map_or(0, |c| c.id);
        let keep = LoadHandle::new(id, self.runtime.shared().clone(), found.library.clone());
        self.log.listen_to(id, keep.voice().clone());
        let base = module.replace('_', "-");
        let once = found.is_once();
        let count = match instances.names.len() {
            _ if once => 1,
            0 => instances.count.unwrap_or(1),
            n => u32::try_from(n).unwrap_or(u32::MAX),
        };
        let Some(create) = found.ty.create else { return Ok(()) };
        let before = ends::threads();
        self.note_origin(component, ends::maps::file_of(create as *const () as usize));
        let mut creating = Creating::new(self, component, keep, args);
        for index in 0..count {
            let i = index as usize;
            let prefix = match instances.names.get(i) {
                _ if once => base.clone(),
                Some(name) => name.clone(),
                None => format!("{base}.{index}"),
            };
            let personality = instances.personality.get(i).copied().unwrap_or(0);
            creating.next_instance();
            let host = creating.host(&prefix, index, personality, found.private);
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
        self.model.staged_mut().begin_threads(threads);
        // An engine in a dry run is dropped without opening.
        if self.model.staged().is_dry() || self.runtime.is_dry_run() {
            return Ok(());
        }
        // From here on, stop actions cover everything that opening drives.
        if self.model.graph().component(component).is_some_and(|c| !c.stops.is_empty()) {
            self.renew_remains();
        }
        for open in &opens {
            if let Err(e) = open.call(Args::default()) {
                let why = e.to_string().into();
                return Err(Error::OpenFailed { name: module.into(), why });
            }
        }
        self.note_threads(component, &before);
        self.model.staged_mut().undo_by(Undo::Opened(component));
        Ok(())
    }
}

/// Wraps an error of creating the component, with the descriptions of the arguments that the
/// error names, or else of those that were given, or else of all.
fn own_error(component: &str, declared: &[Declared], words: &[String], error: Error) -> Error {
    let why = match &error {
        Error::InitFailed { why, code, .. } if *code == Status::EINVAL.0 => &**why,
        // Arguments do not cause a panic or a missing device.
        Error::InitFailed { .. } | Error::OpenFailed { .. } => return error,
        _ => "",
    };
    let named = |d: &&Declared| {
        let letter = |c: char| c.is_alphanumeric() || c == '_';
        why.split(|c| !letter(c)).any(|word| word == &*d.name)
    };
    let given = |d: &&Declared| {
        let of = |w: &String| w.split_once('=').is_some_and(|(name, _)| name == &*d.name);
        words.iter().any(of)
    };
    let mut about: Vec<&Declared> = declared.iter().filter(named).collect();
    if about.is_empty() {
        about = declared.iter().filter(given).collect();
    }
    if about.is_empty() && !why.is_empty() {
        about = declared.iter().collect();
    }
    let said = about.iter().map(|d| format!("{}=: {}", d.name, d.about()));
    let said = said.collect::<Vec<_>>().join("; ");
    let about = (!said.is_empty()).then(|| said.into());
    match Loading::of(component, words, error) {
        Error::Loading(loading) => Error::Loading(Box::new(Loading { about, ..*loading })),
        other => other,
    }
}
