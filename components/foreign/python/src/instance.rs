//! Functions of the module that concern the whole instance.

use crate::{
    connection::{call, locked},
    error, value,
};
use hal_protocol::{
    Client, ComponentInfo, Direction, Failure, ItemInfo, Kind, Place, Reply, Request, Type, Value,
};
use pyo3::{
    exceptions::{PyNameError, PyRuntimeError},
    prelude::*,
    types::{PyDict, PyList},
};
use std::{
    io::Write,
    sync::{
        Mutex,
        atomic::{AtomicBool, AtomicI32, Ordering::Relaxed},
    },
};

/// Connection for requests that belong to no component of this program. Locked only without Python's lock.
static CLIENT: Mutex<Option<Client>> = Mutex::new(None);
/// Set when this program has created a component.
static HAS_JOINED: AtomicBool = AtomicBool::new(false);
/// Message level that this program has set last.
static MESSAGE_LEVEL: AtomicI32 = AtomicI32::new(1);

/// Writes a refusal to standard error.
pub(crate) fn report(failure: &Failure) {
    // A failed write to standard error cannot be reported.
    drop(writeln!(std::io::stderr(), "HAL: ERROR: {failure}"));
}

fn connect() -> Result<Client, Failure> {
    let place = Place::find(None).map_err(|why| Failure::new(-22, why))?;
    Client::connect(&place, "")
}

/// Joins the instance that `HAL_INSTANCE` names; returns the number of the new component, too.
pub(crate) fn join(
    py: Python<'_>,
    name: &str,
    poll_ns: u64,
) -> PyResult<Result<(Client, u32), Failure>> {
    let joined = py.detach(|| {
        let mut client = match connect() {
            Ok(client) => client,
            Err(e) => return Ok(Err(e)),
        };
        let joined = call(&mut client, Request::Join { name: name.to_owned(), poll_ns })?;
        if let Err(e) = joined {
            return Ok(Err(e));
        }
        let found = call(&mut client, Request::Component { name: name.to_owned() })?;
        let id = |reply: Reply| match reply {
            Reply::Components(list) => list.first().map_or(0, |me| me.id),
            _ => 0,
        };
        Ok::<_, PyErr>(found.map(|found| (client, id(found))))
    })?;
    if joined.is_ok() {
        HAS_JOINED.store(true, Relaxed);
    }
    Ok(joined)
}

/// Sends a request of this program.
fn ask(py: Python<'_>, request: Request) -> PyResult<Result<Reply, Failure>> {
    if !HAS_JOINED.load(Relaxed) {
        return Err(PyRuntimeError::new_err("Cannot call before creating component"));
    }
    py.detach(|| {
        let mut client = locked(&CLIENT);
        if client.is_none() {
            match connect() {
                Ok(new) => *client = Some(new),
                Err(e) => return Ok(Err(e)),
            }
        }
        let Some(open) = client.as_mut() else { return Ok(Err(Failure::new(-5, "no connection"))) };
        let reply = call(open, request);
        // A connection whose answer was not awaited, or that is closed, is of no further use.
        if reply.is_err() || open.is_gone() {
            *client = None;
        }
        reply
    })
}

/// Sends a request, and returns whether it was refused: the convention of these functions in LinuxCNC, where 0 means
/// success. The reason goes to standard error.
fn fails(py: Python<'_>, request: Request) -> PyResult<bool> {
    Ok(ask(py, request)?.map_err(|e| report(&e)).is_err())
}

/// Sends a request whose refusal is an exception.
fn demand(py: Python<'_>, request: Request) -> PyResult<Reply> {
    ask(py, request)?.map_err(|e| error::new_err(e.to_string()))
}

fn list(py: Python<'_>, kind: Kind) -> PyResult<Reply> {
    demand(py, Request::List { kind, patterns: Vec::new(), ty: None })
}

/// Returns the pins or parameters in the order of their names.
fn items(py: Python<'_>, kind: Kind) -> PyResult<Vec<ItemInfo>> {
    let Reply::Items(mut items) = list(py, kind)? else { return Ok(Vec::new()) };
    items.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(items)
}

/// Returns the pin or parameter of this name.
fn item(py: Python<'_>, kind: Kind, name: &str) -> PyResult<Option<ItemInfo>> {
    let patterns = vec![name.to_owned()];
    match demand(py, Request::List { kind, patterns, ty: None })? {
        Reply::Items(items) => {
            Ok(items.into_iter().find(|i| i.name == name || i.original.as_deref() == Some(name)))
        }
        _ => Ok(None),
    }
}

