//! Serial arms: closed forms (`arm.rs`), chains of Denavit-Hartenberg parameters (`dh.rs`) and a numeric search (`search.rs`).

pub(crate) mod arm;
pub(crate) mod armkins;
pub(crate) mod dh;
pub(crate) mod genserkins;
pub(crate) mod pumakins;
pub(crate) mod scarakins;
pub(crate) mod scorbotkins;
pub(crate) mod search;
pub(crate) mod three21kins;
