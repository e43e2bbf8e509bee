//! Streams: the rings of `sampler` and `streamer`, and those between two programs.

use crate::{component::Join, connection::locked, value};
use hal_protocol::{Client, Code, Place, Type};
use pyo3::{
    exceptions::{PyOSError, PyTypeError, PyValueError},
    prelude::*,
    types::{PyBytes, PyTuple},
};
use std::sync::Mutex;

/// Key of the ring `sampler.0`; the next keys are those of the others.
pub(crate) const SAMPLER_BASE: i64 = 0x4853_4130;
/// Key of the ring `streamer.0`.
pub(crate) const STREAMER_BASE: i64 = 0x4853_5430;
/// Number of keys from each base on.
const KEYS: i64 = 16;
const EINVAL: i32 = 22;
const ENOSPC: i32 = 28;

/// A ring that this program shares with a component, or with another program.
#[pyclass(name = "stream", module = "hal", frozen)]
#[derive(Debug)]
pub(crate) struct Stream {
    key: i64,
    /// True if this program has made the ring.
    creates: bool,
    types: Vec<Type>,
    end: Mutex<End>,
}

#[derive(Debug)]
struct End {
    stream: hal_protocol::Stream,
    sample: u64,
    overruns: u64,
    underruns: u64,
    /// Held because the engine closes the ring to a client that leaves.
    #[expect(dead_code, reason = "keeps the connection")]
    client: Client,
}

fn invalid(why: String) -> PyErr {
    PyOSError::new_err((EINVAL, why))
}

/// Returns the letter of a type in a stream's configuration.
const fn letter(ty: Type) -> u8 {
    match ty {
        Type::Bit => b'b',
        Type::Float => b'f',
        Type::S32 => b's',
        Type::U32 => b'u',
        Type::S64 => b'l',
        Type::U64 | Type::Port => b'k',
    }
}

/// Returns the types of a stream's configuration.
fn types_of(letters: &str) -> PyResult<Vec<Type>> {
    let all = [Type::Bit, Type::Float, Type::S32, Type::U32, Type::S64, Type::U64];
    let ty = |other: char| {
        let ty = all.into_iter().find(|ty| char::from(letter(*ty)) == other.to_ascii_lowercase());
        ty.ok_or_else(|| {
            invalid(format!("stream: unknown type '{other}', must be B, F, S, U, L or K"))
        })
    };
    letters.chars().map(ty).collect()
}

impl Stream {
    fn letters(&self) -> Vec<u8> {
        self.types.iter().map(|ty| letter(*ty)).collect()
    }
}

#[pymethods]
impl Stream {
    /// Makes a ring with this key, of so many slots and values of these types: `stream(component, KEY, DEPTH, TYPES)`. Or
    /// attaches to a ring of another program, `sampler_base` + N or `streamer_base` + N: `stream(component, KEY[, TYPES])`.
    #[new]
    #[pyo3(signature = (component, key, shape=None, types=None, /))]
    fn new(
        py: Python<'_>,
        component: &Bound<'_, Join>,
        key: i64,
        shape: Option<&Bound<'_, PyAny>>,
        types: Option<&str>,
    ) -> PyResult<Self> {
        let _: &Bound<'_, Join> = component;
        let name = match (key.wrapping_sub(SAMPLER_BASE), key.wrapping_sub(STREAMER_BASE)) {
            (n @ 0..KEYS, _) => format!("sampler.{n}"),
            (_, n @ 0..KEYS) => format!("streamer.{n}"),
            _ => format!("stream.{key:x}"),
        };
        let made = match (shape, types) {
            (Some(depth), Some(types)) => {
                let depth = depth.extract::<i64>()?;
                let depth = u32::try_from(depth).ok().filter(|depth| *depth > 0);
                let depth = depth.ok_or_else(|| invalid("Invalid argument".to_owned()))?;
                Some((depth, types_of(types)?))
            }
            _ => None,
        };
        let types = shape.filter(|_| made.is_none()).map(PyAnyMethods::extract::<String>);
        let types = types.transpose()?;
        let creates = made.is_some();
        let (client, stream) = py
            .detach(|| {
                let place =
                    Place::find(None).map_err(|why| hal_protocol::Failure::new(-22, why))?;
                let mut client = Client::connect(&place, "")?;
                let stream = match made {
                    Some((depth, types)) => client.new_stream(&name, depth, types)?,
                    // LinuxCNC's words where nobody has made a ring of this key.
                    None => client.attach(&name, None).map_err(|e| {
                        let is_none = e.finding == Some(Code::NoSuchName);
                        if is_none && name.starts_with("stream.") {
                            return hal_protocol::Failure::new(-22, "Invalid argument");
                        }
                        e
                    })?,
                };
                Ok((client, stream))
            })
            .map_err(|e: hal_protocol::Failure| invalid(e.to_string()))?;
        let own = stream.types().to_vec();
        let end = End { stream, sample: 0, overruns: 0, underruns: 0, client };
        let this = Self { key, creates, types: own, end: Mutex::new(end) };
        match types.as_deref() {
            Some(types) if !types.as_bytes().eq_ignore_ascii_case(&this.letters()) => {
                let own = String::from_utf8_lossy(&this.letters()).into_owned();
                Err(invalid(format!("'{name}' has values of types '{own}', not '{types}'")))
            }
            _ => Ok(this),
        }
    }

