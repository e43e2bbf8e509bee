//! Realtime. Lines of the kernel, by version 2 of its GPIO interface.
//!
//! A read of levels, a write of levels and a read of edges are one system call each (`ioctl`, `ioctl`, `read`), which
//! neither allocates nor waits.

use crate::{
    chips::{ChipFacts, Chips, LineFacts, OpenChip},
    config::{Bias, Drive, Setting},
    label::Label,
    request::{self, LineRequest, MOST_ATTRIBUTES, MOST_TOGETHER, QUEUE},
};
use core::marker::PhantomData;
use port::{LineEdge, Lines, Lost};
use std::{
    fs::{self, File, OpenOptions},
    io,
    os::fd::{AsRawFd, FromRawFd},
    path::PathBuf,
};

/// Chips of this computer.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// Folder of device nodes.
    pub(crate) nodes: PathBuf,
}

impl Default for Kernel {
    fn default() -> Self {
        Self { nodes: "/dev".into() }
    }
}

impl Chips for Kernel {
    fn numbers(&self) -> Result<Vec<u32>, Lost> {
        let mut numbers = Vec::new();
        for entry in fs::read_dir(&self.nodes).map_err(|e| lost(&e))? {
            let entry = entry.map_err(|e| lost(&e))?;
            // A link is another name for a chip that is there as well.
            let is_link = entry.file_type().is_ok_and(|kind| kind.is_symlink());
            let name = entry.file_name();
            let number = name.to_str().and_then(|name| name.strip_prefix("gpiochip"));
            if let (false, Some(number)) = (is_link, number.and_then(|n| n.parse().ok())) {
                numbers.push(number);
            }
        }
        numbers.sort_unstable();
        Ok(numbers)
    }

    fn open(&self, number: u32) -> Result<Box<dyn OpenChip>, Lost> {
        let node = self.nodes.join(format!("gpiochip{number}"));
        let node = OpenOptions::new().read(true).write(true).open(node).map_err(|e| lost(&e))?;
        Ok(Box::new(Chip(node)))
    }
}

/// Open device node of a chip.
#[derive(Debug)]
struct Chip(File);

impl OpenChip for Chip {
    fn facts(&self) -> Result<ChipFacts, Lost> {
        let info = CHIP_INFO.pass(&self.0, ChipInfo { name: [0; 32], label: [0; 32], lines: 0 })?;
        Ok(ChipFacts { label: Label::from_kernel(&info.label), lines: info.lines })
    }

    fn line(&self, offset: u32) -> Result<LineFacts, Lost> {
        let info = LINE_INFO.pass(&self.0, LineInfo { offset, ..LineInfo::EMPTY })?;
        Ok(LineFacts {
            name: Label::from_kernel(&info.name),
            consumer: Label::from_kernel(&info.consumer),
            is_held: info.flags & USED != 0,
        })
    }

    fn request(&self, request: &LineRequest) -> Result<Box<dyn Lines>, Lost> {
        let answer = GET_LINE.pass(&self.0, encode(request))?;
        // SAFETY: the kernel has just made this descriptor, which belongs to nobody else.
        let lines = unsafe { File::from_raw_fd(answer.fd) };
        let has_edges = request.mask(|setting| setting.has_edges) != 0;
        if has_edges {
            set_nonblocking(&lines)?;
        }
        let mut offsets = [0; MOST_TOGETHER];
        for (to, from) in offsets.iter_mut().zip(&request.offsets) {
            *to = *from;
        }
        Ok(Box::new(KernelLines { lines, offsets, count: request.offsets.len(), has_edges }))
    }
}

/// Lines that the kernel has granted. They are released when this is dropped.
#[derive(Debug)]
struct KernelLines {
    lines: File,
    offsets: [u32; MOST_TOGETHER],
    count: usize,
    has_edges: bool,
}

/// Number of edges that one system call takes.
const AT_ONCE: usize = 64;

impl Lines for KernelLines {
    fn read(&self, mask: u64) -> Result<u64, Lost> {
        Ok(GET_VALUES.pass(&self.lines, Values { bits: 0, mask })?.bits & mask)
    }

