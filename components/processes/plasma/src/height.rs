//! The height control that `thc` and `thcud` share: an offset of Z, reduced as Z rises with the torch off.

/// Offset of Z and its last commanded position, in single precision as in LinuxCNC.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Height {
    /// Offset added to Z, in machine units.
    pub(crate) offset: f32,
    last_z: f32,
}

/// Correction of the height in one cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction {
    /// True to lower Z.
    pub(crate) lowers: bool,
    /// True to raise Z; with `lowers`, after it.
    pub(crate) raises: bool,
    /// Distance, in machine units.
    pub(crate) by: f64,
}

impl Height {
    /// Corrects the offset while the torch is on and burns at speed, and reduces it while the torch is off. Returns
    /// whether it was reduced, or `None` while the torch is on.
    pub(crate) fn control(
        &mut self,
        torch_on: bool,
        burns: bool,
        z: f64,
        correction: &Correction,
    ) -> Option<bool> {
        if !torch_on {
            return Some(self.remove_offset(z));
        }
        if burns {
            if correction.lowers {
                self.correct(-correction.by);
            }
            if correction.raises {
                self.correct(correction.by);
            }
            // The next rise is measured from zero.
            self.last_z = 0.0;
        }
        None
    }

    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    fn correct(&mut self, by: f64) {
        self.offset = (f64::from(self.offset) + by) as f32;
    }

    /// Reduces the offset by the rise of Z in a cycle with the torch off. Returns whether it did.
    #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
    fn remove_offset(&mut self, z: f64) -> bool {
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

/// Returns whether the speed is above 0 and at most `tolerance` percent below the requested one, a limit that LinuxCNC
/// keeps in single precision.
#[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
pub(crate) fn is_at_speed(requested: f64, current: f64, tolerance: f64) -> bool {
    let lowest = f64::from((requested - requested * (tolerance * 0.01)) as f32);
    current > 0.0 && current >= lowest
}
