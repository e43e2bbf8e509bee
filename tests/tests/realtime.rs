//! No function allocates in a cycle. The test interposes the C library's `malloc`, `calloc`,
//! `realloc` and `free`, which every library's own allocator calls, and counts the calls of
//! realtime threads while every component runs 10,000 cycles with inputs, parameters and commands
//! of every kind, and while the wiring changes.
#![expect(clippy::unwrap_used, clippy::panic, unsafe_code, reason = "tests")]

use hal_engine::{ClockKind, Engine, Offer, Options};
use hal_protocol::{
    ArgInfo, CommandInfo, Direction, FunctInfo, ItemInfo, Kind, Link, Place, Reply, Request,
    SampleSpec, Type,
};
use hal_tests::{
    every,
    machine::{bit, cycles, says, script, status, thread, wait},
    plugins::{interpose, plugins},
    programs::programs,
    random::{Random, text_argument},
};
use std::{path::Path, process::Command};

const CYCLES: u64 = 10_000;

/// The function that is added and removed while cycles are counted.
const EDITED: &str = "and2.3";

/// Environment variable with the test that a child process runs.
const CHILD: &str = "FERRULE_TEST_COUNTS";

/// The counting library, which is loaded before the C library.
mod counter {
    unsafe extern "C" {
        fn dlsym(
            handle: *mut core::ffi::c_void,
            name: *const core::ffi::c_char,
        ) -> *mut core::ffi::c_void;
    }

    fn find(name: &core::ffi::CStr) -> *mut core::ffi::c_void {
        // SAFETY: a name and the default handle.
        let found = unsafe { dlsym(core::ptr::null_mut(), name.as_ptr()) };
        assert!(!found.is_null(), "libinterpose.so was not put before the C library");
        found
    }

    /// Resets and starts the counter, or stops it.
    pub(crate) fn count(on: bool) {
        let f = find(c"hal_interpose_count");
        // SAFETY: the library's function of that type.
        let f = unsafe { core::mem::transmute::<*mut core::ffi::c_void, extern "C" fn(bool)>(f) };
        f(on);
    }

    /// Returns the number of counted calls.
    pub(crate) fn counted() -> u64 {
        let f = find(c"hal_interpose_counted");
        // SAFETY: the library's function of that type.
        let f =
            unsafe { core::mem::transmute::<*mut core::ffi::c_void, extern "C" fn() -> u64>(f) };
        f()
    }
}

/// Returns a value as a user would write it: ordinary, or at the edge of the range.
fn value(random: &mut Random, ty: Type) -> String {
    let odd = random.word().is_multiple_of(4);
    let n = random.word();
    match ty {
        Type::Bit => random.one(&["0", "1"]).to_owned(),
        Type::Float if odd => {
            random.one(&["nan", "inf", "-inf", "1e308", "-1e-308", "0", "-0"]).to_owned()
        }
        Type::Float => format!("{}.{}", (n % 401).cast_signed() - 200, n % 1000),
        Type::S32 if odd => random.one(&["-2147483648", "2147483647", "-1"]).to_owned(),
        Type::S64 if odd => random.one(&["-9223372036854775808", "9223372036854775807"]).to_owned(),
        Type::S32 | Type::S64 => ((n % 2001).cast_signed() - 1000).to_string(),
        Type::U32 if odd => "4294967295".to_owned(),
        Type::U64 if odd => "18446744073709551615".to_owned(),
        Type::U32 | Type::U64 | Type::Port => (n % 2000).to_string(),
    }
}

fn engine(path: &[&Path]) -> Engine {
    Engine::without_socket(options(path)).unwrap()
}

fn options(path: &[&Path]) -> Options {
    Options {
        hold: false,
        path: path.iter().map(|p| p.to_path_buf()).collect(),
        realtime: hal_tests::machine::realtime(),
        ..Options::simulated(Place::at("/nonexistent", "counted").unwrap(), ClockKind::Real)
    }
}

fn list(e: &mut Engine, kind: Kind) -> Reply {
    e.call(Request::List { kind, patterns: vec!["*".into()], ty: None }).unwrap()
}

fn functs(e: &mut Engine) -> Vec<FunctInfo> {
    match list(e, Kind::Functs) {
        Reply::Functs(list) => list,
        other => panic!("{other:?}"),
    }
}

