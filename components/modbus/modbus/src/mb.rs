//! The component `modbus`: devices on Modbus lines, by the files of LinuxCNC's `mb2hal`.
//!
//! | module | subject |
//! |---|---|
//! | `config` | the file, understood |
//! | `arguments` | the arguments |
//! | `refused` | why a file or an argument is refused |
//! | `pins` | pins of a transaction, and of its simulated device |
//! | `schedule` | which transaction is next |
//! | `simulation` | simulated devices of a line |
//! | `worker` | the worker of a line |
//! | `probe` | the command `modbus.probe` |

mod arguments;
mod config;
mod pins;
mod probe;
mod refused;
mod schedule;
mod simulation;
#[cfg(test)]
mod tests;
mod worker;

use crate::{
    line::{LinePlace, SimulatedFaultPins, SimulatedLine},
    station::Station,
};
use arguments::ARGS;
use config::{LinkConfig, MbConfig};
use hal_component::{
    Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use hal_modbus::silence_ns;
use hal_modbus_devices::{Bus, Slave, Timing};
use pins::{HealthPins, SimulatedValues, ValuePins};
use schedule::Schedule;
use simulation::{Simulation, Slaves};
use worker::{Counts, LinkState, LinkWorker, Transaction};

/// Period of the workers, in nanoseconds.
const PERIOD_NS: i64 = 1_000_000;
/// Time that a simulated device takes for an answer, in nanoseconds.
const SIMULATED_ANSWER_NS: i64 = 2_000_000;
/// Time of a character over simulated TCP, in nanoseconds.
const TCP_CHAR_NS: i64 = 100;

/// Component `modbus`.
pub(crate) enum Modbus {}

impl Component for Modbus {
    const NAME: &'static str = "modbus";
    const DOC: &'static str = "\
Devices on Modbus lines: RTU on serial lines, and TCP.

`loadrt modbus ini=FILE` takes the file of LinuxCNC's program `mb2hal` as it is, and makes the same pins, under `mb2hal` or its
`HAL_MODULE_NAME`. It needs no function in a thread: a worker for each line reads and writes the pins. Without a file,
`transactions=` lists requests as `NAME:FUNCTION:FIRST:COUNT`, for one line and one device; without any, the line is there for
`modbus.probe` alone.

| entry of `[TRANSACTION_nn]` | meaning |
|---|---|
| `LINK_TYPE` | `serial` with `SERIAL_PORT`, `SERIAL_BAUD`, `SERIAL_BITS`, `SERIAL_PARITY`, `SERIAL_STOP`, `SERIAL_DELAY_MS`; or `tcp` with `TCP_IP`, `TCP_PORT` |
| `MB_SLAVE_ID` | number of the device, 1 to 247 |
| `MB_TX_CODE` | `fnct_01_read_coils` to `fnct_16_write_multiple_registers`, as `mb2hal` names them |
| `FIRST_ELEMENT`, `NELEMENTS` or `PIN_NAMES` | the elements, and the names of their pins |
| `HAL_TX_NAME` | name before the pins, else the number of the section |
| `MAX_UPDATE_RATE` | requests per second; 0 for as many as possible |
| `MB_RESPONSE_TIMEOUT_MS` | time for an answer, 500 ms without it |

An entry for the line, the device, the rate or the time that is missing is that of the section before. `TOTAL_TRANSACTIONS`,
`VERSION`, `HAL_MODULE_NAME` and `SLOWDOWN` of `[MB2HAL_INIT]` have their meaning; `DEBUG`, `INIT_DEBUG` and `MB_BYTE_TIMEOUT_MS`
have none.

The request that is due longest goes next. A broken answer is asked for again, at most twice; a device that does not answer is
left alone for 0.5 s, then 1 s, and up to 8 s, so that the others keep their rates. On a serial line that also keeps its late
answer from being taken for one to another request. A request that a device refuses is repeated after 1 s, and delays no other.

Registers that are written are limited to -32768 to 65535; `mb2hal` lets them wrap. The pins `scale` and `offset`, `fault` and
those of errors by their kind are not in LinuxCNC 2.9.

`NAME.fault` is TRUE while a device does not answer; values keep the last that was read. `critical=TRUE` switches the motion
controller off meanwhile. What a device does when nobody speaks to it is its own affair: give outputs that must not stay on a
time-out in the device.

`modbus.probe unit=1 table=holding first=0` asks a device once, between the requests of its line.

On the virtual clock, and with `--simulate`, the devices are simulated: `mb2hal.sim.NAME.PIN` are their values, and
`show pin mb2hal.*sim.*` lists all pins of the simulation.

# Pins

```hal
loadrt modbus transactions=coils:01:0:2,relays:15:0:2,level:03:0:1,output:06:4:1
```

# Example

```hal
loadrt modbus device=/dev/ttyUSB0 rate=9600 unit=2 transactions=inputs:02:0:2,level:04:8:1,relays:15:0:2
loadrt threads name1=servo period1=1000000
start
setp mb2hal.sim.inputs.01 TRUE
setp mb2hal.sim.level.00 500
setp mb2hal.level.00.scale 0.1
setp mb2hal.relays.01.bit TRUE
run 500ms
getp mb2hal.inputs.01.bit # -> TRUE
getp mb2hal.level.00.float # -> 50
getp mb2hal.sim.relays.01 # -> TRUE
setp mb2hal.sim.level.silent TRUE
run 3s
getp mb2hal.level.fault # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let config = arguments::read(b).map_err(|why| Error::new(why.to_string()))?;
        let is_critical = b.arg_int("critical").unwrap_or(0) != 0;
        let inbox = probe::Inbox::default();
        probe::open(b, config.links.len(), &inbox)?;
        for (n, link) in config.links.iter().enumerate() {
            worker(b, &config, (n, link), is_critical, inbox.clone())?;
        }
        Ok(())
    }
}

/// Declares the worker of a line, with the pins of its transactions.
fn worker(
    b: &mut Builder<'_>,
    config: &MbConfig,
    (n, link): (usize, &LinkConfig),
    is_critical: bool,
    inbox: probe::Inbox,
) -> Result<(), Error> {
    let own = || config.transactions.iter().filter(|t| t.link == n);
    let (silence, char_ns) = match &link.place {
        LinePlace::Serial(place) => (silence_ns(place.rate, place.char_bits()), place.char_ns()),
        LinePlace::Tcp(_) => (0, TCP_CHAR_NS),
    };
    let is_tcp = matches!(link.place, LinePlace::Tcp(_));
    let mut transactions = Vec::new();
    for of in own() {
        let simulated = match b.is_simulated() {
            true => Some(SimulatedValues::make(b, &config.prefix, of)?),
            false => None,
        };
        transactions.push(Transaction {
            values: ValuePins::make(b, config, of)?,
            health: HealthPins::make(b, &format!("{}.{}", config.prefix, of.name))?,
            simulated,
            config: of.clone(),
            counts: Counts::default(),
        });
    }
    let mut simulation = None;
    if b.is_simulated() {
        let mut list: Vec<Slave> = Vec::new();
        for of in own() {
            if list.iter().all(|slave| slave.unit != of.unit) {
                let same = own().filter(|t| t.unit == of.unit);
                let ends = same.map(|t| usize::from(t.first) + t.pins.len());
                list.push(Slave::new(of.unit, ends.max().unwrap_or_default()));
            }
        }
        let timing = Timing { char_ns, silence_ns: silence, answer_ns: SIMULATED_ANSWER_NS };
        let line = SimulatedLine::new(Bus::new(Slaves { list, is_tcp }, timing, 1));
        let faults = SimulatedFaultPins::make(b, &format!("{}.line.{n}", config.prefix))?;
        simulation = Some(Simulation { faults, line });
    } else {
        let place = link.place.clone();
        // A device in the network may come later; a serial line that is not there is a mistake.
        if let LinePlace::Serial(_) = place {
            b.on_open(move |_| place.open().map(drop).map_err(|why| Error::new(why.to_string())))?;
        }
    }
    let name = format!("{}.line.{n}", config.prefix);
    let worker = LinkWorker {
        transactions,
        simulation,
        clock: b.clock(),
        messages: b.messages(),
        hardware: is_critical.then(|| b.hardware()),
        prefix: config.prefix.clone(),
        link: n,
        place: link.place.clone(),
        station: Station::new(silence.saturating_add(link.pause_ns), char_ns),
        schedule: Schedule::new(own(), is_tcp),
        inbox,
        state: LinkState::new(own().count()),
    };
    b.worker(&name, "Speaks with the devices of a line.", PERIOD_NS, 1, worker)
}
