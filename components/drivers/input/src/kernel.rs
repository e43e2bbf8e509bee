//! Devices of the kernel: nodes `/dev/input/eventN`.
//!
//! Reads never wait: the nodes are opened for that. Requests fill a buffer of a size that they state. Devices are found in
//! a list of the kernel's, because a node takes the kernel up to 16 ms to close.

use crate::{
    bus::{
        ABS_COUNT, Abilities, AxisRange, Bus, FoundDevice, HeldState, Identity, InputDevice,
        KEY_COUNT, KEY_WORDS, LED_COUNT, REL_COUNT,
    },
    described::{first_line, listed},
    event::{EVENT_SIZE, InputEvent, kind},
};
use core::ffi::c_void;
use port::Lost;
use rustix::{
    fs::{Mode, OFlags},
    io::Errno,
    ioctl::{self, Direction, Ioctl, IoctlOutput, Opcode, opcode},
};
use std::{
    fs,
    os::fd::OwnedFd,
    path::{Path, PathBuf},
};

/// Devices of this computer.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// Folder of device nodes.
    pub(crate) nodes: PathBuf,
    /// List of the devices.
    pub(crate) list: PathBuf,
}

/// Largest size of the list, in bytes.
const MOST_BYTES: u64 = 1 << 20;

impl Default for Kernel {
    fn default() -> Self {
        Self { nodes: "/dev/input".into(), list: "/proc/bus/input/devices".into() }
    }
}

impl Kernel {
    /// Opens a node.
    pub(crate) fn node(&self, number: u32) -> Result<Node, Lost> {
        let path = self.nodes.join(format!("event{number}"));
        let open = |mode| {
            let flags = mode | OFlags::NONBLOCK | OFlags::CLOEXEC;
            rustix::fs::open(&path, flags, Mode::empty())
        };
        // Without permission to write, lights cannot be switched.
        let node = match open(OFlags::RDWR) {
            Err(Errno::ACCESS | Errno::PERM | Errno::ROFS) => open(OFlags::RDONLY),
            done => done,
        };
        Ok(Node(node.map_err(lost)?))
    }
}

impl Bus for Kernel {
    fn devices(&self) -> Vec<FoundDevice> {
        let bytes = hal_ini::file::contents(&self.list, MOST_BYTES).ok().flatten();
        listed(&String::from_utf8_lossy(&bytes.unwrap_or_default()))
    }

    fn open(&self, device: &FoundDevice, is_exclusive: bool) -> Result<Box<dyn InputDevice>, Lost> {
        let node = self.node(device.number)?;
        // The device went away meanwhile, and the next one got its number.
        if node.identity()? != device.identity {
            return Err(Lost::GONE);
        }
        if is_exclusive {
            node.grab()?;
        }
        Ok(Box::new(node))
    }

    fn number_of(&self, path: &Path) -> Option<u32> {
        let (node, nodes) = (fs::canonicalize(path).ok()?, fs::canonicalize(&self.nodes).ok()?);
        node.strip_prefix(nodes).ok()?.to_str()?.strip_prefix("event")?.parse().ok()
    }
}

/// Open node of a device.
#[derive(Debug)]
pub(crate) struct Node(OwnedFd);

/// Letter of the requests.
const GROUP: u8 = b'E';
/// Numbers of the requests.
const ID: u8 = 0x02;
const NAME: u8 = 0x06;
const PHYS: u8 = 0x07;
const UNIQ: u8 = 0x08;
const KEYS: u8 = 0x18;
const BITS: u8 = 0x20;
const AXIS: u8 = 0x40;
const GRAB: u8 = 0x90;

/// Number of events that one call takes.
const AT_ONCE: usize = 64;

impl Node {
    /// Passes a request that fills a buffer.
    fn fill(&self, number: u8, room: &mut [u8]) -> Result<(), Lost> {
        // SAFETY: the kernel writes at most as many bytes as the request states, which is the length of `room`.
        unsafe { ioctl::ioctl(&self.0, Fill { number, room }) }.map_err(lost)
    }

    fn text(&self, number: u8) -> Result<String, Lost> {
        let mut bytes = [0; 256];
        match self.fill(number, &mut bytes) {
            // A device without such a text.
            Err(lost) if lost.0 == Errno::NOENT.raw_os_error() => return Ok(String::new()),
            done => done?,
        }
        let text = bytes.split(|b| *b == 0).next().unwrap_or_default();
        Ok(first_line(&String::from_utf8_lossy(text)))
    }

    fn identity(&self) -> Result<Identity, Lost> {
        let mut id = [0; 8];
        self.fill(ID, &mut id)?;
        let [a, b, c, d, e, f, g, h] = id;
        Ok(Identity {
            bus: u16::from_ne_bytes([a, b]),
            vendor: u16::from_ne_bytes([c, d]),
            product: u16::from_ne_bytes([e, f]),
            version: u16::from_ne_bytes([g, h]),
            name: self.text(NAME)?,
            phys: self.text(PHYS)?,
            uniq: self.text(UNIQ)?,
        })
    }

