//! Storage of jobs for a controller that only takes a USB medium, without HAL: two images, of which the controller sees one
//! while the other is written.
//!
//! | module | subject |
//! |---|---|
//! | `storage` | the states, from a waiting job to the image that has it |
//! | [`plan`], `prepare` | the contents of the next image, and its making |
//! | `image` | FAT32 images: made, listed, read, written, compared |
//! | [`bay`], [`folder`] | the place of images, state and waiting jobs; such a place in a folder |
//! | `gadget` | the USB device that presents an image; configfs |
//! | `ledger` | the file that says which image is presented, and the ages of its jobs |
//! | `name` | names of jobs that every medium can hold |
//! | `error` | every error |
#![forbid(unsafe_code)]

pub mod bay;
pub mod error;
pub mod folder;
pub mod gadget;
pub mod image;
pub mod ledger;
pub mod name;
pub mod plan;
mod prepare;
pub mod storage;

pub use bay::{Bay, Side};
pub use error::StorageError;
pub use folder::Folder;
pub use gadget::{Configfs, Gadget, NotEjected};
pub use name::safe_name;
pub use storage::{Phase, Rules, Storage, StorageEvent};
