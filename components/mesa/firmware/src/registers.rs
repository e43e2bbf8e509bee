//! Registers of each kind of module, in the order of their addresses.
//!
//! The address of a register follows from its place in the table, the module's base and the firmware's strides
//! ([`Module::address`](crate::Module::address)).

use crate::Tag;

/// Register of a module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register {
    /// Kind of the module.
    pub of: Tag,
    /// Place among the module's registers, from 0.
    pub index: u8,
    /// Name in documents.
    pub name: &'static str,
    /// Meaning of its bits.
    pub doc: &'static str,
}

macro_rules! registers {
    ($($(#[doc = $group:literal])* $of:ident { $($name:ident $index:literal $doc:literal;)* })*) => {
        $($(
            #[doc = $doc]
            pub const $name: Register =
                Register { of: Tag::$of, index: $index, name: stringify!($name), doc: $doc };
        )*)*
        /// All registers.
        pub const ALL: &[Register] = &[$($($name,)*)*];
    };
}

registers! {
    Watchdog {
        WATCHDOG_TIMEOUT 0 "Time until the watchdog bites, in periods of its clock, less one; bit 31 switches it off.";
        WATCHDOG_STATUS 1 "Bit 0 is 1 once it has bitten: all I/O pins are inputs. Writing 0 releases them.";
        WATCHDOG_RESET 2 "Writing `0x5A00_0000` lets the time begin again.";
    }
    IoPort {
        PORT_DATA 0 "Levels of the pins: read from outside, written for outputs.";
        PORT_DIRECTION 1 "1 for each pin that is an output.";
        PORT_SOURCE 2 "1 for each pin that its module drives in place of the data register.";
        PORT_OPEN_DRAIN 3 "1 for each output that only pulls down.";
        PORT_INVERT 4 "1 for each output that is inverted.";
    }
    Encoder {
        ENCODER_COUNT 0 "Bits 0 to 15: counts. Bits 16 to 31: time stamp of the last count.";
        ENCODER_CONTROL 1 "Modes, polarities and arming of index and probe; reads as the levels of the inputs and what was latched.";
        ENCODER_STAMP_DIVISOR 2 "Periods of the clock of one time stamp, less two.";
        ENCODER_STAMP 3 "Present time stamp, 16 bits.";
        ENCODER_FILTER_RATE 4 "Periods of the clock of one sample of the inputs, less two.";
        ENCODER_TIMER 5 "Timer of the clock that latches the counts, in bits 12 to 14; bit 15 enables it. The descriptor does not count this register.";
    }
    MuxedEncoder {
        MUXED_COUNT 0 "As `ENCODER_COUNT`.";
        MUXED_CONTROL 1 "As `ENCODER_CONTROL`.";
        MUXED_STAMP_DIVISOR 2 "As `ENCODER_STAMP_DIVISOR`.";
        MUXED_STAMP 3 "As `ENCODER_STAMP`.";
        MUXED_FILTER_RATE 4 "As `ENCODER_FILTER_RATE`.";
        MUXED_TIMER 5 "As `ENCODER_TIMER`.";
    }
    StepGenerator {
        STEP_RATE 0 "Signed: added to the accumulator with each tick of the clock, in 2^-32 counts.";
        STEP_ACCUMULATOR 1 "Position: bits 16 to 31 are counts, bits 0 to 15 the fraction.";
        STEP_MODE 2 "0 step and direction, 1 up and down, 2 quadrature, 3 and above a table; index and probe from bit 8 on.";
        STEP_SETUP 3 "Periods of the clock from a change of direction to a step.";
        STEP_HOLD 4 "Periods of the clock from a step to a change of direction.";
        STEP_LENGTH 5 "Periods of the clock that a step lasts.";
        STEP_SPACE 6 "Least periods of the clock between two steps.";
        STEP_TABLE_DATA 7 "Levels of the pins, one byte of a table of 16.";
        STEP_TABLE_LENGTH 8 "Length of the table, less one.";
        STEP_MASTER_RATE 9 "Added to the ticks of all generators; `0xFFFF_FFFF` lets every period of the clock be a tick.";
        STEP_TIMER 10 "Timer of the clock that latches the accumulators, in bits 12 to 14; bit 15 enables it. The descriptor does not count this register.";
    }
    Pwm {
        PWM_VALUE 0 "Bits 16 to 27: duty. Bits 12 to 15: its fraction. Bit 31: direction.";
        PWM_MODE 1 "Bits 0 and 1: width, 9 to 12 bits. Bit 2: symmetrical. Bits 3 and 4: form of the outputs. Bit 5: new values begin with a period. Bit 6: fraction.";
        PWM_RATE 2 "Rate of all generators of pulse width.";
        PWM_PDM_RATE 3 "Rate of all generators of pulse density.";
        PWM_ENABLE 4 "1 for each generator that is enabled.";
    }
    Dpll {
        DPLL_BASE_RATE 0 "Rate at which the clock runs alone.";
        DPLL_PHASE_ERROR 1 "Phase at the last read, signed, in 2^-32 periods.";
        DPLL_CONTROL_0 2 "Bits 0 to 23: limit of the change. Bits 24 to 31: prescale.";
        DPLL_CONTROL_1 3 "Bits 16 to 31: time constant. Bits 0 to 7 read as the width of the phase in bits.";
        DPLL_TIMERS_12 4 "Timers 1 and 2, 16 bits each.";
        DPLL_TIMERS_34 5 "Timers 3 and 4, 16 bits each.";
        DPLL_SYNC 6 "A read or a write is the moment that the clock follows.";
    }
    Ssr {
        SSR_DATA 0 "1 for each relay that is on.";
        SSR_RATE 1 "Bits 0 to 11: rate of the chopper of all relays. Bit 12 enables it.";
    }
    Outputs {
        OUTPUTS_DATA 0 "1 for each output that is on.";
    }
    Inputs {
        INPUTS_CONTROL 0 "Bits 0 to 4 read as the number of inputs, less one. Bit 5 inverts all. Bits 6 to 15: rate of the samples. Bits 16 to 21: samples of the short filter. Bits 22 to 31: samples of the long filter.";
        INPUTS_FILTER 1 "1 for each input with the long filter.";
        INPUTS_FILTERED 2 "Levels behind the filter.";
        INPUTS_RAW 3 "Levels at the pins.";
        INPUTS_WHEELS 4 "Counts of four hand wheels, 8 bits each.";
    }
    InputMux {
        INMUX_CONTROL 0 "As `INPUTS_CONTROL`.";
        INMUX_FILTER 1 "1 for each input with the long filter.";
        INMUX_FILTERED 2 "Levels behind the filter.";
        INMUX_RAW 3 "Levels at the pins.";
        INMUX_WHEELS 4 "Counts of four hand wheels, 8 bits each.";
    }
    Led {
        LED_DATA 0 "Bits 24 to 31: 1 for each light that is on.";
    }
    SmartSerial {
        SERIAL_COMMAND 0 "Command to the port's processor; 0 when it is done.";
        SERIAL_DATA 1 "Address or data of a command, or faults.";
        SERIAL_STATUS 2 "State of each channel; written: command and address for a remote.";
        SERIAL_USER_0 3 "Process data of a channel, first 32 bits.";
        SERIAL_USER_1 4 "Process data of a channel, next 32 bits.";
        SERIAL_USER_2 5 "Process data of a channel, last 32 bits.";
    }
}

/// Returns the registers of a kind of module.
pub fn of(tag: Tag) -> impl Iterator<Item = &'static Register> {
    ALL.iter().filter(move |register| register.of == tag)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_stand_in_the_order_of_their_addresses() {
        for tag in Tag::all() {
            for (at, register) in of(tag).enumerate() {
                assert_eq!(usize::from(register.index), at, "{}", register.name);
                assert!(register.doc.ends_with('.'), "{}", register.name);
            }
        }
        assert!(Tag::all().filter(|tag| of(*tag).next().is_some()).count() >= 12);
    }
}
