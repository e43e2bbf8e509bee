use super::Plasmac;
use hal_bench::{Bench, trace::replay};

mod height;
mod messages;
mod probing;
mod rare;

/// A machine whose Z follows the offset, over a table at 0.
struct Table {
    bench: Bench,
    arc: bool,
    volts: f64,
    velocity: f64,
    /// Z at and below which the float switch is on; `tip` is the same for the contact of the tip.
    switch: f64,
    tip: f64,
}

impl Table {
    fn new(more: &[(&str, f64)]) -> Self {
        let mut bench = Bench::new();
        bench.load::<Plasmac>(&[]).unwrap();
        let table = Self {
            bench,
            arc: true,
            volts: 100.0,
            velocity: 50.0,
            switch: 0.0,
            tip: f64::NEG_INFINITY,
        };
        for pin in ["machine-is-on", "homed", "torch-enable", "thc-enable", "program-is-running"] {
            table.put(pin, true);
        }
        table.bench.set("plasmac.mode", 1);
        table.bench.set("plasmac.arc-max-starts", 3);
        for (pin, value) in [
            ("units-per-mm", 1.0),
            ("axis-z-max-limit", 60.0),
            ("axis-z-min-limit", -5.0),
            ("probe-start-height", 15.0),
            ("probe-feed-rate", 12000.0),
            ("setup-feed-rate", 60000.0),
            ("float-switch-travel", 0.5),
            ("pierce-height", 3.0),
            ("cut-height", 1.5),
            ("cut-volts", 100.0),
            ("safe-height", 10.0),
            ("pierce-delay", 0.01),
            ("arc-fail-delay", 0.02),
            ("restart-delay", 0.01),
            ("thc-delay", 0.01),
            ("thc-feed-rate", 1000.0),
            ("thc-threshold", 1.0),
            ("pid-p-gain", 10.0),
            ("feed-upm", 3000.0),
            ("cut-feed-rate", 3000.0),
            ("xy-feed-rate", 600.0),
            ("arc-voltage-scale", 1.0),
        ]
        .iter()
        .chain(more)
        {
            table.bench.set(&format!("plasmac.{pin}"), *value);
        }
        table
    }

    fn put(&self, pin: &str, on: bool) {
        self.bench.set(&format!("plasmac.{pin}"), on);
    }

    fn is(&self, pin: &str) -> bool {
        self.bench.get(&format!("plasmac.{pin}"))
    }

    fn float(&self, pin: &str) -> f64 {
        self.bench.get(&format!("plasmac.{pin}"))
    }

    fn count(&self, pin: &str) -> i32 {
        self.bench.get(&format!("plasmac.{pin}"))
    }

    fn state(&self) -> i32 {
        self.count("state-out")
    }

    fn run(&self, cycles: u32) {
        for _ in 0..cycles {
            let offset = f64::from(self.count("z-offset-counts")) * self.float("offset-scale");
            self.bench.set("plasmac.z-offset-current", offset);
            self.bench.set("plasmac.axis-z-position", 20.0 + offset);
            self.put("float-switch", 20.0 + offset <= self.switch);
            self.put("ohmic-probe", 20.0 + offset <= self.tip);
            let lit = self.is("torch-on");
            self.put("arc-ok-in", lit && self.arc);
            self.bench.set("plasmac.arc-voltage-in", if lit { self.volts } else { 0.0 });
            let cuts = self.state() == 11;
            self.bench.set("plasmac.current-velocity", if cuts { self.velocity } else { 0.0 });
            self.bench.run("plasmac", 1_000_000);
        }
    }

    /// Runs until the component is in this state. Returns the number of cycles.
    fn until(&self, state: i32) -> u32 {
        for i in 0..5000 {
            if self.state() == state {
                return i;
            }
            self.run(1);
        }
        panic!("state {state} is not reached, but {}", self.state());
    }

