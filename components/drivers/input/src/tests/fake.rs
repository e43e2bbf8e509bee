//! Devices in memory, which tests unplug.

use crate::{
    bus::{ABS_COUNT, Abilities, AxisRange, Bus, FoundDevice, HeldState, Identity, InputDevice},
    codes, described,
    event::{InputEvent, kind},
    hal_input::open,
    spec::DeviceSpec,
};
use hal_bench::Bench;
use hal_component::{Builder, Component, Error};
use port::Lost;
use std::{
    cell::RefCell,
    collections::VecDeque,
    sync::{Arc, Mutex},
};

/// Period of the function, in nanoseconds.
pub(super) const MS: i64 = 1_000_000;

/// Device in memory.
#[derive(Clone, Debug)]
pub(super) struct FakeDevice {
    pub(super) identity: Identity,
    pub(super) abilities: Abilities,
    pub(super) waiting: VecDeque<InputEvent>,
    pub(super) held: HeldState,
    /// Error number of each access.
    pub(super) fails: Option<i32>,
    /// Error number of each access; the device is listed and opened.
    pub(super) breaks: Option<i32>,
    /// Error number of each opening; the device is listed.
    pub(super) refuses: Option<i32>,
    /// True if its lights cannot be switched.
    pub(super) is_dark: bool,
    /// Lights that were switched.
    pub(super) lit: Vec<(u16, bool)>,
    /// Number of the connection, which ends with it.
    connection: u32,
}

/// Devices by their numbers; none where nothing is plugged in.
#[derive(Clone, Debug, Default)]
pub(super) struct FakeBus(pub(super) Arc<Mutex<Vec<Option<FakeDevice>>>>);

impl FakeBus {
    /// Changes a device.
    pub(super) fn with<R>(&self, at: usize, change: impl FnOnce(&mut FakeDevice) -> R) -> R {
        change(self.0.lock().unwrap()[at].as_mut().unwrap())
    }

    /// Takes a device away.
    pub(super) fn unplug(&self, at: usize) -> FakeDevice {
        self.0.lock().unwrap()[at].take().unwrap()
    }

    /// Plugs a device in.
    pub(super) fn plug(&self, at: usize, mut device: FakeDevice) {
        let mut all = self.0.lock().unwrap();
        let count = all.len().max(at + 1);
        all.resize(count, None);
        device.connection += 1;
        device.waiting.clear();
        all[at] = Some(device);
    }

    /// Sends events, written as `btn-a 1`, with `|` between packets, and changes the state of the device.
    pub(super) fn send(&self, at: usize, text: &str) {
        self.with(at, |device| {
            for packet in text.split('|') {
                for event in packet.split(',').map(str::trim).filter(|event| !event.is_empty()) {
                    let event = event_of(event);
                    hold(&mut device.held, event);
                    device.waiting.push_back(event);
                }
                device.waiting.push_back(InputEvent::REPORT);
            }
        });
    }
}

/// Returns the event that a text means.
pub(super) fn event_of(text: &str) -> InputEvent {
    if text == "dropped" {
        return InputEvent { kind: kind::SYN, code: 3, value: 0 };
    }
    let (name, value) = text.split_once(' ').unwrap();
    let value = value.parse().unwrap();
    let kinds = [kind::KEY, kind::REL, kind::ABS];
    let found = kinds.iter().find_map(|kind| Some((*kind, codes::code(*kind, name)?)));
    let (kind, code) = found.unwrap_or_else(|| panic!("{name}"));
    InputEvent { kind, code, value }
}

/// Changes the state of a device as an event does.
pub(super) fn hold(held: &mut HeldState, event: InputEvent) {
    let at = usize::from(event.code);
    match event.kind {
        kind::KEY if event.value == 0 => held.keys[at / 64] &= !(1 << (at % 64)),
        kind::KEY => held.keys[at / 64] |= 1 << (at % 64),
        kind::ABS => held.abs[at] = event.value,
        _ => {}
    }
}

/// Returns a known device.
pub(super) fn known(name: &str) -> FakeDevice {
    let found = described::known().into_iter().find(|d| d.identity.name.contains(name)).unwrap();
    device(found.identity, found.abilities)
}

/// Returns a device with one axis of this range.
pub(super) fn with_axis(range: AxisRange) -> FakeDevice {
    let identity = Identity { name: "axis".to_owned(), ..Identity::default() };
    device(identity, Abilities { abs: vec![(0, range)], ..Abilities::default() })
}