fn component(py: Python<'_>, name: &str) -> PyResult<Option<ComponentInfo>> {
    match demand(py, Request::Component { name: name.to_owned() })? {
        Reply::Components(mut list) => Ok(list.pop()),
        _ => Ok(None),
    }
}

fn object(py: Python<'_>, value: Value) -> PyResult<Py<PyAny>> {
    value::object(py, value.ty(), value.bits())
}

/// Returns whether the component exists.
#[pyfunction]
#[pyo3(signature = (name, /))]
fn component_exists(py: Python<'_>, name: &str) -> PyResult<bool> {
    Ok(component(py, name)?.is_some())
}

/// Returns whether the component exists and is ready.
#[pyfunction]
#[pyo3(signature = (name, /))]
fn component_is_ready(py: Python<'_>, name: &str) -> PyResult<bool> {
    let ready = hal_protocol::ComponentState::Ready;
    Ok(component(py, name)?.is_some_and(|c| c.state == ready))
}

/// Creates a signal. Returns False if that succeeds.
#[pyfunction]
#[pyo3(signature = (name, r#type, /))]
fn new_sig(py: Python<'_>, name: &str, r#type: i64) -> PyResult<bool> {
    if !HAS_JOINED.load(Relaxed) {
        return Err(PyRuntimeError::new_err("Cannot call before creating component"));
    }
    let ty = value::type_of(r#type);
    let ty = ty.ok_or_else(|| PyRuntimeError::new_err("not a valid HAL signal type"))?;
    fails(py, Request::NewSignal { name: name.to_owned(), ty })
}

/// Links a pin to a signal. Returns False if that succeeds.
#[pyfunction]
#[pyo3(name = "connect", signature = (pin, signal, /))]
fn connect_pin(py: Python<'_>, pin: &str, signal: &str) -> PyResult<bool> {
    fails(py, Request::Link { pin: pin.to_owned(), signal: signal.to_owned() })
}

/// Unlinks a pin. Returns False if that succeeds.
#[pyfunction]
#[pyo3(signature = (pin, /))]
fn disconnect(py: Python<'_>, pin: &str) -> PyResult<bool> {
    fails(py, Request::Unlink { pin: pin.to_owned() })
}

/// Returns whether an output is linked to the signal of this pin.
#[pyfunction]
#[pyo3(signature = (pin, /))]
fn pin_has_writer(py: Python<'_>, pin: &str) -> PyResult<bool> {
    let found = item(py, Kind::Pins, pin)?;
    let found = found.ok_or_else(|| PyNameError::new_err(format!("Pin `{pin}' does not exist")))?;
    let Some(signal) = found.signal else { return Ok(false) };
    let Reply::Signals(signals) = list(py, Kind::Signals)? else { return Ok(false) };
    let is_out = |(direction, _): &(Direction, String)| *direction == Direction::Out;
    Ok(signals.iter().any(|s| s.name == signal && s.pins.iter().any(is_out)))
}

/// Returns the value of a pin, parameter or signal.
#[pyfunction]
#[pyo3(signature = (name, /))]
fn get_value(py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
    if let Ok(Reply::Value(value)) = ask(py, Request::Get { name: name.to_owned() })? {
        return object(py, value);
    }
    match ask(py, Request::GetSignal { name: name.to_owned() })? {
        Ok(Reply::Value(value)) => object(py, value),
        _ => Err(PyRuntimeError::new_err(format!("Can't set value: pin / param {name} not found"))),
    }
}

/// Sets a pin or parameter to a value, which is a text. Returns False if that succeeds.
#[pyfunction]
#[pyo3(signature = (name, value, /))]
fn set_p(py: Python<'_>, name: &str, value: &str) -> PyResult<bool> {
    let refuse = |why: &'static str| Err(PyRuntimeError::new_err(why));
    match item(py, Kind::Pins, name)? {
        Some(pin) if pin.direction == Direction::Out => return refuse("pin not writable"),
        Some(pin) if pin.signal.is_some() => return refuse("pin connected to signal"),
        Some(_) => {}
        None => match item(py, Kind::Params, name)? {
            Some(param) if param.direction == Direction::Ro => return refuse("param not writable"),
            Some(_) => {}
            None => return refuse("pin not found"),
        },
    }
    fails(py, Request::Set { name: name.to_owned(), value: value.to_owned() })
}

/// Sets a signal without an output to a value, which is a text. Returns False if that succeeds.
#[pyfunction]
#[pyo3(signature = (name, value, /))]
fn set_s(py: Python<'_>, name: &str, value: &str) -> PyResult<bool> {
    fails(py, Request::SetSignal { name: name.to_owned(), value: value.to_owned() })
}

/// Returns the value of a signal.
#[pyfunction]
#[pyo3(signature = (name, /))]
fn get_s(py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
    match ask(py, Request::GetSignal { name: name.to_owned() })? {
        Ok(Reply::Value(value)) => object(py, value),
        Ok(_) => Err(error::new_err("the answer does not match the request")),
        Err(e) => Err(PyRuntimeError::new_err(e.to_string())),
    }
}

/// Returns all pins: a list of {NAME, VALUE, DIRECTION, TYPE}.
#[pyfunction]
fn get_info_pins<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for pin in items(py, Kind::Pins)? {
        let row = PyDict::new(py);
        row.set_item("NAME", &pin.name)?;
        row.set_item("VALUE", object(py, pin.value)?)?;
        row.set_item("DIRECTION", value::direction_code(pin.direction))?;
        row.set_item("TYPE", pin.value.ty().code())?;
        all.append(row)?;
    }
    Ok(all)
}

