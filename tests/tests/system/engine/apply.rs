//! Files that are applied to running threads: completely at one boundary, or not at all.

use hal_engine::ClockKind;
use hal_protocol::{Link, Reply, Request};
use hal_tests::{
    machine::{
        Machine, Served, applied, bit, count, cycles, edits, says, seen, status, thread, wait,
        without_fifo,
    },
    scratch::Scratch,
};

/// Two threads with a reader each. The test links the pins that the readers share, sets them, and links them to one
/// signal or another.
const READERS: &str = "loadrt swap count=2
    net every swap.0.a swap.1.a
    newsig hold-0 u32
    newsig hold-1 u32
    net hold-1 swap.0.c swap.1.c
    addf swap.0.one fast
    addf swap.0.look fast
    addf swap.1.one slow
    addf swap.1.look slow
    start";

/// Returns the change to value `n`: twelve lines that belong together.
fn change(n: u32) -> String {
    let (new, old) = if n % 2 == 1 { ("one", "two") } else { ("two", "one") };
    let hold = n % 2;
    format!(
        "sets every {n}
        setp swap.0.b {n}
        delf swap.0.{old} fast
        unlinkp swap.0.c
        addf swap.1.{new} slow 1
        setp swap.1.b {n}
        unlinkp swap.1.c
        net hold-{hold} swap.0.c swap.1.c
        delf swap.1.{old} slow
        sets hold-{hold} {n}
        addf swap.0.{new} fast 1"
    )
}

/// Returns lines that load and unload components with some of the changes.
fn company(n: u32) -> &'static str {
    match n % 50 {
        7 => {
            "\nloadrt or2 count=3\naddf or2.1 fast\nnet more or2.1.out or2.2.in0\nsetp or2.1.in0 1"
        }
        9 => "\nunloadrt or2\ndelsig more",
        _ => "",
    }
}

#[test]
fn ten_thousand_changes_on_the_virtual_clock() {
    const CHANGES: u32 = 10_000;
    let mut m = Machine::new(ClockKind::Virtual);
    m.script("loadrt threads name1=fast period1=1000000 name2=slow period2=2000000");
    m.script(READERS);
    for n in 2..CHANGES + 2 {
        let lines = change(n) + company(n);
        assert_eq!(applied(&mut m, &lines), "ok", "{lines}");
        m.script("run 1000000");
    }
    for reader in ["swap.0", "swap.1"] {
        assert_eq!(count(&mut m, &format!("{reader}.torn")), 0, "{reader}");
    }
    let changes = u64::from(CHANGES);
    assert_eq!(count(&mut m, "swap.0.changes"), changes);
    assert_eq!(count(&mut m, "swap.1.changes"), changes / 2);
    assert_eq!(count(&mut m, "fast.threadbeat"), changes, "no cycle is lost");
    assert_eq!(count(&mut m, "slow.threadbeat"), changes / 2, "nor one of the other thread");
    let s = status(&mut m);
    assert!(s.running && s.fault.is_none());
    assert_eq!((s.signals.active, s.components.active), (3, 4));
}

#[test]
fn the_readers_would_see_half_a_change() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script("loadrt threads name1=fast period1=1000000 name2=slow period2=1000000");
    m.script(READERS);
    let whole = change(2);
    let lines: Vec<&str> = whole.lines().map(str::trim).collect();
    for n in 1..lines.len() {
        // One part before a cycle, the other after it.
        let (first, rest) = lines.split_at(n);
        assert_eq!(applied(&mut m, &first.join("\n")), "ok");
        let torn = |m: &mut Machine| count(m, "swap.0.torn") + count(m, "swap.1.torn");
        let before = torn(&mut m);
        m.script("run 1000000");
        assert!(torn(&mut m) > before, "{first:?} alone");
        assert_eq!(applied(&mut m, &rest.join("\n")), "ok");
        assert_eq!(applied(&mut m, &change(1)), "ok");
        let before = torn(&mut m);
        m.script("run 1000000");
        assert_eq!(torn(&mut m), before, "after {n} lines and the rest");
    }
}

