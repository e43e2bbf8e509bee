//! Limits of the surface height, and of the probing position.

use super::Table;

#[test]
fn nothing_is_lower_than_the_lowest_z() {
    let table = Table::new(&[("axis-z-min-limit", 5.0), ("probe-start-height", 5.0)]);
    table.run(2);
    table.put("cutting-start", true);
    table.until(15);
    assert!(table.is("program-pause"));
    assert!(20.0 + table.float("z-offset-current") >= 5.25);
}

#[test]
fn a_surface_that_leaves_no_room_is_a_fault() {
    // The surface is at 0.5, and Z may rise to the limit less 5 mm.
    let rooms = |limit: f64, safe: f64| {
        let table = Table::new(&[("axis-z-max-limit", limit), ("safe-height", safe)]);
        table.bench.set("plasmac.max-offset", 5);
        table.run(2);
        table.put("cutting-start", true);
        table.states(500)
    };
    // Less than 4 above the contact, at -0.2 and less; then less than 4 above the surface.
    assert!(rooms(8.5, 10.0).starts_with(&[0, 1, 2, 15, 16, 0]));
    assert!(rooms(9.3, 10.0).starts_with(&[0, 1, 2, 3, 15, 16, 0]));
    assert!(rooms(9.3, 0.0).starts_with(&[0, 1, 2, 3, 4, 5, 6, 7, 8]));
    assert!(rooms(9.7, 10.0).starts_with(&[0, 1, 2, 3, 4, 5, 6, 7, 8]));
}

#[test]
fn an_offset_probe_goes_out_and_back() {
    let table = Table::new(&[
        ("offset-probe-x", 5.0),
        ("offset-probe-y", 3.0),
        ("offset-probe-delay", 0.05),
        ("axis-x-max-limit", 5.0),
        ("axis-y-max-limit", 3.0),
    ]);
    let xy = || (table.count("x-offset-counts"), table.count("y-offset-counts"));
    table.put("ohmic-probe-enable", true);
    table.run(2);
    table.put("cutting-start", true);
    table.run(2);
    assert!(table.is("xy-offset-enable"));
    assert_eq!((xy(), table.count("z-offset-counts")), ((85_748, 51_449), -99_999));
    table.until(2);
    let high = table.count("z-offset-counts");
    assert_eq!(xy(), (499_999, 300_000));
    table.run(30);
    assert_eq!(table.count("z-offset-counts"), high);
    table.until(5);
    table.run(1);
    assert_eq!(xy(), (414_251, 248_551));
    let low = table.count("z-offset-counts");
    table.run(49);
    assert_eq!((xy(), table.count("z-offset-counts")), ((0, 0), low));
    table.run(1);
    assert_eq!(table.count("z-offset-counts"), low + 99_999);
    table.until(11);
}

#[test]
fn an_offset_probe_that_cannot_go_out_is_a_fault() {
    let begin = |limit: f64| {
        let table = Table::new(&[("offset-probe-x", -30.0), ("axis-x-min-limit", limit)]);
        table.put("ohmic-probe-enable", true);
        table.run(2);
        table.put("cutting-start", true);
        table.run(1);
        table
    };
    // Beyond a limit, the cut does not begin.
    let table = begin(-29.0);
    assert_eq!((table.state(), table.count("stop-type-out")), (0, 3));
    assert!(table.is("program-pause") && table.is("feed-hold"));
    assert_eq!(table.states(20), [0]);
    // Contact while extending: Z retracts, X moves back, and no cut follows.
    let mut table = begin(-30.0);
    table.run(3);
    table.tip = 100.0;
    table.run(1);
    assert_eq!((table.state(), table.count("stop-type-out")), (15, 3));
    assert!(table.is("program-pause") && table.count("x-offset-counts") < -300_000);
    table.tip = f64::NEG_INFINITY;
    table.until(16);
    assert_eq!((table.count("x-offset-counts"), table.count("z-offset-counts")), (0, 0));
}
