//! Commands: declared and read on the control side (`interface.rs`, `path_rows.rs`, `configure.rs` with `arguments.rs`,
//! `config.rs`, `numbers.rs` and `comp_file.rs`, `status.rs`; `service.rs` for other plugins, with `call.rs` for arguments of both
//! kinds), passed as data (`command.rs`), and executed on the realtime side (`execute.rs`, `outputs.rs`) or refused with a reason
//! (`refusal.rs`).

pub(crate) mod arguments;
pub(crate) mod call;
pub(crate) mod command;
pub(crate) mod comp_file;
pub(crate) mod config;
pub(crate) mod configure;
pub(crate) mod execute;
pub(crate) mod interface;
pub(crate) mod numbers;
pub(crate) mod outputs;
pub(crate) mod path_rows;
pub(crate) mod refusal;
pub(crate) mod service;
pub(crate) mod status;