/// Returns all parameters: a list of {NAME, DIRECTION, VALUE}.
#[pyfunction]
fn get_info_params<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    for param in items(py, Kind::Params)? {
        let row = PyDict::new(py);
        row.set_item("NAME", &param.name)?;
        row.set_item("DIRECTION", value::direction_code(param.direction))?;
        row.set_item("VALUE", object(py, param.value)?)?;
        all.append(row)?;
    }
    Ok(all)
}

/// Returns all signals: a list of {NAME, VALUE, DRIVER, TYPE}. The driver is an output, or None.
#[pyfunction]
fn get_info_signals<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
    let all = PyList::empty(py);
    let Reply::Signals(mut signals) = list(py, Kind::Signals)? else { return Ok(all) };
    signals.sort_by(|a, b| a.name.cmp(&b.name));
    for signal in signals {
        let driver = signal.pins.iter().find(|(direction, _)| *direction == Direction::Out);
        let row = PyDict::new(py);
        row.set_item("NAME", &signal.name)?;
        // The value of a port is its size.
        let is_port = signal.value.ty() == Type::Port;
        row.set_item("VALUE", if is_port { py.None() } else { object(py, signal.value)? })?;
        row.set_item("DRIVER", driver.map(|(_, name)| name))?;
        row.set_item("TYPE", signal.value.ty().code())?;
        all.append(row)?;
    }
    Ok(all)
}

/// Returns the level of messages, such as `MSG_ERR`, that this program has set.
#[pyfunction]
fn get_msg_level() -> i32 {
    MESSAGE_LEVEL.load(Relaxed)
}

/// Sets which messages of components are shown.
#[pyfunction]
#[pyo3(signature = (level, /))]
fn set_msg_level(py: Python<'_>, level: i32) -> PyResult<()> {
    MESSAGE_LEVEL.store(level, Relaxed);
    if HAS_JOINED.load(Relaxed) {
        let level = u8::try_from(level.max(0)).map_or(5, |level| level.min(5));
        demand(py, Request::MessageLevel { level })?;
    }
    Ok(())
}

/// Adds the functions to the module.
pub(crate) fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(component_exists, module)?)?;
    module.add_function(wrap_pyfunction!(component_is_ready, module)?)?;
    module.add_function(wrap_pyfunction!(new_sig, module)?)?;
    module.add_function(wrap_pyfunction!(connect_pin, module)?)?;
    module.add_function(wrap_pyfunction!(disconnect, module)?)?;
    module.add_function(wrap_pyfunction!(pin_has_writer, module)?)?;
    module.add_function(wrap_pyfunction!(get_value, module)?)?;
    module.add_function(wrap_pyfunction!(set_p, module)?)?;
    module.add_function(wrap_pyfunction!(set_s, module)?)?;
    module.add_function(wrap_pyfunction!(get_s, module)?)?;
    module.add_function(wrap_pyfunction!(get_info_pins, module)?)?;
    module.add_function(wrap_pyfunction!(get_info_params, module)?)?;
    module.add_function(wrap_pyfunction!(get_info_signals, module)?)?;
    module.add_function(wrap_pyfunction!(get_msg_level, module)?)?;
    module.add_function(wrap_pyfunction!(set_msg_level, module)?)
}
