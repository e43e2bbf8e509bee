//! Components of this program.

use crate::{
    connection::{Core, Turn, closed, locked},
    error,
    instance::{self, report},
    item::{Item, Param, Pin},
    sleep, value,
};
use hal_protocol::{Failure, Request};
use pyo3::{
    PyClassInitializer,
    exceptions::{PyAttributeError, PyRuntimeError, PyValueError},
    prelude::*,
    types::{PyDict, PyString, PyTuple, PyType},
};
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, MutexGuard},
};

/// Default interval at which the engine exchanges values on the real clock, in milliseconds.
const POLL_MS: u64 = 2;
/// Largest length of a name in HAL.
const NAME_LEN: usize = 55;

/// Returns the exception for a refusal. The refusal itself goes to standard error, as users of LinuxCNC know it.
fn refused(failure: &Failure) -> PyErr {
    report(failure);
    error::new_err("Invalid argument")
}

/// Component of this program: what the class `component` of `hal` is made of. Several threads may use it at once.
#[pyclass(name = "component", module = "hal", subclass, dict, frozen)]
#[derive(Debug)]
pub(crate) struct Join {
    core: Arc<Core>,
    /// Pins and parameters by name; none after `exit`. Names are strings of Python, whose hashes are known.
    items: Py<PyDict>,
    /// Locked for short times, in which nothing of Python runs. It is changed by the thread that has the turn.
    joined: Mutex<Joined>,
}

/// State of a component.
#[derive(Debug)]
struct Joined {
    name: String,
    prefix: String,
    id: u32,
    sorted: BTreeMap<Arc<str>, Item>,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Begun,
    Ready,
    Closed,
}

impl Join {
    /// Returns the state of a component that has not left.
    fn open(&self) -> PyResult<MutexGuard<'_, Joined>> {
        let joined = locked(&self.joined);
        if joined.state == State::Closed { Err(closed()) } else { Ok(joined) }
    }

    fn find<'py>(&self, name: &Bound<'py, PyString>) -> PyResult<Bound<'py, Item>> {
        let Some(found) = self.items.bind(name.py()).get_item(name)? else {
            drop(self.open()?);
            return Err(PyAttributeError::new_err(format!("Pin '{name}' does not exist")));
        };
        Ok(found.cast_into::<Item>()?)
    }

    /// Returns a pin, or a parameter.
    fn of_kind(&self, name: &Bound<'_, PyString>, pin: bool) -> PyResult<Item> {
        let item = self.find(name)?.get().clone();
        if item.direction.is_pin() == pin {
            return Ok(item);
        }
        let kind = if pin { "pin" } else { "parameter" };
        Err(PyAttributeError::new_err(format!("'{name}' is no {kind}")))
    }

    /// Creates a pin or parameter; `what` is its name in messages.
    fn create(
        &self,
        py: Python<'_>,
        what: &str,
        (name, ty, direction): (&str, i64, i64),
    ) -> PyResult<Item> {
        let turn = self.core.turn(py)?;
        let (full, index, is_ready, is_known) = {
            let joined = self.open()?;
            let full = format!("{}.{name}", joined.prefix);
            let is_ready = joined.state == State::Ready;
            (full, joined.sorted.len(), is_ready, joined.sorted.contains_key(name))
        };
        if is_known {
            let what = if what == "pin" { "pin" } else { "parameter" };
            return Err(PyValueError::new_err(format!("Duplicate {what} name '{name}'")));
        }
        let ty = value::type_of(ty)
            .ok_or_else(|| error::new_err(format!("Invalid {what} type {ty}")))?;
        let direction = value::direction(direction).filter(|d| d.is_pin() == (what == "pin"));
        let direction = direction.ok_or_else(|| {
            let allowed =
                if what == "pin" { "HAL_IN, HAL_OUT, or HAL_IO" } else { "HAL_RO, or HAL_RW" };
            refused(&Failure::new(-22, format!("{what} direction not one of {allowed}")))
        })?;
        if is_ready {
            return Err(refused(&Failure::new(-22, format!("{what}_new called after hal_ready"))));
        }
        if what == "pin" && full.len() > NAME_LEN {
            let why = format!("Invalid pin name length \"{full}\": max = {NAME_LEN} characters");
            return Err(error::new_err(why));
        }
        self.share(py, &turn, index + 1)?;
        let done = self.core.ask_in(py, &turn, Request::NewPin { name: full, ty, direction })?;
        done.map_err(|e| refused(&e))?;
        let item = Item { core: Arc::clone(&self.core), index, ty, direction, name: name.into() };
        locked(&self.joined).sorted.insert(Arc::clone(&item.name), item.clone());
        self.items.bind(py).set_item(name, item.clone())?;
        Ok(item)
    }

    /// Ensures that the component is in this state: neither gone nor in the other one.
    fn must_be(&self, state: State) -> PyResult<()> {
        let joined = self.open()?;
        if joined.state == state {
            return Ok(());
        }
        let other = if state == State::Begun { "ready" } else { "unready" };
        let why = format!("Component '{}' already {other}", joined.name);
        drop(joined);
        Err(refused(&Failure::new(-22, why)))
    }

    /// Ensures that the page has space for this number of pins.
    fn share(&self, py: Python<'_>, turn: &Turn<'_>, pins: usize) -> PyResult<()> {
        self.core.share(py, turn, pins)?.map_err(|e| refused(&e))
    }
}

