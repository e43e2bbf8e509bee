//! The component on the bench, where the workers run as the test says.

mod file;
mod line;
mod names;
mod schedule;

use super::Modbus;
use hal_bench::Bench;
use std::path::PathBuf;

const MS: i64 = 1_000_000;

/// File of `mb2hal` for one test.
struct File(PathBuf);

impl File {
    fn new(text: &str) -> Self {
        static NEXT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let n = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("ferrule-mb-{}-{n}.ini", std::process::id()));
        std::fs::write(&path, text).unwrap();
        Self(path)
    }

    fn arg(&self) -> String {
        format!("ini={}", self.0.display())
    }
}

impl Drop for File {
    fn drop(&mut self) {
        std::fs::remove_file(&self.0).unwrap();
    }
}

/// Returns the component with a file of this text.
fn loaded(text: &str) -> Bench {
    let file = File::new(text);
    let mut bench = Bench::new();
    bench.load::<Modbus>(&[&file.arg()]).unwrap();
    bench
}

/// Lets milliseconds pass on the first line.
fn pass(bench: &Bench, ms: u32) {
    for _ in 0..ms {
        bench.pass(MS);
        bench.work("mb2hal.line.0", 1).unwrap();
    }
}

/// Three devices on one line: 20, 10 and 5 requests per second.
const THREE: &str = "
[MB2HAL_INIT]
VERSION=1.1
TOTAL_TRANSACTIONS=3
[TRANSACTION_00]
LINK_TYPE=serial
SERIAL_PORT=/dev/ttyUSB0
SERIAL_BAUD=19200
SERIAL_BITS=8
SERIAL_PARITY=none
SERIAL_STOP=1
MB_SLAVE_ID=1
MB_TX_CODE=fnct_03_read_holding_registers
FIRST_ELEMENT=0
NELEMENTS=4
HAL_TX_NAME=fast
MAX_UPDATE_RATE=20
[TRANSACTION_01]
MB_SLAVE_ID=2
MB_TX_CODE=fnct_02_read_discrete_inputs
FIRST_ELEMENT=100
NELEMENTS=8
HAL_TX_NAME=middle
MAX_UPDATE_RATE=10
[TRANSACTION_02]
MB_SLAVE_ID=3
MB_TX_CODE=fnct_16_write_multiple_registers
FIRST_ELEMENT=7
PIN_NAMES=speed,torque
HAL_TX_NAME=slow
MAX_UPDATE_RATE=5
";