pub(super) fn device(identity: Identity, abilities: Abilities) -> FakeDevice {
    let mut held = HeldState { keys: [0; _], abs: [0; ABS_COUNT] };
    for (code, range) in &abilities.abs {
        held.abs[usize::from(*code)] = range.value;
    }
    FakeDevice {
        identity,
        abilities,
        waiting: VecDeque::new(),
        held,
        fails: None,
        breaks: None,
        refuses: None,
        is_dark: false,
        lit: Vec::new(),
        connection: 0,
    }
}

impl Bus for FakeBus {
    fn devices(&self) -> Vec<FoundDevice> {
        let all = self.0.lock().unwrap();
        let there = (0..).zip(all.iter()).filter_map(|(number, device)| {
            let identity = device.as_ref().filter(|d| d.fails.is_none())?.identity.clone();
            Some(FoundDevice { number, identity })
        });
        there.collect()
    }

    fn open(&self, found: &FoundDevice, _: bool) -> Result<Box<dyn InputDevice>, Lost> {
        let at = usize::try_from(found.number).unwrap();
        let (connection, refuses) = self.with(at, |device| (device.connection, device.refuses));
        if let Some(number) = refuses {
            return Err(Lost(number));
        }
        Ok(Box::new(FakeOpen { bus: self.clone(), at, connection }))
    }
}

/// Open device in memory.
struct FakeOpen {
    bus: FakeBus,
    at: usize,
    connection: u32,
}

impl FakeOpen {
    fn with<R>(&self, change: impl FnOnce(&mut FakeDevice) -> R) -> Result<R, Lost> {
        let mut all = self.bus.0.lock().unwrap();
        let device = all.get_mut(self.at).and_then(Option::as_mut).ok_or(Lost::GONE)?;
        match device.fails.or(device.breaks) {
            Some(number) => Err(Lost(number)),
            None if device.connection != self.connection => Err(Lost::GONE),
            None => Ok(change(device)),
        }
    }
}

impl InputDevice for FakeOpen {
    fn abilities(&self) -> Result<Abilities, Lost> {
        self.with(|device| device.abilities.clone())
    }

    fn read(&mut self, room: &mut [InputEvent]) -> Result<usize, Lost> {
        self.with(|device| {
            let count = room.len().min(device.waiting.len());
            room.iter_mut().zip(device.waiting.drain(..count)).for_each(|(to, from)| *to = from);
            count
        })
    }

    fn state(&mut self) -> Result<HeldState, Lost> {
        self.with(|device| {
            device.waiting.clear();
            device.held
        })
    }

    fn light(&mut self, led: u16, is_on: bool) -> Result<(), Lost> {
        self.with(|device| {
            if device.is_dark {
                return Err(Lost(9));
            }
            device.lit.push((led, is_on));
            Ok(())
        })?
    }
}

thread_local! {
    /// Devices of the next load, and its specifications.
    static NEXT: RefCell<(FakeBus, Vec<String>)> = RefCell::default();
}

/// Component on fake devices.
enum FakeInput {}

impl Component for FakeInput {
    const NAME: &'static str = "fake_input";
    const DOC: &'static str = "";
    const FLAGS: u32 = hal_component::abi::component_flags::ONCE;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let (bus, words) = NEXT.take();
        let asked = words.into_iter().map(|word| {
            let spec = DeviceSpec::parse(&word).unwrap();
            (word, spec)
        });
        open(b, asked.collect(), &described::known(), bus)
    }
}

/// Loads the component on these devices.
pub(super) fn try_load(bus: &FakeBus, specs: &[&str]) -> Result<Bench, String> {
    NEXT.set((bus.clone(), specs.iter().map(|s| (*s).to_owned()).collect()));
    let mut bench = Bench::new();
    bench.load::<FakeInput>(&[]).map(|()| bench)
}

/// Loads the component on known devices, all of which have pins, and runs it once.
pub(super) fn load(names: &[&str]) -> (FakeBus, Bench) {
    let bus = FakeBus::default();
    for (at, name) in names.iter().enumerate() {
        let mut device = known(name);
        device.identity.phys = format!("usb-{at}");
        bus.plug(at, device);
    }
    let numbers: Vec<String> = (0..names.len()).map(|at| at.to_string()).collect();
    let specs: Vec<&str> = numbers.iter().map(String::as_str).collect();
    let bench = try_load(&bus, &specs).unwrap();
    step(&bench);
    (bus, bench)
}

/// Runs the worker, then the function, and lets a period pass.
pub(super) fn step(bench: &Bench) {
    bench.work("hal_input", 1).unwrap();
    bench.run("hal_input", MS);
    bench.pass(MS);
}
