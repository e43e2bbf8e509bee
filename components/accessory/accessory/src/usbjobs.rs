//! `usbjobs`.

use crate::{
    programs_folder::{MAX_FILES, ProgramsFolder},
    usb_orders::{self, Inbox, UsbOrder},
};
use hal_component::{
    Arg, Builder, Clock, Component, Error, In, Messages, Out, Texts, TicketHandle, Touch, Work,
    abi::{ArgSpec, component_flags},
};
use hal_storage::{
    Configfs, Folder, Gadget, NotEjected, Phase, Rules, Side, Storage, StorageError, StorageEvent,
    folder::read_bounded,
    ledger::StoredJob,
    name::is_same,
    safe_name,
    storage::{MOST_BYTES, MOST_WAITING},
};
use std::{
    io,
    path::{Path, PathBuf},
};

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 10_000_000;
/// Largest number of steps in a period: each is one file of an image.
const ITEMS: u32 = 8;
/// Largest number of different messages.
const MESSAGES: usize = 2000;

/// `loadrt usbjobs`.
pub(crate) struct UsbJobs;

impl Component for UsbJobs {
    const NAME: &'static str = "usbjobs";
    const DOC: &'static str = "\
Jobs for a controller that only takes a USB medium: two disk images, of which the controller sees one.

A job that is sent (`usbjobs.send file=PATH`) waits in the folder. The other image then gets all files of the presented one and
all jobs that wait, is read back, and takes its place. The image is changed only while `idle` is TRUE, which says that the
controller runs no job. If the host holds the medium nevertheless, it is asked for 5 s; then it is taken by force if `force=1`
permits that, and otherwise waited for.

`state`: 0 serving; 1 the other image is written; 2 the other image is complete, and the host is to let go of this one; 3 no
image is presented, and one is about to be. After a failure the presented image stays, `failed` is TRUE, the jobs still
wait, and a new job or `usbjobs.retry` goes on.

Above 80 % of an image the oldest jobs that are marked as finished (`usbjobs.finish job=NAME`) are left out. Files of the same name,
in capitals or not, are replaced. A job has 1 byte to 16 MiB; at most 64 wait. A name has at most 64 characters; those
that are no ASCII letters, digits, blanks or `._-+()` become underscores.

The folder must exist. It holds `a.img` and `b.img` (FAT32, sparse), `state` (the presented image and the ages of its jobs; replaced as a whole) and
`waiting`. After a power cut the image that `state` names is presented, and jobs that waited wait again. Without `folder`
there is no storage, and the commands are refused.

`programs=PATH` names a folder whose files are jobs, such as the programs of `halpanel`, to which a browser uploads: a file that
appears there or changes is sent when two looks, a second apart, find it equal. Files that are there at the first look are sent
unless the image has a job of their name. Those for which there is no room have their turn after a swap; one that
fails is reported once, and tried again. Names that begin with a dot, and files beyond the first 1024 by their names, are left out.

With `function=PATH`, the folder of a function `mass_storage` of the kernel's USB gadgets (configfs, such as
`/sys/kernel/config/usb_gadget/g1/functions/mass_storage.0`), the host is a real one, and the medium is read-only for it. Otherwise,
on the virtual clock and with `--simulate`, it is simulated: the pin `medium` is the cable, and `busy` says that the host
holds the medium.

# Example

