//! Component `hal_input`.

use crate::{
    bus::{Abilities, Bus, FoundDevice, HeldState, Identity, InputDevice},
    described::{self, Described, Wheels},
    kernel::Kernel,
    pins::{self, DevicePins},
    reader::DeviceReader,
    refused::{Refused, Unusable},
    show::{Show, ShownDevice},
    simulated::{SimPins, SimulatedBus},
    spec::{Choice, DeviceSpec, MOST_DEVICES},
    worker::{DeviceTexts, Lit, PERIOD_NS, ReadDevice, WantedDevice, Worker},
};
use hal_component::{
    Arg, Builder, Component, Error, StillWatch, Texts,
    abi::{ArgSpec, component_flags},
};
use std::{io, path::Path, sync::atomic::AtomicU32};

/// Component `hal_input`.
pub(crate) enum HalInput {}

/// Period of the background task, in nanoseconds, as in LinuxCNC.
const TASK_NS: i64 = 10_000_000;

impl Component for HalInput {
    const NAME: &'static str = "hal_input";
    const DOC: &'static str = include_str!("hal_input.md");
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[
        &Arg::texts("devices", "Devices, such as Gamepad or \"-KA Gamepad,-L AT Keyboard\".")
            .at_most(MOST_DEVICES),
        &Arg::text("describe", "File that describes further devices."),
        &Arg::bit("task", "TRUE sets the pins every 10 ms in the background, without a function.")
            .or("FALSE"),
    ];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let specs = specs(&b.arg_texts("devices")).map_err(refuse)?;
        let described = descriptions(b.arg_text("describe")).map_err(refuse)?;
        if b.is_simulated() || b.is_trial() {
            simulate(b, &specs, &described)
        } else {
            open(b, specs, &described, Kernel::default())
        }
    }
}

fn refuse(why: Refused) -> Error {
    Error::new(why.to_string())
}

/// Specification with its text.
type AskedDevice = (String, DeviceSpec);

fn specs(words: &[String]) -> Result<Vec<AskedDevice>, Refused> {
    if words.is_empty() {
        return Err(Refused::Nothing);
    }
    let spec = |word: &String| {
        let spec = DeviceSpec::parse(word);
        let spec = spec.map_err(|why| Refused::Spec { word: word.clone(), why })?;
        Ok((word.clone(), spec))
    };
    words.iter().map(spec).collect()
}

/// Largest size of a file of descriptions, in bytes.
const MOST_BYTES: u64 = 1 << 20;

/// Returns the devices of the user's file, then those that come with the driver.
fn descriptions(path: Option<String>) -> Result<Vec<Described>, Refused> {
    let mut all = Vec::new();
    if let Some(path) = path {
        let text = hal_ini::file::contents(Path::new(&path), MOST_BYTES);
        let text = text.and_then(|t| t.ok_or_else(|| io::Error::other("it is larger than 1 MiB")));
        let text = text.map_err(|why| Refused::File { path: path.clone(), why })?;
        let parsed = described::parse(&String::from_utf8_lossy(&text));
        all = parsed.map_err(|why| Refused::Line { path, why })?;
    }
    all.extend(described::known());
    Ok(all)
}

/// Device that was opened for a specification.
struct OpenedDevice {
    wanted: WantedDevice,
    device: Box<dyn InputDevice>,
    held: HeldState,
    wheels: Wheels,
}

/// Opens the devices of a bus and declares their pins.
pub(crate) fn open(
    b: &mut Builder<'_>,
    specs: Vec<AskedDevice>,
    described: &[Described],
    bus: impl Bus + 'static,
) -> Result<(), Error> {
    let there = bus.devices();
    let mut opened: Vec<OpenedDevice> = Vec::new();
    for (word, spec) in specs {
        let found = match &spec.choice {
            Choice::Path(path) => {
                bus.number_of(path).and_then(|n| there.iter().find(|device| device.number == n))
            }
            _ => spec.find(&there),
        };
        let missing = || Refused::Missing { word, there: there.clone() };
        let found = found.ok_or_else(missing).map_err(refuse)?;
        let same = opened.iter().position(|other| other.wanted.number == found.number);
        let group = same.unwrap_or(opened.len());
        let FoundDevice { number, identity } = found;
        let abilities = |has: &Abilities| pins::chosen(has, spec.features);
        let device = open_one(
            &bus,
            found,
            spec.is_exclusive,
            group,
            wheels_of(described, identity),
            abilities,
        );
        let refused =
            |why| refuse(Refused::Device { number: *number, name: identity.name.clone(), why });
        opened.push(device.map_err(refused)?);
    }
    declare(b, opened, Box::new(bus), Vec::new())
}

/// Returns what the wheels of a device mean: those of the description with its name, or else with its numbers, because other
/// systems and firmware name a device differently.
fn wheels_of(described: &[Described], identity: &Identity) -> Wheels {
    let numbers = |of: &Identity| (of.vendor, of.product);
    let is_named = |d: &&Described| d.identity.is_same_make(identity);
    let is_numbered =
        |d: &&Described| numbers(identity) != (0, 0) && numbers(&d.identity) == numbers(identity);
    let found = described.iter().find(is_named).or_else(|| described.iter().find(is_numbered));
    found.map(|d| d.wheels).unwrap_or_default()
}

