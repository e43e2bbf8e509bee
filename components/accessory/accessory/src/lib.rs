//! An accessory in the cable between a closed controller and its handheld.
//!
//! | module | subject |
//! |---|---|
//! | `keypad`, `presses`, `pipe` | physical and virtual keys; presses that wait; the pipe whose lines press keys |
//! | `lcd_reader`, `readers` | the display as text; the socket for its readers |
//! | `usbjobs`, `usb_orders`, `programs_folder` | jobs on a medium with two images; its commands; a folder whose files are jobs |
//! | `sim_nk105`, `sim_medium`, `sim_handheld` | the controller and the handheld, simulated |
//! | `format` | arguments that describe the frames of a handheld |
//! | `device`, `packed` | serial lines and other character devices; bytes in the words of records |
#![forbid(unsafe_code)]

mod device;
mod format;
mod keypad;
mod lcd_reader;
mod packed;
mod pipe;
mod presses;
mod programs_folder;
mod readers;
mod sim_handheld;
mod sim_medium;
mod sim_nk105;
mod usb_orders;
mod usbjobs;

hal_component::export!(
    keypad::KeypadComponent,
    lcd_reader::LcdReader,
    sim_handheld::SimHandheld,
    sim_nk105::SimNk105,
    usbjobs::UsbJobs,
);

#[cfg(test)]
mod tests;