    fn write(&self, levels: u64, mask: u64) -> Result<(), Lost> {
        SET_VALUES.pass(&self.lines, Values { bits: levels & mask, mask }).map(|_| ())
    }

    fn edges(&self, room: &mut [LineEdge]) -> Result<usize, Lost> {
        if !self.has_edges || room.is_empty() {
            return Ok(0);
        }
        let mut events = [Event::EMPTY; AT_ONCE];
        let most = room.len().min(AT_ONCE);
        let bytes = most * size_of::<Event>();
        // SAFETY: `events` has room for so many bytes, lives across the call, and takes any bytes.
        let done = unsafe { libc::read(self.lines.as_raw_fd(), events.as_mut_ptr().cast(), bytes) };
        let Ok(done) = usize::try_from(done) else {
            let lost = last_error();
            return if lost.0 == libc::EAGAIN { Ok(0) } else { Err(lost) };
        };
        let count = done / size_of::<Event>();
        for (edge, event) in room.iter_mut().zip(events.iter().take(count)) {
            let mut lines = self.offsets.iter().take(self.count);
            // An edge of no requested line, which the kernel does not send, has no bit.
            let bit = lines.position(|offset| *offset == event.offset).unwrap_or(MOST_TOGETHER);
            *edge = LineEdge {
                at_ns: event.at_ns,
                number: event.number,
                bit: u8::try_from(bit).unwrap_or(u8::MAX),
                is_rising: event.id == RISING,
            };
        }
        Ok(count)
    }
}

fn set_nonblocking(lines: &File) -> Result<(), Lost> {
    // SAFETY: reads the flags of an open descriptor; no memory is passed.
    let flags = unsafe { libc::fcntl(lines.as_raw_fd(), libc::F_GETFL) };
    if flags < 0 {
        return Err(last_error());
    }
    // SAFETY: sets the flags of an open descriptor; no memory is passed.
    let done = unsafe { libc::fcntl(lines.as_raw_fd(), libc::F_SETFL, flags | libc::O_NONBLOCK) };
    if done < 0 { Err(last_error()) } else { Ok(()) }
}

/// Returns the request as the kernel reads it.
fn encode(request: &LineRequest) -> KernelRequest {
    let mut to = KernelRequest::EMPTY;
    for (to, from) in to.offsets.iter_mut().zip(&request.offsets) {
        *to = *from;
    }
    for (to, from) in to.consumer.iter_mut().zip(b"ferrule") {
        *to = *from;
    }
    to.lines = u32::try_from(request.offsets.len()).unwrap_or(0);
    let kinds = request::kinds(&request.settings);
    to.config.flags = kinds.first().map_or(0, flags);
    let mut attributes = to.config.attributes.iter_mut();
    let mut count = 0;
    let kinds = kinds.iter().skip(1).map(|kind| {
        let is = |setting: &Setting| Setting { debounce_us: 0, ..*setting } == *kind;
        Attribute { id: FLAGS, padding: 0, value: flags(kind), mask: request.mask(is) }
    });
    let times = request::times(&request.settings).into_iter().map(|time| {
        // The kernel reads the time from the first four bytes of the value.
        let [a, b, c, d] = time.to_ne_bytes();
        let value = u64::from_ne_bytes([a, b, c, d, 0, 0, 0, 0]);
        Attribute { id: DEBOUNCE, padding: 0, value, mask: request.mask(|s| s.debounce_us == time) }
    });
    for (attribute, to) in kinds.chain(times).zip(&mut attributes) {
        *to = attribute;
        count += 1;
    }
    to.config.count = count;
    if request.mask(|setting| setting.has_edges) != 0 {
        to.queue = QUEUE;
    }
    to
}