#[test]
fn changes_on_the_real_clock() {
    let mut m = Machine::new(ClockKind::Real);
    m.script("loadrt threads name1=fast period1=250000 name2=slow period2=1000000");
    m.script(READERS);
    cycles(&mut m, "slow", 2);
    for n in 2..102 {
        let lines = change(n) + company(n);
        assert_eq!(applied(&mut m, &lines), "ok", "{lines}");
        if n % 4 == 0 {
            cycles(&mut m, "slow", 1);
        }
    }
    cycles(&mut m, "slow", 2);
    for reader in ["swap.0", "swap.1"] {
        assert_eq!(count(&mut m, &format!("{reader}.torn")), 0, "{reader}");
    }
    assert!(count(&mut m, "swap.1.changes") >= 25);
    assert_eq!(thread(&mut m, "fast").functs, ["swap.0.one", "swap.0.look"]);
}

/// Lines of every kind that are compatible with each other on the machine of [`faulty`].
const GOOD: &str = "loadrt or2 count=2
    net b or2.0.out and2.1.in1
    loadrt doomed
    addf doomed.copy doomed-thread
    initf or2.1 doomed-thread
    addf or2.0 fast 1
    newsig spare float
    setp or2.0.in0 1
    setp doomed.param 7
    unlinkp and2.1.in0
    setp and2.1.in0 1
    net spare doomed.in
    sets spare 2.5
    alias pin and2.1.in0 gate
    alias pin and2.2.in0 other-name
    unalias pin and2.2.in1
    delf tap.0 fast
    unloadrt tap
    net c and2.2.in0 or2.1.out
    delsig old
    newsig old bit
    unloadrt or2
    delsig b";

/// Lines that fail at every position among them.
const BAD: &[&str] = &[
    "loadrt nothing-of-this-name",
    "loadrt and2",
    "loadrt xor2 colour=blue",
    "loadrt lazy names=x",
    "loadrt doomed",
    "unloadrt nothing",
    "unloadrt __fast",
    "newsig a bit",
    "newsig this-name-is-longer-than-any-name-of-a-signal-may-be-in-this-world float",
    "delsig nothing",
    "net nothing",
    "net x nothing",
    "net x and2.0.in1 and2.0.out",
    "net a and2.2.out",
    "net kind and2.0.in1",
    "linkps nothing a",
    "linkps and2.2.out kind",
    "linkps and2.0.out a2",
    "unlinkp nothing",
    "setp nothing 1",
    "setp and2.0.in1 maybe",
    "setp and2.0.out 1",
    "sets nothing 1",
    "sets a 1",
    "sets kind -1",
    "sets kind 1.5.2",
    "addf nothing fast",
    "addf and2.0 nothing",
    "addf and2.0 slow",
    "addf and2.2 fast 0",
    "addf and2.2 fast 99",
    "initf nothing fast",
    "initf and2.2 fast",
    "delf nothing fast",
    "delf and2.2 fast",
    "delf and2.0 slow",
    "alias pin nothing y",
    "alias pin and2.0.in0 and2.0.in1",
    "alias param and2.0.in0 y",
    "unalias pin nothing",
    "status",
];

/// Failures of a component during its load.
const DOOMED: &[&str] = &[
    "panic",
    "error",
    "open",
    "open-panic",
    "pin",
    "param",
    "funct",
    "thread",
    "command",
    "stream",
    "long",
];

/// Returns a running machine with something of everything.
fn faulty() -> Machine {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(
        "loadrt threads name1=fast period1=500000 name2=slow period2=1000000
         loadrt and2 count=3
         loadrt tap
         loadrt witness
         addf and2.0 fast
         addf tap.0 fast
         addf and2.1 slow
         net a and2.0.out and2.1.in0 tap.0.on
         net old and2.2.in1
         newsig kind u32
         net kind witness.0.a
         alias pin and2.2.in1 known
         alias pin and2.2.in0 again
         setp and2.0.in0 1
         sets kind 5
         start
         run 4000000",
    );
    m
}

fn trimmed(lines: &str) -> Vec<String> {
    lines.lines().map(|l| l.trim().to_owned()).collect()
}