    /// Returns the states of this number of cycles.
    fn states(&self, cycles: u32) -> Vec<i32> {
        let mut all = vec![self.state()];
        for _ in 0..cycles {
            self.run(1);
            all.push(self.state());
        }
        all.dedup();
        all
    }
}

fn cutting(more: &[(&str, f64)]) -> Table {
    let table = Table::new(more);
    table.run(2);
    table.put("cutting-start", true);
    table.until(11);
    table
}

#[test]
fn rows_are_as_theirs() {
    assert!(replay::<Plasmac>(include_str!("../../traces/plasmac.txt")) > 2000);
}

#[test]
fn a_cut_from_start_to_end() {
    let table = Table::new(&[]);
    table.run(2);
    table.put("cutting-start", true);
    assert_eq!(table.states(600), [0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 11]);
    assert!(table.is("torch-on") && table.is("thc-active") && !table.is("feed-hold"));
    assert_eq!(table.float("target-volts"), 100.0);
    assert_eq!(table.float("z-height"), 1.5);
    assert_eq!(table.count("pierce-count"), 1);
    table.put("cutting-start", false);
    assert_eq!(table.states(200), [11, 14, 16, 0]);
    assert!(!table.is("torch-on") && !table.is("feed-hold"));
    assert_eq!(table.count("stop-type-out"), 2);
    assert_eq!(table.float("z-height"), 10.0);
}

#[test]
fn a_start_that_fails_is_tried_again() {
    let mut table = Table::new(&[]);
    table.arc = false;
    table.run(2);
    table.put("cutting-start", true);
    table.until(7);
    assert_eq!(table.until(6), 20);
    assert_eq!(table.until(7), 10);
    table.run(100);
    assert_eq!(table.count("pierce-count"), 3);
    assert!(table.is("program-pause") && !table.is("torch-on"));
    assert_eq!(table.state(), 6);
    table.put("program-is-paused", true);
    table.run(1);
    assert!(!table.is("program-pause"));
    assert_eq!((table.state(), table.count("stop-type-out")), (15, 3));
}

#[test]
fn an_arc_that_is_lost_pauses_the_program() {
    let mut table = cutting(&[("arc-lost-delay", 0.02)]);
    table.run(40);
    table.arc = false;
    table.run(20);
    assert!(table.is("arc-ok-out") && !table.is("thc-enabled"));
    assert_eq!(table.states(3), [11, 15]);
    assert!(table.is("program-pause") && !table.is("torch-on"));
    assert_eq!(table.count("stop-type-out"), 3);
}

#[test]
fn a_pause_takes_the_torch_up_and_it_begins_anew() {
    let table = cutting(&[]);
    table.run(40);
    table.put("program-is-paused", true);
    assert_eq!(table.states(300), [11, 15, 16, 0]);
    assert_eq!(table.count("z-offset-counts"), 0);
    assert_eq!(table.count("stop-type-out"), 3);
    table.put("program-is-paused", false);
    assert_eq!(table.states(5), [0, 1]);
}

#[test]
fn a_torch_that_breaks_away_ends_the_cut() {
    let table = cutting(&[]);
    table.put("breakaway", true);
    table.run(1);
    assert!(table.is("sensor-active") && table.is("program-pause"));
    assert_eq!((table.state(), table.count("stop-type-out")), (15, 3));
}

#[test]
fn a_torch_pulse_lasts_as_long_as_it_shall() {
    let table = Table::new(&[("torch-pulse-time", 0.02)]);
    table.run(2);
    table.put("torch-pulse-start", true);
    table.run(2);
    assert!(table.is("torch-on"));
    table.put("torch-pulse-start", false);
    table.run(19);
    assert!(table.is("torch-on"));
    table.run(2);
    assert!(!table.is("torch-on"));
    assert_eq!(table.state(), 0);
}

