//! Files and arguments that are wrong.

use super::{File, Modbus, THREE};
use hal_bench::Bench;

/// Text of the file that is replaced, by what, and what is said behind the name of the file.
const WRONG: &[(&str, &str, &str)] = &[
    (
        "TOTAL_TRANSACTIONS=3",
        "",
        ": [MB2HAL_INIT]TOTAL_TRANSACTIONS is missing: the number of sections",
    ),
    (
        "TOTAL_TRANSACTIONS=3",
        "TOTAL_TRANSACTIONS=0",
        ":4: [MB2HAL_INIT]TOTAL_TRANSACTIONS=0: a whole number from 1 to 500 is needed",
    ),
    (
        "TOTAL_TRANSACTIONS=3",
        "TOTAL_TRANSACTIONS=4",
        ": [TRANSACTION_03]MB_TX_CODE is missing: the function",
    ),
    (
        "LINK_TYPE=serial",
        "LINK_TYPE=usb",
        ":6: [TRANSACTION_00]LINK_TYPE=usb: one of serial, tcp is needed",
    ),
    ("SERIAL_PORT=/dev/ttyUSB0", "", ": [TRANSACTION_00]SERIAL_PORT is missing: the device file"),
    (
        "SERIAL_BAUD=19200",
        "SERIAL_BAUD=19201",
        ":8: [TRANSACTION_00]SERIAL_BAUD=19201: a serial line has one of 110, 300",
    ),
    (
        "SERIAL_PARITY=none",
        "SERIAL_PARITY=no",
        ":10: [TRANSACTION_00]SERIAL_PARITY=no: one of none, even, odd",
    ),
    (
        "MB_SLAVE_ID=2",
        "MB_SLAVE_ID=248",
        ":19: [TRANSACTION_01]MB_SLAVE_ID=248: a whole number from 1 to 247",
    ),
    (
        "fnct_02_read_discrete_inputs",
        "fnct_07_read",
        ":20: [TRANSACTION_01]MB_TX_CODE=fnct_07_read: one of fnct_01_read_coils, fnct_02_read_discrete_inputs",
    ),
    ("FIRST_ELEMENT=100", "", ": [TRANSACTION_01]FIRST_ELEMENT is missing: the address"),
    (
        "FIRST_ELEMENT=100",
        "FIRST_ELEMENT=65530",
        ":21: [TRANSACTION_01]FIRST_ELEMENT=65530: the last element is beyond address 65535",
    ),
    (
        "NELEMENTS=8",
        "",
        ": [TRANSACTION_01]NELEMENTS is missing: the number of elements, or PIN_NAMES=",
    ),
    (
        "NELEMENTS=4",
        "NELEMENTS=126",
        ":15: [TRANSACTION_00]NELEMENTS=126: this function takes at most 125 in one request",
    ),
    (
        "PIN_NAMES=speed,torque",
        "PIN_NAMES=speed,,x",
        ":29: [TRANSACTION_02]PIN_NAMES=speed,,x: names with commas",
    ),
    (
        "MAX_UPDATE_RATE=10",
        "MAX_UPDATE_RATE=x",
        ":24: [TRANSACTION_01]MAX_UPDATE_RATE=x: a number from 0 to 1000",
    ),
    (
        "HAL_TX_NAME=slow",
        "HAL_TX_NAME=fast",
        ":30: [TRANSACTION_02]HAL_TX_NAME=fast: another transaction has this name",
    ),
    (
        "MB_SLAVE_ID=3",
        "MB_SLAVE_ID=3\nSERIAL_BAUD=9600",
        ":27: [TRANSACTION_02]SERIAL_BAUD=9600: another transaction states other settings for the same line",
    ),
    ("VERSION=1.1", "VERSION=1.0", ""),
];

#[test]
fn mistakes_are_named_with_file_line_and_remedy() {
    for (right, wrong, words) in WRONG {
        assert!(THREE.contains(right), "{right}");
        let file = File::new(&THREE.replace(right, wrong));
        let done = Bench::new().load::<Modbus>(&[&file.arg()]);
        if words.is_empty() {
            done.unwrap();
            continue;
        }
        let refused = done.unwrap_err();
        let wanted = format!("{}{words}", file.0.display());
        assert!(refused.contains(&wanted), "{refused}\nand not {wanted}");
    }
    let file = File::new(
        &THREE
            .replace("VERSION=1.1", "")
            .replace("fnct_02_read_discrete_inputs", "fnct_01_read_coils"),
    );
    let refused = Bench::new().load::<Modbus>(&[&file.arg()]).unwrap_err();
    assert!(refused.contains("this function needs VERSION=1.1 in [MB2HAL_INIT]"), "{refused}");
}

#[test]
fn arguments_that_are_wrong_are_refused_in_words() {
    for (args, words) in [
        (&["ini=x.ini", "transactions=a:03:0:1"][..], "ini= and transactions=: only one of them"),
        (&["device=%"], "device=%: must be a path such as /dev/ttyUSB0"),
        (&["ini=nowhere.ini"], "nowhere.ini"),
        (&["transactions=a:07:0:1"], "transactions=a:07:0:1: NAME:FUNCTION:FIRST:COUNT is needed"),
        (&["transactions=a:03:0:126"], "transactions=a:03:0:126: NAME"),
        (&["transactions=a:05:0:2"], "transactions=a:05:0:2: NAME"),
        (&["transactions=a:03:65535:2"], "transactions=a:03:65535:2: NAME"),
        (&["transactions=a:03:0:1,a:03:1:1"], "transactions=a:03:1:1: NAME"),
        (&["transactions=a:03:0:1", "rate=1"], "rate=1: a serial line has one of"),
        (&["transactions=a:03:0:1", "parity=x"], "parity=x: must be none, even or odd"),
    ] {
        let refused = Bench::new().load::<Modbus>(args).unwrap_err();
        assert!(refused.contains(words), "{args:?}: {refused}");
    }
}

#[test]
fn files_of_any_text_are_refused_or_read_without_a_panic() {
    let mut random = hal_bench::Random::new(1);
    let words = [
        "=",
        "\n",
        "[TRANSACTION_00]",
        "65536",
        "-1",
        "nan",
        ",",
        "fnct_16_write_multiple_registers",
        "x",
    ];
    for _ in 0..2000 {
        let mut text = THREE.to_owned();
        for _ in 0..=random.below(3) {
            let mut at = random.index(text.len());
            while !text.is_char_boundary(at) {
                at -= 1;
            }
            text.insert_str(at, random.one(&words));
        }
        let file = File::new(&text);
        drop(crate::mb::config::MbConfig::read(&file.0));
    }
}
