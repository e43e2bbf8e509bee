//! The Python module `_machine`, on which the module `linuxcnc` stands: snapshots, commands and files of a machine.

use crate::{
    connection::{call, locked},
    drawing, value,
};
use hal_protocol::{
    Client, CommandLine, Orders, Place, Reply, Request, Snapshot, Stop, TicketInfo, Value,
};
use pyo3::{
    exceptions::{PyKeyError, PyRuntimeError},
    prelude::*,
    types::PyTuple,
};
use std::{
    collections::BTreeMap,
    path::Path,
    sync::{Arc, Mutex},
};

pyo3::create_exception!(
    linuxcnc,
    error,
    PyRuntimeError,
    "A failure of the machine, or of its files."
);

fn connect(py: Python<'_>) -> PyResult<Client> {
    py.detach(|| {
        let place = Place::find(None).map_err(error::new_err)?;
        Client::connect(&place, "").map_err(|e| error::new_err(e.to_string()))
    })
}

/// The latest record of a snapshot.
#[pyclass(module = "_machine", frozen)]
struct Page {
    /// First value and number of values of each field.
    fields: BTreeMap<String, (usize, usize)>,
    record: Mutex<Record>,
}

struct Record {
    snapshot: Snapshot,
    values: Vec<Value>,
    next: Vec<Value>,
    /// Connection of the channel.
    client: Arc<Mutex<Client>>,
}

#[pymethods]
impl Page {
    /// Maps the snapshot of this name through the connection of a channel.
    #[new]
    fn new(py: Python<'_>, channel: &Channel, name: &str) -> PyResult<Self> {
        let client = channel.client.clone();
        let snapshot = py.detach(|| locked(&client).snapshot(name));
        let snapshot = snapshot.map_err(|e| error::new_err(e.to_string()))?;
        let (mut fields, mut first) = (BTreeMap::new(), 0);
        for field in &snapshot.info().fields {
            let count = field.count as usize;
            fields.insert(field.name.clone(), (first, count));
            first += count;
        }
        let (values, next) = (Vec::new(), Vec::with_capacity(first));
        let page = Self { fields, record: Mutex::new(Record { snapshot, values, next, client }) };
        page.poll(py)?;
        Ok(page)
    }

    /// Reads the latest record, and returns the number of records so far.
    fn poll(&self, py: Python<'_>) -> PyResult<u64> {
        // Other threads go on while the component writes.
        let count = py.detach(|| {
            let record = &mut *locked(&self.record);
            if locked(&record.client).is_gone() {
                return Err("the machine has ended");
            }
            let count = record.snapshot.wait(&mut record.next);
            std::mem::swap(&mut record.values, &mut record.next);
            count.ok_or("the component does not end its record")
        });
        count.map_err(error::new_err)
    }

    fn __contains__(&self, name: &str) -> bool {
        self.fields.contains_key(name)
    }

    /// Returns the value of a field, or a tuple of its values.
    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
        let field = self.fields.get(name);
        let (first, count) = *field.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        let record = locked(&self.record);
        let values = record.values.get(first..first + count).unwrap_or_default();
        if let ([one], 1) = (values, count) {
            return value::object(py, one.ty(), one.bits());
        }
        let all = values
            .iter()
            .map(|v| value::object(py, v.ty(), v.bits()))
            .collect::<PyResult<Vec<_>>>()?;
        Ok(PyTuple::new(py, all)?.into_any().unbind())
    }

    /// Returns a field of words as text: eight bytes in each, the first lowest.
    fn text(&self, name: &str) -> PyResult<String> {
        let field = self.fields.get(name);
        let (first, count) = *field.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        let record = locked(&self.record);
        Ok(Snapshot::text(record.values.get(first..first + count).unwrap_or_default()))
    }
}

/// A connection for commands and snapshots.
#[pyclass(module = "_machine", frozen)]
struct Channel {
    client: Arc<Mutex<Client>>,
    /// Commands of the machine, once they were asked for.
    orders: Mutex<Option<Arc<Orders>>>,
}

