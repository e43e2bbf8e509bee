//! Port I/O: simulated ports access registers whose bits are pins; real ports access the hardware, as far as the system
//! permits this process.

use crate::{loading::loading, module::Module, running};
use core::ffi::{CStr, c_char, c_int, c_uchar, c_uint, c_ulong, c_ushort, c_void};

fn module() -> Option<&'static Module> {
    running::module()
}

/// Realtime. Reads a port of `width` bytes for the running module.
pub(crate) fn read(port: u16, width: u16) -> u32 {
    match module() {
        Some(m) if m.is_simulated() => m.registers.read(port, width),
        _ => hardware::read(port, width),
    }
}

/// Realtime. Writes a port of `width` bytes for the running module.
pub(crate) fn write(port: u16, width: u16, value: u32) {
    match module() {
        Some(m) if m.is_simulated() => m.registers.write(port, width, value),
        _ => hardware::write(port, width, value),
    }
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_inb(port: c_ushort) -> c_uchar {
    let [low, ..] = read(port, 1).to_le_bytes();
    low
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_inw(port: c_ushort) -> c_ushort {
    let [a, b, ..] = read(port, 2).to_le_bytes();
    u16::from_le_bytes([a, b])
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_inl(port: c_ushort) -> c_uint {
    read(port, 4)
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_outb(value: c_uchar, port: c_ushort) {
    write(port, 1, u32::from(value));
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_outw(value: c_ushort, port: c_ushort) {
    write(port, 2, u32::from(value));
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_outl(value: c_uint, port: c_ushort) {
    write(port, 4, value);
}

/// Claims ports: `ioperm`. Simulated ports get pins. For real ports the system's permission is requested, for this
/// thread now and for other threads on their first access.
#[unsafe(no_mangle)]
extern "C" fn rtapi_ioperm(from: c_ulong, count: c_ulong, on: c_int) -> c_int {
    let (Ok(base), Ok(count)) = (u16::try_from(from), u16::try_from(count)) else {
        return hardware::refused(libc::EINVAL);
    };
    match module() {
        Some(m) if m.is_simulated() => {
            if on != 0 {
                m.registers.claim(base, count);
            }
            0
        }
        _ => hardware::permit(base, count, on != 0),
    }
}

/// Claims all ports: `iopl`. In simulation, only ports that are claimed individually get pins.
#[unsafe(no_mangle)]
extern "C" fn rtapi_iopl(level: c_int) -> c_int {
    match module() {
        Some(m) if m.is_simulated() => 0,
        _ => hardware::permit(0, if level >= 3 { u16::MAX } else { 0 }, level >= 3),
    }
}

/// Returns what takes the place of `ioperm` and `iopl` in a module, so that ports are known by the claims of those who use
/// them, and simulated hardware never becomes real.
pub(crate) fn of_ports(name: &CStr) -> Option<*const c_void> {
    match name.to_bytes() {
        b"ioperm" => Some(rtapi_ioperm as *const c_void),
        b"iopl" => Some(rtapi_iopl as *const c_void),
        _ => None,
    }
}

/// Record with the layout that C components use.
#[repr(C)]
#[derive(Debug)]
struct Parport {
    base: u16,
    base_hi: u16,
    fd: c_int,
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_parport_get(
    _module: *const c_char,
    port: *mut Parport,
    base: c_ushort,
    base_hi: c_ushort,
    _modes: c_uint,
) -> c_int {
    let base_hi = if base_hi == 0 { base.wrapping_add(0x400) } else { base_hi };
    let Some(m) = module().filter(|_| !port.is_null()) else { return -libc::EINVAL };
    if m.is_simulated() && loading().is_some() {
        m.registers.claim(base, 8);
        m.registers.claim(base_hi, 3);
    }
    let fd = if m.is_simulated() { -1 } else { hardware::claim_parport(base) };
    if !m.is_simulated() {
        hardware::permit(base, 8, true);
        hardware::permit(base_hi, 3, true);
    }
    // SAFETY: a live record of the component's.
    unsafe { port.write(Parport { base, base_hi, fd }) };
    0
}

#[unsafe(no_mangle)]
extern "C" fn rtapi_parport_release(port: *mut Parport) {
    // SAFETY: a live record of the component's, or null.
    let Some(port) = (unsafe { port.as_mut() }) else { return };
    if port.fd >= 0 {
        // SAFETY: opened by `claim_parport`, closed once.
        unsafe { libc::close(port.fd) };
        port.fd = -1;
    }
}

mod claims;

/// Access to real ports.
pub(crate) mod hardware {
    use super::claims::Claims;
    use core::ffi::c_int;

    /// Ports that this process may access.
    static CLAIMS: Claims = Claims::new();

    /// Realtime. Requests the permission for every claim, for this thread. If no claim covers `port`, requests it for
    /// `width` bytes there, because LinuxCNC lets its components use every port. Returns whether `port` may be used.
    pub(crate) fn permit_here(port: u16, width: u16) -> bool {
        let mut found = false;
        for ports in CLAIMS.ranges() {
            let done = ask(u64::from(ports.start), u64::from(ports.end - ports.start), true) == 0;
            found |= done && ports.contains(&u32::from(port));
        }
        found || ask(u64::from(port), u64::from(width), true) == 0
    }

    #[cfg(target_arch = "x86_64")]
    fn ask(base: u64, count: u64, on: bool) -> c_int {
        // SAFETY: a request to the system.
        unsafe { libc::ioperm(base, count, c_int::from(on)) }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn ask(_base: u64, _count: u64, _on: bool) -> c_int {
        refused(libc::ENOSYS)
    }

    /// Requests or drops the permission for real ports. Returns the error code.
    pub(crate) fn permit(base: u16, count: u16, on: bool) -> c_int {
        let code = ask(u64::from(base), u64::from(count), on);
        if code == 0 && on {
            CLAIMS.add(base, count);
        }
        code
    }

    /// Sets `errno` and returns -1.
    pub(crate) fn refused(errno: c_int) -> c_int {
        // SAFETY: the thread's own variable.
        let place = unsafe { libc::__errno_location() };
        // SAFETY: as above.
        unsafe { place.write(errno) };
        -1
    }

    /// Realtime. Reads `width` bytes from a hardware port.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn read(port: u16, width: u16) -> u32 {
        use core::arch::asm;
        let (byte, short, long): (u8, u16, u32);
        match width {
            1 => {
                // SAFETY: the component asked for this; without permission it is reported.
                unsafe { asm!("in al, dx", in("dx") port, out("al") byte) };
                u32::from(byte)
            }
            2 => {
                // SAFETY: as above.
                unsafe { asm!("in ax, dx", in("dx") port, out("ax") short) };
                u32::from(short)
            }
            _ => {
                // SAFETY: as above.
                unsafe { asm!("in eax, dx", in("dx") port, out("eax") long) };
                long
            }
        }
    }

    /// Realtime. Writes `width` bytes to a hardware port.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn write(port: u16, width: u16, value: u32) {
        use core::arch::asm;
        match width {
            // SAFETY: the component asked for this; without permission it is reported.
            1 => unsafe { asm!("out dx, al", in("dx") port, in("eax") value) },
            // SAFETY: as above.
            2 => unsafe { asm!("out dx, ax", in("dx") port, in("eax") value) },
            // SAFETY: as above.
            _ => unsafe { asm!("out dx, eax", in("dx") port, in("eax") value) },
        }
    }

    /// Realtime. Returns all ones, as on a machine without port I/O nothing answers.
    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn read(_port: u16, _width: u16) -> u32 {
        u32::MAX
    }

    /// Realtime. Ignores the write, as the machine has no port I/O.
    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn write(_port: u16, _width: u16, _value: u32) {}

    /// Reserves the kernel's parallel port at this address. Returns -1 if the kernel has none there.
    pub(crate) fn claim_parport(base: u16) -> c_int {
        /// `_IO('p', 0x8b)`: claims the port.
        const PPCLAIM: libc::c_ulong = 0x708b;
        for i in 0..8 {
            let known =
                std::fs::read_to_string(format!("/proc/sys/dev/parport/parport{i}/base-addr"));
            let known = known.ok().and_then(|t| t.split_whitespace().next()?.parse::<u16>().ok());
            if known != Some(base) {
                continue;
            }
            let path = std::ffi::CString::new(format!("/dev/parport{i}")).unwrap_or_default();
            // SAFETY: a C string.
            let fd = unsafe { libc::open(path.as_ptr(), libc::O_RDWR | libc::O_CLOEXEC) };
            if fd >= 0 {
                // SAFETY: an open device; if the claim fails, it stays open.
                unsafe { libc::ioctl(fd, PPCLAIM) };
            }
            return fd;
        }
        -1
    }
}
