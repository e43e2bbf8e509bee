//! Ohmic probing, probe tests, and jobs while a program is paused.

use super::{Table, cutting};

/// Returns a machine that probes by its tip.
fn ohmic(attempts: i32) -> Table {
    let table = Table::new(&[("ohmic-probe-offset", 0.3)]);
    table.bench.set("plasmac.ohmic-max-attempts", attempts);
    table.put("ohmic-probe-enable", true);
    table.run(2);
    table
}

/// Starts a cut and pauses its program; X and Y offsets are then requested.
fn paused(x: i32, y: i32) -> Table {
    let table = cutting(&[]);
    table.bench.set("plasmac.x-offset", x);
    table.bench.set("plasmac.y-offset", y);
    table.bench.set("plasmac.laser-x-offset", 3000);
    table.bench.set("plasmac.laser-y-offset", 4000);
    table.run(200);
    table.put("program-is-running", false);
    table.put("program-is-paused", true);
    table.run(300);
    table
}

impl Table {
    fn xy(&self) -> (i32, i32) {
        (self.count("x-offset-counts"), self.count("y-offset-counts"))
    }

    fn resumes(&self) {
        self.put("program-is-paused", false);
        self.put("program-is-running", true);
    }

    fn aborts(&self) {
        self.put("program-is-paused", false);
        self.put("program-is-idle", true);
    }
}

#[test]
fn the_tip_finds_the_surface() {
    let mut table = ohmic(2);
    table.tip = 0.0;
    table.switch = -0.5;
    table.put("cutting-start", true);
    assert_eq!(table.states(65), [0, 1, 2, 3]);
    // Z stops in the cycle of the contact; the pin that reports it is one cycle late.
    assert_eq!(table.count("z-offset-counts"), -2_019_948);
    assert!(table.is("ohmic-enable") && !table.is("sensor-active"));
    table.run(1);
    assert!(table.is("sensor-active"));
    table.until(5);
    assert!(!table.is("ohmic-enable"));
    // The contact ended at -1999948: the offset of the tip is added, not that of the switch.
    assert_eq!(table.count("z-offset-counts"), -1_969_949);
    table.until(11);
    assert_eq!(table.count("z-offset-counts"), -1_819_949);
}

#[test]
fn a_switch_that_is_first_counts_after_the_attempts() {
    let table = ohmic(2);
    table.put("cutting-start", true);
    assert_eq!(table.states(395), [0, 1, 2, 1, 2, 1, 2, 3]);
    assert!(table.is("ohmic-enable"));
    table.run(1);
    assert_eq!((table.state(), table.is("ohmic-enable")), (4, false));
    table.until(5);
    assert_eq!(table.count("z-offset-counts"), -1_949_949);
    // Each probing restarts the attempts, and takes 65 cycles.
    table.until(11);
    table.put("cutting-start", false);
    table.until(0);
    table.put("cutting-start", true);
    table.until(2);
    assert_eq!(table.until(1), 52);
    assert_eq!(table.until(2), 13);
}

#[test]
fn a_tip_that_touches_in_a_cut_ends_it_at_once() {
    let mut table = ohmic(2);
    table.put("cutting-start", true);
    table.until(11);
    table.tip = 100.0;
    table.run(1);
    assert_eq!((table.state(), table.count("stop-type-out")), (15, 3));
    assert!(table.is("program-pause") && !table.is("torch-on") && !table.is("sensor-active"));
}

#[test]
fn a_probe_test_stays_at_the_height_of_piercing() {
    let table = Table::new(&[]);
    table.run(2);
    table.put("probe-test", true);
    assert_eq!(table.states(500), [0, 1, 2, 3, 4, 5, 21]);
    assert_eq!(table.count("z-offset-counts"), -1_649_949);
    assert!(!table.is("probe-test-error") && !table.is("torch-on"));
    table.put("probe-test", false);
    table.run(1);
    assert_eq!(table.count("z-offset-counts"), -1_549_950);
    assert_eq!(table.states(20), [21, 16, 0]);
    assert!(table.count("z-offset-counts") == 0 && !table.is("feed-hold"));
}

