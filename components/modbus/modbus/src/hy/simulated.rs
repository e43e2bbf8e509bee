//! Pins of the simulated inverter and its line.

use crate::line::{SimulatedFaultPins, SimulatedLine};
use hal_component::{Builder, Error, In, Out, Touch};
use hal_modbus::nanoseconds;
use hal_modbus_devices::Inverter;

/// Line with one inverter.
pub(crate) type InverterLine = SimulatedLine<Inverter>;

/// Pins of the simulated inverter and its line.
#[derive(Debug, Touch)]
pub(crate) struct SimulatedPins {
    faults: SimulatedFaultPins,
    trip: In<bool>,
    timeout: In<f64>,
    frequency: Out<f64>,
    running: Out<bool>,
    starts: Out<u32>,
    frames: Out<u32>,
    #[state]
    line: InverterLine,
}

impl SimulatedPins {
    pub(crate) fn make(
        b: &mut Builder<'_>,
        prefix: &str,
        line: InverterLine,
    ) -> Result<Self, Error> {
        let name = |pin| format!("{prefix}.sim.{pin}");
        Ok(Self {
            faults: SimulatedFaultPins::make(b, prefix)?,
            trip: b.simulated(&name("trip"),
                "TRUE trips the simulated inverter: its output is off. FALSE resets it, as at its panel: the next command to run starts it.",
                false,
            )?,
            timeout: b.simulated(&name("timeout"),
                "Time without a frame after which the simulated inverter stops by its own clock, in seconds; 0 for never.",
                0.0,
            )?,
            frequency: b.simulated(&name("frequency"),
                "Frequency at the output of the simulated inverter, in hertz, negative in reverse.",
                0.0,
            )?,
            running: b.simulated(&name("running"), "TRUE while the simulated inverter runs.", false)?,
            starts: b.simulated(&name("starts"),
                "Number of times that the simulated inverter has begun to run.",
                0,
            )?,
            frames: b.simulated(&name("frames"),
                "Number of frames that the simulated inverter has heard.",
                0,
            )?,
            line,
        })
    }

    /// Realtime. Gives the simulation the faults that the pins say, and shows its true state. The worker lets its time pass; one
    /// that stands still does not, and then this does. While the worker has the line, the pins keep their values for a cycle.
    pub(crate) fn exchange(&mut self, now: i64, stands_still: bool) {
        let Some(mut bus) = self.line.try_bus() else { return };
        if stands_still {
            bus.advance(now);
        }
        bus.faults = self.faults.faults();
        bus.devices.trip = self.trip.get();
        bus.devices.timeout_ns = nanoseconds(self.timeout.get());
        self.frequency.set(bus.devices.hz());
        self.running.set(bus.devices.runs());
        self.starts.set(bus.devices.starts());
        self.frames.set(bus.devices.frames());
    }
}
