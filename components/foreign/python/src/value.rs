//! Values between Python and HAL.

use hal_protocol::{Direction, Type, Value};
use pyo3::{
    IntoPyObjectExt,
    exceptions::{PyOverflowError, PyTypeError},
    prelude::*,
    types::{PyFloat, PyInt},
};

/// Returns the code of a direction, as programs write it.
pub(crate) const fn direction_code(direction: Direction) -> i64 {
    match direction {
        Direction::In => 16,
        Direction::Out => 32,
        Direction::Io => 48,
        Direction::Ro => 64,
        Direction::Rw => 192,
    }
}

/// Returns the direction with this code.
pub(crate) const fn direction(code: i64) -> Option<Direction> {
    Some(match code {
        16 => Direction::In,
        32 => Direction::Out,
        48 => Direction::Io,
        64 => Direction::Ro,
        192 => Direction::Rw,
        _ => return None,
    })
}

/// Returns the type with this code. Ports have no values.
pub(crate) fn type_of(code: i64) -> Option<Type> {
    let ty = u8::try_from(code).ok().and_then(Type::from_code);
    ty.filter(|ty| *ty != Type::Port)
}

/// Converts a cell's bits to an object.
#[inline]
pub(crate) fn object(py: Python<'_>, ty: Type, bits: u64) -> PyResult<Py<PyAny>> {
    match Value::from_bits(ty, bits) {
        Value::Bit(truth) => truth.into_py_any(py),
        Value::Float(number) => number.into_py_any(py),
        Value::S32(number) => number.into_py_any(py),
        Value::U32(number) => number.into_py_any(py),
        Value::S64(number) => number.into_py_any(py),
        Value::U64(number) | Value::Port(number) => number.into_py_any(py),
    }
}

/// Converts an object to a cell's bits: a truth value, a number, or a text that is one.
#[inline(always)]
pub(crate) fn bits(ty: Type, object: &Bound<'_, PyAny>) -> PyResult<u64> {
    Ok(match ty {
        Type::Bit => Value::Bit(object.is_truthy()?),
        Type::Float => Value::Float(match object.cast_exact::<PyFloat>() {
            Ok(number) => number.value(),
            Err(_) => float(object)?,
        }),
        Type::S32 => Value::S32(integer::<i64, i32>(object)?),
        Type::U32 => Value::U32(integer::<i64, u32>(object)?),
        Type::S64 => Value::S64(integer::<i64, i64>(object)?),
        Type::U64 | Type::Port => Value::U64(integer::<u64, u64>(object)?),
    }
    .bits())
}

/// Converts an object that is no `float` itself.
fn float(object: &Bound<'_, PyAny>) -> PyResult<f64> {
    if object.is_instance_of::<PyInt>() {
        return object.extract();
    }
    let number = object.py().get_type::<PyFloat>().call1((object,)).map_err(|_| {
        let name = object.get_type().name().map(|n| n.to_string()).unwrap_or_default();
        PyTypeError::new_err(format!("Number expected, not {name}"))
    })?;
    number.extract()
}

/// Converts as Python's `int` does, then to a number that `Wide` can hold, then to the type's own range.
fn integer<'py, Wide, T>(object: &Bound<'py, PyAny>) -> PyResult<T>
where
    Wide: for<'a> FromPyObject<'a, 'py, Error = PyErr> + core::fmt::Display + Copy,
    T: TryFrom<Wide>,
{
    let wide: Wide = if object.is_exact_instance_of::<PyInt>() {
        object.extract()
    } else {
        object.py().get_type::<PyInt>().call1((object,))?.extract()
    }
    .map_err(|e: PyErr| {
        let is_large = e.is_instance_of::<PyOverflowError>(object.py());
        if is_large { PyOverflowError::new_err("int too big to convert") } else { e }
    })?;
    T::try_from(wide).map_err(|_| PyOverflowError::new_err(format!("Value {wide} out of range")))
}
