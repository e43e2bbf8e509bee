//! Reasons why lines cannot be opened.

use crate::label::Label;
use core::fmt;
use port::Lost;
use std::io;

/// Reason why a line or its chip is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// The computer has no chip.
    NoChips,
    /// The computer has no chip of this number.
    NoChip(u32),
    /// The computer has no chip that drives the header of a Raspberry Pi.
    NoHeader,
    /// The user may not open a chip.
    Forbidden(u32),
    /// The kernel has no second version of the interface.
    Old(u32),
    /// A chip cannot be read.
    Broken(u32, Lost),
    /// No chip has a line of this name.
    Unknown { name: Label, near: Option<Label> },
    /// Two lines have this name, as chip and number.
    Ambiguous { name: Label, lines: [(u32, u32); 2] },
    /// A chip has fewer lines.
    Beyond { chip: u32, offset: u32, lines: u32 },
    /// Two names mean the same line.
    Same { names: [Label; 2], chip: u32, offset: u32 },
    /// Another program, or a driver of the kernel, has the line.
    Held { name: Label, chip: u32, offset: u32, consumer: Label },
    /// The chip cannot do what the arguments ask for.
    Unable { chip: u32, lost: Lost, bias: bool, drive: bool },
    /// Lines of an encoder are on two chips.
    Apart(Label, Label),
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoChips => write!(
                f,
                "this computer has no GPIO chip: /dev has no gpiochip0; load the driver of the \
                 board's or the adapter's chip"
            ),
            Self::NoChip(chip) => {
                write!(
                    f,
                    "/dev/gpiochip{chip} is missing: gpiodetect lists the chips that are there"
                )
            }
            Self::NoHeader => write!(
                f,
                "no chip drives the header of a Raspberry Pi (pinctrl-bcm2835, pinctrl-bcm2711 or \
                 pinctrl-rp1): use hal_gpio on other boards"
            ),
            Self::Forbidden(chip) => write!(
                f,
                "/dev/gpiochip{chip} may not be opened: run as a user in group gpio (usermod -aG \
                 gpio NAME, then log in again); without that group: groupadd gpio, and a udev rule \
                 SUBSYSTEM==\"gpio\", GROUP=\"gpio\", MODE=\"0660\""
            ),
            Self::Old(chip) => write!(
                f,
                "/dev/gpiochip{chip} does not know version 2 of the GPIO interface: it needs Linux \
                 5.10 or later"
            ),
            Self::Broken(chip, lost) => {
                write!(f, "/dev/gpiochip{chip} cannot be used: {}", reason(*lost))
            }
            Self::Unknown { name, near } => {
                write!(f, "no GPIO chip has a line '{name}'")?;
                if let Some(near) = near {
                    write!(f, " (did you mean '{near}'?)")?;
                }
                write!(
                    f,
                    ": gpioinfo lists all names, and a line without a name is gpiochipN.LINE, such \
                     as gpiochip0.17"
                )
            }
            Self::Ambiguous { name, lines: [(a, b), (c, d)] } => write!(
                f,
                "two lines are named '{name}': name it by its chip, as gpiochip{a}.{b} or \
                 gpiochip{c}.{d}"
            ),
            Self::Beyond { chip, offset, lines } => {
                write!(f, "gpiochip{chip} has no line {offset}: it has {lines} lines, from 0")
            }
            Self::Same { names: [one, other], chip, offset } => {
                write!(f, "'{one}' and '{other}' are the same line, gpiochip{chip}.{offset}")
            }
            Self::Held { name, chip, offset, consumer } => {
                let holder =
                    if consumer.is_empty() { &"the kernel" } else { consumer as &dyn fmt::Display };
                write!(
                    f,
                    "line '{name}' (gpiochip{chip}.{offset}) is held by '{holder}': end that \
                     program or unload that driver, or take another line"
                )
            }
            Self::Unable { chip, lost, bias, drive } => {
                write!(f, "gpiochip{chip} refuses its lines: {}", reason(*lost))?;
                match (bias, drive) {
                    (false, false) => Ok(()),
                    (true, false) => write!(f, "; it may lack pullup=, pulldown= and biasdisable="),
                    (false, true) => write!(f, "; it may lack opendrain= and opensource="),
                    (true, true) => write!(
                        f,
                        "; it may lack pullup=, pulldown=, biasdisable=, opendrain= and opensource="
                    ),
                }
            }
            Self::Apart(one, other) => write!(
                f,
                "'{one}' and '{other}' are on different chips, so that the order of their edges is \
                 unknown: an encoder needs lines of one chip"
            ),
        }?;
        write!(f, "; or run with --simulate")
    }
}

fn reason(lost: Lost) -> io::Error {
    io::Error::from_raw_os_error(lost.0)
}
