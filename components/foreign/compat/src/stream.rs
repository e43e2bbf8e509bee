//! Realtime. Functions `hal_stream_…`: rings of records that a component shares with programs.

use crate::{
    loading::loading,
    pin::{refuse, text},
    second_setup::refuse_shared,
};
use core::{
    cell::UnsafeCell,
    ffi::{c_char, c_int, c_uint, c_void},
};
use hal_component::abi::{
    Consumer, Got, MAX_WIDTH, Producer, Ring, Status, Str, StreamRef, StreamSpec, size,
    stream_direction, ty,
};
use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU32, Ordering::Relaxed},
};

/// Record with the layout that C components use.
#[repr(C)]
#[derive(Debug)]
struct Handle {
    component: c_int,
    key: c_int,
    stream: *const Stream,
}

/// Ring with producer and consumer, each used by one thread.
#[derive(Debug)]
struct Stream {
    made: StreamRef,
    types: [u8; 24],
    producer: UnsafeCell<Producer>,
    consumer: UnsafeCell<Consumer>,
    sample: AtomicU32,
    underruns: AtomicU32,
}

/// Rings that other components may attach to: instance, key, ring and types.
static KNOWN: Mutex<Vec<Known>> = Mutex::new(Vec::new());

#[derive(Debug)]
struct Known {
    instance: usize,
    key: c_int,
    made: StreamRef,
    types: [u8; 24],
}

// SAFETY: rings are made for sharing, and live as long as their component.
unsafe impl Send for Known {}

/// Base keys of `sampler` and `streamer`; the channel number is added.
const SAMPLER: c_int = 0x4853_4130;
const STREAMER: c_int = 0x4853_5430;

fn named(key: c_int) -> (String, u32) {
    for (base, name, direction) in
        [(SAMPLER, "sampler", stream_direction::OUT), (STREAMER, "streamer", stream_direction::IN)]
    {
        if (0..16).contains(&(key - base)) {
            return (format!("{name}.{}", key - base), direction);
        }
    }
    (format!("stream.{key:08x}"), stream_direction::OUT)
}

/// Parses the type letters.
fn parse(letters: &str) -> Option<([u8; 24], u32)> {
    let mut types = [0; 24];
    let mut width = 0;
    for (place, letter) in types.iter_mut().take(MAX_WIDTH).zip(letters.chars()) {
        *place = match letter.to_ascii_lowercase() {
            'f' | 'r' => ty::FLOAT,
            'b' => ty::BIT,
            's' => ty::S32,
            'u' => ty::U32,
            'l' => ty::S64,
            'k' => ty::U64,
            _ => return None,
        };
        width += 1;
    }
    (width > 0 && letters.len() <= MAX_WIDTH).then_some((types, width))
}

impl Stream {
    fn give(handle: &mut Handle, made: StreamRef, types: [u8; 24]) {
        // SAFETY: the engine's ring, alive until its component is unloaded; there is one producer.
        let producer = unsafe { Producer::new(made.ring, made.depth, made.width) };
        // SAFETY: as above; there is one consumer.
        let consumer = unsafe { Consumer::new(made.ring, made.depth, made.width) };
        let stream = Self {
            made,
            types,
            producer: UnsafeCell::new(producer),
            consumer: UnsafeCell::new(consumer),
            sample: AtomicU32::new(0),
            underruns: AtomicU32::new(0),
        };
        handle.stream = Box::into_raw(Box::new(stream));
    }

    fn ring(&self) -> &Ring {
        // SAFETY: the engine's ring, alive until its component is unloaded.
        unsafe { &*self.made.ring }
    }

    fn waiting(&self) -> u32 {
        self.ring().waiting(self.made.depth)
    }
}

fn handle<'h>(p: *mut Handle) -> Option<&'h mut Handle> {
    // SAFETY: the component passes its own record.
    unsafe { p.as_mut() }
}