/// Returns the kernel's flags of a line.
fn flags(setting: &Setting) -> u64 {
    let mut flags = if setting.is_output { OUTPUT } else { INPUT };
    flags |= if setting.is_active_low { ACTIVE_LOW } else { 0 };
    flags |= if setting.has_edges { EDGE_RISING | EDGE_FALLING } else { 0 };
    flags |= match setting.bias {
        Bias::AsIs => 0,
        Bias::Disabled => BIAS_DISABLED,
        Bias::PullDown => BIAS_PULL_DOWN,
        Bias::PullUp => BIAS_PULL_UP,
    };
    flags
        | match setting.drive {
            Drive::Both => 0,
            Drive::OpenDrain => OPEN_DRAIN,
            Drive::OpenSource => OPEN_SOURCE,
        }
}

const USED: u64 = 1 << 0;
const ACTIVE_LOW: u64 = 1 << 1;
const INPUT: u64 = 1 << 2;
const OUTPUT: u64 = 1 << 3;
const EDGE_RISING: u64 = 1 << 4;
const EDGE_FALLING: u64 = 1 << 5;
const OPEN_DRAIN: u64 = 1 << 6;
const OPEN_SOURCE: u64 = 1 << 7;
const BIAS_PULL_UP: u64 = 1 << 8;
const BIAS_PULL_DOWN: u64 = 1 << 9;
const BIAS_DISABLED: u64 = 1 << 10;

/// Identifiers of attributes.
const FLAGS: u32 = 1;
const DEBOUNCE: u32 = 3;
/// Identifier of a rising edge; the other one is 2.
const RISING: u32 = 1;

#[derive(Clone, Copy)]
#[repr(C)]
struct ChipInfo {
    name: [u8; 32],
    label: [u8; 32],
    lines: u32,
}

#[derive(Clone, Copy)]
#[repr(C)]
struct LineInfo {
    name: [u8; 32],
    consumer: [u8; 32],
    offset: u32,
    count: u32,
    flags: u64,
    attributes: [[u64; 2]; MOST_ATTRIBUTES],
    padding: [u32; 4],
}

impl LineInfo {
    const EMPTY: Self = Self {
        name: [0; 32],
        consumer: [0; 32],
        offset: 0,
        count: 0,
        flags: 0,
        attributes: [[0; 2]; MOST_ATTRIBUTES],
        padding: [0; 4],
    };
}

