//! The Python module `_hal`, on which the module `hal` stands: programs in Python with pins.
//!
//! In LinuxCNC, a program and the machine share memory. Here, the values of a component's pins lie in a page that the
//! program shares with the engine (`PinPage` of `hal-protocol`), so that reading and writing a pin costs no request.
#![forbid(unsafe_code)]

mod component;
mod connection;
mod drawing;
mod gcode;
mod instance;
mod item;
mod machine;
mod sleep;
mod stream;
mod value;

use pyo3::prelude::*;

pyo3::create_exception!(hal, error, pyo3::exceptions::PyException, "A refusal of HAL.");

/// Numbers that programs use by name.
const NUMBERS: &[(&str, i64)] = &[
    ("HAL_BIT", 1),
    ("HAL_FLOAT", 2),
    ("HAL_S32", 3),
    ("HAL_U32", 4),
    ("HAL_S64", 6),
    ("HAL_U64", 7),
    ("HAL_IN", 16),
    ("HAL_OUT", 32),
    ("HAL_IO", 48),
    ("HAL_RO", 64),
    ("HAL_RW", 192),
    ("MSG_NONE", 0),
    ("MSG_ERR", 1),
    ("MSG_WARN", 2),
    ("MSG_INFO", 3),
    ("MSG_DBG", 4),
    ("MSG_ALL", 5),
    ("is_kernelspace", 0),
    ("is_userspace", 1),
    ("is_rt", 0),
    ("is_sim", 1),
    ("sampler_base", stream::SAMPLER_BASE),
    ("streamer_base", stream::STREAMER_BASE),
];

/// HAL of a Ferrule instance.
#[pymodule]
fn _hal(module: &Bound<'_, PyModule>) -> PyResult<()> {
    for (name, number) in NUMBERS {
        module.add(*name, *number)?;
    }
    module.add("kernel_version", "Not Available")?;
    module.add("error", module.py().get_type::<error>())?;
    module.add_class::<component::Join>()?;
    module.add_class::<item::Item>()?;
    module.add_class::<item::Pin>()?;
    module.add_class::<item::Param>()?;
    module.add_class::<stream::Stream>()?;
    instance::add(module)?;
    module.add_function(wrap_pyfunction!(sleep::sleep, module)?)
}
