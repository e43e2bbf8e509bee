//! The Python module `_machine`, on which the module `linuxcnc` stands: snapshots, commands and files of a machine.

use crate::{
    connection::{call, locked},
    drawing, value,
};
use hal_protocol::{Client, Place, Reply, Request, Snapshot, TicketInfo, Value};
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
}

impl Channel {
    fn ask(&self, py: Python<'_>, request: Request) -> PyResult<Reply> {
        let reply = py.detach(|| call(&mut locked(&self.client), request))?;
        reply.map_err(|e| error::new_err(e.text))
    }
}

#[pymethods]
impl Channel {
    #[new]
    fn new(py: Python<'_>) -> PyResult<Self> {
        Ok(Self { client: Arc::new(Mutex::new(connect(py)?)) })
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
