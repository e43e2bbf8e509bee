//! Files that are not plugins: found by a symbol, loaded by the plugin that registered for it.

use crate::{
    Engine, Error,
    change::undo::Undo,
    ends::{self, Activity, Doing},
    graph::ptr::Ptr,
    graph::{Component, Edge, Foreign, Ix},
    load::args::Args,
    load::code::LoadHandle,
    load::create::Creating,
    load::loader::ForeignFound,
    name::Name,
    sync::Arc,
};
use core::{ffi::c_void, ptr::NonNull};
use hal_abi::{ForeignFile, ItemSpec, Record, Status, Str, edit, ty};
use hal_protocol::{ForeignPart, Lock, Type};
use std::path::PathBuf;

impl Engine {
    /// `loadrt --c --prefix P MODULE ARGS…`.
    pub(crate) fn load_foreign(
        &mut self,
        module: &str,
        words: &[String],
        prefix: &str,
    ) -> Result<(), Error> {
        self.model.unlocked(Lock::LOAD, "loading of programs")?;
        let instance = self.runtime.instance().clone();
        let _within = instance.control.run(Doing::new(module, Activity::Load));
        let foreign = self.foreign_files();
        let simulated = self.options.simulate;
        let found = self.model.loader().find_foreign(module, &foreign, simulated)?;
        self.load_file(module, words, prefix, &found)
    }

    /// Returns the loaded files that are not plugins, the oldest first.
    pub(crate) fn foreign_files(&self) -> Vec<PathBuf> {
        let components = self.model.graph().components_by_age().into_iter();
        let components =
            components.filter_map(|ix| self.model.graph().component(ix)?.foreign.as_ref());
        components.filter_map(|f| PathBuf::from(&*f.file).canonicalize().ok()).collect()
    }

    /// Loads a file that is not a plugin, completely or not at all.
    pub(crate) fn load_file(
        &mut self,
        module: &str,
        words: &[String],
        prefix: &str,
        found: &ForeignFound,
    ) -> Result<(), Error> {
        let name = Name::parse("component", &format!("{prefix}{module}"))?;
        if self.model.graph().components.contains_key(&name) {
            return Err(Error::ModuleExists { name: name.as_str().into(), again: false });
        }
        if self.model.staged().is_dry() {
            let why = "it touches its devices as it is loaded, so that cannot be tried".into();
            return Err(Error::InitFailed { name: module.into(), why, code: Status::EBUSY.0 });
        }
        let component = self.model.new_component(name, None, Some(words.join(" ")), true)?;
        self.model.staged_mut().undo_by(Undo::Made(component));
        let file = found.file.canonicalize().ok();
        self.note_origin(component, file.and_then(|f| Some(f.to_str()?.into())));
        let before = ends::threads();
        let made = self.create_foreign(component, (module, prefix), words, found);
        self.note_threads(component, &before);
        // Log the component's messages before the result of the load.
        self.drain_messages();
        self.renew_remains();
        made
    }

    fn create_foreign(
        &mut self,
        component: Ix,
        (module, prefix): (&str, &str),
        words: &[String],
        found: &ForeignFound,
    ) -> Result<(), Error> {
        let id = self.model.graph().component(component).map_or(0, |c| c.id);
        let keep = LoadHandle::new(id, self.runtime.shared().clone(), found.library.clone());
        self.log.listen_to(id, keep.voice().clone());
        let path = found.file.display().to_string();
        if let Some(c) = self.model.component_mut(component) {
            c.foreign = Some(Foreign {
                kind: found.kind.as_str().into(),
                module: module.into(),
                prefix: prefix.into(),
                file: path.as_str().into(),
                doc: "".into(),
                keep: keep.clone(),
            });
        }
        let shared = self.runtime.shared().clone();
        let shown: Vec<Str> = words.iter().map(|w| Str::borrow(w)).collect();
        let mut creating = Creating::new(self, component, keep, Args::default());
        let host = creating.host(module, 0, 0, true);
        let file = ForeignFile {
            size: hal_abi::size::<ForeignFile>(),
            component: id,
            instance: Arc::as_ptr(&shared).cast(),
            path: Str::borrow(&path),
            name: Str::borrow(module),
            prefix: Str::borrow(prefix),
            words: shown.as_ptr(),
            n_words: shown.len(),
            item: Some(item),
            rename: Some(rename),
            need: Some(need),
            edit: Some(edit_graph),
            say: Some(crate::load::code::say),
            level: Some(crate::load::code::level),
            account: Some(crate::load::code::account),
            join: Some(join),
            describe: Some(describe),
        };
        // SAFETY: the loader's code, called with records that live across the call.
        let status = unsafe { (found.load)(&raw const host, &raw const file) };
        if !status.is_ok() {
            let refused = creating.refused.take().map(|e| e.to_string());
            let why = creating.failed.take().or(refused);
            let why = why.unwrap_or_else(|| format!("it refused ({})", status.0));
            return Err(Error::InitFailed { name: module.into(), why: why.into(), code: status.0 });
        }
        let threads = core::mem::take(&mut creating.threads);
        self.model.staged_mut().begin_threads(threads);
        self.model.staged_mut().undo_by(Undo::Opened(component));
        Ok(())
    }
}

