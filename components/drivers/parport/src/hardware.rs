//! Realtime. Real ports: through the kernel's parport device, and directly where that is permitted.

use crate::{
    config::{Mode, PortConfig, PortLocation},
    device::Register,
};
use core::marker::PhantomData;
use port::{Access, Lost};
use std::{
    fs::{self, File, OpenOptions},
    io::{self, ErrorKind},
    os::fd::AsRawFd,
    path::{Path, PathBuf},
};

/// Paths of the system's files.
#[derive(Debug)]
pub(crate) struct System {
    /// Folder with the kernel's list of ports.
    pub(crate) ports: PathBuf,
    /// Folder of device nodes.
    pub(crate) nodes: PathBuf,
    /// True to try I/O port instructions.
    pub(crate) direct: bool,
}

impl Default for System {
    fn default() -> Self {
        Self { ports: "/proc/sys/dev/parport".into(), nodes: "/dev".into(), direct: true }
    }
}

/// Reason why a port cannot be opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// The kernel has no port of this number.
    Absent(u8),
    /// There is no way to access the registers at this address.
    NoWay(u16),
    /// No registers answer at this address.
    Nothing(u16),
    /// The port has no device node.
    NoNode(u8),
    /// The user may not open the device node.
    Forbidden(u8),
    /// The device node cannot be opened.
    Broken(u8, i32),
    /// Another driver or program has claimed the port.
    Taken(u8),
    /// The kernel's device cannot read control lines.
    ControlInputs(u8),
}

/// Commands that let a user open the device nodes.
const JOIN: &str = "sudo usermod -aG lp \"$USER\", then log in again";

/// Command that starts a machine with the right to use I/O ports, and with no other.
const DIRECTLY: &str = "sudo setpriv --reuid \"$USER\" --regid \"$(id -g)\" --init-groups \
                        --inh-caps +sys_rawio --ambient-caps +sys_rawio halrun FILE";

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Absent(n) => write!(
                f,
                "Linux parallel port {n} not found: load its driver (sudo modprobe parport_pc), or \
                 give the port's address"
            ),
            Self::NoWay(address) => write!(
                f,
                "no access to the port at {address:#x}: load the kernel's drivers (sudo modprobe \
                 parport_pc, sudo modprobe ppdev) and run as a user in group lp ({JOIN})"
            ),
            Self::Nothing(address) => {
                write!(f, "there is no port at {address:#x}: its registers read as an empty bus")
            }
            Self::NoNode(n) => {
                write!(f, "/dev/parport{n} is missing: load the module ppdev (sudo modprobe ppdev)")
            }
            Self::Forbidden(n) => {
                write!(f, "/dev/parport{n} may not be opened: run as a user in group lp ({JOIN})")
            }
            Self::Broken(n, errno) => {
                let why = io::Error::from_raw_os_error(*errno);
                write!(f, "/dev/parport{n} cannot be opened: {why}")
            }
            Self::Taken(n) => write!(
                f,
                "/dev/parport{n} is in use: end the program that has it, or unload its driver \
                 (sudo modprobe -r lp)"
            ),
            Self::ControlInputs(n) => write!(
                f,
                "mode x reads control lines, which /dev/parport{n} cannot: run as root, or with \
                 the right to use I/O ports directly ({DIRECTLY})"
            ),
        }?;
        write!(f, "; or run with --simulate")
    }
}

/// Open port.
#[derive(Debug)]
pub(crate) struct Hardware {
    index: usize,
    base: u16,
    /// Device node, which stays claimed while the port is open, however the registers are accessed.
    node: Option<File>,
    direct: bool,
}

/// Port as the kernel knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Found {
    number: u8,
    base: u16,
    /// Address of its extended registers, or zero.
    high: u16,
}

impl Hardware {
    pub(crate) fn open(system: &System, index: usize, config: PortConfig) -> Result<Self, Refused> {
        let found = find(&system.ports, config.place);
        let (base, mut why) = match (config.place, found) {
            (_, Some(found)) => (found.base, Refused::NoNode(found.number)),
            (PortLocation::Kernel(number), None) => return Err(Refused::Absent(number)),
            (PortLocation::Address(address), None) => (address, Refused::NoWay(address)),
        };
        let mut node = None;
        if let Some(found) = found {
            match claim(&system.nodes, found.number) {
                Ok(file) => node = Some(file),
                Err(taken @ Refused::Taken(_)) => return Err(taken),
                Err(other) => why = other,
            }
        }
        let direct = system.direct && ports::allowed(index, base);
        if !direct {
            // The kernel's device is then the only way to access the registers.
            node.as_ref().ok_or(why)?;
            if let (Mode::X, Some(found)) = (config.mode, found) {
                return Err(Refused::ControlInputs(found.number));
            }
        }
        let hardware = Self { index, base, node, direct };
        if found.is_none() && hardware.is_nothing() {
            return Err(Refused::Nothing(base));
        }
        hardware.set_up(config.mode, found);
        Ok(hardware)
    }