/// Returns the items that a user may set.
fn settable(e: &mut Engine) -> Vec<ItemInfo> {
    let mut all = Vec::new();
    for kind in [Kind::Pins, Kind::Params] {
        let Reply::Items(list) = list(e, kind) else { panic!("no items") };
        all.extend(list);
    }
    let may = |i: &ItemInfo| {
        let open = matches!(i.direction, Direction::In | Direction::Io | Direction::Rw);
        open && i.signal.is_none() && i.value.ty() != Type::Port && !i.name.ends_with(".tmax")
    };
    all.retain(may);
    all
}

fn commands(e: &mut Engine) -> Vec<CommandInfo> {
    match list(e, Kind::Commands) {
        Reply::Commands(list) => list,
        other => panic!("{other:?}"),
    }
}

/// Sets everything that can be set, and sends every command, with arguments of every kind.
fn poke(e: &mut Engine, random: &mut Random, items: &[ItemInfo], commands: &[CommandInfo]) {
    for i in items {
        let value = value(random, i.value.ty());
        e.call(Request::Set { name: i.name.clone(), value }).unwrap();
    }
    for c in commands {
        let mut arg = |a: &ArgInfo| {
            let value = match a.ty.as_str() {
                "float" => value(random, Type::Float),
                "int" | "ints" => (random.word() % 4).to_string(),
                "bit" => value(random, Type::Bit),
                _ => text_argument(&a.name, random).to_owned(),
            };
            format!("{}={value}", a.name)
        };
        let args = c.args.iter().map(&mut arg).collect();
        // Most are refused, which does not affect the cycles.
        drop(e.call(Request::Command { name: c.name.clone(), args }));
    }
}

/// Waits until every thread runs. Allocations of a starting thread do not belong to a cycle.
fn begun(e: &mut Engine) {
    wait(e, "the first cycles", |e| match list(e, Kind::Threads) {
        Reply::Threads(all) => all.iter().all(|t| t.cycles > 5),
        other => panic!("{other:?}"),
    });
}

/// Runs everything loaded for `CYCLES` cycles. Returns the number of counted calls.
///
/// # Panics
/// A function fails.
fn counted(e: &mut Engine) -> u64 {
    let all: Vec<String> = functs(e).into_iter().map(|f| f.name).collect();
    for f in all.iter().filter(|f| *f != EDITED) {
        script(e, &format!("addf {f} fast"));
    }
    let there = says(e, "loadrt and2 count=4");
    assert!(there == "ok" || there.starts_with("and2: already exists"), "{there}");
    script(e, "newsig one bit\nstart");
    begun(e);
    let (items, commands) = (settable(e), commands(e));
    let mut random = Random::new(0x00fe_771e);
    let end = thread(e, "fast").cycles + CYCLES;
    counter::count(true);
    let mut rounds = 0;
    while thread(e, "fast").cycles < end || rounds < 100 {
        // The fastest thread applies changes to the wiring.
        script(
            e,
            &format!(
                "addf {EDITED} fast 1
                 linkps {EDITED}.in0 one
                 unlinkp {EDITED}.in0
                 delf {EDITED} fast"
            ),
        );
        poke(e, &mut random, &items, &commands);
        script(e, "idle 1");
        rounds += 1;
        let fault = status(e).fault;
        assert!(fault.is_none(), "round {rounds}: {fault:?}");
    }
    let calls = counter::counted();
    counter::count(false);
    calls
}

/// Runs every component on the path, in several engines, because some exclude each other.
fn everything() {
    let mut wanted: Vec<String> = Vec::new();
    for Offer { component, library, .. } in every::offers() {
        // An engine has only one kinematics component; these run when motion uses them.
        if library == "kinematics" {
            continue;
        }
        wanted.extend(every::ways(&component).iter().map(|w| format!("{component} {w}")));
    }
    wanted.sort_by_key(|w| every::order(w.split(' ').next().unwrap_or_default()));
    while !wanted.is_empty() {
        let mut e = engine(&[programs()]);
        // The cycle takes about 60 us unoptimized; with a shorter period, no slower thread would ever run.
        script(&mut e, "loadrt threads name1=fast period1=100000");
        let mut refused = Vec::new();
        let before = wanted.len();
        wanted.retain(|w| {
            let own = w.split_whitespace().next() == Some("threads");
            let said = if own { "ok".to_owned() } else { says(&mut e, &format!("loadrt {w}")) };
            if said != "ok" {
                refused.push(format!("{w}: {said}"));
            }
            said != "ok"
        });
        assert!(wanted.len() < before, "add to `every` what these need: {refused:#?}");
        let calls = counted(&mut e);
        assert_eq!(calls, 0, "calls of the allocator in cycles");
        e.close();
    }
}

