//! Samples through shared rings: each cycle or each n-th, of every kind of item; samples that do not fit into a ring
//! are counted exactly, and readers that exit, stop or overwrite the memory disturb no other program.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_engine::{ClockKind, Engine};
use hal_protocol::{Client, Link, Place, Request, SampleSpec, Samples, Stamp, Type, Value};
use hal_tests::{
    machine::{Machine, Served, applied, cycles, script, status, thread, wait, without_fifo},
    programs::programs,
    random::Random,
    raw,
    scratch::Scratch,
    tools,
};
use std::os::unix::fs::FileExt;

const MACHINE: &str = "
    loadrt threads name1=fast period1=25000 name2=slow period2=1000000
    loadrt and2 count=4
    start";

fn spec(names: &[&str]) -> SampleSpec {
    let names = names.iter().map(|n| (*n).to_owned()).collect();
    SampleSpec { names, ..SampleSpec::default() }
}

fn in_thread(thread: &str, names: &[&str]) -> SampleSpec {
    SampleSpec { thread: Some(thread.to_owned()), ..spec(names) }
}

fn run(c: &mut impl Link, ns: u64) {
    c.call(Request::Run { ns }).unwrap();
}

/// Reads all waiting samples: time stamp and first value, which is a counter.
fn read(samples: &mut Samples) -> Vec<(Stamp, i64)> {
    let mut record = Vec::new();
    let mut all = Vec::new();
    while let Some(stamp) = samples.take(&mut record) {
        assert_eq!(record.len(), samples.channels().len());
        let Some(Value::S64(n)) = record.first() else { panic!("{record:?}") };
        all.push((stamp, *n));
    }
    all
}

fn stamps(samples: &mut Samples) -> Vec<(u64, i64, u64, i64)> {
    read(samples).into_iter().map(|(s, n)| (s.number, s.time, s.lost, n)).collect()
}

#[test]
fn each_cycle_or_each_nth_of_any_thread() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(MACHINE);
    let fast = spec(&["fast.threadbeat"]);
    let mut each = m.engine.sample(&fast).unwrap();
    assert_eq!((each.info().thread.as_str(), each.info().period), ("fast", 25_000));
    let mut third = m.engine.sample(&SampleSpec { every: 3, ..fast.clone() }).unwrap();
    let mut slow = m.engine.sample(&in_thread("slow", &["slow.threadbeat"])).unwrap();
    run(&mut m, 100_000);
    assert_eq!(
        stamps(&mut each),
        [(0, 25_000, 0, 1), (1, 50_000, 0, 2), (2, 75_000, 0, 3), (3, 100_000, 0, 4)]
    );
    assert_eq!(stamps(&mut third), [(0, 25_000, 0, 1), (1, 100_000, 0, 4)]);
    assert_eq!(stamps(&mut slow), []);

    // No thread runs, so nothing is sampled.
    m.script("stop");
    run(&mut m, 1_000_000);
    assert_eq!(stamps(&mut each), []);
    m.script("start");
    run(&mut m, 900_000);
    assert_eq!(stamps(&mut slow), [(0, 2_000_000, 0, 1)]);
    assert_eq!(stamps(&mut each).first(), Some(&(4, 1_125_000, 0, 5)));
    let state = m.engine.sample(&fast).map(|s| s.info().id).unwrap();
    let ended = m.call(Request::EndSample { id: state });
    assert!(format!("{ended:?}").contains("its reader has ended it"), "{ended:?}");
    let none = m.call(Request::SampleState { id: state }).unwrap_err().to_string();
    assert_eq!(none, format!("this client has no sample {state}"));
    assert!(!each.is_over());
}