#[test]
fn a_probe_test_without_a_surface_is_an_error() {
    let mut table = Table::new(&[]);
    table.switch = -1000.0;
    table.run(2);
    table.put("probe-test", true);
    assert_eq!(table.states(500), [0, 1, 2, 21]);
    assert_eq!(table.count("z-offset-counts"), -2_459_926);
    assert!(table.is("probe-test-error") && !table.is("program-pause"));
    table.put("probe-test", false);
    table.until(16);
    assert!(table.is("probe-test-error"));
    table.run(1);
    assert_eq!((table.state(), table.is("probe-test-error")), (0, false));
}

#[test]
fn a_probe_test_begins_with_nothing_that_touches() {
    let mut table = ohmic(2);
    table.tip = 100.0;
    table.put("probe-test", true);
    assert_eq!(table.states(20), [0, 21]);
    assert!(table.is("probe-test-error") && !table.is("ohmic-enable"));
    table.tip = -1000.0;
    table.run(3);
    table.put("probe-test", false);
    assert_eq!(table.states(3), [21, 16, 0]);

    let mut table = Table::new(&[]);
    table.switch = 100.0;
    table.run(2);
    table.put("probe-test", true);
    // With the float switch it is a fault, until the test ends.
    table.run(1);
    assert!(table.is("program-pause") && table.count("stop-type-out") == 3);
    assert_eq!(table.states(20), [15]);
    table.switch = 0.0;
    table.run(3);
    table.put("probe-test", false);
    assert_eq!(table.states(3), [15, 16, 0]);
}

#[test]
fn a_sensor_stops_the_way_to_the_consumables() {
    let table = paused(20_000, -10_000);
    table.put("consumable-change", true);
    assert_eq!(table.states(3), [0, 15, 23]);
    table.run(7);
    assert_eq!(table.xy(), (6258, -3129));
    table.put("breakaway", true);
    table.run(5);
    assert_eq!(table.xy(), (6258, -3129));
    table.put("breakaway", false);
    table.run(1);
    assert_eq!(table.xy(), (7152, -3576));
    // The request is withdrawn: one cycle in state 0, then back.
    table.put("consumable-change", false);
    table.run(1);
    assert_eq!((table.state(), table.xy()), (0, (7152, -3576)));
    assert_eq!(table.states(2), [0, 24]);
    assert_eq!(table.xy(), (6258, -3129));
    table.until(0);
    assert!(table.xy() == (0, 0) && !table.is("consumable-changing") && !table.is("feed-hold"));
}

#[test]
fn consumables_go_back_before_a_program_runs_on() {
    let table = paused(20_000, -10_000);
    table.put("consumable-change", true);
    table.run(50);
    assert_eq!((table.state(), table.xy()), (0, (20_000, -10_000)));
    table.resumes();
    table.run(1);
    assert_eq!((table.state(), table.count("stop-type-out")), (24, 0));
    assert_eq!(table.xy(), (20_000, -10_000));
    assert_eq!(table.until(0), 24);
    assert!(table.xy() == (0, 0) && !table.is("consumable-changing"));
    assert_eq!(table.states(1), [0, 1]);
}

#[test]
fn consumables_go_back_as_a_program_is_aborted() {
    let table = paused(2000, -1000);
    table.put("consumable-change", true);
    table.run(20);
    table.put("cutting-start", false);
    table.put("consumable-change", false);
    table.aborts();
    table.run(1);
    assert_eq!((table.state(), table.xy()), (24, (1106, -553)));
    assert_eq!(table.states(7), [24, 0, 16, 17, 0]);
    assert!(table.xy() == (0, 0) && !table.is("consumable-changing") && !table.is("feed-hold"));
}