/// Runs a machine that is homed, jogged and moved along a line, with its steps generated and
/// sampled.
fn moving() {
    let mut e = engine(&[programs()]);
    script(
        &mut e,
        "loadrt trivkins
         loadrt motmod base_period_nsec=50000 servo_period_nsec=500000 num_joints=3
         loadrt stepgen step_type=0,0,2
         loadrt sampler depth=10 cfg=fff
         addf stepgen.make-pulses base-thread
         addf stepgen.capture-position servo-thread
         addf motion-command-handler servo-thread
         addf motion-controller servo-thread
         addf stepgen.update-freq servo-thread
         addf sampler.0 servo-thread",
    );
    for j in 0..3 {
        script(
            &mut e,
            &format!(
                "net cmd-{j} joint.{j}.motor-pos-cmd stepgen.{j}.position-cmd sampler.0.pin.{j}
                 net fb-{j} stepgen.{j}.position-fb joint.{j}.motor-pos-fb
                 net on-{j} joint.{j}.amp-enable-out stepgen.{j}.enable
                 setp stepgen.{j}.position-scale 40
                 motion.configure joint={j} max-velocity=50 max-acceleration=2000 ferror=100"
            ),
        );
    }
    script(&mut e, "motion.configure max-velocity=50 max-acceleration=2000\nstart");
    begun(&mut e);
    counter::count(true);
    for line in [
        "motion.enable",
        "motion.home joint=all",
        "motion.jog joint=0 velocity=5",
        "motion.jog-stop joint=0",
        "motion.move x=3 y=2 z=-1 velocity=10",
        "motion.move x=0 y=0 z=0 velocity=10",
        "motion.abort",
        "motion.disable",
    ] {
        let said = says(&mut e, line);
        assert!(said.is_empty(), "{line}: {said}");
        let is = |e: &mut Engine, item: &str, value| says(e, &format!("getp {item}")) == value;
        match line {
            "motion.home joint=all" => wait(&mut e, "homing", |e| {
                (0..3).all(|j| is(e, &format!("joint.{j}.homed"), "TRUE"))
            }),
            "motion.jog joint=0 velocity=5" => {
                wait(&mut e, "steps", |e| !is(e, "stepgen.0.counts", "0"));
            }
            _ => {}
        }
        let end = thread(&mut e, "base-thread").cycles + CYCLES / 4;
        wait(&mut e, "cycles", |e| thread(e, "base-thread").cycles > end);
    }
    assert_eq!(counter::counted(), 0, "calls of the allocator in cycles");
    counter::count(false);
    e.close();
}

/// Runs every kind of kinematics as motion uses it: from joints to poses and back in each cycle.
fn kinematics() {
    for Offer { component, library, .. } in every::offers() {
        if library != "kinematics" {
            continue;
        }
        let mut e = engine(&[programs()]);
        script(
            &mut e,
            &format!(
                "loadrt {component}
                 loadrt motmod servo_period_nsec=100000 num_joints=9
                 addf motion-command-handler servo-thread
                 addf motion-controller servo-thread"
            ),
        );
        for j in 0..9 {
            script(
                &mut e,
                &format!(
                    "net loop-{j} joint.{j}.motor-pos-cmd joint.{j}.motor-pos-fb
                     motion.configure joint={j} max-velocity=50 max-acceleration=2000 ferror=100"
                ),
            );
        }
        script(&mut e, "motion.configure max-velocity=50 max-acceleration=2000\nstart");
        begun(&mut e);
        counter::count(true);
        for line in [
            "motion.enable",
            "motion.home joint=all",
            "motion.jog joint=0 velocity=5",
            "motion.jog-stop joint=0",
            "motion.move x=0.3 velocity=10",
            "motion.move y=0.5 velocity=10",
            "motion.abort",
        ] {
            says(&mut e, line);
            let end = thread(&mut e, "servo-thread").cycles + 100;
            wait(&mut e, "cycles", |e| thread(e, "servo-thread").cycles > end);
        }
        assert_eq!(counter::counted(), 0, "{component}: calls of the allocator in cycles");
        counter::count(false);
        e.close();
    }
}

