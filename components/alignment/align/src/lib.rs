//! The plugin `align`: marks found by a camera on the machine, and the place of the part.
//!
//! | module | subject |
//! |---|---|
//! | `job` | the job: marks, model, camera, source of pictures, from an INI file |
//! | `bench` | marks measured so far, the fit, looks and calibrations |
//! | `report` | the state as lines, and as JSON |
//! | `worker` | the worker, which takes and searches pictures |
//! | `view` | pictures for people who watch |
//! | `eye`, `pins` | Realtime: the function, and what passes to and from the worker; its pins |
//! | `commands` | commands `align.*` |
#![forbid(unsafe_code)]

mod bench;
mod commands;
mod eye;
mod job;
mod pins;
mod report;
mod view;
mod worker;

use bench::Bench;
use eye::{Eye, Shared};
use hal_component::{
    Arg, Builder, Component, Error,
    abi::{ArgSpec, component_flags},
};
use std::{
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use view::Watched;
use worker::Worker;

/// Period of the worker, in nanoseconds.
const PERIOD_NS: i64 = 10_000_000;

/// `loadrt align`.
#[derive(Debug)]
pub struct Align;

impl Component for Align {
    const NAME: &'static str = "align";
    const DOC: &'static str = "\
Alignment by marks: a camera on the machine finds them, and the part's place goes to pins, files and coordinate systems.

`job` is an INI file. Section JOB has the marks in the file's coordinates, in mm (`MARK = X Y`, several; `MARK = X Y X Y` also
states where the mark is expected on the machine), their `KIND` (circle or
square), `SIZE` in mm, `INK` (dark or bright), `FRAMES` (pictures of a look, 5), `MODEL`, `TOLERANCE` and `MIRROR` as of
`halgcode align`, and `NEAR = X Y`, the place where the file's origin is expected. Section CAMERA has `SOURCE` (`sim FILE`, a
simulated table; `files FOLDER`, pictures in the order of their names; `live FOLDER`, pictures that appear `DELAY` seconds
(1) after a look began, as `halcamera` writes them: a camera and its network may take so long from the light to the file), `MATRIX = m11 m12 m21 m22` from pixels to mm, `OFFSET = X Y` from the machine's position to the middle of
the picture, and `TIMEOUT` in seconds for a picture. `mark` selects a mark; `aim-x` and `aim-y` are the position from which the camera should
see it, by the marks before it.

A rising edge of `look` takes pictures at the present position and finds the selected mark; `found` or `error` shows the result when
`busy` falls. A look during which the machine moves is refused. A rising edge of `solve` computes the place of the part from the marks found. `valid` then
shows that `theta` (degrees), `sx`, `sy`, `shear` (degrees), `tx` and `ty` (mm) hold. A coordinate system of the machine can turn and
shift, but neither stretch nor shear: `live` shows whether turn and shift alone fit the marks within the tolerance, and
`live-theta`, `live-x` and `live-y` are the values for `G10 L2`. For any other part `align.save` writes the marks, and `halgcode align`
rewrites the program.

Values of `error`: 0 none, 1 no mark there, 2 two marks are about as near, 3 the pictures differ, 4 no picture, 5 the machine
moved, 6 no such mark, 7 the marks give no place, 8 the camera cannot be calibrated. `align.status` has the details. Positions are in mm.

On the virtual clock, pins `sim.*` change what the simulated camera sees.

# Example

```hal
loadrt threads name1=servo period1=1000000
loadrt align
addf align servo
start
# Marks that were touched with the tool: place in the file, place on the machine.
align.touch x=0 y=0 machine-x=2 machine-y=1
align.touch x=100 y=0 machine-x=102 machine-y=1
align.touch x=0 y=50 machine-x=2 machine-y=51
align.solve --wait
run 50ms
getp align.valid # -> TRUE
getp align.tx # -> 2
getp align.live # -> TRUE
```";
    const FLAGS: u32 = component_flags::ONCE;
    const ARGS: &'static [&'static ArgSpec] =
        &[&Arg::text("job", "INI file of the job: marks and camera.").or("")];

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        let bench = Arc::new(Mutex::new(Bench::default()));
        let (orders, receiver) = b.queue(16);
        let shared = Arc::new(Shared::default());
        let watched = Watched::default();
        let (eye, ends) = Eye::make(b, receiver, shared.clone())?;
        b.function("align", "Reads the pins, and shows results.", eye)?;
        commands::open(b, &bench, &orders, &watched)?;
        if let Some(job) = b.arg_text("job").filter(|j| !j.is_empty()) {
            let bench = bench.clone();
            b.on_open(move |_| {
                let opened = lock(&bench).open(Path::new(&job));
                opened
                    .map_err(|e| Error::new(format!("{e}; job= is an INI file such as plate.conf")))
            })?;
        }
        let worker = Worker::new(bench, shared, ends, watched, b.clock(), b.messages());
        b.worker("align", "Takes pictures and searches them.", PERIOD_NS, 1, worker)
    }
}

/// Returns the bench, whatever happened to another holder.
fn lock(bench: &Arc<Mutex<Bench>>) -> MutexGuard<'_, Bench> {
    bench.lock().unwrap_or_else(PoisonError::into_inner)
}

hal_component::export!(Align);

#[cfg(test)]
mod tests;
