//! Pins and parameters of this program's components.

use crate::{connection::Core, value};
use hal_protocol::{Direction, Type};
use pyo3::{exceptions::PyTypeError, prelude::*};
use std::sync::Arc;

/// A pin or parameter.
#[pyclass(name = "item", module = "hal", subclass, frozen)]
#[derive(Clone, Debug)]
pub(crate) struct Item {
    pub(crate) core: Arc<Core>,
    /// Index in the component's page.
    pub(crate) index: usize,
    pub(crate) ty: Type,
    pub(crate) direction: Direction,
    pub(crate) name: Arc<str>,
}

#[pymethods]
impl Item {
    /// Returns the value.
    #[inline]
    pub(crate) fn get(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        value::object(py, self.ty, self.core.get(self.index)?)
    }

    /// Sets the value.
    #[inline]
    #[pyo3(signature = (value, /))]
    pub(crate) fn set(&self, value: &Bound<'_, PyAny>) -> PyResult<()> {
        self.core.set(self.index, value::bits(self.ty, value)?)
    }

    /// Returns the name, without the component's prefix.
    fn get_name(&self) -> &str {
        &self.name
    }

    /// Returns the type, such as `HAL_FLOAT`.
    fn get_type(&self) -> u8 {
        self.ty.code()
    }

    /// Returns the direction, such as `HAL_IN`.
    fn get_dir(&self) -> i64 {
        value::direction_code(self.direction)
    }

    /// Returns whether this is a pin, not a parameter.
    fn is_pin(&self) -> bool {
        self.direction.is_pin()
    }

    fn __repr__(&self) -> String {
        let kind = if self.is_pin() { "pin" } else { "param" };
        let direction = match self.direction {
            Direction::In => "IN",
            Direction::Out => "OUT",
            Direction::Io => "IO",
            Direction::Ro => "RO",
            Direction::Rw => "RW",
        };
        format!("<hal {kind} \"{}\" {}-{direction}>", self.name, self.ty.name().to_uppercase())
    }
}

/// Pin of a component.
#[pyclass(name = "Pin", module = "hal", extends = Item, subclass, dict)]
#[derive(Debug)]
pub(crate) struct Pin;

/// Parameter of a component.
#[pyclass(name = "Param", module = "hal", extends = Item, subclass, dict)]
#[derive(Debug)]
pub(crate) struct Param;

/// Returns what a constructor makes of an item.
fn wrapped<T>(item: &Bound<'_, PyAny>, name: &str, this: T) -> PyResult<(T, Item)> {
    let item = item.cast::<Item>().map_err(|_| {
        PyTypeError::new_err(format!(
            "Constructor argument must be _hal.item: <class 'hal.{name}'>"
        ))
    })?;
    Ok((this, item.get().clone()))
}

macro_rules! properties {
    ($class:ident, $name:literal) => {
        #[pymethods]
        impl $class {
            #[new]
            fn new(item: &Bound<'_, PyAny>) -> PyResult<(Self, Item)> {
                wrapped(item, $name, Self)
            }

            /// Value.
            #[getter]
            fn value(this: PyRef<'_, Self>) -> PyResult<Py<PyAny>> {
                this.as_super().get(this.py())
            }

            #[setter]
            fn set_value(this: PyRef<'_, Self>, value: &Bound<'_, PyAny>) -> PyResult<()> {
                this.as_super().set(value)
            }

            /// Name, without the component's prefix.
            #[getter]
            fn name(this: PyRef<'_, Self>) -> String {
                this.as_super().name.as_ref().to_owned()
            }

            /// Type, such as `HAL_FLOAT`.
            #[getter]
            fn r#type(this: PyRef<'_, Self>) -> u8 {
                this.as_super().get_type()
            }

            /// Direction, such as `HAL_IN`.
            #[getter]
            fn dir(this: PyRef<'_, Self>) -> i64 {
                this.as_super().get_dir()
            }
        }
    };
}

properties!(Pin, "Pin");
properties!(Param, "Param");
