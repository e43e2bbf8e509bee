//! Names, types, directions and requests, compared with those of LinuxCNC's program.

use super::loaded;
use crate::mb::{config::MbConfig, pins::ValuePins};
use hal_bench::Bench;

/// A file with each function.
const EACH: &str = "
[MB2HAL_INIT]
VERSION=1.1
TOTAL_TRANSACTIONS=8
[TRANSACTION_00]
LINK_TYPE=tcp
TCP_IP=127.0.0.1
TCP_PORT=15502
MB_SLAVE_ID=1
MB_TX_CODE=fnct_01_read_coils
FIRST_ELEMENT=0
NELEMENTS=2
HAL_TX_NAME=coils
MAX_UPDATE_RATE=20
[TRANSACTION_01]
MB_TX_CODE=fnct_02_read_discrete_inputs
PIN_NAMES=a,b
FIRST_ELEMENT=3
[TRANSACTION_02]
MB_TX_CODE=fnct_03_read_holding_registers
NELEMENTS=2
HAL_TX_NAME=hold
FIRST_ELEMENT=0
[TRANSACTION_03]
MB_TX_CODE=fnct_04_read_input_registers
PIN_NAMES=x,y
HAL_TX_NAME=inp
FIRST_ELEMENT=0
[TRANSACTION_04]
MB_TX_CODE=fnct_05_write_single_coil
NELEMENTS=1
HAL_TX_NAME=wc
FIRST_ELEMENT=0
[TRANSACTION_05]
MB_TX_CODE=fnct_06_write_single_register
NELEMENTS=1
HAL_TX_NAME=wr
FIRST_ELEMENT=0
[TRANSACTION_06]
MB_TX_CODE=fnct_15_write_multiple_coils
NELEMENTS=2
HAL_TX_NAME=wcs
FIRST_ELEMENT=0
[TRANSACTION_07]
MB_TX_CODE=fnct_16_write_multiple_registers
NELEMENTS=2
HAL_TX_NAME=wrs
FIRST_ELEMENT=0
";

/// Pins that `halcmd show pin` lists for LinuxCNC 2.9's `mb2hal` with that file.
const PINS: &str = "
bit OUT 01.a.bit 01.a.bit-inv 01.b.bit 01.b.bit-inv coils.00.bit coils.00.bit-inv coils.01.bit coils.01.bit-inv
u32 OUT 01.num_errors coils.num_errors hold.num_errors inp.num_errors wc.num_errors wcs.num_errors wr.num_errors
u32 OUT wrs.num_errors
float OUT hold.00.float hold.01.float inp.x.float inp.y.float
s32 OUT hold.00.int hold.01.int inp.x.int inp.y.int
bit IN wc.00.bit wcs.00.bit wcs.01.bit
float IN wr.00.float wrs.00.float wrs.01.float
s32 IN wr.00.int wrs.00.int wrs.01.int
";

/// The same for version 1.0, in which functions 1 and 5 are 2 and 15.
const OLD_PINS: &str = "
bit OUT 01.a 01.b coils.00 coils.01
u32 OUT 01.num_errors coils.num_errors hold.num_errors inp.num_errors wc.num_errors wcs.num_errors wr.num_errors
u32 OUT wrs.num_errors
float OUT hold.00.float hold.01.float inp.x.float inp.y.float
s32 OUT hold.00.int hold.01.int inp.x.int inp.y.int
bit IN wc.00 wcs.00 wcs.01
float IN wr.00 wrs.00 wrs.01
";

/// The requests that LinuxCNC's program sends for that file, without the number of the transaction.
const REQUESTS: &[&str] = &[
    "00 00 00 06 01 01 00 00 00 02",
    "00 00 00 06 01 02 00 03 00 02",
    "00 00 00 06 01 03 00 00 00 02",
    "00 00 00 06 01 04 00 00 00 02",
    "00 00 00 06 01 05 00 00 00 00",
    "00 00 00 06 01 06 00 00 00 00",
    "00 00 00 08 01 0f 00 00 00 02 01 00",
    "00 00 00 0b 01 10 00 00 00 02 04 00 00 00 00",
];

/// Returns the text for version 1.0.
fn old() -> String {
    EACH.replace("VERSION=1.1\n", "")
        .replace("fnct_01_read_coils", "fnct_02_read_discrete_inputs")
        .replace("fnct_05_write_single_coil", "fnct_15_write_multiple_coils")
}

#[test]
fn all_names_of_linuxcnc_are_there() {
    for (text, pins, count) in [(EACH, PINS, 33), (&old(), OLD_PINS, 26)] {
        let names = loaded(text).names();
        let mut seen = 0;
        for line in pins.lines().filter(|line| !line.is_empty()) {
            let mut words = line.split(' ');
            let (ty, dir) = (words.next().unwrap(), words.next().unwrap());
            for pin in words {
                let wanted = format!("mb2hal.{pin} {ty} {dir}");
                assert!(names.contains(&wanted), "{wanted} is not among {names:#?}");
                seen += 1;
            }
        }
        assert_eq!(seen, count);
    }
}

/// Declares the pins of a file, to see its requests.
enum Requests {}

impl hal_component::Component for Requests {
    const NAME: &'static str = "requests";
    const DOC: &'static str = "Requests of a file.";
    const FLAGS: u32 = hal_component::abi::component_flags::ONCE;
    const ARGS: &'static [&'static hal_component::abi::ArgSpec] =
        &[&hal_component::Arg::text("ini", "File.")];

    fn create(b: &mut hal_component::Builder<'_>) -> Result<(), hal_component::Error> {
        let path = b.arg_text("ini").unwrap();
        let config = MbConfig::read(std::path::Path::new(&path)).unwrap();
        for (of, wanted) in config.transactions.iter().zip(REQUESTS) {
            let request = ValuePins::make(b, &config, of)?.request(of);
            let frame = request.tcp(1).unwrap();
            let text: Vec<String> =
                frame.iter().skip(2).map(|byte| format!("{byte:02x}")).collect();
            assert_eq!(&text.join(" "), wanted, "{}", of.name);
        }
        Ok(())
    }
}

#[test]
fn requests_are_those_of_linuxcnc() {
    let file = super::File::new(EACH);
    Bench::new().load::<Requests>(&[&file.arg()]).unwrap();
}

#[test]
fn another_module_name_is_before_all_pins() {
    let bench = loaded(&EACH.replace("VERSION", "HAL_MODULE_NAME=cabinet\nVERSION"));
    assert!(bench.names().iter().all(|name| name.starts_with("cabinet.")));
}
