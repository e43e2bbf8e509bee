//! Strings, lists, status codes, and the reading of records of other versions.

use core::{marker::PhantomData, mem::offset_of, ptr};

/// A borrowed string: static in a descriptor, otherwise valid for the call to which it is passed.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Str {
    ptr: *const u8,
    len: usize,
}

const _: () = assert!(offset_of!(Str, ptr) == 0 && offset_of!(Str, len) == size_of::<usize>());

// SAFETY: a `Str` in a descriptor points at immutable static bytes.
unsafe impl Sync for Str {}
// SAFETY: as for `Sync`; a `Str` carries no ownership.
unsafe impl Send for Str {}

impl Str {
    /// The absent string.
    pub const NONE: Self = Self { ptr: ptr::null(), len: 0 };

    /// Borrows a static string.
    pub const fn new(s: &'static str) -> Self {
        Self { ptr: s.as_ptr(), len: s.len() }
    }

    /// Borrows `s` for the duration of one call.
    pub const fn borrow(s: &str) -> Self {
        Self { ptr: s.as_ptr(), len: s.len() }
    }

    /// Returns the text, or `None` if the bytes are not UTF-8.
    ///
    /// # Safety
    /// The bytes must be live for `'a`.
    pub unsafe fn get<'a>(self) -> Option<&'a str> {
        if self.ptr.is_null() || self.len == 0 {
            return Some("");
        }
        // SAFETY: the caller guarantees that the bytes are live; the pointer is not null.
        let bytes = unsafe { core::slice::from_raw_parts(self.ptr, self.len) };
        core::str::from_utf8(bytes).ok()
    }
}

/// An array of pointers to records.
#[repr(C)]
#[derive(Debug)]
pub struct List<T> {
    ptr: *const *const T,
    len: usize,
    kind: PhantomData<*const T>,
}

const _: () =
    assert!(offset_of!(List<u8>, ptr) == 0 && offset_of!(List<u8>, len) == size_of::<usize>());

impl<T> Clone for List<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for List<T> {}
// SAFETY: a `List` points at immutable records.
unsafe impl<T: Sync> Sync for List<T> {}
// SAFETY: a `List` carries no ownership.
unsafe impl<T: Sync> Send for List<T> {}

impl<T> List<T> {
    /// The empty list.
    pub const EMPTY: Self = Self { ptr: ptr::null(), len: 0, kind: PhantomData };

    /// Borrows static records.
    pub const fn new(list: &'static [&'static T]) -> Self {
        Self { ptr: list.as_ptr().cast(), len: list.len(), kind: PhantomData }
    }

    /// Returns the number of records.
    pub const fn len(&self) -> usize {
        if self.ptr.is_null() { 0 } else { self.len }
    }

    /// Returns whether the list is empty.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the pointer to record `i`, or null.
    ///
    /// # Safety
    /// The array must be live.
    pub unsafe fn at(&self, i: usize) -> *const T {
        if i >= self.len() {
            return ptr::null();
        }
        // SAFETY: within the live array.
        let place = unsafe { self.ptr.add(i) };
        // SAFETY: a live element.
        unsafe { place.read() }
    }
}

impl<T: Record> List<T> {
    /// Copies record `i` in this side's version of its layout. Returns `None` if it is null or too
    /// small.
    ///
    /// # Safety
    /// The array and its records must be live.
    pub unsafe fn get(&self, i: usize) -> Option<T> {
        // SAFETY: guaranteed by the caller.
        let p = unsafe { self.at(i) };
        // SAFETY: guaranteed by the caller.
        unsafe { T::read(p) }
    }
}

/// A record that begins with its size, and that may be from a newer or older version than this
/// side.
///
/// # Safety
/// The type must be `#[repr(C)]`, its first field must be `size: u32`, and all-zero bytes must be a
/// valid value.
pub unsafe trait Record: Copy {
    /// Size of the record in the first release of this major version.
    const MIN: usize;

    /// Copies the record. Fields that the writer did not have read as zero.
    ///
    /// # Safety
    /// `p` must be null or point to a live record whose first four bytes are its true size.
    unsafe fn read(p: *const Self) -> Option<Self> {
        if p.is_null() || !p.is_aligned() {
            return None;
        }
        // SAFETY: not null; the first field is the size.
        let size = unsafe { p.cast::<u32>().read() } as usize;
        if size < Self::MIN {
            return None;
        }
        let mut out = core::mem::MaybeUninit::<Self>::zeroed();
        let n = if size < size_of::<Self>() { size } else { size_of::<Self>() };
        // SAFETY: both sides hold at least `n` bytes and do not overlap.
        unsafe { ptr::copy_nonoverlapping(p.cast::<u8>(), out.as_mut_ptr().cast::<u8>(), n) };
        // SAFETY: the value was zeroed, and then a prefix was overwritten with a valid prefix.
        Some(unsafe { out.assume_init() })
    }
}

/// Zero or a negative errno, as everywhere in HAL.
#[repr(transparent)]
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Status(pub i32);

impl Status {
    /// Success.
    pub const OK: Self = Self(0);
    /// Not found.
    pub const ENOENT: Self = Self(-2);
    /// Try again: no data, or no space.
    pub const EAGAIN: Self = Self(-11);
    /// Out of memory.
    pub const ENOMEM: Self = Self(-12);
    /// The component panicked.
    pub const EFAULT: Self = Self(-14);
    /// In use.
    pub const EBUSY: Self = Self(-16);
    /// Already exists.
    pub const EEXIST: Self = Self(-17);
    /// Invalid argument.
    pub const EINVAL: Self = Self(-22);

    /// Returns whether this is a success.
    pub const fn is_ok(self) -> bool {
        self.0 >= 0
    }
}
