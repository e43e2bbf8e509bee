//! Modules of a firmware.

use crate::{Identification, Tag};

/// Descriptor of a module: three registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Module {
    /// Number of its kind; 0 ends the table of modules.
    pub tag: u8,
    /// Version of its registers.
    pub version: u8,
    /// Clock that it counts.
    pub clock: Clock,
    /// Number of its instances.
    pub instances: u8,
    /// Address of its first register.
    pub base: u16,
    /// Number of its registers.
    pub registers: u8,
    /// Number of the stride of its registers, 0 or 1.
    pub register_stride: u8,
    /// Number of the stride of its instances, 0 or 1.
    pub instance_stride: u8,
    /// Bit N is 1 if each instance has a register N of its own, and 0 if all share one.
    pub multiple: u32,
}

/// Clock of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The slower one.
    Low,
    /// The faster one.
    High,
    /// Neither, by this number.
    Unknown(u8),
}

impl Module {
    /// Number of registers of a descriptor.
    pub const REGISTERS: usize = 3;

    /// Reads a descriptor. Every one is readable; whether it makes sense is for its user to say.
    #[must_use]
    pub const fn parse(words: [u32; Self::REGISTERS]) -> Self {
        let [first, second, multiple] = words;
        let [tag, version, clock, instances] = first.to_le_bytes();
        let [base_low, base_high, registers, strides] = second.to_le_bytes();
        Self {
            tag,
            version,
            clock: match clock {
                1 => Clock::Low,
                2 => Clock::High,
                other => Clock::Unknown(other),
            },
            instances,
            base: u16::from_le_bytes([base_low, base_high]),
            registers,
            register_stride: strides & 0x0F,
            instance_stride: strides >> 4,
            multiple,
        }
    }

    /// Returns the registers of the descriptor.
    #[must_use]
    pub const fn to_words(&self) -> [u32; Self::REGISTERS] {
        let clock = match self.clock {
            Clock::Low => 1,
            Clock::High => 2,
            Clock::Unknown(other) => other,
        };
        let [base_low, base_high] = self.base.to_le_bytes();
        let strides = self.instance_stride << 4 | self.register_stride & 0x0F;
        [
            u32::from_le_bytes([self.tag, self.version, clock, self.instances]),
            u32::from_le_bytes([base_low, base_high, self.registers, strides]),
            self.multiple,
        ]
    }

    /// Returns the kind of the module, if it is known.
    #[must_use]
    pub const fn kind(&self) -> Option<Tag> {
        Tag::from_number(self.tag)
    }

    /// Returns the frequency of its clock in hertz, if it has one.
    #[must_use]
    pub const fn clock_hz(&self, of: &Identification) -> Option<u32> {
        match self.clock {
            Clock::Low => Some(of.clock_low),
            Clock::High => Some(of.clock_high),
            Clock::Unknown(_) => None,
        }
    }

    /// Returns the address of register `register` of instance `instance`; `None` if it would be beyond the last address,
    /// or if the module has no such register or instance.
    #[must_use]
    pub fn address(&self, of: &Identification, register: u8, instance: u8) -> Option<u16> {
        if register >= self.registers || instance >= self.instances {
            return None;
        }
        let stride = |strides: [u32; 2], which: u8| strides.get(usize::from(which)).copied();
        let own = self.multiple >> register.min(31) & 1 == 1;
        let register =
            stride(of.register_strides, self.register_stride)?.checked_mul(u32::from(register))?;
        let instance = if own {
            stride(of.instance_strides, self.instance_stride)?.checked_mul(u32::from(instance))?
        } else {
            0
        };
        let at = u32::from(self.base).checked_add(register)?.checked_add(instance)?;
        u16::try_from(at).ok().filter(|at| at % 4 == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::idrom::tests::GOOD;

    #[test]
    fn a_descriptor_is_its_registers() {
        let words = [0x0502_0105, 0x000B_2000, 0x0000_03FF];
        let module = Module::parse(words);
        assert_eq!((module.tag, module.version, module.instances), (5, 1, 5));
        assert_eq!((module.clock, module.base, module.registers), (Clock::High, 0x2000, 11));
        assert_eq!(module.to_words(), words);
        assert_eq!(
            Module::parse([0x0103_00FF, 0x1201_0000, 1]).to_words(),
            [0x0103_00FF, 0x1201_0000, 1]
        );
    }

    #[test]
    fn addresses_follow_the_strides() {
        let own = Module {
            tag: 5,
            version: 2,
            clock: Clock::Low,
            instances: 5,
            base: 0x2000,
            registers: 10,
            register_stride: 0,
            instance_stride: 0,
            multiple: 0x1FF,
        };
        // (module, register, instance, address)
        let wide = Module { instance_stride: 1, register_stride: 1, ..own };
        let rows = [
            (own, 0, 0, Some(0x2000)),
            (own, 1, 4, Some(0x2110)),
            (own, 9, 4, Some(0x2900)),
            (own, 10, 0, None),
            (own, 0, 5, None),
            (wide, 1, 2, Some(0x2084)),
            (Module { register_stride: 2, ..own }, 1, 0, None),
            (Module { base: 0xFFFC, ..own }, 1, 0, None),
            (Module { base: 0x2001, ..own }, 0, 0, None),
        ];
        for (module, register, instance, address) in rows {
            assert_eq!(module.address(&GOOD, register, instance), address, "{register} {instance}");
        }
    }
}
