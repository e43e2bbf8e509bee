//! PC speaker, which clicks.
#![forbid(unsafe_code)]

mod device;

use device::Device;
use hal_component::{
    Builder, Component, Error, In, Out, Period, Touch, Update, abi::component_flags,
};
use port::{Access, Driven, Lost, Report, Shown, Simulated};
use std::sync::Arc;

/// Control register of the speaker.
const REGISTER: u16 = 0x61;
/// Bit of that register that connects the timer to the speaker.
const TIMER: u8 = 1;
/// Bit of that register that sets the speaker's level.
const LEVEL: u8 = 2;
/// Number of pins.
const PINS: usize = 8;

/// Component `hal_speaker`.
pub(crate) struct Speaker;

hal_component::export!(Speaker);

impl Component for Speaker {
    const NAME: &'static str = "hal_speaker";
    const DOC: &'static str = "\
The loudspeaker of a PC, which clicks when a bit changes: steps can be heard.

Whenever one of the eight bits has changed, the loudspeaker is driven for one run. It is reached by
register 0x61 through `/dev/port`, which needs root; the other bits of the register stay as they are, but
for the timer, which is taken off the loudspeaker. The simulated register has pins
`speaker.sim.0061` as last written, and `speaker.sim.0061-in` as it reads.

When the machine stops, the loudspeaker is released.

# Example

```hal
loadrt hal_speaker
loadrt threads name1=servo period1=1000000
addf speaker.0.write servo
start
setp speaker.0.pin-00-out 1
run 1ms
getp speaker.sim.0061 # -> 2
run 1ms
getp speaker.sim.0061 # -> 0
```";
    const FLAGS: u32 = component_flags::ONCE | component_flags::PARALLEL;

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let device = Arc::new(Device::new(b)?);
        let mut pins = Vec::new();
        for i in 0..PINS {
            let doc = "A bit whose changes are heard.";
            pins.push(b.item(&format!("speaker.0.pin-{i:02}-out"), doc, false)?);
        }
        let write = Write {
            pins,
            sets: device.simulated().map(Simulated::written),
            asks: device.simulated().map(Simulated::read_from),
            report: Report::new(b, 0),
            device: device.clone(),
            was: 0,
        };
        b.function("speaker.0.write", "Clicks if a bit has changed.", write)?;
        let opened = device.clone();
        b.on_open(move |_| opened.open().map_err(|why| Error::new(why.to_string())))?;
        b.on_stop(move || {
            // A lost register cannot be released; the write function reports it.
            let _ = release(&device);
        })
    }
}

#[derive(Touch)]
struct Write {
    pins: Vec<In<bool>>,
    sets: Option<(Vec<Shown>, Out<u32>)>,
    asks: Option<(Vec<Driven>, Out<u32>)>,
    report: Report,
    #[state]
    device: Arc<Device>,
    /// Inputs in the previous cycle, one bit each.
    #[state]
    was: u8,
}

impl Update for Write {
    fn update(&mut self, _: Period) {
        let now = self.pins.iter().rev().fold(0, |bits, pin| bits << 1 | u8::from(pin.get()));
        let level = if now == self.was { 0 } else { LEVEL };
        self.was = now;
        let done = drive(&self.device, level);
        self.report.note(done, "error {} at the loudspeaker: it is tried again");
    }
}

/// Sets the speaker's level.
fn drive(device: &Device, level: u8) -> Result<(), Lost> {
    let others = device.read(REGISTER)? & !(TIMER | LEVEL);
    device.write(REGISTER, others | level)
}

fn release(device: &Device) -> Result<(), Lost> {
    drive(device, 0)
}

#[cfg(test)]
mod tests {
    use super::{Speaker, device::Closed};
    use hal_bench::{Bench, trace::replay};

    #[test]
    fn a_click_for_each_change() {
        // Register values that LinuxCNC's component writes.
        let rows = "load hal_speaker
            run speaker.0.write
            in speaker.sim.0061-in speaker.0.pin-00-out speaker.0.pin-01-out speaker.0.pin-07-out
            out speaker.sim.0061 speaker.sim.reads speaker.sim.writes
            0 0 0 0 | 0 1 1
            0 1 0 0 | 2 2 2
            0 1 0 0 | 0 3 3
            0 0 1 0 | 2 4 4
            0 0 0 1 | 2 5 5
            0 1 1 1 | 2 6 6
            255 0 0 0 | 254 7 7
            253 0 0 0 | 252 8 8
            164 1 0 0 | 166 9 9
            164 1 0 0 | 164 10 10";
        assert_eq!(replay::<Speaker>(rows), 10);
    }

    #[test]
    fn a_register_that_does_not_open_says_who_opens_it() {
        let text = |errno| Closed(std::io::Error::from_raw_os_error(errno)).to_string();
        assert_eq!(
            text(13),
            "/dev/port: Permission denied (os error 13): only root opens it; or run with --simulate"
        );
        assert_eq!(
            text(2),
            "/dev/port: No such file or directory (os error 2); or run with --simulate"
        );
    }

    #[test]
    fn a_register_that_does_not_answer_is_lost_hardware() {
        let mut bench = Bench::new().with_hardware();
        bench.create::<Speaker>(&[]).unwrap();
        // It was never opened.
        for _ in 0..3 {
            bench.run("speaker.0.write", 1_000_000);
        }
        assert_eq!(bench.failed_hardware(), 1);
        assert_eq!(bench.said(), ["error 6 at the loudspeaker: it is tried again"]);
    }

    #[test]
    fn it_is_released_at_a_stop() {
        let mut bench = Bench::new();
        bench.load::<Speaker>(&[]).unwrap();
        bench.set("speaker.sim.0061-in", 0xFF_u32);
        bench.set("speaker.0.pin-03-out", true);
        bench.run("speaker.0.write", 1_000_000);
        assert_eq!(bench.get::<u32>("speaker.sim.0061"), 0xFE);
        bench.stop();
        assert_eq!(bench.get::<u32>("speaker.sim.0061"), 0xFC);
    }
}