/// Runs a machine as an INI file sets it up: stopped by each side of its interlock and by the step
/// guard, with its spindle oriented.
fn stopping() {
    let options = Options { interlock: true, ..options(&[programs()]) };
    let mut e = Engine::without_socket(options).unwrap();
    script(
        &mut e,
        "loadrt iocontrol interlock=1
         loadrt trivkins coordinates=x kinstype=b
         loadrt motmod servo_period_nsec=100000 num_joints=2 num_extrajoints=1
         loadrt orient
         loadrt integ names=encoder
         addf encoder servo-thread
         addf orient.0 servo-thread
         addf motion-command-handler servo-thread
         addf motion-controller servo-thread
         net command-0 joint.0.motor-pos-cmd joint.0.motor-pos-fb
         net command-1 joint.1.motor-pos-cmd joint.1.motor-pos-fb
         net turns encoder.out orient.0.position
         net asked spindle.0.orient orient.0.enable
         net angle spindle.0.orient-angle orient.0.angle
         net oriented orient.0.is-oriented spindle.0.is-oriented
         motion.configure joint=0 max-velocity=50 max-acceleration=2000 ferror=100
         motion.configure joint=1 max-velocity=50 max-acceleration=2000 ferror=100
         start",
    );
    begun(&mut e);
    let is_on = |e: &mut Engine| bit(e, "motion.motion-enabled");
    let switch_on = |e: &mut Engine| {
        script(e, "setp iocontrol.0.emc-enable-in 1\niocontrol.estop-reset");
        // The background task of iocontrol executes the reset.
        wait(e, "it is on", |e| {
            drop(says(e, "motion.enable"));
            cycles(e, "servo-thread", 10);
            is_on(e)
        });
        script(e, "motion.jog joint=0 velocity=5");
        cycles(e, "servo-thread", 100);
        assert!(!bit(e, "joint.0.in-position"), "it does not move");
    };
    counter::count(true);
    // Refused, because the machine is in e-stop.
    drop(says(&mut e, "motion.enable"));
    cycles(&mut e, "servo-thread", 10);
    assert!(!is_on(&mut e), "on in e-stop");
    for stop in
        ["iocontrol.estop", "setp iocontrol.0.emc-enable-in 0", "setp joint.1.posthome-cmd 500"]
    {
        switch_on(&mut e);
        if stop.contains("posthome") {
            script(&mut e, "motion.home joint=1");
            wait(&mut e, "joint 1 is homed", |e| bit(e, "joint.1.homed"));
        }
        script(&mut e, stop);
        wait(&mut e, stop, |e| !is_on(e));
        assert_eq!(bit(&mut e, "joint.1.error"), stop.contains("posthome"), "{stop}");
    }
    script(&mut e, "setp joint.1.posthome-cmd 0");
    switch_on(&mut e);
    script(&mut e, "setp encoder.in 5\nmotion.spindle-orient angle=90");
    cycles(&mut e, "servo-thread", 2000);
    assert!(!bit(&mut e, "spindle.0.locked"), "locked while it turns");
    script(&mut e, "setp encoder.in 0\nsetp encoder.reset 1\nmotion.spindle-orient angle=0");
    wait(&mut e, "the spindle is locked", |e| bit(e, "spindle.0.locked"));
    assert_eq!(counter::counted(), 0, "calls of the allocator in cycles");
    counter::count(false);
    e.close();
}

/// Sends messages in realtime: combined ones, and more than the ring holds.
fn flooding() {
    let mut e = engine(&[plugins(), programs()]);
    script(&mut e, "loadrt threads name1=t period1=1000000\nloadrt chatty\naddf chatty t\nstart");
    begun(&mut e);
    for (times, said) in [(1, " more)"), (5000, " messages were lost")] {
        drop(e.take_messages());
        counter::count(true);
        script(&mut e, &format!("setp chatty.times {times}"));
        let mut lines = Vec::new();
        wait(&mut e, said, |e| {
            lines.extend(e.take_messages());
            lines.iter().any(|line| line.contains(said))
        });
        let calls = counter::counted();
        counter::count(false);
        assert_eq!(calls, 0, "{times} in each cycle: calls of the allocator");
    }
    e.close();
}

