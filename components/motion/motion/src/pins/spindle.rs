//! Pins of a spindle.

use super::pins;
use hal_component::{In, Io, Out};

pins! {
    /// Pins of one spindle.
    SpindlePins {
        /// TRUE to turn the spindle; FALSE while inhibit is TRUE.
        on: Out<bool> = false, "on" was "on";
        /// TRUE while speed-out is above zero.
        forward: Out<bool> = false, "forward" was "forward";
        /// TRUE while speed-out is below zero.
        reverse: Out<bool> = false, "reverse" was "reverse";
        /// TRUE to apply the spindle's brake: after the spindle was stopped, and whenever the machine goes off.
        brake: Out<bool> = false, "brake" was "brake";
        /// TRUE while the spindle is at rest at orient-angle, until a command turns, stops or orients it.
        locked: Out<bool> = false, "locked" was "locked";
        /// TRUE to turn the spindle to orient-angle, until is-oriented or a fault.
        orient: Out<bool> = false, "orient" was "orient";
        /// Speed command in turns per minute, negative in reverse, with the override applied, within the
        /// spindle's limits.
        speed_out: Out<f64> = 0.0, "speed-out" was "speed-out";
        /// Absolute value of speed-out, turns per minute.
        speed_out_abs: Out<f64> = 0.0, "speed-out-abs" was "speed-out-abs";
        /// speed-out in turns per second.
        speed_out_rps: Out<f64> = 0.0, "speed-out-rps" was "speed-out-rps";
        /// Absolute value of speed-out-rps, turns per second.
        speed_out_rps_abs: Out<f64> = 0.0, "speed-out-rps-abs" was "speed-out-rps-abs";
        /// Speed commanded in turns per second, before override and inhibit.
        speed_cmd_rps: Out<f64> = 0.0, "speed-cmd-rps" was "speed-cmd-rps";
        /// Distance of the axes from their place at the spindle, in units, from the lead-in of a thread or tap to its end;
        /// positive if the axes are behind.
        sync_error: Out<f64> = 0.0, "sync-error";
        /// Angle to turn to, in degrees, 0 to 360.
        orient_angle: Out<f64> = 0.0, "orient-angle" was "orient-angle";
        /// Direction of the turn to orient-angle: 0 the shorter, 1 clockwise, 2 counterclockwise.
        orient_mode: Out<i32> = 0, "orient-mode" was "orient-mode";
        /// Turns since the index: threads and taps follow them. An encoder's interpolated position gives smooth motion.
        revs: In<f64> = 0.0, "revs" was "revs";
        /// Measured speed, in turns per second: feeds per turn follow it. A spindle that turns faster than 0.1 is not locked by is-oriented.
        speed_in: In<f64> = 0.0, "speed-in" was "speed-in";
        /// TRUE when the spindle is at speed: no move begins while a spindle that is on is not at speed.
        at_speed: In<bool> = true, "at-speed" was "at-speed";
        /// TRUE from the spindle's amplifier when it has a fault: switches the machine off.
        amp_fault_in: In<bool> = false, "amp-fault-in" [safety];
        /// TRUE stops the spindle and keeps it stopped. A spindle that a program has turned turns again by a resume or a command,
        /// another one when the pin is FALSE.
        inhibit: In<bool> = false, "inhibit" was "inhibit";
        /// TRUE when the spindle is at rest at orient-angle, as commanded by `orient`; the pin counts while orient is
        /// TRUE and speed-in is not above 0.1 turns per second, and then the spindle is locked.
        is_oriented: In<bool> = false, "is-oriented" was "is-oriented";
        /// A number other than 0 while orient is TRUE aborts the orientation, and is reported to the operator.
        orient_fault: In<i32> = 0, "orient-fault" was "orient-fault";
        /// Handshake with the spindle's encoder: TRUE asks for the index, at which the encoder sets revs to 0 and this pin
        /// FALSE. Threads and taps begin there.
        index_enable: Io<bool> = false, "index-enable" was "index-enable";
    }
}