```hal
loadrt usbjobs
start
run 100ms
getp usbjobs.medium # -> 0
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::text("folder", "Folder of the images, of the state and of the jobs that wait.")
            .or(""),
        &Arg::text("function", "Folder of the USB function in configfs.").or(""),
        &Arg::text("programs", "Folder whose files are jobs.").or(""),
        &Arg::int("size", "Size of each new image; one that is there keeps its own.")
            .or("64")
            .within(36.0, 32_768.0)
            .unit("MiB"),
        &Arg::bit("force", "TRUE permits that the medium is taken from a host that holds it.")
            .or("0"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let folder = b.arg_text("folder").filter(|path| !path.is_empty());
        let function = b.arg_text("function").filter(|path| !path.is_empty() && !b.is_simulated());
        let mebibytes = b.arg_int("size").and_then(|n| u64::try_from(n).ok()).unwrap_or(64);
        let may_force = b.arg_int("force").unwrap_or(0) != 0;
        let rules = Rules { size: mebibytes << 20, may_force };
        let inbox = Inbox::default();
        usb_orders::declare(b, &inbox, folder.is_some())?;
        if let Some(folder) = folder {
            let opened = inbox.clone();
            b.on_open(move |_| {
                let made =
                    open(Path::new(&folder), function.as_deref(), rules).map_err(Error::new)?;
                opened.lock().opened = Some(made);
                Ok(())
            })?;
        }
        let programs = b.arg_text("programs").filter(|path| !path.is_empty());
        let worker = UsbWorker {
            programs: programs.map(|path| ProgramsFolder::new(Path::new(&path))),
            idle: b.item("usbjobs.idle", "TRUE while the controller runs no job.", false)?,
            busy: b.item(
                "usbjobs.busy",
                "TRUE while the simulated host holds the medium.",
                false,
            )?,
            medium: b.item(
                "usbjobs.medium",
                "Presented image: 0 none, 1 image A, 2 image B.",
                0,
            )?,
            state: b.item("usbjobs.state", "0 serving, 1 prepare, 2 eject, 3 present.", 0)?,
            waiting: b.item("usbjobs.waiting", "Number of jobs that wait.", 0)?,
            swaps: b.item("usbjobs.swaps", "Number of images that were presented.", 0)?,
            failed: b.item(
                "usbjobs.failed",
                "TRUE after a failure, until something is tried again.",
                false,
            )?,
            inbox,
            storage: None,
            device: Device::Simulated(None, false),
            texts: Texts::new(MESSAGES),
            last_error: String::new(),
            clock: b.clock(),
            messages: b.messages(),
        };
        b.worker("usbjobs", "Writes the images, and presents them.", PERIOD_NS, ITEMS, worker)
    }
}

/// USB device.
pub(crate) enum Device {
    /// The presented image, and whether the host holds it.
    Simulated(Option<Side>, bool),
    Real(Configfs),
}

impl Gadget for Device {
    fn present(&mut self, side: Side) -> io::Result<()> {
        match self {
            Self::Simulated(shown, _) => {
                *shown = Some(side);
                Ok(())
            }
            Self::Real(device) => device.present(side),
        }
    }

    fn eject(&mut self) -> Result<(), NotEjected> {
        match self {
            Self::Simulated(_, true) => Err(NotEjected::Busy),
            Self::Simulated(shown, false) => {
                *shown = None;
                Ok(())
            }
            Self::Real(device) => device.eject(),
        }
    }

    fn force_eject(&mut self) -> io::Result<()> {
        match self {
            Self::Simulated(shown, _) => {
                *shown = None;
                Ok(())
            }
            Self::Real(device) => device.force_eject(),
        }
    }
}

/// Opens the storage and its device.
fn open(folder: &Path, function: Option<&str>, rules: Rules) -> Result<Opened, String> {
    let place = |text: String| format!("folder {}: {text}", folder.display());
    let bay = Folder::new(folder, rules.size)
        .map_err(|e| place(format!("{e}: must be a folder that exists")))?;
    let device = match function {
        None => Device::Simulated(None, false),
        Some(function) => {
            let whole = |side| std::path::absolute(bay.image_path(side));
            let images: Result<[PathBuf; 2], io::Error> =
                whole(Side::A).and_then(|a| Ok([a, whole(Side::B)?]));
            let made = images.and_then(|images| Configfs::new(Path::new(function), images));
            Device::Real(made.map_err(|e| format!("function {function}: {e}"))?)
        }
    };
    let storage = Storage::open(bay, rules).map_err(|why| place(why.to_string()))?;
    Ok(Opened { storage, device })
}

/// Storage that has been opened, with its device.
pub(crate) struct Opened {
    storage: Storage<Folder>,
    device: Device,
}

/// Worker of the storage.
#[derive(Touch)]
struct UsbWorker {
    idle: In<bool>,
    busy: In<bool>,
    medium: Out<i32>,
    state: Out<u32>,
    waiting: Out<u32>,
    swaps: Out<u32>,
    failed: Out<bool>,
    #[state]
    inbox: Inbox,
    #[state]
    storage: Option<Storage<Folder>>,
    #[state]
    device: Device,
    #[state]
    programs: Option<ProgramsFolder>,
    #[state]
    texts: Texts,
    #[state]
    last_error: String,
    clock: Clock,
    messages: Messages,
}

impl Work for UsbWorker {
    fn work(&mut self, items: u32) -> u32 {
        let orders = {
            let mut inbox = self.inbox.lock();
            if let Some(opened) = inbox.opened.take() {
                (self.storage, self.device) = (Some(opened.storage), opened.device);
            }
            core::mem::take(&mut inbox.orders)
        };
        let Some(mut storage) = self.storage.take() else { return 0 };
        for (order, ticket) in orders {
            self.order(&mut storage, order, ticket);
        }
        if let Device::Simulated(_, is_busy) = &mut self.device {
            *is_busy = self.busy.get();
        }
        let now = self.clock.now_ns() as f64 * 1e-9;
        self.upload(&mut storage, now);
        let mut done = 0;
        while done < items && storage.step(&mut self.device, now, self.idle.get()) {
            done += 1;
        }
        while let Some(event) = storage.event() {
            self.report(event);
        }
        self.show(&storage);
        self.storage = Some(storage);
        done
    }
}

impl UsbWorker {
    fn order(&mut self, storage: &mut Storage<Folder>, order: UsbOrder, ticket: TicketHandle) {
        let result = match order {
            UsbOrder::Send { path, name } => {
                let read = read_bounded(Path::new(&path), MOST_BYTES);
                match read {
                    Ok(bytes) => storage.send(&name, &bytes).map(drop),
                    Err(e) => Err(StorageError::Keeping(format!("file {path}").into(), e)),
                }
            }
            UsbOrder::Cancel(name) => storage.cancel(&name),
            UsbOrder::Finish(name) => storage.finish(&name),
            UsbOrder::Retry => {
                storage.retry();
                Ok(())
            }
        };
        match result {
            Ok(()) => ticket.done(),
            Err(why) => ticket.fail(self.texts.keep(&why.to_string())),
        }
    }

    /// Sends the files of the folder of programs that are new.
    fn upload(&mut self, storage: &mut Storage<Folder>, now: f64) {
        let Some(mut programs) = self.programs.take() else { return };
        let look = programs.look(now, |name| {
            let safe = safe_name(name);
            safe.is_ok_and(|safe| storage.ledger().job(&safe).is_some())
        });
        let failed = look.failed.map(|e| StorageError::Keeping("the folder of programs".into(), e));
        self.events(failed.into_iter());
        if look.is_crowded {
            self.messages.error(
                "the folder of programs has more than {} files: only the first by their names are jobs",
                &[MAX_FILES as f64],
            );
        }
        for name in look.changed {
            // Files beyond those that can wait have their turn after a swap.
            let room = storage.waiting().len() < MOST_WAITING;
            let safe = safe_name(&name).unwrap_or_default();
            let waits = storage.waiting().iter().any(|other| is_same(other, &safe));
            if !room && !waits {
                continue;
            }
            let read = read_bounded(&programs.file(&name), MOST_BYTES);
            let sent = match read {
                Ok(bytes) => storage.send(&name, &bytes).map(drop),
                Err(e) => Err(StorageError::Keeping(format!("file {name}").into(), e)),
            };
            if programs.note(&name, sent.is_ok()) {
                self.events(sent.err().into_iter());
            }
        }
        self.programs = Some(programs);
    }

    fn events(&mut self, failures: impl Iterator<Item = StorageError>) {
        failures.for_each(|why| self.report(StorageEvent::Failed(why)));
    }

    fn report(&mut self, event: StorageEvent) {
        match event {
            StorageEvent::Presented(side) => {
                self.swaps.set(self.swaps.get().wrapping_add(1));
                let text = self.texts.keep(&format!("image {side} is presented"));
                self.messages.info(text, &[]);
            }
            StorageEvent::Deleted(name) => {
                let text = format!("the image was full: job '{name}' was finished, and is deleted");
                self.messages.info(self.texts.keep(&text), &[]);
            }
            StorageEvent::Forced(side) => {
                let text = format!("image {side} was taken from a host that held it");
                self.messages.warn(self.texts.keep(&text), &[]);
            }
            StorageEvent::Failed(why) => {
                self.last_error = why.to_string();
                let text = self.texts.keep(&self.last_error);
                self.messages.error(text, &[]);
            }
        }
    }

    fn show(&mut self, storage: &Storage<Folder>) {
        let side = match &self.device {
            Device::Simulated(side, _) => *side,
            Device::Real(_) => storage.presented(),
        };
        self.medium.set(match side {
            None => 0,
            Some(Side::A) => 1,
            Some(Side::B) => 2,
        });
        let phase = storage.phase();
        self.state.set(match phase {
            Phase::Serving => 0,
            Phase::Preparing => 1,
            Phase::Ejecting => 2,
            Phase::Presenting => 3,
        });
        let waiting = storage.waiting().len();
        self.waiting.set(u32::try_from(waiting).unwrap_or(u32::MAX));
        self.failed.set(storage.is_paused());
        let mut lines = vec![format!("{} image {}", name(phase), storage.ledger().presented)];
        let job = |StoredJob { name, is_finished, .. }: &StoredJob| {
            format!("{} {name}", if *is_finished { "finished" } else { "ready" })
        };
        lines.extend(storage.ledger().jobs.iter().map(job));
        lines.extend(storage.waiting().iter().map(|name| format!("waiting {name}")));
        if storage.is_paused() {
            lines.push(format!("failed: {}", self.last_error));
        }
        let mut inbox = self.inbox.lock();
        if inbox.status != lines {
            inbox.status = lines;
        }
    }
}

const fn name(phase: Phase) -> &'static str {
    match phase {
        Phase::Serving => "serving",
        Phase::Preparing => "prepare, serving",
        Phase::Ejecting => "eject",
        Phase::Presenting => "present",
    }
}