/// Runs a plugin that allocates on request, to prove the counter.
fn planted() {
    let mut e = engine(&[plugins(), programs()]);
    script(
        &mut e,
        "loadrt threads name1=fast period1=50000\nloadrt alloc\naddf alloc.0 fast\nstart",
    );
    begun(&mut e);
    for (go, at_least) in [("0", 0), ("1", 100), ("0", 0)] {
        script(&mut e, &format!("setp alloc.0.go {go}\nidle 5"));
        counter::count(true);
        let end = thread(&mut e, "fast").cycles + 100;
        wait(&mut e, "cycles", |e| thread(e, "fast").cycles > end);
        let calls = counter::counted();
        counter::count(false);
        assert!(calls >= at_least && (at_least > 0 || calls == 0), "{go}: {calls} calls");
    }
}

/// Starts and ends samples, with full rings and with rings that are read, records, and adds and
/// removes watched items.
fn sampled() {
    let mut e = engine(&[programs()]);
    script(
        &mut e,
        "loadrt threads name1=fast period1=50000 name2=slow period2=1000000
         loadrt and2 count=50
         addf and2.0 fast
         start",
    );
    begun(&mut e);
    let spec = |thread: &str, depth| SampleSpec {
        thread: Some(thread.to_owned()),
        depth,
        names: vec!["and2.*".to_owned(), "fast.threadbeat".to_owned()],
        ..SampleSpec::default()
    };
    let full = e.sample(&spec("fast", 10)).unwrap();
    let mut read = e.sample(&spec("slow", 1000)).unwrap();
    counter::count(true);
    script(&mut e, "record /dev/null");
    let mut record = Vec::new();
    for round in 0..50 {
        script(&mut e, "loadrt or2\nnewsig s bit\nlinkps or2.0.in0 s\naddf or2.0 fast");
        let mut names = spec("fast", 100);
        names.names.extend(["or2.*".to_owned(), "s".to_owned()]);
        let other = e.sample(&SampleSpec { every: 2, ..names }).unwrap();
        wait(&mut e, "samples", |_| other.waiting() > 3);
        script(&mut e, if round % 2 == 0 { "unloadrt or2\ndelsig s" } else { "delsig s" });
        if round % 2 == 1 {
            e.call(Request::EndSample { id: other.info().id }).unwrap();
            script(&mut e, "unloadrt or2");
        }
        while read.take_bits(&mut record).is_some() {}
    }
    let calls = counter::counted();
    counter::count(false);
    assert_eq!(calls, 0, "calls of the allocator in cycles");
    assert!(full.lost_at_end() > 0 && full.waiting() == 10);
    e.close();
}

/// Runs one of these functions in a process with the counter, with `SCHED_FIFO` and without.
fn in_a_child(what: &str) {
    for fifo in [true, false] {
        let mut child = Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", "child", "--ignored", "--nocapture"]);
        child.env(CHILD, what).env("LD_PRELOAD", interpose());
        // Built before calls are counted.
        child.env("HAL_TEST_PROGRAMS", programs());
        plugins();
        if !fifo {
            child.env("HAL_NO_FIFO", "1");
        }
        let output = child.output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        let complained = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "FIFO {fifo}:\n{said}\n{complained}");
    }
}

#[test]
#[ignore = "run by the others, each in a process with the counter: cargo test -p hal-tests --test realtime"]
fn child() {
    match std::env::var(CHILD).unwrap().as_str() {
        "everything" => everything(),
        "flooding" => flooding(),
        "kinematics" => kinematics(),
        "moving" => moving(),
        "planted" => planted(),
        "sampled" => sampled(),
        "stopping" => stopping(),
        other => panic!("{other}"),
    }
}

#[test]
fn ten_thousand_cycles_of_every_component_allocate_nothing() {
    in_a_child("everything");
}

#[test]
fn a_machine_that_moves_allocates_nothing() {
    in_a_child("moving");
}

#[test]
fn what_stops_a_machine_from_an_ini_file_allocates_nothing() {
    in_a_child("stopping");
}

#[test]
fn messages_that_are_joined_or_lost_allocate_nothing() {
    in_a_child("flooding");
}

#[test]
fn kinematics_that_are_asked_allocate_nothing() {
    in_a_child("kinematics");
}

#[test]
fn sampling_and_recording_allocate_nothing() {
    in_a_child("sampled");
}

#[test]
fn a_planted_plugin_that_allocates_is_caught() {
    in_a_child("planted");
}
