//! Bytes that no device should send, and nodes that are no devices.

use crate::{
    bus::{Bus, HeldState},
    described::{WheelKind, Wheels, parse},
    event::{EVENT_SIZE, InputEvent},
    kernel::Kernel,
    reader::DeviceReader,
    spec::DeviceSpec,
};
use std::fs;

/// Random numbers (xorshift), the same in each run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn bytes(&mut self, room: &mut [u8]) {
        for byte in room {
            *byte = self.next().to_le_bytes()[3];
        }
    }
}

/// A million records: half of them any bytes, half of kinds and codes that exist.
#[test]
fn a_million_random_events() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut wheels = Wheels::default();
    wheels[7] = WheelKind::Counter(8);
    wheels[8] = WheelKind::Ring;
    wheels[9] = WheelKind::Counter(31);
    let mut reader = DeviceReader::new(wheels);
    reader.open(&HeldState::REST);
    let (mut events, mut asked) = (0_u32, 0);
    let mut bytes = vec![0; 1000 * EVENT_SIZE];
    for round in 0..1000 {
        random.bytes(&mut bytes);
        if round % 2 == 1 {
            for event in bytes.chunks_exact_mut(EVENT_SIZE) {
                let kind = [0, 0, 1, 1, 2, 3, 0x11, 4][event[0] as usize % 8];
                let fields = &mut event[EVENT_SIZE - 8..];
                fields[..2].copy_from_slice(&u16::to_ne_bytes(kind));
                let code = u16::from(fields[2]) % [800, 17, 66, 5][usize::from(fields[3]) % 4];
                fields[2..4].copy_from_slice(&code.to_ne_bytes());
            }
        }
        for event in InputEvent::decode(&bytes) {
            events += 1;
            if reader.event(event) {
                asked += 1;
                reader.take(&HeldState::REST);
            }
        }
    }
    assert_eq!(events, 1_000_000);
    assert!(asked > 1000, "{asked}");
}

#[test]
fn part_of_an_event_is_none() {
    let event = InputEvent { kind: 1, code: 0x130, value: -2 };
    let mut bytes = event.encode().to_vec();
    bytes.extend(&bytes.clone()[..EVENT_SIZE - 1]);
    assert_eq!(InputEvent::decode(&bytes).collect::<Vec<_>>(), [event]);
    assert_eq!(InputEvent::decode(&[]).count(), 0);
}

/// Random texts: none is a panic, and descriptions name a line.
#[test]
fn random_texts() {
    let mut random = Random(7);
    let mut devices = include_str!("../devices.txt").as_bytes().to_vec();
    let specs = ["-KRAL +Gamepad:1", "046d:c077:1", "*a*b?:3", "-", "+", ":", "*:*"];
    for _ in 0..2000 {
        let at = usize::try_from(random.next()).unwrap() % devices.len();
        let was = std::mem::replace(&mut devices[at], random.next().to_le_bytes()[2]);
        let text = String::from_utf8_lossy(&devices);
        if let Err(why) = parse(&text) {
            assert!(0 < why.0 && why.0 <= text.lines().count(), "{why}");
        }
        devices[at] = was;
        let word = specs[usize::try_from(random.next()).unwrap() % specs.len()];
        let mut word = word.as_bytes().to_vec();
        let place = usize::try_from(random.next()).unwrap() % word.len();
        word[place] = random.next().to_le_bytes()[1];
        drop(DeviceSpec::parse(&String::from_utf8_lossy(&word)));
    }
}

/// A file in place of a node gives events, then is gone; it answers no request, and is no device.
#[test]
fn nodes_that_are_no_devices() {
    let folder = std::env::temp_dir().join(format!("ferrule-events-{}", std::process::id()));
    let kernel = Kernel { nodes: folder.clone() };
    assert_eq!(kernel.devices().all.len(), 0, "no folder");
    fs::create_dir(&folder).unwrap();
    let sent: Vec<InputEvent> =
        (0..100).map(|code| InputEvent { kind: 1, code, value: i32::from(code) }).collect();
    let mut bytes: Vec<u8> = sent.iter().flat_map(|event| event.encode()).collect();
    bytes.extend([1, 2, 3]);
    fs::write(folder.join("event7"), &bytes).unwrap();
    for name in ["event", "eventx", "event99999999999", "mouse0", "event8"] {
        fs::write(folder.join(name), "").unwrap();
    }
    let found = kernel.devices();
    assert_eq!((found.all.len(), found.forbidden), (0, 0));
    let mut device = kernel.open(7, false).unwrap();
    assert!(device.abilities().is_err());
    let (mut room, mut came) = ([InputEvent::default(); 64], Vec::new());
    let lost = loop {
        match device.read(&mut room) {
            Ok(count) => came.extend_from_slice(&room[..count]),
            Err(lost) => break lost,
        }
    };
    assert_eq!(came, sent);
    assert_eq!(lost, port::Lost::GONE);
    assert!(device.state().is_err());
    assert!(kernel.open(7, true).is_err(), "it cannot be kept from others");
    assert_eq!(kernel.open(9, false).err().unwrap().0, 2);
    fs::remove_dir_all(&folder).unwrap();
}
