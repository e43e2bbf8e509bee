//! `sim_nk105`.

use crate::{
    device::read_port,
    sim_medium::{self, SimMedium},
};
use hal_component::{
    Arg, Builder, Component, Error, In, Out, Period, Port, Touch, Update,
    abi::{ArgSpec, component_flags},
};
use hal_handheld::{FrameFormat, FrameReader, KeySet, frame::Received};
use hal_nk105::{Controller, Mode};

/// Largest number of bytes that are read in a cycle.
const BYTES: usize = 64;
/// Time without a good frame after which the handheld counts as gone, in nanoseconds.
const GONE_NS: i64 = 60_000_000;
/// Time without a byte after which a frame that has begun is lost, in nanoseconds.
const SILENCE_NS: i64 = 10_000_000;

/// `loadrt sim_nk105`.
pub(crate) struct SimNk105;

impl Component for SimNk105 {
    const NAME: &'static str = "sim_nk105";
    const DOC: &'static str = "\
Simulated closed controller of a router, after the Weihong NK105: keys in, display out, jobs from a USB medium.

It reads frames of keys (as `keypad` sends them), draws its display with the bytes of an ST7920 (as `lcd_reader` reads them),
and runs G-code programs of the medium that is plugged in. Its machine moves along straight lines at constant speeds, without
inertia; arcs are chords of at most 2 degrees. Travel is 500 mm to either side of machine zero.

| keys | effect |
|---|---|
| digits, `.`, `-`, OK | a number, at most 16 characters; OK makes it the feed in percent, 1 to 150 |
| STOP | ends the job and all motion; clears the number and the message |
| X+ X- Y+ Y- Z+ Z- | jogs while held, or one step of 0.1 mm, as MODE says |
| HIGH | jogs at 50 or at 5 mm/s |
| MODE | jogs continuously or in steps |
| RUN | the menu of files: UP, DOWN, OK; while a job runs, holds it and goes on |
| ORIGIN | makes the place the zero of the work |
| HOME | goes to machine zero |
| SPINDLE | turns the spindle on and off |
| SHIFT | none |

Rows 1 to 3 of the display have the axis, its coordinate in the work (`%10.3f`) and four characters: IDLE, JOG, RUN or HOLD; the
feed; the tool. Row 4 has the number, the menu or a message. A key that is down already when a job ends moves nothing.
If no good frame arrives for 60 ms, all keys are up and a job is held.

The medium is image A or B in the folder of `usbjobs`, as the pin `medium` says. The controller holds it (`reading`) while a
job runs. A medium that goes ends the job.

# Example

```hal
loadrt sim_nk105
loadrt keypad
loadrt threads name1=servo period1=1000000
addf keypad.update servo
addf sim-nk105.update servo
newsig cable port
sets cable 64
net cable keypad.frames-out sim-nk105.keys
start
keypad.press key=MODE --wait
keypad.press key=X+ --wait
getp sim-nk105.x # -> 0.1
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::text("folder", "Folder of the images, that of `usbjobs`.").or(".")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let folder = b.arg_text("folder").unwrap_or_default();
        let medium = sim_medium::declare(b, &folder)?;
        let simulated = Simulated {
            keys: b.item("sim-nk105.keys", "Bytes of the frames of keys.", Port::default())?,
            lcd: b.item("sim-nk105.lcd", "Bytes to the display.", Port::default())?,
            reading: b.item(
                "sim-nk105.reading",
                "True while the controller holds the medium.",
                false,
            )?,
            axes: [
                b.item("sim-nk105.x", "X in machine coordinates, in mm.", 0.0)?,
                b.item("sim-nk105.y", "Y in machine coordinates, in mm.", 0.0)?,
                b.item("sim-nk105.z", "Z in machine coordinates, in mm.", 0.0)?,
            ],
            mode: b.item("sim-nk105.mode", "0 idle, 1 jog, 2 run, 3 hold.", 0)?,
            spindle: b.item("sim-nk105.spindle", "True while the spindle turns.", false)?,
            bad_frames: b.item("sim-nk105.bad-frames", "Number of frames that were dropped.", 0)?,
            medium,
            reader: FrameReader::new(FrameFormat::default()),
            controller: Controller::default(),
            pressed: None,
            since_ns: 0,
            silent_ns: 0,
        };
        b.function("sim-nk105.update", "Runs a cycle of the controller.", simulated)
    }
}

/// Function of the controller.
#[derive(Touch)]
struct Simulated {
    keys: In<Port>,
    lcd: Out<Port>,
    reading: Out<bool>,
    axes: [Out<f64>; 3],
    mode: Out<u32>,
    spindle: Out<bool>,
    bad_frames: Out<u32>,
    medium: SimMedium,
    #[state]
    reader: FrameReader,
    #[state]
    controller: Controller,
    #[state]
    pressed: Option<KeySet>,
    /// Time since the last good frame.
    #[state]
    since_ns: i64,
    /// Time since the last byte.
    #[state]
    silent_ns: i64,
}

impl Update for Simulated {
    fn update(&mut self, period: Period) {
        self.receive(period.ns());
        self.controller.cycle(period.secs(), self.pressed, &mut self.medium);
        // The controller has drawn into its own memory: a row that finds no room is sent later.
        if let Some(burst) = self.controller.panel().next()
            && self.lcd.get().write(burst.bytes())
        {
            self.controller.panel().sent();
        }
        for (pin, place) in self.axes.iter().zip(self.controller.place()) {
            pin.set(place);
        }
        self.reading.set(self.controller.holds_medium());
        self.spindle.set(self.controller.has_spindle());
        self.mode.set(match self.controller.mode() {
            Mode::Idle => 0,
            Mode::Jog => 1,
            Mode::Run => 2,
            Mode::Hold => 3,
        });
    }
}

impl Simulated {
    fn receive(&mut self, ns: i64) {
        let mut bytes = [0; BYTES];
        let count = read_port(self.keys.get(), &mut bytes);
        let arrived = bytes.get(..count).unwrap_or_default();
        self.since_ns = self.since_ns.saturating_add(ns);
        self.silent_ns = if arrived.is_empty() { self.silent_ns.saturating_add(ns) } else { 0 };
        let mut bad = u32::from(self.silent_ns >= SILENCE_NS && self.reader.silence());
        for byte in arrived {
            match self.reader.feed(*byte) {
                Some(Received::Keys(keys)) => (self.pressed, self.since_ns) = (Some(keys), 0),
                Some(Received::Bad) => bad += 1,
                None => {}
            }
        }
        if self.since_ns > GONE_NS {
            self.pressed = None;
        }
        self.bad_frames.set(self.bad_frames.get().wrapping_add(bad));
    }
}
