//! The component `hy_vfd`: Huanyang's inverters.
//!
//! | module | subject |
//! |---|---|
//! | `config` | arguments |
//! | `pins` | its pins, and what passes between function and worker |
//! | `gate` | Realtime: the function, which reads and writes pins and watches the worker |
//! | `drive` | what is said to the inverter, and when |
//! | `question` | requests to it |
//! | `note` | events that a person has to know |
//! | `worker` | the worker, which keeps the line |
//! | `halt` | the stop that needs no worker |
//! | `flags` | between that stop and the worker |
//! | `simulated` | pins of the simulated inverter |

mod config;
mod drive;
mod flags;
mod gate;
mod halt;
mod note;
mod pins;
mod question;
mod simulated;
#[cfg(test)]
mod tests;
mod worker;

use crate::{line::SimulatedLine, station::Station};
use config::{ARGS, HyConfig};
use drive::Drive;
use gate::{Gate, Was};
use hal_component::{
    Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use hal_modbus::HUANYANG_SILENCE_NS;
use hal_modbus_devices::{Bus, Inverter, Timing};
use halt::Halt;
use pins::{InputPins, Inputs, ResultPins, Results};
use simulated::SimulatedPins;
use std::sync::{Arc, atomic::AtomicU32};
use worker::{InverterPlace, Worker, WorkerState};

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 1_000_000;
/// Time that the simulated inverter takes for an answer, in nanoseconds.
const SIMULATED_ANSWER_NS: i64 = 3_000_000;

/// Component `hy_vfd`.
pub(crate) enum HyVfd {}

impl Component for HyVfd {
    const NAME: &'static str = "hy_vfd";
    const DOC: &'static str = "\
Spindle with an inverter of Huanyang on a serial line (RS-485).

Pins and parameters have the names of LinuxCNC's program `hy_vfd`. Its options are arguments here, as in
`loadrt hy_vfd device=/dev/ttyUSB0 rate=9600`, and the function `hy_vfd` belongs in the servo thread. A line
`loadusr -W hy_vfd -d /dev/ttyUSB0 -r 9600` loads it as well: its pins are then set every millisecond in the background.

| setting of the inverter | value |
|---|---|
| PD001, PD002 | 2: commands and frequency come by the line |
| PD004, PD005, PD011 | rated, greatest and least frequency |
| PD141 to PD144 | voltage, current, poles, and turns per minute at 50 Hz |
| PD163 | 1, or `target` |
| PD164 | 0 for 4800, 1 for 9600, 2 for 19200, 3 for 38400: `rate` |
| PD165 | 3: 8 bits, no parity, 1 stop bit, RTU |

The driver sends the command, the frequency and a request for each measurement, one after the other, and begins again. It sends
a changed command before anything else. Settings that arguments state are written once after the load; if the inverter does not
take one of them, a message says so, and the spindle stands.

The driver sends a stop to the inverter in each of these cases:

| case | after |
|---|---|
| `spindle-on` or `enable` is FALSE | one request |
| the function does not run | 0.2 s |
| the worker stands still: the function sends the stop | 0.5 s |
| the inverter has stopped by itself, as after a trip: its reset starts nothing | one round, 0.25 s |
| the component is loaded: the inverter may run by the command of a process that was killed | at once, until it is answered |
| the instance stops or ends | at once, behind the request under way |

The driver cannot send a stop when the process is killed (`kill -9`), when the computer loses its power, or when the line is cut. Put a
contactor into the e-stop chain for these cases, or set the inverter's own time-out if it has one. The time-out must be longer
than `timeout`.

`fault` is TRUE while requests fail and none was answered for `timeout`; the motion controller is off then, and refuses to be
switched on. Nothing starts by itself: after a fault, a loss of the line, a trip, a stop or a gap in time, and after the load,
the spindle turns once `spindle-on` was FALSE while the inverter answers.

`spindle-at-speed` compares with `speed-command`, as LinuxCNC's does: it stays FALSE for a speed outside the inverter's limits, and
a message says so. A speed of 0 stops the inverter, where LinuxCNC's program lets it turn at its least frequency.

On the virtual clock, and with `--simulate`, the inverter is simulated, with ramps, trips and a time-out of its own: `show pin
hy_vfd.sim.*` lists its pins.

# Example

```hal
loadrt threads name1=servo period1=1000000
loadrt hy_vfd
addf hy_vfd servo
start
setp hy_vfd.enable TRUE
setp hy_vfd.speed-command 12000
setp hy_vfd.spindle-forward TRUE
run 1s
getp hy_vfd.hycomm-ok # -> TRUE
getp hy_vfd.max-freq # -> 400
setp hy_vfd.spindle-on TRUE
run 3s
getp hy_vfd.OutF # -> 200
getp hy_vfd.spindle-at-speed # -> TRUE
# The cable is pulled: the inverter does not hear the stop.
setp hy_vfd.sim.cut TRUE
run 1s
getp hy_vfd.fault # -> TRUE
# It is plugged in again: the inverter stops, and nothing starts by itself.
setp hy_vfd.sim.cut FALSE
run 3s
getp hy_vfd.fault # -> FALSE
getp hy_vfd.sim.frequency # -> 0
setp hy_vfd.spindle-on FALSE
run 100ms
setp hy_vfd.spindle-on TRUE
run 3s
getp hy_vfd.spindle-at-speed # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = ARGS;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let HyConfig { name, unit, place, writes, timeout_ns, is_task } =
            HyConfig::read(b).map_err(|why| Error::new(why.to_string()))?;
        let char_ns = place.char_ns();
        let (results_in, results) = b.seqlock(Results::default());
        let (wanted, wanted_out) = b.seqlock(Inputs::default());
        let clock = b.clock();
        let halt = Arc::new(Halt::new(unit, clock));
        let steps = Arc::new(AtomicU32::new(0));
        let (mut simulated, mut at) = (None, InverterPlace::Serial(place));
        if b.is_simulated() {
            let timing =
                Timing { char_ns, silence_ns: HUANYANG_SILENCE_NS, answer_ns: SIMULATED_ANSWER_NS };
            let line = SimulatedLine::new(Bus::new(Inverter::new(unit), timing, 1));
            simulated = Some(SimulatedPins::make(b, &name, line.clone())?);
            at = InverterPlace::Simulated(line);
        }
        let gate = Gate {
            inputs: InputPins::make(b, &name)?,
            shown: ResultPins::make(b, &name)?,
            results,
            wanted,
            simulated,
            clock,
            messages: b.messages(),
            hardware: b.hardware(),
            halt: halt.clone(),
            steps: steps.clone(),
            was: Was::new(clock.gaps()),
        };
        let about = "Reads the pins, shows the inverter, and watches the worker.";
        if is_task {
            b.task(&name, about, PERIOD_NS, gate)?;
        } else {
            b.function(&name, about, gate)?;
        }
        let first = at.clone();
        b.on_open(move |_| first.open().map(drop).map_err(|why| Error::new(why.to_string())))?;
        let stop = halt.clone();
        b.on_stop(move || stop.stop_action())?;
        let worker = Worker {
            wanted: wanted_out,
            results: results_in,
            clock,
            messages: b.messages(),
            place: at,
            station: Station::new(HUANYANG_SILENCE_NS, char_ns),
            drive: Drive::new(unit, writes, timeout_ns),
            halt,
            steps,
            state: WorkerState::new(),
        };
        b.worker(&name, "Speaks with the inverter.", PERIOD_NS, 1, worker)
    }
}
