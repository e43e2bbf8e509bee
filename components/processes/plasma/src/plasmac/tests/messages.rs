//! Messages for the operator.

use super::{Table, cutting};

/// Returns a machine that begins a cut with these settings.
fn begun(settings: &[(&str, f64)]) -> Table {
    let table = Table::new(settings);
    table.run(2);
    table.put("cutting-start", true);
    table
}

/// Returns the messages of this number of cycles; a lasting condition is reported once.
fn said(table: &Table, cycles: u32) -> Vec<String> {
    table.run(cycles);
    table.bench.said()
}

#[test]
fn a_cut_that_goes_well_says_nothing() {
    let table = cutting(&[]);
    table.run(100);
    table.put("cutting-start", false);
    table.until(0);
    assert_eq!(said(&table, 10), [""; 0]);
}

#[test]
fn each_fault_is_told_once() {
    let mut table = begun(&[]);
    table.arc = false;
    assert_eq!(said(&table, 2000), ["plasmac: no arc after 3 starts"]);

    let mut table = cutting(&[("arc-lost-delay", 0.02)]);
    table.arc = false;
    assert_eq!(said(&table, 100), ["plasmac: the arc is lost"]);

    let table = cutting(&[]);
    table.put("breakaway", true);
    assert_eq!(said(&table, 500), ["plasmac: a sensor is active"]);

    let table = begun(&[("axis-z-min-limit", 5.0), ("probe-start-height", 5.0)]);
    let lowest = "plasmac: Z is at its lowest, and no surface was found";
    assert_eq!(said(&table, 300), [lowest]);

    let table = begun(&[("cut-volts", 0.0)]);
    let heights = "plasmac: pierce-height 3, cut-height 1.5 and cut-volts 0 must be above 0";
    assert_eq!(said(&table, 300), [heights]);

    let table = begun(&[("axis-z-max-limit", 3.0)]);
    let high = "plasmac: the surface is too high to pierce below the highest Z";
    assert_eq!(said(&table, 300), [high]);

    let table = cutting(&[("axis-z-max-limit", 12.0)]);
    let ends = table.bench.said();
    assert!(ends.len() == 1 && ends[0].starts_with("plasmac: the safe height is 6."), "{ends:?}");
    assert!(ends[0].ends_with(", not 10: Z ends there"), "{ends:?}");

    let table = Table::new(&[("offset-probe-x", -30.0), ("axis-x-min-limit", -29.0)]);
    table.put("ohmic-probe-enable", true);
    table.run(2);
    table.put("cutting-start", true);
    let beyond = "plasmac: the offset probe would be at X -30 and Y 0, beyond a limit";
    assert_eq!(said(&table, 100), [beyond]);

    let mut table = Table::new(&[("offset-probe-x", -30.0), ("axis-x-min-limit", -30.0)]);
    table.put("ohmic-probe-enable", true);
    table.run(2);
    table.put("cutting-start", true);
    table.run(4);
    table.tip = 100.0;
    let early = "plasmac: contact before the offset probe is out: probe-start-height 15 is too low";
    assert_eq!(said(&table, 1), [early]);

    let table = Table::new(&[]);
    table.run(2);
    table.put("breakaway", true);
    assert_eq!(said(&table, 100), ["plasmac: a sensor is active before a cut"]);

    let mut table = cutting(&[]);
    table.bench.set("plasmac.low-cut-volts", 50);
    table.run(200);
    table.volts = 40.0;
    assert_eq!(said(&table, 100), ["plasmac: 40 V are below low-cut-volts, 50"]);
}
