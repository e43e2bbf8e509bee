//! Simulated lines, whose faults are pins.

use super::Carrier;
use core::time::Duration;
use hal_component::{Builder, Error, In, Touch};
use hal_modbus_devices::{Bus, Device, Faults};
use port::{Exchange, Lost};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

/// Simulated line with its devices.
#[derive(Debug)]
pub(crate) struct SimulatedLine<D>(Arc<Mutex<Bus<D>>>);

impl<D> Clone for SimulatedLine<D> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<D: Device> SimulatedLine<D> {
    pub(crate) fn new(bus: Bus<D>) -> Self {
        Self(Arc::new(Mutex::new(bus)))
    }

    /// Returns the line. In virtual time nobody else holds it; with `--simulate`, the others hold it for microseconds.
    pub(crate) fn bus(&self) -> MutexGuard<'_, Bus<D>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<D> SimulatedLine<D> {
    /// Realtime. Returns the line unless another thread has it.
    pub(crate) fn try_bus(&self) -> Option<MutexGuard<'_, Bus<D>>> {
        match self.0.try_lock() {
            Ok(bus) => Some(bus),
            Err(TryLockError::Poisoned(bus)) => Some(bus.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

impl<D: Device> Exchange for SimulatedLine<D> {
    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        self.bus().send(packet);
        Ok(())
    }

    fn receive(&self, into: &mut [u8], _: Duration) -> Result<usize, Lost> {
        let came = self.bus().receive(into.len());
        into.iter_mut().zip(&came).for_each(|(to, byte)| *to = *byte);
        Ok(came.len())
    }

    fn advance(&self, now_ns: i64) {
        self.bus().advance(now_ns);
    }
}

impl<D: Device> Carrier for SimulatedLine<D> {
    /// A line that another thread has takes nothing: a realtime thread must not wait.
    fn send_now(&self, frame: &[u8], now_ns: i64) -> Result<(), Lost> {
        if let Some(mut bus) = self.try_bus() {
            bus.advance(now_ns);
            bus.send(frame);
        }
        Ok(())
    }

    fn send_later(&self, frame: &[u8], wait: Duration, now_ns: i64) -> bool {
        if let Some(mut bus) = self.try_bus() {
            bus.advance(now_ns);
            bus.send_later(frame, i64::try_from(wait.as_nanos()).unwrap_or(i64::MAX));
        }
        true
    }
}

/// Pins that are faults of a simulated line.
#[derive(Debug, Touch)]
pub(crate) struct SimulatedFaultPins {
    cut: In<bool>,
    noise: In<f64>,
    half: In<f64>,
    other: In<f64>,
    delay: In<f64>,
}

impl SimulatedFaultPins {
    pub(crate) fn make(b: &mut Builder<'_>, prefix: &str) -> Result<Self, Error> {
        let name = |pin| format!("{prefix}.sim.{pin}");
        Ok(Self {
            cut: b.simulated(
                &name("cut"),
                "TRUE cuts the simulated line: nothing arrives.",
                false,
            )?,
            noise: b.simulated(
                &name("noise"),
                "Share of simulated answers with noise and a wrong bit, 0 to 1.",
                0.0,
            )?,
            half: b.simulated(
                &name("half"),
                "Share of simulated answers of which only half arrives, 0 to 1.",
                0.0,
            )?,
            other: b.simulated(
                &name("other"),
                "Share of simulated answers that another device gives, 0 to 1.",
                0.0,
            )?,
            delay: b.simulated(
                &name("delay"),
                "Time by which simulated answers are late, in seconds.",
                0.0,
            )?,
        })
    }

    /// Realtime. Returns what the pins say.
    pub(crate) fn faults(&self) -> Faults {
        Faults {
            cut: self.cut.get(),
            noise: self.noise.get(),
            half: self.half.get(),
            other: self.other.get(),
            delay: self.delay.get(),
        }
    }
}