    /// Returns the codes of a kind that the device has, below `most`.
    fn codes(&self, kind: u16, most: usize) -> Result<Vec<u16>, Lost> {
        let mut bytes = [0; KEY_WORDS * 8];
        let number = u8::try_from(kind).map_or(BITS, |kind| BITS.wrapping_add(kind));
        self.fill(number, &mut bytes)?;
        let words = words(&bytes);
        let has = |code: &u16| {
            let word = words.get(usize::from(code / 64)).copied().unwrap_or(0);
            word >> (code % 64) & 1 != 0
        };
        Ok((0..).take(most).filter(has).collect())
    }

    fn axis(&self, code: u16) -> Result<AxisRange, Lost> {
        let mut bytes = [0; 24];
        let number = u8::try_from(code).map_or(AXIS, |code| AXIS.wrapping_add(code));
        self.fill(number, &mut bytes)?;
        let mut numbers = bytes.chunks_exact(4).map(|four| {
            let [a, b, c, d] = *four else { return 0 };
            i32::from_ne_bytes([a, b, c, d])
        });
        let mut next = || numbers.next().unwrap_or(0);
        let (value, min, max) = (next(), next(), next());
        Ok(AxisRange { value, min, max, fuzz: next(), flat: next() })
    }

    fn grab(&self) -> Result<(), Lost> {
        const REQUEST: Opcode = opcode::write::<i32>(GROUP, GRAB);
        // SAFETY: the request takes a number in place of a pointer.
        let request = unsafe { ioctl::IntegerSetter::<REQUEST>::new_usize(1) };
        // SAFETY: the kernel accesses no memory for it.
        unsafe { ioctl::ioctl(&self.0, request) }.map_err(lost)
    }
}

/// Returns the masks in bytes from the kernel, whose words are as long as its own.
fn words(bytes: &[u8; KEY_WORDS * 8]) -> [u64; KEY_WORDS] {
    let mut words = [0; KEY_WORDS];
    let (own, _) = bytes.as_chunks::<{ size_of::<usize>() }>();
    for (at, own) in own.iter().enumerate() {
        let bit = at * size_of::<usize>() * 8;
        if let Some(word) = words.get_mut(bit / 64) {
            *word |= (usize::from_ne_bytes(*own) as u64) << (bit % 64);
        }
    }
    words
}

impl InputDevice for Node {
    fn abilities(&self) -> Result<Abilities, Lost> {
        let mut abs = Vec::new();
        for code in self.codes(kind::ABS, ABS_COUNT)? {
            abs.push((code, self.axis(code)?));
        }
        Ok(Abilities {
            keys: self.codes(kind::KEY, KEY_COUNT.into())?,
            abs,
            rel: self.codes(kind::REL, REL_COUNT)?,
            leds: self.codes(kind::LED, LED_COUNT)?,
        })
    }

    fn read(&mut self, room: &mut [InputEvent]) -> Result<usize, Lost> {
        let mut bytes = [0; AT_ONCE * EVENT_SIZE];
        let most = room.len().min(AT_ONCE) * EVENT_SIZE;
        let Some(bytes) = bytes.get_mut(..most) else { return Ok(0) };
        let done = match rustix::io::read(&self.0, &mut *bytes) {
            Ok(0) => return Err(Lost::GONE),
            Ok(done) => done,
            Err(Errno::AGAIN | Errno::INTR) => return Ok(0),
            Err(why) => return Err(lost(why)),
        };
        let mut count = 0;
        let events = InputEvent::decode(bytes.get(..done).unwrap_or_default());
        for (to, from) in room.iter_mut().zip(events) {
            *to = from;
            count += 1;
        }
        Ok(count)
    }

    fn state(&mut self) -> Result<HeldState, Lost> {
        // What waits is older than the answers.
        let mut room = [InputEvent::default(); AT_ONCE];
        for _ in 0..AT_ONCE {
            if self.read(&mut room)? == 0 {
                break;
            }
        }
        let mut bytes = [0; KEY_WORDS * 8];
        self.fill(KEYS, &mut bytes)?;
        let mut held = HeldState { keys: words(&bytes), abs: [0; ABS_COUNT] };
        for code in self.codes(kind::ABS, ABS_COUNT)? {
            if let Some(value) = held.abs.get_mut(usize::from(code)) {
                *value = self.axis(code)?.value;
            }
        }
        Ok(held)
    }

    fn light(&mut self, led: u16, is_on: bool) -> Result<(), Lost> {
        let light = InputEvent { kind: kind::LED, code: led, value: i32::from(is_on) };
        let mut bytes = light.encode().to_vec();
        bytes.extend(InputEvent::REPORT.encode());
        rustix::io::write(&self.0, &bytes).map(drop).map_err(lost)
    }
}

fn lost(why: Errno) -> Lost {
    Lost(why.raw_os_error())
}

/// Request that fills a buffer.
struct Fill<'r> {
    number: u8,
    room: &'r mut [u8],
}

// SAFETY: the request has the length of the buffer, which is what the kernel writes at most; the pointer is that of the
// buffer, which lives across the call.
unsafe impl Ioctl for Fill<'_> {
    type Output = ();

    const IS_MUTATING: bool = true;

    fn opcode(&self) -> Opcode {
        opcode::from_components(Direction::Read, GROUP, self.number, self.room.len())
    }

    fn as_ptr(&mut self) -> *mut c_void {
        self.room.as_mut_ptr().cast()
    }

    unsafe fn output_from_ptr(_: IoctlOutput, _: *mut c_void) -> rustix::io::Result<()> {
        Ok(())
    }
}
