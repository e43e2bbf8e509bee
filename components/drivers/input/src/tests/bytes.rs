//! Bytes that no device should send, and nodes that are no devices.

use crate::{
    bus::{Bus, FoundDevice, HeldState, Identity, InputDevice},
    described::{WheelKind, Wheels, parse},
    event::{EVENT_SIZE, InputEvent},
    kernel::Kernel,
    reader::DeviceReader,
    spec::DeviceSpec,
};
use std::{fs, os::unix::fs::symlink};

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

/// List of devices as the kernel writes it, with one that has no node and names that devices should not have.
const LIST: &str = "\
I: Bus=0019 Vendor=0000 Product=0001 Version=0000
N: Name=\"Power Button\"
P: Phys=PNP0C0C/button/input0
S: Sysfs=/devices/LNXSYSTM:00/input/input0
U: Uniq=
H: Handlers=kbd event12\x20
B: PROP=0
B: EV=3
B: KEY=8000 10000000000000 0

I: Bus=0005 Vendor=054c Product=05c4 Version=8100
N: Name=\"Wireless \"Controller\" \"
P: Phys=00:1a:7d:da:71:13
S: Sysfs=/devices/virtual/misc/uhid/0005:054C:05C4.0003/input/input20
U: Uniq=1c:66:6d:00:00:01
H: Handlers=js0 event3\x20
B: KEY=7fdb000000000000 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0

I: Bus=0003 Vendor=xyz Product=1
N: Name=\"Two
lines\"
P: Phys=
H: Handlers=mouse1 event7

I: Bus=0003 Vendor=0001 Product=0002 Version=0003
N: Name=\"No node\"
H: Handlers=rfkill
";

#[test]
fn the_list_of_the_kernel() {
    let list = std::env::temp_dir().join(format!("ferrule-list-{}", std::process::id()));
    let kernel = Kernel { nodes: std::env::temp_dir(), list: list.clone() };
    assert_eq!(kernel.devices(), [], "no list");
    fs::write(&list, [LIST.as_bytes(), b"\n\nN: Name=\xff\nH: Handlers=event9"].concat()).unwrap();
    let device = |number, [bus, vendor, product, version]: [u16; 4], texts: [&str; 3]| {
        let [name, phys, uniq] = texts.map(str::to_owned);
        FoundDevice {
            number,
            identity: Identity { bus, vendor, product, version, name, phys, uniq },
        }
    };
    let pad = ["Wireless \"Controller\"", "00:1a:7d:da:71:13", "1c:66:6d:00:00:01"];
    let want = [
        device(3, [5, 0x54c, 0x5c4, 0x8100], pad),
        device(7, [3, 0, 0, 0], ["Two", "", ""]),
        device(9, [0; 4], ["\u{fffd}", "", ""]),
        device(12, [0x19, 0, 1, 0], ["Power Button", "PNP0C0C/button/input0", ""]),
    ];
    assert_eq!(kernel.devices(), want);
    fs::remove_file(&list).unwrap();
}

/// A file in place of a node gives events, then is gone; it answers no request, and is no device.
#[test]
fn nodes_that_are_no_devices() {
    let folder = std::env::temp_dir().join(format!("ferrule-events-{}", std::process::id()));
    fs::create_dir(&folder).unwrap();
    let kernel = Kernel { nodes: folder.clone(), list: folder.join("list") };
    let sent: Vec<InputEvent> =
        (0..100).map(|code| InputEvent { kind: 1, code, value: i32::from(code) }).collect();
    let mut bytes: Vec<u8> = sent.iter().flat_map(|event| event.encode()).collect();
    bytes.extend([1, 2, 3]);
    fs::write(folder.join("event7"), &bytes).unwrap();
    let mut device = kernel.node(7).unwrap();
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
    // What the list says of a node is compared with what the node says.
    let found = |number| FoundDevice { number, identity: Identity::default() };
    for (number, why) in [(7, 25), (9, 2)] {
        assert_eq!(kernel.open(&found(number), false).err().unwrap().0, why, "{number}");
    }
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_path_leads_to_a_node() {
    let folder = std::env::temp_dir().join(format!("ferrule-paths-{}", std::process::id()));
    fs::create_dir_all(folder.join("by-id")).unwrap();
    let kernel = Kernel { nodes: folder.clone(), list: folder.join("list") };
    for name in ["event7", "mouse0", "eventx", "by-id/event8"] {
        fs::write(folder.join(name), "").unwrap();
    }
    symlink("../event7", folder.join("by-id/usb-Pad_1-0:1.0-event-joystick")).unwrap();
    symlink("../event9", folder.join("by-id/gone")).unwrap();
    symlink("/dev/null", folder.join("by-id/elsewhere")).unwrap();
    for (path, want) in [
        ("event7", Some(7)),
        ("by-id/usb-Pad_1-0:1.0-event-joystick", Some(7)),
        ("by-id/../event7", Some(7)),
        ("by-id/gone", None),
        ("by-id/elsewhere", None),
        ("by-id/event8", None),
        ("mouse0", None),
        ("eventx", None),
        ("", None),
    ] {
        assert_eq!(kernel.number_of(&folder.join(path)), want, "{path}");
    }
    fs::remove_dir_all(&folder).unwrap();
}