#[test]
fn every_type_of_pin_signal_and_parameter() {
    let mut m = Machine::new(ClockKind::Virtual);
    let scratch = Scratch::new("types");
    m.script("loadrt threads\nstart");
    let all = [
        ("bit", "bit", "1", Value::Bit(true)),
        ("float", "float", "-1.5e300", Value::Float(-1.5e300)),
        ("s32", "s32", "-7", Value::S32(-7)),
        ("u32", "u32", "4294967295", Value::U32(u32::MAX)),
        ("s64", "s64", "-9223372036854775808", Value::S64(i64::MIN)),
        ("u64", "u64", "18446744073709551615", Value::U64(u64::MAX)),
    ];
    for (name, ty, value, _) in &all {
        m.script(&format!("newsig {name} {ty}\nsets {name} {value}"));
    }
    let mut signals = m.engine.sample(&spec(&["sig:*"])).unwrap();
    run(&mut m, 1_000_000);
    let mut record = Vec::new();
    assert!(signals.take(&mut record).is_some());
    for (channel, value) in signals.channels().iter().zip(&record) {
        let wanted = all.iter().find(|a| a.0 == channel.name).unwrap();
        assert_eq!((channel.ty, value), (Type::parse(wanted.1).unwrap(), &wanted.3));
    }
    assert_eq!(record.len(), 6);
    m.end();

    // Pins and parameters of a program.
    let served = Served::on(ClockKind::Virtual, &scratch, "types", "loadrt threads\nstart");
    let mut c = served.client();
    script(&mut c, "join prog");
    for (name, ty, _, _) in &all {
        script(&mut c, &format!("newpin prog.{name} {ty} in"));
    }
    script(&mut c, "ready");
    let mut user = served.client();
    for (name, _, value, _) in &all {
        script(&mut user, &format!("setp prog.{name} {value}"));
    }
    let mut pins = user.sample(spec(&["prog.*", "thread1.tmax"])).unwrap();
    run(&mut user, 1_000_000);
    assert!(pins.take(&mut record).is_some());
    for (channel, value) in pins.channels().iter().zip(&record).take(6) {
        let wanted = all.iter().find(|a| channel.name == format!("prog.{}", a.0)).unwrap();
        assert_eq!(value, &wanted.3);
    }
    assert_eq!(record.last(), Some(&Value::S32(0)));
    served.end();
}

#[test]
fn what_the_ring_cannot_hold_is_counted_and_the_rest_is_right() {
    let scratch = Scratch::new("stopped");
    let served = Served::on(ClockKind::Virtual, &scratch, "stopped", MACHINE);
    let (mut c, mut reader) = (served.client(), served.client());
    let wanted = SampleSpec { depth: 100, ..spec(&["fast.threadbeat", "and2.0.out"]) };
    let mut samples = reader.sample(wanted).unwrap();
    assert_eq!(samples.info().depth, 100);
    let (mut next, mut lost) = (0_u64, 0);
    // The reader pauses for this many cycles, then reads.
    for stop in [1, 99, 100, 101, 1000, 37, 12_345, 100] {
        run(&mut c, stop * 25_000);
        let all = read(&mut samples);
        let kept = stop.min(100);
        assert_eq!(all.len() as u64, kept, "after {stop}");
        for (i, (stamp, n)) in all.iter().enumerate() {
            let number = next + i as u64;
            assert_eq!(stamp.number, number);
            assert_eq!(
                (stamp.time, *n),
                ((number.cast_signed() + 1) * 25_000, number.cast_signed() + 1)
            );
            assert_eq!(stamp.lost, if i == 0 { lost } else { 0 });
        }
        lost = stop - kept;
        next += stop;
        let state = reader.sample_state(samples.info().id).unwrap();
        assert_eq!(state.samples, next);
        assert_eq!(state.lost, samples.lost() + lost);
        assert_eq!(samples.lost_at_end(), lost);
    }
    served.end();
}

/// Reads until this many samples have arrived; checks that `(channel 0 - number)` stays constant.
fn all_of(mut samples: Samples, n: u64) -> u64 {
    let mut record = Vec::new();
    let mut got = 0;
    while got < n {
        let Some(stamp) = samples.take(&mut record) else {
            std::thread::yield_now();
            continue;
        };
        assert_eq!((stamp.number, stamp.lost), (got, 0));
        assert_eq!(record.first(), Some(&Value::S64(got.cast_signed() + 1)));
        got += 1;
    }
    got
}

