//! Load in progress: the engine's functions, and the module that is being set up.

use crate::{
    module::Module,
    second_copy::{Made, SecondCopy},
};
use core::cell::{Cell, RefCell};
use hal_component::abi::{ForeignFile, Host, Status};
use std::sync::Arc;

/// Error number and text of a refusal. Without a text, the engine has one.
pub(crate) type Refusal = (Status, String);

/// Load in progress.
#[derive(Debug)]
pub(crate) struct Loading {
    pub(crate) host: Host,
    pub(crate) file: ForeignFile,
    pub(crate) module: Arc<Module>,
    /// Addresses of the component's pointers to port pins.
    pub(crate) ports: RefCell<Vec<usize>>,
    /// Pins and parameters that the component has requested.
    pub(crate) items: RefCell<Vec<Made>>,
    /// Texts of the refused calls of the component.
    pub(crate) refusals: RefCell<Vec<String>>,
    /// Functions that reach outside, which the component has called and which were refused.
    pub(crate) tried: RefCell<Vec<String>>,
    /// Results of the first copy's setup, while a second copy is set up; otherwise empty.
    pub(crate) second_copy: SecondCopy,
}

impl Loading {
    pub(crate) fn new(host: Host, file: ForeignFile, module: Arc<Module>) -> Self {
        Self {
            host,
            file,
            module,
            ports: RefCell::default(),
            items: RefCell::default(),
            refusals: RefCell::default(),
            tried: RefCell::default(),
            second_copy: SecondCopy::default(),
        }
    }
}

thread_local! {
    static LOADING: Cell<*const Loading> = const { Cell::new(core::ptr::null()) };
}

/// Returns the load in progress on this thread; only during a load can items be made.
pub(crate) fn loading<'l>() -> Option<&'l Loading> {
    // SAFETY: `within` sets the pointer on this thread, and only while it borrows the load.
    unsafe { LOADING.get().as_ref() }
}

/// Runs the setup of a load, during which [`loading`] returns it.
pub(crate) fn within<T>(load: &Loading, setup: impl FnOnce() -> T) -> T {
    /// Ends the load, also when its setup panics.
    struct End;

    impl Drop for End {
        fn drop(&mut self) {
            LOADING.set(core::ptr::null());
        }
    }

    LOADING.set(&raw const *load);
    let _end = End;
    setup()
}