#[derive(Clone, Copy)]
#[repr(C)]
struct Values {
    bits: u64,
    mask: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
struct Attribute {
    id: u32,
    padding: u32,
    value: u64,
    mask: u64,
}

#[derive(Clone, Copy)]
#[repr(C)]
struct LineConfig {
    flags: u64,
    count: u32,
    padding: [u32; 5],
    attributes: [Attribute; MOST_ATTRIBUTES],
}

#[derive(Clone, Copy)]
#[repr(C)]
struct KernelRequest {
    offsets: [u32; MOST_TOGETHER],
    consumer: [u8; 32],
    config: LineConfig,
    lines: u32,
    queue: u32,
    padding: [u32; 5],
    fd: i32,
}

impl KernelRequest {
    const EMPTY: Self = Self {
        offsets: [0; MOST_TOGETHER],
        consumer: [0; 32],
        config: LineConfig {
            flags: 0,
            count: 0,
            padding: [0; 5],
            attributes: [Attribute { id: 0, padding: 0, value: 0, mask: 0 }; MOST_ATTRIBUTES],
        },
        lines: 0,
        queue: 0,
        padding: [0; 5],
        fd: 0,
    };
}

#[derive(Clone, Copy)]
#[repr(C)]
struct Event {
    at_ns: u64,
    id: u32,
    offset: u32,
    number: u32,
    line_number: u32,
    padding: [u32; 6],
}

impl Event {
    const EMPTY: Self =
        Self { at_ns: 0, id: 0, offset: 0, number: 0, line_number: 0, padding: [0; 6] };
}

// Sizes of the kernel's records, which are part of the numbers of the requests.
const _: () = {
    assert!(size_of::<ChipInfo>() == 68 && size_of::<LineInfo>() == 256);
    assert!(size_of::<Values>() == 16 && size_of::<KernelRequest>() == 592);
    assert!(size_of::<LineConfig>() == 272 && size_of::<Event>() == 48);
};

/// Request to the kernel; `T` is the record that it reads and writes.
struct Request<T>(libc::Ioctl, PhantomData<T>);

const LETTER: u32 = 0xB4;
const CHIP_INFO: Request<ChipInfo> = Request(libc::_IOR::<ChipInfo>(LETTER, 0x01), PhantomData);
const LINE_INFO: Request<LineInfo> = Request(libc::_IOWR::<LineInfo>(LETTER, 0x05), PhantomData);
const GET_LINE: Request<KernelRequest> =
    Request(libc::_IOWR::<KernelRequest>(LETTER, 0x07), PhantomData);
const GET_VALUES: Request<Values> = Request(libc::_IOWR::<Values>(LETTER, 0x0E), PhantomData);
const SET_VALUES: Request<Values> = Request(libc::_IOWR::<Values>(LETTER, 0x0F), PhantomData);

impl<T> Request<T> {
    /// Executes the request with `value` as input. Returns the value that the kernel leaves in it.
    fn pass(&self, node: &File, mut value: T) -> Result<T, Lost> {
        // SAFETY: each request is declared with the record that the kernel reads and writes, and `value` has that type
        // and lives across the call.
        let done = unsafe { libc::ioctl(node.as_raw_fd(), self.0, &raw mut value) };
        if done < 0 { Err(last_error()) } else { Ok(value) }
    }
}

fn last_error() -> Lost {
    lost(&io::Error::last_os_error())
}

fn lost(error: &io::Error) -> Lost {
    Lost(error.raw_os_error().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::{
        Attribute, CHIP_INFO, GET_LINE, GET_VALUES, KernelLines, LINE_INFO, SET_VALUES, encode,
        set_nonblocking,
    };
    use crate::{
        config::{Bias, Drive, Setting},
        request::{FoundLine, MOST_ATTRIBUTES, plan},
    };

    use port::{LineEdge, Lines, Lost};
    use std::{fs::File, io::Write, os::fd::OwnedFd};

    /// Returns the bytes of an event as the kernel sends them.
    fn event(at_ns: u64, id: u32, offset: u32, number: u32) -> Vec<u8> {
        let mut bytes = at_ns.to_ne_bytes().to_vec();
        for word in [id, offset, number, 7, 0, 0, 0, 0, 0, 0] {
            bytes.extend(word.to_ne_bytes());
        }
        assert_eq!(bytes.len(), 48);
        bytes
    }

    /// Events from a pipe in place of the kernel: the oldest first, no more than there is room for, and no wait.
    #[test]
    fn events_become_edges() {
        let (reader, mut writer) = std::io::pipe().unwrap();
        let lines = File::from(OwnedFd::from(reader));
        set_nonblocking(&lines).unwrap();
        let mut offsets = [0; 64];
        offsets[..2].copy_from_slice(&[17, 4]);
        let lines = KernelLines { lines, offsets, count: 2, has_edges: true };
        let mut room = [LineEdge::default(); 100];
        assert_eq!(lines.edges(&mut room), Ok(0), "nothing waits");
        for bytes in [event(1000, 1, 4, 1), event(2500, 2, 17, 2), event(9, 1, 0, 3)] {
            writer.write_all(&bytes).unwrap();
        }
        assert_eq!((lines.edges(&mut []), lines.edges(&mut room[..2])), (Ok(0), Ok(2)));
        let edge = |at_ns, bit, is_rising, number| LineEdge { at_ns, number, bit, is_rising };
        assert_eq!(room[..2], [edge(1000, 1, true, 1), edge(2500, 0, false, 2)]);
        assert_eq!(lines.edges(&mut room), Ok(1));
        assert_eq!(room[0], edge(9, 64, true, 3), "a line that was not requested has no bit");
        for number in 0..70 {
            writer.write_all(&event(1, 1, 4, number)).unwrap();
        }
        assert_eq!([0; 3].map(|_| lines.edges(&mut room).unwrap()), [64, 6, 0]);
        let without = KernelLines { has_edges: false, ..lines };
        writer.write_all(&event(1, 1, 4, 1)).unwrap();
        assert_eq!(without.edges(&mut room), Ok(0), "lines without edges are not asked");
        // A pipe is no chip.
        assert_eq!((without.read(1), without.write(1, 1)), (Err(Lost(25)), Err(Lost(25))));
    }

    /// The numbers that `linux/gpio.h` gives, written out.
    #[test]
    fn requests_have_the_kernels_numbers() {
        let numbers = [CHIP_INFO.0, LINE_INFO.0, GET_LINE.0, GET_VALUES.0, SET_VALUES.0];
        let wanted = [0x8044_B401_u32, 0xC100_B405, 0xC250_B407, 0xC010_B40E, 0xC010_B40F];
        assert_eq!(numbers.map(|n| u32::try_from(n).unwrap()), wanted);
    }

    /// Flags of each setting alone, as `linux/gpio.h` has them.
    #[test]
    fn each_setting_is_its_flag() {
        let plain = Setting::default();
        let out = Setting { is_output: true, ..plain };
        for (setting, flags) in [
            (plain, 0x4),
            (out, 0x8),
            (Setting { is_active_low: true, ..plain }, 0x6),
            (Setting { has_edges: true, ..plain }, 0x34),
            (Setting { drive: Drive::OpenDrain, ..out }, 0x48),
            (Setting { drive: Drive::OpenSource, ..out }, 0x88),
            (Setting { bias: Bias::PullUp, ..plain }, 0x104),
            (Setting { bias: Bias::PullDown, ..plain }, 0x204),
            (Setting { bias: Bias::Disabled, ..plain }, 0x404),
        ] {
            let request = plan(&[FoundLine { chip: 0, offset: 7, setting }], &[]).pop();
            // A line with edges is requested by its encoder alone.
            let Some(request) = request else {
                assert!(setting.has_edges);
                continue;
            };
            let to = encode(&request);
            assert_eq!((to.config.flags, to.config.count), (flags, 0), "{setting:?}");
            assert_eq!((to.lines, to.queue, &to.offsets[..2]), (1, 0, &[7, 0][..]));
            assert_eq!(&to.consumer[..8], b"ferrule\0");
        }
    }

    #[test]
    fn lines_that_differ_from_the_first_kind_are_attributes() {
        let plain = Setting::default();
        let settings = [
            Setting { is_output: true, ..plain },
            Setting { debounce_us: 2000, ..plain },
            plain,
            Setting { debounce_us: 2000, bias: Bias::PullUp, ..plain },
            Setting { debounce_us: 0x0102_0304, ..plain },
        ];
        let lines: Vec<_> = (0..)
            .zip(settings)
            .map(|(offset, setting)| FoundLine { chip: 0, offset, setting })
            .collect();
        let to = encode(&plan(&lines, &[])[0]);
        assert_eq!((to.config.flags, to.config.count, to.lines), (0x4, 4, 5));
        let found: Vec<(u32, u64, u64)> =
            to.config.attributes[..4].iter().map(|a| (a.id, a.value, a.mask)).collect();
        let time = |us: u32| {
            let mut bytes = [0; 8];
            bytes[..4].copy_from_slice(&us.to_ne_bytes());
            u64::from_ne_bytes(bytes)
        };
        assert_eq!(
            found,
            [
                (1, 0x104, 0b1000),
                (1, 0x8, 0b1),
                (3, time(2000), 0b1010),
                (3, time(0x0102_0304), 0b1_0000)
            ]
        );
        let none = Attribute { id: 0, padding: 0, value: 0, mask: 0 };
        assert_eq!(to.config.attributes[4..], [none; MOST_ATTRIBUTES - 4]);
    }

    #[test]
    fn an_encoder_asks_for_the_largest_queue() {
        let setting = Setting { has_edges: true, ..Setting::default() };
        let lines = [5, 6].map(|offset| FoundLine { chip: 0, offset, setting });
        let encoder = crate::config::EncoderLines { a: 0, b: Some(1), z: None };
        let to = encode(&plan(&lines, &[encoder])[0]);
        assert_eq!((to.config.flags, to.queue, to.lines), (0x34, 1024, 2));
    }
}