#[test]
fn a_scribe_is_armed_and_then_on() {
    let table = Table::new(&[("scribe-arm-delay", 0.01), ("scribe-on-delay", 0.02)]);
    table.run(2);
    table.put("scribe-start", true);
    table.run(2);
    assert!(table.is("scribe-arm") && table.is("feed-hold") && !table.is("scribe-on"));
    table.run(15);
    assert!(table.is("scribe-on") && table.is("feed-hold"));
    table.run(25);
    assert!(!table.is("feed-hold"));
    table.put("scribe-start", false);
    table.run(1);
    assert!(!table.is("scribe-arm") && !table.is("scribe-on"));
    assert_eq!(table.state(), 0);
}

#[test]
fn consumables_are_changed_in_a_pause() {
    let table = cutting(&[]);
    table.bench.set("plasmac.x-offset", 20_000);
    table.bench.set("plasmac.y-offset", -10_000);
    table.put("program-is-running", false);
    table.put("program-is-paused", true);
    table.put("cutting-start", false);
    table.until(0);
    table.put("consumable-change", true);
    table.until(23);
    table.run(2);
    assert_eq!((table.count("x-offset-counts"), table.count("y-offset-counts")), (894, -447));
    table.run(40);
    assert_eq!((table.count("x-offset-counts"), table.count("y-offset-counts")), (20_000, -10_000));
    assert!(table.is("consumable-changing"));
    table.put("consumable-change", false);
    table.run(60);
    assert_eq!((table.count("x-offset-counts"), table.count("y-offset-counts")), (0, 0));
    assert!(!table.is("consumable-changing"));
}

#[test]
fn a_spot_lasts_its_time_from_when_the_voltage_is_high_enough() {
    let mut table = Table::new(&[("spotting-threshold", 50.0), ("spotting-time", 10.0)]);
    table.arc = false;
    table.volts = 20.0;
    table.run(2);
    table.put("spotting-start", true);
    table.until(7);
    table.run(5);
    assert!(table.state() == 7 && table.is("torch-on"));
    table.volts = 60.0;
    assert_eq!(table.until(14), 11);
    assert_eq!(table.count("stop-type-out"), 2);
    assert!(!table.is("torch-on"));
    assert_eq!(table.count("pierce-count"), 1);
    // The spot is still requested: another one follows.
    table.until(0);
    table.until(7);
    // The spot takes longer than a start may take: no spot.
    table.bench.set("plasmac.spotting-time", 40.0);
    assert_eq!(table.until(6), 20);
}

#[test]
fn a_cut_and_a_spot_together_are_a_cut() {
    let table = Table::new(&[("spotting-threshold", 50.0)]);
    table.run(2);
    table.put("spotting-start", true);
    table.put("cutting-start", true);
    table.until(11);
}

#[test]
fn a_job_ends_only_without_a_program() {
    let table = cutting(&[]);
    table.put("program-is-running", false);
    table.put("program-is-idle", true);
    table.until(17);
    table.put("program-is-idle", false);
    table.put("program-is-running", true);
    assert_eq!(table.states(20), [17]);
    table.put("cutting-start", false);
    table.put("program-is-running", false);
    table.put("program-is-idle", true);
    assert_eq!(table.states(5), [17, 0]);
    assert_eq!(table.count("stop-type-out"), 0);
}

#[test]
fn the_feed_is_held_after_a_torch_that_broke_away() {
    let table = cutting(&[]);
    table.put("breakaway", true);
    table.until(0);
    assert_eq!(table.states(4), [0, 16, 0, 16, 0]);
    table.put("breakaway", false);
    table.run(4);
    assert_eq!((table.state(), table.count("stop-type-out")), (0, 0));
    assert!(table.is("feed-hold") && table.is("program-pause"));
}

#[test]
fn a_torch_that_is_put_out_is_no_lost_arc() {
    let table = cutting(&[]);
    table.put("torch-off", true);
    assert_eq!(table.states(10), [11]);
    assert!(!table.is("torch-on") && !table.is("program-pause"));
    table.put("torch-off", false);
    assert_eq!(table.states(2), [11, 15]);
    assert!(table.is("program-pause"));
}