impl Creating<'_> {
    fn component_of(&self, number: u32) -> Option<Ix> {
        let g = self.engine.model.graph();
        g.components.values().copied().find(|ix| g.component(*ix).is_some_and(|c| c.id == number))
    }

    fn foreign_item(
        &mut self,
        spec: &ItemSpec,
        owner: u32,
        place: *mut *mut c_void,
    ) -> Result<(), Error> {
        let owner = self.component_of(owner).unwrap_or(self.component);
        let pointer = NonNull::new(place.cast());
        let (ix, slot) = self.item_of(spec, owner)?;
        if let (Some(pointer), Some(slot)) = (pointer, slot) {
            let pointer = Ptr(pointer);
            let cell = crate::graph::ptr::own_cell(Ptr(slot));
            crate::change::stores::point(pointer, cell);
            self.engine.model.set_pointer(ix, pointer);
        }
        Ok(())
    }

    fn rename(&mut self, name: &str) -> Result<(), Error> {
        let name = Name::parse("component", name)?;
        self.engine.model.rename(self.component, name.clone())?;
        let component = self.engine.model.component_mut(self.component);
        if let Some(origin) = component.and_then(|c| c.origin.as_mut()) {
            origin.component = name;
        }
        Ok(())
    }

    /// Creates a further component of the file, which is removed with the first.
    fn join(&mut self, name: &str) -> Result<u32, Error> {
        let name = Name::parse("component", name)?;
        let joined = self.engine.model.new_component(name, None, None, true)?;
        self.engine.model.connect(self.component, joined, Edge::Owns);
        Ok(self.engine.model.graph().component(joined).map_or(0, |c| c.id))
    }

    fn describe(&mut self, doc: &str) {
        let component = self.engine.model.component_mut(self.component);
        if let Some(foreign) = component.and_then(|c| c.foreign.as_mut()) {
            foreign.doc = doc.into();
        }
    }

    fn need(&mut self, number: u32) -> Result<(), Error> {
        if let Some(provider) = self.component_of(number).filter(|ix| *ix != self.component) {
            self.engine.model.connect(self.component, provider, Edge::Needs);
        }
        Ok(())
    }

    fn edit(&mut self, what: u32, a: &str, b: &str, number: i64) -> Result<(), Error> {
        let e = &mut *self.engine;
        let code = u8::try_from(number).unwrap_or_default();
        match what {
            edit::NEW_SIGNAL => {
                let ty = Type::from_code(code).filter(|_| code <= ty::U64);
                e.model.new_signal(a, ty.unwrap_or(Type::Bit)).map(drop)
            }
            edit::DELETE_SIGNAL => e.model.delete_signal(a),
            edit::LINK => e.model.link(a, b),
            edit::UNLINK => e.model.unlink(a),
            edit::ADD | edit::ADD_INIT => e.model.add_funct(a, b, number, what == edit::ADD_INIT),
            edit::REMOVE => e.model.remove_funct(a, Some(b)),
            edit::START => e.start_threads(),
            edit::STOP => e.runtime.stop_by_command(),
            edit::ALIAS_PIN | edit::ALIAS_PARAM => {
                let param = what == edit::ALIAS_PARAM;
                if b.is_empty() { e.model.unalias(param, a) } else { e.model.alias(param, a, b) }
            }
            edit::SET => e.model.set_item(a, b),
            edit::LOCK => {
                e.model.set_lock(Lock(code));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Keeps the error of a refused declaration, for the result of the load. A plugin's load ends with its first one; a
    /// file that is not a plugin may go on after that, so that its last one counts, and earlier ones are logged.
    pub(crate) fn keep_refusal(&mut self, error: Error) {
        let component = self.engine.model.graph().component(self.component);
        if component.is_none_or(|c| c.foreign.is_none()) {
            self.refused.get_or_insert(error);
        } else if let Some(earlier) = self.refused.replace(error) {
            self.log_refusal(&earlier);
        }
    }

    fn log_refusal(&mut self, error: &Error) {
        let by = self.engine.model.graph().component(self.component);
        let by = by.map_or_else(String::new, |c| c.name.as_str().to_owned());
        self.engine.drain_messages();
        self.engine.notice(format!("{by}: {error}"));
    }

    /// Does the same as [`Self::answer`], but logs the error at once, since the file may continue
    /// after it.
    fn answer_said(&mut self, result: Result<(), Error>) -> Status {
        match result {
            Ok(()) => Status::OK,
            Err(e) => {
                let status = Status(e.errno());
                self.log_refusal(&e);
                status
            }
        }
    }
}

fn creating<'c>(ctx: *mut c_void) -> &'c mut Creating<'c> {
    // SAFETY: the `Creating` of the load in progress; loaders call back on this thread only.
    unsafe { &mut *ctx.cast::<Creating<'c>>() }
}

/// # Safety
/// Called by a loader while it loads, with the context and records of that call.
unsafe extern "C" fn item(
    ctx: *mut c_void,
    spec: *const ItemSpec,
    owner: u32,
    place: *mut *mut c_void,
) -> Status {
    let c = creating(ctx);
    // SAFETY: the loader's record lives across its call.
    let Some(spec) = (unsafe { ItemSpec::read(spec) }) else { return Status::EINVAL };
    let made = c.foreign_item(&spec, owner, place);
    c.answer_said(made)
}

/// # Safety
/// Called by a loader while it loads, with the context of that call and a live text.
unsafe extern "C" fn rename(ctx: *mut c_void, name: Str) -> Status {
    let c = creating(ctx);
    // SAFETY: the loader's text lives across its call.
    let Some(name) = (unsafe { name.get() }) else { return Status::EINVAL };
    let renamed = c.rename(name);
    c.answer_said(renamed)
}

/// # Safety
/// Called by a loader while it loads, with the context of that call, a live text and memory for a number.
unsafe extern "C" fn join(ctx: *mut c_void, name: Str, id: *mut u32) -> Status {
    let c = creating(ctx);
    // SAFETY: the loader's text lives across its call.
    let Some(name) = (unsafe { name.get() }) else { return Status::EINVAL };
    let joined = c.join(name).map(|number| {
        // SAFETY: guaranteed by the loader.
        unsafe { id.write(number) };
    });
    c.answer_said(joined)
}

/// # Safety
/// Called by a loader while it loads, with the context of that call and a live text.
unsafe extern "C" fn describe(ctx: *mut c_void, doc: Str) -> Status {
    // SAFETY: the loader's text lives across its call.
    let Some(doc) = (unsafe { doc.get() }) else { return Status::EINVAL };
    creating(ctx).describe(doc);
    Status::OK
}

/// # Safety
/// Called by a loader while it loads, with the context of that call.
unsafe extern "C" fn need(ctx: *mut c_void, number: u32) -> Status {
    let c = creating(ctx);
    let needed = c.need(number);
    c.answer_said(needed)
}

/// # Safety
/// Called by a loader while it loads, with the context of that call and live texts.
unsafe extern "C" fn edit_graph(
    ctx: *mut c_void,
    what: u32,
    a: Str,
    b: Str,
    number: i64,
) -> Status {
    let c = creating(ctx);
    // SAFETY: the loader's text lives across its call.
    let Some(a) = (unsafe { a.get() }) else { return Status::EINVAL };
    // SAFETY: as above.
    let Some(b) = (unsafe { b.get() }) else { return Status::EINVAL };
    let done = c.edit(what, a, b, number);
    c.answer_said(done)
}

impl Engine {
    /// Lists the loaded components that are not plugins, the oldest first.
    pub(crate) fn foreign_parts(&self) -> Vec<ForeignPart> {
        let components = self.model.graph().components_by_age().into_iter();
        let components = components.filter_map(|ix| self.model.graph().component(ix));
        components
            .filter_map(|c| {
                let f = c.foreign.as_ref()?;
                let (component, kind) = (c.name.as_str().to_owned(), f.kind.to_string());
                Some(ForeignPart { component, kind, memory: f.keep.memory() })
            })
            .collect()
    }
}

impl Component {
    /// Returns the description for the protocol.
    pub(crate) fn foreign_info(&self) -> Option<hal_protocol::ForeignInfo> {
        self.foreign.as_ref().map(|f| hal_protocol::ForeignInfo {
            kind: f.kind.to_string(),
            module: f.module.to_string(),
            prefix: f.prefix.to_string(),
            file: f.file.to_string(),
            memory: f.keep.memory(),
            doc: f.doc.to_string(),
        })
    }
}