#[test]
fn a_recovery_that_is_given_up_goes_back() {
    let table = paused(20_000, -10_000);
    table.put("cut-recovery", true);
    table.run(2);
    assert_eq!((table.state(), table.xy()), (25, (2500, -2500)));
    assert!(table.is("cut-recovering") && table.is("xy-offset-enable"));
    table.run(4);
    assert_eq!(table.xy(), (12_500, -10_000));
    table.run(20);
    assert_eq!((table.state(), table.xy()), (25, (20_000, -10_000)));
    table.put("cut-recovery", false);
    table.run(2);
    assert_eq!((table.state(), table.xy()), (26, (17_764, -8882)));
    assert_eq!(table.until(0), 9);
    assert!(table.xy() == (0, 0) && !table.is("cut-recovering") && table.is("feed-hold"));
}

#[test]
fn a_recovered_cut_goes_back_to_its_path() {
    let table = paused(20_000, -10_000);
    table.put("cut-recovery", true);
    table.run(30);
    table.resumes();
    assert_eq!(table.states(291), [25, 0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 26]);
    assert_eq!(table.xy(), (20_000, -10_000));
    table.run(1);
    assert_eq!(table.xy(), (15_528, -7764));
    assert_eq!(table.until(11), 5);
    assert!(table.xy() == (0, 0) && !table.is("cut-recovering") && !table.is("feed-hold"));
}

#[test]
fn a_recovery_ends_with_its_program() {
    let table = paused(20_000, -10_000);
    table.put("cut-recovery", true);
    table.run(30);
    table.aborts();
    table.run(1);
    assert_eq!((table.state(), table.xy()), (26, (17_764, -8882)));
    assert_eq!(table.states(12), [26, 11, 16, 17, 0]);
    assert!(table.xy() == (0, 0) && !table.is("cut-recovering"));
}

#[test]
fn the_laser_is_laid_where_the_cut_goes_on() {
    let table = paused(20_000, -10_000);
    table.bench.set("plasmac.laser-recovery-start", 1);
    table.put("cut-recovery", true);
    table.run(4);
    assert_eq!((table.count("laser-recovery-state"), table.xy()), (2, (2999, 3999)));
    table.run(1);
    assert_eq!(table.xy(), (3000, 4000));
    table.run(1);
    assert_eq!((table.count("laser-recovery-state"), table.xy()), (3, (3000, 4000)));
    table.run(2);
    assert_eq!(table.xy(), (8000, -1000));
    table.run(40);
    assert_eq!(table.xy(), (23_000, -6000));
    table.put("cut-recovery", false);
    table.run(2);
    assert_eq!((table.state(), table.xy()), (26, (20_581, -5369)));
    assert_eq!(table.until(0), 10);
    assert_eq!((table.count("laser-recovery-state"), table.xy()), (0, (0, 0)));
}

#[test]
fn the_laser_leaves_before_the_cut_goes_on() {
    let table = paused(20_000, -10_000);
    table.put("cut-recovery", true);
    table.run(30);
    table.bench.set("plasmac.laser-recovery-start", 1);
    table.run(60);
    assert_eq!((table.count("laser-recovery-state"), table.xy()), (3, (23_000, -6000)));
    table.bench.set("plasmac.laser-recovery-start", 0);
    table.resumes();
    table.run(2);
    assert_eq!((table.state(), table.count("stop-type-out")), (0, 0));
    table.run(2);
    assert_eq!((table.count("laser-recovery-state"), table.xy()), (5, (23_000, -6000)));
    table.run(1);
    assert_eq!(table.xy(), (20_001, -9999));
    table.run(2);
    assert_eq!((table.count("laser-recovery-state"), table.xy()), (0, (20_000, -10_000)));
    assert_eq!(table.states(1), [0, 1]);
    table.until(26);
    table.until(11);
    assert_eq!(table.xy(), (0, 0));
}
