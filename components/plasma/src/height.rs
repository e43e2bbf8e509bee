//! What the torch height controls have in common: an offset of Z that is taken back as Z rises.

/// The offset, and where Z was. Single precision, as in LinuxCNC.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Height {
    /// What is added to Z, in machine units.
    pub(crate) offset: f32,
    last_z: f32,
}

impl Height {
    /// A cycle with the torch on: `by` is added, and the way of Z begins anew.
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    pub(crate) fn correct(&mut self, by: f64) {
        self.offset = (f64::from(self.offset) + by) as f32;
    }

    /// Z counts from zero when the torch goes off.
    pub(crate) fn forget(&mut self) {
        self.last_z = 0.0;
    }

    /// A cycle with the torch off: the offset shrinks by as much as Z rises. Whether it did.
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    pub(crate) fn take_back(&mut self, z: f64) -> bool {
        let rise = (z - f64::from(self.last_z)) as f32;
        self.last_z = z as f32;
        if !(rise > 0.0 && self.offset != 0.0) {
            return false;
        }
        if self.offset > 0.0 {
            self.offset = if self.offset > rise { self.offset - rise } else { 0.0 };
        }
        if self.offset < 0.0 {
            self.offset = if self.offset < rise { self.offset + rise } else { 0.0 };
        }
        true
    }
}

/// In single precision, as LinuxCNC keeps it.
#[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
pub(crate) fn single(number: f64) -> f64 {
    f64::from(number as f32)
}