impl Channel {
    fn ask(&self, py: Python<'_>, request: Request) -> PyResult<Reply> {
        let reply = py.detach(|| call(&mut locked(&self.client), request))?;
        reply.map_err(|e| error::new_err(e.text))
    }

    /// Returns the commands of the machine; those of a machine without a task are listed each time, as it may still get one.
    fn orders(&self, py: Python<'_>, anew: bool) -> PyResult<Arc<Orders>> {
        if let Some(orders) = &*locked(&self.orders)
            && orders.has_task()
            && !anew
        {
            return Ok(orders.clone());
        }
        let list = match self.ask(py, Orders::list())? {
            Reply::Commands(list) => list,
            _ => Vec::new(),
        };
        let orders = Orders::of(&list).map_err(|missing| error::new_err(missing.to_string()))?;
        let orders = Arc::new(orders);
        *locked(&self.orders) = Some(orders.clone());
        Ok(orders)
    }
}

#[pymethods]
impl Channel {
    #[new]
    fn new(py: Python<'_>) -> PyResult<Self> {
        let client = Arc::new(Mutex::new(connect(py)?));
        Ok(Self { client, orders: Mutex::default() })
    }

    /// Sends a command of a component. Returns its lines, and the number of its ticket if it takes time. A refusal
    /// raises `error`.
    #[pyo3(signature = (name, *args))]
    fn command(
        &self,
        py: Python<'_>,
        name: String,
        args: Vec<String>,
    ) -> PyResult<(Vec<String>, Option<u64>)> {
        match self.ask(py, Request::Command { name, args })? {
            Reply::Answer(answer) => Ok((answer.lines, answer.ticket)),
            _ => Ok((Vec::new(), None)),
        }
    }

    /// Sets the commands that are executed when this connection ends, each with its arguments, in place of those before.
    fn at_end(&self, py: Python<'_>, commands: Vec<(String, Vec<String>)>) -> PyResult<()> {
        let lines = commands.into_iter().map(|(name, args)| CommandLine { name, args });
        self.ask(py, Request::AtEnd { commands: lines.collect() }).map(drop)
    }

    /// Sends a command as `command` does; on a machine without a task, one of the task becomes what does the same.
    #[pyo3(signature = (name, *args))]
    fn order(
        &self,
        py: Python<'_>,
        name: String,
        args: Vec<String>,
    ) -> PyResult<(Vec<String>, Option<u64>)> {
        let orders = self.orders(py, false)?;
        match orders.request(&name, args).map_err(|why| error::new_err(why.to_string()))? {
            Some(Request::Command { name, args }) => self.command(py, name, args),
            _ => Ok((Vec::new(), None)),
        }
    }

    /// Raises `error` if something moves that nothing stops.
    fn check_stops(&self, py: Python<'_>) -> PyResult<()> {
        self.orders(py, true).map(drop)
    }

    /// Stops the machine: sends every command of the stop `estop`, `off`, `abort` or `pause`. Returns the numbers of the tickets
    /// of those that take time, and the refusals.
    fn stop(&self, py: Python<'_>, stop: &str) -> PyResult<(Vec<u64>, Vec<String>)> {
        let stop = Stop::named(stop)
            .ok_or_else(|| error::new_err(format!("there is no stop '{stop}'")))?;
        let (mut tickets, mut refused) = (Vec::new(), Vec::new());
        let orders = self.orders(py, true)?;
        let names = orders.stops().commands(stop);
        for name in names {
            match self.command(py, (*name).to_owned(), Vec::new()) {
                Ok((_, ticket)) => tickets.extend(ticket),
                Err(why) => refused.push(format!("{name}: {}", why.value(py))),
            }
        }
        if names.is_empty() {
            refused.push("nothing of this machine can be stopped so".to_owned());
        }
        Ok((tickets, refused))
    }

    /// Returns `None` while a command is in progress, an empty text when it is done, or the reason why it failed.
    fn ticket(&self, py: Python<'_>, id: u64) -> PyResult<Option<String>> {
        match self.ask(py, Request::Ticket { id, wait: false })? {
            Reply::Ticket(TicketInfo::Pending) => Ok(None),
            Reply::Ticket(TicketInfo::Failed(why)) => Ok(Some(why)),
            _ => Ok(Some(String::new())),
        }
    }

