//! Digital lines of boards with a VIA VX900.
//!
//! The chip's registers and its setup are in `chip`. The real chip is accessed in `hardware`, the only module with
//! unsafe code; the simulated one is [`Simulated`].
#![deny(unsafe_code)]

mod chip;
mod device;
#[cfg_attr(
    target_arch = "x86_64",
    expect(unsafe_code, reason = "I/O ports are the processor's, not the language's")
)]
mod hardware;
mod lines;
#[cfg(test)]
mod tests;

use crate::{
    device::Device,
    hardware::CONFIG,
    lines::{Input, Output},
};
use hal_component::{
    Builder, Component, Error, Out, Period, Touch, Update,
    abi::{ItemSpec, component_flags},
};
use port::{Driven, Report, Shown, Simulated};
use std::{path::Path, sync::Arc};

/// Component `hal_viagpio`.
pub(crate) enum Viagpio {}

hal_component::export!(Viagpio);

impl Component for Viagpio {
    const NAME: &'static str = "hal_viagpio";
    const DOC: &'static str = "\
The digital lines of boards with a VIA VX900, such as the EPIA-P830: four in, four out.

| pin | signal | connector pin |
|---|---|---|
| `viagpio.pin-01-in` | GPI4 | 24 |
| `viagpio.pin-02-in` | GPI5 | 22 |
| `viagpio.pin-03-in` | GPI8 | 18 |
| `viagpio.pin-04-in` | GPI9 | 20 |
| `viagpio.pin-05-out` | GPO12 | 21 |
| `viagpio.pin-06-out` | GPIO1 | 23 |
| `viagpio.pin-07-out` | GPIO9 | 19 |
| `viagpio.pin-08-out` | GPIO12 | 17 |

Connector pins 25 and 26 are ground. `viagpio.read` takes two reads of a byte, `viagpio.write`
three writes; bits that are not lines keep the value that they had at the load. There is no reset
function, so that step pulses need a `stepspace` of one period.

The load makes the lines outputs, after it has made sure that PCI device 00:11.0 is a VX900
(1106:8410) and before anything else is written. It needs root. The simulated chip shows its
registers as `viagpio.sim.*`, raw bytes and bits.

When the machine stops, every output goes to the level of FALSE.

# Example

```hal
loadrt hal_viagpio
loadrt threads name1=servo period1=1000000
addf viagpio.read servo
addf viagpio.write servo
start
setp viagpio.pin-05-out 1
run 1ms
getp viagpio.pin-05-out # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ITEMS: &'static [&'static ItemSpec] = lines::ITEMS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let device = Arc::new(Device::new(b)?);
        let report = Report::new(b, 0);
        let asks = device.simulated().map(Simulated::read_from);
        let sets = device.simulated().map(Simulated::written);

        let lines = lines::inputs(b)?;
        let read = Read { device: device.clone(), lines, asks, report: report.clone() };
        b.function("viagpio.read", "Reads the four inputs", read)?;

        let lines = lines::outputs(b)?;
        let write = Write { device: device.clone(), lines: lines.clone(), sets, report };
        b.function("viagpio.write", "Writes the four outputs", write)?;

        let opened = device.clone();
        b.on_open(move |_| {
            opened.open(Path::new(CONFIG)).map_err(|why| Error::new(format!("viagpio: {why}")))
        })?;
        b.on_stop(move || {
            let (_, idle) = lines::levels(&lines);
            // A lost device cannot be stopped; the write function reports it.
            let _ = device.write(idle, idle);
        })
    }
}

#[derive(Touch)]
struct Read {
    #[state]
    device: Arc<Device>,
    lines: Vec<Input>,
    asks: Option<(Vec<Driven>, Out<u32>)>,
    report: Report,
}

impl Update for Read {
    fn update(&mut self, _: Period) {
        let done = self.device.read().map(|registers| lines::take(&self.lines, registers));
        self.report.note(done, "error {} when reading viagpio: its inputs keep their values");
    }
}

#[derive(Touch)]
struct Write {
    #[state]
    device: Arc<Device>,
    lines: Vec<Output>,
    sets: Option<(Vec<Shown>, Out<u32>)>,
    report: Report,
}

impl Update for Write {
    fn update(&mut self, _: Period) {
        let (levels, idle) = lines::levels(&self.lines);
        let done = self.device.write(levels, idle);
        self.report.note(done, "error {} when writing viagpio: it is tried again");
    }
}
