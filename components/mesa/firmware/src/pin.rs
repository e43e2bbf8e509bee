//! I/O pins of a firmware.

use crate::Tag;

/// Descriptor of an I/O pin: one register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Number of the module's pin, from 1; 0 if the pin is an I/O pin only.
    pub number: u8,
    /// True if the module drives it.
    pub is_output: bool,
    /// Tag of the module that may use it; 0 for none.
    pub tag: u8,
    /// Instance of the module, or 0x80 and more for a pin that all instances share.
    pub instance: u8,
    /// Tag of what it is without the module: the I/O port.
    pub primary: u8,
}

impl Pin {
    /// Reads a descriptor. Every one is readable.
    #[must_use]
    pub const fn parse(word: u32) -> Self {
        let [pin, tag, instance, primary] = word.to_le_bytes();
        Self { number: pin & 0x7F, is_output: pin & 0x80 != 0, tag, instance, primary }
    }

    /// Returns the register.
    #[must_use]
    pub const fn to_word(&self) -> u32 {
        let pin = self.number & 0x7F | (self.is_output as u8) << 7;
        u32::from_le_bytes([pin, self.tag, self.instance, self.primary])
    }

    /// Returns a pin that is only an I/O pin.
    #[must_use]
    pub const fn plain() -> Self {
        Self { number: 0, is_output: false, tag: 0, instance: 0, primary: Tag::IoPort as u8 }
    }

    /// Returns whether all instances of the module share the pin.
    #[must_use]
    pub const fn is_shared(&self) -> bool {
        self.instance & 0x80 != 0
    }

    /// Returns the kind of the module that may use the pin, if there is one and it is known.
    #[must_use]
    pub const fn kind(&self) -> Option<Tag> {
        Tag::from_number(self.tag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_its_register() {
        // The descriptor of a step output of the first step generator, and of a plain pin.
        let step = Pin::parse(0x0300_0581);
        assert_eq!((step.number, step.is_output, step.instance), (1, true, 0));
        assert_eq!((step.kind(), step.primary), (Some(Tag::StepGenerator), 3));
        assert_eq!(step.to_word(), 0x0300_0581);
        assert_eq!(Pin::plain().to_word(), 0x0300_0000);
        assert!(Pin::parse(0x0380_0481).is_shared());
    }
}
