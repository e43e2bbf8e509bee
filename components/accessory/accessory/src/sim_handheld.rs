//! `sim_handheld`.

use crate::format::{CHECK, HEADER, MAP, PERIOD, SIZE, format};
use hal_component::{
    Builder, Component, Error, In, Out, Period, Port, Touch, Update,
    abi::{ArgSpec, component_flags},
};
use hal_handheld::{FrameFormat, KeySet};

/// `loadrt sim_handheld`.
pub(crate) struct SimHandheld;

impl Component for SimHandheld {
    const NAME: &'static str = "sim_handheld";
    const DOC: &'static str = "\
Simulated handheld: sends the state of its keys in frames, as `keypad` reads them.

A pin `key-NN` is a key under a finger. The faults are a check byte that is wrong (`corrupt`), a frame without its last
byte (`short`) and a cable that is cut (`cut`).

# Example

```hal
loadrt sim_handheld
loadrt keypad
loadrt threads name1=servo period1=1000000
addf sim-handheld.update servo
addf keypad.update servo
newsig cable port
sets cable 64
net cable sim-handheld.frames keypad.frames-in
start
setp sim-handheld.key-14 TRUE
run 60ms
getp keypad.down-14 # -> TRUE
setp sim-handheld.corrupt TRUE
run 200ms
getp keypad.down-14 # -> FALSE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] = &[&PERIOD, &HEADER, &SIZE, &CHECK, &MAP];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let format = format(b)?;
        let period_ms = b.arg_float("period").unwrap_or(20.0);
        let mut keys = Vec::new();
        for key in 1..=format.keys() {
            let doc = format!("True while key {key} is pressed.");
            keys.push(b.item(&format!("sim-handheld.key-{key:02}"), &doc, false)?);
        }
        let fingers = Fingers {
            keys,
            corrupt: b.item("sim-handheld.corrupt", "Fault: the check bytes are wrong.", false)?,
            short: b.item("sim-handheld.short", "Fault: frames have no last byte.", false)?,
            cut: b.item("sim-handheld.cut", "Fault: the cable is cut.", false)?,
            frames: b.item("sim-handheld.frames", "Bytes of the frames.", Port::default())?,
            format,
            #[expect(clippy::cast_possible_truncation, reason = "2 to 1000 ms")]
            period_ns: (period_ms * 1e6) as i64,
            elapsed_ns: 0,
        };
        b.function("sim-handheld.update", "Sends one frame in every period.", fingers)
    }
}

/// Function of the handheld.
#[derive(Touch)]
struct Fingers {
    keys: Vec<In<bool>>,
    corrupt: In<bool>,
    short: In<bool>,
    cut: In<bool>,
    frames: Out<Port>,
    #[state]
    format: FrameFormat,
    #[state]
    period_ns: i64,
    #[state]
    elapsed_ns: i64,
}

impl Update for Fingers {
    fn update(&mut self, period: Period) {
        self.elapsed_ns = self.elapsed_ns.saturating_add(period.ns());
        if self.elapsed_ns < self.period_ns {
            return;
        }
        self.elapsed_ns = (self.elapsed_ns - self.period_ns) % self.period_ns;
        if self.cut.get() {
            return;
        }
        let pressed = (1..).zip(&self.keys).filter(|(_, pin)| pin.get());
        let keys = pressed.fold(KeySet::NONE, |set, (key, _)| set.with(KeySet::of(key)));
        let (mut bytes, len) = self.format.encode(keys);
        if self.corrupt.get()
            && let Some(check) = bytes.get_mut(len - 1)
        {
            *check ^= 0x10;
        }
        let len = len - usize::from(self.short.get());
        // A full queue has no reader: the bytes are lost, as in a cable.
        let _: bool = self.frames.get().write(bytes.get(..len).unwrap_or_default());
    }
}