    /// Returns whether the scripts with which the instance starts are in progress.
    fn is_starting(&self, py: Python<'_>) -> PyResult<bool> {
        let reply = self.ask(py, Request::Status)?;
        Ok(matches!(reply, Reply::Status(status) if status.starting))
    }

    /// Returns the process of the instance, and the arguments with which a component was loaded.
    fn loaded(&self, py: Python<'_>, name: String) -> PyResult<(Option<i32>, Option<String>)> {
        let pid = match self.ask(py, Request::Status)? {
            Reply::Status(status) => Some(status.pid),
            _ => None,
        };
        let args = match self.ask(py, Request::Component { name })? {
            Reply::Components(list) => list.into_iter().next().and_then(|c| c.args),
            _ => None,
        };
        Ok((pid, args))
    }
}

/// An INI file.
#[pyclass(module = "linuxcnc", name = "ini")]
struct IniFile {
    ini: hal_ini::Ini,
}

#[pymethods]
impl IniFile {
    #[new]
    #[pyo3(signature = (path, /))]
    fn new(path: &str) -> PyResult<Self> {
        // Panels without a machine open this one.
        let ini = if path == "/dev/null" {
            hal_ini::Ini::parse(path, b"")
        } else {
            hal_ini::Ini::read(Path::new(path))
        };
        ini.map(|ini| Self { ini })
            .map_err(|e| error::new_err(format!("inifile.open() failed: {e}")))
    }

    /// `find(SECTION, OPTION)`: returns the first value, or None.
    #[pyo3(signature = (section, option, /))]
    fn find(&self, section: &str, option: &str) -> Option<&str> {
        self.ini.get(section, option)
    }

    /// `findall(SECTION, OPTION)`: returns all values in the order of the file.
    #[pyo3(signature = (section, option, /))]
    fn findall(&self, section: &str, option: &str) -> Vec<&str> {
        self.ini.all(section, option).map(|entry| entry.value.as_str()).collect()
    }
}

/// Returns whether the machine's unit of length is the inch; else it is the millimetre.
#[pyfunction]
fn is_inch(file: &IniFile) -> bool {
    file.ini.is_inch().unwrap_or(false)
}

/// A tool: number, pocket, nine offsets, diameter, front and back angle, orientation.
type ToolRow = (i32, i32, [f64; 9], f64, f64, f64, u8);

/// Returns the tools of a tool table, in the order of the file.
#[pyfunction]
fn tools(path: &str) -> PyResult<Vec<ToolRow>> {
    let text = hal_ini::file::whole(Path::new(path));
    let text = text.map_err(|e| error::new_err(format!("{path}: {e}")))?;
    let (table, _) = hal_gcode::tool::ToolTable::parse(&String::from_utf8_lossy(&text));
    let rows = table.tools.iter().map(|t| {
        let offset = hal_gcode::axis::Axis::ALL.map(|a| t.offset[a]);
        (t.number, t.pocket, offset, t.diameter, t.front, t.back, t.orientation)
    });
    Ok(rows.collect())
}

/// A machine and its files.
#[pymodule]
fn _machine(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("error", module.py().get_type::<error>())?;
    module.add_class::<Page>()?;
    module.add_class::<Channel>()?;
    module.add_class::<IniFile>()?;
    module.add_function(wrap_pyfunction!(is_inch, module)?)?;
    module.add_function(wrap_pyfunction!(tools, module)?)?;
    module.add_function(wrap_pyfunction!(drawing::gui_respect_offsets, module)?)?;
    module.add_function(wrap_pyfunction!(drawing::gui_rot_offsets, module)?)?;
    module.add_function(wrap_pyfunction!(drawing::vertex9, module)?)?;
    module.add_function(wrap_pyfunction!(drawing::pieces, module)?)?;
    module.add_function(wrap_pyfunction!(drawing::vertices, module)?)
}
