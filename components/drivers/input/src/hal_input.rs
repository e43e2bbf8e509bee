//! Component `hal_input`.

use crate::{
    bus::{Bus, FoundDevice, FoundDevices, HeldState, InputDevice},
    described::{self, Described, Wheels},
    kernel::Kernel,
    pins::{self, DevicePins},
    reader::DeviceReader,
    refused::Refused,
    show::{Show, ShownDevice},
    simulated::{SimPins, SimulatedBus},
    spec::{Choice, DeviceSpec, MOST_DEVICES},
    worker::{DeviceTexts, PERIOD_NS, ReadDevice, WantedDevice, Worker},
};
use hal_component::{
    Arg, Builder, Component, Error, StillWatch, Texts,
    abi::{ArgSpec, component_flags},
};
use port::Lost;
use std::sync::atomic::AtomicU32;

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
            .at_most(16),
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
    if words.len() > MOST_DEVICES {
        return Err(Refused::TooMany);
    }
    let spec = |word: &String| {
        let spec = DeviceSpec::parse(word);
        let spec = spec.map_err(|why| Refused::Spec { word: word.clone(), why })?;
        Ok((word.clone(), spec))
    };
    words.iter().map(spec).collect()
}

/// Returns the devices of the user's file, then those that come with the driver.
fn descriptions(path: Option<String>) -> Result<Vec<Described>, Refused> {
    let mut all = Vec::new();
    if let Some(path) = path {
        let text = std::fs::read_to_string(&path).map_err(|why| {
            let lost = Lost(why.raw_os_error().unwrap_or(22));
            Refused::File { path: path.clone(), lost }
        })?;
        all = described::parse(&text).map_err(|why| Refused::Line { path, why })?;
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
    let mut opened = Vec::new();
    for (word, spec) in specs {
        let found = spec.find(&there.all);
        let missing = || Refused::Missing { word, there: there.clone() };
        let found = found.ok_or_else(missing).map_err(refuse)?;
        opened.push(open_one(&bus, &spec, found, described).map_err(refuse)?);
    }
    declare(b, opened, Box::new(bus), Vec::new())
}

fn open_one(
    bus: &dyn Bus,
    spec: &DeviceSpec,
    found: &FoundDevice,
    described: &[Described],
) -> Result<OpenedDevice, Refused> {
    let FoundDevice { number, identity } = found.clone();
    let name = identity.name.clone();
    let broken = |lost| Refused::Broken { number, name: name.clone(), lost };
    let mut device = bus.open(number, spec.is_exclusive).map_err(broken)?;
    let abilities = pins::chosen(&device.abilities().map_err(broken)?, spec.features);
    let held = device.state().map_err(broken)?;
    let is_same = |d: &&Described| d.identity.is_same_make(&identity);
    let wheels = described.iter().find(is_same).map(|d| d.wheels).unwrap_or_default();
    let wanted = WantedDevice { number, identity, abilities, is_exclusive: spec.is_exclusive };
    Ok(OpenedDevice { wanted, device, held, wheels })
}

/// Makes a simulated device for each specification.
fn simulate(
    b: &mut Builder<'_>,
    specs: &[AskedDevice],
    described: &[Described],
) -> Result<(), Error> {
    let there: Vec<FoundDevice> = (0..)
        .zip(described)
        .map(|(number, d)| FoundDevice { number, identity: d.identity.clone() })
        .collect();
    let mut bus = SimulatedBus::default();
    let mut asked = Vec::new();
    for (at, (word, spec)) in specs.iter().enumerate() {
        // Of devices that match, a description stands for each; the number of a node says nothing.
        let all = DeviceSpec { nth: 0, ..spec.clone() };
        let found = match spec.choice {
            Choice::Node(_) => None,
            Choice::Numbers { .. } | Choice::Text(_) => {
                spec.find(&there).or_else(|| all.find(&there))
            }
        };
        let found = found.and_then(|found| described.get(usize::try_from(found.number).ok()?));
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
        let has = pins::chosen(&device.abilities, spec.features);
        let pins = SimPins::make(b, &format!("input.{at}"), &has)?;
        device.abilities = has;
        bus.devices.push((device, pins));
        asked.push((at, spec));
    }
    let FoundDevices { all, .. } = bus.devices();
    let mut opened = Vec::new();
    for ((_, spec), found) in asked.into_iter().zip(&all) {
        let wheels = bus.devices.get(opened.len()).map(|d| d.0.clone());
        let described: Vec<Described> = wheels.into_iter().collect();
        opened.push(open_one(&bus, spec, found, &described).map_err(refuse)?);
    }
    let pins = bus.devices.iter().map(|(_, pins)| pins.clone()).collect();
    declare(b, opened, Box::new(bus), pins)
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
        let texts = texts(at, &wanted);
        let device = Some(device);
        read.push(ReadDevice { record: writer, lights, reader, device, wanted, texts, lit: None });
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

fn texts(at: usize, wanted: &WantedDevice) -> DeviceTexts {
    let WantedDevice { identity, .. } = wanted;
    let name = identity.name.escape_debug();
    let mut texts = Texts::new(3);
    DeviceTexts {
        lost: texts.keep(&format!(
            "input.{at}: '{name}' does not answer, as if it were unplugged: its buttons are FALSE, its \
             axes at their centres"
        )),
        back: texts.keep(&format!(
            "input.{at}: '{name}' is back; what is held on it has no effect until it is let go"
        )),
        dark: texts.keep(&format!(
            "input.{at}: the lights of '{name}' cannot be switched: is /dev/input/event{} writable?",
            wanted.number
        )),
    }
}