    pub(crate) const fn base(&self) -> u16 {
        self.base
    }

    /// Returns whether all registers read as an empty bus, which those of a port never do.
    fn is_nothing(&self) -> bool {
        (0..3).all(|register| self.read(self.base.wrapping_add(register)) == Ok(0xFF))
    }

    /// Sets the mode of the chip, if it has modes, and the direction of the data lines.
    fn set_up(&self, mode: Mode, found: Option<Found>) {
        let extended = match mode {
            Mode::Epp => Some(0x80),
            Mode::In => Some(0x20), // Required for the data lines to be inputs.
            Mode::Out | Mode::X => None,
        };
        let high = found.map_or(0, |f| f.high);
        if let (true, Some(value), Some(register @ 3..)) =
            (self.direct, extended, high.checked_add(2))
        {
            ports::set_up(register, value);
        }
        if let Some(node) = &self.node {
            // A port that cannot change direction fails later, when its direction is written.
            let _ = DIRECTION.pass(node, i32::from(mode.reads_data()));
        }
    }
}

impl Access for Hardware {
    fn read(&self, address: u16) -> Result<u8, Lost> {
        if self.direct {
            return ports::read(self.index, self.base, address);
        }
        let node = self.node.as_ref().ok_or(Lost::NONE)?;
        match register(address.wrapping_sub(self.base)) {
            Some(Register::Data) => READ_DATA.pass(node, 0),
            Some(Register::Status) => READ_STATUS.pass(node, 0),
            Some(Register::Control) => READ_CONTROL.pass(node, 0),
            None => Err(Lost::NONE),
        }
    }

    fn write(&self, address: u16, value: u8) -> Result<(), Lost> {
        if self.direct {
            return ports::write(self.index, self.base, address, value);
        }
        let node = self.node.as_ref().ok_or(Lost::NONE)?;
        match register(address.wrapping_sub(self.base)) {
            Some(Register::Data) => WRITE_DATA.pass(node, value)?,
            // The direction was set when the port was opened.
            Some(Register::Control) => WRITE_CONTROL.pass(node, value & 0x0F)?,
            Some(Register::Status) | None => return Err(Lost::NONE),
        };
        Ok(())
    }
}

const fn register(offset: u16) -> Option<Register> {
    match offset {
        0 => Some(Register::Data),
        1 => Some(Register::Status),
        2 => Some(Register::Control),
        _ => None,
    }
}

/// Finds a port in the kernel's list.
fn find(list: &Path, wanted: PortLocation) -> Option<Found> {
    // The kernel numbers ports from 0 and has few.
    (0..16).find_map(|number| {
        let text = fs::read_to_string(list.join(format!("parport{number}/base-addr"))).ok()?;
        let mut words = text.split_whitespace();
        let base = words.next()?.parse().ok()?;
        let high = words.next().and_then(|w| w.parse().ok()).unwrap_or(0);
        let is = match wanted {
            PortLocation::Address(address) => address == base,
            PortLocation::Kernel(n) => n == number,
        };
        is.then_some(Found { number, base, high })
    })
}

/// Opens a port's device node and claims it exclusively.
fn claim(nodes: &Path, number: u8) -> Result<File, Refused> {
    let node = nodes.join(format!("parport{number}"));
    let node =
        OpenOptions::new().read(true).write(true).open(node).map_err(|e| match e.kind() {
            ErrorKind::NotFound => Refused::NoNode(number),
            ErrorKind::PermissionDenied => Refused::Forbidden(number),
            _ => Refused::Broken(number, e.raw_os_error().unwrap_or(0)),
        })?;
    EXCLUSIVE.pass(&node, ()).map_err(|_| Refused::Taken(number))?;
    CLAIM.pass(&node, ()).map_err(|_| Refused::Taken(number))?;
    Ok(node)
}

/// Request to the kernel's device; `T` is the type that it reads or writes.
struct Request<T>(libc::Ioctl, PhantomData<T>);

