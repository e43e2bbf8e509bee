//! Cost of sampling values: per channel of a sample, and per pin whose changes are recorded.
//!
//! Machine time runs in a loop, so that only the cost of a cycle is measured; the last column is the number of channels
//! sampled per second. Then the printer as a whole, with and without its flight recorder. Run it with
//! `cargo bench -p hal-tests --bench samples`.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark measures the wall clock and prints"
)]

use divan::{Bencher, counter::ItemsCount};
use hal_engine::{ClockKind, Engine, Options};
use hal_protocol::{Client, FlightSpec, Link, Place, Reply, Request, SampleSpec};
use hal_tests::{
    machine::script,
    programs::root,
    scratch::{Scratch, until},
};
use std::{cell::RefCell, time::Instant};

/// Number of cycles between two reads of the ring.
const CYCLES: u32 = 1000;

/// Creates this many gates, with linked outputs, in a machine whose 1 ms thread runs none of them.
fn machine(gates: usize) -> Engine {
    let options =
        Options::simulated(Place::at("/nonexistent", "bench").unwrap(), ClockKind::Virtual);
    let mut e = Engine::without_socket(options).unwrap();
    e.add_static(&logic::HAL_LIBRARY);
    e.add_static(&threads::HAL_LIBRARY);
    let load = |e: &mut Engine, module: &str, args: &str| {
        let args = args.split_whitespace().map(str::to_owned).collect();
        e.call(Request::Load { module: module.to_owned(), args }).unwrap();
    };
    load(&mut e, "threads", "name1=t period1=1000000");
    load(&mut e, "and2", &format!("count={gates}"));
    for i in 0..gates {
        let pins = vec![format!("and2.{i}.out"), format!("and2.{}.in0", (i + 1) % gates)];
        e.call(Request::Net { signal: format!("s{i}"), pins }).unwrap();
    }
    e.call(Request::Start).unwrap();
    e
}

fn run(e: &mut Engine) {
    e.call(Request::Run { ns: u64::from(CYCLES) * 1_000_000 }).unwrap();
}

/// Measures the cycle alone, without samples.
#[divan::bench(sample_count = 50, sample_size = 1)]
fn cycle_of_nothing(bencher: Bencher<'_, '_>) {
    let mut e = machine(8);
    bencher.counter(ItemsCount::new(CYCLES)).bench_local(|| run(&mut e));
}

/// Samples every value of this many linked pins into a ring that a program would read.
#[divan::bench(args = [16, 200, 1000], sample_count = 50, sample_size = 1)]
fn channel_of_a_sample(bencher: Bencher<'_, '_>, channels: usize) {
    let mut e = machine(channels);
    let names = (0..channels).map(|i| format!("and2.{i}.out")).collect();
    let spec = SampleSpec { depth: CYCLES, names, ..SampleSpec::default() };
    let samples = RefCell::new(e.sample(&spec).unwrap());
    let mut record = Vec::new();
    bencher
        .counter(ItemsCount::new(CYCLES as usize * channels))
        .with_inputs(|| while samples.borrow_mut().take_bits(&mut record).is_some() {})
        .bench_local_values(|()| run(&mut e));
    assert_eq!(samples.borrow().lost_at_end(), 0);
}

/// Measures the reading side of the same.
#[divan::bench(args = [16, 200, 1000], sample_count = 50, sample_size = 1)]
fn channel_that_is_read(bencher: Bencher<'_, '_>, channels: usize) {
    let mut e = machine(channels);
    let names = (0..channels).map(|i| format!("and2.{i}.out")).collect();
    let spec = SampleSpec { depth: CYCLES, names, ..SampleSpec::default() };
    let mut samples = e.sample(&spec).unwrap();
    let mut record = Vec::new();
    bencher
        .counter(ItemsCount::new(CYCLES as usize * channels))
        .with_inputs(|| run(&mut e))
        .bench_local_values(|()| while samples.take_bits(&mut record).is_some() {});
}

/// Looks for changes in this many pins that do not change.
#[divan::bench(args = [1000], sample_count = 50, sample_size = 1)]
fn pin_that_is_recorded(bencher: Bencher<'_, '_>, pins: usize) {
    let mut e = machine(pins);
    let (path, patterns) = ("/dev/null".to_owned(), vec!["and2.*.out".to_owned()]);
    e.call(Request::Record { path, patterns }).unwrap();
    bencher.counter(ItemsCount::new(CYCLES as usize * pins)).bench_local(|| run(&mut e));
}

/// Number of measurements of each; the smallest counts.
const ROUNDS: usize = 60;
/// Base period of the printer, in nanoseconds, and its cycles in a round.
const BASE: u32 = 100_000;
const BASE_CYCLES: u32 = 2_000;

/// Returns the duration of the printer's base cycle, in nanoseconds.
fn cycle(client: &mut Client) -> f64 {
    let begin = Instant::now();
    client.call(Request::Run { ns: u64::from(BASE) * u64::from(BASE_CYCLES) }).unwrap();
    begin.elapsed().as_secs_f64() * 1e9 / f64::from(BASE_CYCLES)
}

/// Jogs X at this speed, in mm/s, unless it is 0.
fn jog(client: &mut Client, velocity: i32) {
    if velocity != 0 {
        script(client, &format!("motion.jog joint=0 velocity={velocity}"));
    }
}

/// Measures the printer of `configs`, at rest and in motion: a base cycle with everything that runs besides it, and the
/// additional cost of the flight recorder.
fn printer() {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    let lines =
        "iocontrol.estop-reset --wait\nmotion.enable --wait\nmotion.home joint=all --wait\n";
    scratch.write("custom_postgui.hal", format!("{lines}newsig is-up bit\n"));
    let mut halrun = scratch.command(&[], "halrun");
    let _halrun = scratch.start(halrun.args(["--virtual", "--hold", "printer.ini"]));
    let place = Place::at(scratch.path().join(".run/ferrule"), "default").unwrap();
    let up = Request::GetSignal { name: "is-up".to_owned() };
    until("the printer is up", || {
        Client::connect(&place, "").is_ok_and(|mut c| c.call(up.clone()).is_ok())
    });
    let mut client = Client::connect(&place, "").unwrap();
    for velocity in [0, 50] {
        let (mut without, mut with, mut values) = (f64::INFINITY, f64::INFINITY, 0);
        for _ in 0..ROUNDS {
            jog(&mut client, velocity);
            without = without.min(cycle(&mut client));
            jog(&mut client, -velocity);
            client.call(Request::Flight(FlightSpec::default())).unwrap();
            with = with.min(cycle(&mut client));
            let Ok(Reply::Flight(info)) = client.call(Request::FlightState) else {
                panic!("no flight recorder")
            };
            assert_eq!(info.lost, 0);
            values = info.values;
            client.call(Request::EndFlight).unwrap();
        }
        let more = with - without;
        println!(
            "the printer at {velocity:>2} mm/s: a base cycle {without:.0} ns, with {values} values in the \
             flight recorder {with:.0} ns: {:.2} ns a value, {:.2} % of the base period",
            more / f64::from(values),
            more / f64::from(BASE) * 100.0
        );
    }
    client.call(Request::Shutdown).unwrap();
}

fn main() {
    divan::main();
    if !std::env::args().any(|a| a == "--test" || a == "--list") {
        printer();
    }
}