fn stream<'s>(p: *mut Handle) -> Option<&'s Stream> {
    // SAFETY: made by `give`, freed by `destroy` or `detach`.
    handle(p).and_then(|h| unsafe { h.stream.as_ref() })
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_create(
    p: *mut Handle,
    component: c_int,
    key: c_int,
    depth: c_uint,
    types: *const c_char,
) -> c_int {
    let (Some(l), Some(h), Some(letters)) = (loading(), handle(p), text(types)) else {
        return Status::EINVAL.0;
    };
    // A ring has one end on each side.
    if let Some(refused) = refuse_shared("hal_stream_create") {
        return refused;
    }
    let Some((types, width)) = parse(letters) else {
        let why = format!("stream: '{letters}' are not types of a record");
        return refuse(Some(l), Status::EINVAL.0, &why);
    };
    let (name, direction) = named(key);
    let name = format!("{}{name}", l.module.prefix);
    let spec = StreamSpec {
        size: size::<StreamSpec>(),
        direction,
        name: Str::borrow(&name),
        depth,
        width,
        types,
    };
    let mut made = StreamRef { ring: core::ptr::null(), depth: 0, width: 0 };
    let Some(make) = l.host.stream else { return Status::EINVAL.0 };
    // SAFETY: the engine's function; both records live across the call.
    let status = unsafe { make(l.host.ctx, &raw const spec, &raw mut made) };
    if !status.is_ok() {
        return status.0;
    }
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let instance = l.file.instance.addr();
    known.retain(|k| k.instance != instance || k.key != key);
    known.push(Known { instance, key, made, types });
    (h.component, h.key) = (component, key);
    Stream::give(h, made, types);
    0
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_attach(
    p: *mut Handle,
    component: c_int,
    key: c_int,
    types: *const c_char,
) -> c_int {
    let (Some(l), Some(h)) = (loading(), handle(p)) else { return Status::EINVAL.0 };
    if let Some(refused) = refuse_shared("hal_stream_attach") {
        return refused;
    }
    let known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let instance = l.file.instance.addr();
    let Some(k) = known.iter().find(|k| k.instance == instance && k.key == key) else {
        return Status::ENOENT.0;
    };
    let wanted = text(types).filter(|t| !t.is_empty()).map(parse);
    if wanted.is_some_and(|w| w.is_none_or(|(types, _)| types != k.types)) {
        return Status::EINVAL.0;
    }
    (h.component, h.key) = (component, key);
    Stream::give(h, k.made, k.types);
    0
}

fn free(p: *mut Handle) {
    let Some(h) = handle(p) else { return };
    let stream = core::mem::replace(&mut h.stream, core::ptr::null()).cast_mut();
    if !stream.is_null() {
        // SAFETY: made by `give`; freed once.
        drop(unsafe { Box::from_raw(stream) });
    }
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_destroy(p: *mut Handle) {
    let at = stream(p).map(|s| s.made.ring);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.retain(|k| Some(k.made.ring) != at);
    free(p);
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_detach(p: *mut Handle) -> c_int {
    free(p);
    0
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_write(p: *mut Handle, values: *const u64) -> c_int {
    let Some(s) = stream(p).filter(|_| !values.is_null()) else { return Status::EINVAL.0 };
    let value = |i: usize| {
        // SAFETY: the component passes a value of each type, eight bytes apart.
        let bits = unsafe { values.wrapping_add(i).read() };
        narrow(bits, s.types.get(i).copied().unwrap_or(0))
    };
    // SAFETY: only one thread writes.
    let producer = unsafe { &mut *s.producer.get() };
    if producer.put(value) { 0 } else { -libc::ENOSPC }
}

/// Returns the bits that count for the type, in the form of cells.
const fn narrow(bits: u64, ty: u8) -> u64 {
    match ty {
        ty::BIT => (bits & 0xFF != 0) as u64,
        ty::S32 | ty::U32 => bits & 0xFFFF_FFFF,
        _ => bits,
    }
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_read(p: *mut Handle, values: *mut u64, sample: *mut c_uint) -> c_int {
    let Some(s) = stream(p).filter(|_| !values.is_null()) else { return Status::EINVAL.0 };
    // SAFETY: only one thread reads.
    let consumer = unsafe { &mut *s.consumer.get() };
    let got = consumer.take(|i, bits| {
        // SAFETY: the component passes room for a value of each type.
        unsafe { values.wrapping_add(i).write(bits) };
    });
    match got {
        Got::Sample(number) => {
            let [a, b, c, d, ..] = number.to_le_bytes();
            s.sample.store(u32::from_le_bytes([a, b, c, d]), Relaxed);
            if !sample.is_null() {
                // SAFETY: the component's memory.
                unsafe { sample.write(s.sample.load(Relaxed)) };
            }
            0
        }
        Got::Nothing | Got::Nonsense => {
            s.underruns.fetch_add(1, Relaxed);
            Status::EAGAIN.0
        }
    }
}

fn signed(n: u32) -> c_int {
    c_int::try_from(n).unwrap_or(c_int::MAX)
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_readable(p: *mut Handle) -> bool {
    stream(p).is_some_and(|s| s.waiting() > 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_writable(p: *mut Handle) -> bool {
    stream(p).is_some_and(|s| s.waiting() < s.made.depth.saturating_sub(1))
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_depth(p: *mut Handle) -> c_int {
    stream(p).map_or(0, |s| signed(s.waiting()))
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_maxdepth(p: *mut Handle) -> c_int {
    stream(p).map_or(0, |s| signed(s.made.depth))
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_num_underruns(p: *mut Handle) -> c_int {
    stream(p).map_or(0, |s| signed(s.underruns.load(Relaxed)))
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_num_overruns(p: *mut Handle) -> c_int {
    let lost = stream(p).map_or(0, |s| s.ring().lost.load(Relaxed));
    c_int::try_from(lost).unwrap_or(c_int::MAX)
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_element_count(p: *mut Handle) -> c_int {
    stream(p).map_or(0, |s| signed(s.made.width))
}

#[unsafe(no_mangle)]
extern "C" fn hal_stream_element_type(p: *mut Handle, index: c_int) -> c_int {
    let index = usize::try_from(index).unwrap_or(usize::MAX);
    stream(p).and_then(|s| s.types.get(index)).map_or(0, |t| c_int::from(*t))
}

/// Placeholder for memory that some components inspect; it holds zeroes.
#[repr(transparent)]
#[derive(Debug)]
pub(crate) struct Nowhere(*const c_void);
// SAFETY: points to immutable bytes.
unsafe impl Sync for Nowhere {}

static NOTHING: [u64; 8192] = [0; 8192];

/// Base of LinuxCNC's shared memory: here, zeroes.
#[unsafe(no_mangle)]
pub(crate) static hal_shmem_base: Nowhere = Nowhere((&raw const NOTHING).cast());