#[test]
fn time_waits_for_a_reader_that_asks_for_it() {
    let scratch = Scratch::new("lossless");
    let machine = "
        loadrt threads name1=fast period1=25000 name2=slow period2=1000000
        loadrt and2 count=60
        start";
    let served = Served::on(ClockKind::Virtual, &scratch, "lossless", machine);
    let (mut c, mut reader) = (served.client(), served.client());
    // 16 channels at 40 kHz and 200 at 1 kHz, in rings that hold a small part.
    let few: Vec<String> = (0..15).map(|i| format!("and2.{i}.in0")).collect();
    let mut few: Vec<&str> = few.iter().map(String::as_str).collect();
    few.insert(0, "fast.threadbeat");
    let many: Vec<String> = (0..200)
        .map(|i| format!("and2.{}.{}", i / 4 % 60, ["in0", "in1", "out", "time"][i % 4]))
        .collect();
    let mut many: Vec<&str> = many.iter().map(String::as_str).collect();
    many.pop();
    many.insert(0, "slow.threadbeat");
    let wait = SampleSpec { wait: true, depth: 64, ..SampleSpec::default() };
    let few = reader.sample(SampleSpec {
        thread: Some("fast".into()),
        names: spec(&few).names,
        ..wait.clone()
    });
    let many =
        reader.sample(SampleSpec { thread: Some("slow".into()), names: spec(&many).names, ..wait });
    let (few, many) = (few.unwrap(), many.unwrap());
    assert_eq!((few.channels().len(), many.channels().len()), (16, 200));
    assert!(few.info().wait && many.info().wait);
    let reads = [
        std::thread::spawn(move || all_of(few, 20_000)),
        std::thread::spawn(move || all_of(many, 500)),
    ];
    run(&mut c, 500_000_000);
    for r in reads {
        r.join().unwrap();
    }
    assert_eq!(thread(&mut c, "fast").cycles, 20_000);
    served.end();
}

#[test]
fn time_moves_on_when_the_reader_it_waited_for_goes() {
    let scratch = Scratch::new("gone");
    let served = Served::on(ClockKind::Virtual, &scratch, "gone", MACHINE);
    let mut reader = served.client();
    let waits = SampleSpec { wait: true, depth: 10, ..spec(&["fast.threadbeat"]) };
    let samples = reader.sample(waits).unwrap();
    let place = served.place.clone();
    let ran = std::thread::spawn(move || run(&mut Client::connect(&place, "").unwrap(), 1_000_000));
    let mut look = served.client();
    wait(&mut look, "a full ring", |_| samples.waiting() == 10);
    assert_eq!(status(&mut look).time, 250_000);
    assert_eq!(thread(&mut look, "fast").cycles, 10);
    drop(reader);
    ran.join().unwrap();
    assert_eq!(thread(&mut look, "fast").cycles, 40);
    // Waiting samples remain, and no more arrive.
    assert_eq!(samples.waiting(), 10);
    served.end();
}

#[test]
fn a_pin_follows_its_signal() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(MACHINE);
    m.script("newsig one bit\nsets one 1\nnewsig zero bit");
    let mut samples = m.engine.sample(&spec(&["and2.0.in0", "and2.1.in0", "one"])).unwrap();
    let mut seen = |m: &mut Machine, lines: &str| {
        if !lines.is_empty() {
            assert_eq!(applied(m, lines), "ok");
        }
        run(m, 25_000);
        let mut record = Vec::new();
        samples.take(&mut record).unwrap();
        let bits = record.iter().map(|v| if *v == Value::Bit(true) { '1' } else { '0' });
        bits.collect::<String>()
    };
    assert_eq!(seen(&mut m, ""), "001");
    assert_eq!(seen(&mut m, "linkps and2.0.in0 one\nlinkps and2.1.in0 zero\nsets one 1"), "101");
    let swap = "unlinkp and2.0.in0\nunlinkp and2.1.in0\nlinkps and2.0.in0 zero\nlinkps and2.1.in0 one\nsets zero 0\nsets one 1";
    assert_eq!(seen(&mut m, swap), "011");
    assert_eq!(seen(&mut m, "sets one 0\nsets zero 1"), "100");
    // An unlinked pin keeps its value.
    assert_eq!(seen(&mut m, "unlinkp and2.0.in0\nsets zero 0"), "100");
    assert_eq!(seen(&mut m, "setp and2.0.in0 0"), "000");
}

