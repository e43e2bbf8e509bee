//! The height of the torch while it cuts.

use super::{Table, cutting};

#[test]
fn the_height_follows_the_voltage() {
    let mut table = cutting(&[]);
    table.run(40);
    let before = table.count("z-offset-counts");
    table.volts = 103.0;
    table.run(10);
    assert!(table.is("led-down"));
    assert_eq!(table.count("z-offset-counts") - before, -3000);
    table.volts = 100.5;
    table.run(10);
    assert!(!table.is("led-down"));
    assert_eq!(table.count("z-offset-counts") - before, -3000);
    // Limited by the speed: 1000 units per minute are 1666 counts per cycle.
    table.volts = 60.0;
    table.run(1);
    assert_eq!(table.count("z-offset-counts") - before, -3000 + 1666);
}

#[test]
fn z_moves_for_a_changed_override() {
    let table = cutting(&[("height-per-volt", 0.1)]);
    table.run(40);
    let before = table.count("z-offset-counts");
    table.bench.set("plasmac.height-override", 0.9);
    table.run(1);
    assert_eq!(table.count("z-offset-counts"), before);
    table.run(1);
    assert_eq!(table.count("z-offset-counts"), before + 9000);
    table.bench.set("plasmac.setup-feed-rate", 1200.0);
    table.bench.set("plasmac.height-override", 0.4);
    table.run(2);
    assert_eq!(table.count("z-offset-counts"), before + 9000 - 1999);
    table.run(3);
    assert_eq!(table.count("z-offset-counts"), before + 4000);
}

#[test]
fn a_target_is_the_mean_of_a_voltage_that_is_steady() {
    let mut table = Table::new(&[("thc-delay", 1.0), ("thc-sample-threshold", 0.5)]);
    table.put("thc-auto", true);
    table.put("use-auto-volts", true);
    table.bench.set("plasmac.thc-sample-counts", 4);
    table.velocity = 40.0;
    table.run(2);
    table.put("cutting-start", true);
    table.until(11);
    table.run(5);
    // Too slow: no target, although the voltage is steady.
    assert_eq!(table.float("target-volts"), 0.0);
    table.velocity = 50.0;
    for volts in [90.0, 91.0, 92.0] {
        table.volts = volts;
        table.run(1);
        assert_eq!(table.float("target-volts"), 0.0);
    }
    table.volts = 91.75;
    table.run(2);
    assert_eq!(table.float("target-volts"), 0.0);
    table.run(1);
    assert_eq!(table.float("target-volts"), (92.0 + 3.0 * 91.75) / 4.0);
}