#[test]
fn a_line_that_fails_anywhere_leaves_nothing_behind() {
    let mut m = faulty();
    // The first run loads the libraries.
    let doomed = format!("{GOOD}\nloadrt doomed by=error");
    assert_eq!(applied(&mut m, &doomed), "24: doomed: already exists");
    let before = seen(&mut m);
    let good = trimmed(GOOD);
    let bad = BAD.iter().map(|line| (*line).to_owned());
    for (which, bad) in bad.enumerate() {
        for at in 0..=good.len() {
            if bad == "loadrt doomed" && at < 3 {
                continue;
            }
            // Every position for the first ones, then some.
            if which > 6 && (at + which) % 4 != 0 && at != good.len() {
                continue;
            }
            let mut lines = good.clone();
            lines.insert(at, bad.clone());
            if bad == "loadrt doomed" {
                lines.truncate(at + 1);
            }
            let said = match m.call(edits(&lines.join("\n"), false)) {
                Ok(Reply::Refused { edit, failure }) => (edit as usize, failure.text),
                other => panic!("{bad} at {at}: {other:?}"),
            };
            assert_eq!(said.0, at, "{bad} at {at}: {}", said.1);
            assert_eq!(seen(&mut m), before, "{bad} at {at}");
        }
    }
    m.engine.take_messages();
    for how in DOOMED {
        let rest = trimmed(GOOD).split_off(3).join("\n");
        for before_it in
            ["loadrt or2 count=2", "loadrt or2 count=2\nsetp or2.0.in0 1\naddf or2.0 fast"]
        {
            let lines = format!("{before_it}\nloadrt doomed by={how}\n{rest}");
            let at = before_it.lines().count() + 1;
            let said = applied(&mut m, &lines);
            assert!(
                said.starts_with(&format!("{at}: doomed: "))
                    || said.starts_with(&format!("{at}: ")),
                "{how}: {said}"
            );
            assert_eq!(seen(&mut m), before, "{how}: {said}");
        }
    }
    m.script("run 4000000");
    assert_eq!(count(&mut m, "fast.threadbeat"), 16, "no cycle is lost");
    // Without a bad line, everything takes effect.
    let lines = GOOD.to_owned();
    assert!(matches!(m.call(edits(&lines, true)), Ok(Reply::Applied { .. })));
    m.script("run 500000");
    assert_eq!(count(&mut m, "fast.threadbeat"), 17);
    assert_eq!(applied(&mut m, &lines), "ok");
    m.script("run 4000000");
    assert_eq!(says(&mut m, "getp doomed.param"), "7");
    assert_eq!(says(&mut m, "getp doomed.out"), "2.5", "the new thread runs");
    assert_eq!(says(&mut m, "getp gate"), "TRUE");
}

#[test]
fn looking_whether_it_could_be_opens_nothing() {
    let mut m = faulty();
    m.script("loadrt doomed\nunloadrt doomed");
    let before = seen(&mut m);
    let dry = m.call(edits("loadrt doomed by=open\naddf doomed.copy doomed-thread", true));
    assert_eq!(dry, Ok(Reply::Applied { stores: 0, lists: 1 }));
    assert_eq!(seen(&mut m), before);
    let said = applied(&mut m, "setp and2.0.in0 0\nloadrt doomed by=open");
    assert_eq!(said, "2: doomed: the device is not there");
    assert_eq!(seen(&mut m), before);
    // Messages of a component during a transaction arrive, also if the transaction is reverted.
    m.script("loadrt chatty\nunloadrt chatty");
    m.engine.take_messages();
    assert_eq!(
        applied(&mut m, "loadrt chatty\nsetp nothing 1"),
        "2: parameter or pin 'nothing': not found"
    );
    let said = m.engine.take_messages();
    let all = ["chatty: being created", "chatty: being opened, 1 of 2.5", "chatty: being stopped"];
    assert_eq!(said, all);
}

#[test]
fn threads_are_started_with_everything_in_place() {
    let mut m = Machine::new(ClockKind::Virtual);
    let whole = "loadrt threads name1=fast period1=1000000
        loadrt witness
        addf witness.0 fast
        setp witness.0.a 5
        setp witness.0.b 5
        start
        loadrt swap
        initf swap.0.two fast
        addf swap.0.one fast
        addf swap.0.look fast";
    assert_eq!(
        applied(&mut m, &format!("{whole}\nsetp nothing 1")),
        "11: parameter or pin 'nothing': not found"
    );
    assert!(!status(&mut m).running && status(&mut m).components.active == 0);
    assert_eq!(applied(&mut m, whole), "ok");
    m.script("run 3000000");
    assert_eq!(count(&mut m, "witness.0.cycles"), 2, "the first cycle is that of initf");
    assert_eq!((count(&mut m, "witness.0.torn"), count(&mut m, "witness.0.changes")), (0, 1));
    assert_eq!(applied(&mut m, "start\nunloadrt all"), "ok");
    assert_eq!(status(&mut m).components.active, 0);
}

