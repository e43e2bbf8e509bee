//! A simulated Mesa card: the bytes of its packets on one side, its terminals on the other.
//!
//! [`Card::answer`] takes a packet as the card's Ethernet port does, and [`Card::advance`] lets the card's time pass. The
//! registers behave as those of the hardware: step generators count, encoders follow what turns them, inputs are filtered,
//! the watchdog bites, remotes of smart serial answer. The descriptors and names of registers are those of
//! [`hal_firmware`], which the driver uses too.
//!
//! A [`FaultyLine`] loses, delays, doubles and cuts packets on request, by a seed. [`Recorded`] writes down what a packet does.
//! The program `hm2card` is the same over UDP.
#![forbid(unsafe_code)]

mod board;
mod card;
mod decode;
mod dpll;
mod encoder;
mod inputs;
mod line;
mod pins;
mod port;
mod pwm;
mod record;
mod relays;
mod remote;
mod serial;
mod spaces;
mod step;
mod timer;
mod watchdog;
mod world;

pub use board::{BadBoard, Board, BoardFault, Terminal, boards};
pub use card::{ADDRESS, Card, MAC};
pub use line::{Fate, FaultyLine, Rates};
pub use record::Recorded;
pub use remote::{BadRemote, Remote, remotes};
