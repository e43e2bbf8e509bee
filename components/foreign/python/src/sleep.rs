//! Sleep in machine time.
//!
//! On the virtual clock, time stands still while a program works, and moves while it sleeps. Programs sleep with
//! `time.sleep`, so that function sleeps in machine time there, in the thread that made a component ready.

use crate::connection::{Core, locked};
use hal_protocol::Request;
use pyo3::{exceptions::PyValueError, prelude::*};
use std::{
    sync::{Arc, Mutex},
    thread::{self, ThreadId},
};

/// Ready components of this process on a virtual clock, each with the thread that made it ready.
static SLEEPERS: Mutex<Vec<(ThreadId, Arc<Core>)>> = Mutex::new(Vec::new());
/// Python's own `time.sleep`.
static WALL: Mutex<Option<Py<PyAny>>> = Mutex::new(None);
/// Longest single sleep, in nanoseconds: the limit of the request.
const MAX_SLEEP_NS: u64 = 1_000_000_000_000;

/// Lets the calling thread sleep in machine time if the component's instance is on the virtual clock.
pub(crate) fn begin(py: Python<'_>, core: &Arc<Core>) -> PyResult<()> {
    if !core.is_virtual() {
        return Ok(());
    }
    locked(&SLEEPERS).push((thread::current().id(), Arc::clone(core)));
    let time = py.import("time")?;
    let own = time.getattr("sleep")?;
    let mut wall = locked(&WALL);
    if wall.is_none() {
        *wall = Some(own.unbind());
        drop(wall);
        time.setattr("sleep", py.import("_hal")?.getattr("sleep")?)?;
    }
    Ok(())
}

/// Ends the sleeps of a component that leaves.
pub(crate) fn end(core: &Arc<Core>) {
    locked(&SLEEPERS).retain(|(_, c)| !Arc::ptr_eq(c, core));
}

/// Sleeps for a time in seconds: of machine time in a program on the virtual clock, otherwise as `time.sleep`.
#[pyfunction]
#[pyo3(signature = (seconds, /))]
pub(crate) fn sleep(py: Python<'_>, seconds: &Bound<'_, PyAny>) -> PyResult<()> {
    let me = thread::current().id();
    let mine = locked(&SLEEPERS)
        .iter()
        .filter(|(t, _)| *t == me)
        .map(|(_, c)| Arc::clone(c))
        .collect::<Vec<_>>();
    let Some((first, others)) = mine.split_first() else {
        let wall = locked(&WALL).as_ref().map(|f| f.clone_ref(py));
        let wall =
            wall.map_or_else(|| Ok(py.import("time")?.getattr("sleep")?.unbind()), Ok::<_, PyErr>)?;
        return wall.call1(py, (seconds,)).map(drop);
    };
    let seconds: f64 = seconds.extract()?;
    if seconds.is_nan() || seconds < 0.0 {
        return Err(PyValueError::new_err("sleep length must be non-negative"));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a conversion saturates"
    )]
    let mut left = (seconds * 1e9).round() as u64;
    loop {
        let ns = left.min(MAX_SLEEP_NS);
        left -= ns;
        // Other components of this thread exchange values, too: their sleeps end together with the first one's.
        py.detach(|| {
            let asleep =
                |core: &Core| Python::attach(|py| ended(core.ask(py, Request::Sleep { ns })?));
            thread::scope(|scope| {
                let others =
                    others.iter().map(|core| scope.spawn(move || asleep(core))).collect::<Vec<_>>();
                let first = asleep(first);
                // A thread that panics has reported it on standard error.
                let others = others.into_iter().filter_map(|other| other.join().ok());
                others.fold(first, Result::and)
            })
        })?;
        if left == 0 {
            return Ok(());
        }
    }
}

/// Returns the exception for a sleep that the end of the instance has cut short.
fn ended(done: Result<(), hal_protocol::Failure>) -> PyResult<()> {
    done.map_err(|failure| crate::error::new_err(failure.text))
}
