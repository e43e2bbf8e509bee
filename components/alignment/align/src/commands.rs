//! Commands `align.*`.

use crate::{
    bench::Bench,
    eye::{Action, Instruction},
    lock,
    view::Watched,
};
use hal_align::{Mark, Vector};
use hal_component::{Arg, Builder, Call, Error, Sender, abi::ArgSpec};
use std::{
    path::PathBuf,
    sync::{Arc, Mutex},
};

/// Command that the worker executes.
struct WorkerCommand {
    name: &'static str,
    doc: &'static str,
    args: &'static [&'static ArgSpec],
    action: fn(&Call<'_>) -> Action,
}

const ROWS: &[WorkerCommand] = &[
    WorkerCommand {
        name: "align.look",
        doc: "Finds a mark from the present position; without a number the selected one.",
        args: &[&Arg::int("mark", "Number of the mark, from 1.")],
        action: |call| Action::Look(call.int("mark").map(|n| u32::try_from(n).unwrap_or(0))),
    },
    WorkerCommand {
        name: "align.solve",
        doc: "Computes the place of the part from the marks that are measured.",
        args: &[],
        action: |_| Action::Solve,
    },
    WorkerCommand {
        name: "align.clear",
        doc: "Forgets all marks.",
        args: &[],
        action: |_| Action::Clear,
    },
    WorkerCommand {
        name: "align.sight",
        doc: "Finds any mark from the present position, for the calibration of the camera.",
        args: &[],
        action: |_| Action::Sight,
    },
    WorkerCommand {
        name: "align.calibrate",
        doc: "Calibrates the camera from the sights of one mark from three positions or more, and forgets all marks. align.status shows the matrix, for the job's file.",
        args: &[],
        action: |_| Action::Calibrate,
    },
];

const TOUCH: &[&ArgSpec] = &[
    &Arg::float("x", "X in the file, in mm.").required(),
    &Arg::float("y", "Y in the file, in mm.").required(),
    &Arg::float("machine-x", "X on the machine, in mm.").required(),
    &Arg::float("machine-y", "Y on the machine, in mm.").required(),
];

const STATUS: &[&ArgSpec] = &[&Arg::bit("json", "As JSON, in one line.").or("FALSE")];

const WATCH: &[&ArgSpec] = &[
    &Arg::text("file", "File that is replaced by each picture.").required(),
    &Arg::float("seconds", "Machine time for which pictures come.")
        .within(0.0, 60.0)
        .unit("s")
        .or("2"),
];

const SAVE: &[&ArgSpec] = &[&Arg::text("file", "File to write.").required()];

/// Returns the file that is written, which people elsewhere do not name.
fn file(call: &Call<'_>) -> Result<PathBuf, Error> {
    match call.is_from_afar() {
        true => {
            Err(Error::new("a file that is written is named at the machine, and not from afar"))
        }
        false => Ok(PathBuf::from(call.text("file").unwrap_or_default())),
    }
}

/// Declares the commands.
pub(crate) fn open(
    b: &mut Builder<'_>,
    bench: &Arc<Mutex<Bench>>,
    orders: &Sender<Instruction>,
    watched: &Watched,
) -> Result<(), Error> {
    for row in ROWS {
        let orders = orders.clone();
        b.command(row.name, row.doc, row.args, move |call| {
            let ticket = Some(call.ticket()?);
            let order = Instruction { action: (row.action)(call), ticket };
            let full = |_| Error::new("too many commands wait for the function align");
            orders.send(order).map_err(full)
        })?;
    }
    let shared = bench.clone();
    b.command("align.touch", "Adds a mark that was touched with the tool.", TOUCH, move |call| {
        let place = |x, y| {
            let at = |name| call.float(name).unwrap_or(f64::NAN);
            Vector::new(at(x), at(y))
        };
        let mark = Mark { file: place("x", "y"), machine: place("machine-x", "machine-y") };
        lock(&shared).touch(mark).map_err(Error::new)
    })?;
    let shared = bench.clone();
    let doc =
        "Writes the marks and the model to a file for halgcode align; align.solve comes first.";
    b.command("align.save", doc, SAVE, move |call| {
        let path = file(call)?;
        let text = lock(&shared).text().map_err(Error::new)?;
        let written = hal_output::write(&path, text.as_bytes());
        let name = path.display();
        written.map_err(|e| Error::new(format!("{name}: {}", hal_output::reason(&e))))
    })?;
    let shared = bench.clone();
    let doc = "Returns the marks, their residuals, the place of the part, and the last problem.";
    b.command("align.status", doc, STATUS, move |call| {
        let mut bench = lock(&shared);
        match call.bit("json").unwrap_or(false) {
            true => call.reply(&bench.json().to_string()),
            false => bench.status().iter().for_each(|line| call.reply(line)),
        }
        Ok(())
    })?;
    let (watched, clock) = (watched.clone(), b.clock());
    let doc = "\
Writes pictures of the camera at the present position to a file, at most ten in a second, until the time is over: a line of JSON (number, \
kind, size, place, the map from the machine to pixels, marks found), then the picture as PNG or JPEG. Nothing is measured.";
    b.command("align.watch", doc, WATCH, move |call| {
        let path = file(call)?;
        watched.watch(path, clock.now_ns(), call.float("seconds").unwrap_or(0.0));
        Ok(())
    })
}