    /// Takes the oldest record: a tuple of values, or None if there is none.
    fn read<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        let mut record = Vec::new();
        {
            let mut end = locked(&self.end);
            let Some(sample) = end.stream.take(&mut record) else {
                end.underruns += 1;
                return Ok(None);
            };
            end.sample = sample;
        }
        let values = record.iter().map(|v| value::object(py, v.ty(), v.bits()));
        let values = values.collect::<PyResult<Vec<_>>>()?;
        PyTuple::new(py, values).map(Some)
    }

    /// Appends a record, a tuple of values.
    fn write(&self, record: &Bound<'_, PyAny>) -> PyResult<()> {
        let record = record.cast::<PyTuple>().map_err(|_| {
            let name = record.get_type().name().map(|n| n.to_string()).unwrap_or_default();
            PyTypeError::new_err(format!("hal.stream.write() argument 1 must be tuple, not {name}"))
        })?;
        if record.len() != self.types.len() {
            let (expected, got) = (self.types.len(), record.len());
            return Err(PyValueError::new_err(format!("expected {expected} values, got {got}")));
        }
        let values = record.iter().zip(&self.types).map(|(object, ty)| {
            Ok(hal_protocol::Value::from_bits(*ty, value::bits(*ty, &object)?))
        });
        let values = values.collect::<PyResult<Vec<_>>>()?;
        let mut end = locked(&self.end);
        if end.stream.put(&values) {
            return Ok(());
        }
        end.overruns += 1;
        Err(PyOSError::new_err((ENOSPC, "No space left on device")))
    }

    /// Types of a record's values, one letter each.
    #[getter]
    fn element_types<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.letters())
    }

    /// Number of records in the ring.
    #[getter]
    fn depth(&self) -> u32 {
        locked(&self.end).stream.waiting()
    }

    /// Number of slots of the ring.
    #[getter]
    fn maxdepth(&self) -> u32 {
        locked(&self.end).stream.depth()
    }

    /// True if there is a record to read.
    #[getter]
    fn readable(&self) -> bool {
        self.depth() > 0
    }

    /// True if there is space for a record.
    #[getter]
    fn writable(&self) -> bool {
        self.depth() + 1 < self.maxdepth()
    }

    /// Number of records that found no space.
    #[getter]
    fn num_overruns(&self) -> u64 {
        locked(&self.end).overruns
    }

    /// Number of reads that found no record.
    #[getter]
    fn num_underruns(&self) -> u64 {
        locked(&self.end).underruns
    }

    /// Number of the record that was read last.
    #[getter]
    fn sampleno(&self) -> u64 {
        locked(&self.end).sample
    }

    fn __repr__(&self) -> String {
        format!("<stream 0x{:x}{}>", self.key, if self.creates { " creator" } else { "" })
    }
}
