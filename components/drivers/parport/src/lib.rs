//! Parallel port of the PC.
//!
//! Real ports are accessed in `hardware`, the only module with unsafe code; simulated ones are [`Simulated`]. Functions
//! share a port's registers through `device::Device` and the values written to them through `device::Written`, both
//! without locks.
#![deny(unsafe_code)]

mod config;
mod device;
mod functions;
#[expect(
    unsafe_code,
    reason = "device requests and I/O ports are the system's, not the language's"
)]
mod hardware;
mod lines;
#[cfg(test)]
mod tests;

use crate::{
    config::PortConfig,
    device::{Device, Register, Written},
    functions::{All, Read, Reset, Write},
    hardware::System,
    lines::{CONTROL, DATA, STATUS},
};
use hal_component::{
    Arg, Builder, Component, Error, ParamRw,
    abi::{ArgSpec, component_flags},
};
use port::{Report, Simulated};
use std::sync::Arc;

/// Component `hal_parport`.
pub(crate) enum Parport {}

hal_component::export!(Parport);

impl Component for Parport {
    const NAME: &'static str = "hal_parport";
    const DOC: &'static str = "\
The PC's parallel port: up to eight ports of 17 lines each.

`cfg` lists the ports: an address in hexadecimal (or the port's number in the kernel, 0 to f),
then a mode, `out` when there is none; separated by blanks or `_`:

| mode | outputs | inputs |
|---|---|---|
| `out` | 1 to 9, 14, 16, 17 | 10 to 13, 15 |
| `in` | 1, 14, 16, 17 | 2 to 13, 15 |
| `x` | 2 to 9 | 1, 10 to 17 |
| `epp` | as `out`, on a chip in EPP mode | as `out` |

`parport.N.read` and `.write` serve one port, `parport.read-all` and `.write-all` all of them; a
register is written only when it changes. `parport.N.reset`, after them in the same thread, returns
outputs with `-out-reset` to rest `reset-time` after the write: a step pulse in every period.

A real port needs the kernel's drivers `parport_pc` and `ppdev` and a user in group `lp`; mode `x`
needs root or CAP_SYS_RAWIO. The message of a refused load has the command that gives the right. While
a port does not answer, the motion controller is off. Simulated ports show their registers as
`parport.N.sim.*`: raw bits as the chip has them, of which bit 7 of `status` and bits 0, 1 and 3 of `control` are the opposite of the line's
level.

When the machine stops, every output goes to the level of FALSE.

# Pins

```hal
loadrt hal_parport cfg=378_in
loadrt hal_parport cfg=378_x
```

# Example

```hal
# On simulated hardware the lines are pins.
loadrt hal_parport cfg=378
loadrt threads name1=servo period1=1000000
addf parport.0.read servo
addf parport.0.write servo
start
setp parport.0.pin-02-out 1
setp parport.0.sim.status-6 1
run 1ms
getp parport.0.pin-10-in # -> TRUE
getp parport.0.sim.data-0 # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;
    const ARGS: &'static [&'static ArgSpec] = &[&Arg::text(
        "cfg",
        "Ports as `ADDR [mode] …`: hexadecimal address, then out (default), in, x or epp; \
         separated by blanks or `_`",
    )];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let ports = config::parse(b.arg_text("cfg").as_deref())?;
        let (mut devices, mut reads, mut writes) = (Vec::new(), Vec::new(), Vec::new());
        for (index, config) in ports.into_iter().enumerate() {
            let (read, write) = create_port(b, index, config)?;
            devices.push(read.device.clone());
            reads.push(read);
            writes.push(write);
        }
        b.function("parport.read-all", "Reads the inputs of every port", All { ports: reads })?;
        b.function("parport.write-all", "Writes the outputs of every port", All { ports: writes })?;
        b.on_open(move |_| {
            let mut numbered = devices.iter().enumerate();
            numbered.try_for_each(|(index, device)| device.open(index, &System::default()))
        })
    }
}

/// Declares one port. Returns its read and write functions, which `All` calls as well.
fn create_port(
    b: &mut Builder<'_>,
    index: usize,
    config: PortConfig,
) -> Result<(Read, Write), Error> {
    let mode = config.mode;
    let device = Arc::new(Device::new(b, index, config)?);
    let (given, taken) = b.shared(Written::default());
    let sets = device.simulated().map(Simulated::written);
    let asks = device.simulated().map(Simulated::read_from);
    let report = Report::new(b, u32::try_from(index).unwrap_or(u32::MAX));
    let clock = b.clock();

    let (mut registers, mut lines) = (vec![Register::Status], Vec::new());
    lines.push(lines::inputs(b, index, STATUS)?);
    let (mut data, mut data_pulses) = (Vec::new(), Vec::new());
    if mode.reads_data() {
        registers.push(Register::Data);
        lines.push(lines::inputs(b, index, DATA)?);
    } else {
        (data, data_pulses) = lines::outputs(b, index, DATA)?;
    }
    let (mut control, mut control_pulses) = (Vec::new(), Vec::new());
    if mode.reads_control() {
        registers.push(Register::Control);
        lines.push(lines::inputs(b, index, CONTROL)?);
    } else {
        (control, control_pulses) = lines::outputs(b, index, CONTROL)?;
    }
    let time = if mode.reads_data() { None } else { Some(parameters(b, index)?) };

    let read = Read { device, registers, lines, asks, report };
    let (device, report) = (read.device.clone(), read.report.clone());
    let reset = Reset {
        device: device.clone(),
        written: taken,
        data: data_pulses,
        control: control_pulses,
        time,
        sets: sets.clone(),
        clock,
        report: report.clone(),
    };
    let write = Write { device, written: given, data, control, sets, clock, report };

    let about = format!("Reads the inputs of port {index}");
    b.function(&format!("parport.{index}.read"), &about, read.clone())?;
    let about = format!("Writes the outputs of port {index} that have changed");
    b.function(&format!("parport.{index}.write"), &about, write.clone())?;
    let about = format!(
        "Returns the outputs of port {index} that have -out-reset to rest, reset-time after \
         they were written"
    );
    b.fast_function(&format!("parport.{index}.reset"), &about, reset)?;
    let stopped = write.clone();
    b.on_stop(move || {
        device::stop(&stopped.device, &stopped.written, &stopped.data, &stopped.control);
    })?;
    Ok((read, write))
}

/// Declares the parameters of a port. Returns the reset time.
fn parameters(b: &mut Builder<'_>, index: usize) -> Result<ParamRw<u32>, Error> {
    let about = "Nanoseconds from write to reset; 0 to a quarter of the period, above which the \
                 reset function sets it to that. In virtual time the reset does not wait";
    let time = b.item(&format!("parport.{index}.reset-time"), about, 0)?;
    for name in ["debug1", "debug2"] {
        let about = "Without effect; kept for scripts that set it";
        let _: ParamRw<u32> = b.item(&format!("parport.{index}.{name}"), about, 0)?;
    }
    Ok(time)
}
