//! Devices on Modbus lines, and inverters on serial lines.
//!
//! | module | subject |
//! |---|---|
//! | `line` | lines: serial, TCP, simulated |
//! | `station` | one request at a time on a line |
//! | `sync` | the atomics |
//! | `hy` | the component `hy_vfd`: Huanyang's inverters |
//! | `mb` | the component `modbus`: devices by the files of LinuxCNC's `mb2hal` |
//!
//! A component has a function in a thread, which reads and writes pins, and a worker, which speaks on the line and never waits:
//! each of its steps sends what is due and takes what has come. Both exchange records without locks.
#![forbid(unsafe_code)]

mod hy;
mod line;
mod mb;
mod station;
mod sync;

hal_component::export!(hy::HyVfd, mb::Modbus);