#[pymethods]
impl Join {
    /// Creates a component that has not joined: a class in Python joins in its `__init__`, whose arguments are its own. This
    /// class itself joins at once.
    #[new]
    #[classmethod]
    #[pyo3(signature = (*args))]
    fn new(class: &Bound<'_, PyType>, args: &Bound<'_, PyTuple>) -> PyResult<Self> {
        let py = class.py();
        let joined = Joined {
            name: String::new(),
            prefix: String::new(),
            id: 0,
            sorted: BTreeMap::new(),
            state: State::Closed,
        };
        let items = PyDict::new(py).unbind();
        let this = Self { core: Arc::default(), items, joined: Mutex::new(joined) };
        if class.is(py.get_type::<Self>()) {
            let (name, prefix) = match args.len() {
                1 => (args.extract::<(String,)>()?.0, None),
                _ => {
                    args.extract::<(String, String)>().map(|(name, prefix)| (name, Some(prefix)))?
                }
            };
            this.join(py, &name, prefix.as_deref())?;
        }
        Ok(this)
    }

    /// Joins the instance as a component of this name. Names of pins begin with the prefix, or with the name.
    #[pyo3(name = "_join", signature = (name, prefix=None, /))]
    fn join(&self, py: Python<'_>, name: &str, prefix: Option<&str>) -> PyResult<()> {
        let turn = self.core.turn(py)?;
        if locked(&self.joined).id != 0 {
            return Err(PyRuntimeError::new_err("this component has joined before"));
        }
        let (client, id) = instance::join(py, name, poll_ns())?.map_err(|e| refused(&e))?;
        self.core.open(&turn, client);
        let mut joined = locked(&self.joined);
        name.clone_into(&mut joined.name);
        prefix.unwrap_or(name).clone_into(&mut joined.prefix);
        (joined.id, joined.state) = (id, State::Begun);
        Ok(())
    }

    /// Creates a pin.
    #[pyo3(signature = (name, r#type, dir, /))]
    fn newpin(&self, py: Python<'_>, name: &str, r#type: i64, dir: i64) -> PyResult<Py<Pin>> {
        let item = self.create(py, "pin", (name, r#type, dir))?;
        Py::new(py, PyClassInitializer::from(item).add_subclass(Pin))
    }

    /// Creates a parameter.
    #[pyo3(signature = (name, r#type, dir, /))]
    fn newparam(&self, py: Python<'_>, name: &str, r#type: i64, dir: i64) -> PyResult<Py<Param>> {
        let item = self.create(py, "param", (name, r#type, dir))?;
        Py::new(py, PyClassInitializer::from(item).add_subclass(Param))
    }

    /// Returns a pin or parameter.
    fn getitem(&self, name: &Bound<'_, PyString>) -> PyResult<Item> {
        Ok(self.find(name)?.get().clone())
    }

    /// Returns a pin.
    fn getpin(&self, name: &Bound<'_, PyString>) -> PyResult<Py<Pin>> {
        let item = self.of_kind(name, true)?;
        Py::new(name.py(), PyClassInitializer::from(item).add_subclass(Pin))
    }

    /// Returns a parameter.
    fn getparam(&self, name: &Bound<'_, PyString>) -> PyResult<Py<Param>> {
        let item = self.of_kind(name, false)?;
        Py::new(name.py(), PyClassInitializer::from(item).add_subclass(Param))
    }

    /// Returns the values of all pins and parameters, by name.
    fn getpins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let items = self.open()?.sorted.clone();
        let all = PyDict::new(py);
        for (name, item) in &items {
            all.set_item(name.as_ref(), item.get(py)?)?;
        }
        Ok(all)
    }

    /// Returns the prefix of the names of pins.
    fn getprefix(&self) -> PyResult<String> {
        Ok(self.open()?.prefix.clone())
    }

    /// Sets the prefix of the pins created from now on.
    fn setprefix(&self, prefix: &str) -> PyResult<()> {
        prefix.clone_into(&mut self.open()?.prefix);
        Ok(())
    }

    /// Declares that all pins are there: `loadusr -W` waits for this.
    fn ready(&self, py: Python<'_>) -> PyResult<()> {
        let turn = self.core.turn(py)?;
        self.must_be(State::Begun)?;
        self.share(py, &turn, 1)?;
        self.core.ask_in(py, &turn, Request::Ready)?.map_err(|e| refused(&e))?;
        locked(&self.joined).state = State::Ready;
        sleep::begin(py, &self.core)
    }

    /// Declares that further pins will be created.
    fn unready(&self, py: Python<'_>) -> PyResult<()> {
        let turn = self.core.turn(py)?;
        self.must_be(State::Ready)?;
        self.core.ask_in(py, &turn, Request::Unready)?.map_err(|e| refused(&e))?;
        locked(&self.joined).state = State::Begun;
        sleep::end(&self.core);
        Ok(())
    }

    /// Leaves the instance: the component and its pins are removed.
    fn exit(&self, py: Python<'_>) -> PyResult<()> {
        self.open()?.state = State::Closed;
        sleep::end(&self.core);
        self.items.bind(py).clear();
        self.core.leave(py)
    }

    #[inline]
    fn __getitem__(&self, name: &Bound<'_, PyString>) -> PyResult<Py<PyAny>> {
        self.find(name)?.get().get(name.py())
    }

    #[inline]
    fn __setitem__(&self, name: &Bound<'_, PyString>, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.find(name)?.get().set(value)
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.open()?.sorted.len())
    }

    fn __repr__(&self) -> String {
        let joined = locked(&self.joined);
        let count = joined.sorted.len();
        format!("<hal component {}({}) with {count} pins and params>", joined.name, joined.id)
    }
}

impl Drop for Join {
    fn drop(&mut self) {
        sleep::end(&self.core);
    }
}

/// Returns the interval at which the engine exchanges values on the real clock.
fn poll_ns() -> u64 {
    let asked = std::env::var("HAL_POLL_MS").ok().and_then(|ms| ms.parse().ok());
    u64::min(asked.unwrap_or(POLL_MS).max(1), 1000) * 1_000_000
}