#[test]
fn it_ends_when_what_it_watches_goes_and_only_then() {
    for (names, goes) in [
        (["and2.0.out", "fast.threadbeat"], "unloadrt and2"),
        (["x", "fast.threadbeat"], "delsig x"),
    ] {
        let scratch = Scratch::new("ends");
        let served = Served::on(ClockKind::Virtual, &scratch, "ends", MACHINE);
        let mut c = served.client();
        script(
            &mut c,
            "loadrt or2\nloadrt threads2 name1=t period1=2000000".lines().next().unwrap(),
        );
        script(&mut c, "newsig x bit\nlinkps and2.0.in0 x");
        let mut samples = c.sample(spec(&names)).unwrap();
        run(&mut c, 50_000);
        // The whole transaction is refused, so nothing has changed.
        assert!(applied(&mut c, &format!("{goes}\nsetp nothing 1")).contains("not found"));
        script(&mut c, "unloadrt or2");
        run(&mut c, 50_000);
        let id = samples.info().id;
        assert_eq!(c.sample_state(id).unwrap().ended, None);
        assert_eq!(applied(&mut c, goes), "ok");
        let state = c.sample_state(id).unwrap();
        let why = "something that was sampled has been unloaded or deleted";
        assert_eq!((state.samples, state.ended.as_deref()), (4, Some(why)));
        assert!(!samples.is_over());
        run(&mut c, 50_000);
        let mut record = Vec::new();
        let n = std::iter::from_fn(|| samples.take(&mut record)).count();
        assert_eq!((n, samples.is_over(), samples.lost_at_end()), (4, true, 0));
        assert_eq!(c.end_sample(id).unwrap().ended.as_deref(), Some(why));
        assert!(c.sample_state(id).is_err());
        served.end();
    }
}

#[test]
fn what_cannot_be_sampled_is_refused_and_leaves_nothing() {
    let mut m = Machine::new(ClockKind::Virtual);
    let said = |m: &mut Machine, spec: &SampleSpec| m.engine.sample(spec).unwrap_err().to_string();
    m.script("newsig x bit\nnewsig p port");
    assert_eq!(said(&mut m, &spec(&["x"])), "there is no thread to sample in");
    m.script(MACHINE);
    for (names, want) in [
        (&[][..], "no pin to sample is named"),
        (
            &["x", "and2.0.otu"],
            "pin, parameter or signal 'and2.0.otu' not found; did you mean and2.0.out?",
        ),
        (&["nothing*"], "nothing matches 'nothing*'"),
        (&["p"], "'p' is a port and has no value to sample"),
        (&["sig:and2.0.out"], "pin, parameter or signal 'sig:and2.0.out' not found"),
    ] {
        let text = said(&mut m, &spec(names));
        assert!(text.starts_with(want), "{names:?}: {text}");
    }
    assert_eq!(
        said(&mut m, &spec(&["x"; 1025])),
        "1025 channels at once; at most 1024 are possible"
    );
    let text = said(&mut m, &SampleSpec { depth: u32::MAX, ..spec(&["x"]) });
    assert!(text.starts_with("not enough memory for 4294967295 samples"), "{text}");
    let here = m.call(Request::Sample(spec(&["x"]))).unwrap_err().to_string();
    assert_eq!(here, "samples go to programs: ask for them on the socket");
    assert!(said(&mut m, &in_thread("quick", &["x"])).contains("'quick' not found"));
    assert!(m.engine.sample(&spec(&["x"; 1024])).is_ok());
    // The total size of all rings is bounded.
    let deep = SampleSpec { depth: 1 << 23, ..spec(&["x"]) };
    let taken: Vec<Samples> = std::iter::from_fn(|| m.engine.sample(&deep).ok()).collect();
    assert!(taken.len() < 6, "{}", taken.len());
    for s in &taken {
        m.call(Request::EndSample { id: s.info().id }).unwrap();
    }
    assert!(m.engine.sample(&deep).is_ok());
}

