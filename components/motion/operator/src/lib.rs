//! The operator: pins for knobs, switches and lamps, and pins for the settings of an INI file.
#![forbid(unsafe_code)]

mod halui;
mod inihal;
mod pins;

pub use halui::Halui;
pub use inihal::Inihal;

hal_component::export!(Halui, Inihal);

#[cfg(test)]
mod tests;
