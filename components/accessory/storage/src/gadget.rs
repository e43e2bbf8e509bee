//! The USB device that presents an image to the host.

use crate::bay::Side;
use std::{
    fs::{self, OpenOptions},
    io::{self, ErrorKind, Write as _},
    path::{Path, PathBuf},
};

/// Reason why an image is not ejected.
#[derive(Debug)]
pub enum NotEjected {
    /// The host holds it.
    Busy,
    /// The device fails.
    Failed(io::Error),
}

/// USB device with one medium.
pub trait Gadget {
    /// Presents an image, also after a process before this one has left another.
    ///
    /// # Errors
    /// The device does not take it, or the host holds the other one.
    fn present(&mut self, side: Side) -> io::Result<()>;

    /// Takes the image from the host.
    ///
    /// # Errors
    /// The host holds it, or the device fails.
    fn eject(&mut self) -> Result<(), NotEjected>;

    /// Takes the image from the host, whatever the host does with it.
    ///
    /// # Errors
    /// The device fails.
    fn force_eject(&mut self) -> io::Result<()>;
}

/// The function `mass_storage` of Linux' USB gadgets, below `/sys/kernel/config/usb_gadget`. The medium is read-only for the host.
#[derive(Clone, Debug)]
pub struct Configfs {
    /// The folder `lun.0`.
    lun: PathBuf,
    images: [PathBuf; 2],
}

impl Configfs {
    /// Returns the device whose function is this folder, such as `…/g1/functions/mass_storage.0`, for images A and B.
    ///
    /// # Errors
    /// The folder has no `lun.0/file`, or an image's path is not absolute.
    pub fn new(function: &Path, images: [PathBuf; 2]) -> io::Result<Self> {
        let lun = function.join("lun.0");
        fs::metadata(lun.join("file"))?;
        if images.iter().any(|path| !path.is_absolute()) {
            return Err(io::Error::new(ErrorKind::InvalidInput, "an image's path is not absolute"));
        }
        Ok(Self { lun, images })
    }

    fn get(&self, attribute: &str) -> io::Result<String> {
        Ok(fs::read_to_string(self.lun.join(attribute))?.trim_end().to_owned())
    }

    fn set(&self, attribute: &str, text: &str) -> io::Result<()> {
        // An attribute is written by one call, and never made.
        let mut file =
            OpenOptions::new().write(true).truncate(true).open(self.lun.join(attribute))?;
        file.write_all(format!("{text}\n").as_bytes())
    }
}

impl Gadget for Configfs {
    fn present(&mut self, side: Side) -> io::Result<()> {
        let [a, b] = &self.images;
        let path = if side == Side::A { a } else { b };
        let text = path.to_str();
        let text =
            text.ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "the path is not UTF-8"))?;
        // What a process before this one has presented stays if it is this image. The kernel refuses `ro` beside any image.
        let (shown, is_read_only) = (self.get("file")?, self.get("ro")? == "1");
        if shown == text && is_read_only {
            return Ok(());
        }
        if !shown.is_empty() {
            self.set("file", "")?;
        }
        if !is_read_only {
            self.set("ro", "1")?;
        }
        self.set("file", text)
    }

    fn eject(&mut self) -> Result<(), NotEjected> {
        self.set("file", "").map_err(|e| match e.kind() {
            ErrorKind::ResourceBusy => NotEjected::Busy,
            _ => NotEjected::Failed(e),
        })
    }

    fn force_eject(&mut self) -> io::Result<()> {
        self.set("forced_eject", "1")
    }
}
