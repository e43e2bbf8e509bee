//! Turns of transactions.

use super::MS;
use crate::mb::{
    config::{Function, TransactionConfig},
    schedule::Schedule,
};
use hal_modbus::ModbusTable;

/// Returns the turns of transactions of these devices, each due every 100 ms.
fn schedule(units: &[u8]) -> Schedule {
    let all: Vec<TransactionConfig> = units
        .iter()
        .map(|unit| TransactionConfig {
            name: String::new(),
            link: 0,
            unit: *unit,
            kind: Function::Read(ModbusTable::Holding),
            first: 0,
            pins: Vec::new(),
            period_ns: 100 * MS,
            timeout_ns: 500 * MS,
        })
        .collect();
    Schedule::new(all.iter(), false)
}

#[test]
fn a_refusal_delays_its_own_transaction_alone() {
    let mut schedule = schedule(&[1, 1]);
    assert_eq!(schedule.next(0), Some(0));
    schedule.refused(0, 0);
    assert_eq!(schedule.next(0), Some(1));
    schedule.answered(1, 0);
    assert!(!schedule.is_silent(1));
    for now in 1..10 {
        assert_eq!(schedule.next(now * 100 * MS), Some(1));
        schedule.answered(1, now * 100 * MS);
    }
    assert_eq!(schedule.next(1000 * MS), Some(0), "it is tried again");
}

#[test]
fn silence_delays_all_transactions_of_a_device_and_of_no_other() {
    let mut schedule = schedule(&[1, 1, 2]);
    schedule.silent(0, 0);
    assert_eq!((schedule.next(0), schedule.is_silent(1)), (Some(2), true));
    schedule.answered(2, 0);
    assert_eq!(schedule.next(50 * MS), None);
    assert_eq!(schedule.next(500 * MS), Some(1));
    schedule.answered(1, 500 * MS);
    assert!(!schedule.is_silent(1));
}
