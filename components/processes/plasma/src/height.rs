//! Offset of Z shared by the torch height controls, reduced as Z rises with the torch off.

/// Offset of Z and its last commanded position, in single precision as in LinuxCNC.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Height {
    /// Offset added to Z, in machine units.
    pub(crate) offset: f32,
    last_z: f32,
}

impl Height {
    /// Adds `by` to the offset in a cycle with the torch on. The caller also resets the last Z with `forget`.
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    pub(crate) fn correct(&mut self, by: f64) {
        self.offset = (f64::from(self.offset) + by) as f32;
    }

    /// Resets the last Z to zero, so that the next `take_back` measures the rise from there.
    pub(crate) fn forget(&mut self) {
        self.last_z = 0.0;
    }

    /// Reduces the offset by the rise of Z in a cycle with the torch off. Returns whether it did.
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

/// Rounds to single precision, as LinuxCNC keeps the value.
#[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
pub(crate) fn single(number: f64) -> f64 {
    f64::from(number as f32)
}
