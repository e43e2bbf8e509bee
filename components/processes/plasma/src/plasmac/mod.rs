//! `plasmac`.
mod cutting;
mod ending;
mod idle;
mod inputs;
mod jobs;
mod machine;
mod numbers;
mod offset;
mod outputs;
mod paused;
mod probing;
mod recovery;
mod settings;
mod state;
mod steady;
mod thc;
mod times;
mod volts;

use hal_component::{Builder, Component, Error, abi::component_flags};
use machine::Cutter;

/// Controller of a plasma cutter.
pub(crate) struct Plasmac;

impl Component for Plasmac {
    const NAME: &'static str = "plasmac";
    const DOC: &'static str = "\
A plasma cutter: finds the surface, pierces, cuts, and keeps the torch at its height.

The program is a motion program: `cutting-start` comes from `spindle.0.on` and begins a cut. Z, and X and Y in
pauses, are moved by external offsets: `z-offset-counts` goes to `axis.z.eoffset-counts`, `offset-scale` to
`axis.z.eoffset-scale`, `z-offset-enable` to `axis.z.eoffset-enable`, and `feed-hold` to `motion.feed-hold`
holds the program's feed until the torch cuts. `mode` selects how an arc is detected: 0 a steady voltage between
`arc-ok-low` and `arc-ok-high`, 1 `arc-ok-in`, 2 the same with `move-up` and `move-down` for the height.

| `state-out` | what it does | and then |
|---|---|---|
| 0 | waits | 1, 5, 18, 19, 20, 22, 23, 24, 25 |
| 1 | moves Z to the height where probing begins | 2; 3 when it touches |
| 2 | probes downwards | 3; 15 at the lowest Z |
| 3 | moves up until the contact ends | 4; 2 again after 1 |
| 4 | moves to the surface | 5 |
| 5 | moves to the height of piercing | 6; 8 without a torch, 21 in a probe test |
| 6 | lights the torch, after `restart-delay` | 7; waits for a pause after `arc-max-starts` |
| 7 | waits for the arc, or marks a spot | 8, 14 after a spot; 6 after `arc-fail-delay` |
| 8 | pierces | 9 or 10 after `pierce-delay` |
| 9 | jumps over the puddle | 10 |
| 10 | moves to the height of the cut | 11, or 12 with `mode` 2; 26 in a recovery |
| 11, 12 | cuts | 13, 14 or 15 |
| 13 | waits with the torch on for `pause-at-end` | 14 |
| 14 | moves to `safe-height` | 16 |
| 15 | removes the offset of Z, after a fault, a pause or the program's end | 16 |
| 16, 17 | ends the cut, ends the job | 0 |
| 18 | lights the torch for `torch-pulse-time` | 0 |
| 19 | moves along the path while paused | 25 |
| 20, 21 | tests the contact, tests the probe | 0, 16 |
| 22 | scribes | 0 |
| 23, 24 | moves to the position for changing consumables, and back | 0 |
| 25, 26 | moves to the position where a cut continues, and back to the path | 0, 11 |

`stop-type-out` is the reason for the end of a cut: 1 the program ended, 2 the cut ended, 3 a fault or a pause. A fault
sets `program-pause` and reports its cause in a message: the lowest Z without a contact, no arc after all
starts, an arc that is lost, a voltage below `low-cut-volts`, a sensor, heights or volts that are not above 0, no room. A sensor is the
`float-switch`, the tip (`ohmic-probe`) or `breakaway`.

While it cuts at the program's feed rate (`feed-upm`), Z follows the voltage: `thc-delay` after that feed rate
is reached the target is `cut-volts`, or with `use-auto-volts` the mean of the next `target-samples`.
A difference of `thc-threshold` or more moves Z by the gains, no faster than `thc-feed-rate`.
`cornerlock-enable` stops that in corners, `voidlock-enable` where the voltage rises quickly. With `thc-auto` and
`use-auto-volts` there is no delay: the target is the mean of the last `thc-sample-counts` voltages (1000 at most)
as soon as they differ by no more than `thc-sample-threshold`. A changed `height-override` shifts the target, and
moves Z by `height-per-volt` for each volt: up at once, down by `setup-feed-rate`.

`spotting-start` makes a spot instead of a cut: `spotting-time` after the voltage is first `spotting-threshold` the
torch goes off in state 7, and Z to `safe-height`. With `cutting-start` as well it is a cut.

A surface above which there is less room than `pierce-height` and 1 mm is a fault, at the contact and, with a
`safe-height`, where contact ends; Z goes no higher than `axis-z-max-limit` less `max-offset`. A `safe-height` beyond
that is reported in a message, and Z stops at that height.

With `ohmic-probe-enable` and an `offset-probe-x` or `offset-probe-y`, X and Y move until that probe is above the
torch's previous position, at `setup-feed-rate` along the line, while Z goes to its start height, and back in state 5. Z goes down
no sooner than `offset-probe-delay` after the begin, and up as long after state 5 began. A place beyond the limits of
X and Y, and contact on the way there, are faults. A cut that ends at once leaves X and Y where they are, as LinuxCNC
does; a pause takes them back. With both distances 0 there is no delay; LinuxCNC with a delay then waits forever.
After contact in state 1 LinuxCNC waits a cycle more in state 2.

A spot without a program ends as its input falls; LinuxCNC lights on and cuts. Known to differ from LinuxCNC 2.9:
`feed-hold` after a sensor that comes in idle or with the machine's power, `thc-enabled` before the first arc with
`arc-lost-delay`, `voidlock-enable`, `thc-auto` in a cut without a program whose arc was away, a program that resumes
while `laser-recovery-start` is 1, `probe-test` during a cut, a program that ends while consumables are out, and by a
cycle or a count `probe-time`, X and Y as state 15 begins. Not compared in every order of events: sensors in one cycle
with others, contact by the tip, `mode` 0, and states 19 and 23 to 26.

The pins are those of LinuxCNC 2.9; 2.10 has more. Numbers are kept with the 24 bits that LinuxCNC keeps of them
where that shows: speeds, times, the voltage (to three decimals) and the sum of Z's counts.

# Example

A spot to see a cut begin: the torch stands 20 above the table, and the float switch closes after 30 ms.

```hal
loadrt plasmac
loadrt threads name1=servo period1=1000000
addf plasmac servo
setp plasmac.units-per-mm 1
setp plasmac.mode 1
setp plasmac.axis-z-position 20
setp plasmac.axis-z-max-limit 60
setp plasmac.axis-z-min-limit 0
setp plasmac.probe-start-height 15
setp plasmac.probe-feed-rate 6000
setp plasmac.setup-feed-rate 60000
setp plasmac.pierce-height 3
setp plasmac.cut-height 1.5
setp plasmac.cut-volts 100
setp plasmac.safe-height 10
setp plasmac.arc-max-starts 3
setp plasmac.arc-fail-delay 0.05
setp plasmac.torch-enable 1
setp plasmac.homed 1
setp plasmac.machine-is-on 1
setp plasmac.program-is-running 1
start
setp plasmac.cutting-start 1
run 30ms
getp plasmac.state-out # -> 2
setp plasmac.float-switch 1
run 2ms
getp plasmac.state-out # -> 3
setp plasmac.float-switch 0
run 10ms
getp plasmac.torch-on # -> TRUE
getp plasmac.state-out # -> 7
setp plasmac.arc-ok-in 1
run 10ms
getp plasmac.state-out # -> 11
getp plasmac.feed-hold # -> FALSE
setp plasmac.cutting-start 0
run 2ms
getp plasmac.torch-on # -> FALSE
getp plasmac.stop-type-out # -> 2
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let machine = Cutter::new(b)?;
        b.function("plasmac", "Reads the arc and the switches, and controls the torch.", machine)
    }
}

#[cfg(test)]
mod tests;
