//! Realtime. Real chip: its configuration through the kernel, its registers as I/O ports.

use crate::chip::Refused;
use port::{Access, Lost};
use std::{
    fs::{File, OpenOptions},
    io::{Error, ErrorKind},
    os::unix::fs::FileExt,
    path::Path,
};

/// Configuration of bus 0, device 17, function 0. The kernel serializes accesses.
pub(crate) const CONFIG: &str = "/sys/bus/pci/devices/0000:00:11.0/config";

/// Configuration of the chip; the permission for its I/O ports is requested at the first access.
#[derive(Debug)]
pub(crate) struct Hardware {
    config: File,
}

impl Hardware {
    pub(crate) fn open(config: &Path) -> Result<Self, Refused> {
        let config = OpenOptions::new().read(true).write(true).open(config);
        config.map(|config| Self { config }).map_err(|e| match e.kind() {
            ErrorKind::NotFound => Refused::NoDevice,
            ErrorKind::PermissionDenied => Refused::Forbidden,
            _ => Refused::Lost(lost(&e)),
        })
    }
}

/// Converts an I/O error. For users without permission, the kernel only shortens the configuration, which gives no
/// error number.
fn lost(error: &Error) -> Lost {
    const FORBIDDEN: i32 = 1;
    Lost(error.raw_os_error().unwrap_or(FORBIDDEN))
}

impl Access for Hardware {
    fn read(&self, address: u16) -> Result<u8, Lost> {
        ports::read(address)
    }

    fn write(&self, address: u16, value: u8) -> Result<(), Lost> {
        ports::write(address, value)
    }

    fn read_config(&self, register: u8) -> Result<u32, Lost> {
        let mut bytes = [0; 4];
        self.config.read_exact_at(&mut bytes, u64::from(register & !3)).map_err(|e| lost(&e))?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn write_config(&self, register: u8, value: u32) -> Result<(), Lost> {
        self.config
            .write_all_at(&value.to_le_bytes(), u64::from(register & !3))
            .map_err(|e| lost(&e))
    }
}

/// I/O port instructions. The kernel grants the permission per thread: a thread without it requests it at its first
/// access.
#[cfg(target_arch = "x86_64")]
mod ports {
    use core::{arch::asm, cell::Cell, ffi::c_ulong};
    use port::Lost;

    /// Registers of the block that the driver may access.
    const FIRST: u16 = 0x48;
    const COUNT: u16 = 8;

    thread_local! {
        /// Block whose registers this thread may access.
        static GRANTED: Cell<u16> = const { Cell::new(0) };
    }

    pub(super) fn read(address: u16) -> Result<u8, Lost> {
        ask(address)?;
        let value: u8;
        // SAFETY: the thread has the permission for this port: `ask` has requested it.
        unsafe {
            asm!("in al, dx", out("al") value, in("dx") address, options(nomem, nostack, preserves_flags));
        }
        Ok(value)
    }

    pub(super) fn write(address: u16, value: u8) -> Result<(), Lost> {
        ask(address)?;
        // SAFETY: the thread has the permission for this port: `ask` has requested it.
        unsafe {
            asm!("out dx, al", in("dx") address, in("al") value, options(nomem, nostack, preserves_flags));
        }
        Ok(())
    }

    fn ask(address: u16) -> Result<(), Lost> {
        let block = address & 0xFF80;
        if block == 0 || (address & 0x7F).wrapping_sub(FIRST) >= COUNT {
            return Err(Lost::NONE);
        }
        if GRANTED.get() == block {
            return Ok(());
        }
        let (first, count) = (c_ulong::from(block | FIRST), c_ulong::from(COUNT));
        // SAFETY: requests a permission from the kernel; no memory is passed.
        let done = unsafe { libc::syscall(libc::SYS_ioperm, first, count, 1) };
        if done < 0 {
            return Err(super::lost(&std::io::Error::last_os_error()));
        }
        GRANTED.set(block);
        Ok(())
    }
}

/// Processors without I/O ports do not have this chip.
#[cfg(not(target_arch = "x86_64"))]
mod ports {
    use port::Lost;

    pub(super) const fn read(_: u16) -> Result<u8, Lost> {
        Err(Lost::NONE)
    }
    pub(super) const fn write(_: u16, _: u8) -> Result<(), Lost> {
        Err(Lost::NONE)
    }
}