/// Opens a device; `chosen` returns the abilities that have pins.
fn open_one(
    bus: &dyn Bus,
    found: &FoundDevice,
    is_exclusive: bool,
    group: usize,
    wheels: Wheels,
    chosen: impl Fn(&Abilities) -> Abilities,
) -> Result<OpenedDevice, Unusable> {
    let unusable = |lost| Unusable::new(lost, is_exclusive);
    let mut device = bus.open(found, is_exclusive).map_err(unusable)?;
    let abilities = chosen(&device.abilities().map_err(unusable)?);
    let held = device.state().map_err(unusable)?;
    let FoundDevice { number, identity } = found.clone();
    let wanted = WantedDevice { number, group, identity, abilities, is_exclusive };
    Ok(OpenedDevice { wanted, device, held, wheels })
}

/// Makes a simulated device for each specification.
fn simulate(
    b: &mut Builder<'_>,
    specs: &[AskedDevice],
    described: &[Described],
) -> Result<(), Error> {
    let mut bus = SimulatedBus::default();
    for (at, (word, spec)) in specs.iter().enumerate() {
        let found = described_for(spec, described);
        let mut device = found.cloned().unwrap_or_else(described::everything);
        if found.is_none() && !b.is_trial() {
            let word = word.escape_debug();
            let text = format!(
                "nothing describes the input device '{word}': it is simulated with all keys, axes and \
                 lights; describe= names a file that describes it"
            );
            b.messages().notice(Texts::new(1).keep(&text), &[]);
        }
        device.identity.phys = format!("simulated/input{at}");
        device.abilities = pins::chosen(&device.abilities, spec.features);
        let pins = SimPins::make(b, &format!("input.{at}"), &device.abilities)?;
        bus.devices.push((device, pins));
    }
    let mut opened = Vec::new();
    for (found, (device, _)) in bus.devices().iter().zip(&bus.devices) {
        let one = open_one(&bus, found, false, opened.len(), device.wheels, Abilities::clone);
        let name = || found.identity.name.clone();
        let refused = |why| refuse(Refused::Device { number: found.number, name: name(), why });
        opened.push(one.map_err(refused)?);
    }
    let pins = bus.devices.iter().map(|(_, pins)| pins.clone()).collect();
    declare(b, opened, Box::new(bus), pins)
}

/// Numbers below this one mean a node in simulation, which has none; others are a part of a name.
const MOST_NODES: u32 = 100;

/// Returns the description of the device that a specification means.
fn described_for<'d>(spec: &DeviceSpec, described: &'d [Described]) -> Option<&'d Described> {
    if matches!(spec.choice, Choice::Path(_) | Choice::Number(..MOST_NODES, _)) {
        return None;
    }
    // Descriptions have no nodes: their numbers are none that a word has.
    let numbers = (0..u32::MAX).rev();
    let there: Vec<FoundDevice> = numbers
        .zip(described)
        .map(|(number, d)| FoundDevice { number, identity: d.identity.clone() })
        .collect();
    // Of devices that match, a description stands for each.
    let all = DeviceSpec { nth: 0, ..spec.clone() };
    let found = spec.find(&there).or_else(|| all.find(&there))?;
    described.get(there.iter().position(|device| device.number == found.number)?)
}

fn declare(
    b: &mut Builder<'_>,
    opened: Vec<OpenedDevice>,
    bus: Box<dyn Bus>,
    simulated: Vec<SimPins>,
) -> Result<(), Error> {
    let (mut shown, mut read) = (Vec::new(), Vec::new());
    let is_task = b.arg_int("task") == Some(1);
    for (at, OpenedDevice { wanted, device, held, wheels }) in opened.into_iter().enumerate() {
        let pins = DevicePins::make(b, &format!("input.{at}"), &wanted.abilities, &wheels)?;
        let mut reader = DeviceReader::new(wheels);
        reader.open(&held);
        let (writer, record) = b.seqlock(*reader.record());
        let (gives, lights) = b.shared(AtomicU32::new(0));
        // The task runs from now on; a function runs when its thread does.
        let since = is_task.then_some(reader.record());
        shown.push(ShownDevice::new(pins, record, gives, b.hardware(), since));
        read.push(ReadDevice {
            record: writer,
            lights,
            reader,
            device: Some(device),
            texts: texts(at, &wanted),
            wanted,
            lit: Lit::default(),
            refusals: 0,
        });
    }
    let (gives, steps) = b.shared(AtomicU32::new(0));
    let worker = Worker {
        devices: read,
        simulated,
        steps: gives,
        clock: b.clock(),
        messages: b.messages(),
        bus,
        looked: None,
    };
    b.worker("hal_input", "Reads the devices", PERIOD_NS, 1, worker)?;
    let show = Show {
        devices: shown,
        steps,
        clock: b.clock(),
        messages: b.messages(),
        worker: StillWatch::new(),
        is_dead: false,
    };
    if is_task {
        b.task("hal_input", "Sets the pins of the devices", TASK_NS, show)
    } else {
        b.function("hal_input", "Sets the pins of the devices", show)
    }
}

/// Largest number of texts about a device.
const MOST_TEXTS: usize = 8;

fn texts(at: usize, wanted: &WantedDevice) -> DeviceTexts {
    let who = format!("input.{at}: '{}'", wanted.identity.name.escape_debug());
    let mut texts = Texts::new(MOST_TEXTS);
    let lost = format!(
        "{who} is lost, because its node cannot be read: its buttons are FALSE, its axes at their centres"
    );
    let back = format!("{who} is back; what is held on it has no effect until it is let go");
    let dark = format!("{who}: its lights cannot be switched: may the user write to its node?");
    DeviceTexts {
        lost: texts.keep(&lost),
        back: texts.keep(&back),
        dark: texts.keep(&dark),
        who,
        refused: texts,
    }
}