#[test]
fn new_threads_join_threads_that_run_or_none() {
    let mut m = Machine::new(ClockKind::Real);
    // Started, with nothing to run yet.
    m.script("start");
    let whole = "loadrt threads name1=fast period1=1000000
        loadrt swap
        addf swap.0.one fast
        addf swap.0.look fast";
    assert_eq!(applied(&mut m, whole), "ok");
    cycles(&mut m, "fast", 3);
    let more = "loadrt doomed
        addf doomed.copy doomed-thread
        setp doomed.in 1.5
        setp swap.0.a 2
        setp swap.0.b 2
        setp swap.0.c 2
        delf swap.0.one fast
        addf swap.0.two fast 1";
    let threads = status(&mut m).threads;
    assert!(applied(&mut m, &format!("{more}\nsetp nothing 1")).starts_with("9: "));
    assert_eq!(status(&mut m).threads, threads);
    assert_eq!(applied(&mut m, more), "ok");
    cycles(&mut m, "doomed-thread", 3);
    assert_eq!(says(&mut m, "getp doomed.out"), "1.5");
    // A function may move from a thread that ends to one that stays.
    let away = "unloadrt doomed\nloadrt and2\naddf and2.0 fast";
    m.script("loadrt or2\naddf or2.0 doomed-thread");
    assert_eq!(applied(&mut m, &format!("{away}\naddf or2.0 fast")), "ok");
    assert_eq!(thread(&mut m, "fast").functs, ["swap.0.two", "swap.0.look", "and2.0", "or2.0"]);
    cycles(&mut m, "fast", 3);
    assert_eq!((count(&mut m, "swap.0.torn"), count(&mut m, "swap.0.changes")), (0, 1));
}

#[test]
fn a_function_that_failed_is_replaced_and_threads_go_on() {
    let mut m = Machine::new(ClockKind::Virtual);
    m.script(
        "loadrt threads name1=fast period1=1000000
         loadrt boom
         addf boom.0 fast
         start
         setp boom.0.go 1
         run 2000000",
    );
    assert!(status(&mut m).fault.is_some());
    let before = seen(&mut m);
    let said = applied(&mut m, "start");
    assert_eq!(said, "1: function 'boom.0' has failed: threads stay stopped");
    let said = applied(&mut m, "unloadrt boom\nstart\nsetp nothing 1");
    assert_eq!(said, "3: parameter or pin 'nothing': not found");
    assert_eq!(seen(&mut m), before);
    let lines = "unloadrt boom\nloadrt witness\naddf witness.0 fast\nstart";
    assert_eq!(applied(&mut m, lines), "ok");
    m.script("run 2000000");
    assert!(status(&mut m).fault.is_none());
    assert_eq!(count(&mut m, "witness.0.cycles"), 2);
}

#[test]
fn a_stuck_thread_lets_nothing_of_it_happen() {
    let mut m = Machine::new(ClockKind::Real);
    m.script(
        "loadrt threads name1=fast period1=1000000 name2=slow period2=1000000
         loadrt stuck
         loadrt and2 count=2
         loadrt doomed
         unloadrt doomed
         addf and2.0 fast
         addf stuck.0 slow
         net a and2.0.in0
         start",
    );
    cycles(&mut m, "slow", 1);
    m.script("setp stuck.0.hold 1");
    wait(&mut m, "it is stuck", |m| bit(m, "stuck.0.inside"));
    let usage = |m: &mut Machine| {
        let s = status(m);
        (s.memory, s.pins, s.signals, s.components, s.functs, s.threads, s.aliases)
    };
    let before = usage(&mut m);
    let lines = "loadrt or2
        net b or2.0.out and2.1.in0
        addf or2.0 fast
        setp and2.1.in1 1
        setp and2.0.in1 1
        alias pin and2.1.in1 gate
        loadrt doomed
        addf doomed.copy doomed-thread
        unloadrt stuck
        unlinkp and2.0.in0";
    let stuck = "thread 'slow' is stuck in its cycle, in function 'stuck.0'";
    assert_eq!(applied(&mut m, lines), stuck);
    assert_eq!(usage(&mut m), before);
    assert_eq!(thread(&mut m, "fast").functs, ["and2.0"]);
    assert!(!bit(&mut m, "and2.1.in1") && !bit(&mut m, "and2.0.in1"));
    m.script("setp stuck.0.hold 0");
    wait(&mut m, "it comes back", |m| !bit(m, "stuck.0.inside"));
    assert_eq!(applied(&mut m, lines), "ok");
    wait(&mut m, "the new thread runs", |m| count(m, "doomed-thread.threadbeat") > 2);
    assert!(bit(&mut m, "gate"));
    assert_eq!(thread(&mut m, "slow").functs, Vec::<String>::new());
}