const LETTER: u32 = b'p' as u32;
const READ_STATUS: Request<u8> = Request(libc::_IOR::<u8>(LETTER, 0x81), PhantomData);
const READ_CONTROL: Request<u8> = Request(libc::_IOR::<u8>(LETTER, 0x83), PhantomData);
const WRITE_CONTROL: Request<u8> = Request(libc::_IOW::<u8>(LETTER, 0x84), PhantomData);
const READ_DATA: Request<u8> = Request(libc::_IOR::<u8>(LETTER, 0x85), PhantomData);
const WRITE_DATA: Request<u8> = Request(libc::_IOW::<u8>(LETTER, 0x86), PhantomData);
const CLAIM: Request<()> = Request(libc::_IO(LETTER, 0x8B), PhantomData);
const EXCLUSIVE: Request<()> = Request(libc::_IO(LETTER, 0x8F), PhantomData);
const DIRECTION: Request<i32> = Request(libc::_IOW::<i32>(LETTER, 0x90), PhantomData);

impl<T> Request<T> {
    /// Executes the request with `value` as input. Returns the value that the kernel leaves in it.
    fn pass(&self, node: &File, mut value: T) -> Result<T, Lost> {
        // SAFETY: each request is declared with the type that the kernel reads or writes, and `value` has that type and
        // lives across the call.
        let done = unsafe { libc::ioctl(node.as_raw_fd(), self.0, &raw mut value) };
        if done < 0 { Err(last_error()) } else { Ok(value) }
    }
}

fn last_error() -> Lost {
    Lost(io::Error::last_os_error().raw_os_error().unwrap_or(0))
}

/// I/O port instructions. The kernel grants the permission per thread: a thread without it requests it at its first
/// access.
#[cfg(target_arch = "x86_64")]
mod ports {
    use super::last_error;
    use core::{arch::asm, cell::Cell};
    use port::Lost;

    /// Number of registers of a port.
    const COUNT: u16 = 3;

    thread_local! {
        /// Addresses of the ports that this thread may access, by port number.
        static GRANTED: Cell<[u16; 8]> = const { Cell::new([0; 8]) };
    }

    pub(super) fn allowed(index: usize, base: u16) -> bool {
        ask(index, base, base).is_ok()
    }

    pub(super) fn read(index: usize, base: u16, address: u16) -> Result<u8, Lost> {
        ask(index, base, address)?;
        let value: u8;
        // SAFETY: the thread has the permission for this port: `ask` has requested it.
        unsafe {
            asm!("in al, dx", out("al") value, in("dx") address, options(nomem, nostack, preserves_flags));
        }
        Ok(value)
    }

    pub(super) fn write(index: usize, base: u16, address: u16, value: u8) -> Result<(), Lost> {
        ask(index, base, address)?;
        output(address, value);
        Ok(())
    }

    /// Writes a register during setup, if that is permitted.
    pub(super) fn set_up(address: u16, value: u8) {
        if grant(address, 1).is_ok() {
            output(address, value);
        }
    }

    fn output(address: u16, value: u8) {
        // SAFETY: both callers have requested the permission for this port first.
        unsafe {
            asm!("out dx, al", in("dx") address, in("al") value, options(nomem, nostack, preserves_flags));
        }
    }

    fn ask(index: usize, base: u16, address: u16) -> Result<(), Lost> {
        if address.wrapping_sub(base) >= COUNT {
            return Err(Lost::NONE);
        }
        let mut granted = GRANTED.get();
        let Some(mine) = granted.get_mut(index) else { return Err(Lost::NONE) };
        if *mine != base {
            grant(base, COUNT)?;
            *mine = base;
            GRANTED.set(granted);
        }
        Ok(())
    }

    fn grant(base: u16, count: u16) -> Result<(), Lost> {
        let (base, count) = (core::ffi::c_ulong::from(base), core::ffi::c_ulong::from(count));
        // SAFETY: requests a permission from the kernel; no memory is passed.
        let done = unsafe { libc::syscall(libc::SYS_ioperm, base, count, 1) };
        if done < 0 { Err(last_error()) } else { Ok(()) }
    }
}

/// Processors without I/O ports: every access goes through the kernel.
#[cfg(not(target_arch = "x86_64"))]
mod ports {
    use port::Lost;

    pub(super) const fn allowed(_: usize, _: u16) -> bool {
        false
    }
    pub(super) const fn read(_: usize, _: u16, _: u16) -> Result<u8, Lost> {
        Err(Lost::NONE)
    }
    pub(super) const fn write(_: usize, _: u16, _: u16, _: u8) -> Result<(), Lost> {
        Err(Lost::NONE)
    }
    pub(super) const fn set_up(_: u16, _: u8) {}
}