#[test]
fn on_the_real_clock_exactly_what_was_lost_is_counted() {
    let scratch = Scratch::new("real");
    let machine = "
        loadrt threads name1=fast period1=100000 name2=slow period2=1000000
        loadrt and2 count=60
        start";
    let served = Served::start(&scratch, "real", machine);
    let (mut c, mut reader) = (served.client(), served.client());
    let names: Vec<String> = (0..60).map(|i| format!("and2.{i}.*")).collect();
    let names = names.iter().map(String::as_str);
    let names: Vec<&str> = std::iter::once("fast.threadbeat").chain(names).collect();
    let small = SampleSpec { depth: 50, ..in_thread("fast", &names) };
    let mut samples = reader.sample(small).unwrap();
    let (mut before, mut got, mut offset) = (None::<Stamp>, 0_u64, None);
    let mut check = |all: Vec<(Stamp, i64)>| {
        for (stamp, beat) in all {
            // The thread counts its cycles itself.
            assert_eq!(
                *offset.get_or_insert(beat - stamp.number.cast_signed()),
                beat - stamp.number.cast_signed()
            );
            if let Some(b) = before {
                assert_eq!(stamp.number - b.number - 1, stamp.lost);
                assert!(stamp.time - b.time >= (stamp.number - b.number).cast_signed() * 100_000);
                assert_eq!((stamp.time - b.time) % 100_000, 0);
            }
            before = Some(stamp);
            got += 1;
        }
        got
    };
    for stop in [10, 49, 50, 200, 20] {
        cycles(&mut c, "fast", stop);
        check(read(&mut samples));
    }
    let state = reader.end_sample(samples.info().id).unwrap();
    let got = check(read(&mut samples));
    assert!(samples.is_over());
    assert_eq!(state.samples, got + samples.lost() + samples.lost_at_end());
    assert_eq!(state.lost, samples.lost() + samples.lost_at_end());
    assert!(state.lost >= 150, "{state:?}");
    served.end();
}

#[test]
fn components_and_links_come_and_go_while_the_real_clock_runs() {
    let scratch = Scratch::new("churn");
    let machine = "loadrt threads name1=fast period1=50000\nloadrt and2\naddf and2.0 fast\nstart";
    let served = Served::start(&scratch, "churn", machine);
    let (mut c, mut reader) = (served.client(), served.client());
    let mut steady = reader.sample(spec(&["fast.threadbeat", "and2.0.out"])).unwrap();
    for _ in 0..20 {
        script(&mut c, "loadrt or2 count=3\naddf or2.0 fast\nnewsig s bit\nlinkps or2.0.in0 s");
        let mut samples = reader.sample(spec(&["or2.*", "s", "fast.threadbeat"])).unwrap();
        wait(&mut c, "samples", |_| samples.waiting() > 3);
        script(&mut c, "unlinkp or2.0.in0\nunloadrt or2");
        let state = reader.sample_state(samples.info().id).unwrap();
        assert!(state.ended.is_some());
        let mut record = Vec::new();
        let n = std::iter::from_fn(|| samples.take(&mut record)).count() as u64;
        assert_eq!(n + samples.lost() + samples.lost_at_end(), state.samples);
        script(&mut c, "delsig s");
        let all = read(&mut steady);
        assert!(all.windows(2).all(|w| w[1].0.number == w[0].0.number + 1 + w[1].0.lost));
    }
    assert_eq!(reader.sample_state(steady.info().id).unwrap().ended, None);
    served.end();
}