#[test]
fn what_no_thread_sees_is_not_counted() {
    let mut m = Machine::new(ClockKind::Real);
    m.script("loadrt threads\nloadrt and2 count=300\naddf and2.0 thread1\nstart");
    let lines = |what: &str| {
        let line = |i: usize| format!("\n{}", what.replace('#', &i.to_string()));
        (0..300).map(line).collect::<String>()
    };
    let before = status(&mut m).pins;
    let many = "this change takes 300 stores at once; at most 256 are made while threads run";
    assert_eq!(applied(&mut m, &format!("loadrt or2{}", lines("setp and2.#.in0 1"))), many);
    assert_eq!(status(&mut m).pins, before);
    // New pins are set, linked to each other and to existing signals; then an old pin joins.
    let new = format!(
        "loadrt or2 count=300{}{}\nnet line or2.0.out and2.0.in0",
        lines("setp or2.#.in0 1"),
        lines("net line or2.#.in1")
    );
    assert_eq!(m.call(edits(&new, true)), Ok(Reply::Applied { stores: 1, lists: 0 }));
    assert_eq!(applied(&mut m, &new), "ok");
    assert!(bit(&mut m, "or2.299.in0"));
    // Stores that follow a store visible to threads stay after it.
    let order = "loadrt xor2\nnet line xor2.0.in0\nunlinkp xor2.0.in0\nsetp xor2.0.in0 1\nnet new xor2.0.in0\nsets new 0\nsets new 1";
    assert_eq!(applied(&mut m, order), "ok");
    assert!(bit(&mut m, "xor2.0.in0"));
    m.script("stop\nunlinkp and2.0.in0");
    assert_eq!(applied(&mut m, lines("setp and2.#.in0 1").trim()), "ok");
    assert!(bit(&mut m, "and2.299.in0"));
}

#[test]
fn a_file_of_ten_thousand_lines_fits_and_a_longer_one_is_refused() {
    let scratch = Scratch::new("apply");
    let lines = "loadrt threads\nloadrt and2 count=10";
    let served = Served::on(ClockKind::Virtual, &scratch, "apply", lines);
    let mut client = served.client();
    let file = |n: usize| {
        let line = |i: usize| format!("setp and2.{}.in{} {}\n", i % 10, i % 2, i % 3 % 2);
        (0..n).map(line).collect::<String>().trim_end().to_owned()
    };
    assert_eq!(applied(&mut client, &file(10_000)), "ok");
    let refused = applied(&mut client, &file(100_000));
    assert!(refused.ends_with("bytes at once, 4194304 are read"), "{refused}");
    assert_eq!(
        applied(&mut client, &format!("{}\nsetp nothing 1", file(10_000))),
        "10001: parameter or pin 'nothing': not found"
    );
    // An engine refuses nested requests and requests that are not changes.
    let nested = Request::Apply {
        files: Vec::new(),
        edits: vec![hal_protocol::Edit { file: 9, line: 9, request: edits("start", false) }],
        dry: false,
    };
    match client.call(nested) {
        Ok(Reply::Refused { edit: 0, failure }) => {
            assert_eq!(failure.text, "this does not change the graph");
        }
        other => panic!("{other:?}"),
    }
    served.end();
}

#[test]
fn all_of_this_on_one_thread_of_the_system() {
    without_fifo(module_path!(), "all_of_this_on_one_thread_of_the_system");
}
