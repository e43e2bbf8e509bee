//! Components of this program.

use crate::{
    error,
    instance::{self, report},
    item::{Item, Param, Pin},
    sleep, value,
};
use hal_protocol::{Client, Failure, MAX_PAGE_PINS, PinPage, Request};
use pyo3::{
    PyClassInitializer,
    exceptions::{PyAttributeError, PyRuntimeError, PyValueError},
    prelude::*,
    types::{PyDict, PyString, PyTuple, PyType},
};
use std::{
    collections::BTreeMap,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// Default interval at which the engine exchanges values on the real clock, in milliseconds.
const POLL_MS: u64 = 2;
/// Number of pins for which the first page has space.
const FIRST_PINS: u32 = 64;
/// Largest length of a name in HAL.
const NAME_LEN: usize = 55;

/// State of a component that its pins share.
#[derive(Debug)]
pub(crate) struct Core {
    /// Connection; `None` after `exit`. Locked only while this thread does not hold Python's lock, because a request
    /// that waits takes that lock to look for signals.
    client: Mutex<Option<Client>>,
    /// Page of values; `None` before the first pin and after `exit`.
    page: Mutex<Option<PinPage>>,
}

/// Locks a value whose holder never leaves it half changed.
pub(crate) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn closed() -> PyErr {
    PyRuntimeError::new_err("Invalid operation on closed HAL component")
}

/// Returns the exception for a refusal. The refusal itself goes to standard error, as users of LinuxCNC know it.
fn refused(failure: &Failure) -> PyErr {
    report(failure);
    error::new_err("Invalid argument")
}

impl Core {
    #[inline]
    pub(crate) fn get(&self, pin: usize) -> PyResult<u64> {
        locked(&self.page).as_ref().map(|page| page.get(pin)).ok_or_else(closed)
    }

    #[inline]
    pub(crate) fn set(&self, pin: usize, bits: u64) -> PyResult<()> {
        let mut page = locked(&self.page);
        let is_set = page.as_mut().is_some_and(|page| page.set(pin, bits));
        if is_set { Ok(()) } else { Err(closed()) }
    }

    /// Sends a request while other threads of Python run.
    pub(crate) fn ask(&self, py: Python<'_>, request: Request) -> PyResult<Result<(), Failure>> {
        py.detach(|| {
            let mut client = locked(&self.client);
            let client = client.as_mut().ok_or_else(closed)?;
            Ok(instance::call(client, request)?.map(drop))
        })
    }

    /// Returns whether the instance runs on the virtual clock.
    pub(crate) fn is_virtual(&self) -> bool {
        locked(&self.page).as_ref().is_some_and(|page| page.info().is_virtual)
    }

    /// Ensures that the page has space for this number of pins.
    fn share(&self, py: Python<'_>, pins: usize) -> PyResult<()> {
        let fits = |page: &PinPage| page.info().pins as usize >= pins;
        if locked(&self.page).as_ref().is_some_and(fits) {
            return Ok(());
        }
        let pins = u32::try_from(pins).unwrap_or(u32::MAX);
        if pins > MAX_PAGE_PINS {
            let why = format!("a component in Python has at most {MAX_PAGE_PINS} pins");
            return Err(refused(&Failure::new(-12, why)));
        }
        // The maximum is a power of two as well.
        let space = pins.next_power_of_two().max(FIRST_PINS);
        let shared = py.detach(|| {
            let mut client = locked(&self.client);
            let client = client.as_mut().ok_or_else(closed)?;
            // Locked until the new page is there, so that no other thread finds none.
            let mut page = locked(&self.page);
            let new = client.share_pins(space, page.as_ref());
            Ok::<_, PyErr>(new.map(|new| *page = Some(new)))
        })?;
        shared.map_err(|e| refused(&e))
    }

    fn close(&self, py: Python<'_>) {
        py.detach(|| *locked(&self.client) = None);
        *locked(&self.page) = None;
    }
}

/// Component of this program: what the class `component` of `hal` is made of.
#[pyclass(name = "component", module = "hal", subclass, dict)]
#[derive(Debug)]
pub(crate) struct Join {
    core: Arc<Core>,
    name: String,
    prefix: String,
    id: u32,
    /// Pins and parameters by name. Names are strings of Python, whose hashes are known.
    items: Py<PyDict>,
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
    fn open(&self) -> PyResult<()> {
        if self.state == State::Closed { Err(closed()) } else { Ok(()) }
    }

    fn find<'py>(&self, name: &Bound<'py, PyString>) -> PyResult<Bound<'py, Item>> {
        self.open()?;
        let found = self.items.bind(name.py()).get_item(name)?;
        let found = found
            .ok_or_else(|| PyAttributeError::new_err(format!("Pin '{name}' does not exist")))?;
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
        &mut self,
        py: Python<'_>,
        what: &str,
        (name, ty, direction): (&str, i64, i64),
    ) -> PyResult<Item> {
        self.open()?;
        if self.sorted.contains_key(name) {
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
        if self.state == State::Ready {
            return Err(refused(&Failure::new(-22, format!("{what}_new called after hal_ready"))));
        }
        let full = format!("{}.{name}", self.prefix);
        if what == "pin" && full.len() > NAME_LEN {
            let why = format!("Invalid pin name length \"{full}\": max = {NAME_LEN} characters");
            return Err(error::new_err(why));
        }
        let index = self.sorted.len();
        self.core.share(py, index + 1)?;
        let done = self.core.ask(py, Request::NewPin { name: full, ty, direction })?;
        done.map_err(|e| refused(&e))?;
        let item = Item { core: Arc::clone(&self.core), index, ty, direction, name: name.into() };
        self.sorted.insert(Arc::clone(&item.name), item.clone());
        self.items.bind(py).set_item(name, item.clone())?;
        Ok(item)
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
        let mut this = Self {
            core: Arc::new(Core { client: Mutex::new(None), page: Mutex::new(None) }),
            name: String::new(),
            prefix: String::new(),
            id: 0,
            items: PyDict::new(py).unbind(),
            sorted: BTreeMap::new(),
            state: State::Closed,
        };
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
    fn join(&mut self, py: Python<'_>, name: &str, prefix: Option<&str>) -> PyResult<()> {
        if self.state != State::Closed || self.id != 0 {
            return Err(PyRuntimeError::new_err("this component has joined before"));
        }
        let (client, id) = instance::join(py, name, poll_ns())?.map_err(|e| refused(&e))?;
        self.core = Arc::new(Core { client: Mutex::new(Some(client)), page: Mutex::new(None) });
        name.clone_into(&mut self.name);
        prefix.unwrap_or(name).clone_into(&mut self.prefix);
        (self.id, self.state) = (id, State::Begun);
        Ok(())
    }

    /// Creates a pin.
    #[pyo3(signature = (name, r#type, dir, /))]
    fn newpin(&mut self, py: Python<'_>, name: &str, r#type: i64, dir: i64) -> PyResult<Py<Pin>> {
        let item = self.create(py, "pin", (name, r#type, dir))?;
        Py::new(py, PyClassInitializer::from(item).add_subclass(Pin))
    }

    /// Creates a parameter.
    #[pyo3(signature = (name, r#type, dir, /))]
    fn newparam(
        &mut self,
        py: Python<'_>,
        name: &str,
        r#type: i64,
        dir: i64,
    ) -> PyResult<Py<Param>> {
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
        self.open()?;
        let all = PyDict::new(py);
        for (name, item) in &self.sorted {
            all.set_item(name.as_ref(), item.get(py)?)?;
        }
        Ok(all)
    }

    /// Returns the prefix of the names of pins.
    fn getprefix(&self) -> PyResult<&str> {
        self.open()?;
        Ok(&self.prefix)
    }

    /// Sets the prefix of the pins created from now on.
    fn setprefix(&mut self, prefix: &str) -> PyResult<()> {
        self.open()?;
        prefix.clone_into(&mut self.prefix);
        Ok(())
    }

    /// Declares that all pins are there: `loadusr -W` waits for this.
    fn ready(&mut self, py: Python<'_>) -> PyResult<()> {
        self.open()?;
        if self.state == State::Ready {
            let why = format!("Component '{}' already ready", self.name);
            return Err(refused(&Failure::new(-22, why)));
        }
        self.core.share(py, 1)?;
        self.core.ask(py, Request::Ready)?.map_err(|e| refused(&e))?;
        self.state = State::Ready;
        sleep::begin(py, &self.core)
    }

    /// Declares that further pins will be created.
    fn unready(&mut self, py: Python<'_>) -> PyResult<()> {
        self.open()?;
        if self.state == State::Begun {
            let why = format!("Component '{}' already unready", self.name);
            return Err(refused(&Failure::new(-22, why)));
        }
        self.core.ask(py, Request::Unready)?.map_err(|e| refused(&e))?;
        self.state = State::Begun;
        sleep::end(&self.core);
        Ok(())
    }

    /// Leaves the instance: the component and its pins are removed.
    fn exit(&mut self, py: Python<'_>) -> PyResult<()> {
        self.open()?;
        self.state = State::Closed;
        sleep::end(&self.core);
        // If the instance has ended, there is nothing to leave.
        let left = self.core.ask(py, Request::Leave);
        self.core.close(py);
        left.map(drop)
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
        self.open()?;
        Ok(self.sorted.len())
    }

    fn __repr__(&self) -> String {
        let count = self.sorted.len();
        format!("<hal component {}({}) with {count} pins and params>", self.name, self.id)
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