#[test]
fn what_a_reader_writes_is_not_believed() {
    let scratch = Scratch::new("scribble");
    let served = Served::on(ClockKind::Virtual, &scratch, "scribble", MACHINE);
    let (mut c, mut reader) = (served.client(), served.client());
    let mut right = reader.sample(spec(&["fast.threadbeat"])).unwrap();
    let mut random = Random::new(0x5eed);
    let mut n = 0;
    for round in 0..40 {
        let request = r#"{"sample":{"names":["fast.threadbeat"],"depth":4}}"#;
        let (socket, file) = raw::ring(&served, request);
        let size = file.metadata().unwrap().len();
        assert!(file.set_len(0).is_err() && file.set_len(size + 1).is_err());
        for _ in 0..20 {
            // First the ring's indices, then random words.
            let at = if round < 20 { [64, 128][round % 2] } else { random.word() % (size / 8) * 8 };
            let word = match random.word() % 3 {
                0 => random.word(),
                1 => random.word() % 16,
                _ => (random.word() % 16).wrapping_neg(),
            };
            file.write_all_at(&word.to_ne_bytes(), at).unwrap();
            let cycles = random.word() % 3;
            run(&mut c, cycles * 25_000);
            n += cycles.cast_signed();
        }
        drop((socket, file));
        // The adjacent ring is intact, and a new one starts clean.
        let all = stamps(&mut right);
        assert!(all.iter().all(|s| s.0.cast_signed() + 1 == s.3 && s.2 == 0));
        assert_eq!(all.last().map_or(n, |s| s.3), n);
        let mut next = c.sample(spec(&["fast.threadbeat"])).unwrap();
        run(&mut c, 50_000);
        n += 2;
        assert_eq!(
            stamps(&mut next).iter().map(|s| (s.0, s.3)).collect::<Vec<_>>(),
            [(0, n - 1), (1, n)]
        );
        c.end_sample(next.info().id).unwrap();
    }
    served.end();
}

/// A component in C whose parameters are in memory of its own.
const FOREIGN: &str = "component par \"Parameters.\";
    pin out s32 n;
    param rw float gain = 1.5;
    param rw bit on = 1;
    param rw signed low = -3;
    param rw unsigned high = 4000000000;
    param r signed count;
    function _;
    license \"GPL\";
;;
    FUNCTION(_) { count = count + 1; n = -count; }
    ";

#[test]
fn parameters_in_memory_of_a_component_in_c() {
    if tools::compiler().is_none() {
        return;
    }
    let scratch = Scratch::new("foreign");
    std::fs::write(scratch.path().join("par.comp"), FOREIGN).unwrap();
    let compiled = scratch.run(scratch.command(&[], "halcompile").args(["--compile", "par.comp"]));
    assert_eq!(compiled.status, Some(0), "{}", compiled.stderr);
    for clock in [ClockKind::Virtual, ClockKind::Real] {
        let place = Place::at("/nonexistent", "test").unwrap();
        let mut options = hal_tests::machine::options(place, clock);
        options.path = vec![programs().to_owned(), scratch.path().to_owned()];
        let mut e = Engine::without_socket(options).unwrap();
        e.add_static(&::threads::HAL_LIBRARY);
        script(&mut e, "loadrt threads\nloadrt par\naddf par.0 thread1");
        let names = ["par.0.count", "par.0.n", "par.0.gain", "par.0.on", "par.0.low", "par.0.high"];
        let mut samples = e.sample(&spec(&names)).unwrap();
        script(&mut e, "start");
        if clock == ClockKind::Virtual {
            run(&mut e, 3_000_000);
        }
        wait(&mut e, "samples", |_| samples.waiting() >= 3);
        let mut record = Vec::new();
        for i in 1..=3 {
            samples.take(&mut record).unwrap();
            let rest =
                [Value::Float(1.5), Value::Bit(true), Value::S32(-3), Value::U32(4_000_000_000)];
            assert_eq!(record.get(..2), Some(&[Value::S32(i), Value::S32(-i)][..]));
            assert_eq!(record.get(2..), Some(&rest[..]));
        }
        // Its memory is freed with it, and no sample reads it any more.
        script(&mut e, "unloadrt par");
        let id = samples.info().id;
        let state = e.call(Request::SampleState { id });
        assert!(format!("{state:?}").contains("unloaded"), "{state:?}");
        e.close();
    }
}

#[test]
fn all_of_this_without_fifo() {
    without_fifo(module_path!(), "all_of_this_without_fifo");
}
